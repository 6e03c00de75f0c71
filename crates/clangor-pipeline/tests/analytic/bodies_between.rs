//! Recorded bodies that a thin one keeps apart: a box on a tray that falls on a floor hits the tray alone.

use std::sync::Arc;

use clangor_core::body::{Body, BodyId, MeshSurface, Surface, World};
use clangor_core::material::presets;
use clangor_core::pose::Pose;
use clangor_core::shape::Shape;
use clangor_core::timeline::ContactKind;
use clangor_pipeline::motion::impacts::find_impacts;
use clangor_pipeline::motion::recording::{Frame, RecordedBody};
use glam::DVec3;

const G: f64 = 9.81;

fn block(sides: &str) -> Body {
    let mesh = Shape::parse(&format!("box:{sides}")).unwrap().mesh();
    let (surface, mass) = MeshSurface::try_new(mesh, Vec::new()).unwrap();
    Body::solid(sides, presets::WOOD.material(), Arc::new(Surface::Mesh(surface)), &mass)
}

/// Both fall from rest and stay where they land, or leave the floor with a part of their speed.
#[test]
fn analytic_a_box_on_a_tray_hits_the_tray_alone() {
    let bodies = [
        block("0.3x0.006x0.2"),
        block("0.06x0.08x0.06"),
        Body::plane("floor", presets::GRANITE.material(), DVec3::ZERO, DVec3::Y),
    ];
    let world = World { bodies: bodies.to_vec(), links: Vec::new(), gravity: DVec3::NEG_Y * G };
    let (speed, [tray, cup]) = (2.5, [bodies[0].mass, bodies[1].mass]);
    for (rate, part) in
        [24.0, 30.0, 60.0, 120.0].into_iter().flat_map(|rate| [0.1, 0.4, 0.7, 0.95].map(|part| (rate, part)))
    {
        for restitution in [0.0, 0.3] {
            let instant = ((0.4_f64 * rate).floor() + part) / rate;
            let height = |t: f64| {
                let since = t - instant;
                if since < 0.0 {
                    -speed * since - 0.5 * G * since * since
                } else {
                    (restitution * speed * since - 0.5 * G * since * since).max(0.0)
                }
            };
            let recorded = |body: u32, rest: f64| {
                let pose = |t: f64| Pose::at(DVec3::new(0.02 * f64::from(body), rest + height(t), 0.0));
                let frame = |k: u64| Frame { time: k as f64 / rate, pose: pose(k as f64 / rate), row: k };
                RecordedBody {
                    body: BodyId(body),
                    frames: (0..=(0.9 * rate) as u64).map(frame).collect(),
                    group: None,
                }
            };
            let found = find_impacts(&world, &[recorded(0, 0.003), recorded(1, 0.046)], 0.05);
            let near = |time: f64| (time - instant).abs() < 1.5 / rate;
            let given = |pair: [u32; 2]| -> f64 {
                let is_pair = |a: u32, b: u32| [a.min(b), a.max(b)] == pair;
                let rows = found.contacts.iter().filter(|row| {
                    row.kind == ContactKind::Impact && near(row.time) && is_pair(row.body_a.0, row.body_b.0)
                });
                rows.map(|row| row.impulse_n).sum()
            };
            let jump = (1.0 + restitution) * speed;
            let off = [given([0, 1]) / (cup * jump) - 1.0, given([0, 2]) / ((tray + cup) * jump) - 1.0];
            let case = format!("{rate} Hz, {part} of a frame, {restitution}: {:.1e} {:.1e}", off[0], off[1]);
            assert_eq!(given([1, 2]), 0.0, "{case}");
            // Seen: 4.2e-2 where both stay at 24 Hz after 0.95 of a frame, and 5.6e-11 elsewhere.
            let most = if rate < 25.0 && restitution == 0.0 { 0.05 } else { 1e-6 };
            assert!(off.into_iter().all(|off| off.abs() < most), "{case}");
        }
    }
}
