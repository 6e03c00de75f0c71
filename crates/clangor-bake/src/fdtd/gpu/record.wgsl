// The pressure at the points of the sphere, by interpolation along each axis. One invocation for each point
// and lane.

struct Point {
    // Cell of the first tap.
    first: u32,
    // Weights along x, y, z.
    weights: array<f32, 3 * TAPS>,
}

@group(0) @binding(1) var<storage, read> p: array<f32>;
@group(0) @binding(2) var<storage, read> points: array<Point>;
@group(0) @binding(3) var<storage, read> clock: array<u32>;
@group(0) @binding(4) var<storage, read_write> records: array<f32>;

@compute @workgroup_size(64, 1, 1)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= run.points {
        return;
    }
    let first = id.y * cells() + points[id.x].first;
    var value = 0.0;
    for (var k = 0u; k < TAPS; k++) {
        for (var j = 0u; j < TAPS; j++) {
            let row = first + (k * run.size.y + j) * run.size.x;
            var along = 0.0;
            for (var i = 0u; i < TAPS; i++) {
                along += p[row + i] * points[id.x].weights[i];
            }
            value += points[id.x].weights[2u * TAPS + k] * points[id.x].weights[TAPS + j] * along;
        }
    }
    let slot = clock[0] / run.stride % run.records;
    records[(slot * run.lanes + id.y) * run.points + id.x] = value;
}
