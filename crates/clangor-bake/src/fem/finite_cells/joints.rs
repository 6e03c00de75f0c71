//! Which nodes the parts of neighbouring cells share.
//!
//! Two parts are joined where their sections with the common face of their cells overlap: they share the
//! nodes of this face, so that displacements are continuous. Parts that touch the face in different places,
//! such as two walls with a gap between them, share none.

use glam::DVec3;

use super::basis::Basis;
use super::chain::{Cap, Chain, Origin};
use super::grid::CellGrid;
use super::parts::{Cell, Parts, face_area};

/// Least overlap, in the smaller of two sections.
const OVERLAP: f64 = 0.1;
/// Rounding of a section, in the area of a face.
const ROUNDING: f64 = 1e-12;

/// Sets of equals.
struct Sets(Vec<u32>);

impl Sets {
    fn root(&mut self, mut of: usize) -> usize {
        while self.0[of] as usize != of {
            let above = self.0[self.0[of] as usize];
            self.0[of] = above;
            of = above as usize;
        }
        of
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b)] = a.min(b) as u32;
    }
}

/// Nodes of each part, and positions of all nodes \[m\], in the order of the grid.
pub(super) fn numbered(grid: &CellGrid, basis: &Basis, body: &Parts) -> (Vec<Vec<u32>>, Vec<DVec3>) {
    let degree = basis.degree();
    let local = degree + 1;
    let all = local.pow(3);
    let mut nodes = Sets((0..(body.parts.len() * all) as u32).collect());
    let mut bodies = Sets((0..body.parts.len() as u32).collect());
    body.ties.iter().for_each(|tie| bodies.join(tie.parts[0], tie.parts[1]));
    let mut share = |pair: [usize; 2], axis: usize, bodies: &mut Sets| {
        bodies.join(pair[0], pair[1]);
        let step = [local * local, local, 1][axis];
        for k in on_lower_face(local, axis) {
            nodes.join(pair[0] * all + k + degree * step, pair[1] * all + k);
        }
    };
    for cell in &body.cells {
        for axis in 0..3 {
            if let Some(above) = neighbour(body, cell, axis) {
                for pair in joined(body, cell, above, axis) {
                    share(pair, axis, &mut bodies);
                }
            }
        }
    }
    // What hangs together by less than rounding shares all nodes of the face.
    for cell in &body.cells {
        for axis in 0..3 {
            let Some(above) = neighbour(body, cell, axis) else { continue };
            for pair in
                cell.parts.iter().flatten().flat_map(|a| above.parts.iter().flatten().map(|b| [*a, *b]))
            {
                if bodies.root(pair[0]) != bodies.root(pair[1]) {
                    share(pair, axis, &mut bodies);
                }
            }
        }
    }
    let lattice = |part: usize, k: usize| -> [usize; 3] {
        let at = [k / (local * local), k / local % local, k % local];
        std::array::from_fn(|a| body.parts[part].place[a] * degree + at[a])
    };
    let roots: Vec<([usize; 3], u32)> = (0..body.parts.len() * all)
        .map(|node| (lattice(node / all, node % all), nodes.root(node) as u32))
        .collect();
    let mut distinct = roots.clone();
    distinct.sort_unstable();
    distinct.dedup();
    let number = |key: &([usize; 3], u32)| distinct.partition_point(|other| other < key) as u32;
    let elements = roots.chunks_exact(all).map(|own| own.iter().map(number).collect()).collect();
    let along = |n: usize| (n / degree) as f64 + basis.lobatto()[n % degree];
    let positions =
        distinct.iter().map(|(at, _)| grid.origin + grid.edge * DVec3::from_array(at.map(along))).collect();
    (elements, positions)
}

/// Whether the body goes on through the mirror plane across each axis at each of so many nodes: a part that
/// does not meet the plane is not joined to its image.
pub(super) fn on_mirrors(
    grid: &CellGrid,
    basis: &Basis,
    (body, elements): (&Parts, &[Vec<u32>]),
    count: usize,
) -> Vec<[bool; 3]> {
    let local = basis.degree() + 1;
    let mut on = vec![[false; 3]; count];
    for cell in &body.cells {
        for axis in (0..3).filter(|a| grid.mirrored()[*a] && cell.place[*a] == grid.images[*a]) {
            let meets = |part: &&usize| cell.lower_section(&body.parts[**part], axis) > ROUNDING;
            for part in cell.parts.iter().flatten().filter(meets) {
                for node in on_lower_face(local, axis).map(|k| elements[*part][k]) {
                    on[node as usize][axis] = true;
                }
            }
        }
    }
    on
}

/// The nodes of a cell on its lower face across an axis.
fn on_lower_face(local: usize, axis: usize) -> impl Iterator<Item = usize> {
    let step = [local * local, local, 1][axis];
    (0..local.pow(3)).filter(move |k| (k / step).is_multiple_of(local))
}

fn neighbour<'a>(body: &'a Parts, cell: &Cell, axis: usize) -> Option<&'a Cell> {
    let mut place = cell.place;
    place[axis] += 1;
    body.cells.binary_search_by_key(&place, |cell| cell.place).ok().map(|k| &body.cells[k])
}

/// The pairs of parts that are joined across the upper face of a cell along an axis.
fn joined(body: &Parts, cell: &Cell, above: &Cell, axis: usize) -> Vec<[usize; 2]> {
    let face = 2 * axis as u8;
    let parts = |cell: &Cell| {
        let mut parts: Vec<usize> = cell.parts.iter().flatten().copied().collect();
        parts.sort_unstable();
        parts.dedup();
        parts
    };
    let (lower, upper) = (parts(cell), parts(above));
    let area = |cell_: &Cell, part: usize, face: u8| match cell_.division {
        Some(_) => face_area(&body.parts[part].sections, face),
        None => cell.sections[axis],
    };
    let below: Vec<f64> = lower.iter().map(|part| area(cell, *part, face + 1)).collect();
    let over: Vec<f64> = upper.iter().map(|part| area(above, *part, face)).collect();
    // Overlap of each part below with each above.
    let overlap: Vec<Vec<f64>> = match (&cell.division, &above.division) {
        (_, None) => below.iter().map(|area| vec![*area]).collect(),
        (None, Some(_)) => vec![over.clone()],
        (Some(_), Some(division)) => {
            let shift = DVec3::AXES[axis];
            let within = |part: &usize| {
                let mut section = Chain::default();
                for cap in
                    body.parts[*part].sections.iter().filter(|cap| cap.origin == Origin::Face(face + 1))
                {
                    let border = cap.border.iter().map(|side| side.map(|x| x - shift)).collect();
                    section.caps.push(Cap { origin: cap.origin, border });
                }
                let (walls, _) = division.parts(&section);
                let mut areas = vec![0.0; upper.len()];
                for (wall, chain) in walls.iter().enumerate() {
                    let Some(found) = above.parts[wall].and_then(|part| upper.binary_search(&part).ok())
                    else {
                        continue;
                    };
                    areas[found] += face_area(&chain.caps, face + 1);
                }
                areas
            };
            lower.iter().map(within).collect()
        }
    };
    let mut pairs = Vec::new();
    for (a, row) in overlap.iter().enumerate() {
        for (b, shared) in row.iter().enumerate() {
            let most = row.iter().all(|other| other <= shared) || overlap.iter().all(|row| row[b] <= *shared);
            let enough = *shared > OVERLAP * below[a].min(over[b]);
            if *shared > ROUNDING && (most || enough) {
                pairs.push([lower[a], upper[b]]);
            }
        }
    }
    pairs
}
