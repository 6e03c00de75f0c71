//! Processor time of sound synthesis, on one core: `cargo bench -p clangor-core`. Other programs do not count
//! where the system reports thread time (Linux).
//!
//! * Spheres: a generated timeline of 23 000 impulses of two balls each for two receivers, as in the ball
//!   drop of \[PAN\] Table 2, with and without a rigid floor.
//! * Fields: what a body's impulse costs per receiver, for a field with all terms of order 12, for the terms
//!   that an ellipsoid has, and for fields of as many terms and nodes, as large and ringing for as long as
//!   those of the bowl and the mug of the shape library up to 20 kHz; and whether it grows with the number of
//!   impulses and receivers as it should. The coefficients are random: the cost does not depend on them.
//! * The near field: a click heard inside the bounding sphere, for as many vertices and nodes as the bowl's.
//! * A pile: 96 000 impulses between 1000 rocks of as many sizes, through the fields of 66 and of 1000
//!   ellipsoids.
//!
//! Words after `--` select the lines that contain one of them: `spheres`, `own`, `ellipsoid`, `bowl`, `mug`,
//! `near`, `pile`.

mod thread_time;

use std::hint::black_box;
use std::sync::Arc;

use clangor_core::body::{BodyId, Surface};
use clangor_core::contact::ForceProfile;
use clangor_core::glam::{DQuat, DVec3};
use clangor_core::pose::{Pose, Track};
use clangor_core::shape::{Form, Shape};
use clangor_core::sound_model::acceleration::field::{AccelerationField, Node, RIGID_DOFS, Term};
use clangor_core::sound_model::acceleration::field_evaluator::FieldEvaluator;
use clangor_core::sound_model::acceleration::near_field::NearField;
use clangor_core::synthesis::listener::Floor;
use clangor_core::synthesis::{
    AccelerationPulse, BlockMemory, FieldSource, Listener, OverlapAdd, RenderSettings, Renderer, SoundSource,
};
use num_complex::{Complex32, Complex64};
use thread_time::thread_time;

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

/// Impacts between pairs of the bodies with these sources in a box of half a metre; their distance is that of
/// two spheres of `radius` [m].
fn clicks(sources: &[SoundSource], radius: f64, impulses: u32) -> Vec<AccelerationPulse> {
    let mut uniform = Uniform(1);
    let mut clicks = Vec::new();
    for i in 0..impulses {
        let time = SECONDS * f64::from(i) / f64::from(impulses);
        let duration = 40e-6 + 60e-6 * uniform.next();
        let centre = uniform.vector(0.5) + DVec3::Y;
        let velocity_change = uniform.vector(2.0);
        for side in [1.0, -1.0] {
            let body = (uniform.next() * sources.len() as f64) as usize;
            clicks.push(AccelerationPulse {
                body: BodyId(body as u32),
                time,
                duration,
                shape: ForceProfile::HalfSine.into(),
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

/// Renders everything.
fn render(clicks: &[AccelerationPulse], receivers: usize, floor: Floor) {
    let track = Track::fixed(Pose::at(DVec3::new(1.0, 1.8, 1.0)));
    let place = |i: usize| DVec3::X * (0.2 * i as f64 - 0.1);
    let listener = Listener { name: "row".into(), track, receivers: (0..receivers).map(place).collect() };
    let settings = RenderSettings::default().with_floor(floor);
    let mut renderer = Renderer::new(&listener, &settings).expect("a listener above the floor");
    let mut signal = OverlapAdd::new(receivers, 0);
    for click in clicks {
        renderer.push(click).expect("finite clicks");
    }
    let mut memory = BlockMemory::default();
    for job in renderer.take_all() {
        signal.add(&job.render_with(&mut memory));
    }
    black_box(signal.take_until((SECONDS * 48_000.0) as i64));
}

/// The least time [s] of several measurements. Each repeats until the resolution of the clock does not
/// matter.
fn best(clicks: &[AccelerationPulse], receivers: usize, floor: Floor) -> f64 {
    let measure = || {
        let begin = thread_time();
        let mut repeats = 0;
        while thread_time() - begin < LEAST_SECONDS {
            render(clicks, receivers, floor);
            repeats += 1;
        }
        (thread_time() - begin) / f64::from(repeats)
    };
    (0..MEASUREMENTS).map(|_| measure()).fold(f64::INFINITY, f64::min)
}

/// Least duration of a measurement [s].
const LEAST_SECONDS: f64 = 0.2;
/// Number of measurements, of which the least counts.
const MEASUREMENTS: usize = 5;

/// Terms of a field.
#[derive(Clone, Copy)]
enum Terms {
    /// So many of all those up to its order.
    Some(usize),
    /// Those of an ellipsoid.
    Ellipsoid,
}

/// A field of random coefficients, its nodes so far beside the axis.
fn field(order: u8, which: Terms, nodes: usize, damping: f64, ring_time: f64) -> Arc<FieldEvaluator> {
    let mut uniform = Uniform(7);
    // A motion has the harmonics of its own parity: so odd in x, y, z, in the order of the degrees of
    // freedom.
    let odd = [[1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 1, 1], [1, 0, 1], [1, 1, 0]];
    let parity = |n: u8, m: i8| {
        let (x, y) = (m.unsigned_abs() % 2, u8::from(m < 0));
        // cos mφ is odd in x for odd m, sin mφ the other way round for even m; both flip y for sin.
        [(x + y) % 2, y, (n + m.unsigned_abs()) % 2]
    };
    let all = RIGID_DOFS * (usize::from(order) + 1).pow(2);
    let mut index = 0;
    let mut kept = |term: &Term| match which {
        Terms::Ellipsoid => parity(term.n, term.m) == odd[usize::from(term.degree)],
        Terms::Some(count) => {
            index += 1;
            index * count / all != (index - 1) * count / all
        }
    };
    let mut terms = Vec::new();
    for n in 0..=order {
        for m in -(n as i8)..=n as i8 {
            for degree in 0..RIGID_DOFS as u8 {
                terms.extend(Some(Term { n, m, degree }).filter(&mut kept));
            }
        }
    }
    let place = |j: usize| Complex64::new(damping, 30.0 * j as f64 / nodes as f64);
    let mut number = || (uniform.next() - 0.5) as f32;
    let nodes: Vec<Node> = (0..nodes)
        .map(|j| Node { s: place(j), weight: Complex64::new(f64::from(number()), f64::from(number())) })
        .collect();
    let count = terms.len() * nodes.len();
    let real = (0..count).map(|_| number()).collect();
    let imaginary = (0..count).map(|_| number()).collect();
    let field = AccelerationField { max_wavenumber: 1e3, ring_time, nodes, terms, real, imaginary };
    Arc::new(FieldEvaluator::try_new(&field).expect("a field that agrees with itself"))
}

fn source(field: &Arc<FieldEvaluator>, radius: f64) -> SoundSource {
    let surface = Arc::new(Surface::Sphere { radius });
    let source = FieldSource::new(Arc::clone(field), None, radius, DQuat::IDENTITY, surface);
    SoundSource::Field(Arc::new(source))
}

fn spheres(asked: &Asked) {
    if !asked.wants("spheres") {
        return;
    }
    for (name, radius) in [("7.5 mm", 0.0075), ("3 cm", 0.03), ("12 cm", 0.12)] {
        let clicks = clicks(&[SoundSource::Sphere { radius }], radius, IMPULSES);
        for (floor_name, floor) in [("no floor", Floor::None), ("rigid floor", Floor::Rigid { height: 0.0 })]
        {
            let best = best(&clicks, 2, floor);
            let per_wave = best / (clicks.len() * 2) as f64;
            println!(
                "{IMPULSES} impulses, 2 bodies of {name}, 2 receivers, {floor_name}: {best:.3} s on one \
                 core, {:.2} µs \
                 per click and receiver",
                1e6 * per_wave
            );
        }
    }
}

fn fields(asked: &Asked) {
    for (name, field, radius) in [
        ("own field of order 12, 1014 terms, 16 nodes", field(12, Terms::Some(1014), 16, 0.05, 10.0), 0.012),
        ("ellipsoid of order 12, 16 nodes", field(12, Terms::Ellipsoid, 16, 0.25, 10.0), 0.012),
        ("bowl: order 32, 1377 terms, 38 nodes", field(32, Terms::Some(1377), 38, 0.05, 10.1), 0.0789),
        (
            "mug, ringing for 94 ms: order 19, 1405 terms, 46 nodes",
            field(19, Terms::Some(1405), 46, 0.0, 444.0),
            0.0725,
        ),
    ] {
        if !asked.wants(name) {
            continue;
        }
        let source = [source(&field, radius)];
        for (impulses, receivers) in [(1_000, 1), (4_000, 1), (1_000, 4)] {
            let clicks = clicks(&source, radius, impulses);
            let best = best(&clicks, receivers, Floor::None);
            let per_wave = best / (clicks.len() * receivers) as f64;
            println!(
                "{name}: {impulses} impulses, {receivers} receivers: {:.2} µs per body-impulse and receiver",
                1e6 * per_wave
            );
        }
    }
}

/// A field as the bowl's close to it; only the numbers of vertices and nodes matter.
fn near(asked: &Asked) {
    if !asked.wants("near field") {
        return;
    }
    let field = field(32, Terms::Some(1377), 38, 0.05, 10.1);
    let shape =
        Shape::try_new(Form::Ellipsoid { semi_axes: DVec3::splat(0.9) }, Some(0.0295)).expect("a mesh");
    let surface = shape.mesh();
    let (vertices, triangles) = (surface.vertices.len(), surface.triangles.len());
    let nodes = field.nodes();
    let pressure = |i: usize| Complex32::cis(0.1 * (i % (nodes.len() * RIGID_DOFS)) as f32);
    let pressures: Vec<Complex32> = (0..vertices * RIGID_DOFS * nodes.len()).map(pressure).collect();
    let near = NearField::from_pressures(surface, nodes.len(), &pressures);
    let mut values = Vec::new();
    let begin = thread_time();
    let mut repeats = 0;
    while thread_time() - begin < 5.0 * LEAST_SECONDS {
        near.at_nodes(nodes, &[1.0; RIGID_DOFS], DVec3::new(0.5, 0.7, 0.4), &mut values);
        black_box(&values);
        repeats += 1;
    }
    println!(
        "near field of {vertices} vertices, {triangles} triangles, 38 nodes: {:.1} ms per body-impulse and \
         receiver",
        1e3 * (thread_time() - begin) / f64::from(repeats)
    );
}

fn pile(asked: &Asked) {
    if !asked.wants("pile") {
        return;
    }
    // The nearest of the bank serves many rocks; the mean of its neighbours is each rock's own.
    for fields in [66, 1000] {
        let mut uniform = Uniform(3);
        let shapes: Vec<_> = (0..fields).map(|_| field(12, Terms::Ellipsoid, 16, 0.25, 10.0)).collect();
        let rocks: Vec<SoundSource> =
            (0..1000).map(|i| source(&shapes[i % fields], 0.01 + 0.03 * uniform.next())).collect();
        let clicks = clicks(&rocks, 0.02, 96_000);
        println!(
            "96 000 impulses of 1000 rocks with {fields} fields, one receiver: {:.2} s on one core",
            best(&clicks, 1, Floor::None)
        );
    }
}

/// Words of the command line.
struct Asked(Vec<String>);

impl Asked {
    fn wants(&self, name: &str) -> bool {
        self.0.is_empty() || self.0.iter().any(|word| name.contains(word.as_str()))
    }
}

fn main() {
    // Cargo adds its own option.
    let asked = Asked(std::env::args().skip(1).filter(|word| !word.starts_with('-')).collect());
    spheres(&asked);
    fields(&asked);
    near(&asked);
    pile(&asked);
}
