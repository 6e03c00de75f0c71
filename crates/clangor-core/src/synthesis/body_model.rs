//! The sound model of one body of a scene: the field of its acceleration and the modes of its vibration.
//!
//! Each part is the body's own, that of a proxy, or the simplest: a sphere of equal volume for the
//! acceleration, no modes for the vibration. Each part carries the reason for its choice.

use std::fmt;
use std::sync::Arc;

use super::source::SoundSource;
use super::source_rule::{Decision, Reason, SourceKind};
use crate::sound_model::modal::model::ModalModel;
use crate::sound_model::soundbank::modal_soundbank::ModalProxy;

/// A part of the sound of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum SoundPart {
    /// Pressure from the acceleration of the rigid body.
    Acceleration,
    /// Pressure from its modes.
    Modal,
    /// Pressure from the ground under an impact.
    Ground,
}

impl fmt::Display for SoundPart {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            SoundPart::Acceleration => "acceleration",
            SoundPart::Modal => "modal",
            SoundPart::Ground => "ground",
        })
    }
}

/// Sound model of one body.
#[derive(Clone, Debug, PartialEq)]
pub struct SoundModel {
    /// Field of its acceleration.
    pub acceleration: AccelerationPart,
    /// Modes of its vibration.
    pub modal: BodyModes,
}

/// Acceleration model of a body.
#[derive(Clone, Debug, PartialEq)]
pub struct AccelerationPart {
    /// The source.
    pub source: SoundSource,
    /// Its kind: the next best where the chosen field is missing.
    pub kind: SourceKind,
    /// The choice, with its reason.
    pub decision: Decision,
}

/// Modal model of a body.
#[derive(Clone, Debug, PartialEq)]
pub enum BodyModes {
    /// Its own; bodies of equal form and material share it.
    Own(Arc<ModalModel>),
    /// Modes of an ellipsoid.
    Proxy(Arc<ModalProxy>),
    /// None.
    None(NoModes),
}

/// Reason for which a body has no modes.
#[derive(Clone, Debug, PartialEq)]
pub enum NoModes {
    /// All modes lie above the band.
    AboveBand {
        /// Lowest frequency \[Hz\].
        first: f64,
        /// Upper end of the band \[Hz\].
        limit: f64,
    },
    /// The scene excludes them.
    Unwanted,
    /// It is a plane, or nothing strikes it.
    Unstruck,
    /// Too many bodies of different forms.
    TooManyForms {
        /// Largest number of forms whose modes are computed without a request.
        most: usize,
    },
    /// Its modes or their transfers cannot be computed.
    Failed(String),
}

impl SoundModel {
    /// A body that radiates by `source` when accelerated, and has no modes.
    pub fn without_modes(source: SoundSource) -> Self {
        let kind = match source {
            SoundSource::Sphere { .. } => SourceKind::Sphere,
            _ => SourceKind::Own,
        };
        let decision = Decision { kind, reason: Reason::Asked };
        SoundModel {
            acceleration: AccelerationPart { source, kind, decision },
            modal: BodyModes::None(NoModes::Unwanted),
        }
    }
}

impl BodyModes {
    /// Its own modes, if any.
    pub fn own(&self) -> Option<&Arc<ModalModel>> {
        match self {
            BodyModes::Own(model) => Some(model),
            _ => None,
        }
    }

    /// The ellipsoid whose modes it has, if any.
    pub fn proxy(&self) -> Option<&Arc<ModalProxy>> {
        match self {
            BodyModes::Proxy(proxy) => Some(proxy),
            _ => None,
        }
    }

    /// Number of modes.
    pub fn mode_count(&self) -> usize {
        match self {
            BodyModes::Own(model) => model.modes.len(),
            BodyModes::Proxy(proxy) => proxy.mode_count(),
            BodyModes::None(_) => 0,
        }
    }
}

impl fmt::Display for BodyModes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            BodyModes::Own(model) => match model.modes.len() {
                1 => write!(f, "one mode"),
                count => write!(f, "{count} modes"),
            },
            BodyModes::Proxy(proxy) => match proxy.mode_count() {
                1 => write!(f, "one mode of ellipsoid {}", proxy.entry()),
                count => write!(f, "{count} modes of ellipsoid {}", proxy.entry()),
            },
            BodyModes::None(reason) => write!(f, "{reason}"),
        }
    }
}

impl fmt::Display for NoModes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            NoModes::AboveBand { first, limit } => {
                let (first, limit) = (1e-3 * first, 1e-3 * limit);
                write!(f, "no audible modes: first at {first:.2} kHz, above the limit of {limit:.2} kHz")
            }
            NoModes::Unwanted => f.write_str("it is not to ring"),
            NoModes::Unstruck => f.write_str("nothing strikes it"),
            NoModes::TooManyForms { most } => {
                write!(f, "one of more than {most} forms: ask for its modes with modal = true")
            }
            NoModes::Failed(why) => write!(f, "its modes cannot be baked: {why}"),
        }
    }
}
