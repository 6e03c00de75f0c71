//! A radiated field as the source of a body: its own field, or that of an ellipsoid.
//!
//! A field is known outside its bounding sphere, of radius R about the centre of mass. If there is a boundary
//! integral ([`near_field`](crate::sound_model::acceleration::near_field)), the pressure goes over to it
//! between 1.2 and 1.1 R. Otherwise a receiver in the bounding sphere gets the field on the sphere in its
//! direction. That pressure is finite and continuous, and too low close to the surface.

use std::sync::Arc;

use glam::{DQuat, DVec3};

use super::body_interior::inside;
use crate::body::Surface;
use crate::sound_model::acceleration::field_evaluator::FieldEvaluator;
use crate::sound_model::acceleration::near_field::NearField;

/// A field with its size and orientation on a body.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldSource {
    /// The field; bodies of the same shape share it.
    pub field: Arc<FieldEvaluator>,
    /// The field near the body, if known.
    pub near: Option<Arc<NearField>>,
    /// Its unit of length R \[m\]: the bounding radius of the body, or of its proxy.
    pub radius: f64,
    /// Rotation from the axes of the field to those of the body.
    pub body_from_field: DQuat,
    /// The body, inside which receivers get no pressure.
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
