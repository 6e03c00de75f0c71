//! The sound of one strike with its labels.

use std::sync::Arc;

use clangor_core::glam::DVec3;
use clangor_core::propagation::Room;
use clangor_core::synthesis::strike::{self, StrikeError, StrikeForce, Striker};

use super::Dataset;
use super::draws::{Draws, Quantity};
use super::error::DatasetError;
use super::strikes::{DrawnForce, DrawnStrike};
use super::struck_bodies::ReadyBody;
use crate::session;
use crate::session::strike::usual_impact;

/// A strike: its sound, and everything that made it. Vectors have the axes of the body and begin at its
/// centre of mass.
#[derive(Clone, Debug, PartialEq)]
pub struct LabelledStrike {
    /// Number in the data set, from 0.
    pub index: u64,
    /// Seed of the data set.
    pub seed: u64,
    /// Name of the body.
    pub object: String,
    /// Name of its material.
    pub material: String,
    /// Mass of the body \[kg\].
    pub mass: f64,
    /// Whether its sound model is a draft.
    pub draft: bool,
    /// Struck point \[m\].
    pub point: DVec3,
    /// Outward unit normal there.
    pub normal: DVec3,
    /// The ball that strikes; `None` for a given force.
    pub striker: Option<StrikerLabel>,
    /// Impulse on the body [N s].
    pub impulse: DVec3,
    /// Largest force below half the sample rate \[N\].
    pub peak_force: f64,
    /// Duration of the contact \[s\].
    pub contact_duration: f64,
    /// Listener \[m\].
    pub listener: DVec3,
    /// The room; `None` for free space.
    pub room: Option<StrikeRoomLabel>,
    /// Frequencies of the modes without damping \[Hz\].
    pub frequencies: Arc<[f64]>,
    /// Times in which the modes fall by 60 dB \[s\].
    pub t60s: Arc<[f64]>,
    /// Samples per second \[Hz\].
    pub sample_rate: u32,
    /// Time of the first sample after the beginning of the contact \[s\].
    pub start: f64,
    /// Largest absolute pressure \[Pa\].
    pub peak_pressure: f64,
    /// Pressure at the listener \[Pa\].
    pub samples: Vec<f32>,
}

/// A ball that strikes.
#[derive(Clone, Debug, PartialEq)]
pub struct StrikerLabel {
    /// Name of its material.
    pub material: String,
    /// Radius \[m\].
    pub radius: f64,
    /// Speed along the normal [m/s].
    pub speed: f64,
}

/// A room with a body in it.
#[derive(Clone, Debug, PartialEq)]
pub struct StrikeRoomLabel {
    /// Its name.
    pub name: String,
    /// Centre of mass of the body in it \[m\].
    pub body: DVec3,
}

impl Dataset {
    /// The sound and the labels of a strike.
    pub(super) fn labelled(
        &self,
        drawn: &DrawnStrike,
        ready: &ReadyBody,
    ) -> Result<LabelledStrike, DatasetError> {
        let recipe = &self.strikes.recipe;
        let (object, material) = drawn.body;
        let object = &self.strikes.objects[object];
        let body = ready.struck.body();
        let point = drawn.point.unwrap_or_else(|| {
            ready.points.draw(&body.surface, &mut Draws::of(recipe.seed, drawn.index, Quantity::Point))
        });
        let failed = |source: StrikeError| DatasetError::Strike {
            place: self.strikes.place(drawn.index, column(&source)),
            object: object.name.clone(),
            source: Box::new(source),
        };
        let given = drawn.normal.and_then(DVec3::try_normalize);
        let normal = given.or_else(|| body.surface.normal_at(point));
        let outward = normal.ok_or_else(|| failed(StrikeError::NoNormal { point }))?;
        let impact = strike::Strike {
            force: force(drawn, outward),
            listener: drawn.listener,
            sample_rate: self.settings.sample_rate,
            max_frequency: self.settings.choice.options.max_frequency,
            seconds: Some(recipe.seconds),
            room: drawn.room.map(|(room, body)| around(&recipe.rooms[room].room, body)),
            ..usual_impact(point)
        };
        let (sound, _) = ready.sounding.sound(&impact, recipe.seconds).map_err(|error| match error {
            session::Error::Strike(source) => failed(source),
            source => DatasetError::Object {
                object: object.name.clone(),
                material: self.strikes.materials[material].name.clone(),
                source: Box::new(source),
            },
        })?;
        let striker = match &drawn.force {
            DrawnForce::Ball { material, radius, speed } => {
                Some(StrikerLabel { material: material.name.clone(), radius: *radius, speed: *speed })
            }
            DrawnForce::Along { .. } | DrawnForce::Impulse { .. } => None,
        };
        Ok(LabelledStrike {
            index: drawn.index,
            seed: recipe.seed,
            object: object.name.clone(),
            material: body.material.name.clone(),
            mass: body.mass,
            draft: ready.is_draft,
            point,
            normal: outward,
            striker,
            impulse: sound.impulse,
            peak_force: sound.peak_force,
            contact_duration: sound.contact_duration,
            listener: drawn.listener,
            room: drawn
                .room
                .map(|(room, body)| StrikeRoomLabel { name: recipe.rooms[room].name.clone(), body }),
            frequencies: Arc::clone(&ready.frequencies),
            t60s: Arc::clone(&ready.t60s),
            sample_rate: recipe.sample_rate,
            start: -strike::LEAD,
            peak_pressure: sound.peak(),
            samples: sound.pressures.iter().map(|p| *p as f32).collect(),
        })
    }
}

/// What strikes a body whose outward normal is `outward`.
fn force(drawn: &DrawnStrike, outward: DVec3) -> StrikeForce {
    match &drawn.force {
        DrawnForce::Ball { material, radius, speed } => {
            let ball = Striker::new(material.clone(), *radius, *speed);
            StrikeForce::Striker(Striker { normal: drawn.normal, ..ball })
        }
        DrawnForce::Along { impulse, duration } => {
            StrikeForce::Impulse { impulse: -*impulse * outward, duration: *duration }
        }
        DrawnForce::Impulse { impulse, duration } => {
            StrikeForce::Impulse { impulse: *impulse, duration: *duration }
        }
    }
}

/// A room with its corners relative to a body in it.
fn around(room: &Room, body: DVec3) -> Room {
    Room { lowest: room.lowest - body, highest: room.highest - body, ..*room }
}

/// The column of a table that an error is about.
fn column(error: &StrikeError) -> &'static str {
    match error {
        StrikeError::OffSurface { .. } => "point",
        StrikeError::NoNormal { .. } | StrikeError::ZeroNormal | StrikeError::InwardNormal { .. } => "normal",
        StrikeError::ListenerInside { .. } => "listener",
        StrikeError::Striker { .. } => "striker",
        StrikeError::NoImpulse => "impulse",
        StrikeError::Duration { .. } => "duration",
        StrikeError::Immovable { .. } => "object",
        StrikeError::NotFinite { .. }
        | StrikeError::Contact(_)
        | StrikeError::Seconds { .. }
        | StrikeError::Room(_)
        | StrikeError::Synthesis(_) => "strike",
    }
}
