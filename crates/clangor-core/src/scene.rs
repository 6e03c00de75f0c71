//! Scenes: what the user wrote, as typed data, with every error found at once.
//!
//! ```text
//! text ──► Scene::from_toml ──► Scene ──► instantiate(loader) ──► World
//!            all errors, each               files read, copies placed,
//!            with line and remedy           links resolved
//! ```
//!
//! The format is documented in `docs/format/scene.md`. This module reads no files: meshes come from a loader
//! that the caller supplies.

pub mod body_description;
pub mod breaking;
mod decode;
pub mod diagnostic;
pub mod instantiate;
pub mod listener;
mod placement;
pub mod render_description;
pub mod simulation_description;
mod suggest;

use glam::DVec3;

use crate::acoustics::Acoustics;
use crate::body::BodyId;
use crate::synthesis::SoundRule;
use crate::synthesis::modal::RingingRule;
use body_description::{BodyDescription, HangDescription, PlaneDescription, SpringDescription};
use breaking::Breaking;
use diagnostic::{SceneErrors, SceneWarning};
use listener::ListenerDescription;
use render_description::RenderDescription;
use simulation_description::SimulationDescription;

pub use instantiate::instantiate;

/// Version of the format.
pub const VERSION: i64 = 1;

/// Most bodies that a scene may have.
pub const MAX_BODIES: u64 = 100_000;

/// Gravity where a scene names none [m/s²]: the standard acceleration of free fall (CGPM 1901), downwards.
pub const STANDARD_GRAVITY: DVec3 = DVec3::new(0.0, -9.80665, 0.0);

/// A scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Medium, air, room, floor and band limit.
    pub acoustics: Acoustics,
    /// Gravity [m/s²].
    pub gravity: DVec3,
    /// Bodies, in the order of the file.
    pub bodies: Vec<BodyDescription>,
    /// Planes.
    pub planes: Vec<PlaneDescription>,
    /// Hung spheres.
    pub hangs: Vec<HangDescription>,
    /// Springs.
    pub springs: Vec<SpringDescription>,
    /// Listeners.
    pub listeners: Vec<ListenerDescription>,
    /// Dynamics.
    pub simulation: SimulationDescription,
    /// Sound.
    pub render: RenderDescription,
    /// What is allowed but probably not meant.
    pub warnings: Vec<SceneWarning>,
}

impl Scene {
    /// What each body of the instantiated scene is to sound as, in their order; planes make no sound.
    pub fn sound_rules(&self) -> Vec<SoundRule> {
        let of = |body: &BodyDescription| (body.sound.unwrap_or(self.render.sound), body.count());
        let bodies = self.bodies.iter().map(of);
        bodies.flat_map(|(rule, count)| std::iter::repeat_n(rule, count)).collect()
    }

    /// Whether each body of the instantiated scene is to ring, and with whose modes, in their order.
    pub fn ringing_rules(&self) -> Vec<RingingRule> {
        let of = |body: &BodyDescription| std::iter::repeat_n(body.ringing, body.count());
        self.bodies.iter().flat_map(of).collect()
    }

    /// How each body of the instantiated scene breaks, in their order; `None` for those that do not.
    pub fn breaking_rules(&self) -> Vec<Option<&Breaking>> {
        let bodies = self.bodies.iter();
        bodies.flat_map(|body| std::iter::repeat_n(body.breaking.as_ref(), body.count())).collect()
    }

    /// The `[[body]]` of a body of the instantiated scene; `None` for planes.
    pub fn description_of(&self, body: BodyId) -> Option<&BodyDescription> {
        let mut first = 0;
        self.bodies.iter().find(|description| {
            first += description.count();
            body.index() < first
        })
    }

    /// Reads a scene.
    ///
    /// # Errors
    /// Every error of the text, in its order: TOML syntax, unknown keys, wrong types and ranges, names that
    /// stand for nothing, settings that exclude each other.
    pub fn from_toml(text: &str) -> Result<Scene, SceneErrors> {
        match decode::decode(text) {
            (scene, errors) if errors.is_empty() => Ok(scene),
            (_, errors) => Err(SceneErrors(errors)),
        }
    }

    /// As [`from_toml`](Self::from_toml); if there are errors, the mesh files are loaded too, so that missing
    /// and bad ones are reported with the rest.
    ///
    /// # Errors
    /// As `from_toml`, and those of the files beside them.
    pub fn from_toml_with_files(
        text: &str,
        load: &mut instantiate::Loader<'_>,
    ) -> Result<Scene, SceneErrors> {
        let (scene, mut errors) = decode::decode(text);
        if errors.is_empty() {
            return Ok(scene);
        }
        errors.extend(instantiate::file_errors(&scene, load));
        errors.sort_by_key(|e| e.place.order());
        Err(SceneErrors(errors))
    }
}
