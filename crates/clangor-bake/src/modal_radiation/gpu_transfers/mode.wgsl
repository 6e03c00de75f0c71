// Definitions shared by all kernels: sizes, and the parameters of a mode.

struct Sizes {
    modes: u32,
    places: u32,
    // Highest order of any mode.
    order: u32,
    // Σ (order + 1) of the modes.
    waves: u32,
}

struct Mode {
    first_coefficient: u32,
    first_wave: u32,
    order: u32,
    // κ = kR.
    wavenumber: f32,
}

fn product(a: vec2<f32>, b: vec2<f32>) -> vec2<f32> {
    return vec2(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x);
}
