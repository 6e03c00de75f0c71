//! Bodies and random impulses between them: timelines as dense as those of the papers' scenes.
//!
//! An impulse is one row between two bodies that touch at a point, at random places above a table, with
//! random orientations and approach speeds of 0.1 to 2 m/s. Both bodies sound if both are free.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;

use clangor_core::body::{Body, BodyId, Motion, Surface};
use clangor_core::contact::ContactSettings;
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::glam::{DQuat, DVec3};
use clangor_core::material::presets;
use clangor_core::medium::Medium;
use clangor_core::scene::render_description::{GroundSound, Parts};
use clangor_core::shape::Shape;
use clangor_core::sound_model::acceleration::model_evaluator::BankEvaluator;
use clangor_core::sound_model::{AccelerationRule, SoundRule};
use clangor_core::synthesis::SoundModel;
use clangor_core::synthesis::{Listener, RenderSettings};
use clangor_core::timeline::{ContactKind, ContactRow, PoseRow, Timeline};
use clangor_pipeline::formats::model_cache::ModelCache;
use clangor_pipeline::formats::wav::SampleFormat;
use clangor_pipeline::stages::render::{FullScale, RenderOptions, Transfers, render};
use clangor_pipeline::stages::sound_models::patience::PATIENCE;
use clangor_pipeline::stages::sound_models::{
    AccelerationSettings, SoundModelPlan, SoundModelSettings, SoundModelStore,
};

use crate::cpu_time::cpu_time;

/// Some equal bodies, or some of one kind: `{n}` in the shape is their number.
pub struct Group {
    /// Shape, as `Shape::parse` reads it.
    pub shape: &'static str,
    /// Name of a preset.
    pub material: &'static str,
    /// Number of bodies.
    pub count: usize,
    /// Sound model of the bodies.
    pub rule: AccelerationRule,
}

/// The microphone of \[PAN\] §5; the table is centred at x = z = 0, 0.4 m high, 1.8 m long, 0.8 m wide.
const MICROPHONE: DVec3 = DVec3::new(1.0, 1.8, 1.0);
/// Level error of the fields.
const ACCURACY: f64 = 1e-2;

/// Uniform numbers in [0, 1): the multiplicative congruential generator of Park and Miller.
pub struct Uniform(pub u64);

impl Uniform {
    /// The next number.
    pub fn sample(&mut self) -> f64 {
        self.0 = self.0 * 48_271 % 2_147_483_647;
        self.0 as f64 / 2_147_483_647.0
    }

    fn between(&mut self, low: DVec3, high: DVec3) -> DVec3 {
        low + (high - low) * DVec3::new(self.sample(), self.sample(), self.sample())
    }

    /// A random unit vector.
    pub fn direction(&mut self) -> DVec3 {
        let z = 2.0 * self.sample() - 1.0;
        let (sin, cos) = (std::f64::consts::TAU * self.sample()).sin_cos();
        let ring = (1.0 - z * z).sqrt();
        DVec3::new(ring * cos, ring * sin, z)
    }
}

/// Bodies of a scene and their sound rules.
pub struct Stage {
    /// Bodies in the order of the groups; the table last.
    pub bodies: Vec<Body>,
    rules: Vec<AccelerationRule>,
}

impl Stage {
    /// With the bodies of all groups, and a table if `table`.
    pub fn new(groups: &[Group], table: bool) -> Self {
        let mut stage = Stage { bodies: Vec::new(), rules: Vec::new() };
        for group in groups {
            let mut known: BTreeMap<String, (Arc<Surface>, MassProperties)> = BTreeMap::new();
            for n in 0..group.count {
                let text = group.shape.replace("{n}", &(n + 1).to_string());
                let (surface, mass) = known.entry(text).or_insert_with_key(|text| {
                    let shape = Shape::parse(text).expect("a shape of the library");
                    let (surface, mass) = shape.surface().expect("a solid");
                    (Arc::new(surface), mass)
                });
                let name = format!("{} {}", group.shape, n + 1);
                stage.add(name, group.material, Arc::clone(surface), mass, Motion::Free, group.rule);
            }
        }
        if table {
            let shape = Shape::parse("box:1.8x0.04x0.8").expect("a box");
            let (surface, mass) = shape.surface().expect("a solid");
            stage.add(
                "table".into(),
                "wood",
                Arc::new(surface),
                &mass,
                Motion::Fixed,
                AccelerationRule::Auto,
            );
        }
        stage
    }

    fn add(
        &mut self,
        name: String,
        material: &str,
        surface: Arc<Surface>,
        mass: &MassProperties,
        motion: Motion,
        rule: AccelerationRule,
    ) {
        let material = presets::preset(material).expect("a preset");
        let body = Body::solid(name, material, surface, mass)
            .at(DVec3::Y * 0.38)
            .with_motion(motion)
            .with_edge_radius(2e-4);
        self.bodies.push(body);
        self.rules.push(rule);
    }

    /// Fields for a band \[Hz\], from the cache or baked; prints the bakes and their warnings.
    pub fn models(
        &self,
        frequency: f64,
        cache: &ModelCache,
        bank: Option<&BankEvaluator>,
    ) -> Vec<SoundModel> {
        let highest = std::f64::consts::TAU * frequency / Medium::AIR.sound_speed;
        let settings = SoundModelSettings {
            acceleration: AccelerationSettings::new(highest, ACCURACY, PATIENCE),
            wants_acceleration: true,
            modal: None,
            patience: f64::INFINITY,
        };
        let rules: Vec<SoundRule> = self.rules.iter().copied().map(SoundRule::from).collect();
        let plan = SoundModelPlan::new(&self.bodies, &rules, settings);
        let store = SoundModelStore { cache: Some(cache), bank };
        let sounding: BTreeSet<BodyId> = (0..self.bodies.len() as u32).map(BodyId).collect();
        let found = plan
            .find(&self.bodies, &sounding, store, &mut |_| ControlFlow::Continue(()))
            .expect("no interruption");
        found.remarks.iter().for_each(|remark| eprintln!("{remark}"));
        found.bodies
    }

    /// `impulses` impulses, evenly over `seconds`. With a table, every second body is the table.
    pub fn timeline(&self, impulses: usize, seconds: f64) -> Timeline {
        let mut uniform = Uniform(11);
        let mut timeline = Timeline::default();
        let table = self.bodies.iter().position(|b| b.motion == Motion::Fixed);
        let free = self.bodies.len() - usize::from(table.is_some());
        // Random pair, point, normal and speed.
        for i in 0..impulses {
            let time = seconds * (i as f64 + 0.5) / impulses as f64;
            let a = (uniform.sample() * free as f64) as usize;
            let b = match table {
                Some(table) => table,
                None => (a + 1 + (uniform.sample() * (free - 1) as f64) as usize) % free,
            };
            let point = uniform.between(DVec3::new(-0.7, 0.45, -0.3), DVec3::new(0.7, 0.9, 0.3));
            let normal = uniform.direction();
            let speed = 0.1 + 1.9 * uniform.sample();
            let mut mass = f64::INFINITY;
            // Poses of the free bodies, then the contact.
            for (body, side) in [(a, 1.0), (b, -1.0)] {
                if Some(body) == table {
                    continue;
                }
                mass = mass.min(self.bodies[body].mass);
                timeline.poses.push(PoseRow {
                    time,
                    body: BodyId(body as u32),
                    position: point + normal * (side * 0.6 * self.radius(body)),
                    orientation: DQuat::from_scaled_axis(uniform.direction() * 3.0 * uniform.sample()),
                    velocity: DVec3::ZERO,
                    angular_velocity: DVec3::ZERO,
                });
            }
            timeline.contacts.push(ContactRow {
                time,
                body_a: BodyId(a as u32),
                body_b: BodyId(b as u32),
                kind: ContactKind::Impact,
                point,
                normal,
                impulse_n: 0.7 * mass * speed,
                impulse_t: DVec3::ZERO,
                couple: DVec3::ZERO,
                velocity: normal * -speed,
                depth: 0.0,
                impact_id: i as u64 + 1,
                effective_mass: None,
            });
        }
        timeline
    }

    fn radius(&self, body: usize) -> f64 {
        match &*self.bodies[body].surface {
            Surface::Sphere { radius } => *radius,
            Surface::Mesh(mesh) => mesh.mesh.bounding_radius(DVec3::ZERO),
            Surface::HalfSpace | Surface::Plate { .. } => 0.0,
        }
    }

    /// Renders for one microphone into a file.
    pub fn render(&self, models: &[SoundModel], timeline: &Timeline, seconds: f64, file: &Path) -> Rendered {
        let options = RenderOptions {
            listeners: vec![Listener::fixed("microphone", MICROPHONE)],
            contact: ContactSettings::default(),
            synthesis: RenderSettings::default(),
            parts: Parts { acceleration: true, modal: false, ground: false },
            transfers: Transfers::Baked,
            rolling: None,
            ground: GroundSound::None,
            inherit_vibration: true,
            to: seconds + 0.05,
            format: SampleFormat::Float32,
            full_scale: FullScale::Pascals(1.0),
            compressor: None,
            stems: false,
            note: String::new(),
        };
        let begin = cpu_time();
        let summary =
            render(&self.bodies, models, timeline, &options, file, &mut |_| ControlFlow::Continue(()))
                .expect("a sound");
        Rendered { seconds: cpu_time() - begin, clicks: summary.listeners.iter().map(|l| l.clicks).sum() }
    }
}

/// Cost of a rendering.
pub struct Rendered {
    /// CPU time of all threads from the timeline to the file \[s\].
    pub seconds: f64,
    /// Number of clicks: sounding bodies over all impulses.
    pub clicks: u64,
}

/// Cache folder shared by runs of the programs.
pub fn cache() -> ModelCache {
    ModelCache::new(std::env::temp_dir().join("clangor-paper-scenes"))
}
