//! The contact of a corner: where several faces meet.
//!
//! In each direction of the tangent plane the steepest of the faces limits the contact to a half width w
//! ([`touched_form`](super::touched_form)). The star of these half widths has an area A and second moments M
//! about its centroid, which are those of an ellipse with
//!
//! ```text
//! a aᵀ = 4 M/A
//! ```
//!
//! as squares of its half axes, and the paraboloid that is lower than the tangent plane by d on that ellipse
//! has the curvature tensor 2 d (4 M/A)⁻¹. Directions lie closer together around those in which two faces
//! meet: along an edge that lies in the tangent plane the star is a narrow strip.

use std::f64::consts::TAU;

use glam::{DMat2, DMat3, DVec2, DVec3};

use super::contact_scale::{ContactScale, slope};
use crate::geometry::principal_curvature::outer;

/// A corner in the tangent plane of a contact.
#[derive(Clone, Debug)]
pub(super) struct CornerForm {
    /// Orthonormal vectors in the tangent plane.
    plane: [DVec3; 2],
    /// Directions in it, by angle, each with the slope of the faces.
    directions: Vec<(DVec2, f64)>,
    /// Rounding ρ of its edges \[m\].
    rounding: f64,
}

/// Directions all around, and those on each side of the line in which two faces meet, each at half the angle
/// of the one before.
const DIRECTIONS: usize = 64;
const CLOSER: i32 = 10;
/// Largest excess of the slope along the line of two faces over that of all faces: above, the line is not an
/// edge of the corner.
const ON_EDGE: f64 = 1e-9;

/// Most faces of a corner: more, as of a cone, differ little.
const MOST_FACES: usize = 16;
/// Least cosine between the normals of triangles of one face: 6°.
const ONE_FACE: f64 = 0.9945;

impl CornerForm {
    /// Of faces with these outward unit normals, in their order around the corner, at a contact with the
    /// outward unit `normal`; its edges have a rounding \[m\].
    pub(super) fn new(faces: &[DVec3], normal: DVec3, rounding: f64) -> Self {
        let (u, v) = normal.any_orthonormal_pair();
        let mut angles: Vec<f64> = (0..DIRECTIONS).map(|i| TAU * i as f64 / DIRECTIONS as f64).collect();
        let at = |angle: f64| u * angle.cos() + v * angle.sin();
        let faces = &distinct(faces)[..];
        for (index, one) in faces.iter().enumerate() {
            let other = faces[(index + 1) % faces.len()];
            let line = one.cross(other);
            for line in [line, -line] {
                let angle = line.dot(v).atan2(line.dot(u));
                let along = slope(&[*one, other], normal, at(angle));
                if slope(faces, normal, at(angle)) <= along + ON_EDGE {
                    let closer = (0..CLOSER).map(|k| TAU / DIRECTIONS as f64 * 0.5_f64.powi(k));
                    angles.push(angle.rem_euclid(TAU));
                    angles.extend(
                        closer.flat_map(|step| [angle - step, angle + step]).map(|a| a.rem_euclid(TAU)),
                    );
                }
            }
        }
        angles.sort_unstable_by(f64::total_cmp);
        angles.dedup();
        let directions = angles
            .into_iter()
            .map(|angle| (DVec2::from_angle(angle), slope(faces, normal, at(angle))))
            .collect();
        CornerForm { plane: [u, v], directions, rounding }
    }

    /// Curvature tensor [1/m] of a contact of this scale; without one, of the lightest contact.
    pub(super) fn tensor(&self, scale: Option<ContactScale>) -> DMat3 {
        let planar = scale
            .and_then(|scale| self.of_star(scale))
            .unwrap_or(DMat2::from_diagonal(DVec2::splat(self.rounding.recip())));
        let [u, v] = self.plane;
        planar.x_axis.x * outer(u, u)
            + planar.x_axis.y * (outer(u, v) + outer(v, u))
            + planar.y_axis.y * outer(v, v)
    }

    /// 2 d (4 M/A)⁻¹ of the star of half widths; `None` where it has no area.
    fn of_star(&self, scale: ContactScale) -> Option<DMat2> {
        let tip = |(direction, slope): &(DVec2, f64)| *direction * scale.width(*slope, self.rounding);
        // Area, first and second moments about the contact, triangle by triangle.
        let (mut area, mut first, mut second) = (0.0, DVec2::ZERO, DMat2::ZERO);
        let mut a = tip(self.directions.last()?);
        for direction in &self.directions {
            let b = tip(direction);
            let triangle = 0.5 * a.perp_dot(b);
            let sum = a + b;
            area += triangle;
            first += triangle / 3.0 * sum;
            second += (square(a) + square(b) + square(sum)) * (triangle / 12.0);
            a = b;
        }
        let central = (second - square(first) * area.recip()) * (4.0 / area);
        let inverse = central.inverse() * (2.0 * scale.approach);
        inverse.is_finite().then_some(inverse)
    }
}

/// The faces without those that hardly differ from another one, as the triangles of one face.
fn distinct(faces: &[DVec3]) -> Vec<DVec3> {
    let mut kept: Vec<DVec3> = Vec::with_capacity(faces.len());
    for face in faces {
        if kept.len() < MOST_FACES && kept.iter().all(|other| other.dot(*face) < ONE_FACE) {
            kept.push(*face);
        }
    }
    kept
}

/// a aᵀ.
fn square(a: DVec2) -> DMat2 {
    DMat2::from_cols(a * a.x, a * a.y)
}
