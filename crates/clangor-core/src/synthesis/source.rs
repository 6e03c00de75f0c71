//! Sources: what radiates when a body is accelerated or the ground is struck.
//!
//! A source is data: the sphere of a body's volume, a field ([`field_source`](super::field_source)), or the
//! ground ([`ground`](super::ground)). `received_wave` evaluates its waves. A
//! receiver inside the body gets no pressure, and is counted.

use std::sync::Arc;

use glam::DVec3;

use super::field_source::FieldSource;
use super::ground::Ground;
use crate::body::{Body, Surface};
use crate::medium::Medium;
use crate::reference::PanSource;
use crate::sound_model::acceleration::sphere_radiation::SphereTransfer;

/// A sphere rings until it has fallen by e^−23 = 1e-10.
const DECAY_FOLDS: f64 = 23.0;

/// Source of the acceleration noise of a body, or of the ground.
#[derive(Clone, Debug, PartialEq)]
pub enum SoundSource {
    /// A sphere about the centre of mass, whose rotation radiates nothing.
    Sphere {
        /// Radius \[m\].
        radius: f64,
    },
    /// A field about the centre of mass.
    Field(Arc<FieldSource>),
    /// A field in a paper's representation.
    Reference(Arc<PanSource>),
    /// The ground below an impact, with the force at the centre of the click and the normal y.
    Ground {
        /// The ground.
        ground: Ground,
        /// Impulse into it [N s].
        impulse: f64,
    },
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

    /// Radius \[m\] about the centre of mass that encloses the source.
    pub fn radius(&self) -> f64 {
        match self {
            SoundSource::Sphere { radius } => *radius,
            SoundSource::Field(source) => source.radius,
            SoundSource::Reference(source) => source.model.radius(),
            SoundSource::Ground { .. } => 0.0,
        }
    }

    /// Decay time \[s\] after a sudden acceleration, from the passing of a wave from the centre of mass.
    pub fn ring_time(&self, medium: &Medium) -> f64 {
        match self {
            SoundSource::Sphere { radius } => SphereTransfer::decay_time(medium, *radius, DECAY_FOLDS),
            SoundSource::Field(source) => source.field.ring_time * source.radius / medium.sound_speed,
            SoundSource::Reference(source) => source.ring_time(medium),
            // The decay time of the ground depends on the place.
            SoundSource::Ground { .. } => 0.0,
        }
    }

    /// Whether a point \[m\] of the body frame is inside the source, where pressure is not evaluated.
    pub fn silent_at(&self, point_body: DVec3) -> bool {
        match self {
            SoundSource::Sphere { radius } => point_body.length() < *radius,
            SoundSource::Field(source) => source.contains(point_body),
            SoundSource::Reference(source) => source.contains(point_body),
            SoundSource::Ground { ground: Ground::Plate(plate), .. } => plate.contains(point_body),
            SoundSource::Ground { .. } => point_body.y <= 0.0,
        }
    }
}
