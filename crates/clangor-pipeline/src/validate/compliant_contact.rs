//! Contact between bodies that give way: restitution, spectrum, losses and energy of solved impacts, against
//! equations of motion integrated by Runge–Kutta and closed forms.

use std::f64::consts::{PI, TAU};

use clangor_core::contact::compliant::{
    ContactLaw, ContactSolution, ContactSystem, HertzLaw, Member, MemberContact, SolverMemory, StepSettings,
    half_space_radiation, restitution_damping,
};
use clangor_core::glam::{DMat3, DVec3};
use clangor_core::material::presets::{GLASS, STEEL};
use clangor_core::math::random::SplitMix;
use num_complex::Complex64;

use super::{Check, Extent, Fault, Outcome, Validation};

const SECTION: &str = "Contact";

pub(super) fn run(_extent: Extent, table: &mut Validation) -> Outcome {
    let mut add = |quantity: &str, reference, error, bar, unit| {
        let quantity = quantity.into();
        table.checks.push(Check { section: SECTION, quantity, reference, error, bar, unit });
    };
    let [restitution, level] = free_pair()?;
    add(
        "solved impact of two free steel balls of 11 mm, 1 m/s, 64 steps: restitution",
        "1",
        restitution,
        1e-12,
        "",
    );
    add(
        "its force: spectrum to 20 kHz, worst",
        "m d̈ = −k d^1.5 integrated by Runge–Kutta",
        level,
        0.03,
        "dB",
    );
    let reference = "Zener 1941, integrated by Runge–Kutta";
    add("restitution on an endless plate, λ from 0.01 to 3, worst", reference, endless_plate()?, 2e-4, "");
    add(
        "loss of a steel ball of 5 mm to waves in a glass half-space, 0.1 and 1 m/s, worst",
        "κ ∫Ḟ² dt of Hertz's force, in closed form",
        half_space()?,
        0.02,
        "",
    );
    add(
        "200 oblique impacts with friction on ringing bodies of 40 modes, 1 to 64 steps: energy balance",
        "motion, modes, contact and losses sum to 0",
        energy_balance()?,
        1e-12,
        "",
    );
    Ok(())
}

fn rigid(mass: f64, radius: f64, velocity: DVec3, centre: DVec3) -> Member {
    Member {
        inverse_mass: 1.0 / mass,
        inverse_inertia: DMat3::from_diagonal(DVec3::splat(2.5 / (mass * radius * radius))),
        centre,
        velocity,
        angular_velocity: DVec3::ZERO,
        acceleration: DVec3::ZERO,
        poles: Vec::new(),
        state: Vec::new(),
    }
}

fn steel_ball(radius: f64, speed: f64) -> Member {
    let mass = STEEL.density * 4.0 / 3.0 * PI * radius.powi(3);
    rigid(mass, radius, -speed * DVec3::Y, radius * DVec3::Y)
}

fn contact(members: [Option<usize>; 2], law: HertzLaw) -> MemberContact {
    MemberContact {
        members,
        point: DVec3::ZERO,
        normal: DVec3::Y,
        velocity: DVec3::ZERO,
        law: ContactLaw::Hertz(law),
        gap: 0.0,
        friction: 0.0,
        standing: false,
        shapes: [Vec::new(), Vec::new()],
    }
}

fn solve(members: &[Member], hit: MemberContact, steps: f64) -> Result<ContactSolution, Fault> {
    let system = ContactSystem::new(members, &[hit])?;
    let settings = StepSettings { steps_per_duration: steps, max_steps: 4000, ..StepSettings::default() };
    Ok(system.solve(&settings, &mut SolverMemory::default())?.clone())
}

/// z = ∫s^{3/2} of a Zener contact after steps of the classical Runge–Kutta method until it opens, and its
/// force at each: ṡ = 1 − z − λ s^{3/2}, ż = s^{3/2}, in units of Hertz's contact.
pub(super) fn zener_course(lambda: f64, step: f64) -> (f64, Vec<f64>) {
    let force = |s: f64| s.max(0.0).powf(1.5);
    let rate = |[s, z]: [f64; 2]| [1.0 - z - lambda * force(s), force(s)];
    let along = |a: [f64; 2], h: f64, k: [f64; 2]| [a[0] + h * k[0], a[1] + h * k[1]];
    let (mut state, mut forces) = ([0.0, 0.0], Vec::new());
    while state[0] >= 0.0 && forces.len() < 2_000_000 {
        forces.push(force(state[0]));
        let k1 = rate(state);
        let k2 = rate(along(state, 0.5 * step, k1));
        let k3 = rate(along(state, 0.5 * step, k2));
        let k4 = rate(along(state, step, k3));
        let mean = [0, 1].map(|i| (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]) / 6.0);
        state = along(state, step, mean);
    }
    (state[1], forces)
}

/// |∫F e^{−iωt} dt| of forces at even times, or that are constant on steps.
fn spectrum(forces: impl Iterator<Item = f64>, step: f64, omega: f64) -> f64 {
    let sum: Complex64 = forces.enumerate().map(|(n, f)| f * Complex64::cis(-omega * step * n as f64)).sum();
    step * sum.norm()
}

/// Errors of restitution and of the spectrum \[dB\].
fn free_pair() -> Result<[f64; 2], Fault> {
    let radius = 0.011;
    let stiffness = 4.0 / 3.0 * (0.5_f64 * radius).sqrt() / (2.0 * STEEL.material().contact_compliance());
    let members = [steel_ball(radius, 1.0), Member { velocity: DVec3::ZERO, ..steel_ball(radius, 0.0) }];
    let members = members.map(|member| Member { centre: DVec3::ZERO, ..member });
    let law = HertzLaw { stiffness, ..HertzLaw::default() };
    let solution = solve(&members, contact([Some(0), Some(1)], law), 64.0)?;
    let restitution = (solution.velocities[0] - solution.velocities[1]).y;
    let inverse_mass = 2.0 * members[0].inverse_mass;
    let (unit, step) = ((inverse_mass * stiffness).powf(-0.4), 1e-3);
    let (_, exact) = zener_course(0.0, step);
    let mut worst = 0.0_f64;
    for k in 1..=100 {
        let omega = TAU * 200.0 * f64::from(k);
        let reference = spectrum(exact.iter().copied(), unit * step, omega) / unit;
        let half = 0.5 * omega * solution.step;
        let steps = solution.forces.iter().map(|force| force[0]);
        let found = spectrum(steps, solution.step, omega) * half.sin() / half * inverse_mass;
        worst = worst.max((20.0 * (found / reference).log10()).abs());
    }
    Ok([(restitution - 1.0).abs(), worst])
}

/// Worst error of the restitution on an endless plate.
fn endless_plate() -> Result<f64, Fault> {
    let (ball, stiffness) = (steel_ball(0.005, 1.0), 4e9);
    let unit = (ball.inverse_mass * stiffness).powf(-0.4);
    let mut worst = 0.0_f64;
    for lambda in [0.01, 0.03, 0.1, 0.3, 1.0, 3.0] {
        let plate_mobility = lambda * unit * ball.inverse_mass;
        let law = HertzLaw { stiffness, plate_mobility, ..HertzLaw::default() };
        let solution = solve(std::slice::from_ref(&ball), contact([Some(0), None], law), 64.0)?;
        let found = solution.impulse(0).y * ball.inverse_mass;
        worst = worst.max((found - zener_course(lambda, 1e-3).0).abs());
    }
    Ok(worst)
}

/// Worst relative error of the loss to a half-space.
fn half_space() -> Result<f64, Fault> {
    let (radius, glass) = (0.005_f64, GLASS.material());
    let radiation = half_space_radiation(glass.youngs_modulus, glass.poisson_ratio, glass.density);
    let compliance = STEEL.material().contact_compliance() + glass.contact_compliance();
    let stiffness = 4.0 / 3.0 * radius.sqrt() / compliance;
    let mut worst = 0.0_f64;
    for speed in [0.1, 1.0] {
        let ball = steel_ball(radius, speed);
        let depth = (1.25 * speed * speed / (ball.inverse_mass * stiffness)).powf(0.4);
        // ∫Ḟ² dt = 1.5918 F² V/d.
        let loss = radiation * 1.591_815 * (stiffness * depth.powf(1.5)).powi(2) * speed / depth;
        let law = HertzLaw { stiffness, radiation, ..HertzLaw::default() };
        let solution = solve(&[ball], contact([Some(0), None], law), 64.0)?;
        worst = worst.max((solution.energies.motion_lost / loss - 1.0).abs());
    }
    Ok(worst)
}

/// Largest residual of the energy over the energy at first.
fn energy_balance() -> Result<f64, Fault> {
    let mut random = SplitMix::new(17);
    let mut worst = 0.0_f64;
    for _ in 0..200 {
        let radius = random.uniform(0.002, 0.015);
        let mut striker = steel_ball(radius, random.uniform(0.1, 5.0));
        striker.velocity.x = random.uniform(-2.0, 2.0);
        let energy = 0.5 * striker.velocity.length_squared() / striker.inverse_mass;
        let mut target = rigid(random.uniform(0.05, 0.6), 0.1, DVec3::ZERO, DVec3::new(0.05, -0.01, 0.02));
        let mut shapes = Vec::new();
        for mode in 0..40 {
            let omega = TAU * 400.0 * (f64::from(mode) + random.uniform(0.6, 1.0));
            target.poles.push(Complex64::new(-2e-3 * omega, omega));
            let share = random.uniform(0.0, 0.2 * energy);
            target.state.push(Complex64::from_polar((share / 20.0).sqrt(), random.uniform(0.0, TAU)));
            shapes.push(random.uniform(0.5, 2.0) * target.inverse_mass.sqrt() * random.direction());
        }
        let vibration: f64 = target.state.iter().map(|w| 0.5 * w.norm_sqr()).sum();
        let law = HertzLaw {
            stiffness: 6e10 * radius.sqrt(),
            restitution_damping: restitution_damping(random.uniform(0.6, 1.0)),
            ..HertzLaw::default()
        };
        let mut hit = contact([Some(0), Some(1)], law);
        hit.friction = random.uniform(0.0, 1.0);
        hit.shapes[1] = shapes;
        let system = ContactSystem::new(&[striker, target], &[hit])?;
        let settings = StepSettings {
            steps_per_duration: random.uniform(0.0, 6.0).exp2(),
            max_steps: 2000,
            modal_loss: true,
            ..StepSettings::default()
        };
        let mut memory = SolverMemory::default();
        let solution = system.solve(&settings, &mut memory)?;
        worst = worst.max(solution.energies.residual().abs() / (energy + vibration));
    }
    Ok(worst)
}
