// The cells near the body: p_new = 2p − p_old + Σ_j w_j (p_j − p) + a · drive + a'' · bend. One invocation
// for each row and lane.

struct Row {
    cell: u32,
    start: u32,
    end: u32,
}

struct Link {
    neighbour: u32,
    weight: f32,
}

// Of each of the six motions.
struct Drive {
    drive: array<f32, 6>,
    bend: array<f32, 6>,
}

@group(0) @binding(1) var<storage, read> p: array<f32>;
@group(0) @binding(2) var<storage, read_write> next: array<f32>;
@group(0) @binding(3) var<storage, read> rows: array<Row>;
@group(0) @binding(4) var<storage, read> links: array<Link>;
@group(0) @binding(5) var<storage, read> drives: array<Drive>;
// a and a'' at each step; none afterwards.
@group(0) @binding(6) var<storage, read> pulse: array<vec2<f32>>;
@group(0) @binding(7) var<storage, read> clock: array<u32>;

@compute @workgroup_size(64, 1, 1)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= run.rows {
        return;
    }
    let row = rows[id.x];
    let field = id.y * cells();
    let cell = field + row.cell;
    let here = p[cell];
    var sum = 0.0;
    for (var i = row.start; i < row.end; i++) {
        sum += links[i].weight * (p[field + links[i].neighbour] - here);
    }
    var acceleration = vec2(0.0);
    if clock[0] < arrayLength(&pulse) {
        acceleration = pulse[clock[0]];
    }
    let motion = run.first + id.y;
    let drive =
        drives[id.x].drive[motion] * acceleration.x + drives[id.x].bend[motion] * acceleration.y;
    next[cell] = 2.0 * here - next[cell] + sum + drive;
}
