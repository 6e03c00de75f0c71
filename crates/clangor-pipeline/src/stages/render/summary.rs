//! What a rendering wrote and measured.

use std::collections::BTreeMap;
use std::path::PathBuf;

use clangor_core::body::BodyId;
use clangor_core::contact::ContactReport;
use clangor_core::synthesis::RenderReport;
use clangor_core::synthesis::SoundPart;

use super::modal_state_transfer::ModalStateTransfer;
use crate::analysis::levels::Levels;

/// One part of the sound of one body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Stem {
    /// The body.
    pub body: BodyId,
    /// The part.
    pub part: SoundPart,
}

/// A file that was written.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderedFile {
    /// Where.
    pub path: PathBuf,
    /// Who heard it.
    pub listener: String,
    /// What is in a stem.
    pub stem: Option<Stem>,
    /// Pressure of a sample of 1 \[Pa\].
    pub full_scale: f64,
    /// How loud it is.
    pub levels: Levels,
    /// Samples beyond full scale (24-bit only).
    pub clipped_samples: u64,
}

/// What a rendering did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RenderSummary {
    /// The files, in order of listener; a mix before its stems.
    pub files: Vec<RenderedFile>,
    /// What became of the impacts.
    pub contacts: ContactReport,
    /// What each listener could not hear.
    pub listeners: Vec<RenderReport>,
    /// Sum of ∫ p² dt of the clicks over all receivers \[Pa² s\] by body.
    pub energies: BTreeMap<BodyId, f64>,
    /// The same of the ringing.
    pub modal_energies: BTreeMap<BodyId, f64>,
    /// The same of the ground, by plane.
    pub ground_energies: BTreeMap<BodyId, f64>,
    /// What became of the vibration of bodies that broke.
    pub handovers: BTreeMap<BodyId, ModalStateTransfer>,
    /// Estimates of the same above the band of the fields, for bodies whose field ends within the band
    /// rendered.
    pub missing_energies: BTreeMap<BodyId, f64>,
}
