//! What sounds when a body is accelerated: the sphere of its volume, or a field of its own or of an
//! ellipsoid.
//!
//! A field is known outside its bounding sphere, of radius R about the centre of mass. The boundary integral
//! of [`near_field`](crate::sound_model::acceleration::near_field), where there is one, takes over between
//! 1.2 and 1.1 R. Without it, a listener in the bounding sphere hears the field on the sphere in its
//! direction, which is finite, continuous, and too quiet close to the surface. A listener inside the body
//! hears nothing, and is counted.

use std::sync::Arc;

use glam::{DQuat, DVec3};

use super::ground::Ground;
use crate::body::{Body, Surface};
use crate::medium::Medium;
use crate::reference::pan_sound::PanSource;
use crate::sound_model::acceleration::field_evaluator::FieldEvaluator;
use crate::sound_model::acceleration::near_field::NearField;
use crate::sound_model::acceleration::sphere_radiation::SphereTransfer;

/// Ringing of a sphere is followed until it has fallen by e^−23 = 1e-10.
const DECAY_FOLDS: f64 = 23.0;

/// What sounds in the place of a body.
#[derive(Clone, Debug, PartialEq)]
pub enum SoundSource {
    /// A sphere about the centre of mass, whose rotation radiates nothing.
    Sphere {
        /// Radius \[m\].
        radius: f64,
    },
    /// A field about the centre of mass.
    Field(Arc<FieldSource>),
    /// The published representation of one.
    Pan(Arc<PanSource>),
    /// Not a body that moves, but the ground that it hits, pressed at the centre of the click, y its normal.
    Ground {
        /// The ground.
        ground: Ground,
        /// Impulse into it [N s].
        impulse: f64,
    },
}

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

impl SoundSource {
    /// The sphere that has the volume of a body.
    pub fn equal_volume_sphere(surface: &Surface) -> Self {
        SoundSource::Sphere { radius: surface.equal_volume_radius() }
    }

    /// The spheres of all bodies, in their order.
    pub fn spheres(bodies: &[Body]) -> Vec<Self> {
        bodies.iter().map(|body| SoundSource::equal_volume_sphere(&body.surface)).collect()
    }

    /// Radius \[m\] about the centre of mass inside which all of the source is.
    pub fn radius(&self) -> f64 {
        match self {
            SoundSource::Sphere { radius } => *radius,
            SoundSource::Field(source) => source.radius,
            SoundSource::Pan(source) => source.model.radius(),
            SoundSource::Ground { .. } => 0.0,
        }
    }

    /// Time \[s\] in which it dies away after a sudden acceleration, from the passing of a wave from the
    /// centre of mass.
    pub fn ring_time(&self, medium: &Medium) -> f64 {
        match self {
            SoundSource::Sphere { radius } => SphereTransfer::decay_time(medium, *radius, DECAY_FOLDS),
            SoundSource::Field(source) => source.field.ring_time * source.radius / medium.sound_speed,
            SoundSource::Pan(source) => source.ring_time(medium),
            // How long the surface is heard depends on where.
            SoundSource::Ground { .. } => 0.0,
        }
    }

    /// Whether nothing is heard at a point \[m\] of the body frame.
    pub fn silent_at(&self, point_body: DVec3) -> bool {
        match self {
            SoundSource::Sphere { radius } => point_body.length() < *radius,
            SoundSource::Field(source) => source.contains(point_body),
            SoundSource::Pan(source) => source.contains(point_body),
            SoundSource::Ground { .. } => point_body.y <= 0.0,
        }
    }
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

    fn contains(&self, point_body: DVec3) -> bool {
        inside(&self.surface, self.bounding_radius, point_body)
    }
}

/// Whether a point \[m\] is in a body of this bounding radius \[m\].
pub(crate) fn inside(surface: &Surface, bounding_radius: f64, point_body: DVec3) -> bool {
    match surface {
        Surface::Sphere { radius } => point_body.length() < *radius,
        Surface::HalfSpace => point_body.y < 0.0,
        Surface::Mesh(mesh) => point_body.length() < bounding_radius && mesh.contains(point_body),
    }
}
