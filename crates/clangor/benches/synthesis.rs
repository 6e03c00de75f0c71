//! Time to synthesise sound, on one core: `cargo bench -p clangor`. It is that of the processor where the system tells
//! (Linux), so that other programs do not count.
//!
//! * Spheres: a generated timeline of 23 000 impulses of two balls each for two receivers, as in the ball drop of \[PAN\]
//!   Table 2, with and without a rigid floor.
//! * Fields: what a body's impulse costs per receiver, for a field with all terms of order 12, for the terms that an
//!   ellipsoid has, and for one of order 30 that rings for long, as a mug does; and whether it grows with the number
//!   of impulses and receivers as it should. The coefficients are random: the cost does not depend on them.
//! * A pile: 96 000 impulses between 1000 rocks of as many sizes, through the fields of ellipsoids.

use std::hint::black_box;
use std::sync::{Arc, LazyLock};
use std::time::Instant;

use clangor::body::{BodyId, Surface};
use clangor::contact::ForceProfile;
use clangor::glam::{DQuat, DVec3};
use clangor::model::acceleration_field::{AccelerationField, DEGREES, Node, Term};
use clangor::model::playable_field::PlayableField;
use clangor::pose::{Pose, Track};
use clangor::synthesis::listener::Floor;
use clangor::synthesis::{Click, FieldSource, Listener, OverlapAdd, RenderSettings, Renderer, SoundSource};
use realfft::num_complex::Complex64;

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

/// Impacts between pairs of the bodies with these sources in a box of half a metre; their distance is that of two
/// spheres of `radius` [m].
fn clicks(sources: &[SoundSource], radius: f64, impulses: u32) -> Vec<Click> {
    let mut uniform = Uniform(1);
    let mut clicks = Vec::new();
    for i in 0..impulses {
        let time = SECONDS * f64::from(i) / f64::from(impulses);
        let duration = 40e-6 + 60e-6 * uniform.next();
        let centre = uniform.vector(0.5) + DVec3::Y;
        let velocity_change = uniform.vector(2.0);
        for side in [1.0, -1.0] {
            let body = (uniform.next() * sources.len() as f64) as usize;
            clicks.push(Click {
                body: BodyId(body as u32),
                time,
                duration,
                profile: ForceProfile::HalfSine,
                centre: centre + DVec3::X * (side * radius),
                orientation: DQuat::from_scaled_axis(uniform.vector(6.0)),
                velocity_change: velocity_change * side,
                angular_velocity_change: uniform.vector(50.0),
                source: sources[body].clone(),
            });
        }
    }
    clicks
}

/// Time that this thread has had [s], or else that on the wall.
fn seconds() -> f64 {
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    let statistics = std::fs::read_to_string("/proc/self/schedstat").ok();
    let nanoseconds = statistics.and_then(|s| s.split(' ').next()?.parse::<f64>().ok());
    nanoseconds.map_or_else(|| START.elapsed().as_secs_f64(), |ns| 1e-9 * ns)
}

/// Renders everything and returns the time taken [s].
fn render(clicks: &[Click], receivers: usize, floor: Floor) -> f64 {
    let track = Track::fixed(Pose::at(DVec3::new(1.0, 1.8, 1.0)));
    let place = |i: usize| DVec3::X * (0.2 * i as f64 - 0.1);
    let listener = Listener { name: "row".into(), track, receivers: (0..receivers).map(place).collect() };
    let settings = RenderSettings { floor, ..RenderSettings::default() };
    let begin = seconds();
    let mut renderer = Renderer::new(&listener, &settings).expect("a listener above the floor");
    let mut signal = OverlapAdd::new(receivers, 0);
    for click in clicks {
        renderer.push(click).expect("finite clicks");
    }
    for job in renderer.take_all() {
        signal.add(&job.render());
    }
    black_box(signal.take_until((SECONDS * 48_000.0) as i64));
    seconds() - begin
}

fn best(runs: usize, clicks: &[Click], receivers: usize, floor: Floor) -> f64 {
    (0..runs).map(|_| render(clicks, receivers, floor)).fold(f64::INFINITY, f64::min)
}

/// A field of random coefficients with all terms up to `order`, or those of an ellipsoid.
fn field(order: u8, nodes: usize, ring_time: f64, ellipsoid: bool) -> Arc<PlayableField> {
    let mut uniform = Uniform(7);
    // A motion has the harmonics of its own parity: so odd in x, y, z, in the order of the degrees of freedom.
    let odd = [[1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 1, 1], [1, 0, 1], [1, 1, 0]];
    let parity = |n: u8, m: i8| {
        let (x, y) = (m.unsigned_abs() % 2, u8::from(m < 0));
        // cos mφ is odd in x for odd m, sin mφ the other way round for even m; both flip y for sin.
        [(x + y) % 2, y, (n + m.unsigned_abs()) % 2]
    };
    let mut terms = Vec::new();
    for n in 0..=order {
        for m in -(n as i8)..=n as i8 {
            for degree in 0..DEGREES as u8 {
                if !ellipsoid || parity(n, m) == odd[usize::from(degree)] {
                    terms.push(Term { n, m, degree });
                }
            }
        }
    }
    let place = |j: usize| Complex64::new(0.05, 30.0 * j as f64 / nodes as f64);
    let mut number = || (uniform.next() - 0.5) as f32;
    let nodes: Vec<Node> = (0..nodes)
        .map(|j| Node { s: place(j), weight: Complex64::new(f64::from(number()), f64::from(number())) })
        .collect();
    let count = terms.len() * nodes.len();
    let real = (0..count).map(|_| number()).collect();
    let imaginary = (0..count).map(|_| number()).collect();
    let field = AccelerationField { max_wavenumber: 1e3, ring_time, nodes, terms, real, imaginary };
    Arc::new(PlayableField::try_new(&field).expect("a field that agrees with itself"))
}

fn source(field: &Arc<PlayableField>, radius: f64) -> SoundSource {
    let surface = Arc::new(Surface::Sphere { radius });
    let source = FieldSource::new(Arc::clone(field), None, radius, DQuat::IDENTITY, surface);
    SoundSource::Field(Arc::new(source))
}

fn main() {
    for (name, radius) in [("7.5 mm", 0.0075), ("3 cm", 0.03), ("12 cm", 0.12)] {
        let clicks = clicks(&[SoundSource::Sphere { radius }], radius, IMPULSES);
        for (floor_name, floor) in [("no floor", Floor::None), ("rigid floor", Floor::Rigid { height: 0.0 })]
        {
            let best = best(7, &clicks, 2, floor);
            let per_wave = best / (clicks.len() * 2) as f64;
            println!(
                "{IMPULSES} impulses, 2 bodies of {name}, 2 receivers, {floor_name}: {best:.3} s on one core, {:.2} µs \
                 per click and receiver",
                1e6 * per_wave
            );
        }
    }
    for (name, field, radius) in [
        ("own field of order 12, 16 nodes, R = 1.2 cm", field(12, 16, 10.0, false), 0.012),
        ("ellipsoid of order 12, 16 nodes, R = 1.2 cm", field(12, 16, 10.0, true), 0.012),
        ("mug: order 30, 48 nodes, R = 6 cm, ringing for 13 ms", field(30, 48, 75.0, false), 0.06),
    ] {
        let source = [source(&field, radius)];
        for (impulses, receivers) in [(1_000, 1), (4_000, 1), (1_000, 4)] {
            let clicks = clicks(&source, radius, impulses);
            let best = best(5, &clicks, receivers, Floor::None);
            let per_wave = best / (clicks.len() * receivers) as f64;
            println!(
                "{name}: {impulses} impulses, {receivers} receivers: {:.2} µs per body-impulse and receiver",
                1e6 * per_wave
            );
        }
    }
    let mut uniform = Uniform(3);
    let shapes: Vec<_> = (0..66).map(|_| field(12, 16, 10.0, true)).collect();
    let rocks: Vec<SoundSource> =
        (0..1000).map(|i| source(&shapes[i % 66], 0.01 + 0.03 * uniform.next())).collect();
    let clicks = clicks(&rocks, 0.02, 96_000);
    println!(
        "96 000 impulses of 1000 rocks, one receiver: {:.2} s on one core",
        best(3, &clicks, 1, Floor::None)
    );
}
