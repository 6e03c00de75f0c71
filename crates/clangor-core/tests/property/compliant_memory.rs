//! Solving without allocation, and going on from any step.

use crate::compliant_bodies::{Disc, ball, contact, hertz, stiffness};
use clangor_core::contact::compliant::{
    ContactLaw, ContactSystem, Member, MemberContact, SolverMemory, StepSettings, restitution_damping,
};
use clangor_core::glam::DVec3;
use clangor_core::math::random::SplitMix;

/// A disc that stands on a spring and two feet under gravity, struck beside its middle by a spinning ball.
fn standing_disc(random: &mut SplitMix) -> (Vec<Member>, Vec<MemberContact>) {
    let disc = Disc::new(random, [0.1, 0.004], 15e3, 0.004);
    let point = disc.point(0.6, 0.4);
    let mut striker = ball(0.008, point + 0.008 * DVec3::Y, DVec3::new(0.4, -1.5, 0.2));
    striker.angular_velocity = DVec3::new(20.0, -10.0, 5.0);
    let mut law = hertz(stiffness(0.008));
    law.restitution_damping = restitution_damping(0.95);
    let mut hit = contact([Some(0), Some(1)], point, DVec3::Y, law);
    hit.friction = 0.3;
    hit.shapes[1] = disc.shapes(point);
    let mut contacts = vec![hit];
    for angle in [0.1, 2.2, 4.4] {
        let foot = disc.point(0.7, angle);
        let mut stand = contact([Some(1), None], foot, DVec3::Y, hertz(5e8));
        stand.friction = 0.4;
        stand.standing = true;
        stand.shapes[0] = disc.shapes(foot);
        stand.gap = -5e-7;
        if angle > 4.0 {
            stand.law = ContactLaw::Spring { stiffness: 3e5, damping: 2.0 };
            stand.friction = 0.0;
        }
        contacts.push(stand);
    }
    let mut members = vec![striker, disc.ringing(random, 1e-4)];
    for member in &mut members {
        member.acceleration = -9.81 * DVec3::Y;
    }
    (members, contacts)
}

fn settings(step: f64, max_steps: usize) -> StepSettings {
    StepSettings { step: Some(step), max_steps, end_when_parted: false, ..StepSettings::default() }
}

#[test]
fn a_solve_allocates_nothing_once_its_buffers_exist() {
    let mut random = SplitMix::new(5);
    let (members, contacts) = standing_disc(&mut random);
    let mut system = ContactSystem::new(&members, &contacts).unwrap();
    let mut memory = SolverMemory::default();
    let settings = StepSettings { max_steps: 400, modal_loss: true, ..StepSettings::default() };
    let before = system.solve(&settings, &mut memory).unwrap().clone();
    let counted = allocation_counter::measure(|| {
        system.replace(&members, &contacts).unwrap();
        system.solve(&settings, &mut memory).unwrap();
    });
    assert_eq!((counted.count_total, counted.bytes_total), (0, 0));
    assert_eq!(*system.solve(&settings, &mut memory).unwrap(), before);
}

#[test]
fn stopping_and_going_on_with_more_members_changes_nothing() {
    let mut random = SplitMix::new(6);
    let (mut members, mut contacts) = standing_disc(&mut random);
    let mut memory = SolverMemory::default();
    let step = ContactSystem::new(&members, &contacts).unwrap().first_duration().unwrap() / 16.0;
    let system = ContactSystem::new(&members, &contacts).unwrap();
    let whole = system.solve(&settings(step, 300), &mut memory).unwrap().clone();
    assert!(whole.touch_durations[0] > 5.0 * step);
    let mut forces = Vec::new();
    for (steps, joins) in [(7, false), (50, true), (243, false)] {
        let system = ContactSystem::new(&members, &contacts).unwrap();
        let part = system.solve(&settings(step, steps), &mut memory).unwrap();
        forces.extend(part.forces.chunks(contacts.len()).flat_map(|step| step[..4].to_vec()));
        part.carry_over(&mut members, &mut contacts);
        if joins {
            // A pair that touches none of the others.
            let far = 3.0 * DVec3::X;
            members.push(ball(0.01, far + 0.01 * DVec3::Y, -DVec3::Y));
            members.push(ball(0.01, far - 0.01 * DVec3::Y, DVec3::ZERO));
            let mut other = contact([Some(2), Some(3)], far, DVec3::Y, hertz(3e9));
            other.friction = 0.2;
            contacts.push(other);
        }
    }
    let largest = whole.forces.iter().map(|f| f[0]).fold(0.0, f64::max);
    let difference = |(a, b): (&[f64; 3], &[f64; 3])| (0..3).map(|i| (a[i] - b[i]).abs()).fold(0.0, f64::max);
    let worst = forces.iter().zip(&whole.forces).map(difference).fold(0.0, f64::max) / largest;
    println!("worst force {worst:.1e}");
    assert_eq!(forces.len(), whole.forces.len());
    // Residual seen: 4.7e-15.
    assert!(worst < 1e-10, "{worst}");
    for (index, member) in members.iter().take(2).enumerate() {
        let velocity = (member.velocity - whole.velocities[index]).length();
        let spin = (member.angular_velocity - whole.angular_velocities[index]).length();
        let states = member.state.iter().zip(whole.modal_state(index));
        let state = states.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        println!("velocity {velocity:.1e}, spin {spin:.1e}, state {state:.1e}");
        // Residuals seen: 4e-16 m/s, 4e-14 rad/s, 1e-16.
        assert!(velocity < 1e-11 && spin < 1e-9 && state < 1e-11, "{velocity} {spin} {state}");
    }
    // The pair that joined went through its own impact.
    assert!((members[3].velocity.y + 1.0).abs() < 1e-12, "{}", members[3].velocity);
}
