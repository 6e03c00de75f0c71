//! Principal moments and axes of an inertia tensor, by cyclic Jacobi rotations.
//!
//! I = R diag(I₁, I₂, I₃) Rᵀ with I₁ ≤ I₂ ≤ I₃ and det R = +1, so that R is a rotation: angular quantities
//! are pseudovectors and a mirrored frame would flip them.

use glam::{DMat3, DVec3};

/// Moments I₁ ≤ I₂ ≤ I₃ and the rotation whose columns are their axes (principal frame to the frame of
/// `inertia`).
///
/// The largest component of the first two axes is positive, so that the frame does not flip from rounding;
/// axes of equal moments are an arbitrary but reproducible choice. Only the symmetric part of `inertia`
/// counts. A tensor that is not finite comes back as moments that are not finite.
pub fn principal_axes(inertia: DMat3) -> (DVec3, DMat3) {
    let mut a = (inertia + inertia.transpose()) * 0.5;
    let mut axes = DMat3::IDENTITY;
    // Convergence is quadratic: six sweeps reach rounding from any start; the rest is margin.
    for _ in 0..12 {
        let off = a.y_axis.x.abs() + a.z_axis.x.abs() + a.z_axis.y.abs();
        let scale = a.x_axis.x.abs() + a.y_axis.y.abs() + a.z_axis.z.abs();
        if off <= 1e-17 * scale || !off.is_finite() {
            break;
        }
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let apq = a.col(q)[p];
            if apq == 0.0 {
                continue;
            }
            let theta = (a.col(q)[q] - a.col(p)[p]) / (2.0 * apq);
            let sign = if theta < 0.0 { -1.0 } else { 1.0 };
            let t = sign / (theta.abs() + (theta * theta + 1.0).sqrt());
            let c = 1.0 / (t * t + 1.0).sqrt();
            let s = t * c;
            let mut rotation = DMat3::IDENTITY;
            rotation.col_mut(p)[p] = c;
            rotation.col_mut(q)[q] = c;
            rotation.col_mut(q)[p] = s;
            rotation.col_mut(p)[q] = -s;
            a = rotation.transpose() * a * rotation;
            a.col_mut(q)[p] = 0.0;
            a.col_mut(p)[q] = 0.0;
            axes *= rotation;
        }
    }
    let mut order = [0, 1, 2];
    order.sort_by(|i, j| a.col(*i)[*i].total_cmp(&a.col(*j)[*j]));
    let moments = DVec3::from_array(order.map(|i| a.col(i)[i]));
    let first = facing(axes.col(order[0]));
    let second = facing(axes.col(order[1]));
    (moments, DMat3::from_cols(first, second, first.cross(second)))
}

/// The axis or its opposite, whichever has its largest component positive.
fn facing(axis: DVec3) -> DVec3 {
    let largest =
        axis.to_array().into_iter().fold(0.0, |m: f64, x| if x.abs() > m.abs() + 1e-9 { x } else { m });
    if largest < 0.0 { -axis } else { axis }
}

#[cfg(test)]
mod tests {
    use glam::DQuat;

    use super::*;

    #[test]
    fn a_rotated_diagonal_tensor_comes_back() {
        let diagonal = DVec3::new(3.0, 1.0, 2.0);
        for k in 0..50 {
            let turn = DMat3::from_quat(DQuat::from_scaled_axis(DVec3::new(0.3, -0.7, 1.1) * k as f64));
            let tensor = turn * DMat3::from_diagonal(diagonal) * turn.transpose();
            let (moments, axes) = principal_axes(tensor);
            // Residuals seen: 1.4e-15.
            assert!((moments - DVec3::new(1.0, 2.0, 3.0)).length() < 1e-14);
            assert!((axes.determinant() - 1.0).abs() < 1e-14);
            let rebuilt = axes * DMat3::from_diagonal(moments) * axes.transpose();
            assert!((rebuilt - tensor).to_cols_array().iter().all(|x| x.abs() < 1e-14));
        }
    }

    #[test]
    fn equal_moments_and_zero_give_a_rotation() {
        for diagonal in [DVec3::ONE, DVec3::ZERO, DVec3::new(2.0, 1.0, 2.0)] {
            let (moments, axes) = principal_axes(DMat3::from_diagonal(diagonal));
            assert_eq!(moments.element_sum(), diagonal.element_sum());
            assert_eq!(axes.determinant(), 1.0);
        }
    }
}
