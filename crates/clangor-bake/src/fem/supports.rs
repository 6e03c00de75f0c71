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

use clangor_core::body::support::free_motions;
pub use clangor_core::body::support::{Support, SupportKind, SupportRegion};
use glam::{DMat3, DVec3};

use super::element::shapes;
use crate::mesh::tetrahedra::TetMesh;
use crate::quadrature::TETRAHEDRON_FIFTH_DEGREE;

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
    /// A free body whose supports bend it.
    #[error(
        "on its supports the body would move as a whole at {whole:.1} Hz, not far below its first own mode \
         at {first:.1} Hz, but the supports of a free body move with it; soften them, or fix the body"
    )]
    Stiff {
        /// Highest frequency of the six motions that were rigid \[Hz\].
        whole: f64,
        /// The next \[Hz\].
        first: f64,
    },
}

/// Rejects numbers that no support has.
///
/// # Errors
/// [`SupportError`].
pub fn check_supports(supports: &[Support]) -> Result<(), SupportError> {
    supports.iter().enumerate().try_for_each(|(index, support)| check(support, index))
}

pub(super) fn check(held: &Support, support: usize) -> Result<(), SupportError> {
    let wrong = |what, value| Err(SupportError::Value { support, what, value });
    let (middle, half) = held.region.bounds();
    if let Some(value) = middle.to_array().into_iter().find(|x| !x.is_finite()) {
        return wrong("place", value);
    }
    if let Some(value) = half.to_array().into_iter().find(|x| !(*x > 0.0 && x.is_finite())) {
        return wrong("extent", value);
    }
    let SupportKind::Sprung { stiffness, damping } = held.kind else { return Ok(()) };
    for (what, vector) in [("stiffness", stiffness), ("damping", damping)] {
        if let Some(value) = vector.to_array().into_iter().find(|x| !(*x >= 0.0 && x.is_finite())) {
            return wrong(what, value);
        }
    }
    if stiffness == DVec3::ZERO { Err(SupportError::Loose { support }) } else { Ok(()) }
}

/// A spring and damper to the ground, at a point of a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct PointSpring {
    /// Where it is \[m\].
    pub place: DVec3,
    /// Nodes around the point, with the weight of each.
    pub weights: Vec<(u32, f64)>,
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

/// 2ξω = uᵀC u [1/s] by the dampers of supports, of a mode with uᵀM u = 1. That dampers also couple modes is
/// left out: right where modes are farther apart than their bandwidths.
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
            check(support, index)?;
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
                        place: weights.iter().map(|(node, w)| mesh.nodes[*node as usize] * *w).sum(),
                        weights: weights.into(),
                        stiffness: stiffness * (volume / total),
                        damping: damping * (volume / total),
                    }));
                }
            }
        }
        let clamped: Vec<bool> = clamp_of.iter().map(Option::is_some).collect();
        let clamps = mesh.nodes.iter().zip(&clamped).filter(|(_, held)| **held).map(|(x, _)| *x);
        let clamps: Vec<DVec3> = clamps.collect();
        let held = Holding { springs, clamped };
        held.holds(&clamps)?;
        Ok(held)
    }

    /// Springs at points that already stand for all supports: clamps as stiff springs, in a discretization
    /// whose nodes are not on the body.
    ///
    /// # Errors
    /// [`SupportError::Free`].
    pub(super) fn of_springs(springs: Vec<PointSpring>, nodes: usize) -> Result<Self, SupportError> {
        let held = Holding { springs, clamped: vec![false; nodes] };
        held.holds(&[])?;
        Ok(held)
    }

    /// 2ξω [1/s] of a mode with these displacements of all nodes.
    pub fn damping(&self, shape: &[DVec3]) -> f64 {
        support_damping(&self.springs, shape)
    }

    /// Whether springs and clamped places leave no motion of the whole body free.
    fn holds(&self, clamped: &[DVec3]) -> Result<(), SupportError> {
        let stiffest = self.springs.iter().map(|s| s.stiffness.max_element()).fold(0.0, f64::max);
        let clamp = DVec3::splat(if stiffest > 0.0 { stiffest } else { 1.0 });
        let springs = self.springs.iter().map(|spring| (spring.place, spring.stiffness));
        let held: Vec<_> = springs.chain(clamped.iter().map(|x| (*x, clamp))).collect();
        match free_motions(&held) {
            0 => Ok(()),
            motions => Err(SupportError::Free { motions }),
        }
    }
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
