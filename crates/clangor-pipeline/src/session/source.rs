//! What a session begins with: a loaded scene or an open timeline, and what it says about its sound.

use std::path::Path;

use clangor_core::acoustics::Acoustics;
use clangor_core::body::Body;
use clangor_core::scene::Scene;
use clangor_core::scene::listener::ListenerDescription;
use clangor_core::scene::render_description::RenderDescription;
use clangor_core::scene::simulation_description::SolverChoice;
use clangor_core::sound_model::SoundRule;
use clangor_core::synthesis::Listener;

use super::error::Error;
use crate::formats::timeline_file::TimelineReader;
use crate::stages::load::LoadedScene;
use crate::stages::simulate::solver;

/// Bodies, listeners and settings.
pub(super) struct Source {
    pub(super) motion: Motion,
    /// Those present from the beginning, until it is known what broke.
    pub(super) bodies: Vec<Body>,
    pub(super) acoustics: Acoustics,
    pub(super) listeners: Vec<Listener>,
    pub(super) settings: RenderDescription,
    pub(super) rules: Vec<SoundRule>,
    /// Speed below which impacts are not heard [m/s].
    pub(super) v_min: f64,
    /// Time step \[s\], if the dynamics give all forces.
    pub(super) time_step: Option<f64>,
    /// \[s\].
    pub(super) duration: f64,
}

/// Where the impacts come from.
pub(super) enum Motion {
    /// They are still to be simulated.
    Scene(Box<LoadedScene>),
    /// They are in a folder.
    Timeline(Box<TimelineReader>),
}

impl Source {
    /// A scene; nothing moves yet.
    pub(super) fn from_scene(loaded: LoadedScene) -> Self {
        let scene = &loaded.scene;
        Source {
            bodies: loaded.world.bodies.clone(),
            acoustics: scene.acoustics,
            listeners: scene.listeners.iter().map(receivers).collect(),
            v_min: scene.simulation.v_min,
            time_step: Some(scene.simulation.time_step).filter(|_| solver(&loaded) == SolverChoice::Rigid),
            duration: scene.simulation.duration,
            settings: scene.render.clone(),
            rules: scene.sound_rules(),
            motion: Motion::Scene(Box::new(loaded)),
        }
    }

    /// A timeline; the scene stored in it has listeners and settings, unless `listeners` are asked for.
    pub(super) fn of_timeline(path: &Path, listeners: &[ListenerDescription]) -> Result<Self, Error> {
        let reader = TimelineReader::open(path)?;
        let header = reader.header();
        let scene = match header.scene.as_deref().map(Scene::from_toml) {
            Some(Ok(scene)) => Some(scene),
            Some(Err(errors)) => return Err(Error::StoredScene { path: path.into(), errors }),
            None => None,
        };
        let listeners = match &scene {
            Some(scene) if listeners.is_empty() => &scene.listeners,
            _ => listeners,
        };
        Ok(Source {
            bodies: header.world.bodies.clone(),
            acoustics: Acoustics {
                medium: header.medium,
                ..scene.as_ref().map(|s| s.acoustics).unwrap_or_default()
            },
            listeners: listeners.iter().map(receivers).collect(),
            v_min: header.origin.v_min,
            time_step: Some(header.origin.time_step).filter(|step| *step > 0.0 && header.origin.raw_log),
            duration: header.origin.duration,
            rules: scene.as_ref().map(Scene::sound_rules).unwrap_or_default(),
            settings: scene.map(|s| s.render).unwrap_or_default(),
            motion: Motion::Timeline(Box::new(reader)),
        })
    }
}

fn receivers(listener: &ListenerDescription) -> Listener {
    Listener { name: listener.name.clone(), track: listener.track.clone(), receivers: listener.receivers() }
}
