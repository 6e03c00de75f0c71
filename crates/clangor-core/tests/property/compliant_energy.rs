//! Energy of impacts between bodies that give way, whatever the step.

use std::f64::consts::TAU;

use crate::compliant_bodies::{Disc, ball, contact, displacement, hertz, stiffness, vibration};
use clangor_core::contact::compliant::{
    ContactEnd, ContactLaw, ContactSolution, ContactSystem, Member, MemberContact, SolverMemory,
    StepSettings, modal_tail, restitution_damping,
};
use clangor_core::glam::DVec3;
use clangor_core::math::random::SplitMix;
use num_complex::Complex64;

fn log_uniform(random: &mut SplitMix, low: f64, high: f64) -> f64 {
    random.uniform(f64::ln(low), f64::ln(high)).exp()
}

/// A ball on a disc, by chance beside its middle and oblique; the disc rings in every second impact.
fn impact(random: &mut SplitMix, damped: bool, oblique: bool) -> (Vec<Member>, Vec<MemberContact>) {
    let size = [random.uniform(0.04, 0.13), log_uniform(random, 6e-4, 6e-3)];
    let loss_factor = if damped { log_uniform(random, 1e-3, 0.05) } else { 0.0 };
    let disc = Disc::new(random, size, 16e3, loss_factor);
    let radius = log_uniform(random, 1e-3, 2e-2);
    let speed = log_uniform(random, 1e-2, 10.0);
    let point = disc.point(random.uniform(0.0, 1.0), random.uniform(0.0, TAU));
    let mut velocity = -DVec3::Y;
    if oblique {
        let angle = random.uniform(0.0, TAU);
        velocity += random.uniform(0.0, 3.0) * DVec3::new(angle.cos(), 0.0, angle.sin());
    }
    let mut striker = ball(radius, point + radius * DVec3::Y, speed * velocity);
    if oblique {
        striker.angular_velocity = random.uniform(0.0, 2.0) * speed / radius * random.direction();
    }
    let energy = 0.5 * speed * speed / striker.inverse_mass;
    let target = if random.uniform(0.0, 1.0) < 0.5 {
        let share = random.uniform(0.0, 2.0);
        disc.ringing(random, energy * share)
    } else {
        disc.member.clone()
    };
    let mut law = hertz(stiffness(radius));
    law.restitution_damping = restitution_damping(random.uniform(0.6, 1.0));
    let mut hit = contact([Some(0), Some(1)], point, DVec3::Y, law);
    hit.shapes[1] = disc.shapes(point);
    // The ball touches the surface as it is.
    hit.gap = if target.state.is_empty() { 0.0 } else { displacement(&target, &hit.shapes[1], DVec3::Y) };
    (vec![striker, target], vec![hit])
}

fn energy(members: &[Member]) -> f64 {
    let motion = |m: &Member| {
        let spin = m.inverse_inertia.inverse() * m.angular_velocity;
        0.5 * (m.velocity.length_squared() / m.inverse_mass + m.angular_velocity.dot(spin))
    };
    members.iter().map(|m| motion(m) + vibration(&m.poles, &m.state)).sum()
}

fn settings(steps_per_duration: f64) -> StepSettings {
    StepSettings { steps_per_duration, max_steps: 4000, ..StepSettings::default() }
}

#[test]
fn modes_never_gain_more_than_motion_lost_without_damping() {
    let mut random = SplitMix::new(3);
    let mut memory = SolverMemory::default();
    let (mut parted, mut worst) = (0, 0.0_f64);
    for _ in 0..400 {
        let (members, contacts) = impact(&mut random, false, false);
        let before = energy(&members);
        let system = ContactSystem::new(&members, &contacts).unwrap();
        let solution = system.solve(&settings(random.uniform(0.0, 6.0).exp2()), &mut memory).unwrap();
        let e = solution.energies;
        worst = worst.max(e.residual().abs() / before);
        parted += usize::from(solution.end == ContactEnd::Parted);
        assert!(e.contact_loss >= 0.0 && e.friction_loss == 0.0 && e.plate_loss == 0.0);
        let excess = e.modes_gained + e.stored_gained - e.motion_lost;
        assert!(excess <= 1e-12 * before, "{excess} of {before} J");
        // The energies are those of the state.
        let mut after = members.clone();
        solution.carry_over(&mut after, &mut contacts.clone());
        let change = energy(&after) - before + e.stored_gained + e.contact_loss;
        assert!(change.abs() < 1e-11 * before, "{change} of {before} J");
    }
    println!("balance {worst:.1e}, parted {parted}");
    // Residual seen: 7.8e-14.
    assert!(worst < 1e-12, "{worst}");
    assert!(parted > 300, "{parted}");
}

/// Adds a tail at the contact.
fn add_tail(members: &mut [Member], contact: &mut MemberContact, duration: f64) {
    let modes = members[1].poles.iter().zip(&contact.shapes[1]);
    let modes: Vec<_> = modes.map(|(pole, shape)| (pole.norm(), shape.dot(DVec3::Y))).collect();
    let tail = modal_tail(modes, 16e3, duration);
    assert!(!tail.poles.is_empty());
    let member = &mut members[1];
    contact.shapes[1].extend(tail.poles.iter().map(|_| tail.shape * DVec3::Y));
    member.poles.extend_from_slice(&tail.poles);
    if !member.state.is_empty() {
        member.state.resize(member.poles.len(), Complex64::ZERO);
    }
}

/// Losses in the order contact, plate, friction, modes.
fn losses(solution: &ContactSolution) -> [f64; 4] {
    let e = solution.energies;
    [e.contact_loss, e.plate_loss, e.friction_loss, e.modal_loss]
}

#[test]
fn every_loss_is_a_loss_with_damping_tail_and_friction() {
    let mut random = SplitMix::new(11);
    let mut memory = SolverMemory::default();
    let (mut worst, mut growth, mut stalled, mut shares) = (0.0_f64, 0.0_f64, 0, [0.0_f64; 4]);
    for _ in 0..300 {
        let (mut members, mut contacts) = impact(&mut random, true, true);
        contacts[0].friction = random.uniform(0.0, 1.0);
        let system = ContactSystem::new(&members, &contacts).unwrap();
        add_tail(&mut members, &mut contacts[0], system.first_duration().unwrap());
        if let ContactLaw::Hertz(law) = &mut contacts[0].law {
            law.plate_mobility = random.uniform(0.0, 1e-4);
            law.viscosity = random.uniform(0.0, 1e-7);
        }
        let before = energy(&members);
        let system = ContactSystem::new(&members, &contacts).unwrap();
        let per_duration = random.uniform(0.0, 6.0).exp2();
        let (mut last, mut lost) = (before, [0.0; 4]);
        for max_steps in [1, 2, 3, 5, 8, 13, 21, 34, 55, 89, 144, 4000] {
            let settings = StepSettings { max_steps, modal_loss: true, ..settings(per_duration) };
            let solution = system.solve(&settings, &mut memory).unwrap();
            let e = solution.energies;
            worst = worst.max(e.residual().abs() / before);
            stalled += solution.stalled_steps;
            let now = before - e.motion_lost + e.modes_gained + e.stored_gained;
            growth = growth.max((now - last) / before);
            last = now;
            let total = losses(solution);
            for (total, lost) in total.iter().zip(lost) {
                assert!(*total >= lost - 1e-13 * before, "{total} after {lost} J of {before} J");
            }
            lost = total;
        }
        for (share, lost) in shares.iter_mut().zip(lost) {
            *share = share.max(lost / before);
        }
    }
    println!("balance {worst:.1e}, growth {growth:.1e}, {stalled} stalled steps, {shares:?}");
    // Residual seen: 8.5e-14, no growth.
    assert!(worst < 1e-10, "{worst}");
    assert!(growth < 1e-9, "{growth}");
    assert!(shares.iter().all(|share| *share > 0.01), "{shares:?}");
}
