//! What holds a body: clamps and springs in a region of it, as part of the eigenproblem.
//!
//! ```text
//! clamp:    u = 0 at the nodes in the region
//! springs:  K ← K + Σ_q k_q N_q N_qᵀ,   C = Σ_q c_q N_q N_qᵀ,   N_q: interpolation weights at a point
//! ```
//!
//! The points of springs fill the part of the body in the region, each with its share of the stiffness by
//! volume. Weights are those of the quadratic tetrahedra on the nodes of the mesh, whatever its elements:
//! bricks and prisms have the same nodes. All nodes of a tetrahedron belong to one element, so the pattern of
//! the matrices does not change. Motions that were rigid become modes.
//!
//! A clamp ends at the last nodes within it: to first order in their distance. Boxes choose their grid so
//! that nodes lie at its ends, if a grid up to half finer has such nodes.
//!
//! Not here: what the support itself weighs, and supports that let the body lift off.

use std::collections::BTreeMap;

use glam::{DMat3, DVec3};

use super::element::shapes;
use super::rigid_motions::rigid_motions;
use crate::mesh::tetrahedra::TetMesh;
use crate::quadrature::TETRAHEDRON_FIFTH_DEGREE;

/// A part of space, in the frame of the body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SupportRegion {
    /// A ball.
    Ball {
        /// Centre \[m\].
        centre: DVec3,
        /// Radius \[m\].
        radius: f64,
    },
    /// A box along the axes of the body.
    Box {
        /// Lowest corner \[m\].
        low: DVec3,
        /// Highest corner \[m\].
        high: DVec3,
    },
}

/// How a support holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SupportKind {
    /// Nothing in the region moves.
    Clamped,
    /// Springs and dampers along the axes of the body, spread over the region.
    Sprung {
        /// Total stiffness along each axis [N/m].
        stiffness: DVec3,
        /// Total damping along each axis [N s/m].
        damping: DVec3,
    },
}

/// A support of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Support {
    /// Where it holds.
    pub region: SupportRegion,
    /// How.
    pub kind: SupportKind,
}

/// Reasons why a body cannot be held as described. Supports count from 0.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SupportError {
    /// A number out of range.
    #[error("the {what} of support {support} is {value}")]
    Value {
        /// Which support.
        support: usize,
        /// Quantity.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// No stiffness along any axis.
    #[error("support {support} has no stiffness along any axis; clamp it, or give it a stiffness")]
    Loose {
        /// Which support.
        support: usize,
    },
    /// No part of the body is in the region.
    #[error(
        "support {support} does not touch the body: its region is {distance:.3e} m from the nearest node; \
         move or widen it"
    )]
    Off {
        /// Which support.
        support: usize,
        /// Distance from the body \[m\].
        distance: f64,
    },
    /// Two clamps share a part of the body.
    #[error("the clamps {first} and {second} overlap; make them one")]
    Overlap {
        /// One clamp.
        first: usize,
        /// The other.
        second: usize,
    },
    /// The supports together leave the body free.
    #[error(
        "the supports leave {motions} of the six motions of the whole body free; add another, or widen one"
    )]
    Free {
        /// Number of free motions.
        motions: usize,
    },
    /// A body that is solved on its section.
    #[error("a body of revolution with supports is no longer one; give its surface as a mesh")]
    Revolution,
}

impl SupportRegion {
    /// Distance of a point from the region \[m\]; 0 inside.
    fn distance(&self, point: DVec3) -> f64 {
        match *self {
            SupportRegion::Ball { centre, radius } => (point.distance(centre) - radius).max(0.0),
            SupportRegion::Box { low, high } => point.distance(point.clamp(low, high)),
        }
    }

    /// Lowest and highest coordinate along an axis \[m\].
    pub(crate) fn ends(&self, axis: usize) -> [f64; 2] {
        let (middle, half) = self.bounds();
        [middle[axis] - half[axis], middle[axis] + half[axis]]
    }

    /// Middle and half extent \[m\].
    fn bounds(&self) -> (DVec3, DVec3) {
        match *self {
            SupportRegion::Ball { centre, radius } => (centre, DVec3::splat(radius)),
            SupportRegion::Box { low, high } => (0.5 * (low + high), 0.5 * (high - low)),
        }
    }
}

impl Support {
    /// Rejects numbers that no support has; `support` is its place among the others.
    ///
    /// # Errors
    /// [`SupportError`].
    pub fn check(&self, support: usize) -> Result<(), SupportError> {
        let wrong = |what, value| Err(SupportError::Value { support, what, value });
        let (middle, half) = self.region.bounds();
        if let Some(value) = middle.to_array().into_iter().find(|x| !x.is_finite()) {
            return wrong("place", value);
        }
        if let Some(value) = half.to_array().into_iter().find(|x| !(*x > 0.0 && x.is_finite())) {
            return wrong("extent", value);
        }
        let SupportKind::Sprung { stiffness, damping } = self.kind else { return Ok(()) };
        for (what, vector) in [("stiffness", stiffness), ("damping", damping)] {
            if let Some(value) = vector.to_array().into_iter().find(|x| !(*x >= 0.0 && x.is_finite())) {
                return wrong(what, value);
            }
        }
        if stiffness == DVec3::ZERO { Err(SupportError::Loose { support }) } else { Ok(()) }
    }
}

/// A spring and damper to the ground, at a point of a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct PointSpring {
    /// Nodes around the point, with the weight of each.
    pub weights: [(u32, f64); 10],
    /// Stiffness along each axis [N/m].
    pub stiffness: DVec3,
    /// Damping along each axis [N s/m].
    pub damping: DVec3,
}

impl PointSpring {
    /// Displacement at the point \[m\].
    fn displacement(&self, motion: &[DVec3]) -> DVec3 {
        self.weights.iter().map(|(node, weight)| *weight * motion[*node as usize]).sum()
    }

    /// Its block of the stiffness between two of its nodes, by their weights.
    pub(super) fn block(&self, weight: f64) -> DMat3 {
        DMat3::from_diagonal(self.stiffness * weight)
    }
}

/// Damping rate uᵀC u [1/s] by supports of a mode with uᵀM u = 1; it adds half of it to ξω.
pub fn support_damping(springs: &[PointSpring], shape: &[DVec3]) -> f64 {
    let rate = |spring: &PointSpring| {
        let u = spring.displacement(shape);
        spring.damping.dot(u * u)
    };
    springs.iter().map(rate).sum()
}

/// Divisions along each edge of a tetrahedron that a region cuts: at least, at most, and along the shortest
/// extent of the region.
const DIVISIONS: [usize; 2] = [4, 32];
const ACROSS: f64 = 4.0;
/// Part of the size of the mesh within which a node is in a region.
const ROUNDING: f64 = 1e-9;
/// Least pivot of the stiffness against rigid motions, over the largest, of a body that is held.
const LEAST_PIVOT: f64 = 1e-12;

/// What supports do to a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Holding {
    /// Springs between points and the ground.
    pub springs: Vec<PointSpring>,
    /// By node: whether a clamp holds it.
    pub clamped: Vec<bool>,
}

impl Holding {
    /// The supports on a mesh.
    ///
    /// # Errors
    /// [`SupportError`] for numbers out of range, regions beside the body, clamps that overlap, and supports
    /// that leave the body free to move as a whole.
    pub fn new(mesh: &TetMesh, supports: &[Support]) -> Result<Self, SupportError> {
        let mut springs = Vec::new();
        let mut clamp_of: Vec<Option<usize>> = vec![None; mesh.nodes.len()];
        for (index, support) in supports.iter().enumerate() {
            support.check(index)?;
            match support.kind {
                SupportKind::Clamped => {
                    for node in nodes_in(mesh, support, index)? {
                        match clamp_of[node] {
                            Some(first) => return Err(SupportError::Overlap { first, second: index }),
                            None => clamp_of[node] = Some(index),
                        }
                    }
                }
                SupportKind::Sprung { stiffness, damping } => {
                    let points = points_in(mesh, support, index)?;
                    let total: f64 = points.iter().map(|(_, volume)| volume).sum();
                    springs.extend(points.into_iter().map(|(weights, volume)| PointSpring {
                        weights,
                        stiffness: stiffness * (volume / total),
                        damping: damping * (volume / total),
                    }));
                }
            }
        }
        let clamped: Vec<bool> = clamp_of.iter().map(Option::is_some).collect();
        let held = Holding { springs, clamped };
        match held.free_motions(mesh) {
            0 => Ok(held),
            motions => Err(SupportError::Free { motions }),
        }
    }

    /// Number of motions of the whole body that cost no energy.
    fn free_motions(&self, mesh: &TetMesh) -> usize {
        let motions = rigid_motions(&mesh.nodes);
        let size = mesh.nodes.iter().map(|x| x.distance(mesh.nodes[0])).fold(0.0, f64::max).max(1e-300);
        let scaled = |k: usize, u: DVec3| if k < 3 { u } else { u / size };
        let mut held = [[0.0_f64; 6]; 6];
        let mut add = |u: &dyn Fn(usize) -> DVec3, stiffness: DVec3| {
            let motions: [DVec3; 6] = std::array::from_fn(|k| scaled(k, u(k)));
            for (row, first) in held.iter_mut().zip(motions) {
                row.iter_mut().zip(motions).for_each(|(sum, second)| *sum += (first * stiffness).dot(second));
            }
        };
        let stiffest = self.springs.iter().map(|s| s.stiffness.max_element()).fold(0.0, f64::max);
        let unit = if stiffest > 0.0 { stiffest } else { 1.0 };
        for spring in &self.springs {
            add(&|k| spring.displacement(&motions[k]), spring.stiffness / unit);
        }
        for (node, _) in self.clamped.iter().enumerate().filter(|(_, held)| **held) {
            add(&|k| motions[k][node], DVec3::ONE);
        }
        6 - rank(held)
    }
}

/// Rank of a positive semidefinite matrix, by elimination with the largest pivots.
fn rank(mut a: [[f64; 6]; 6]) -> usize {
    let largest = (0..6).map(|k| a[k][k]).fold(0.0, f64::max);
    let mut left: Vec<usize> = (0..6).collect();
    for done in 0..6 {
        let Some(at) = (0..left.len()).max_by(|i, j| a[left[*i]][left[*i]].total_cmp(&a[left[*j]][left[*j]]))
        else {
            return done;
        };
        let pivot = left.swap_remove(at);
        if a[pivot][pivot] <= LEAST_PIVOT * largest {
            return done;
        }
        let row = a[pivot];
        for &k in &left {
            for l in 0..6 {
                a[k][l] -= row[k] / row[pivot] * row[l];
            }
        }
    }
    6
}

/// Nodes in the region of a support, or the nearest one if the region lies between nodes.
fn nodes_in(mesh: &TetMesh, support: &Support, index: usize) -> Result<Vec<usize>, SupportError> {
    let distance = |x: &DVec3| support.region.distance(*x);
    let size = mesh.nodes.iter().map(|x| x.length()).fold(0.0, f64::max);
    let inside: Vec<usize> = (mesh.nodes.iter().enumerate())
        .filter(|(_, x)| distance(x) <= ROUNDING * size)
        .map(|(node, _)| node)
        .collect();
    if !inside.is_empty() {
        return Ok(inside);
    }
    // A region within the body that no node is in.
    points_in(mesh, support, index)?;
    let (middle, _) = support.region.bounds();
    let nearer =
        |a: &usize, b: &usize| mesh.nodes[*a].distance(middle).total_cmp(&mesh.nodes[*b].distance(middle));
    Ok((0..mesh.nodes.len()).min_by(nearer).into_iter().collect())
}

/// Nodes and weights of a point.
type Weights = [(u32, f64); 10];

/// Points in the region of a support, with their volumes \[m³\]; the nearest point for a region smaller than
/// their distance.
fn points_in(mesh: &TetMesh, support: &Support, index: usize) -> Result<Vec<(Weights, f64)>, SupportError> {
    let mut lattices: BTreeMap<usize, Vec<[f64; 10]>> = BTreeMap::new();
    let coarse = lattice(DIVISIONS[0]);
    let whole: Vec<([f64; 10], f64)> =
        TETRAHEDRON_FIFTH_DEGREE.iter().map(|(at, weight)| (shapes(*at), *weight)).collect();
    // The part of the region that the body could be in.
    let (middle, half) = support.region.bounds();
    let lowest = mesh.nodes.iter().copied().fold(DVec3::INFINITY, DVec3::min).max(middle - half);
    let highest = mesh.nodes.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max).min(middle + half);
    let (middle, narrowest) = (0.5 * (lowest + highest), (highest - lowest).min_element());
    let mut inside = Vec::new();
    let mut nearest: Option<(f64, f64, Weights, f64)> = None;
    for (e, element) in mesh.elements.iter().enumerate() {
        let nodes = mesh.positions(e);
        let at = |shape: &[f64; 10]| nodes.iter().zip(shape).map(|(x, w)| *x * *w).sum::<DVec3>();
        let [a, b, c, d] = [nodes[0], nodes[1], nodes[2], nodes[3]];
        let volume = (b - a).cross(c - a).dot(d - a).abs() / 6.0;
        let weights = |shape: &[f64; 10]| std::array::from_fn(|k| (element[k], shape[k]));
        let low = nodes.into_iter().fold(DVec3::INFINITY, DVec3::min);
        let high = nodes.into_iter().fold(DVec3::NEG_INFINITY, DVec3::max);
        let apart = (low.cmpgt(highest) | high.cmplt(lowest)).any();
        let reach = (1..4).map(|k| nodes[k].distance(nodes[0])).fold(0.0, f64::max);
        if !apart {
            let divisions = (ACROSS * reach / narrowest.max(1e-3 * reach)).ceil() as usize;
            let divisions = divisions.clamp(DIVISIONS[0], DIVISIONS[1]);
            let lattice = lattices.entry(divisions).or_insert_with(|| lattice(divisions));
            let within: Vec<&[f64; 10]> =
                lattice.iter().filter(|shape| support.region.distance(at(shape)) == 0.0).collect();
            if within.len() == lattice.len() {
                inside.extend(whole.iter().map(|(shape, weight)| (weights(shape), weight * volume)));
            } else {
                let share = volume / lattice.len() as f64;
                inside.extend(within.iter().map(|shape| (weights(shape), share)));
            }
        }
        // The nearest point, and how far an element reaches around it.
        for shape in &coarse {
            let distance = at(shape).distance(middle);
            if nearest.as_ref().is_none_or(|(best, ..)| distance < *best) {
                nearest = Some((distance, reach, weights(shape), volume));
            }
        }
    }
    if !inside.is_empty() {
        return Ok(inside);
    }
    let off = mesh.nodes.iter().map(|x| support.region.distance(*x)).fold(f64::INFINITY, f64::min);
    match nearest {
        Some((distance, reach, weights, volume)) if distance <= reach / DIVISIONS[0] as f64 || off == 0.0 => {
            Ok(vec![(weights, volume)])
        }
        _ => Err(SupportError::Off { support: index, distance: off }),
    }
}

/// Shape functions at points of a lattice in a tetrahedron, of equal weight: exact for linear functions.
fn lattice(divisions: usize) -> Vec<[f64; 10]> {
    let each = (0..divisions)
        .flat_map(|i| (0..divisions - i).flat_map(move |j| (0..divisions - i - j).map(move |k| [i, j, k])));
    each.map(|index| {
        let at = index.map(|x| (x as f64 + 0.25) / divisions as f64);
        shapes([1.0 - at.iter().sum::<f64>(), at[0], at[1], at[2]])
    })
    .collect()
}
