//! How to render, and what to write.

use clangor_core::contact::ContactSettings;
use clangor_core::scene::render_description::{Compressor as CompressorSettings, GroundSound, Parts};
use clangor_core::synthesis::{Listener, RenderSettings, Renderer};

use super::error::RenderError;
use super::propagation_paths::reverberation;
use super::transfers::Transfers;
use crate::formats::wav::SampleFormat;

/// What full scale of a file is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FullScale {
    /// This pressure \[Pa\].
    Pascals(f64),
    /// Whatever brings the loudest sample of a listener to this level \[dBFS\].
    Peak(f64),
}

/// How to render, and what to write.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderOptions {
    /// Who listens.
    pub listeners: Vec<Listener>,
    /// Impacts to forces.
    pub contact: ContactSettings,
    /// Forces to pressure; `start` is the time of the first sample written \[s\].
    pub synthesis: RenderSettings,
    /// What of the sound is rendered.
    pub parts: Parts,
    /// How modes become pressure.
    pub transfers: Transfers,
    /// How planes sound that are hit.
    pub ground: GroundSound,
    /// Whether pieces go on with the vibration of what they were part of.
    pub inherit_vibration: bool,
    /// Time step \[s\] of the dynamics whose gentle forces make bodies ring too; `None`: only impacts do.
    pub rolling: Option<f64>,
    /// End of the sound \[s\].
    pub to: f64,
    /// Format of a sample.
    pub format: SampleFormat,
    /// What full scale means.
    pub full_scale: FullScale,
    /// Dynamic range compression, after which a file is no longer pressure.
    pub compressor: Option<CompressorSettings>,
    /// Also a file for each body that sounds.
    pub stems: bool,
    /// A line for the comment of the files.
    pub note: String,
}

impl RenderOptions {
    /// Checks what does not depend on the motion, before a long simulation.
    ///
    /// # Errors
    /// Those of [`render`](super::render) that depend neither on the impacts nor on files.
    pub fn check_sound(&self) -> Result<(), RenderError> {
        if self.listeners.is_empty() {
            return Err(RenderError::NoListener);
        }
        let from = self.synthesis.start;
        if self.to <= from {
            return Err(RenderError::NothingToWrite { from, to: self.to });
        }
        for listener in &self.listeners {
            Renderer::new(listener, &self.synthesis)?;
        }
        let rate = self.synthesis.sample_rate.as_f64();
        reverberation(&self.synthesis.acoustics, rate)?;
        Ok(())
    }
}
