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

use super::contact_scale::{ContactScale, slope};
use super::corner_form::CornerForm;
use crate::body::Surface;
use crate::geometry::principal_curvature::outer;
use crate::geometry::sharp_place::SharpPlace;

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
    /// That of a surface at a point \[m\] where the contact has a unit `normal`, either way; edges are
    /// rounded with `edge_radius` \[m\], 0 for none. All in the frame of the body.
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
