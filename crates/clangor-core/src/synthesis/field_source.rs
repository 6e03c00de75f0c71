//! A radiated field in the place of a body: its own, or that of an ellipsoid.
//!
//! A field is known outside its bounding sphere, of radius R about the centre of mass. The boundary integral
//! of [`near_field`](crate::sound_model::acceleration::near_field), where there is one, takes over between
//! 1.2 and 1.1 R. Without it, a receiver in the bounding sphere gets the field on the sphere in its
//! direction, which is finite, continuous, and too quiet close to the surface.

use std::sync::Arc;

use glam::{DQuat, DVec3};

use super::body_interior::inside;
use crate::body::Surface;
use crate::sound_model::acceleration::field_evaluator::FieldEvaluator;
use crate::sound_model::acceleration::near_field::NearField;

/// A field as a body uses it.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldSource {
    /// The field; bodies of the same shape share it.
    pub field: Arc<FieldEvaluator>,
    /// What takes over near the body.
    pub near: Option<Arc<NearField>>,
    /// Its unit of length R \[m\]: the bounding radius of the body, or of its proxy.
    pub radius: f64,
    /// Rotation from the axes of the field to those of the body.
    pub body_from_field: DQuat,
    /// The body, where no listener hears anything.
    pub surface: Arc<Surface>,
    /// Bounding radius of the body \[m\].
    bounding_radius: f64,
}

impl FieldSource {
    /// A field of unit length `radius` R \[m\], turned by `body_from_field`, for a body with this surface.
    pub fn new(
        field: Arc<FieldEvaluator>,
        near: Option<Arc<NearField>>,
        radius: f64,
        body_from_field: DQuat,
        surface: Arc<Surface>,
    ) -> Self {
        let bounding_radius = surface.bounding_radius();
        FieldSource { field, near, radius, body_from_field, surface, bounding_radius }
    }

    /// Highest frequency \[Hz\] at which the field is known, in a medium of this speed of sound [m/s].
    pub fn max_frequency(&self, sound_speed: f64) -> f64 {
        self.field.max_wavenumber * sound_speed / (std::f64::consts::TAU * self.radius)
    }

    /// Whether a point \[m\] of the body frame is in the body.
    pub(super) fn contains(&self, point_body: DVec3) -> bool {
        inside(&self.surface, self.bounding_radius, point_body)
    }
}
