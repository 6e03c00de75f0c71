// The leapfrog of all open cells without a sparse row. One invocation for each cell and lane.

@group(0) @binding(1) var<storage, read> p: array<f32>;
@group(0) @binding(2) var<storage, read_write> next: array<f32>;
// One bit for each cell that the sweep skips.
@group(0) @binding(3) var<storage, read> kept: array<u32>;
// ψ one step earlier, and now. The two cells beside a face both compute it, to the same bits.
@group(0) @binding(4) var<storage, read> psi: array<f32>;
@group(0) @binding(5) var<storage, read_write> next_psi: array<f32>;
@group(0) @binding(6) var<storage, read_write> zeta: array<f32>;
// Steps done.
@group(0) @binding(7) var<storage, read_write> clock: array<u32>;

// 1 outside the absorbing layers across an axis.
fn is_open(cell: u32, n: u32) -> f32 {
    return select(0.0, 1.0, cell > LAYER && cell < n - 1u - LAYER);
}

// Adds the terms of the layer across an axis to a cell inside it.
fn absorbed(value: f32, lane: u32, axis: u32, cell: u32, i: u32, u: u32, v: u32) -> f32 {
    let rest = run.size[axis] - 1u - FACES;
    let is_lower = i <= LAYER;
    if !is_lower && i <= rest {
        return value;
    }
    let side = select(1u, 0u, is_lower);
    let deep = select(i - rest, i, is_lower);
    let profile = run.profiles[side * FACES + deep];
    let before = run.profiles[side * FACES + deep - 1u];
    let stride = step_along(axis);
    let down = p[cell] - p[cell - stride];
    let up = p[cell + stride] - p[cell];
    let here = memory(lane, axis, side, deep, u, v);
    let below = memory(lane, axis, side, deep - 1u, u, v);
    let lower = before.y * psi[below] + before.x * down;
    let upper = profile.y * psi[here] + profile.x * up;
    next_psi[here] = upper;
    if deep == 1u {
        next_psi[below] = lower;
    }
    let stretch = upper - lower;
    let remembered = profile.w * zeta[here] + profile.z * (up - down + stretch);
    zeta[here] = remembered;
    return value + SQUARE * (stretch + remembered);
}

@compute @workgroup_size(16, 8, 1)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if all(id == vec3(0u)) {
        clock[0] += 1u;
    }
    let n = run.size;
    let lane = id.z / n.z;
    let at = vec3(id.xy, id.z % n.z);
    if lane >= run.lanes || any(at == vec3(0u)) || any(at >= n - 1u) {
        return;
    }
    let place = cell_at(at);
    if (kept[place >> 5u] >> (place & 31u) & 1u) != 0u {
        return;
    }
    let cell = lane * cells() + place;
    let row = n.x;
    let plane = n.x * n.y;
    // The cells across the faces: y, z, x.
    let a1 = p[cell - row];
    let b1 = p[cell + row];
    let c1 = p[cell - plane];
    let d1 = p[cell + plane];
    let p0 = p[cell - 1u];
    let p1 = p[cell];
    let p2 = p[cell + 1u];
    let is_inner = is_open(at.x, n.x) * is_open(at.y, n.y) * is_open(at.z, n.z) > 0.0;
    var value: f32;
    if is_inner {
        // In the order of operations of the processor.
        let o0 = is_open(at.y - 1u, n.y);
        let o1 = is_open(at.y + 1u, n.y);
        let o2 = is_open(at.z - 1u, n.z);
        let o3 = is_open(at.z + 1u, n.z);
        let whole = o0 + o1 + o2 + o3;
        let before = o0 * p[cell - row - 1u] + o1 * p[cell + row - 1u] + o2 * p[cell - plane - 1u]
            + o3 * p[cell + plane - 1u] - whole * p0;
        let beside = o0 * a1 + o1 * b1 + o2 * c1 + o3 * d1 - whole * p1;
        let after = o0 * p[cell - row + 1u] + o1 * p[cell + row + 1u] + o2 * p[cell - plane + 1u]
            + o3 * p[cell + plane + 1u] - whole * p2;
        let down = p1 - c1;
        let up = p1 - d1;
        let around = o0 * o2 * (down + p[cell - plane - row] - a1)
            + o1 * o2 * (down + p[cell - plane + row] - b1)
            + o0 * o3 * (up + p[cell + plane - row] - a1)
            + o1 * o3 * (up + p[cell + plane + row] - b1);
        let across = a1 + b1 + c1 + d1 + p0 + p2 - 6.0 * p1;
        let sum = across + SIXTH * (before - 2.0 * beside + after + around);
        value = 2.0 * p1 - next[cell] + SQUARE * sum;
        // Remove the edge terms between the first or last cell and the layer.
        if at.x == LAYER + 1u {
            value -= SQUARE * SIXTH * (before - beside);
        }
        if at.x == n.x - 2u - LAYER {
            value -= SQUARE * SIXTH * (after - beside);
        }
    } else {
        let sum = a1 + b1 + c1 + d1 + p0 + p2 - 6.0 * p1;
        value = 2.0 * p1 - next[cell] + SQUARE * sum;
        value = absorbed(value, lane, 0u, cell, at.x, at.y, at.z);
        value = absorbed(value, lane, 1u, cell, at.y, at.x, at.z);
        value = absorbed(value, lane, 2u, cell, at.z, at.x, at.y);
    }
    next[cell] = value;
}
