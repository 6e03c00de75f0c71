//! Impacts between bodies that give way against an independent integrator of all coordinates, and short
//! steps against long ones.

use std::f64::consts::TAU;

use crate::comparison::{level_errors, mode_energies, solve, worst_level};
use crate::compliant_bodies::{Disc, ball, contact, hertz, stiffness};
use crate::integrator::{Integrated, impact};
use clangor_core::contact::compliant::{
    ContactLaw, ContactSystem, HertzLaw, Member, MemberContact, hertz_duration, restitution_damping,
};
use clangor_core::glam::DVec3;
use clangor_core::math::random::SplitMix;

/// A ball of 5 mm radius at 1 m/s on the rim of a disc.
fn rim(seed: u64, size: [f64; 2]) -> (Vec<Member>, Vec<MemberContact>) {
    let mut random = SplitMix::new(seed);
    let disc = Disc::new(&mut random, size, 20e3, 0.004);
    let point = disc.point(0.96, 0.3);
    let mut hit = contact([Some(0), Some(1)], point, DVec3::Y, hertz(stiffness(0.005)));
    hit.shapes[1] = disc.shapes(point);
    (vec![ball(0.005, point + 0.005 * DVec3::Y, -DVec3::Y), disc.member], vec![hit])
}

#[test]
fn a_ball_on_rims_rings_as_all_coordinates_have_it() {
    for (name, size) in [("plate", [0.125, 0.0045]), ("thin glass", [0.04, 0.0012])] {
        let (members, contacts) = rim(8, size);
        let inverse = members[0].inverse_mass + members[1].inverse_mass;
        let time = 8.0 * hertz_duration(inverse, stiffness(0.005), 1.0);
        let Integrated { energies, impulses, .. } = impact(&members, &contacts, time, 1e-9);
        let momentum = 1.0 / members[0].inverse_mass;
        for (per_duration, bar) in [(16.0, 1.0), (64.0, 0.02)] {
            let solution = solve(&members, &contacts, per_duration, time);
            let level = worst_level(&members[1], solution.modal_state(1), &energies[1]);
            let impulse = (solution.impulse(0).y - impulses[0]) / momentum;
            println!(
                "{name}, {} modes, {per_duration}: {level:.4} dB, impulse {impulse:.1e} of {:.3}",
                members[1].poles.len(),
                impulses[0] / momentum
            );
            // Residuals seen at 64: 0.003 dB, 8e-5.
            assert!(level < bar, "{name} at {per_duration}: {level} dB");
            assert!(impulse.abs() < if per_duration > 32.0 { 1e-3 } else { 1e-2 }, "{name}: {impulse}");
        }
    }
}

#[test]
fn two_flexible_bodies_hit_each_other_again_and_again() {
    let mut random = SplitMix::new(21);
    for (name, sizes) in
        [("plates", [[0.125, 0.0045], [0.11, 0.004]]), ("glass on plate", [[0.05, 0.002], [0.125, 0.0045]])]
    {
        let discs = sizes.map(|size| Disc::new(&mut random, size, 12e3, 0.004));
        let points = [discs[0].point(0.96, 0.3), discs[1].point(0.96, 2.0)];
        let law = hertz(stiffness(0.0015));
        let mut hit = contact([Some(0), Some(1)], points[1], DVec3::Y, law);
        hit.shapes = [discs[0].shapes(points[0]), discs[1].shapes(points[1])];
        let mut members = discs.map(|disc| disc.member).to_vec();
        members[0].centre = points[1] - points[0];
        members[0].velocity = -DVec3::Y;
        let system = ContactSystem::new(&members, std::slice::from_ref(&hit)).unwrap();
        // W from the two masses and levers.
        let lever = |i: usize| points[i].cross(DVec3::Y);
        let inverse: f64 = (0..2)
            .map(|i| members[i].inverse_mass + lever(i).dot(members[i].inverse_inertia * lever(i)))
            .sum();
        let time = 12.0 * hertz_duration(inverse, law.stiffness, 1.0);
        let hits = [hit];
        let exact = impact(&members, &hits, time, 1e-9);
        for (per_duration, bar) in [(16.0, 4.0), (32.0, 0.6), (64.0, 0.2)] {
            let solution = solve(&members, &hits, per_duration, time);
            let restitution = (solution.impulse(0).y - exact.impulses[0]) * inverse;
            let levels =
                [0, 1].map(|i| worst_level(&members[i], solution.modal_state(i), &exact.energies[i]));
            println!(
                "{name}, {} and {} modes, {} hits, {per_duration}: e {restitution:.1e} of {:.4}, \
                {levels:.3?} dB",
                members[0].poles.len(),
                members[1].poles.len(),
                solution.hits[0],
                exact.impulses[0] * inverse - 1.0
            );
            // Residuals seen at 32: 0.12 dB, 2e-4.
            assert!(levels[0].max(levels[1]) < bar, "{name} at {per_duration}: {levels:?}");
            assert!(per_duration < 32.0 || restitution.abs() < 1e-3, "{name}: {restitution}");
        }
        assert!(system.first_duration().unwrap() < time / 12.0);
    }
}

#[test]
fn a_plate_between_a_ball_and_three_feet() {
    let mut random = SplitMix::new(31);
    let disc = Disc::new(&mut random, [0.125, 0.0045], 12e3, 0.004);
    let point = disc.point(0.7, 0.9);
    let radius = 0.008;
    let mut hit = contact([Some(0), Some(1)], point, DVec3::Y, hertz(stiffness(radius)));
    hit.shapes[1] = disc.shapes(point);
    let weight = 9.81 / disc.member.inverse_mass;
    let mut contacts = vec![hit];
    for foot in 0..3 {
        let place = disc.point(0.6, TAU / 3.0 * f64::from(foot));
        let mut stand = contact([Some(1), None], place, DVec3::Y, hertz(stiffness(0.002)));
        stand.shapes[0] = disc.shapes(place);
        stand.gap = -(weight / 3.0 / stiffness(0.002)).powf(2.0 / 3.0);
        stand.standing = true;
        contacts.push(stand);
    }
    let mut members = vec![ball(radius, point + radius * DVec3::Y, DVec3::new(0.1, -1.0, 0.0)), disc.member];
    for member in &mut members {
        member.acceleration = -9.81 * DVec3::Y;
    }
    let time = 1.5e-3;
    let exact = impact(&members, &contacts, time, 1e-9);
    let momentum = 1.0 / members[0].inverse_mass;
    let solution = solve(&members, &contacts, 64.0, time);
    let level = worst_level(&members[1], solution.modal_state(1), &exact.energies[1]);
    for (index, exact) in exact.impulses.iter().enumerate() {
        let impulse = (solution.impulse(index).y - exact) / momentum;
        println!("contact {index}: {impulse:.1e} of {:.4}, {} hits", exact / momentum, solution.hits[index]);
        // Residual seen: 5e-5.
        assert!(impulse.abs() < 1e-3, "contact {index}: {impulse}");
    }
    println!("{level:.4} dB");
    // Residual seen: 0.005 dB.
    assert!(level < 0.1, "{level}");
    for (velocity, exact) in solution.velocities.iter().zip(&exact.velocities) {
        assert!((*velocity - *exact).length() < 1e-3, "{velocity} {exact}");
    }
}

#[test]
fn a_ball_on_a_cushion_under_gravity() {
    let radius = 0.01;
    let mut striker = ball(radius, radius * DVec3::Y, -0.1 * DVec3::Y);
    striker.acceleration = -9.81 * DVec3::Y;
    let momentum = 0.1 / striker.inverse_mass;
    let soft = HertzLaw { viscosity: 5e-4, ..hertz(2e6) };
    let laws = [ContactLaw::Hertz(soft), ContactLaw::Spring { stiffness: 4e4, damping: 1.0 }];
    for law in laws {
        let mut hit = contact([Some(0), None], DVec3::ZERO, DVec3::Y, hertz(1.0));
        hit.law = law;
        let (members, hits) = ([striker.clone()], [hit]);
        let time = 6e-3;
        let exact = impact(&members, &hits, time, 1e-10);
        let solution = solve(&members, &hits, 64.0, time);
        let impulse = (solution.impulse(0).y - exact.impulses[0]) / momentum;
        println!("impulse {impulse:.1e} of {:.4}", exact.impulses[0] / momentum);
        // Residual seen: 4e-4.
        assert!(impulse.abs() < 1e-3, "{impulse}");
    }
}

#[test]
fn eight_steps_are_enough_for_levels() {
    let mut random = SplitMix::new(3);
    let mut errors = [8.0, 16.0].map(|per_duration| (per_duration, Vec::new()));
    for size in [[0.125, 0.0045], [0.04, 0.0012], [0.08, 0.003], [0.0375, 0.001], [0.06, 0.0012]] {
        let disc = Disc::new(&mut random, size, 16e3, 0.004);
        for _ in 0..16 {
            let point = disc.point(random.uniform(0.0, 1.0).sqrt(), random.uniform(0.0, TAU));
            let radius = 10f64.powf(random.uniform(-2.7, -1.8));
            let speed = 10f64.powf(random.uniform(-1.0, 0.5));
            let striker = ball(radius, point + radius * DVec3::Y, -speed * DVec3::Y);
            let mut law = hertz(stiffness(radius));
            law.restitution_damping = restitution_damping(0.95);
            let mut hit = contact([Some(0), Some(1)], point, DVec3::Y, law);
            hit.shapes[1] = disc.shapes(point);
            let lever = point.cross(DVec3::Y);
            let inverse = striker.inverse_mass
                + disc.member.inverse_mass
                + lever.dot(disc.member.inverse_inertia * lever);
            let time = (8.0 * hertz_duration(inverse, law.stiffness, speed)).min(3e-3);
            let (members, hits) = ([striker, disc.member.clone()], [hit]);
            let exact = mode_energies(solve(&members, &hits, 128.0, time).modal_state(1));
            for (per_duration, errors) in &mut errors {
                let solution = solve(&members, &hits, *per_duration, time);
                let levels = level_errors(&members[1].poles, solution.modal_state(1), &exact);
                let mean = levels.iter().map(|x| x * x).sum::<f64>() / levels.len() as f64;
                errors.push(mean.sqrt());
            }
        }
    }
    for (per_duration, errors) in &mut errors {
        errors.sort_by(f64::total_cmp);
        let [median, most] = [0.5, 0.9].map(|share| errors[(share * errors.len() as f64) as usize]);
        println!("{per_duration} steps: median {median:.3} dB, 90 % {most:.3} dB, worst {:.2}", errors[79]);
        // Seen at 8 steps: 0.114 and 0.51 dB; at 16: 0.023 and 0.08 dB.
        assert!(median < 0.15 && most < 0.8, "{per_duration} steps: {median} {most}");
    }
}
