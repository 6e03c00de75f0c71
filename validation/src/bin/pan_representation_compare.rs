//! The published representation of acceleration noise compared with multipoles on the same bodies: errors at
//! 2, 8 and 100 R, bytes, time of a contact.
//!
//! `cargo run --release -p clangor-validation --bin pan_representation_compare`
//!
//! The field of a body extends to κ = 20, 20 kHz for R = 55 mm. The published pulse h = 0.25 R/c is at 1 % of
//! its peak there; a contact lasts five of them. Errors are relative L2 of the sound of the half-sine over 40
//! directions off every grid, worst translation and worst rotation, relative to the field with all its
//! multipoles.

use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

use clangor_bake::acceleration::{BakeOptions, Method, bake_with};
use clangor_bake::bem::axisymmetric::{AxisymmetricOptions, AxisymmetricSolver};
use clangor_bake::reference::{FieldSampler, Fit, PanOptions, fit, half_sine_spectrum, synthesize};
use clangor_core::body::{BodyId, Surface};
use clangor_core::contact::ForceProfile;
use clangor_core::geometry::meridian::Meridian;
use clangor_core::glam::DQuat;
use clangor_core::glam::DVec3;
use clangor_core::medium::Medium;
use clangor_core::reference::pan_representation::directions::Directions;
use clangor_core::reference::pan_representation::{HeardContact, PanField, PanModel};
use clangor_core::sound_model::acceleration::field::{AccelerationField, RIGID_DOFS};
use clangor_core::sound_model::acceleration::field_evaluator::FieldEvaluator;
use clangor_core::synthesis::{
    AccelerationPulse, FieldSource, Listener, OverlapAdd, RenderSettings, Renderer, SampleRate, SoundSource,
};
use num_complex::Complex64;

use clangor_validation::pan_representation::errors::{Push, directions, errors, worst};

const HIGHEST: f64 = 20.0;
const PULSE: f64 = 0.25;
const CONTACT: f64 = 1.25;
const DISTANCES: [f64; 3] = [2.0, 8.0, 100.0];
/// R \[m\] at which κ = 20 is 20 kHz.
const RADIUS: f64 = 0.0546;
const CONTACTS: usize = 2000;

fn options(directions: Directions, fit: Fit) -> PanOptions {
    PanOptions { pulse: PULSE, step: 0.02, length: 1024, terms: 2, radii: 5, directions, fit }
}

fn main() {
    println!("published against ours, κ ≤ {HIGHEST}, contacts of {CONTACT} R/c, N = 2, 1024 samples");
    for (name, across, along) in
        [("disc 20 : 20 : 1", 1.0, 0.05), ("spheroid 2 : 2 : 1", 1.0, 0.5), ("needle 1 : 1 : 4", 0.25, 1.0)]
    {
        let Ok(meridian) = Meridian::spheroid(across, along) else { continue };
        let solver = AxisymmetricSolver::new(&meridian, DVec3::Z, AxisymmetricOptions::new(HIGHEST));
        let bake_options = BakeOptions { method: Method::Bem, ..BakeOptions::new(HIGHEST, 1e-4) };
        let baked = bake_with(&solver, 0.8, &bake_options, &mut |_| std::ops::ControlFlow::Continue(()));
        match baked {
            Ok((model, evidence)) => {
                println!(
                    "{name}: {} solves, {} nodes, held-out error {:.1e}",
                    evidence.solves,
                    model.field.nodes.len(),
                    evidence.held_out_error
                );
                body(&model.field);
            }
            Err(error) => println!("{name}: {error}"),
        }
    }
}

fn body(field: &AccelerationField) {
    let octant = options(Directions::OCTANT_45, Fit::Wavelets { tolerance: 0.01 });
    let sampler = FieldSampler::new(field, &octant.wavenumbers());
    let spectra = |x: DVec3| sampler.spectra(x);
    let listeners = directions(40);
    let near = |x: DVec3| listeners.iter().any(|l| l.dot(x) > 0.99 * x.length());
    let silent = || std::array::from_fn(|_| vec![Complex64::ZERO; octant.length / 2 + 1]);
    let around = |x: DVec3| if near(x) { sampler.spectra(x) } else { silent() };

    let svd = Fit::TruncatedSvd { truncation: 1e-3 };
    let grid = |rows: usize, columns: usize| Directions::Angles { rows, columns };
    let rows: [(&str, PanOptions, bool); 4] = [
        ("PAN 40 × 80", options(grid(40, 80), svd), true),
        ("PAN 5 × 10", options(grid(5, 10), svd), false),
        ("PROXY octant, ε = 0.01", octant, false),
        ("PROXY octant, ε = 0.04", PanOptions { fit: Fit::Wavelets { tolerance: 0.04 }, ..octant }, false),
    ];
    // Published representations.
    for (name, options, masked) in rows {
        let fitted = if masked { fit(&options, &around) } else { fit(&options, &spectra) };
        let Ok(published) = fitted else { continue };
        let line: Vec<String> = DISTANCES
            .iter()
            .map(|r| {
                pair(&errors(
                    &published,
                    &spectra,
                    Push::HalfSine { duration: CONTACT, onset: 0.0 },
                    &listeners,
                    *r,
                ))
            })
            .collect();
        // The time of a mostly zero grid is meaningless.
        let time = if masked { String::new() } else { format!("{:.0} µs", published_time(&published)) };
        println!("| {name} | {} | {} | {time} |", line.join(" | "), published.bytes());
    }
    // Truncated multipoles.
    for order in [8, 10, 12] {
        let ours = truncated(field, order);
        let own = FieldSampler::new(&ours, &octant.wavenumbers());
        let line: Vec<String> =
            DISTANCES.iter().map(|r| pair(&field_errors(&own, &sampler, &octant, &listeners, *r))).collect();
        let bytes = 8 * ours.real.len() + 3 * ours.terms.len() + 32 * ours.nodes.len();
        println!("| ours, n ≤ {order} | {} | {bytes} | {:.1} µs |", line.join(" | "), our_time(&ours));
    }
}

fn pair(e: &[Option<f64>; RIGID_DOFS]) -> String {
    format!("{:.2} / {:.2}", 100.0 * worst(&e[..3]), 100.0 * worst(&e[3..]))
}

/// The terms up to an order.
fn truncated(field: &AccelerationField, order: u8) -> AccelerationField {
    let count = field.nodes.len();
    let mut less =
        AccelerationField { terms: Vec::new(), real: Vec::new(), imaginary: Vec::new(), ..field.clone() };
    for (row, term) in field.terms.iter().enumerate().filter(|(_, t)| t.n <= order) {
        less.terms.push(*term);
        less.real.extend(&field.real[row * count..][..count]);
        less.imaginary.extend(&field.imaginary[row * count..][..count]);
    }
    less
}

fn field_errors(
    ours: &FieldSampler,
    exact: &FieldSampler,
    options: &PanOptions,
    listeners: &[DVec3],
    distance: f64,
) -> [Option<f64>; RIGID_DOFS] {
    let contact: Vec<Complex64> =
        options.wavenumbers().iter().map(|k| half_sine_spectrum(*k, CONTACT)).collect();
    let ones = vec![1.0; contact.len()];
    let sound = |p: &[Complex64]| {
        let spectrum: Vec<Complex64> = p.iter().zip(&contact).map(|(p, s)| p * s).collect();
        synthesize(&spectrum, &ones, options.step, options.start())
    };
    let mut sums = [[0.0; 2]; RIGID_DOFS];
    for v in listeners {
        let (a, b) = (ours.spectra(*v * distance), exact.spectra(*v * distance));
        for (degree, sum) in sums.iter_mut().enumerate() {
            for (x, r) in sound(&a[degree]).iter().zip(sound(&b[degree])) {
                sum[0] += (x - r) * (x - r);
                sum[1] += r * r;
            }
        }
    }
    let loudest = sums.iter().map(|s| s[1]).fold(0.0, f64::max);
    sums.map(|[difference, size]| (size > 1e-12 * loudest).then(|| (difference / size).sqrt()))
}

/// Time per contact and listener \[µs\], at 48 kHz.
fn published_time(field: &PanField) -> f64 {
    let Ok(model) = PanModel::new(RADIUS, vec![field.clone()]) else { return f64::NAN };
    let listeners = directions(CONTACTS / 10);
    let once = || {
        let begin = Instant::now();
        for (i, v) in listeners.iter().enumerate() {
            let contact = HeardContact {
                peak: [100.0, -80.0, 60.0, 900.0, 700.0, -800.0],
                onset: 1e-3 * i as f64,
                duration: CONTACT * RADIUS / Medium::AIR.sound_speed,
                listener: *v * (1.0 + 0.01 * i as f64),
            };
            black_box(model.render(&contact, &Medium::AIR, 48_000.0).ok());
        }
        begin.elapsed().as_secs_f64()
    };
    (0..5).map(|_| once()).fold(f64::INFINITY, f64::min) * 1e6 / listeners.len() as f64
}

/// The same through the renderer, its blocks and their transforms included.
fn our_time(field: &AccelerationField) -> f64 {
    let Ok(playable) = FieldEvaluator::try_new(field) else { return f64::NAN };
    let surface = Arc::new(Surface::Sphere { radius: RADIUS });
    let source = SoundSource::Field(Arc::new(FieldSource::new(
        Arc::new(playable),
        None,
        RADIUS,
        DQuat::IDENTITY,
        surface,
    )));
    let clicks: Vec<AccelerationPulse> = directions(CONTACTS)
        .into_iter()
        .enumerate()
        .map(|(i, v)| AccelerationPulse {
            body: BodyId(0),
            time: 2.5e-4 * i as f64,
            duration: CONTACT * RADIUS / Medium::AIR.sound_speed,
            shape: ForceProfile::HalfSine.into(),
            centre: v * 1.5,
            orientation: DQuat::IDENTITY,
            velocity_change: DVec3::new(1.0, -0.8, 0.6),
            angular_velocity_change: DVec3::new(9.0, 7.0, -8.0),
            source: source.clone(),
        })
        .collect();
    let settings = RenderSettings { sample_rate: SampleRate::HZ_48000, ..RenderSettings::default() };
    let once = || {
        let begin = Instant::now();
        let listener = Listener::fixed("microphone", DVec3::ZERO);
        let Ok(mut renderer) = Renderer::new(&listener, &settings) else { return f64::NAN };
        let mut signal = OverlapAdd::new(1, 0);
        for click in &clicks {
            black_box(renderer.push(click).is_ok());
        }
        for job in renderer.take_all() {
            signal.add(&job.render());
        }
        black_box(signal.take_until(48_000));
        begin.elapsed().as_secs_f64()
    };
    (0..5).map(|_| once()).fold(f64::INFINITY, f64::min) * 1e6 / clicks.len() as f64
}
