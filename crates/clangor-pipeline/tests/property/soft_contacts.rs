//! Recorded motion of engines whose contacts give way: the impulse of an impact does not depend on the rate.

use std::fmt::Write as _;

use clangor_pipeline::formats::timeline_file::TimelineReader;
use tempfile::TempDir;

use crate::imported_motion::{folder, import, scene};

const G: f64 = 9.81;
const RADIUS: f64 = 0.01;
const DROP: f64 = 0.5;
/// Step of the engine \[s\].
const STEP: f64 = 1e-4;

/// Heights of a ball that falls on a contact with a time constant \[s\] and a damping ratio, as that of
/// MuJoCo: a = −2 v/τ − x/(τ ζ)², and never a pull.
fn heights(time_constant: f64, ratio: f64) -> Vec<f64> {
    let (mut height, mut speed) = (RADIUS + DROP, 0.0);
    let push = |depth: f64, speed: f64| {
        let spring = depth / (time_constant * ratio).powi(2) - 2.0 * speed / time_constant;
        if depth > 0.0 { (spring + G).max(0.0) } else { 0.0 }
    };
    let step = |_| {
        let now = height;
        speed += (push(RADIUS - height, speed) - G) * STEP;
        height += speed * STEP;
        now
    };
    (0..(1.0 / STEP) as usize).map(step).collect()
}

/// Impulses of the impacts over the mass of the ball [m/s], and whether a notice speaks of soft contacts.
fn imported(heights: &[f64], every: usize) -> (Vec<f64>, bool) {
    let mut text = String::from("t,body,position_x,position_y,position_z\n");
    for (k, height) in heights.iter().enumerate().step_by(every) {
        writeln!(text, "{},ball,0,{height},0", k as f64 * STEP).unwrap();
    }
    let folder: TempDir = folder(scene!(), &[("poses.csv", &text)]);
    let summary = import(folder.path(), &["poses.csv"], &[], false).unwrap();
    let reader = TimelineReader::open(&folder.path().join("out.timeline")).unwrap();
    let mass = reader.header().world.bodies[0].mass;
    let rows = reader.read_all().unwrap().contacts;
    let impulses = rows.iter().filter(|row| row.impact_id != 0).map(|row| row.impulse_n / mass).collect();
    (impulses, summary.notices.iter().any(|notice| notice.contains("a push over several frames")))
}

#[test]
fn property_a_soft_contact_is_one_impact_at_any_rate() {
    let arrival = (2.0 * G * DROP).sqrt();
    for (time_constant, ratio, rates) in [(0.02, 1.0, &[10, 20, 40][..]), (0.01, 0.3, &[5, 10])] {
        let heights = heights(time_constant, ratio);
        let fastest = |range: std::ops::Range<usize>| {
            heights[range].windows(2).map(|pair| (pair[1] - pair[0]) / STEP).fold(0.0, f64::max)
        };
        // What the contact gives back until the ball flies or stays.
        let given_back = fastest(3200..4000);
        for every in rates {
            let (impulses, is_named) = imported(&heights, *every);
            let off = impulses[0] / (arrival + given_back) - 1.0;
            println!("{time_constant} s, every {every}: {impulses:?}, {off:+.4}, {given_back}");
            assert!(is_named);
            // Seen: 4e-3.
            assert!(off.abs() < 0.06, "{off}");
            // It stays, or bounces at less than a third of the speed.
            assert!(impulses[1..].iter().all(|other| *other < 0.5 * impulses[0]), "{impulses:?}");
        }
    }
    // A stiff contact lasts no frame.
    let bounces = |t: f64| RADIUS + (t % 0.5) * (0.5 - t % 0.5) * 4.9;
    let stiff: Vec<f64> = (0..20_000).map(|k| bounces(f64::from(k) * STEP)).collect();
    let (impulses, is_named) = imported(&stiff, 10);
    assert!(!is_named && impulses.len() > 1, "{impulses:?}");
}
