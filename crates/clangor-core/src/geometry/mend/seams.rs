//! Cracks: open edges whose counterparts lie within rounding, because both sides were written with few digits
//! or one side has a vertex more.
//!
//! Vertices on open edges merge within [`SEAM`] of the diagonal, at most a third of the shortest open edge at
//! them; then vertices that lie on an open edge within that distance divide it.

use std::collections::HashMap;

use glam::DVec3;

use super::super::tri_mesh::TriMesh;
use super::edges::{Side, Sides};
use super::{Fault, Repair, SEAM};

/// Most cells of the grid that one edge is looked up in.
const MOST_CELLS: f64 = 4096.0;
/// Rounds of dividing edges: one edge of each triangle in each.
const ROUNDS: usize = 3;

/// What was closed.
#[derive(Default)]
struct Closed {
    count: usize,
    gap: f64,
    position: DVec3,
}

impl Closed {
    fn note(&mut self, gap: f64, position: DVec3) {
        if self.count == 0 {
            self.position = position;
        }
        self.count += 1;
        self.gap = self.gap.max(gap);
    }
}

pub(super) fn close_cracks(work: &mut Repair) {
    let tolerance = SEAM * work.diagonal;
    let mut closed = Closed::default();
    merge(&mut work.mesh, tolerance, &mut closed);
    for _ in 0..ROUNDS {
        let before = closed.count;
        divide(&mut work.mesh, tolerance, &mut closed);
        if closed.count == before {
            break;
        }
    }
    work.note(Fault::Crack { gap: closed.gap / work.diagonal }, closed.count, closed.position);
}

/// A grid of vertices. Cells are only looked up, and hold their vertices in order.
struct Grid {
    cell: f64,
    cells: HashMap<[i64; 3], Vec<u32>>,
}

impl Grid {
    fn of(x: DVec3, cell: f64) -> [i64; 3] {
        (x / cell).floor().to_array().map(|c| c as i64)
    }

    fn add(&mut self, i: u32, x: DVec3) {
        self.cells.entry(Self::of(x, self.cell)).or_default().push(i);
    }

    /// Vertices in the cells of a box, in order of index; `None` if there are too many cells.
    fn within(&self, low: DVec3, high: DVec3) -> Option<Vec<u32>> {
        let (low, high) = (Self::of(low, self.cell), Self::of(high, self.cell));
        let sizes: f64 = (0..3).map(|k| (high[k] - low[k]) as f64 + 1.0).product();
        if sizes > MOST_CELLS {
            return None;
        }
        let mut found = Vec::new();
        for x in low[0]..=high[0] {
            for y in low[1]..=high[1] {
                for z in low[2]..=high[2] {
                    found.extend(self.cells.get(&[x, y, z]).into_iter().flatten());
                }
            }
        }
        found.sort_unstable();
        Some(found)
    }
}

/// The ends of open sides, in order, and the length of the shortest open side at each vertex.
fn border(mesh: &TriMesh, open: &[Side]) -> (Vec<u32>, Vec<f64>) {
    let mut shortest = vec![f64::INFINITY; mesh.vertices.len()];
    let mut ends = Vec::with_capacity(2 * open.len());
    for side in open {
        let (a, b) = (side.low as usize, side.high as usize);
        let length = mesh.vertices[a].distance(mesh.vertices[b]);
        for i in [a, b] {
            shortest[i] = shortest[i].min(length);
            ends.push(i as u32);
        }
    }
    ends.sort_unstable();
    ends.dedup();
    (ends, shortest)
}

fn merge(mesh: &mut TriMesh, tolerance: f64, closed: &mut Closed) {
    let open = Sides::new(mesh).open();
    let (ends, shortest) = border(mesh, &open);
    if ends.is_empty() || tolerance <= 0.0 {
        return;
    }
    let mut grid = Grid { cell: 2.0 * tolerance, cells: HashMap::new() };
    let mut onto: Vec<u32> = (0..mesh.vertices.len() as u32).collect();
    for i in ends {
        let x = mesh.vertices[i as usize];
        let reach = tolerance.min(shortest[i as usize] / 3.0);
        let near = grid.within(x - reach, x + reach).unwrap_or_default();
        let distance = |j: u32| mesh.vertices[j as usize].distance(x);
        let twin = near
            .into_iter()
            .filter(|j| distance(*j) <= reach.min(shortest[*j as usize] / 3.0))
            .min_by(|j, k| distance(*j).total_cmp(&distance(*k)).then(j.cmp(k)));
        match twin {
            Some(j) => {
                onto[i as usize] = j;
                closed.note(distance(j), x);
            }
            None => grid.add(i, x),
        }
    }
    mesh.triangles.iter_mut().flatten().for_each(|i| *i = onto[*i as usize]);
    mesh.triangles.retain(|[a, b, c]| a != b && b != c && c != a);
}

/// Divides open sides at the vertices on open edges that lie on them.
fn divide(mesh: &mut TriMesh, tolerance: f64, closed: &mut Closed) {
    let open = Sides::new(mesh).open();
    let (ends, _) = border(mesh, &open);
    if ends.is_empty() || tolerance <= 0.0 {
        return;
    }
    let length = |s: &Side| mesh.vertices[s.low as usize].distance(mesh.vertices[s.high as usize]);
    let mean = open.iter().map(length).sum::<f64>() / open.len() as f64;
    let mut grid = Grid { cell: mean.max(2.0 * tolerance), cells: HashMap::new() };
    ends.iter().for_each(|i| grid.add(*i, mesh.vertices[*i as usize]));
    let mut touched = vec![false; mesh.triangles.len()];
    for side in open {
        let t = side.triangle as usize;
        if touched[t] {
            continue;
        }
        let slot = usize::from(side.slot);
        let [a, b, c] = [0, 1, 2].map(|k| mesh.triangles[t][(slot + k) % 3]);
        let [p, q] = [a, b].map(|i| mesh.vertices[i as usize]);
        let (along, length) = (q - p, p.distance(q));
        let (low, high) = (p.min(q) - tolerance, p.max(q) + tolerance);
        let near = grid.within(low, high).unwrap_or_else(|| ends.clone());
        let off = |i: &u32| {
            let x = mesh.vertices[*i as usize] - p;
            let share = x.dot(along) / (length * length);
            (share, (x - along * share).length())
        };
        let margin = tolerance / length;
        let mut on: Vec<(f64, u32)> = near
            .into_iter()
            .filter(|i| ![a, b, c].contains(i))
            .map(|i| (off(&i), i))
            .filter(|((share, far), _)| *far <= tolerance && *share > margin && *share < 1.0 - margin)
            .map(|((share, _), i)| (share, i))
            .collect();
        if on.is_empty() {
            continue;
        }
        on.sort_unstable_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)));
        on.iter().for_each(|(_, i)| closed.note(off(i).1, mesh.vertices[*i as usize]));
        let chain: Vec<u32> = [a].into_iter().chain(on.into_iter().map(|(_, i)| i)).chain([b]).collect();
        mesh.triangles[t] = [chain[0], chain[1], c];
        mesh.triangles.extend(chain[1..].windows(2).map(|pair| [pair[0], pair[1], c]));
        touched[t] = true;
    }
}
