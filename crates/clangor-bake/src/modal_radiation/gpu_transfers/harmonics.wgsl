// Real spherical harmonics, as in `clangor_core::math::spherical_harmonics`.
// One invocation for each m ≥ 0 and place.

@group(0) @binding(0) var<storage, read> sizes: Sizes;
@group(0) @binding(1) var<storage, read> places: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read_write> harmonics: array<f32>;

@compute @workgroup_size(GROUP, 1, 1)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let m = id.x;
    if m > sizes.order {
        return;
    }
    let direction = places[id.y].xyz;
    let start = id.y * (sizes.order + 1u) * (sizes.order + 1u);
    // Y_mm: cosine and sine part together.
    var sectoral = vec2(0.28209479177387814, 0.0);
    for (var k = 1u; k <= m; k++) {
        let size = sqrt(f32(2u * k + 1u) / f32(2u * k));
        sectoral = size * product(sectoral, direction.xy);
    }
    if m > 0u {
        sectoral *= 1.4142135623730951;
    }
    let mm = f32(m * m);
    var before = vec2(0.0, 0.0);
    var here = sectoral;
    for (var n = m; n <= sizes.order; n++) {
        let at = start + n * n + n;
        harmonics[at + m] = here.x;
        if m > 0u {
            harmonics[at - m] = here.y;
        }
        let next = f32(n + 1u);
        let below = next * next - mm;
        let a = sqrt((4.0 * next * next - 1.0) / below);
        var b = 0.0;
        if n > m {
            let n_now = f32(n);
            b = sqrt((2.0 * next + 1.0) * (n_now * n_now - mm) / ((2.0 * next - 3.0) * below));
        }
        let after = a * direction.z * here - b * before;
        before = here;
        here = after;
    }
}
