//! The form of a surface where it is touched, as a curvature at the scale of the contact.
//!
//! A smooth surface has a curvature tensor. A crease or a corner has faces that fall away from the tangent
//! plane of the contact with slopes s, rounded with the edge radius ρ. The surface is lower than the tangent
//! plane by d at the distance
//!
//! ```text
//! w = √(2 ρ d)        for d ≤ ρ s²/2: the contact lies on the rounding
//! w = d/s + ρ s/2     beyond: it reaches the face
//! w ≤ L               the reach of the contact
//! ```
//!
//! and the curvature of the paraboloid that is as wide at the approach d is 2 d/w². Across a crease w is the
//! mean of both directions; along it the curvature is −b·n, with the curvature vector b of the crease and the
//! outward normal n: the rim of a disc of radius r that is tilted by θ has the radius r/sin θ there. A corner
//! ([`corner_form`](super::corner_form)) has w in every direction.
//!
//! A body that lands flat so has a contact as wide as its face, and one that lands on an edge that of the
//! edge, whatever the triangles of its mesh.
//!
//! Source: the paraboloid of equal width is our own; it is exact for a smooth body (2 d/w² = 1/R), and its
//! force on a wedge or a cone is within a small factor of the exact one. Not covered: the shape of the force
//! over the approach, which stays d^{3/2}; hollow edges.

use glam::{DMat3, DVec3};

use super::corner_form::CornerForm;
use crate::body::Surface;
use crate::geometry::principal_curvature::outer;
use crate::geometry::sharp_place::SharpPlace;

/// How far a contact goes: its largest approach, and its largest half width.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ContactScale {
    /// d \[m\].
    pub(super) approach: f64,
    /// L \[m\].
    pub(super) reach: f64,
}

/// The form of the surface of a body at a point, in the tangent plane of a contact.
#[derive(Clone, Debug)]
pub(super) enum TouchedForm {
    /// With this curvature tensor [1/m].
    Smooth(DMat3),
    /// An edge.
    Crease {
        /// Unit vectors along and across it.
        axes: [DVec3; 2],
        /// Curvature along it [1/m].
        curvature: f64,
        /// Slopes of the faces on both sides, across it.
        slopes: [f64; 2],
        /// Its rounding ρ \[m\].
        rounding: f64,
    },
    /// A point of several faces.
    Corner(CornerForm),
}

impl TouchedForm {
    /// That of a surface at a point \[m\] where the contact has a unit `normal`, either way; edges are rounded
    /// with `edge_radius` \[m\], 0 for none. All in the frame of the body.
    pub(super) fn of_surface(surface: &Surface, point: DVec3, normal: DVec3, edge_radius: f64) -> Self {
        let sharp = (edge_radius > 0.0).then(|| surface.sharp_place_at(point, edge_radius)).flatten();
        let outward = |faces: &[DVec3]| normal * faces.iter().sum::<DVec3>().dot(normal).signum();
        match sharp {
            Some(SharpPlace::Crease { tangent, bend, faces }) => {
                let normal = outward(&faces);
                let along =
                    tangent.reject_from_normalized(normal).normalize_or(normal.any_orthonormal_vector());
                let across = normal.cross(along);
                TouchedForm::Crease {
                    axes: [along, across],
                    curvature: -bend.dot(normal),
                    slopes: [across, -across].map(|direction| slope(&faces, normal, direction)),
                    rounding: edge_radius,
                }
            }
            Some(SharpPlace::Corner { faces }) => {
                TouchedForm::Corner(CornerForm::new(&faces, outward(&faces), edge_radius))
            }
            None => TouchedForm::Smooth(surface.curvature_at(point).tensor(normal)),
        }
    }

    /// Curvature tensor [1/m] in the tangent plane of a contact of this scale; without one, of the lightest
    /// contact.
    pub(super) fn tensor(&self, scale: Option<ContactScale>) -> DMat3 {
        match self {
            TouchedForm::Smooth(tensor) => *tensor,
            TouchedForm::Crease { axes: [along, across], curvature, slopes, rounding } => {
                let wide = scale.map_or(rounding.recip(), |scale| {
                    let [one, other] = slopes.map(|slope| scale.width(slope, *rounding));
                    2.0 * scale.approach / (0.5 * (one + other)).powi(2)
                });
                *curvature * outer(*along, *along) + wide * outer(*across, *across)
            }
            TouchedForm::Corner(corner) => corner.tensor(scale),
        }
    }
}

/// Slope, at least 0 and infinite where it is upright, with which the steepest of the faces falls away from
/// the tangent plane along a direction in it.
pub(super) fn slope(faces: &[DVec3], normal: DVec3, direction: DVec3) -> f64 {
    faces.iter().fold(0.0, |steepest, face| {
        let (along, upward) = (face.dot(direction), face.dot(normal));
        match along > 0.0 {
            true if upward > 0.0 => f64::max(steepest, along / upward),
            true => f64::INFINITY,
            false => steepest,
        }
    })
}

impl ContactScale {
    /// Distance w \[m\] at which a face of some slope, whose edge has a rounding ρ \[m\], is lower than the
    /// tangent plane by the approach.
    pub(super) fn width(self, slope: f64, rounding: f64) -> f64 {
        let ContactScale { approach, reach } = self;
        let free = if approach <= 0.5 * rounding * slope * slope {
            (2.0 * rounding * approach).sqrt()
        } else {
            approach / slope + 0.5 * rounding * slope
        };
        free.min(reach)
    }

    /// 2 d/L² [1/m]: the relative curvature of a contact as wide as its reach.
    pub(super) fn least_curvature(self) -> f64 {
        2.0 * self.approach / (self.reach * self.reach)
    }
}
