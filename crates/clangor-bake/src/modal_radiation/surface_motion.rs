//! The motion of a mode at the points of another mesh, and its volume flux.
//!
//! ```text
//! U(x) = Σ Uᵢ Nᵢ(L),    V̇ = ∮ U·n dS = ∫∫ U·(∂x/∂L₁ × ∂x/∂L₂) dL₁ dL₂
//! ```
//!
//! Nᵢ are the shape functions of the six nodes of a triangle, also for positions. A body of nearly constant
//! volume has a net flux near zero. On another mesh the interpolated motion may have a net flux of a
//! thousandth of the total, a spurious monopole. [`balance`] restores the exact flux.

use clangor_core::sound_model::modal::surface::{ModalSurface, SurfaceLocator, SurfacePoint, node_weights};
use glam::DVec3;
use rayon::prelude::*;

/// Corner weights and weights of a rule on the triangle of area ½, exact to degree 4. Source: Dunavant
/// (1985), Int. J. Numer. Meth. Eng. 21, 1129.
const RULE: [([f64; 3], f64); 6] = {
    const A: f64 = 0.445_948_490_915_965;
    const B: f64 = 0.091_576_213_509_771;
    const W: f64 = 0.5 * 0.223_381_589_678_011;
    const V: f64 = 0.5 * 0.109_951_743_655_322;
    [
        ([A, A, 1.0 - 2.0 * A], W),
        ([A, 1.0 - 2.0 * A, A], W),
        ([1.0 - 2.0 * A, A, A], W),
        ([B, B, 1.0 - 2.0 * B], V),
        ([B, 1.0 - 2.0 * B, B], V),
        ([1.0 - 2.0 * B, B, B], V),
    ]
};

/// Locates points on a surface once, for the shapes of any number of modes.
#[derive(Clone, Debug)]
pub struct MotionSampler {
    places: Vec<SurfacePoint>,
}

impl MotionSampler {
    /// For points on or near the surface \[m\]; each takes the motion of the nearest point. `None` for an
    /// empty surface.
    pub fn new(surface: &ModalSurface, points: &[DVec3]) -> Option<Self> {
        let locator = SurfaceLocator::new(surface);
        let places = points.par_iter().map(|x| locator.nearest(*x)).collect::<Option<Vec<_>>>()?;
        Some(MotionSampler { places })
    }

    /// U at the points.
    pub fn motions(&self, shape: &[DVec3]) -> Vec<DVec3> {
        self.places.iter().map(|place| place.interpolate(shape)).collect()
    }

    /// Largest distance of a point from the surface \[m\].
    pub fn farthest(&self) -> f64 {
        self.places.iter().map(|place| place.distance).fold(0.0, f64::max)
    }
}

/// ∮ U·n dS, exact for triangles of six nodes; in units of the shape's times m².
pub fn volume_flux(surface: &ModalSurface, shape: &[DVec3]) -> f64 {
    let at_triangle = |nodes: &[u32; 6]| {
        let x = nodes.map(|n| surface.nodes[n as usize]);
        RULE.iter()
            .map(|(corners, weight)| {
                let motions = nodes.iter().zip(node_weights(*corners));
                let motion: DVec3 = motions.map(|(n, w)| shape[*n as usize] * w).sum();
                let [u, v] = tangents(&x, *corners);
                motion.dot(u.cross(v)) * weight
            })
            .sum::<f64>()
    };
    surface.triangles.iter().map(at_triangle).sum()
}

/// Shifts normal motions uniformly, so that their flux is `flux`; `areas` \[m²\] sum to the surface.
pub fn balance(motions: &mut [f64], areas: &[f64], flux: f64) {
    let found: f64 = motions.iter().zip(areas).map(|(u, a)| u * a).sum();
    let area: f64 = areas.iter().sum();
    let excess = (found - flux) / area;
    motions.iter_mut().for_each(|u| *u -= excess);
}

/// ∂x/∂L₁ and ∂x/∂L₂ with L₀ = 1 − L₁ − L₂.
fn tangents(x: &[DVec3; 6], [a, b, c]: [f64; 3]) -> [DVec3; 2] {
    let by_a = x[0] * (4.0 * a - 1.0) + x[3] * (4.0 * b) + x[5] * (4.0 * c);
    let by_b = x[1] * (4.0 * b - 1.0) + x[3] * (4.0 * a) + x[4] * (4.0 * c);
    let by_c = x[2] * (4.0 * c - 1.0) + x[4] * (4.0 * b) + x[5] * (4.0 * a);
    [by_b - by_a, by_c - by_a]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::tetrahedra::ball::ellipsoid;

    #[test]
    fn fluxes_are_those_of_the_divergence() {
        let mesh = ellipsoid(DVec3::new(1.0, 0.8, 0.6), 3).expect("a mesh");
        let surface = ModalSurface { nodes: mesh.nodes.clone(), triangles: mesh.surface() };
        let volume = mesh.quality().volume;
        // Linear motions satisfy div U times the volume exactly. Residual seen: 1e-15.
        let stretch: Vec<DVec3> = mesh.nodes.iter().map(|x| *x * DVec3::new(2.0, -0.5, 1.0)).collect();
        assert!((volume_flux(&surface, &stretch) / (2.5 * volume) - 1.0).abs() < 1e-12);
        let turn: Vec<DVec3> = mesh.nodes.iter().map(|x| DVec3::new(0.3, 0.5, -0.2).cross(*x)).collect();
        assert!(volume_flux(&surface, &turn).abs() < 1e-14);
        let corners = surface.triangles[..20].iter().map(|t| t[0] as usize);
        let points: Vec<DVec3> = corners.clone().map(|n| mesh.nodes[n]).collect();
        let sampler = MotionSampler::new(&surface, &points).expect("places");
        let moved = sampler.motions(&stretch);
        // Residual seen: 3e-16.
        assert!(moved.iter().zip(corners).all(|(u, n)| (*u - stretch[n]).length() < 1e-12));
        let mut motions: Vec<f64> = moved.iter().map(|u| u.x).collect();
        let areas: Vec<f64> = (0..20).map(|k| 1.0 + f64::from(k)).collect();
        balance(&mut motions, &areas, 3.0);
        let flux: f64 = motions.iter().zip(&areas).map(|(u, a)| u * a).sum();
        // Residual seen: 3e-14, of numbers of the size of 200.
        assert!((flux - 3.0).abs() < 1e-11);
        assert!(MotionSampler::new(&ModalSurface::default(), &points).is_none());
    }
}
