//! Errors of a simulation.

use clangor_core::quantity::{readable, rounded};

/// Why a simulation failed.
#[derive(Debug, thiserror::Error)]
pub enum SimulationError {
    /// The log could not be written.
    #[error("the timeline cannot be written: {0}")]
    Sink(#[from] std::io::Error),
    /// The sphere solver met a body that it cannot move.
    #[error(
        "solver = \"spheres\" cannot move body \"{body}\": {reason}; use solver = \"rigid\", which moves \
         all bodies"
    )]
    NotASphere {
        /// The body.
        body: String,
        /// Why the solver cannot move it.
        reason: &'static str,
    },
    /// The time-stepped solver does not support a feature of the world.
    #[error(
        "solver = \"rigid\" has no {what} (\"{name}\"); solver = \"spheres\" has, if all other bodies \
         are spheres and planes too"
    )]
    Unsupported {
        /// The feature.
        what: &'static str,
        /// The body or link.
        name: String,
    },
    /// A body cannot be simulated.
    #[error("body \"{body}\" {reason}")]
    BadBody {
        /// The body.
        body: String,
        /// What is wrong with the body.
        reason: &'static str,
    },
    /// A hand or a load that is too strong for the time step.
    #[error(transparent)]
    PushedTooFar(Box<FarPush>),
    /// A setting is out of range.
    #[error("{setting} = {value:e} is not possible")]
    BadSetting {
        /// Which number.
        setting: &'static str,
        /// Its value.
        value: f64,
    },
    /// Two bodies overlap at the start, or where one of them is let go.
    #[error("\"{a}\" and \"{b}\" overlap by {depth:.3e} m at t = {time}; move them apart")]
    StartOverlap {
        /// First body.
        a: String,
        /// Second body.
        b: String,
        /// Overlap \[m\].
        depth: f64,
        /// When \[s\].
        time: f64,
    },
    /// A joint cannot be closed.
    #[error(
        "a joint of \"{body}\" cannot be closed at t = {time:.6} s: it stays open by {gap:.3e} m (or rad); \
         use a smaller time_step, or look whether keyframes pull it apart"
    )]
    LooseJoint {
        /// The body at its near end.
        body: String,
        /// How far it is off \[m, or rad\].
        gap: f64,
        /// When \[s\].
        time: f64,
    },
    /// A spring pulls so strongly that no step brings it to rest.
    #[error(
        "a spring of \"{body}\" is strained so strongly that its motion cannot be followed at \
         t = {time:.6} s (off by {gap:.3e} m); use a smaller time_step, a lower stiffness, or a rest_length \
         nearer to its length"
    )]
    StrainedSpring {
        /// The body at its near end.
        body: String,
        /// How far it is off its law \[m\].
        gap: f64,
        /// When \[s\].
        time: f64,
    },
    /// The ends of a joint are apart at the start.
    #[error("a joint of \"{body}\" is open by {gap:.3e} m (or rad) at t = 0; its ends must meet there")]
    OpenJoint {
        /// The body at its near end.
        body: String,
        /// How far it is off \[m, or rad\].
        gap: f64,
    },
    /// A body cannot be replaced by pieces.
    #[error("\"{body}\" breaks at t = {time:.6} s, but it {reason}")]
    CannotBreak {
        /// The body.
        body: String,
        /// Why not.
        reason: &'static str,
        /// When \[s\].
        time: f64,
    },
    /// A body that is set to break cannot be prepared or computed.
    #[cfg(feature = "fracture")]
    #[error("\"{body}\" cannot break: {source}")]
    Fracture {
        /// The body.
        body: String,
        /// Why.
        source: crate::fracture::FractureError,
    },
    /// The state is no longer finite.
    #[error("the motion of \"{body}\" diverged at t = {time:.6} s")]
    Diverged {
        /// The body.
        body: String,
        /// When \[s\].
        time: f64,
    },
    /// The caller stopped the run.
    #[error("interrupted")]
    Interrupted,
}

/// A push that moves a body too far within a time step.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "a {what} of {} {unit} moves \"{body}\" by {} {moved_unit} within a time step of {time_step} s, \
     farther than contacts can follow; make it weaker, or time_step at most {} s",
    readable(rounded(*size, 3)),
    readable(rounded(*moved, 2)),
    readable(rounded(0.95 * longest, 2))
)]
pub struct FarPush {
    /// The body.
    pub body: String,
    /// `hand`, `force` or `torque`.
    pub what: &'static str,
    /// Its largest value \[N, of a torque N m\].
    pub size: f64,
    /// Unit of `size`: `N` or `N m`.
    pub unit: &'static str,
    /// How far it moves the body in a step \[m, of a torque rad\].
    pub moved: f64,
    /// Unit of `moved`: `m` or `rad`.
    pub moved_unit: &'static str,
    /// The step \[s\].
    pub time_step: f64,
    /// The longest step that would do \[s\].
    pub longest: f64,
}
