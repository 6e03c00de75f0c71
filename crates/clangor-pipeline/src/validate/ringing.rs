//! Ringing: frequencies against closed forms and fine meshes, the power of modes against finer panels,
//! translations as modes against clicks, what is played against the decaying sine, and the peaks of a struck
//! body.

use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow;
use std::sync::Arc;

use clangor_bake::bem::axisymmetric::{AxisymmetricOptions, AxisymmetricSolver};
use clangor_bake::fem::lamb_sphere;
use clangor_bake::fem::{ElasticConstants, ElasticSystem};
use clangor_bake::fitting::comparison::directions;
use clangor_bake::geometry_class::bake_geometry::BakeGeometry;
use clangor_bake::mesh::tetrahedra::ball::ellipsoid;
use clangor_bake::mesh::tetrahedra::block::block;
use clangor_bake::modal::{ModalBakeOptions, find_modes, radiate};
use clangor_bake::modal_analysis::eigensolver::solve;
use clangor_bake::modal_analysis::{ModalAnalysisOptions, modal_analysis};
use clangor_bake::modal_radiation::axisymmetric::AxisymmetricModalSolver;
use clangor_bake::modal_radiation::{ModalMotion, ModalSolver};
use clangor_bake::radiation::RadiationSolver;
use clangor_core::body::{Body, Surface};
use clangor_core::contact::ForceProfile;
use clangor_core::geometry::meridian::Meridian;
use clangor_core::glam::{DMat3, DVec3};
use clangor_core::material::presets::{CERAMIC, GLASS, STEEL};
use clangor_core::material::{Damping, Material};
use clangor_core::math::radial::outgoing;
use clangor_core::math::spherical_harmonics::solid_harmonics;
use clangor_core::medium::Medium;
use clangor_core::shape::Shape;
use clangor_core::sound_model::acceleration::sphere_radiation::SphereModel;
use clangor_core::sound_model::modal::model::{ModalMode, ModalModel, ModalTransfer};
use clangor_core::sound_model::modal::surface::ModalSurface;
use clangor_core::synthesis::SampleRate;
use clangor_core::synthesis::modal::{ModalSettings, ModalSource};
use clangor_core::synthesis::strike::{Strike, StrikeForce, StrikeSound, struck_ringing};
use num_complex::Complex64;

use super::{Check, Extent, Fault, Outcome, Timing, Validation, cpu_time};
use crate::analysis::spectrum::Spectrum;

const SECTION: &str = "Ringing";

pub(super) fn run(extent: Extent, table: &mut Validation) -> Outcome {
    sphere(extent, table)?;
    bar(table)?;
    translations(table)?;
    powers(extent, table)?;
    decay(table)?;
    peaks(table)
}

fn add(table: &mut Validation, quantity: String, reference: &'static str, error: f64, bar: f64) {
    table.checks.push(Check { section: SECTION, quantity, reference, error, bar, unit: "" });
}

/// Largest relative error; infinite if there are fewer than the reference has.
fn worst(found: &[f64], reference: &[f64]) -> f64 {
    if found.len() < reference.len() {
        return f64::INFINITY;
    }
    found.iter().zip(reference).map(|(f, r)| (f / r - 1.0).abs()).fold(0.0, f64::max)
}

fn sphere(extent: Extent, table: &mut Validation) -> Outcome {
    let (material, radius) = (GLASS.material(), 0.025);
    let reference = "Lamb 1881";
    let exact = &lamb_sphere::frequencies(&material, radius)[..20];
    let constants = ElasticConstants::of(&material)?;
    let limit = 1.005 * exact[19];
    let options = ModalAnalysisOptions { accuracy: 1e-5, ..ModalAnalysisOptions::to(limit) };
    let geometry = BakeGeometry::Ellipsoid { semi_axes: DVec3::splat(radius) };
    let found = modal_analysis(&geometry, &constants, &options, &mut |_| ControlFlow::Continue(()))?;
    let frequencies: Vec<f64> = found.modes.iter().map(|m| m.frequency).collect();
    add(
        table,
        format!("elastic sphere, first 20 frequencies, by its section ({} nodes)", found.nodes),
        reference,
        worst(&frequencies, exact),
        1e-4,
    );
    if extent == Extent::Full {
        let mesh = ellipsoid(DVec3::splat(radius), 6)?;
        let modes = solve(&ElasticSystem::new(&mesh, &constants), limit)?;
        let frequencies: Vec<f64> = modes.modes.iter().map(|m| m.frequency).collect();
        add(
            table,
            format!("the same by tetrahedra with curved edges ({} nodes)", mesh.nodes.len()),
            reference,
            worst(&frequencies, exact),
            1e-3,
        );
    }
    Ok(())
}

fn bar(table: &mut Validation) -> Outcome {
    // On 120 × 12 × 4 cells; the first is within 1 % of Euler and Bernoulli.
    const FINE: [f64; 10] =
        [574.401, 1573.196, 1671.474, 2948.849, 3055.526, 4354.580, 4989.727, 5920.033, 7343.771, 7958.034];
    let mesh = block(DVec3::new(0.3, 0.03, 0.01), [40, 4, 2])?;
    let begin = cpu_time();
    let modes = solve(&ElasticSystem::new(&mesh, &ElasticConstants::of(&STEEL.material())?), 9000.0)?;
    table.timings.push(Timing {
        what: format!("{} modes of a bar, {} nodes", modes.modes.len(), mesh.nodes.len()),
        cpu_seconds: cpu_time() - begin,
    });
    let frequencies: Vec<f64> = modes.modes.iter().map(|m| m.frequency).collect();
    add(
        table,
        format!("free steel bar 300 × 30 × 10 mm, first ten frequencies ({} nodes)", mesh.nodes.len()),
        "54 225 nodes",
        worst(&frequencies, &FINE),
        1e-2,
    );
    Ok(())
}

/// A body of the library about its centre of mass: its section, and its surface as elements see it.
fn round_body(name: &str, edge: f64) -> Result<(Meridian, ModalSurface), Fault> {
    let shape = Shape::parse(name)?.with_edge(edge)?;
    let meridian = shape.meridian().ok_or("the body has no section")?;
    let mesh = clangor_bake::mesh::tetrahedra::shape_mesh(&shape, edge)?;
    let centre = DVec3::Y * meridian.centre_of_mass();
    let nodes = mesh.nodes.iter().map(|x| x - centre).collect();
    Ok((meridian.about_centre_of_mass(), ModalSurface { nodes, triangles: mesh.surface() }))
}

fn transfers(
    solver: &AxisymmetricModalSolver,
    surface: &ModalSurface,
    motions: &[ModalMotion<'_>],
) -> Result<Vec<ModalTransfer>, Fault> {
    Ok(solver.transfers(surface, motions, &mut |_| ControlFlow::Continue(()))?)
}

fn translations(table: &mut Validation) -> Outcome {
    for (name, edge, wavenumber) in [("coin", 2e-3, 300.0), ("bowl", 6e-3, 100.0)] {
        let (meridian, surface) = round_body(name, edge)?;
        let click = AxisymmetricSolver::new(&meridian, DVec3::Y, AxisymmetricOptions::new(wavenumber));
        let sample = click.solve(&[wavenumber], 20)?.remove(0);
        let (radius, own) = (surface.radius(), click.reference_radius());
        let (mut harmonics, mut radial) = (Vec::new(), Vec::new());
        let (mut wrong, mut size) = ([0.0; 3], [0.0; 3]);
        for (axis, direction) in DVec3::AXES.into_iter().enumerate() {
            let shape = vec![direction; surface.nodes.len()];
            let motion = ModalMotion { wavenumber, shape: &shape };
            let ringing =
                transfers(&AxisymmetricModalSolver::new(&meridian, DVec3::Y), &surface, &[motion])?.remove(0);
            for at in directions(40) {
                let x = 2.0 * radius * at;
                solid_harmonics(at, 20, &mut harmonics);
                outgoing(Complex64::I * wavenumber * own, x.length() / own, 20, &mut radial);
                let clicked: Complex64 = sample.coefficients[axis]
                    .iter()
                    .enumerate()
                    .map(|(i, c)| c * harmonics[i] * radial[i.isqrt()])
                    .sum();
                let rung = ringing.undelayed(x / radius, wavenumber * radius) * radius;
                wrong[axis] += (rung - clicked).norm_sqr();
                size[axis] += clicked.norm_sqr();
            }
        }
        let loudest = size.into_iter().fold(0.0, f64::max);
        let error = wrong.into_iter().map(|w| f64::sqrt(w / loudest)).fold(0.0, f64::max);
        add(
            table,
            format!("{name} that moves as a whole, as a mode: three translations at 2 R, worst"),
            "its acceleration noise",
            error,
            1e-3,
        );
    }
    Ok(())
}

fn powers(extent: Extent, table: &mut Validation) -> Outcome {
    let bodies: &[(&str, Material, f64, usize)] = match extent {
        Extent::Quick => &[("coin", STEEL.material(), 20e3, 1)],
        Extent::Full => &[
            ("coin", STEEL.material(), 20e3, 1),
            ("bowl", CERAMIC.material(), 20e3, 4),
            ("plate", CERAMIC.material(), 20e3, 8),
        ],
    };
    for (name, material, limit, step) in bodies {
        let shape = Shape::parse(name)?;
        let meridian = shape.meridian().ok_or("the body has no section")?.about_centre_of_mass();
        let options = ModalBakeOptions { max_frequency: *limit, ..ModalBakeOptions::new(Medium::AIR) };
        let geometry = BakeGeometry::axisymmetric(meridian.clone());
        let begin = cpu_time();
        let (model, _) = find_modes(&geometry, material, &options, &mut |_| ControlFlow::Continue(()))?;
        let motions: Vec<ModalMotion<'_>> = model
            .modes
            .iter()
            .step_by(*step)
            .map(|mode| ModalMotion {
                wavenumber: TAU * mode.frequency / Medium::AIR.sound_speed,
                shape: &mode.shape,
            })
            .collect();
        let solver = AxisymmetricModalSolver::new(&meridian, DVec3::Y);
        let usual = transfers(&solver, &model.surface, &motions)?;
        table.timings.push(Timing {
            what: format!("{} modes of a {name}, and the sound of {}", model.modes.len(), motions.len()),
            cpu_seconds: cpu_time() - begin,
        });
        let finer = AxisymmetricOptions {
            nodes_per_wavelength: 14.0,
            edge_levels: 6,
            ..AxisymmetricOptions::new(0.0)
        };
        let finer = transfers(&solver.with_options(finer), &model.surface, &motions)?;
        let error = motions
            .iter()
            .zip(usual.iter().zip(&finer))
            .map(|(motion, (usual, finer))| {
                let kappa = motion.wavenumber * model.radius;
                (usual.power(kappa) / finer.power(kappa) - 1.0).abs()
            })
            .fold(0.0, f64::max);
        add(
            table,
            format!(
                "{name}, {} of its {} modes to 20 kHz: radiated power, worst",
                motions.len(),
                model.modes.len()
            ),
            "finer panels",
            error,
            1e-2,
        );
    }
    Ok(())
}

/// A body at rest for impacts.
fn struck(surface: Surface, material: Material, volume: f64) -> Body {
    let radius = surface.bounding_radius();
    let mass = material.density * volume;
    let inertia = DMat3::from_diagonal(DVec3::splat(0.4 * mass * radius * radius));
    Body::new("struck", material, surface, mass, inertia).with_edge_radius(0.05 * radius)
}

/// What an impact of 60 µs rings in so many seconds from its beginning, and its first sample's
/// time.
fn rung(body: &Body, source: ModalSource, impact: &Strike, seconds: f64) -> Result<StrikeSound, Fault> {
    let rate = impact.sample_rate.as_f64();
    let lead = clangor_core::synthesis::strike::LEAD;
    let count = ((seconds + lead) * rate).ceil() as usize;
    let mut sound = StrikeSound {
        times: (0..count).map(|n| n as f64 / rate - lead).collect(),
        pressures: vec![0.0; count],
        duration: CONTACT,
        velocity_change: DVec3::ZERO,
        radius: body.surface.equal_volume_radius(),
    };
    sound.pressures = struck_ringing(body, Arc::new(source), impact, &sound)?;
    Ok(sound)
}

/// Duration of the impacts \[s\].
const CONTACT: f64 = 60e-6;

fn impact(impulse: DVec3, point: DVec3, listener: DVec3, hz: u32) -> Result<Strike, Fault> {
    Ok(Strike {
        force: StrikeForce::Impulse { impulse, duration: Some(CONTACT) },
        point,
        listener,
        profile: ForceProfile::HalfSine,
        steps: 16.0,
        sample_rate: SampleRate::try_new(hz)?,
        max_frequency: None,
        seconds: None,
        medium: Medium::AIR,
        room: None,
        sphere_model: SphereModel::Exact,
    })
}

/// A mode of one multipole, played at several rates, against the decaying sine.
fn decay(table: &mut Validation) -> Outcome {
    const RADIUS: f64 = 0.1;
    let (t60, coefficient, distance) = (0.4, Complex64::new(0.3, -1.1), 0.9);
    let impulse = 0.02;
    let mut error = 0.0_f64;
    for hz in [44_100, 48_000, 192_000] {
        for frequency in [310.0, 2511.3, 18_000.0] {
            let corners = [DVec3::ZERO, DVec3::X, DVec3::Y].map(|x| RADIUS * x);
            let middles = [(0, 1), (1, 2), (2, 0)].map(|(a, b)| 0.5 * (corners[a] + corners[b]));
            let model = ModalModel {
                radius: RADIUS,
                medium: Medium::AIR,
                density: STEEL.material().density,
                max_frequency: 20_000.0,
                statistical_above: None,
                surface: ModalSurface {
                    nodes: corners.into_iter().chain(middles).collect(),
                    triangles: vec![[0, 1, 2, 3, 4, 5]],
                },
                modes: vec![ModalMode {
                    frequency,
                    mesh_error: 0.0,
                    support_damping: 0.0,
                    shape: vec![2.0 * DVec3::Z; 6],
                    transfer: Some(ModalTransfer { order: 0, coefficients: vec![coefficient] }),
                }],
            };
            let settings = ModalSettings { radiation_damping: false, ..ModalSettings::default() };
            let source = ModalSource::new(Arc::new(model), &Damping::T60(t60), &settings)?;
            let body = struck(Surface::Sphere { radius: RADIUS }, STEEL.material(), 4.0 / 3.0 * PI * 1e-3);
            let impact = impact(impulse * DVec3::Z, RADIUS * DVec3::X, distance * DVec3::X, hz)?;
            let sound = rung(&body, source, &impact, 0.25)?;
            // After a half-sine of unit impulse, the complex modal acceleration is
            // −i (λ²/Im λ) (1 + e^{−λτ})/(2 (1 + (λτ/π)²)) e^{λt}.
            let rate = 3.0 * 10.0_f64.ln() / t60;
            let pole = Complex64::new(-rate, ((TAU * frequency).powi(2) - rate * rate).sqrt());
            let x = pole * sound.duration;
            let start =
                -Complex64::I * pole * pole / pole.im * (1.0 + (-x).exp()) / (2.0 * (1.0 + (x / PI).powi(2)));
            // Y₀₀ on the sphere of radius R.
            let transfer = Medium::AIR.density * RADIUS * 0.5 / PI.sqrt() * coefficient * RADIUS / distance;
            let late = sound.duration + 130.0 / f64::from(hz) + distance / Medium::AIR.sound_speed;
            let (mut wrong, mut level) = (0.0_f64, 0.0_f64);
            for (time, pressure) in sound.times.iter().zip(&sound.pressures).filter(|(t, _)| **t > late) {
                let time = time - distance / Medium::AIR.sound_speed;
                let exact = (transfer * 2.0 * impulse * start * (pole * time).exp()).re;
                wrong = wrong.max((pressure - exact).abs());
                level = level.max(exact.abs());
            }
            error = error.max(wrong / level);
        }
    }
    add(
        table,
        "a mode of 310 Hz to 18 kHz for 0.25 s after an impact, played at 44.1, 48 and 192 kHz: pressure, \
         worst"
            .into(),
        "the decaying sine after a half-sine, in closed form",
        error,
        1e-4,
    );
    Ok(())
}

/// Peaks of the sound of a struck disc, at the frequencies of its modes.
fn peaks(table: &mut Validation) -> Outcome {
    let material = STEEL.material();
    let shape = Shape::parse("coin:0.03x0.002@0.003")?;
    let meridian = shape.meridian().ok_or("a coin has no section")?.about_centre_of_mass();
    let volume = meridian.volume();
    let geometry = BakeGeometry::axisymmetric(meridian);
    let options =
        ModalBakeOptions { max_frequency: 6500.0, accuracy: 0.03, ..ModalBakeOptions::new(Medium::AIR) };
    let mut go_on = |_: &_| ControlFlow::Continue(());
    let (mut model, mut evidence) = find_modes(&geometry, &material, &options, &mut go_on)?;
    radiate(&geometry, &mut model, &mut evidence, &options, &mut go_on)?;
    let modes: Vec<f64> = model.modes.iter().map(|m| m.frequency).collect();
    let source = ModalSource::new(Arc::new(model), &material.damping, &ModalSettings::default())?;
    let (surface, _) = shape.surface()?;
    let body = struck(surface, material, volume);
    let impact = impact(
        DVec3::new(0.0, -0.002, 0.0),
        DVec3::new(0.022, 0.001, 0.0),
        DVec3::new(0.1, 0.3, 0.15),
        16_000,
    )?;
    let sound = rung(&body, source, &impact, 1.0)?;
    let samples: Vec<f32> = sound.pressures.iter().map(|p| *p as f32).collect();
    let peaks = Spectrum::of(&samples, 16_000.0)?.peaks(6500.0, 40.0);
    let off = |f: f64| {
        let nearest = modes.iter().copied().min_by(|a, b| (a - f).abs().total_cmp(&(b - f).abs()));
        nearest.map_or(f64::INFINITY, |m| (f - m).abs() / (2e-3 * m).max(2.0))
    };
    // No peak at all would be no success.
    let error = match peaks.len() {
        0 => f64::INFINITY,
        _ => peaks.iter().map(|p| off(p.frequency)).fold(0.0, f64::max),
    };
    table.checks.push(Check {
        section: SECTION,
        quantity: format!(
            "struck steel disc: distance of {} peaks within 40 dB from a mode, worst",
            peaks.len()
        ),
        reference: "its modes; 1 is 0.2 % or 2 Hz, whichever is larger",
        error,
        bar: 1.0,
        unit: "",
    });
    Ok(())
}
