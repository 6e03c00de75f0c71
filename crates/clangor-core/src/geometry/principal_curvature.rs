//! Principal curvatures and directions at a point of a surface.
//!
//! The curvature tensor is the gradient of the outward unit normal along the surface: symmetric, with the
//! eigenvalues κ₁ ≥ κ₂ along two perpendicular tangents. [`vertex_curvature`](super::vertex_curvature) finds
//! it on meshes.

use glam::{DMat3, DVec3};

/// Principal curvatures at a point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Curvature {
    /// κ₁ ≥ κ₂ [1/m], positive where convex: a sphere has 1/R, a cylinder 1/R and 0.
    pub principal: [f64; 2],
    /// Unit vector tangential to the surface along which the curvature is κ₁; any direction where κ₁ = κ₂.
    pub direction: DVec3,
}

impl Curvature {
    /// Of a plane.
    pub const FLAT: Curvature = Curvature { principal: [0.0; 2], direction: DVec3::X };

    /// The same curvature [1/m] in all directions.
    pub fn isotropic(curvature: f64) -> Self {
        Curvature { principal: [curvature; 2], ..Curvature::FLAT }
    }

    /// That of a symmetric tensor [1/m] within the plane normal to the unit vector `normal`.
    pub fn of_tensor(tensor: DMat3, normal: DVec3) -> Self {
        let (u, v) = normal.any_orthonormal_pair();
        let planar = PlanarTensor::of_tensor(tensor, [u, v]);
        // Half the angle of the anisotropic part.
        let (sin, cos) = (0.5 * planar.shear.atan2(planar.stretch)).sin_cos();
        Curvature { principal: planar.principal(), direction: (u * cos + v * sin).normalize_or(u) }
    }

    /// Mean curvature (κ₁ + κ₂)/2 [1/m].
    pub fn mean(&self) -> f64 {
        0.5 * (self.principal[0] + self.principal[1])
    }

    /// The curvature tensor [1/m] in the plane normal to the unit vector `normal`, which need not be exactly
    /// that of the surface: the direction of κ₁ is projected.
    pub fn tensor(&self, normal: DVec3) -> DMat3 {
        let [first, second] = self.principal;
        let projected = self.direction.reject_from_normalized(normal);
        let along = projected.try_normalize().unwrap_or_else(|| normal.any_orthonormal_vector());
        second * (DMat3::IDENTITY - outer(normal, normal)) + (first - second) * outer(along, along)
    }

    /// With all lengths multiplied by `factor`.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        Curvature { principal: self.principal.map(|curvature| curvature / factor), ..self }
    }
}

/// A symmetric tensor in a plane: mean·I + [[stretch, shear], [shear, −stretch]].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PlanarTensor {
    pub(crate) mean: f64,
    pub(crate) stretch: f64,
    pub(crate) shear: f64,
}

impl PlanarTensor {
    /// The part of a symmetric tensor within the plane of two orthonormal vectors.
    pub(crate) fn of_tensor(tensor: DMat3, [u, v]: [DVec3; 2]) -> Self {
        let (along_u, along_v) = (tensor * u, tensor * v);
        let (uu, uv, vv) = (u.dot(along_u), u.dot(along_v), v.dot(along_v));
        PlanarTensor { mean: 0.5 * (uu + vv), stretch: 0.5 * (uu - vv), shear: uv }
    }

    /// Eigenvalues, the larger first.
    pub(crate) fn principal(&self) -> [f64; 2] {
        let deviation = self.stretch.hypot(self.shear);
        [self.mean + deviation, self.mean - deviation]
    }
}

/// a bᵀ.
pub(crate) fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}
