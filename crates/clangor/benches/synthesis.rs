//! Time to synthesise a generated timeline of 23 000 impulses for two receivers: `cargo bench -p clangor`.
//!
//! Two balls radiate at every impulse, as in the ball drop of \[PAN\] Table 2. Prints the best of several runs on one
//! core, with and without a rigid floor, and what a click costs at each block length.

use std::hint::black_box;
use std::time::Instant;

use clangor::body::BodyId;
use clangor::contact::ForceProfile;
use clangor::glam::{DQuat, DVec3};
use clangor::pose::{Pose, Track};
use clangor::synthesis::listener::Floor;
use clangor::synthesis::{Click, Listener, OverlapAdd, RenderSettings, Renderer, SoundSource};

const IMPULSES: u32 = 23_000;
const SECONDS: f64 = 5.0;

/// Uniform numbers in [0, 1): the multiplicative congruential generator of Park and Miller.
struct Uniform(u64);

impl Uniform {
    fn next(&mut self) -> f64 {
        self.0 = self.0 * 48_271 % 2_147_483_647;
        self.0 as f64 / 2_147_483_647.0
    }

    fn vector(&mut self, size: f64) -> DVec3 {
        DVec3::new(self.next() - 0.5, self.next() - 0.5, self.next() - 0.5) * size
    }
}

/// Impacts of pairs of balls of a radius [m] in a box of half a metre.
fn clicks(radius: f64) -> Vec<Click> {
    let mut uniform = Uniform(1);
    let mut clicks = Vec::new();
    for i in 0..IMPULSES {
        let time = SECONDS * f64::from(i) / f64::from(IMPULSES);
        let duration = 40e-6 + 60e-6 * uniform.next();
        let centre = uniform.vector(0.5) + DVec3::Y;
        let velocity_change = uniform.vector(2.0);
        for side in [1.0, -1.0] {
            clicks.push(Click {
                body: BodyId(i % 100),
                time,
                duration,
                profile: ForceProfile::HalfSine,
                centre: centre + DVec3::X * (side * radius),
                orientation: DQuat::IDENTITY,
                velocity_change: velocity_change * side,
                angular_velocity_change: DVec3::ZERO,
                source: SoundSource::Sphere { radius },
            });
        }
    }
    clicks
}

/// Renders everything and returns the time taken [s].
fn render(clicks: &[Click], floor: Floor) -> f64 {
    let track = Track::fixed(Pose::at(DVec3::new(1.0, 1.8, 1.0)));
    let listener = Listener::spaced_pair("pair", track, 0.2);
    let settings = RenderSettings { floor, ..RenderSettings::default() };
    let begin = Instant::now();
    let mut renderer = Renderer::new(&listener, &settings).expect("a listener above the floor");
    let mut signal = OverlapAdd::new(2, 0);
    for click in clicks {
        renderer.push(click).expect("finite clicks");
    }
    for job in renderer.take_all() {
        signal.add(&job.render());
    }
    black_box(signal.take_until((SECONDS * 48_000.0) as i64));
    begin.elapsed().as_secs_f64()
}

fn main() {
    for (name, radius) in [("7.5 mm", 0.0075), ("3 cm", 0.03), ("12 cm", 0.12)] {
        let clicks = clicks(radius);
        for (floor_name, floor) in [("no floor", Floor::None), ("rigid floor", Floor::Rigid { height: 0.0 })]
        {
            let best = (0..7).map(|_| render(&clicks, floor)).fold(f64::INFINITY, f64::min);
            let per_wave = best / (clicks.len() * 2) as f64;
            println!(
                "{IMPULSES} impulses, 2 bodies of {name}, 2 receivers, {floor_name}: {best:.3} s on one core, {:.2} µs \
                 per click and receiver",
                1e6 * per_wave
            );
        }
    }
}
