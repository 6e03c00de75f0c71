//! The [`pan_representation`](super::pan_representation) of a body, as a source of clicks.

use std::sync::Arc;

use glam::DVec3;

use crate::body::Surface;
use crate::medium::Medium;
use crate::reference::pan_representation::PanModel;
use crate::synthesis::body_interior::inside;

/// A \[PAN\] model with the size of its body.
#[derive(Clone, Debug, PartialEq)]
pub struct PanSource {
    /// The signals; bodies of the same shape share them.
    pub model: Arc<PanModel>,
    /// The body, inside which receivers get no pressure.
    pub surface: Arc<Surface>,
    /// Bounding radius of the body \[m\].
    bounding_radius: f64,
}

impl PanSource {
    /// A model for a body with this surface.
    pub fn new(model: Arc<PanModel>, surface: Arc<Surface>) -> Self {
        let bounding_radius = surface.bounding_radius();
        PanSource { model, surface, bounding_radius }
    }

    /// Time \[s\] for which the longest signal continues after the passing of a wave from the centre of mass.
    pub(crate) fn ring_time(&self, medium: &Medium) -> f64 {
        let ends = self.model.fields().iter().map(|f| f.start + f.step * f.length as f64);
        ends.fold(0.0, f64::max) * self.model.radius() / medium.sound_speed
    }

    /// Whether a point \[m\] of the body frame is in the body.
    pub(crate) fn contains(&self, point_body: DVec3) -> bool {
        inside(&self.surface, self.bounding_radius, point_body)
    }
}
