//! The gap between two surfaces at a contact, before they give way.
//!
//! ```text
//! gap = ½ tᵀ (T_A + T_B) t = x²/(2 R') + y²/(2 R'')          T: curvature tensors in the tangent plane
//! ```
//!
//! t is the place in the tangent plane. Source: Johnson (1985), section 4.1, whose A + B and B − A are the
//! trace and the anisotropy of the sum. Bounds keep it physical where the local paraboloid is not:
//! * an edge or vertex of a mesh has a curvature of the order of 1/(triangle size), so each principal radius
//!   of a body is at least its [`edge_radius`](crate::body::Body::edge_radius);
//! * flat on flat and a cylinder on a plane have no curvature in two directions or in one, and surfaces may
//!   bend towards each other, so the curvatures are at least 2 d/L², with which the contact is as wide as the
//!   smaller body ([`touching`](mod@super::touching)). [`HertzRange`] says so.

use glam::{DMat3, DVec3};

use super::contact_side::ContactSide;
use super::hertz::HertzRange;
use crate::geometry::principal_curvature::PlanarTensor;

/// The paraboloid of the gap between two surfaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RelativeCurvature {
    /// Principal relative radii R' ≥ R'' \[m\].
    pub radii: [f64; 2],
    /// Whether they had to be bounded by the width of the contact.
    pub range: HertzRange,
}

/// Rounding of curvatures against the bound by the size.
const ROUNDING: f64 = 1e-9;

impl RelativeCurvature {
    /// Of two sides that meet along the unit `normal` \[world\].
    pub fn between(sides: &[ContactSide; 2], normal: DVec3) -> Self {
        let (u, v) = normal.any_orthonormal_pair();
        let [a, b] = sides.each_ref().map(|side| bounded(side.curvature, [u, v], side.edge_radius));
        let sum =
            PlanarTensor { mean: a.mean + b.mean, stretch: a.stretch + b.stretch, shear: a.shear + b.shear };
        let [first, second] = sum.principal();
        let least = sides[0].least_curvature.max(sides[1].least_curvature);
        let touches = |curvature: f64| curvature < least * (1.0 - ROUNDING);
        let range = if touches(first) {
            HertzRange::Conforming
        } else if second < -least {
            HertzRange::Saddle
        } else if touches(second) {
            HertzRange::Line
        } else {
            HertzRange::Within
        };
        RelativeCurvature { radii: [second, first].map(|curvature| curvature.max(least).recip()), range }
    }
}

/// The tensor in the plane of two orthonormal vectors, with principal curvatures of at most 1/`edge_radius`.
fn bounded(tensor: DMat3, plane: [DVec3; 2], edge_radius: f64) -> PlanarTensor {
    let planar = PlanarTensor::of_tensor(tensor, plane);
    let [first, second] = planar.principal();
    let most = edge_radius.recip();
    if first <= most {
        return planar;
    }
    let [kept_first, kept_second] = [most, second.min(most)];
    let shrunk = if first > second { (kept_first - kept_second) / (first - second) } else { 0.0 };
    PlanarTensor {
        mean: 0.5 * (kept_first + kept_second),
        stretch: planar.stretch * shrunk,
        shear: planar.shear * shrunk,
    }
}
