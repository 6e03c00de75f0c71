//! Impacts of bodies with baked modes against an independent integrator of all coordinates.

use std::f64::consts::TAU;

use crate::baked_bodies::{BakedBody, Place, stand, steel, stiffness};
use crate::comparison::{solve, worst_level};
use crate::compliant_bodies::{ball, contact, hertz};
use crate::integrator::impact;
use clangor_core::contact::compliant::{Member, MemberContact, hertz_duration};
use clangor_core::material::presets::{CERAMIC, GLASS};
use glam::{DMat3, DQuat, DVec3};

/// The outermost place of a body whose surface faces up there.
fn upper_rim(body: &BakedBody) -> Place {
    body.top(|place| if place.normal.y > 0.9 { place.point.with_y(0.0).length() } else { 0.0 })
}

/// The outside of a wine glass just below its lip, and the direction outward.
fn lip(glass: &BakedBody) -> (Place, DVec3) {
    let top = glass.top(|place| place.point.y).point.y;
    let radius = |place: &Place| place.point.with_y(0.0).length();
    let place = glass.top(|place| if place.point.y > top - 0.004 { radius(place) } else { 0.0 });
    (place, place.point.with_y(0.0).normalize())
}

/// A steel ball that hits a body at a place, along a unit vector that points out of the body.
fn ball_on(
    body: &BakedBody,
    place: Place,
    out: DVec3,
    radius: f64,
    speed: f64,
) -> ([Member; 2], MemberContact) {
    let striker = ball(radius, place.point + radius * out, -speed * out);
    let law = hertz(stiffness(radius, [&steel(), &body.material]));
    let mut hit = contact([Some(0), Some(1)], place.point, out, law);
    hit.shapes[1] = body.shapes(place);
    ([striker, body.member.clone()], hit)
}

#[test]
fn balls_on_rims_ring_as_all_coordinates_have_it() {
    let plate = BakedBody::new("plate", &CERAMIC, 20e3);
    let glass = BakedBody::new("wineglass", &GLASS, 20e3);
    let rim = (upper_rim(&plate), DVec3::Y);
    for (name, body, (place, out), radius, speed) in
        [("plate", &plate, rim, 0.005, 1.0), ("wine glass", &glass, lip(&glass), 0.003, 0.5)]
    {
        let (members, hit) = ball_on(body, place, out, radius, speed);
        let inverse = members[0].inverse_mass + body.inverse_mass(place, out);
        let time = 8.0 * hertz_duration(inverse, stiffness(radius, [&steel(), &body.material]), speed);
        let hits = [hit];
        let exact = impact(&members, &hits, time, 1e-9);
        for (per_duration, bar) in [(16.0, 1.0), (64.0, 0.02)] {
            let solution = solve(&members, &hits, per_duration, time);
            let level = worst_level(&members[1], solution.modal_state(1), &exact.energies[1]);
            let whole = exact.impulses[0] * inverse / speed;
            let impulse = solution.impulse(0).dot(out) * inverse / speed - whole;
            println!(
                "{name}, {} modes, {per_duration}: {level:.4} dB, e {impulse:.1e} of {:.4}, {} hits",
                body.member.poles.len(),
                whole - 1.0,
                solution.hits[0]
            );
            // Residuals seen at 64: 0.002 dB, 7e-5.
            assert!(level < bar, "{name} at {per_duration}: {level} dB");
            assert!(per_duration < 32.0 || impulse.abs() < 1e-3, "{name}: {impulse}");
        }
    }
}

#[test]
fn rims_hit_rims_again_and_again() {
    let plate = || BakedBody::new("plate", &CERAMIC, 12e3);
    let (upper, lower) = (plate().turned_below(DMat3::IDENTITY, 12e3), plate());
    let glass = BakedBody::new("wineglass", &GLASS, 12e3);
    // The glass is turned so that it meets the plate with its lip, from above.
    let (_, out) = lip(&glass);
    let turn = DQuat::from_rotation_arc(out, -DVec3::Y);
    let lip = lip(&glass).0;
    let glass = glass.turned_below(DMat3::from_quat(turn), 12e3);
    let lip = glass.places[lip.index];
    let place = upper_rim(&lower);
    for (name, body, own) in [("plate", &upper, upper_rim(&upper)), ("wine glass", &glass, lip)] {
        let law = hertz(stiffness(0.0015, [&lower.material, &body.material]));
        let mut hit = contact([Some(0), Some(1)], place.point, DVec3::Y, law);
        hit.shapes = [body.shapes(own), lower.shapes(place)];
        let mut members = [body.member.clone(), lower.member.clone()];
        members[0].centre = place.point - own.point;
        members[0].velocity = -DVec3::Y;
        let inverse = body.inverse_mass(own, DVec3::Y) + lower.inverse_mass(place, DVec3::Y);
        let time = 12.0 * hertz_duration(inverse, law.stiffness, 1.0);
        let hits = [hit];
        let exact = impact(&members, &hits, time, 1e-9);
        for (per_duration, bar) in [(16.0, 4.0), (32.0, 0.6), (64.0, 0.2)] {
            let solution = solve(&members, &hits, per_duration, time);
            let restitution = (solution.impulse(0).y - exact.impulses[0]) * inverse;
            let levels =
                [0, 1].map(|i| worst_level(&members[i], solution.modal_state(i), &exact.energies[i]));
            println!(
                "{name} on plate, {} and {} modes, {} hits, {per_duration}: e {restitution:.1e} of {:.4}, \
                {levels:.3?} dB",
                members[0].poles.len(),
                members[1].poles.len(),
                solution.hits[0],
                exact.impulses[0] * inverse - 1.0
            );
            // Residuals seen at 32: 0.07 dB, 1.1e-4.
            assert!(levels[0].max(levels[1]) < bar, "{name} at {per_duration}: {levels:?}");
            assert!(per_duration < 32.0 || restitution.abs() < 1e-3, "{name}: {restitution}");
        }
    }
}

/// Places around the lowest part of a body, on its outermost ring there.
fn feet(body: &BakedBody, count: usize) -> Vec<Place> {
    let lowest = body.top(|place| -place.point.y).point.y;
    let radius = |place: &Place| place.point.with_y(0.0).length();
    let foot = |k: usize| {
        let (sine, cosine) = (TAU * (k as f64 + 0.2) / count as f64).sin_cos();
        body.top(|place| {
            let low = place.point.y < lowest + 2e-4 && radius(place) > 1e-3;
            if low { place.point.dot(DVec3::new(cosine, 0.0, sine)) } else { -1.0 }
        })
    };
    (0..count).map(foot).collect()
}

#[test]
fn bodies_that_stand_are_struck() {
    let plate = BakedBody::new("plate", &CERAMIC, 20e3);
    let glass = BakedBody::new("wineglass", &GLASS, 20e3);
    let middle = plate.top(|place| {
        if place.normal.y > 0.99 { -(place.point.with_y(0.0).length() - 0.06).abs() } else { -1.0 }
    });
    for (name, body, (place, out), [radius, speed], count, time) in [
        ("plate", &plate, (middle, DVec3::Y), [0.008, 1.0], 3, 1.5e-3),
        ("wine glass", &glass, lip(&glass), [0.003, 0.5], 4, 1.5e-3),
    ] {
        let (mut members, hit) = ball_on(body, place, out, radius, speed);
        members[0].velocity += 0.1 * DVec3::X;
        for member in &mut members {
            member.acceleration = -9.81 * DVec3::Y;
        }
        let mut contacts = vec![hit];
        let law = hertz(stiffness(0.002, [&body.material, &GLASS.material()]));
        for foot in feet(body, count) {
            let mut contact = contact([Some(1), None], foot.point, DVec3::Y, law);
            contact.shapes[0] = body.shapes(foot);
            contacts.push(contact);
        }
        let load = 9.81 / (count as f64 * body.member.inverse_mass);
        let mut standing: Vec<&mut MemberContact> = contacts[1..].iter_mut().collect();
        stand(&mut members[1], 0, &mut standing, load);
        let exact = impact(&members, &contacts, time, 1e-9);
        let momentum = speed / members[0].inverse_mass;
        let solution = solve(&members, &contacts, 64.0, time);
        let level = worst_level(&members[1], solution.modal_state(1), &exact.energies[1]);
        println!("{name}: {level:.4} dB, e of {:.4}", exact.impulses[0] / momentum - 1.0);
        for (index, exact) in exact.impulses.iter().enumerate() {
            let impulse = (solution.impulse(index).dot(contacts[index].normal) - exact) / momentum;
            println!(
                "  contact {index}: {impulse:.1e} of {:.4}, {} hits",
                exact / momentum,
                solution.hits[index]
            );
            // Residual seen: 6.8e-4, of the glass's lip.
            assert!(impulse.abs() < 1e-3, "{name}, contact {index}: {impulse}");
        }
        // Residuals seen: 0.016 dB; 8.3e-4 of the momentum of the ball.
        assert!(level < 0.1, "{name}: {level}");
        for ((velocity, exact), member) in solution.velocities.iter().zip(&exact.velocities).zip(&members) {
            let error = (*velocity - *exact).length() / (member.inverse_mass * momentum);
            println!("  momentum {error:.1e}");
            assert!(error < 1e-3, "{name}: {velocity} {exact}");
        }
    }
}
