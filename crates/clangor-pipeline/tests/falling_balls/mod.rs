//! Renders of spheres without modes into a WAV of micropascals with stems, and its samples.

use std::ops::ControlFlow;
use std::path::Path;

use clangor_core::contact::ContactSettings;
use clangor_core::scene::render_description::{GroundSound, Parts};
use clangor_core::synthesis::{Listener, RenderSettings, SoundModel, SoundSource};
use clangor_core::timeline::Timeline;
use clangor_pipeline::formats::wav::{SampleFormat, WavReader};
use clangor_pipeline::stages::load::LoadedScene;
use clangor_pipeline::stages::render::{FullScale, RenderOptions, RenderSummary, Transfers, render};

/// \[Pa\]
const FULL_SCALE: f64 = 1e-6;

/// One listener, up to a time \[s\].
pub(crate) fn options(listener: Listener, to: f64) -> RenderOptions {
    RenderOptions {
        listeners: vec![listener],
        contact: ContactSettings::default(),
        synthesis: RenderSettings::default(),
        parts: Parts::default(),
        transfers: Transfers::Baked,
        rolling: None,
        ground: GroundSound::HalfSpace,
        inherit_vibration: true,
        to,
        format: SampleFormat::Float32,
        full_scale: FullScale::Pascals(FULL_SCALE),
        compressor: None,
        stems: true,
        note: String::new(),
    }
}

pub(crate) fn render_spheres(
    loaded: &LoadedScene,
    timeline: &Timeline,
    options: &RenderOptions,
    file: &Path,
) -> RenderSummary {
    let bodies = &loaded.world.bodies;
    let models: Vec<SoundModel> =
        SoundSource::spheres(bodies).into_iter().map(SoundModel::without_modes).collect();
    render(bodies, &models, timeline, options, file, &mut |_| ControlFlow::Continue(())).unwrap()
}

/// \[Pa\]
pub(crate) fn samples(path: &Path) -> Vec<f64> {
    let mut samples = Vec::new();
    let mut reader = WavReader::open(path).unwrap();
    while reader.read(&mut samples, 1 << 16).unwrap() > 0 {}
    samples.into_iter().map(|p: f32| FULL_SCALE * f64::from(p)).collect()
}
