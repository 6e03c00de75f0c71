// x^{−(n+1)} θₙ(sx)/θₙ(s) by the ratios of θ, as in `clangor_core::math::radial`.
// One invocation for each mode and place.

@group(0) @binding(0) var<storage, read> sizes: Sizes;
@group(0) @binding(1) var<storage, read> modes: array<Mode>;
@group(0) @binding(2) var<storage, read> places: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> waves: array<vec2<f32>>;

fn inverse(a: vec2<f32>) -> vec2<f32> {
    return vec2(a.x, -a.y) / dot(a, a);
}

@compute @workgroup_size(GROUP, 1, 1)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= sizes.modes {
        return;
    }
    let mode = modes[id.x];
    let x = places[id.y].w;
    let start = id.y * sizes.waves + mode.first_wave;
    let kappa = mode.wavenumber;
    var wave = vec2(1.0 / x, 0.0);
    waves[start] = wave;
    var there = vec2(1.0, kappa * x);
    var here = vec2(1.0, kappa);
    for (var n = 1u; n <= mode.order; n++) {
        if n > 1u {
            let odd = vec2(f32(2u * n - 1u), 0.0);
            there = odd - kappa * kappa * x * x * inverse(there);
            here = odd - kappa * kappa * inverse(here);
        }
        wave = product(wave, product(there, inverse(here))) / x;
        waves[start + n] = wave;
    }
}
