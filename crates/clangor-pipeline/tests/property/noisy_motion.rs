//! Recorded motion with noise, with rounded positions and with repeated poses.

use std::fmt::Write as _;

use clangor_pipeline::formats::timeline_file::TimelineReader;
use clangor_pipeline::interchange::motion_import::MotionSummary;
use tempfile::TempDir;

use crate::imported_motion::{folder, import, scene};

/// Evenly spread numbers in −1 … 1 (Lehmer's generator).
fn noise(state: &mut u64) -> f64 {
    *state = *state * 48271 % 0x7fff_ffff;
    2.0 * (*state as f64 / f64::from(0x7fff_ffff)) - 1.0
}

/// The import of heights of the ball at a rate, with a jitter of all coordinates \[m\].
fn imported(
    rate: f64,
    height: impl Fn(f64) -> f64,
    mut jitter: impl FnMut() -> f64,
) -> (TempDir, MotionSummary) {
    let mut text = String::from("t,body,position_x,position_y,position_z\n");
    for t in (0..=(2.0 * rate).round() as u32).map(|k| f64::from(k) / rate) {
        let [x, y, z] = [0.0, height(t), 0.0].map(|x| x + jitter());
        writeln!(text, "{t},ball,{x},{y},{z}").unwrap();
    }
    let folder = folder(scene!(), &[("poses.csv", &text)]);
    let summary = import(folder.path(), &["poses.csv"], &[], false).unwrap();
    (folder, summary)
}

/// Sum of the impulses of all impacts over the mass of the ball [m/s].
fn impulse(folder: &TempDir) -> f64 {
    let reader = TimelineReader::open(&folder.path().join("out.timeline")).unwrap();
    let mass = reader.header().world.bodies[0].mass;
    let rows = reader.read_all().unwrap().contacts;
    rows.iter().filter(|row| row.impact_id != 0).map(|row| row.impulse_n).sum::<f64>() / mass
}

#[test]
fn property_what_is_set_down_in_noise_has_the_impulse_of_its_speed() {
    for (rate, deviation, speed) in [(60.0, 1e-4, 0.25), (120.0, 1e-4, 0.5), (240.0, 2e-5, 0.25)] {
        for seed in 1..6 {
            let mut state = seed * 7919;
            let height = |t: f64| 0.01 + speed * (1.0123 - t).max(0.0);
            let (folder, _) = imported(rate, height, || noise(&mut state) * deviation * 3.0_f64.sqrt());
            let off = impulse(&folder) / speed - 1.0;
            println!("{rate} Hz, {deviation} m, {speed} m/s: {off:+.3}");
            // Seen: 0.105.
            assert!(off.abs() < 0.2, "{rate} Hz, {deviation} m: {off}");
        }
    }
}

#[test]
fn property_rounded_positions_are_noisy_and_repeated_poses_are_told() {
    let bounces = |t: f64| 0.01 + (t % 0.5) * (0.5 - t % 0.5) * 4.9;
    let (folder, summary) = imported(240.0, bounces, || 0.0);
    let exact = impulse(&folder);
    assert!(summary.notices.iter().all(|notice| !notice.contains("repeat") && !notice.contains("noise")));
    // Bounces at 2.45 m/s stand out from the rounding, which the file does not say.
    let (folder, summary) = imported(240.0, |t| (bounces(t) * 1e3).round() / 1e3, || 0.0);
    let noisy = summary.notices.iter().chain(&summary.warnings).any(|notice| notice.contains("noise of"));
    assert!(noisy, "{:?} {:?}", summary.notices, summary.warnings);
    let off = impulse(&folder) / exact - 1.0;
    println!("rounded to a millimetre: {off:+.3}");
    // Seen: 4e-3.
    assert!(off.abs() < 0.15, "{off}");
    // Drawn on twos.
    let (_, summary) = imported(48.0, |t| bounces((t * 24.0 + 1e-9).floor() / 24.0), || 0.0);
    let is_named = summary.notices.iter().chain(&summary.warnings).any(|notice| notice.contains("repeat"));
    assert!(is_named, "{:?} {:?}", summary.notices, summary.warnings);
}
