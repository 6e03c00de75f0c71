//! Normal motion of a surface: the mean over its area of the square of U·n.

use clangor_core::sound_model::modal::surface::ModalSurface;
use glam::DVec3;

/// A surface as flat triangles between its nodes.
pub(super) struct NormalMotion {
    /// Nodes, unit normal and area \[m²\] of each.
    triangles: Vec<([usize; 3], DVec3, f64)>,
    /// Area of all \[m²\].
    pub(super) area: f64,
}

impl NormalMotion {
    pub(super) fn new(surface: &ModalSurface) -> Self {
        let mesh = surface.quarters();
        let triangles: Vec<_> = (0..mesh.triangles.len())
            .map(|t| {
                let vector = mesh.area_vector(t);
                (mesh.triangles[t].map(|node| node as usize), vector.normalize_or_zero(), vector.length())
            })
            .collect();
        let area = triangles.iter().map(|t| t.2).sum();
        NormalMotion { triangles, area }
    }

    /// ⟨(U·n)²⟩ of a shape [1/kg].
    pub(super) fn mean_square(&self, shape: &[DVec3]) -> f64 {
        let part = |(nodes, normal, area): &([usize; 3], DVec3, f64)| {
            let [a, b, c] = nodes.map(|node| shape[node].dot(*normal));
            area * (a * a + b * b + c * c + a * b + b * c + c * a) / 6.0
        };
        self.triangles.iter().map(part).sum::<f64>() / self.area
    }
}
