//! The sound of the ground against closed forms: Pekeris, Boussinesq, a piston, and the wave straight up.

use std::f64::consts::{PI, TAU};

use clangor_core::glam::DVec3;
use clangor_core::material::Material;
use clangor_core::material::presets::preset;
use clangor_core::medium::Medium;
use clangor_core::synthesis::ground::rayleigh_integral::SurfaceGrid;
use clangor_core::synthesis::ground::{GroundSource, HalfSpace, rayleigh_integral};
use num_complex::Complex64;

fn solid(poisson_ratio: f64) -> HalfSpace {
    let material = Material { poisson_ratio, ..preset("granite").unwrap() };
    HalfSpace::try_new(&material, 343.2).unwrap()
}

#[test]
fn surface_moves_as_pekeris_found_and_comes_to_rest_where_boussinesq_did() {
    // Pekeris 1955, ν = ¼: u μ π r / F, between P and S and between S and Rayleigh's wave.
    let quarter = solid(0.25);
    let root3 = 3f64.sqrt();
    let gamma = 0.5 * (3.0 + root3).sqrt();
    for i in 1..200 {
        let tau = f64::from(i) * 0.008;
        let rayleigh = || (3.0 * root3 + 5.0).sqrt() / (gamma * gamma - tau * tau).sqrt();
        let pekeris = match tau {
            t if t < 1.0 / root3 => 0.0,
            t if t < 1.0 => {
                let other = (3.0 * root3 - 5.0).sqrt() / (t * t + 0.25 * root3 - 0.75).sqrt();
                (6.0 - root3 / (t * t - 0.25).sqrt() - rayleigh() + other) / 32.0
            }
            t if t < gamma => (6.0 - rayleigh()) / 16.0,
            _ => 6.0 / 16.0,
        };
        let displacement = 0.5 * quarter.step_displacement(tau);
        // Rounding near the singularity of Rayleigh's wave.
        assert!((displacement - pekeris).abs() < 1e-11 * pekeris.abs().max(1.0), "{tau}: {displacement}");
    }
    for nu in [0.0, 0.1, 0.26, 0.27, 0.33, 0.49] {
        let solid = solid(nu);
        let ratio = (0.5 * (1.0 - 2.0 * nu) / (1.0 - nu)).sqrt();
        assert_eq!(solid.step_displacement(0.999 * ratio), 0.0, "before the pressure wave");
        assert!(solid.step_displacement(1.001 * ratio) < 0.0, "the first motion is against the force");
        let rayleigh = solid.shear_speed() / solid.rayleigh_speed();
        assert!(solid.step_displacement(rayleigh * (1.0 - 1e-6)) < -10.0, "Rayleigh's wave");
        assert_eq!(solid.step_displacement(rayleigh * (1.0 + 1e-6)), 1.0 - nu);
    }
    // Viktorov's table, ν = ¼.
    assert!((quarter.rayleigh_speed() / quarter.shear_speed() - 0.919_402).abs() < 1e-6);
}

#[test]
fn rayleigh_integral_of_a_piston() {
    // Stepanishen 1971, on the axis: p = ρc (v(t − z/c) − v(t − √(z² + a²)/c)).
    let medium = Medium::AIR;
    let (rho, c) = (medium.density, medium.sound_speed);
    let (a, width) = (0.05, 4e-5);
    let speed = |t: f64| (-0.5 * (t / width).powi(2)).exp();
    let acceleration = |r: f64, t: f64| if r < a { -t / (width * width) * speed(t) } else { 0.0 };
    let grid = SurfaceGrid { radius: a, rings: 300, points: 1 };
    for z in [0.01, 0.1, 1.0] {
        let exact = |t: f64| rho * c * (speed(t - z / c) - speed(t - z.hypot(a) / c));
        let times: Vec<f64> = (-150..250).map(|i| z / c + f64::from(i) * 2e-6).collect();
        let largest = times.iter().map(|t| exact(*t).abs()).fold(0.0, f64::max);
        let worst = times
            .iter()
            .map(|t| (rayleigh_integral(&medium, (0.0, z), *t, &grid, &acceleration) - exact(*t)).abs())
            .fold(0.0, f64::max);
        println!("piston, axis at {z} m: {:.1e}", worst / largest);
        // Residual seen: 2.4e-5.
        assert!(worst < 1e-3 * largest, "{z}: {:e}", worst / largest);
    }
    // Far away, 2 J₁(ka sin θ)/(ka sin θ), here ka = 5 at 30°: J₁(2.5) = 0.497094.
    let omega = 5.0 * c / a;
    let distance = 40.0;
    let (across, above) = (0.5 * distance, 0.75f64.sqrt() * distance);
    let grid = SurfaceGrid { radius: a, rings: 60, points: 60 };
    let part = |phase: f64| {
        rayleigh_integral(&medium, (across, above), 0.0, &grid, &|_, t| (omega * t + phase).cos())
    };
    let amplitude = part(0.0).hypot(part(0.5 * PI));
    let closed = rho * a * a / (2.0 * distance) * 2.0 * 0.497_094_1 / 2.5;
    println!("piston, far: {:.1e}", amplitude / closed - 1.0);
    // Residual seen: 3.1e-4.
    assert!((amplitude / closed - 1.0).abs() < 1e-3, "{amplitude} against {closed}");
}

#[test]
fn straight_up_the_ground_is_its_impedance() {
    // Far above, the pressed plane sends −ρ F′/(2πR ρ_s c_P), whatever Poisson's ratio and the waves along
    // the surface.
    for (name, medium) in [("granite", Medium::AIR), ("rubber", Medium::AIR), ("wood", Medium::AIR)] {
        let material = preset(name).unwrap();
        let ground = GroundSource::try_new(&material, &medium).unwrap();
        let (height, omega) = (300.0, TAU * 10_000.0);
        let pressure = ground.transfer(DVec3::Y * height, &[omega])[0];
        let impedance = material.density * ground.solid.pressure_speed();
        let delay = Complex64::from_polar(1.0, -omega * height / medium.sound_speed);
        let exact = -Complex64::I * omega * medium.density / (TAU * height * impedance) * delay;
        println!("{name}, straight up: {:.1e}", (pressure / exact - 1.0).norm());
        // Residual seen: 6e-4.
        assert!((pressure / exact - 1.0).norm() < 5e-3, "{name}: {}", pressure / exact);
    }
}

#[test]
fn far_field_of_a_slow_ground_carries_the_power_of_its_directivity() {
    // No wave along this ground is as fast as sound: all that reaches far is |f(sin θ)|².
    let material =
        Material { youngs_modulus: 2e7, poisson_ratio: 0.35, density: 1800.0, ..preset("rubber").unwrap() };
    let medium = Medium::AIR;
    let ground = GroundSource::try_new(&material, &medium).unwrap();
    assert!(ground.solid.pressure_speed() < medium.sound_speed);
    let (distance, omega) = (60.0, TAU * 2000.0);
    let scale = medium.density / (TAU * ground.solid.shear_modulus) * omega * medium.sound_speed / distance;
    let (mut heard, mut sent) = (0.0, 0.0);
    for i in 0..90 {
        let theta = (f64::from(i) + 0.5).to_radians();
        let place = distance * DVec3::new(theta.sin(), theta.cos(), 0.0);
        heard += (ground.transfer(place, &[omega])[0] / scale).norm_sqr() * theta.sin();
        let square = Complex64::new(theta.sin().powi(2), 0.0);
        sent += ground.solid.admittance(square).norm_sqr() * theta.sin();
    }
    println!("power: {:.1e}", heard / sent - 1.0);
    // Residual seen: 2e-4.
    assert!((heard / sent - 1.0).abs() < 6e-3, "{heard} of {sent}");
}
