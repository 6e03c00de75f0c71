//! A scene as data, and its construction without a text.

use glam::DVec3;

use super::body_description::{BodyDescription, Copies, PlaneDescription};
use super::breaking::Breaking;
use super::diagnostic::{Place, SceneWarning};
use super::link_description::{HangDescription, JointDescription, LoadDescription, SpringDescription};
use super::listener::ListenerDescription;
use super::render_description::RenderDescription;
use super::simulation_description::SimulationDescription;
use crate::acoustics::Acoustics;
use crate::body::BodyId;
use crate::material::Material;
use crate::sound_model::rule::SoundRule;

/// Version of the format.
pub const VERSION: i64 = 1;

/// Most bodies that a scene may have.
pub const MAX_BODIES: u64 = 100_000;

/// Default gravity [m/s²]: the standard acceleration of free fall (CGPM 1901), downwards.
pub const STANDARD_GRAVITY: DVec3 = DVec3::new(0.0, -9.80665, 0.0);

/// A scene: bodies, planes, links and listeners, with the settings of simulation and rendering.
///
/// ```
/// use clangor_core::glam::DVec3;
/// use clangor_core::material::presets;
/// use clangor_core::scene::body_description::{BodyDescription, PlaneDescription};
/// use clangor_core::scene::instantiate::load_shape;
/// use clangor_core::scene::listener::ListenerDescription;
/// use clangor_core::scene::{Scene, instantiate};
///
/// let ball = BodyDescription::shape("ball", presets::STEEL.material(), "sphere:0.01").at(DVec3::Y * 0.3);
/// let scene = Scene::new()
///     .body(ball)
///     .plane(PlaneDescription::new("ground", presets::GRANITE.material(), DVec3::ZERO, DVec3::Y))
///     .listener(ListenerDescription::mono("microphone", DVec3::new(0.5, 1.0, 0.0)))
///     .with_duration(1.0);
/// let world = instantiate(&scene, &mut load_shape)?.world;
/// assert_eq!(world.bodies.len(), 2);
/// # Ok::<(), clangor_core::scene::diagnostic::SceneErrors>(())
/// ```
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
    /// Suspended spheres.
    pub hangs: Vec<HangDescription>,
    /// Springs.
    pub springs: Vec<SpringDescription>,
    /// Hinges, ball joints, rods and ropes.
    pub joints: Vec<JointDescription>,
    /// Forces over time.
    pub loads: Vec<LoadDescription>,
    /// Listeners.
    pub listeners: Vec<ListenerDescription>,
    /// Materials that the scene defines itself, whether a body uses them or not.
    pub materials: Vec<Material>,
    /// Settings of the dynamics.
    pub simulation: SimulationDescription,
    /// Settings of the rendering.
    pub render: RenderDescription,
    /// Warnings: accepted, but probably not intended.
    pub warnings: Vec<SceneWarning>,
}

impl Default for Scene {
    fn default() -> Self {
        Scene {
            acoustics: Acoustics::default(),
            gravity: STANDARD_GRAVITY,
            bodies: Vec::new(),
            planes: Vec::new(),
            hangs: Vec::new(),
            springs: Vec::new(),
            joints: Vec::new(),
            loads: Vec::new(),
            listeners: Vec::new(),
            materials: Vec::new(),
            simulation: SimulationDescription::default(),
            render: RenderDescription::default(),
            warnings: Vec::new(),
        }
    }
}

impl Scene {
    /// An empty scene in free air under standard gravity, with the default simulation and rendering.
    pub fn new() -> Self {
        Scene::default()
    }

    /// Adds a body, or copies of one; its name must differ from those of other bodies and planes.
    #[must_use]
    pub fn body(mut self, body: BodyDescription) -> Self {
        self.bodies.push(body);
        self
    }

    /// Adds a plane.
    #[must_use]
    pub fn plane(mut self, plane: PlaneDescription) -> Self {
        self.planes.push(plane);
        self
    }

    /// Adds a listener.
    #[must_use]
    pub fn listener(mut self, listener: ListenerDescription) -> Self {
        self.listeners.push(listener);
        self
    }

    /// The same scene with other acoustics.
    #[must_use]
    pub fn with_acoustics(self, acoustics: Acoustics) -> Self {
        Scene { acoustics, ..self }
    }

    /// The same scene with another gravity [m/s²].
    #[must_use]
    pub fn with_gravity(self, gravity: DVec3) -> Self {
        Scene { gravity, ..self }
    }

    /// The same scene simulated for another duration \[s\].
    #[must_use]
    pub fn with_duration(mut self, duration: f64) -> Self {
        self.simulation.duration = duration;
        self
    }

    /// The sound model rules, one for each body of the instantiated scene in its order; none for planes.
    pub fn sound_rules(&self) -> Vec<SoundRule> {
        let of = |body: &BodyDescription| {
            let rule =
                SoundRule { acceleration: body.sound.unwrap_or(self.render.sound), modal: body.ringing };
            std::iter::repeat_n(rule, body.count())
        };
        self.bodies.iter().flat_map(of).collect()
    }

    /// Fracture settings of each body of the instantiated scene, in their order; `None` for those that do not
    /// break.
    pub fn breaking_rules(&self) -> Vec<Option<&Breaking>> {
        let bodies = self.bodies.iter();
        bodies.flat_map(|body| std::iter::repeat_n(body.breaking.as_ref(), body.count())).collect()
    }

    /// The place in the text of the body, copy or plane with this name in the instantiated scene.
    pub fn place_of(&self, name: &str) -> Option<&Place> {
        let has_copy = |body: &BodyDescription| {
            body.copies != Copies::One
                && name
                    .strip_prefix(body.name.as_str())
                    .and_then(|rest| rest.strip_prefix('-')?.parse::<usize>().ok())
                    .is_some_and(|number| (1..=body.count()).contains(&number))
        };
        let bodies = self.bodies.iter();
        let body = bodies.clone().find(|b| b.name == name).or_else(|| bodies.clone().find(|b| has_copy(b)));
        let plane = || self.planes.iter().find(|plane| plane.name == name).map(|plane| &plane.place);
        body.map(|body| &body.place).or_else(plane)
    }

    /// The `[[body]]` of a body of the instantiated scene; `None` for planes.
    pub fn description_of(&self, body: BodyId) -> Option<&BodyDescription> {
        let mut first = 0;
        self.bodies.iter().find(|description| {
            first += description.count();
            body.index() < first
        })
    }
}
