//! A timeline's rows come in order of time, also where contacts among several balls last longer than the time
//! between two poses.

use crate::sphere_worlds::{G, material, plane, run, settings, sphere, world};
use clangor_core::body::BodyId;
use clangor_core::material::Material;
use clangor_sim::{ContactModel, SimulationSettings};
use glam::DVec3;

const RADIUS: f64 = 0.028575;

/// How far a time lies before an earlier one of its list, at most \[s\].
fn latest_by(times: impl Iterator<Item = f64>) -> f64 {
    let mut latest = f64::NEG_INFINITY;
    times.fold(0.0, |late, time| {
        latest = latest.max(time);
        late.max(latest - time)
    })
}

#[test]
fn contacts_longer_than_a_pose_interval_keep_the_order() {
    // A cushion so soft that a ball stays on it for milliseconds, and pairs of balls that meet there.
    let phenolic = Material { youngs_modulus: 5.8e9, ..material(0.95, 0.06, 2e-4) };
    let cushion = Material { youngs_modulus: 4e6, poisson_ratio: 0.49, ..material(0.7, 0.3, 0.0) };
    let mut bodies = Vec::new();
    for k in 0..4_u32 {
        let at = DVec3::new(-0.1 - 0.01 * f64::from(k), RADIUS, 0.2 * f64::from(k));
        bodies.push(sphere(RADIUS, at, DVec3::X * 2.0, &phenolic));
        let behind = at - DVec3::X * (2.0 * RADIUS + 1e-4);
        bodies.push(sphere(RADIUS, behind, DVec3::X * 2.2, &phenolic));
    }
    bodies.push(plane(DVec3::ZERO, DVec3::Y, &phenolic));
    bodies.push(plane(DVec3::ZERO, DVec3::NEG_X, &cushion));
    let rail = BodyId(bodies.len() as u32 - 1);
    let world = world(bodies, vec![], G);
    for raw in [false, true] {
        let settings = SimulationSettings {
            contact: ContactModel::Compliant,
            time_step: 1e-4,
            ..settings(0.2, raw, 4000.0)
        };
        let (timeline, report) = run(&world, &settings).unwrap();
        let on_rail = timeline.contacts.iter().filter(|row| row.body_b == rail).count();
        let poses = latest_by(timeline.poses.iter().map(|row| row.time));
        let contacts = latest_by(timeline.contacts.iter().map(|row| row.time));
        let impacts = report.impacts;
        println!("raw {raw}: {impacts} impacts, {on_rail} rows on the rail, late {poses} s and {contacts} s");
        assert!(on_rail >= 4, "{on_rail}");
        assert_eq!(timeline.poses.iter().filter(|row| row.time == 0.2).count(), 8);
        // As rows were written when a contact was over, poses came 14.4 ms late and contacts 13.6 ms.
        assert_eq!((poses, contacts), (0.0, 0.0), "raw {raw}");
    }
}
