//! Spheres, planes, rods and springs: an exact event-driven solver, and a time-stepped one for piles.
//!
//! | module | what it computes |
//! |---|---|
//! | `event_driven` | exact motion from event to event |
//! | `stepped` | the same bodies in steps of time, where they come to rest on each other |
//! | `approach` | times at which two surfaces meet |
//! | `compliant_cluster` | balls that press on each other, through the time of their contacts |
//! | `impact` | impulses of simultaneous impacts with friction |
//! | `bodies`, `cells` | spheres and planes of a world, and the order in which they are stored |
//! | `pair_coefficients` | restitution, friction and rolling loss of pairs of materials |

mod approach;
mod bodies;
mod cells;
mod compliant_cluster;
mod event_driven;
mod impact;
mod pair_coefficients;
pub(crate) mod spring_pace;
mod stepped;
mod tolerances;

pub(crate) use event_driven::{Engine, simulate};
pub(crate) use stepped::Stepped;
