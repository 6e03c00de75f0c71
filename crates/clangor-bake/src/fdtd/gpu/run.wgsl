// Parameters shared by all kernels of a run. LAYER, FACES and SQUARE are prepended, as on the processor.

struct Run {
    // Cells along each axis.
    size: vec3<u32>,
    // Motions that run side by side; their fields are consecutive in each buffer.
    lanes: u32,
    // Motion of the first of them.
    first: u32,
    // Rows near the body, and points of the sphere.
    rows: u32,
    points: u32,
    // Steps between records, and records that are kept.
    stride: u32,
    records: u32,
    // Longest edge of the grid.
    longest: u32,
    padding: vec2<u32>,
    // (a, b) of face i and of cell i of a layer, the lower one first.
    profiles: array<vec4<f32>, 2 * FACES>,
}

@group(0) @binding(0) var<uniform> run: Run;

fn cells() -> u32 {
    return run.size.x * run.size.y * run.size.z;
}

fn cell_at(at: vec3<u32>) -> u32 {
    return (at.z * run.size.y + at.y) * run.size.x + at.x;
}

// Distance of neighbours along an axis.
fn step_along(axis: u32) -> u32 {
    return select(select(run.size.x * run.size.y, run.size.x, axis == 1u), 1u, axis == 0u);
}

// Index of a lane's memory variable of face or cell `i` of the layer `side` across an axis; (u, v) is the
// position along the two other axes.
fn memory(lane: u32, axis: u32, side: u32, i: u32, u: u32, v: u32) -> u32 {
    let layer = ((lane * 3u + axis) * 2u + side) * FACES + i;
    return (layer * run.longest + v) * run.longest + u;
}
