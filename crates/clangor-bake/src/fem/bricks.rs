//! Stiffness and mass of a box of hexahedra: elements of order 4 or 2 where nothing is curved.
//!
//! ```text
//! N_ijk(x, y, z) = l_i(x) l_j(y) l_k(z),    l of second or fourth order, on evenly spaced nodes
//! K_IJ = ∫ λ g_I g_Jᵀ + μ (g_J g_Iᵀ + (g_I·g_J) 1) dV,    M_IJ = 1 ∫ ρ N_I N_J dV
//! ```
//!
//! Tetrahedra that are many times as long as a plate is thick are too stiff in bending: their displacements
//! across the plate cannot follow those along it. Hexahedra of order 4 on the same nodes can. Integrals are
//! products of those along the axes, exact, and the same for all elements.

use glam::{DMat3, DVec3};

use super::across_walls::{self, Columns, Unknowns};
use super::rigid_motions::rigid_motions;
use super::{ElasticConstants, ElasticSystem, Elements};
use crate::mesh::tetrahedra::TetMesh;
use crate::quadrature::gauss_legendre;

/// Order of hexahedra two cells long.
const HIGH_ORDER: usize = 4;
/// Order of hexahedra one cell long.
const LOW_ORDER: usize = 2;

/// Integrals of one axis over the unit interval.
pub(super) struct Axis {
    /// Order of the shape functions.
    order: usize,
    /// Elements along the axis.
    bricks: usize,
    /// Length of an element \[m\].
    length: f64,
    /// ∫ l_i l_j, by i (order + 1) + j.
    plain: Vec<f64>,
    /// ∫ l_i' l_j.
    mixed: Vec<f64>,
    /// ∫ l_i' l_j'.
    steep: Vec<f64>,
}

impl Axis {
    /// An axis of so many cells; a single one has the unknowns of a wall, if asked.
    pub(super) fn new(length: f64, cells: usize, unknowns: Unknowns) -> Self {
        let order = if cells.is_multiple_of(2) { HIGH_ORDER } else { LOW_ORDER };
        let bricks = cells * LOW_ORDER / order;
        let count = order + 1;
        let mut axis = Axis {
            order,
            bricks,
            length: length / bricks as f64,
            plain: vec![0.0; count * count],
            mixed: vec![0.0; count * count],
            steep: vec![0.0; count * count],
        };
        for (x, weight) in gauss_legendre(count) {
            let shape = |i: usize| match is_wall(cells, unknowns) {
                true => across_walls::function(i, x),
                false => lagrange(order, i, x),
            };
            let shapes: Vec<(f64, f64)> = (0..count).map(shape).collect();
            for (i, (value, slope)) in shapes.iter().enumerate() {
                for (j, (other, other_slope)) in shapes.iter().enumerate() {
                    axis.plain[i * count + j] += weight * value * other;
                    axis.mixed[i * count + j] += weight * slope * other;
                    axis.steep[i * count + j] += weight * slope * other_slope;
                }
            }
        }
        axis
    }

    /// ∫ along an element of the shape functions i and j, differentiated where flagged.
    pub(super) fn integral(&self, i: usize, j: usize, derived: [bool; 2]) -> f64 {
        let count = self.order + 1;
        match derived {
            [false, false] => self.plain[i * count + j] * self.length,
            [true, false] => self.mixed[i * count + j],
            [false, true] => self.mixed[j * count + i],
            [true, true] => self.steep[i * count + j] / self.length,
        }
    }
}

/// Whether an axis of so many cells has the unknowns of a wall.
pub(super) fn is_wall(cells: usize, unknowns: Unknowns) -> bool {
    cells == 1 && unknowns == Unknowns::AcrossWalls
}

/// Value and slope of the i-th Lagrange polynomial on evenly spaced nodes of [0, 1].
fn lagrange(order: usize, i: usize, x: f64) -> (f64, f64) {
    let node = |k: usize| k as f64 / order as f64;
    let others = || (0..=order).filter(move |k| *k != i);
    let scale: f64 = others().map(|k| node(i) - node(k)).product();
    let value: f64 = others().map(|k| x - node(k)).product();
    let slope: f64 =
        others().map(|m| others().filter(|k| *k != m).map(|k| x - node(k)).product::<f64>()).sum();
    (value / scale, slope / scale)
}

/// Stiffness and mass of a box on the nodes of `mesh`, which is
/// [`block`](crate::mesh::tetrahedra::block::block) of the same full edges \[m\] and cells. Along axes with
/// an even number of cells the hexahedra are two cells long and of order 4.
pub fn box_of_bricks(
    mesh: &TetMesh,
    edges: DVec3,
    cells: [usize; 3],
    constants: &ElasticConstants,
    unknowns: Unknowns,
) -> ElasticSystem {
    let axes: [Axis; 3] = std::array::from_fn(|a| Axis::new(edges[a], cells[a], unknowns));
    let counts = cells.map(|n| 2 * n + 1);
    let number = |at: [usize; 3]| (at[2] * counts[1] + at[1]) * counts[0] + at[0];
    let mut lattice = vec![0_u32; counts.iter().product()];
    for (n, node) in mesh.nodes.iter().enumerate() {
        let at = |a: usize| ((node[a] / edges[a] + 0.5) * (counts[a] - 1) as f64).round() as usize;
        lattice[number([at(0), at(1), at(2)])] = n as u32;
    }
    let orders = [0, 1, 2].map(|a| axes[a].order);
    let local: Vec<[usize; 3]> = each([0, 1, 2].map(|a| orders[a] + 1)).collect();
    let brick = |at: [usize; 3]| -> Vec<u32> {
        local.iter().map(|l| lattice[number([0, 1, 2].map(|a| at[a] * orders[a] + l[a]))]).collect()
    };
    let elements: Vec<Vec<u32>> = each([0, 1, 2].map(|a| axes[a].bricks)).map(brick).collect();
    let pairs: Vec<(DMat3, f64)> = (0..local.len())
        .flat_map(|i| (0..=i).map(move |j| (i, j)))
        .map(|(i, j)| pair(&axes, local[i], local[j], constants))
        .collect();
    // Lines of three nodes along the axes of one cell; along two such axes, both changes of unknowns follow.
    let mut columns = Columns::default();
    for a in (0..3).filter(|a| is_wall(cells[*a], unknowns)) {
        let along = |at: [usize; 3], level: usize| {
            let mut at = at;
            at[a] = level;
            lattice[number(at)]
        };
        let feet = each(std::array::from_fn(|b| if a == b { 1 } else { counts[b] }));
        columns.0.extend(feet.map(|at| [0, 1, 2].map(|level| along(at, level))));
    }
    let (nodes, rigid) = (mesh.nodes.clone(), rigid_motions(&mesh.nodes).into());
    let mesh = Elements { nodes, elements: &elements, rigid, columns };
    ElasticSystem::assemble(mesh, |_| |i: usize, j: usize| pairs[i * (i + 1) / 2 + j])
}

/// All index triples of a grid, the first axis fastest.
fn each(counts: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
    let [nx, ny, nz] = counts;
    (0..nz).flat_map(move |k| (0..ny).flat_map(move |j| (0..nx).map(move |i| [i, j, k])))
}

/// Block of the stiffness [N/m] and factor of the mass \[kg\] of two nodes of a hexahedron.
fn pair(axes: &[Axis; 3], i: [usize; 3], j: [usize; 3], constants: &ElasticConstants) -> (DMat3, f64) {
    let integral = |of: Option<usize>, with: Option<usize>| -> f64 {
        (0..3).map(|a| axes[a].integral(i[a], j[a], [of == Some(a), with == Some(a)])).product()
    };
    let gradients: [[f64; 3]; 3] =
        std::array::from_fn(|a| std::array::from_fn(|b| integral(Some(a), Some(b))));
    let dot = gradients[0][0] + gradients[1][1] + gradients[2][2];
    let ElasticConstants { lame_lambda: lambda, shear_modulus: mu, density } = *constants;
    let entry = |r: usize, c: usize| {
        lambda * gradients[r][c] + mu * (gradients[c][r] + if r == c { dot } else { 0.0 })
    };
    let column = |c: usize| DVec3::new(entry(0, c), entry(1, c), entry(2, c));
    (DMat3::from_cols(column(0), column(1), column(2)), density * integral(None, None))
}

#[cfg(test)]
mod tests {
    use clangor_core::material::presets::STEEL;

    use super::*;
    use crate::mesh::tetrahedra::block::block;

    #[test]
    fn bricks_and_tetrahedra_agree_on_what_both_can_represent() {
        let (edges, cells) = (DVec3::new(0.3, 0.02, 0.1), [4, 1, 3]);
        let constants = ElasticConstants::of(&STEEL.material()).expect("steel");
        let mesh = block(edges, cells).expect("a box");
        let bricks = box_of_bricks(&mesh, edges, cells, &constants, Unknowns::AtNodes);
        let walls = box_of_bricks(&mesh, edges, cells, &constants, Unknowns::AcrossWalls);
        let tetrahedra = ElasticSystem::new(&mesh, &constants);
        // A displacement of second order, with all strains.
        let motion: Vec<DVec3> = (mesh.nodes.iter())
            .map(|p| {
                DVec3::new(p.x * p.y + p.z * p.z, p.x * p.x - 2.0 * p.y * p.z, p.z * p.x + p.y + 3.0 * p.z)
            })
            .collect();
        let energy = |system: &ElasticSystem| {
            let motion: Vec<f64> = system.unknowns_of(&motion);
            let (mut stiff, mut heavy) = (vec![0.0; motion.len()], vec![0.0; motion.len()]);
            system.multiply_stiffness(&motion, 1, &mut stiff);
            system.multiply_mass(&motion, 1, &mut heavy);
            let with = |y: &[f64]| motion.iter().zip(y).map(|(u, f)| u * f).sum::<f64>();
            [with(&stiff), with(&heavy)]
        };
        let other = energy(&tetrahedra);
        for one in [energy(&bricks), energy(&walls)] {
            for k in 0..2 {
                assert!((one[k] / other[k] - 1.0).abs() < 1e-10, "{one:?} {other:?}");
            }
        }
    }
}
