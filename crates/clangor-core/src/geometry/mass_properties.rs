//! Mass, centre of mass and inertia of a solid bounded by a closed surface.
//!
//! The integrals of 1, x and x xᵀ over the tetrahedra between a reference point and each triangle, summed
//! with sign; they are exact for a polyhedron. The reference is the middle of the bounding box, so that a
//! body far from the origin loses nothing but the digits that its coordinates have lost already.

use glam::{DMat3, DVec3};

use super::mesh_error::MeshError;
use super::tri_mesh::TriMesh;

/// Mass properties of a solid of unit density.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MassProperties {
    /// Volume \[m³\].
    pub volume: f64,
    /// Centre of mass \[m\].
    pub centre_of_mass: DVec3,
    /// Inertia tensor about the centre of mass, per unit density \[m⁵\].
    pub inertia: DMat3,
}

impl MassProperties {
    /// Those of a sphere about the origin.
    pub fn of_sphere(radius: f64) -> Self {
        let volume = 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
        let inertia = DMat3::from_diagonal(DVec3::splat(0.4 * volume * radius * radius));
        MassProperties { volume, centre_of_mass: DVec3::ZERO, inertia }
    }

    /// Those of the same solid with all lengths multiplied by `factor`.
    pub fn scaled(&self, factor: f64) -> Self {
        MassProperties {
            volume: self.volume * factor.powi(3),
            centre_of_mass: self.centre_of_mass * factor,
            inertia: self.inertia * factor.powi(5),
        }
    }

    /// Integrates over the solid that a closed surface bounds; whether it is closed, see
    /// [`check_solid`](super::solid::check_solid).
    ///
    /// # Errors
    /// No triangles, an index out of range, a coordinate that is not finite, or a volume that is zero or
    /// negative.
    pub fn of(mesh: &TriMesh) -> Result<Self, MeshError> {
        super::mesh_error::check_numbers(mesh)?;
        let (low, high) = mesh.bounds();
        let reference = low + 0.5 * (high - low);
        let mut volume = 0.0;
        let mut first = DVec3::ZERO;
        let mut second = DMat3::ZERO;
        for t in 0..mesh.triangles.len() {
            let [a, b, c] = mesh.corners(t).map(|v| v - reference);
            let v = a.dot(b.cross(c)) / 6.0;
            let sum = a + b + c;
            volume += v;
            first += v / 4.0 * sum;
            // ∫ x xᵀ over a tetrahedron with one corner at the origin: V/20 (Σ vᵢvᵢᵀ + s sᵀ), s = Σ vᵢ.
            second += (outer(a) + outer(b) + outer(c) + outer(sum)) * (v / 20.0);
        }
        let size = (high - low).max_element();
        if volume.abs() <= 1e-12 * size.powi(3) {
            return Err(MeshError::NoVolume { volume });
        }
        if volume < 0.0 {
            return Err(MeshError::Inverted { volume, position: reference });
        }
        let centre = first / volume;
        let central = second - outer(centre) * volume;
        let trace = central.x_axis.x + central.y_axis.y + central.z_axis.z;
        let inertia = DMat3::from_diagonal(DVec3::splat(trace)) - central;
        Ok(MassProperties { volume, centre_of_mass: reference + centre, inertia })
    }
}

/// v vᵀ.
fn outer(v: DVec3) -> DMat3 {
    DMat3::from_cols(v * v.x, v * v.y, v * v.z)
}
