//! Settings of a real-time engine: sample rate, acoustics, receivers, block length and limits of the work.

use super::budget::Budget;
use crate::acoustics::Acoustics;
use crate::contact::ForceProfile;
use crate::propagation::{Air, PropagationPaths, ReflectingPlanes, Room};
use crate::scene::Scene;
use crate::synthesis::listener::Floor;
use crate::synthesis::{RenderSettings, SampleRate};

/// Largest number of receivers.
pub const MOST_RECEIVERS: usize = 2;
/// Longest block \[samples\].
pub const LONGEST_BLOCK: usize = 4096;
/// Shortest block \[samples\].
const SHORTEST_BLOCK: usize = 16;
/// Largest reach \[m\].
const FARTHEST: f64 = 1000.0;

/// Settings of a real-time engine. The defaults: 48 kHz, two receivers in unbounded air, blocks of 128
/// samples, 64 objects.
///
/// The `with_` methods replace one setting each:
///
/// ```
/// use clangor_core::realtime::EngineSettings;
/// use clangor_core::synthesis::listener::Floor;
///
/// let settings = EngineSettings::default().with_floor(Floor::Rigid { height: 0.0 }).with_objects(8);
/// assert_eq!((settings.objects, settings.receivers), (8, 2));
/// ```
#[derive(Clone, Debug)]
pub struct EngineSettings {
    /// Samples per second.
    pub sample_rate: SampleRate,
    /// Medium, air, room, floor, planes and band limit.
    pub acoustics: Acoustics,
    /// Force of an impact over its duration.
    pub profile: ForceProfile,
    /// Number of receivers: 1, or 2 for two ears.
    pub receivers: usize,
    /// Longest block for which every event of the preceding block is in time \[samples\].
    pub block: usize,
    /// Longest path of a sound \[m\]; raised to include all reflections of the room.
    pub reach: f64,
    /// Number of object slots.
    pub objects: usize,
    /// Largest work of a block.
    pub budget: Budget,
}

impl Default for EngineSettings {
    fn default() -> Self {
        EngineSettings {
            sample_rate: SampleRate::default(),
            acoustics: Acoustics::default(),
            profile: ForceProfile::default(),
            receivers: 2,
            block: 128,
            reach: 40.0,
            objects: 64,
            budget: Budget::default(),
        }
    }
}

impl EngineSettings {
    /// The acoustics and the force profile of a scene.
    pub fn from_scene(scene: &Scene) -> Self {
        EngineSettings {
            acoustics: scene.acoustics,
            profile: scene.render.pulse,
            ..EngineSettings::default()
        }
    }

    /// Replaces the sample rate.
    #[must_use]
    pub fn with_sample_rate(self, sample_rate: SampleRate) -> Self {
        EngineSettings { sample_rate, ..self }
    }

    /// Replaces the force profile of impacts.
    #[must_use]
    pub fn with_profile(self, profile: ForceProfile) -> Self {
        EngineSettings { profile, ..self }
    }

    /// Replaces the reflecting floor.
    #[must_use]
    pub fn with_floor(mut self, floor: Floor) -> Self {
        self.acoustics.floor = floor;
        self
    }

    /// Replaces the room; `None` for none.
    #[must_use]
    pub fn with_room(mut self, room: Option<Room>) -> Self {
        self.acoustics.room = room;
        self
    }

    /// Replaces the reflecting planes.
    #[must_use]
    pub fn with_planes(mut self, planes: ReflectingPlanes) -> Self {
        self.acoustics.planes = planes;
        self
    }

    /// Replaces the absorption by the air; `None` for none.
    #[must_use]
    pub fn with_air(mut self, air: Option<Air>) -> Self {
        self.acoustics.air = air;
        self
    }

    /// Replaces the number of receivers: 1 or 2.
    #[must_use]
    pub fn with_receivers(self, receivers: usize) -> Self {
        EngineSettings { receivers, ..self }
    }

    /// Replaces the block length \[samples\].
    #[must_use]
    pub fn with_block(self, block: usize) -> Self {
        EngineSettings { block, ..self }
    }

    /// Replaces the longest path of a sound \[m\].
    #[must_use]
    pub fn with_reach(self, reach: f64) -> Self {
        EngineSettings { reach, ..self }
    }

    /// Replaces the number of object slots.
    #[must_use]
    pub fn with_objects(self, objects: usize) -> Self {
        EngineSettings { objects, ..self }
    }

    /// Replaces the largest work of a block.
    #[must_use]
    pub fn with_budget(self, budget: Budget) -> Self {
        EngineSettings { budget, ..self }
    }

    /// The settings within their limits: 1 or 2 receivers, blocks of 16 to 4096 samples, a reach up to 1 km
    /// that includes the reflections of the room.
    #[must_use]
    pub fn clamped(&self) -> Self {
        let reflected = self
            .acoustics
            .room
            .as_ref()
            .map_or(0.0, |room| room.extent().length() * f64::from(room.image_order.max(1) + 1));
        let reach = if self.reach > 0.0 { self.reach } else { EngineSettings::default().reach };
        EngineSettings {
            receivers: self.receivers.clamp(1, MOST_RECEIVERS),
            block: self.block.clamp(SHORTEST_BLOCK, LONGEST_BLOCK),
            reach: reach.max(reflected).min(FARTHEST),
            ..self.clone()
        }
    }

    /// Settings of the pulses and voices.
    pub(super) fn rendering(&self) -> RenderSettings {
        let Acoustics { medium, max_frequency, .. } = self.acoustics;
        let acoustics = Acoustics { medium, max_frequency, ..Acoustics::default() };
        RenderSettings { sample_rate: self.sample_rate, acoustics, ..RenderSettings::default() }
    }

    /// Propagation paths to each receiver.
    pub(super) fn paths(&self) -> PropagationPaths {
        self.acoustics.paths()
    }

    /// Longest propagation delay \[s\].
    pub(super) fn longest_delay(&self) -> f64 {
        self.reach / self.acoustics.medium.sound_speed
    }
}
