//! How far a session is.

/// A step of a session.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// The dynamics.
    Simulation,
    /// Baking of fields of accelerated bodies.
    Acceleration,
    /// Baking of modes and their transfers.
    Modal,
    /// Rendering to files.
    Render,
    /// Rendering of a run by the real-time engine for its peak.
    Level,
    /// Playback on an audio device.
    Playback,
}

/// How far a stage is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress<'a> {
    /// The stage.
    pub stage: Stage,
    /// Fraction of the stage that is done, 0 to 1.
    pub done: f64,
    /// The body whose model is baked, the first of those that share it; empty otherwise.
    pub body: &'a str,
    /// What is being computed.
    pub step: &'static str,
}

impl Progress<'_> {
    /// A rendering of which this part is done.
    pub(crate) fn of_render(done: f64) -> Self {
        Progress { stage: Stage::Render, done, body: "", step: "render" }
    }

    /// A stage at `time` of `total` \[s\].
    pub fn of_time(stage: Stage, step: &'static str, (time, total): (f64, f64)) -> Self {
        let done = if total > 0.0 { time / total } else { 1.0 };
        Progress { stage, done, body: "", step }
    }
}
