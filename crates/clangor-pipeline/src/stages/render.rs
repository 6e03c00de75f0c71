//! Impacts become sound at listeners, and sound becomes WAV files.
//!
//! ```text
//! impacts ─► force pulses ─► clicks, voices ─► one pass per listener and stem ─► WAV, levels, energies
//! ```
//!
//! A pass streams: blocks of clicks are rendered on all threads, added in a fixed order, joined by the modal
//! voices, and written as soon as they are complete. Normalising takes a pass of its own to find the peak,
//! so that memory stays flat however long the sound is.

mod error;
mod file_names;
mod forces;
mod ground;
mod impact_reader;
mod impacts_by_body;
mod modal_sources;
mod modal_state_transfer;
mod modal_voices;
mod options;
mod pass;
mod propagation_paths;
mod sounding_scene;
mod struck_source;
mod summary;
mod transfers;

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::Path;

use clangor_core::body::{Body, BodyId};
use clangor_core::synthesis::AccelerationPulse;
use clangor_core::synthesis::{SoundModel, SoundPart};
use clangor_core::timeline::Timeline;

pub use self::error::RenderError;
pub use self::file_names::check_output;
use self::file_names::file_name;
pub use self::forces::timeline_forces;
pub(crate) use self::forces::{Forces, forces};
pub use self::impact_reader::read_impacts;
pub use self::modal_sources::{UnplayableModes, modal_sources};
pub use self::modal_state_transfer::ModalStateTransfer;
pub use self::options::{FullScale, RenderOptions};
use self::pass::{Heard, Pass, PassProgress, Vibrating};
use self::sounding_scene::SoundingScene;
pub use self::summary::{RenderSummary, RenderedFile, Stem};
pub use self::transfers::Transfers;

/// Renders the impacts of a timeline for every listener into `output`; `models` has the sound model of each
/// body.
///
/// One listener makes the file `output`; several make `NAME.LISTENER.wav` each. Stems are
/// `….BODY.acceleration.wav`, `….BODY.modal.wav` and `….PLANE.ground.wav`. `progress` gets the fraction of
/// the
/// work done, from 0 to 1.
///
/// # Errors
/// [`RenderError`]; a file appears only once it is complete.
pub fn render(
    bodies: &[Body],
    models: &[SoundModel],
    timeline: &Timeline,
    options: &RenderOptions,
    output: &Path,
    progress: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<RenderSummary, RenderError> {
    check_output(options, bodies, output)?;
    let (scene, contacts) = SoundingScene::new(bodies, models, timeline, options)?;
    let mut stems = vec![None];
    if options.stems {
        stems.extend(scene.stems().into_iter().map(Some));
    }
    let passes = options.listeners.len()
        * (stems.len() + usize::from(matches!(options.full_scale, FullScale::Peak(_))));
    let mut progress = PassProgress { passes, done: 0.0, progress };
    let mut summary =
        RenderSummary { contacts, handovers: scene.modal.handovers().clone(), ..RenderSummary::default() };
    for listener in &options.listeners {
        let mut full_scale = None;
        for &stem in &stems {
            let own: Vec<AccelerationPulse>;
            let (clicks, vibrating) = match stem {
                None => (&scene.clicks[..], Vibrating::All),
                Some(Stem { body, part: SoundPart::Acceleration | SoundPart::Ground }) => {
                    own = scene.clicks.iter().filter(|c| c.body == body).cloned().collect();
                    (&own[..], Vibrating::None)
                }
                Some(Stem { body, part: SoundPart::Modal }) => (&[][..], Vibrating::Only(body)),
            };
            let pass = Pass { listener, options, scene: &scene, clicks, vibrating };
            // Stems keep the full scale of their mix, so that they add up to it.
            let scale = match full_scale {
                Some(scale) => scale,
                None => pass.full_scale(&mut progress)?,
            };
            full_scale = Some(scale);
            let named = stem.map(|stem| (bodies[stem.body.index()].name.as_str(), stem.part));
            let path = file_name(output, options, listener, named);
            let (file, heard) = pass.write(&path, scale, &mut progress)?;
            if stem.is_none() {
                add_heard(&mut summary, heard, &scene);
            }
            summary.files.push(RenderedFile { stem, ..file });
        }
    }
    Ok(summary)
}

/// The pressure at a listener.
#[derive(Clone, Debug, PartialEq)]
pub struct HeardPressure {
    /// Name of the listener.
    pub listener: String,
    /// Number of receivers.
    pub channels: usize,
    /// Pressure \[Pa\], frame after frame, one number per receiver.
    pub interleaved: Vec<f32>,
}

/// Renders the impacts of a timeline for every listener into memory, without stems and compression; see
/// [`render`].
///
/// # Errors
/// [`RenderError`].
pub fn render_in_memory(
    bodies: &[Body],
    models: &[SoundModel],
    timeline: &Timeline,
    options: &RenderOptions,
    progress: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<Vec<HeardPressure>, RenderError> {
    options.check_sound()?;
    let (scene, _) = SoundingScene::new(bodies, models, timeline, options)?;
    let mut progress = PassProgress { passes: options.listeners.len(), done: 0.0, progress };
    let hear = |listener| {
        let pass =
            Pass { listener, options, scene: &scene, clicks: &scene.clicks, vibrating: Vibrating::All };
        Ok(HeardPressure {
            listener: listener.name.clone(),
            channels: listener.receivers.len(),
            interleaved: pass.collect(&mut progress)?,
        })
    };
    options.listeners.iter().map(hear).collect()
}

/// Adds what one listener heard of everything.
fn add_heard(summary: &mut RenderSummary, heard: Heard, scene: &SoundingScene) {
    summary.listeners.push(heard.report);
    let (ground, energies) =
        heard.energies.into_iter().partition(|(body, _)| scene.grounds.contains_key(body));
    let sums: [(_, BTreeMap<BodyId, f64>); 4] = [
        (&mut summary.energies, energies),
        (&mut summary.ground_energies, ground),
        (&mut summary.missing_energies, heard.missing_energies),
        (&mut summary.modal_energies, heard.modal_energies),
    ];
    for (sum, energies) in sums {
        energies.into_iter().for_each(|(body, energy)| *sum.entry(body).or_default() += energy);
    }
}
