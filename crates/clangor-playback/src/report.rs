//! How a playback went.

/// How a playback went. An event is an impact, a pose or the end of a body; a wave is the sound of one
/// acceleration pulse on one path to one receiver.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaybackReport {
    /// Name of the device.
    pub device: String,
    /// Sample rate of the device \[Hz\].
    pub sample_rate: u32,
    /// Pressure of a full-scale sample \[Pa\].
    pub full_scale: f64,
    /// Start of the played part, in the time of the run \[s\].
    pub from: f64,
    /// End of the played part, in the time of the run \[s\].
    pub to: f64,
    /// Impacts sent to the engine.
    pub impacts: usize,
    /// Bodies in the slots of the engine.
    pub objects: usize,
    /// Events that the engine took.
    pub taken: u64,
    /// Waves rendered.
    pub waves: u64,
    /// Impacts that reached the engine after their time and were rendered as soon as possible.
    pub late: u64,
    /// Events for which the engine had no room.
    pub lost: u64,
    /// Events out of range.
    pub refused: u64,
    /// Events lost, waves and bodies left out for lack of time, and waves from beyond the engine's reach.
    pub left_out: u64,
    /// Delay of the engine \[s\].
    pub engine_latency: f64,
    /// Longest time from the rendering of a sample until it is heard, as the device reports it \[s\].
    pub device_latency: f64,
    /// How often the device ran out of samples.
    pub underruns: u64,
}
