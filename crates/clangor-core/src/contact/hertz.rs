//! Duration of a collision by Hertz's theory of elastic contact.
//!
//! ```text
//! τ = 2.87 (m² / (r E*² V))^{1/5}      1/m = 1/m₁ + 1/m₂     1/r = 1/r₁ + 1/r₂     1/E* = Σ (1 − νᵢ²)/Eᵢ
//! ```
//!
//! \[PAN\] eqs. (7) and (8). Only the sum of the two curvatures counts: a ball in a bowl has 1/r₁ − 1/|r₂| >
//! 0 and is ordinary Hertz contact. Two limits keep τ physical where the local sphere is not:
//! * an edge or vertex of a mesh has a curvature of the order of 1/(triangle size), so each body's radius is
//!   at least its [`edge_radius`](crate::body::Body::edge_radius);
//! * flat on flat has no curvature at all, so the combined radius is at most the size of the smaller body.
//!
//! Not covered: plastic deformation, adhesion, and the flat punch.

/// Input of Hertz's formula for one collision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HertzContact {
    /// Combined inverse effective mass 1/m [1/kg].
    pub inverse_mass: f64,
    /// Combined curvature 1/r [1/m].
    pub curvature: f64,
    /// Combined compliance 1/E* [1/Pa].
    pub compliance: f64,
    /// Approach speed V along the normal [m/s].
    pub speed: f64,
}

impl HertzContact {
    /// Duration τ \[s\]. All four numbers must be positive and finite.
    pub fn duration(&self) -> f64 {
        let HertzContact { inverse_mass, curvature, compliance, speed } = *self;
        2.87 * (curvature * compliance * compliance / (inverse_mass * inverse_mass * speed)).powf(0.2)
    }
}

/// Combined curvature 1/r [1/m] of two surfaces.
///
/// * `curvatures`: mean curvature of each surface at the contact [1/m], 0 for a plane, negative where hollow.
/// * `edge_radii`: lower bound of each surface's radius of curvature \[m\], 0 for none.
/// * `size`: upper bound of the combined radius \[m\], the size of the smaller body; infinite for none.
pub fn combined_curvature(curvatures: [f64; 2], edge_radii: [f64; 2], size: f64) -> f64 {
    let bounded = |i: usize| curvatures[i].min(1.0 / edge_radii[i]);
    (bounded(0) + bounded(1)).max(1.0 / size)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curvatures_add_and_stay_between_the_bounds() {
        let ball_in_bowl = combined_curvature([100.0, -20.0], [1e-4, 1e-3], 0.01);
        assert_eq!(ball_in_bowl, 100.0);
        assert_eq!(combined_curvature([200.0, -20.0], [1e-4, 1e-3], 0.01), 180.0);
        assert_eq!(combined_curvature([1e7, 0.0], [1e-3, 0.0], f64::INFINITY), 1000.0);
        assert_eq!(combined_curvature([0.0, 0.0], [0.0, 0.0], 0.5), 2.0);
    }
}
