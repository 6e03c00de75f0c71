//! Impacts between bodies that give way against closed forms and ordinary differential equations.

use std::f64::consts::{PI, TAU};

use crate::compliant_bodies::{ball, contact, hertz};
use clangor_core::contact::compliant::{
    ContactEnd, ContactLaw, ContactSolution, ContactSystem, HalfSpaceLoss, HertzLaw, Member, MemberContact,
    SolverMemory, StepSettings, half_space_loss, half_space_radiation, hertz_duration, modal_tail,
    restitution_damping, viscosity,
};
use clangor_core::glam::{DMat3, DVec3};
use num_complex::Complex64;

fn solve(members: &[Member], contacts: &[MemberContact], settings: &StepSettings) -> ContactSolution {
    let system = ContactSystem::new(members, contacts).unwrap();
    system.solve(settings, &mut SolverMemory::default()).unwrap().clone()
}

fn steps(steps_per_duration: f64) -> StepSettings {
    StepSettings { steps_per_duration, ..StepSettings::default() }
}

/// A ball that falls on something immovable, and its restitution by the impulse.
fn drop_ball(radius: f64, speed: f64, law: HertzLaw, per_duration: f64) -> (ContactSolution, f64) {
    let striker = ball(radius, radius * DVec3::Y, -speed * DVec3::Y);
    let momentum = speed / striker.inverse_mass;
    let hit = contact([Some(0), None], DVec3::ZERO, DVec3::Y, law);
    let solution = solve(&[striker], &[hit], &steps(per_duration));
    let restitution = solution.impulse(0).y / momentum - 1.0;
    (solution, restitution)
}

/// Classical Runge–Kutta steps of s̈ = −f(s, ṡ) from s = 0, ṡ = 1 until the force is no longer positive:
/// times, forces and last speed, with the last step shortened to the end of the force.
fn course(force: impl Fn(f64, f64) -> f64, step: f64) -> (Vec<f64>, f64) {
    let advance = |[s, v]: [f64; 2], h: f64| {
        let a = |s: f64, v: f64| -force(s.max(0.0), v);
        let (k1, l1) = (v, a(s, v));
        let (k2, l2) = (v + 0.5 * h * l1, a(s + 0.5 * h * k1, v + 0.5 * h * l1));
        let (k3, l3) = (v + 0.5 * h * l2, a(s + 0.5 * h * k2, v + 0.5 * h * l2));
        let (k4, l4) = (v + h * l3, a(s + h * k3, v + h * l3));
        [s + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4), v + h / 6.0 * (l1 + 2.0 * l2 + 2.0 * l3 + l4)]
    };
    let mut state = [0.0, 1.0];
    let mut forces = vec![0.0];
    loop {
        // Small steps where the root makes the force rough.
        let mut next = state;
        let parts = if state[0] < 0.05 { 64 } else { 1 };
        for _ in 0..parts {
            next = advance(next, step / f64::from(parts));
        }
        let f = force(next[0].max(0.0), next[1]);
        if f <= 0.0 || next[0] <= 0.0 {
            let last = *forces.last().unwrap();
            let share = if f < 0.0 { last / (last - f) } else { 0.5 };
            return (forces, state[1] + share * (next[1] - state[1]));
        }
        forces.push(f);
        state = next;
    }
}

#[test]
fn a_free_pair_keeps_its_energy_and_has_the_spectrum_of_hertz() {
    let radius = 0.011;
    let young = 200e9 / (1.0 - 0.29 * 0.29) / 2.0;
    let stiffness = 4.0 / 3.0 * young * (0.5_f64 * radius).sqrt();
    let members = [ball(radius, radius * DVec3::Y, -DVec3::Y), ball(radius, -radius * DVec3::Y, DVec3::ZERO)];
    let hit = contact([Some(0), Some(1)], DVec3::ZERO, DVec3::Y, hertz(stiffness));
    let inverse_mass = 2.0 * members[0].inverse_mass;
    for per_duration in [4.0, 8.0, 64.0] {
        let solution = solve(&members, std::slice::from_ref(&hit), &steps(per_duration));
        let restitution = (solution.velocities[0] - solution.velocities[1]).y;
        // Residual seen: 2e-15.
        assert!((restitution - 1.0).abs() < 1e-12, "{restitution}");
        assert_eq!((solution.end, solution.hits[0]), (ContactEnd::Parted, 1));
    }
    let solution = solve(&members, &[hit], &steps(64.0));
    let unit = (inverse_mass * stiffness).powf(-0.4);
    let step = 2e-4;
    let (exact, _) = course(|s, _| s.powf(1.5), step);
    let mut worst = 0.0_f64;
    for i in 1..=200 {
        let omega = TAU * 100.0 * f64::from(i);
        let sum = |forces: &mut dyn Iterator<Item = f64>, h: f64, at: f64| -> Complex64 {
            forces.enumerate().map(|(n, f)| h * f * Complex64::cis(-omega * h * (n as f64 + at))).sum()
        };
        let true_level = sum(&mut exact.iter().copied(), unit * step, 0.0).norm() / unit;
        let half = 0.5 * omega * solution.step;
        let forces = &mut solution.forces.iter().map(|f| f[0]);
        let level = sum(forces, solution.step, 0.5).norm() * half.sin() / half * inverse_mass;
        worst = worst.max((20.0 * (level / true_level).log10()).abs());
    }
    println!("spectrum {worst} dB");
    // Residual seen: 0.013 dB.
    assert!(worst < 0.03, "{worst}");
}

#[test]
fn a_ball_on_an_endless_plate_bounces_as_zener_has_it() {
    let (radius, k) = (0.005, 4e9);
    let inverse_mass = ball(radius, DVec3::ZERO, DVec3::ZERO).inverse_mass;
    let unit = (inverse_mass * k).powf(-0.4);
    for lambda in [0.01, 0.03, 0.1, 0.3, 0.5, 1.0, 2.0, 3.0] {
        let exact = zener(lambda);
        let law = HertzLaw { plate_mobility: lambda * unit * inverse_mass, ..hertz(k) };
        let (solution, restitution) = drop_ball(radius, 1.0, law, 64.0);
        println!("λ {lambda}: {exact} {restitution}");
        // Residual seen: 6e-5.
        assert!((restitution - exact).abs() < 2e-4, "λ {lambda}: {restitution} {exact}");
        assert!(solution.energies.residual().abs() < 1e-12 * 0.5 / inverse_mass);
    }
}

/// \[Zener1941\]: ∫s^{3/2} − 1 of s̈ + (1 + λ d/dt) s^{3/2} = 0: with z = ∫s^{3/2}, ṡ = 1 − z − λ s^{3/2}.
fn zener(lambda: f64) -> f64 {
    let rate = |[s, z]: [f64; 2]| {
        let force = s.max(0.0).powf(1.5);
        [1.0 - z - lambda * force, force]
    };
    let shifted = |a: [f64; 2], h: f64, k: [f64; 2]| [a[0] + h * k[0], a[1] + h * k[1]];
    let (mut state, step) = ([0.0, 0.0], 2e-4);
    for _ in 0..2_000_000 {
        let k1 = rate(state);
        let k2 = rate(shifted(state, 0.5 * step, k1));
        let k3 = rate(shifted(state, 0.5 * step, k2));
        let k4 = rate(shifted(state, step, k3));
        for i in 0..2 {
            state[i] += step / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
        }
        if state[0] <= 0.0 {
            break;
        }
    }
    state[1] - 1.0
}

#[test]
fn a_half_space_takes_what_lamb_has() {
    // Residual seen: 5e-6, the digits of the table.
    for (poisson, beta) in [(0.0, 0.21396), (0.2, 0.15986), (0.25, 0.14813), (0.3, 0.13723), (0.4, 0.11824)] {
        let HalfSpaceLoss { body, rayleigh } = half_space_loss(poisson);
        assert!((body + rayleigh - beta).abs() < 1e-5, "{poisson}: {body} + {rayleigh}");
    }
    let HalfSpaceLoss { body, rayleigh } = half_space_loss(0.25);
    assert!((rayleigh / (body + rayleigh) - 0.674).abs() < 5e-4);
    // Near its limits it stays finite.
    for poisson in [-0.9, 0.0, 0.45, 0.499] {
        let HalfSpaceLoss { body, rayleigh } = half_space_loss(poisson);
        assert!(body > 0.0 && rayleigh > 0.0 && body + rayleigh < 1.0, "{poisson}: {body} + {rayleigh}");
    }
}

#[test]
fn waves_into_a_half_space_cost_what_the_closed_form_says() {
    // Steel on glass: κ ∫Ḟ² dt with Hertz's own force, ∫Ḟ² = 1.591815 F² V/d.
    let (radius, kappa) = (0.005, half_space_radiation(62e9, 0.2, 2600.0));
    let contact_modulus = 1.0 / ((1.0 - 0.29 * 0.29) / 200e9 + (1.0 - 0.2 * 0.2) / 62e9);
    let k = 4.0 / 3.0 * contact_modulus * f64::sqrt(radius);
    let mass = 1.0 / ball(radius, DVec3::ZERO, DVec3::ZERO).inverse_mass;
    for speed in [0.1, 1.0, 5.0] {
        let depth = (1.25 * mass * speed * speed / k).powf(0.4);
        let loss = kappa * 1.591_815 * (k * depth.powf(1.5)).powi(2) * speed / depth;
        let (solution, _) = drop_ball(radius, speed, HertzLaw { radiation: kappa, ..hertz(k) }, 32.0);
        let relative = solution.energies.motion_lost / loss - 1.0;
        println!("half-space at {speed} m/s: {relative}");
        // Residual seen: 0.017 at 5 m/s, where the loss itself changes the motion.
        assert!(relative.abs() < 0.02, "{relative}");
    }
}

#[test]
fn a_contact_has_the_restitution_it_is_to_have() {
    let (radius, k) = (0.008, 3e9);
    let inverse_mass = ball(radius, DVec3::ZERO, DVec3::ZERO).inverse_mass;
    for wanted in [0.98, 0.9, 0.7, 0.5, 0.3, 0.2, 0.1, 0.05, 0.02] {
        let alpha = restitution_damping(wanted);
        let (_, speed) = course(|s, v| s.powf(1.5) + alpha * s.sqrt().sqrt() * v, 2e-4);
        // Residuals seen: below the bars; with the step law 7e-5.
        assert!((-speed - wanted).abs() < 1e-5, "{wanted}: {speed}");
        let x = 1.5 * viscosity(wanted, 1.0, 1.0, 1.0);
        let (_, speed) = course(|s, v| s.powf(1.5) + x * s.sqrt() * v, 2e-4);
        assert!((-speed - wanted).abs() < 4e-5, "{wanted}: {speed} viscoelastic");
        for (law, speed) in [
            (HertzLaw { restitution_damping: alpha, ..hertz(k) }, 0.02),
            (HertzLaw { restitution_damping: alpha, ..hertz(k) }, 5.0),
            (HertzLaw { viscosity: viscosity(wanted, k, inverse_mass, 3.0), ..hertz(k) }, 3.0),
        ] {
            let (_, restitution) = drop_ball(radius, speed, law, 256.0);
            println!("{wanted} at {speed}: {:.1e}", restitution - wanted);
            assert!((restitution - wanted).abs() < 1e-3, "{wanted}: {restitution}");
        }
    }
    assert_eq!(restitution_damping(1.0), 0.0);
    assert_eq!(restitution_damping(0.0), restitution_damping(0.01));
    // The series of [SchwagerPoeschel1998] for small losses.
    let series = |x: f64| 1.0 - 1.15344 * x + 0.79826 * x * x;
    let x = 1.5 * viscosity(series(0.03), 1.0, 1.0, 1.0);
    assert!((x - 0.03).abs() < 2e-4, "{x}");
}

#[test]
fn friction_slips_by_coulomb_or_ends_in_rolling() {
    let (radius, k) = (0.01, 3e9);
    for (friction, sliding) in [(0.05, true), (0.9, false)] {
        let striker = ball(radius, radius * DVec3::Y, DVec3::new(1.0, -2.0, 0.5));
        let mass = 1.0 / striker.inverse_mass;
        let along = DVec3::new(1.0, 0.0, 0.5);
        let mut hit = contact([Some(0), None], DVec3::ZERO, DVec3::Y, hertz(k));
        hit.friction = friction;
        let solution = solve(&[striker], &[hit], &steps(32.0));
        let impulse = solution.impulse(0);
        let sideways = DVec3::new(impulse.x, 0.0, impulse.z);
        let exact = if sliding {
            -friction * impulse.y * along.normalize()
        } else {
            // A ball ends rolling: 2/7 of its momentum along the ground.
            -2.0 / 7.0 * mass * along
        };
        // Residual seen: 3e-16 of the impulse.
        assert!((sideways - exact).length() < 1e-12 * impulse.length(), "{sideways} {exact}");
        assert!((impulse.y / (4.0 * mass) - 1.0).abs() < 1e-12);
    }
}

#[test]
fn a_ball_at_rest_stays_and_a_spring_swings() {
    let (radius, k, gravity) = (0.01, 3e9, 9.81);
    let mut resting = ball(radius, radius * DVec3::Y, DVec3::ZERO);
    resting.acceleration = -gravity * DVec3::Y;
    let weight = gravity / resting.inverse_mass;
    let mut stand = contact([Some(0), None], DVec3::ZERO, DVec3::Y, hertz(k));
    stand.gap = -(weight / k).powf(2.0 / 3.0);
    stand.standing = true;
    let settings = StepSettings { max_steps: 500, ..steps(16.0) };
    let solution = solve(&[resting.clone()], &[stand.clone()], &settings);
    assert_eq!(solution.end, ContactEnd::StillTouching);
    // Residual seen: 2e-14.
    assert!(solution.forces.iter().all(|f| (f[0] / weight - 1.0).abs() < 1e-9));
    // Half a period of a linear spring turns the velocity round.
    resting.acceleration = DVec3::ZERO;
    resting.velocity = -DVec3::Y;
    let stiffness = 1e5;
    stand.law = ContactLaw::Spring { stiffness, damping: 0.0 };
    stand.gap = 0.0;
    let half = PI / (stiffness * resting.inverse_mass).sqrt();
    let settings = StepSettings { step: Some(half / 400.0), max_steps: 400, ..steps(16.0) };
    let solution = solve(&[resting.clone()], &[stand], &settings);
    // Residual seen: 4e-11: the step law keeps the energy, and its period is h² off.
    assert!((solution.velocities[0].y - 1.0).abs() < 1e-8, "{}", solution.velocities[0].y);
    let period = hertz_duration(resting.inverse_mass, k, 1.0);
    assert!(period > 1e-5 && period < 1e-3);
}

/// Modes of a supported glass pane, 50 × 50 cm, at a point: pole and displacement [kg^−½], by frequency.
fn pane(thickness: f64, highest: f64) -> Vec<(Complex64, f64)> {
    let (young, poisson, density, side) = (62e9, 0.2, 2600.0, 0.5);
    let surface = density * thickness;
    let ratio = (young * f64::powi(thickness, 3) / 12.0 / (1.0 - poisson * poisson) / surface).sqrt();
    let most = ((TAU * highest / ratio).sqrt() * side / PI) as usize + 1;
    let mut modes = Vec::new();
    for (m, n) in (1..=most).flat_map(|m| (1..=most).map(move |n| (m as f64, n as f64))) {
        let omega = ratio * (PI / side).powi(2) * (m * m + n * n);
        if omega < TAU * highest {
            let shape = (PI * m * 0.27 / side).sin() * (PI * n * 0.23 / side).sin();
            let pole = Complex64::new(-0.0005 * omega, omega);
            modes.push((pole, 2.0 / (surface.sqrt() * side) * shape));
        }
    }
    modes.sort_by(|a, b| a.0.im.total_cmp(&b.0.im));
    modes
}

#[test]
fn a_tail_stands_for_the_modes_of_a_pane_above_the_band() {
    let radius = 0.005;
    let modulus = 1.0 / ((1.0 - 0.29 * 0.29) / 200e9 + (1.0 - 0.2 * 0.2) / 62e9);
    let k = 4.0 / 3.0 * modulus * f64::sqrt(radius);
    let striker = ball(radius, radius * DVec3::Y, -DVec3::Y);
    let momentum = 1.0 / striker.inverse_mass;
    let duration = hertz_duration(striker.inverse_mass, k, 1.0);
    // Restitution with all modes, of the shared note "compliant contact".
    for (thickness, known) in [(0.003, 0.171), (0.004, 0.383), (0.006, 0.652), (0.010, 0.855)] {
        let result = |modes: &[(Complex64, f64)]| {
            let mut target = ball(radius, DVec3::ZERO, DVec3::ZERO);
            (target.inverse_mass, target.inverse_inertia) = (0.0, DMat3::ZERO);
            target.poles = modes.iter().map(|(pole, _)| *pole).collect();
            let mut hit = contact([Some(0), Some(1)], DVec3::ZERO, DVec3::Y, hertz(k));
            hit.shapes[1] = modes.iter().map(|(_, shape)| *shape * DVec3::Y).collect();
            let settings = StepSettings { step: Some(duration / 64.0), max_steps: 2000, ..steps(64.0) };
            let solution = solve(&[striker.clone(), target], &[hit], &settings);
            let band = modes.iter().zip(solution.modal_state(1)).filter(|(mode, _)| mode.0.im < TAU * 20e3);
            let energy: f64 = band.map(|(_, w)| 0.5 * w.norm_sqr()).sum();
            (solution.impulse(0).y / momentum - 1.0, energy / (0.5 * momentum))
        };
        let all = result(&pane(thickness, 8.0 / duration));
        let mut cut = pane(thickness, 20e3);
        let listed = cut.iter().map(|(pole, shape)| (pole.im, *shape)).collect::<Vec<_>>();
        let tail = modal_tail(listed, 20e3, duration);
        cut.extend(tail.poles.iter().map(|pole| (*pole, tail.shape)));
        let found = result(&cut);
        println!("{thickness}: all {all:.3?}, with a tail {found:.3?}, {} in the tail", tail.poles.len());
        assert!((all.0 - known).abs() < 2e-3, "{thickness}: {all:?}");
        assert!((found.0 - known).abs() < 0.02, "{thickness}: {found:?}");
        assert!((found.1 - all.1).abs() < 0.01, "{thickness}: {found:?} {all:?}");
    }
}
