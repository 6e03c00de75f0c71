//! What radiates when a body is accelerated or the ground is struck.
//!
//! A source is data: the sphere of a body's volume, a field ([`field_source`](super::field_source)), or the
//! ground ([`ground`](super::ground)). Its waves are evaluated in [`received_wave`](super::received_wave). A
//! receiver inside the body hears nothing, and is counted.

use std::sync::Arc;

use glam::DVec3;

use super::field_source::FieldSource;
use super::ground::Ground;
use crate::body::{Body, Surface};
use crate::medium::Medium;
use crate::reference::PanSource;
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
    /// A field as a paper has it.
    Reference(Arc<PanSource>),
    /// The ground that a body hits, pressed at the centre of the click, y its normal.
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

    /// Radius \[m\] about the centre of mass inside which all of the source is.
    pub fn radius(&self) -> f64 {
        match self {
            SoundSource::Sphere { radius } => *radius,
            SoundSource::Field(source) => source.radius,
            SoundSource::Reference(source) => source.model.radius(),
            SoundSource::Ground { .. } => 0.0,
        }
    }

    /// Time \[s\] in which it dies away after a sudden acceleration, from the passing of a wave from the
    /// centre of mass.
    pub fn ring_time(&self, medium: &Medium) -> f64 {
        match self {
            SoundSource::Sphere { radius } => SphereTransfer::decay_time(medium, *radius, DECAY_FOLDS),
            SoundSource::Field(source) => source.field.ring_time * source.radius / medium.sound_speed,
            SoundSource::Reference(source) => source.ring_time(medium),
            // How long the surface is heard depends on where.
            SoundSource::Ground { .. } => 0.0,
        }
    }

    /// Whether nothing is heard at a point \[m\] of the body frame.
    pub fn silent_at(&self, point_body: DVec3) -> bool {
        match self {
            SoundSource::Sphere { radius } => point_body.length() < *radius,
            SoundSource::Field(source) => source.contains(point_body),
            SoundSource::Reference(source) => source.contains(point_body),
            SoundSource::Ground { .. } => point_body.y <= 0.0,
        }
    }
}
