//! The sound of the ground: Rayleigh's integral of a piston, the surface of a half-space, and what it sends
//! straight up.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use clangor_core::body::BodyId;
use clangor_core::contact::ForceProfile;
use clangor_core::glam::{DQuat, DVec3};
use clangor_core::material::{Material, presets};
use clangor_core::medium::Medium;
use clangor_core::synthesis::ground::rayleigh_integral::SurfaceGrid;
use clangor_core::synthesis::ground::{GroundSource, HalfSpace, rayleigh_integral};
use clangor_core::synthesis::{
    AccelerationPulse, Listener, OverlapAdd, RenderSettings, Renderer, SoundSource,
};

use super::{Check, Extent, Fault, Outcome, Validation};

const SECTION: &str = "Ground";

pub(super) fn run(_extent: Extent, table: &mut Validation) -> Outcome {
    let mut check = |quantity: &str, reference, error, bar| {
        let quantity = quantity.into();
        table.checks.push(Check { section: SECTION, quantity, reference, error, bar, unit: "" });
    };
    check(
        "Rayleigh's integral of a piston, on its axis at 0.1, 1 and 10 diameters, of the peak",
        "Stepanishen 1971",
        piston_on_its_axis(),
        1e-2,
    );
    check(
        "Rayleigh's integral of a piston, ka = 5, 30° off its axis at 400 diameters",
        "2 J₁(ka sin θ)/(ka sin θ)",
        piston_far_away(),
        1e-2,
    );
    check(
        "surface of a half-space, ν = ¼, under a force that begins and stays",
        "Pekeris 1955",
        pekeris()?,
        1e-9,
    );
    for (name, quantity) in [
        ("soil", "an impact on soil, as it is rendered 100 m straight above, of the peak"),
        ("rubber", "an impact on rubber, as it is rendered 100 m straight above, of the peak"),
    ] {
        check(quantity, "impedance of pressure waves, −ρF′/(2πR ρ_s c_P)", straight_up(name)?, 3e-2);
    }
    Ok(())
}

fn material(name: &str) -> Result<Material, Fault> {
    Ok(presets::preset(name).ok_or_else(|| format!("there is no preset {name}"))?)
}

/// p = ρc (v(t − z/c) − v(t − √(z² + a²)/c)).
fn piston_on_its_axis() -> f64 {
    let medium = Medium::AIR;
    let Medium { density, sound_speed } = medium;
    let (a, width) = (0.05f64, 4e-5);
    let speed = |t: f64| (-0.5 * (t / width).powi(2)).exp();
    let acceleration = |r: f64, t: f64| if r < a { -t / (width * width) * speed(t) } else { 0.0 };
    let grid = SurfaceGrid { radius: a, rings: 300, points: 1 };
    let mut worst = 0.0f64;
    for z in [0.01, 0.1, 1.0] {
        let exact = |t: f64| {
            density * sound_speed * (speed(t - z / sound_speed) - speed(t - z.hypot(a) / sound_speed))
        };
        let times = (-50..100).map(|i| z / sound_speed + f64::from(i) * 5e-6);
        let largest = times.clone().map(|t| exact(t).abs()).fold(0.0, f64::max);
        let differs = |t| (rayleigh_integral(&medium, (0.0, z), t, &grid, &acceleration) - exact(t)).abs();
        worst = worst.max(times.map(differs).fold(0.0, f64::max) / largest);
    }
    worst
}

/// J₁(2.5) = 0.497094.
fn piston_far_away() -> f64 {
    let medium = Medium::AIR;
    let a = 0.05;
    let omega = 5.0 * medium.sound_speed / a;
    let distance = 40.0;
    let place = (0.5 * distance, 0.75f64.sqrt() * distance);
    let grid = SurfaceGrid { radius: a, rings: 60, points: 60 };
    let part = |phase: f64| rayleigh_integral(&medium, place, 0.0, &grid, &|_, t| (omega * t + phase).cos());
    let exact = medium.density * a * a / (2.0 * distance) * 2.0 * 0.497_094_1 / 2.5;
    (part(0.0).hypot(part(0.5 * PI)) / exact - 1.0).abs()
}

/// u μ π r / F over c_S t/r.
fn pekeris() -> Result<f64, Fault> {
    let quarter = Material { poisson_ratio: 0.25, ..material("granite")? };
    let solid = HalfSpace::try_new(&quarter, Medium::AIR.sound_speed)?;
    let root3 = 3f64.sqrt();
    let gamma_square = 0.25 * (3.0 + root3);
    let mut worst = 0.0f64;
    for i in 1..200 {
        let tau = f64::from(i) * 0.008;
        let rayleigh = || (3.0 * root3 + 5.0).sqrt() / (gamma_square - tau * tau).sqrt();
        let exact = if tau < 1.0 / root3 {
            0.0
        } else if tau < 1.0 {
            let other = (3.0 * root3 - 5.0).sqrt() / (tau * tau + 0.25 * root3 - 0.75).sqrt();
            (6.0 - root3 / (tau * tau - 0.25).sqrt() - rayleigh() + other) / 32.0
        } else if tau * tau < gamma_square {
            (6.0 - rayleigh()) / 16.0
        } else {
            6.0 / 16.0
        };
        worst = worst.max((0.5 * solid.step_displacement(tau) - exact).abs() / exact.abs().max(1.0));
    }
    Ok(worst)
}

/// An impact, rendered, against the closed form far straight above.
fn straight_up(name: &str) -> Result<f64, Fault> {
    let (height, impulse, duration, time) = (100.0, 0.3, 1e-3, 5e-3);
    let solid = material(name)?;
    let medium = Medium::AIR;
    let ground = Arc::new(GroundSource::try_new(&solid, &medium)?);
    let click = AccelerationPulse {
        body: BodyId(0),
        time,
        duration,
        shape: ForceProfile::Gaussian.into(),
        centre: DVec3::ZERO,
        orientation: DQuat::IDENTITY,
        velocity_change: DVec3::ZERO,
        angular_velocity_change: DVec3::ZERO,
        source: SoundSource::Ground { ground: Arc::clone(&ground).into(), impulse },
    };
    let settings = RenderSettings::default();
    let mut renderer = Renderer::new(&Listener::fixed("above", DVec3::Y * height), &settings)?;
    renderer.push(&click)?;
    let mut signal = OverlapAdd::new(1, 0);
    renderer.take_all().iter().for_each(|job| signal.add(&job.render()));
    let samples = signal.take_until(24_000).swap_remove(0);
    let impedance = solid.density * ground.solid.pressure_speed();
    let exact = |t: f64| {
        let since = t - time - height / medium.sound_speed;
        let slope =
            -12.0 / duration * (since / duration - 0.5) * ForceProfile::Gaussian.value(since, duration);
        -medium.density * impulse * slope / (TAU * height * impedance)
    };
    let (mut worst, mut largest) = (0.0f64, 0.0f64);
    for (i, pressure) in samples.iter().enumerate() {
        let exact = exact(i as f64 / settings.sample_rate.as_f64());
        worst = worst.max((pressure - exact).abs());
        largest = largest.max(exact.abs());
    }
    Ok(worst / largest)
}
