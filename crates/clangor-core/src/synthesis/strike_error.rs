//! Errors in the strike of a single body.

use glam::DVec3;

use super::SynthesisError;
use crate::contact::ContactError;
use crate::propagation::RoomError;
use crate::quantity::readable_length;

/// Error in a strike.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum StrikeError {
    /// A number that is not finite.
    #[error("{what} is not finite")]
    NotFinite {
        /// Quantity.
        what: &'static str,
    },
    /// The impact misses the body.
    #[error(
        "the point {point} m is {} off the surface, more than 2 % of the bounding radius {}",
        readable_length(*distance),
        readable_length(*bounding)
    )]
    OffSurface {
        /// The point \[m\].
        point: DVec3,
        /// Its distance from the surface \[m\].
        distance: f64,
        /// Bounding radius of the body \[m\].
        bounding: f64,
    },
    /// A number of the striker that is not positive.
    #[error("the striker has {what} {value}; it must be more than 0")]
    Striker {
        /// Quantity, with its article.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// A given normal without a direction.
    #[error("the normal is zero; it points out of the body")]
    ZeroNormal,
    /// A given normal along which the striker would come through the body.
    #[error("the normal {normal} points into the body, whose surface faces {outward:.3} there")]
    InwardNormal {
        /// The given normal.
        normal: DVec3,
        /// The normal of the surface at the point.
        outward: DVec3,
    },
    /// The surface has no direction at the point.
    #[error("the surface has no normal at the point {point} m: give one")]
    NoNormal {
        /// The point \[m\].
        point: DVec3,
    },
    /// The contact has no duration.
    #[error(transparent)]
    Contact(#[from] ContactError),
    /// No impulse and no duration.
    #[error("the impulse is zero, so the duration of the contact must be given")]
    NoImpulse,
    /// A half-space, or a mass or volume that is not positive.
    #[error(
        "the body cannot be struck: its mass is {mass} kg and the sphere of its volume has radius {radius} m"
    )]
    Immovable {
        /// Mass \[kg\].
        mass: f64,
        /// Radius of the sphere of equal volume \[m\].
        radius: f64,
    },
    /// A duration that is not positive.
    #[error("the contact lasts {duration} s; it must be longer than 0")]
    Duration {
        /// Duration \[s\].
        duration: f64,
    },
    /// An output that ends before it begins.
    #[error("the output ends at {seconds} s, before it begins at −0.002 s")]
    Seconds {
        /// End of the output \[s\].
        seconds: f64,
    },
    /// The listener is inside the body, or inside the sphere in its place.
    #[error(
        "the listener is {distance} m from the centre of mass, inside the body or the sphere that sounds in \
        its place"
    )]
    ListenerInside {
        /// Distance from the centre of mass \[m\].
        distance: f64,
    },
    /// The room has no reverberation time.
    #[error(transparent)]
    Room(#[from] RoomError),
    /// The sound cannot be synthesised.
    #[error(transparent)]
    Synthesis(#[from] SynthesisError),
}
