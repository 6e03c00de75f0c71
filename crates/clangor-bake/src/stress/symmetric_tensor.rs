//! Symmetric 3 × 3 tensors: stresses and their principal values.
//!
//! ```text
//! λ₁ = q + 2 p cos(⅓ arccos(det(σ − q)/(2 p³))),    q = tr σ/3,    6 p² = |σ − q|²
//! ```
//!
//! The largest principal stress has this closed form (Smith 1961, "Eigenvalues of a symmetric 3 × 3 matrix").
//! Directions come from Jacobi rotations, which also handle equal principal stresses.

use std::ops::{Add, AddAssign, Mul};

use clangor_core::geometry::principal_axes::principal_axes;
use glam::{DMat3, DVec3};

/// A symmetric tensor; a stress has unit \[Pa\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SymmetricTensor {
    /// xx, yy, zz.
    pub diagonal: DVec3,
    /// yz, xz, xy.
    pub off_diagonal: DVec3,
}

impl SymmetricTensor {
    /// Zero stress.
    pub const ZERO: Self = SymmetricTensor { diagonal: DVec3::ZERO, off_diagonal: DVec3::ZERO };

    /// The symmetric part of a matrix.
    pub fn of(matrix: DMat3) -> Self {
        let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
        SymmetricTensor {
            diagonal: DVec3::new(x.x, y.y, z.z),
            off_diagonal: 0.5 * DVec3::new(y.z + z.y, x.z + z.x, x.y + y.x),
        }
    }

    /// xx, yy, zz, yz, xz, xy.
    pub fn to_array(self) -> [f64; 6] {
        let (d, o) = (self.diagonal, self.off_diagonal);
        [d.x, d.y, d.z, o.x, o.y, o.z]
    }

    /// From xx, yy, zz, yz, xz, xy.
    pub fn from_array([xx, yy, zz, yz, xz, xy]: [f64; 6]) -> Self {
        SymmetricTensor { diagonal: DVec3::new(xx, yy, zz), off_diagonal: DVec3::new(yz, xz, xy) }
    }

    /// As a matrix.
    pub fn matrix(self) -> DMat3 {
        let (d, o) = (self.diagonal, self.off_diagonal);
        DMat3::from_cols(DVec3::new(d.x, o.z, o.y), DVec3::new(o.z, d.y, o.x), DVec3::new(o.y, o.x, d.z))
    }

    /// σ n: of a stress, the traction on a surface with normal n \[Pa\].
    pub fn on(self, normal: DVec3) -> DVec3 {
        self.matrix() * normal
    }

    /// Sum of the diagonal.
    pub fn trace(self) -> f64 {
        self.diagonal.element_sum()
    }

    /// σ : τ, the sum of the products of all nine entries.
    pub fn contract(self, other: Self) -> f64 {
        self.diagonal.dot(other.diagonal) + 2.0 * self.off_diagonal.dot(other.off_diagonal)
    }

    /// The largest principal value, to 1e-8 of the tensor.
    pub fn largest(self) -> f64 {
        let mean = self.trace() / 3.0;
        let d = self.diagonal - mean;
        let o = self.off_diagonal;
        let spread = ((d.length_squared() + 2.0 * o.length_squared()) / 6.0).sqrt();
        if spread == 0.0 {
            return mean;
        }
        let d = d / spread;
        let o = o / spread;
        let determinant =
            d.x * (d.y * d.z - o.x * o.x) - o.z * (o.z * d.z - o.x * o.y) + o.y * (o.z * o.x - d.y * o.y);
        mean + 2.0 * spread * ((0.5 * determinant).clamp(-1.0, 1.0).acos() / 3.0).cos()
    }

    /// A quick upper bound of the largest principal value.
    pub(super) fn most_largest(self) -> f64 {
        let mean = self.trace() / 3.0;
        let square = (self.diagonal - mean).length_squared() + 2.0 * self.off_diagonal.length_squared();
        // The largest of three values of sum zero is at most √(2/3) of the root of the sum of their squares.
        mean + (2.0 / 3.0 * square).sqrt() * (1.0 + 1e-12)
    }

    /// The largest principal value and its direction, a unit vector whose largest component is positive.
    pub fn largest_with_direction(self) -> (f64, DVec3) {
        // The sign of the third axis of a rotation is determined by the other two.
        let (values, axes) = principal_axes(self.matrix());
        let axis = axes.z_axis;
        (values.z, if axis[axis.abs().max_position()] < 0.0 { -axis } else { axis })
    }

    /// The principal values, ascending, and the rotation whose columns are their directions.
    pub fn principal(self) -> (DVec3, DMat3) {
        principal_axes(self.matrix())
    }
}

impl Add for SymmetricTensor {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        SymmetricTensor {
            diagonal: self.diagonal + other.diagonal,
            off_diagonal: self.off_diagonal + other.off_diagonal,
        }
    }
}

impl AddAssign for SymmetricTensor {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Mul<f64> for SymmetricTensor {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        SymmetricTensor { diagonal: self.diagonal * factor, off_diagonal: self.off_diagonal * factor }
    }
}
