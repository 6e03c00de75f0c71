//! A ceramic tile that falls on stone and breaks, as a scene: its pieces, and what is heard of it.

use std::collections::BTreeSet;
use std::ops::ControlFlow;
use std::path::Path;

use clangor_bake::modal::ModalBakeOptions;
use clangor_core::body::{Body, BodyId};
use clangor_core::contact::ContactSettings;
use clangor_core::medium::Medium;
use clangor_core::scene::render_description::{GroundSound, PROXY_FREQUENCY, Parts};
use clangor_core::synthesis::{BodyModes, NoModes};
use clangor_core::synthesis::{Listener, RenderSettings};
use clangor_core::timeline::Timeline;
use clangor_pipeline::formats::soundbank::default_bank;
use clangor_pipeline::formats::wav::{SampleFormat, WavReader};
use clangor_pipeline::stages::load::{LoadedScene, scene_from_text};
use clangor_pipeline::stages::render::{FullScale, RenderOptions, Transfers, render};
use clangor_pipeline::stages::simulate::simulate_impacts;
use clangor_pipeline::stages::sound_models::{
    AccelerationSettings, ModalPlanSettings, SoundModelPlan, SoundModelSettings, SoundModelStore, SoundModels,
};

/// Duration of the scene \[s\].
pub(crate) const DURATION: f64 = 0.06;

/// How the tile breaks.
#[derive(Clone, Copy)]
pub(crate) struct Tile {
    /// G_c [J/m²].
    pub(crate) toughness: f64,
    /// Whether its cracks drive the pieces apart.
    pub(crate) crack_impulses: bool,
    pub(crate) seed: u64,
}

/// A tile after its fall.
pub(crate) struct Fallen {
    loaded: LoadedScene,
    pub(crate) bodies: Vec<Body>,
    pub(crate) timeline: Timeline,
}

fn go_on(_: f64) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

impl Tile {
    fn scene(&self) -> String {
        let Tile { toughness, crack_impulses, seed } = self;
        format!(
            "version = 1\n[simulation]\nduration = {DURATION}\ntime_step = 0.0001\n[material.tough]\n\
             base = \"ceramic\"\n\
             fracture_energy = {toughness}\n[[body]]\nname = \"tile\"\nshape = \"box:0.12x0.006x0.12\"\n\
             material = \"tough\"\n\
             position = [0, 0.03, 0]\norientation = {{ axis = [0.3, 0, 1], degrees = 12 }}\n\
             velocity = [0, -4, 0]\n\
             acceleration = \"proxy\"\nmodal = \"proxy\"\n\
             fracture = {{ edge = 0.01, seed = {seed}, crack_impulses = {crack_impulses} }}\n[[plane]]\n\
             material = \"granite\"\n\
             [[listener]]\nposition = [0, 0.4, 1]\n"
        )
    }

    pub(crate) fn fall(&self) -> Fallen {
        let loaded = scene_from_text(Path::new("tile.toml"), self.scene(), &|_| ()).unwrap();
        let all = (0..loaded.world.bodies.len() as u32).map(BodyId).collect();
        let (timeline, _) = simulate_impacts(&loaded, &all, &mut go_on).unwrap();
        let bodies = timeline.all_bodies(&loaded.world.bodies);
        Fallen { loaded, bodies, timeline }
    }
}

impl Fallen {
    /// The pieces that are whole at the end.
    pub(crate) fn pieces(&self) -> impl Iterator<Item = &Body> {
        self.bodies.iter().filter(|b| b.life.parent.is_some() && b.life.death == f64::INFINITY)
    }

    /// The lowest frequencies of the pieces \[Hz\].
    pub(crate) fn pitches(&self) -> Vec<f64> {
        let models = self.models();
        let lowest = |(id, body): (usize, &Body)| {
            let piece = body.life.parent.is_some() && body.life.death == f64::INFINITY;
            match &models.bodies[id].modal {
                BodyModes::Proxy(proxy) if piece => Some(proxy.frequency(0)),
                BodyModes::None(NoModes::AboveBand { first, .. }) if piece => Some(*first),
                _ => None,
            }
        };
        self.bodies.iter().enumerate().filter_map(lowest).collect()
    }

    /// The sound models of its bodies; fields are those of ellipsoids.
    pub(crate) fn models(&self) -> SoundModels {
        let scene = &self.loaded.scene;
        let bank = default_bank();
        let settings = SoundModelSettings {
            acceleration: AccelerationSettings::new(RenderSettings::default().max_wavenumber(), 0.01, 0.0),
            wants_acceleration: true,
            modal: Some(ModalPlanSettings {
                options: ModalBakeOptions::new(Medium::AIR),
                proxy_frequency: PROXY_FREQUENCY,
            }),
            patience: f64::INFINITY,
        };
        let plan = SoundModelPlan::new(&self.loaded.world.bodies, &scene.sound_rules(), settings);
        let store = SoundModelStore { cache: None, bank: bank.as_ref() };
        plan.find(&self.bodies, &self.struck(), store, &mut |_| ControlFlow::Continue(())).unwrap()
    }

    fn struck(&self) -> BTreeSet<BodyId> {
        self.timeline.contacts.iter().flat_map(|r| [r.body_a, r.body_b]).collect()
    }

    /// What is heard \[Pa\] at 48 kHz, and what it is made of: clicks, ringing, or both.
    pub(crate) fn heard(&self, models: &SoundModels, parts: Parts) -> Vec<f64> {
        let synthesis = RenderSettings::default();
        let mut models = models.bodies.clone();
        // What vibrates is heard whatever the parts are.
        if !parts.modal {
            models.iter_mut().for_each(|model| model.modal = BodyModes::None(NoModes::Unwanted));
        }
        let options = RenderOptions {
            listeners: vec![Listener::fixed("microphone", clangor_core::glam::DVec3::new(0.0, 0.4, 1.0))],
            contact: ContactSettings::default(),
            synthesis,
            parts,
            transfers: Transfers::Baked,
            rolling: None,
            ground: GroundSound::None,
            // What cracks add, not what the tile hands on.
            inherit_vibration: false,
            to: DURATION,
            format: SampleFormat::Float32,
            full_scale: FullScale::Pascals(1.0),
            compressor: None,
            stems: false,
            note: String::new(),
        };
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("tile.wav");
        render(&self.bodies, &models, &self.timeline, &options, &file, &mut go_on).unwrap();
        let mut samples = Vec::new();
        let mut reader = WavReader::open(&file).unwrap();
        while reader.read(&mut samples, 1 << 16).unwrap() > 0 {}
        samples.into_iter().map(f64::from).collect()
    }
}

/// The first sample that sounds.
pub(crate) fn onset_sample(samples: &[f64]) -> usize {
    let peak = samples.iter().map(|p| p.abs()).fold(0.0, f64::max);
    samples.iter().position(|p| p.abs() > 1e-3 * peak).unwrap()
}

/// ∫ p² dt \[Pa² s\] over some milliseconds from the first sound on.
pub(crate) fn onset_energy(samples: &[f64], milliseconds: f64) -> f64 {
    let count = (1e-3 * milliseconds * 48_000.0) as usize;
    samples[onset_sample(samples)..].iter().take(count).map(|p| p * p).sum::<f64>() / 48_000.0
}

/// The middle of some numbers.
pub(crate) fn median(mut numbers: Vec<f64>) -> f64 {
    numbers.sort_by(f64::total_cmp);
    let half = numbers.len() / 2;
    if numbers.len() % 2 == 1 { numbers[half] } else { 0.5 * (numbers[half - 1] + numbers[half]) }
}
