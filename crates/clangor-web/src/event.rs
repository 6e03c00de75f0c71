//! An event between the world and the synthesiser, as [`STRIDE`] numbers.
//!
//! | index | content |
//! |---|---|
//! | 0 | kind: [`CLICK`] of a sphere, [`IMPACT`] on a loaded object, [`POSE`] of a loaded object, [`END`] of one |
//! | 1 | time \[s\] |
//! | 2 | duration τ \[s\] |
//! | 3 | radius \[m\] (click), or the slot of the object |
//! | 4–6 | centre of mass \[m\] |
//! | 7–10 | orientation x, y, z, w |
//! | 11–13 | change of the velocity [m/s] (click, impact), or the velocity (pose) |
//! | 14–16 | change of the angular velocity, or the angular velocity \[rad/s\] |
//! | 17–19 | point of the impact \[m\], world |
//! | 20–22 | impulse there [N s], world |
//! | 23 | number of the body, for the page |

use clangor_core::contact::{BodyPulse, ImpactPulse};

/// Numbers of an event.
pub const STRIDE: usize = 24;
/// Kind of an event: the click of a sphere.
pub const CLICK: f64 = 0.0;
/// Kind of an event: an impact on a loaded object.
pub const IMPACT: f64 = 1.0;
/// Kind of an event: the pose of a loaded object.
pub const POSE: f64 = 2.0;
/// Kind of an event: a loaded object is no more.
pub const END: f64 = 3.0;

/// The click of a sphere of this radius that an impact moves.
pub fn click(pulse: &ImpactPulse, share: &BodyPulse, radius: f64) -> [f64; STRIDE] {
    let mut event = [0.0; STRIDE];
    event[..4].copy_from_slice(&[CLICK, pulse.onset, pulse.duration, radius]);
    event[4..7].copy_from_slice(&share.pose.position.to_array());
    event[7..11].copy_from_slice(&share.pose.orientation.to_array());
    event[11..14].copy_from_slice(&share.velocity_change.to_array());
    event[14..17].copy_from_slice(&share.angular_velocity_change.to_array());
    event[17..20].copy_from_slice(&pulse.point.to_array());
    event[20..23].copy_from_slice(&share.impulse.to_array());
    event[23] = f64::from(share.body.0);
    event
}
