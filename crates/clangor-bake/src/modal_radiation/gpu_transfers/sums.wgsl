// Σ_n waves Σ_m c Y. One group for each mode and place; its invocations take coefficients in turn.

@group(0) @binding(0) var<storage, read> sizes: Sizes;
@group(0) @binding(1) var<storage, read> modes: array<Mode>;
@group(0) @binding(2) var<storage, read> coefficients: array<vec2<f32>>;
@group(0) @binding(3) var<storage, read> harmonics: array<f32>;
@group(0) @binding(4) var<storage, read> waves: array<vec2<f32>>;
@group(0) @binding(5) var<storage, read_write> sums: array<vec2<f32>>;

var<workgroup> parts: array<vec2<f32>, GROUP>;

@compute @workgroup_size(GROUP, 1, 1)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) own: u32) {
    let mode = modes[group.x];
    let of_place = group.y * (sizes.order + 1u) * (sizes.order + 1u);
    let first_wave = group.y * sizes.waves + mode.first_wave;
    var sum = vec2(0.0, 0.0);
    var n = 0u;
    for (var i = own; i < (mode.order + 1u) * (mode.order + 1u); i += GROUP) {
        while (n + 1u) * (n + 1u) <= i {
            n++;
        }
        let c = coefficients[mode.first_coefficient + i];
        sum += product(c, waves[first_wave + n]) * harmonics[of_place + i];
    }
    parts[own] = sum;
    workgroupBarrier();
    for (var half = GROUP / 2u; half > 0u; half /= 2u) {
        if own < half {
            parts[own] += parts[own + half];
        }
        workgroupBarrier();
    }
    if own == 0u {
        sums[group.y * sizes.modes + group.x] = parts[0];
    }
}
