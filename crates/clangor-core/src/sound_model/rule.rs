//! Rules of a scene for the sound model of a body, part by part.

use std::fmt;

use crate::body::Body;

/// Rule for the sound model of one body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SoundRule {
    /// Field of its acceleration.
    pub acceleration: AccelerationRule,
    /// Modes of its vibration.
    pub modal: ModalRule,
}

/// Rule for the field of an accelerated body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AccelerationRule {
    /// Chosen by size and convexity.
    #[default]
    Auto,
    /// A field of its own.
    Own,
    /// An ellipsoid: the mean of those of the bank around it.
    Proxy,
    /// The nearest ellipsoid of the bank, as in \[PROXY\].
    NearestProxy,
    /// The sphere of equal volume.
    Sphere,
}

/// Rule for the modes of a body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ModalRule {
    /// Its own, unless that takes too long; the render settings decide for pieces of broken bodies.
    #[default]
    Auto,
    /// Its own.
    Own,
    /// Those of an ellipsoid.
    Proxy,
    /// None.
    Never,
}

impl SoundRule {
    /// The rule of the pieces of a body with this rule. Pieces of a body under [`AccelerationRule::Auto`]
    /// radiate as ellipsoids of any size: they are many, and their sounds are short.
    #[must_use]
    pub fn of_pieces(self) -> Self {
        let acceleration = match self.acceleration {
            AccelerationRule::Auto => AccelerationRule::Proxy,
            rule => rule,
        };
        SoundRule { acceleration, ..self }
    }
}

/// The rules of all `bodies`, pieces included; `rules` are those of the bodies present from the beginning,
/// [`SoundRule::default`] where they end. A piece inherits from its parent ([`SoundRule::of_pieces`]).
pub fn rules_with_pieces(bodies: &[Body], rules: &[SoundRule]) -> Vec<SoundRule> {
    let mut all: Vec<SoundRule> = Vec::with_capacity(bodies.len());
    for (index, body) in bodies.iter().enumerate() {
        let parent = body.life.parent.and_then(|parent| all.get(parent.index()).copied());
        all.push(match parent {
            Some(rule) => rule.of_pieces(),
            None => rules.get(index).copied().unwrap_or_default(),
        });
    }
    all
}

impl From<AccelerationRule> for SoundRule {
    fn from(acceleration: AccelerationRule) -> Self {
        SoundRule { acceleration, modal: ModalRule::default() }
    }
}

impl From<ModalRule> for SoundRule {
    fn from(modal: ModalRule) -> Self {
        SoundRule { acceleration: AccelerationRule::default(), modal }
    }
}

impl fmt::Display for AccelerationRule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            AccelerationRule::Auto => "auto",
            AccelerationRule::Own => "own",
            AccelerationRule::Proxy => "proxy",
            AccelerationRule::NearestProxy => "nearest-proxy",
            AccelerationRule::Sphere => "sphere",
        })
    }
}
