//! Processor time of the real-time engine on one core:
//! `cargo bench --profile release -p clangor-core --bench live -- soak 600`.
//!
//! A thousand impacts on spheres a second, in bursts of up to fifty in a block, and fifty objects of a
//! hundred modes that vibrate all the time, in blocks of 128 samples at 48 kHz for two ears. Times are those
//! of the thread, so that other programs count only by their use of the caches.
//!
//! * `soak SECONDS`: so many seconds of sound, objects at rest. Prints the share of real time and the times
//!   of blocks: median, 99 %, 99.99 %, longest.
//! * `moving SECONDS`: the same while all objects and the ears move, and transfers follow.
//! * `histories SECONDS`: at rest; the forces of impacts on objects, and of one on a sphere in ten, have
//!   histories of 0.3 to 11 ms.
//! * `floor SECONDS`, `room SECONDS`: at rest over a rigid floor, and in a room with late reverberation.

use std::sync::Arc;

use clangor_core::contact::ForceHistory;
use clangor_core::glam::{DQuat, DVec3};
use clangor_core::material::Damping;
use clangor_core::math::random::SplitMix;
use clangor_core::medium::Medium;
use clangor_core::pose::Pose;
use clangor_core::propagation::{Air, Room, WallAbsorption};
use clangor_core::realtime::{
    Controller, EngineSettings, Event, ImpactEvent, ImpactTarget, SoundingObject, engine,
};
use clangor_core::sound_model::modal::model::{ModalMode, ModalModel, ModalTransfer};
use clangor_core::sound_model::modal::surface::ModalSurface;
use clangor_core::synthesis::listener::Floor;
use clangor_core::synthesis::modal::{ModalSettings, ModalSource};
use num_complex::Complex64;
use rustix::time::{ClockId, clock_gettime};

const BLOCK: usize = 128;
const RATE: f64 = 48_000.0;
const OBJECTS: usize = 50;
const MODES: usize = 100;
/// Impacts on spheres in a second, and in the largest burst.
const CLICKS: f64 = 1000.0;
const BURST: usize = 50;
/// Impacts on objects in a second.
const IMPACTS: f64 = 100.0;

/// Processor time of this thread [s].
fn thread_time() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

/// A hundred modes up to 18 kHz that decay over seconds, with transfers of the orders that their wavelengths
/// have on 10 cm.
fn source(random: &mut SplitMix) -> Arc<ModalSource> {
    let radius = 0.1;
    let corners = [DVec3::ZERO, DVec3::X, DVec3::Y].map(|x| radius * x);
    let middles = [(0, 1), (1, 2), (2, 0)].map(|(a, b)| 0.5 * (corners[a] + corners[b]));
    let nodes: Vec<DVec3> = corners.into_iter().chain(middles).collect();
    let modes = (0..MODES).map(|i| {
        let frequency = 300.0 + 177.0 * i as f64;
        let order = (std::f64::consts::TAU * frequency * radius / 343.2) as usize + 2;
        let coefficient = |_| Complex64::new(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0));
        let coefficients: Vec<_> = (0..(order + 1).pow(2)).map(coefficient).collect();
        let transfer = Some(ModalTransfer { order, coefficients });
        ModalMode {
            frequency,
            mesh_error: 0.0,
            support_damping: 0.0,
            shape: vec![random.direction(); 6],
            transfer,
        }
    });
    let model = ModalModel {
        radius,
        medium: Medium::AIR,
        density: 2700.0,
        max_frequency: 20_000.0,
        statistical_above: None,
        modes: modes.collect(),
        surface: ModalSurface { nodes, triangles: vec![[0, 1, 2, 3, 4, 5]] },
    };
    let settings = ModalSettings { radiation_damping: false, ..ModalSettings::default() };
    Arc::new(ModalSource::new(Arc::new(model), &Damping::T60(4.0), &settings).expect("a good model"))
}

/// The events of a soak: bursts of impacts on spheres, impacts on objects, and motion.
struct Load {
    random: SplitMix,
    places: Vec<DVec3>,
    moving: bool,
    histories: bool,
    /// Impacts on spheres and on objects that are due.
    due: [f64; 2],
    /// Number of impacts on spheres in the next burst.
    next_burst: usize,
}

impl Load {
    /// Sends the events of a block that begins at `time` \[s\].
    fn send(&mut self, controller: &mut Controller, block: usize, time: f64) {
        self.due[0] += CLICKS * BLOCK as f64 / RATE;
        self.due[1] += IMPACTS * BLOCK as f64 / RATE;
        // Impacts on spheres wait until the burst is complete.
        if self.due[0] >= self.next_burst as f64 {
            self.due[0] -= self.next_burst as f64;
            for _ in 0..self.next_burst {
                controller.send(self.sphere_impact(time)).expect("room in the ring");
            }
            // Mostly a few, sometimes fifty.
            self.next_burst = (1.0 + BURST as f64 * self.random.uniform(0.0, 1.0).powi(4)) as usize;
        }
        while self.due[1] >= 1.0 {
            self.due[1] -= 1.0;
            controller.send(self.object_impact(time)).expect("room in the ring");
        }
        // Poses come as often as a picture is drawn; at rest once is enough.
        if if self.moving { block.is_multiple_of(6) } else { block == 0 } {
            self.send_motion(controller, time);
        }
    }

    /// The impact, with a history if it is to have one.
    fn with_history(&mut self, impact: ImpactEvent, share: f64) -> ImpactEvent {
        if !self.histories || self.random.uniform(0.0, 1.0) > share {
            return impact;
        }
        let duration = 0.3e-3 * self.random.uniform(0.0, 36_f64.ln()).exp();
        let forces: Vec<f64> = (0..400).map(|n| (0.02 * f64::from(n)).sin().abs()).collect();
        let history = ForceHistory::of_steps(&forces, duration / 400.0, 24e3);
        ImpactEvent { duration, force: history.map(|(history, _)| Arc::new(history)), ..impact }
    }

    fn sphere_impact(&mut self, time: f64) -> ImpactEvent {
        let random = &mut self.random;
        let target = ImpactTarget::Sphere { radius: random.uniform(0.003, 0.03) };
        let time = time + random.uniform(0.0, BLOCK as f64 / RATE);
        let impact = ImpactEvent::new(target, time, random.uniform(30e-6, 200e-6))
            .at(2.0 * random.direction())
            .with_velocity_change(random.direction());
        self.with_history(impact, 0.1)
    }

    fn object_impact(&mut self, time: f64) -> ImpactEvent {
        let slot = (self.random.uniform(0.0, 1.0) * OBJECTS as f64) as usize;
        let place = self.places[slot];
        let impact =
            ImpactEvent::new(ImpactTarget::Object { slot }, time, self.random.uniform(30e-6, 500e-6))
                .at(place)
                .with_impulse(place, 0.01 * self.random.direction());
        self.with_history(impact, 1.0)
    }

    fn send_motion(&self, controller: &mut Controller, time: f64) {
        let turn = if self.moving { time } else { 0.0 };
        for (slot, place) in self.places.iter().enumerate() {
            let pose = Pose { position: *place, orientation: DQuat::from_rotation_y(3.0 * turn) };
            let angular_velocity = if self.moving { 3.0 * DVec3::Y } else { DVec3::ZERO };
            let motion = Event::Pose { slot, time, pose, velocity: DVec3::ZERO, angular_velocity };
            controller.send(motion).expect("room in the ring");
        }
        let ear = DVec3::new(0.3 * turn.sin(), 0.2, 0.3 * turn.cos());
        controller.send(Event::Receivers([ear, ear + 0.17 * DVec3::X])).expect("room in the ring");
    }
}

fn soak(name: &str, seconds: f64, settings: &EngineSettings, [moving, histories]: [bool; 2]) {
    let mut random = SplitMix::new(7);
    let (mut controller, mut engine) = engine(settings).expect("good settings");
    let places: Vec<DVec3> = (0..OBJECTS).map(|_| random.direction() * random.uniform(0.3, 2.0)).collect();
    for slot in 0..OBJECTS {
        let object = SoundingObject::new(None, Some(source(&mut random)), settings);
        controller.put(slot, Some(object)).expect("room");
    }
    engine.render(BLOCK);
    let blocks = (seconds * RATE / BLOCK as f64) as usize;
    let mut load = Load { random, places, moving, histories, due: [0.0; 2], next_burst: 1 };
    let (mut times, mut modes) = (Vec::with_capacity(blocks), 0);
    for block in 0..blocks {
        load.send(&mut controller, block, engine.time());
        let begin = thread_time();
        engine.render(BLOCK);
        times.push(thread_time() - begin);
        modes += engine.report().modes as usize;
    }
    let period = BLOCK as f64 / RATE;
    let mean = times.iter().sum::<f64>() / blocks as f64 / period;
    times.sort_by(f64::total_cmp);
    let at = |part: f64| 100.0 * times[((part * blocks as f64) as usize).min(blocks - 1)] / period;
    let report = engine.report();
    println!(
        "{name}: {seconds} s, {:.1} % of real time; of a block's period 50 %: {:.1} %, 99 %: {:.1} %, \
         99.99 %: {:.1} %, longest {:.1} %; {:.0} modes on average, {} waves, shed {} (masked {}), late {}, \
         objects faded {}, without history {}",
        100.0 * mean,
        at(0.5),
        at(0.99),
        at(0.9999),
        at(1.0),
        modes as f64 / blocks as f64,
        report.waves,
        report.shed,
        report.masked,
        report.late,
        report.shed_voices,
        report.simplified,
    );
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with("--")).collect();
    let seconds = |name: &str| {
        let at = words.iter().position(|word| word == name);
        at.map(|at| words.get(at + 1).and_then(|word| word.parse().ok()).unwrap_or(20.0))
            .or(words.is_empty().then_some(5.0))
    };
    let settings = EngineSettings::default();
    let room = Room {
        lowest: DVec3::splat(-3.0),
        highest: DVec3::splat(3.0),
        walls: [WallAbsorption::even(0.2); 6],
        image_order: 1,
        late: true,
    };
    let floor = settings.clone().with_floor(Floor::Rigid { height: -2.5 });
    let room = settings.clone().with_room(Some(room)).with_air(Some(Air::default()));
    let runs = [
        ("soak", &settings, [false, false]),
        ("moving", &settings, [true, false]),
        ("histories", &settings, [false, true]),
        ("floor", &floor, [false, false]),
        ("room", &room, [false, false]),
    ];
    for (name, settings, variation) in runs {
        if let Some(seconds) = seconds(name) {
            soak(name, seconds, settings, variation);
        }
    }
}
