//! Recipes of data sets: which bodies are struck, where, by what, and where it is heard.
//!
//! A recipe draws its strikes at random, or takes them from a table and draws what the table does not have.
//! `docs/format/dataset.md` describes the text. This module reads no files.

use glam::DVec3;

use super::body_description::Geometry;
use super::diagnostic::Place;
use crate::material::{Material, presets};
use crate::propagation::Room;

/// A recipe of strikes: see the module.
#[derive(Clone, Debug, PartialEq)]
pub struct StrikeRecipe {
    /// Seed of all that is drawn. Default: 0.
    pub seed: u64,
    /// Number of strikes that are drawn; `None` where a table lists them.
    pub count: Option<u64>,
    /// Path of a table of strikes, relative to the recipe.
    pub table: Option<String>,
    /// Strikes in a row on one body of one material. Default: 1.
    pub repeat: u64,
    /// Samples per second \[Hz\], 8000 to 384 000. Default: 48 000.
    pub sample_rate: u32,
    /// End of each sound after the beginning of the contact \[s\]. Default: 1.
    pub seconds: f64,
    /// Bodies.
    pub objects: Vec<StruckObject>,
    /// Materials that the recipe defines.
    pub materials: Vec<Material>,
    /// What strikes the bodies; one is drawn for each strike.
    pub strikers: Vec<StrikerDescription>,
    /// Where they are heard; one is drawn for each strike.
    pub listeners: Vec<ListenerPlacement>,
    /// Rooms; one is drawn for each strike. Empty: free space.
    pub rooms: Vec<StrikeRoom>,
}

impl Default for StrikeRecipe {
    fn default() -> Self {
        StrikeRecipe {
            seed: 0,
            count: None,
            table: None,
            repeat: 1,
            sample_rate: 48_000,
            seconds: 1.0,
            objects: Vec::new(),
            materials: Vec::new(),
            strikers: Vec::new(),
            listeners: Vec::new(),
            rooms: Vec::new(),
        }
    }
}

impl StrikeRecipe {
    /// The material of a name: one that the recipe defines, or a preset.
    pub fn material(&self, name: &str) -> Option<Material> {
        let own = self.materials.iter().find(|material| material.name == name);
        own.cloned().or_else(|| presets::preset(name))
    }

    /// Names of all materials, those of the recipe first.
    pub fn material_names(&self) -> impl Iterator<Item = &str> {
        let presets = presets::names().map(|name| -> &str { name });
        self.materials.iter().map(|material| material.name.as_str()).chain(presets)
    }
}

/// A body of a recipe.
#[derive(Clone, Debug, PartialEq)]
pub struct StruckObject {
    /// Name, unique in the recipe. Default: its shape or file.
    pub name: String,
    /// A shape, or a mesh file or sound model relative to the recipe.
    pub geometry: Geometry,
    /// Factor on its lengths \[-\].
    pub scale: f64,
    /// Its materials; one is drawn for each strike.
    pub materials: Vec<Material>,
    /// Points that may be struck \[m from the centre of mass\]; empty: anywhere, evenly by area.
    pub points: Vec<DVec3>,
    /// Place in the text.
    pub place: Place,
}

/// What strikes a body.
#[derive(Clone, Debug, PartialEq)]
pub enum StrikerDescription {
    /// A ball.
    Ball {
        /// Its materials; one is drawn for each strike.
        materials: Vec<Material>,
        /// Radius \[m\].
        radius: Distribution,
        /// Speed along the normal [m/s].
        speed: Distribution,
    },
    /// A force along the normal, into the body.
    Force {
        /// Impulse [N s].
        impulse: Distribution,
        /// Duration \[s\]; `None`: that of a collision with a rigid plane at 1 m/s.
        duration: Option<Distribution>,
    },
}

/// Where a listener is, relative to the centre of mass of the body.
#[derive(Clone, Debug, PartialEq)]
pub enum ListenerPlacement {
    /// Within a box, along the axes of the body.
    Position([Distribution; 3]),
    /// At a distance \[m\] in one direction.
    Along {
        /// Unit vector.
        direction: DVec3,
        /// \[m\].
        distance: Distribution,
    },
    /// At a distance, evenly over a part of the sphere between two azimuths (about y, from x towards z) and
    /// two elevations \[rad\].
    Around {
        /// \[m\].
        distance: Distribution,
        /// \[rad\].
        azimuth: [f64; 2],
        /// \[rad\].
        elevation: [f64; 2],
    },
}

/// A room, and where the body is in it.
#[derive(Clone, Debug, PartialEq)]
pub struct StrikeRoom {
    /// Name, unique in the recipe.
    pub name: String,
    /// The room.
    pub room: Room,
    /// Centre of mass of the body \[m\].
    pub body: [Distribution; 3],
}

/// A number that is drawn for each strike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Distribution {
    /// Always the same.
    Constant(f64),
    /// Even between two numbers.
    Uniform([f64; 2]),
    /// Its logarithm is even between those of two positive numbers.
    LogUniform([f64; 2]),
}

impl Distribution {
    /// The number below which lies a `share` of the draws, 0 to 1.
    pub fn quantile(&self, share: f64) -> f64 {
        match *self {
            Distribution::Constant(value) => value,
            Distribution::Uniform([low, high]) => (low + (high - low) * share).clamp(low, high),
            Distribution::LogUniform([low, high]) => (low * (high / low).powf(share)).clamp(low, high),
        }
    }
}
