//! Rows of lasting contact in recorded motion: they balance the momentum of what slides, rolls and is hit,
//! what rests has no sound, and noise of the poses is not taken for forces.

use std::fmt::Write as _;
use std::path::Path;

use crate::boxes;
use crate::imported_motion::{folder, import};
use clangor_core::body::{Body, BodyId};
use clangor_core::contact::PoseHistory;
use clangor_core::contact::force_stream::{StreamSettings, StreamedForce, force_stream};
use clangor_core::timeline::{ContactKind, ContactRow, Timeline};
use clangor_pipeline::formats::timeline_file::TimelineReader;
use clangor_pipeline::interchange::file_frame::FileAxes;
use clangor_pipeline::interchange::motion_import::{MotionFiles, import_motion};
use glam::{DQuat, DVec3};

const G: f64 = 9.80665;
const HEAD: &str =
    "t,body,position_x,position_y,position_z,orientation_x,orientation_y,orientation_z,orientation_w\n";
const SCENE: &str = r#"version = 1
[material.board]
base = "wood"
friction = 0.3
rolling_loss = 0.0002
[[body]]
name = "block"
shape = "box:0.1x0.04x0.08"
material = "board"
position = [0.0, 0.02, 0.0]
[[body]]
name = "ball"
shape = "sphere:0.01"
material = "board"
position = [0.0, 0.01, 0.5]
[[plane]]
name = "floor"
material = "board"
[[listener]]
position = [0.3, 0.4, 0.4]
[render]
rolling = true
"#;

/// Rows of a body at a rate, with positions and turns of a time.
fn table(body: &str, rate: f64, seconds: f64, pose: impl Fn(f64) -> (DVec3, DQuat)) -> String {
    let mut text = String::new();
    for k in 0..=(seconds * rate).round() as u32 {
        let t = f64::from(k) / rate;
        let (p, q) = pose(t);
        writeln!(text, "{t},{body},{},{},{},{},{},{},{}", p.x, p.y, p.z, q.x, q.y, q.z, q.w).unwrap();
    }
    text
}

/// A run: bodies, their rows, and the length of its steps.
struct Run {
    bodies: Vec<Body>,
    timeline: Timeline,
    step: f64,
    notices: Vec<String>,
}

fn run(rows: &str) -> Run {
    let folder = folder(SCENE, &[("poses.csv", &format!("{HEAD}{rows}"))]);
    let notices = import(folder.path(), &["poses.csv"], &[], false).unwrap().notices;
    read(folder.path(), notices)
}

fn read(folder: &Path, notices: Vec<String>) -> Run {
    let reader = TimelineReader::open(&folder.join("out.timeline")).unwrap();
    let header = reader.header();
    assert_eq!(header.origin.raw_log, header.origin.time_step > 0.0);
    let step = header.origin.time_step;
    Run { bodies: header.world.bodies.clone(), timeline: reader.read_all().unwrap(), step, notices }
}

impl Run {
    fn id(&self, name: &str) -> BodyId {
        BodyId(self.bodies.iter().position(|body| body.name == name).unwrap() as u32)
    }

    fn mass(&self, name: &str) -> f64 {
        self.bodies[self.id(name).index()].mass
    }

    /// Rows that act on a body, in a stretch of time, with the sign in which they do.
    fn rows(&self, name: &str, [from, to]: [f64; 2]) -> Vec<(ContactRow, f64)> {
        let id = self.id(name);
        let sign = |row: &ContactRow| f64::from(row.body_a == id) - f64::from(row.body_b == id);
        let rows = self.timeline.contacts.iter().map(|row| (*row, sign(row)));
        rows.filter(|(row, sign)| *sign != 0.0 && row.time >= from && row.time < to).collect()
    }

    fn impulse(&self, name: &str, span: [f64; 2]) -> DVec3 {
        self.rows(name, span).iter().map(|(row, sign)| row.impulse() * *sign).sum()
    }

    /// Forces of lasting contacts that are heard.
    fn stream(&self) -> Vec<StreamedForce> {
        let poses = PoseHistory::try_new(&self.bodies, &self.timeline.poses).unwrap();
        let settings = StreamSettings { v_min: 0.05, time_step: self.step, rest_speed: 1e-3 };
        force_stream(&self.bodies, &self.timeline.contacts, &poses, &settings).unwrap()
    }

    /// What is heard of a body in a stretch of time, over its weight in a step: the largest sum of the
    /// impulses of a step, and the largest change of all of them from one step to the next.
    fn heard(&self, name: &str, [from, to]: [f64; 2]) -> [f64; 2] {
        let (id, weight) = (self.id(name), self.mass(name) * G * self.step);
        let own = self.stream().into_iter();
        let own: Vec<StreamedForce> =
            own.filter(|force| force.body == id && force.time >= from && force.time < to).collect();
        let sum = |force: &StreamedForce| force.points.iter().map(|p| p.impulse).sum::<DVec3>().length();
        let size = |force: &StreamedForce| force.points.iter().map(|p| p.impulse.length()).sum::<f64>();
        let change = |pair: &[StreamedForce]| {
            let (a, b) = (&pair[0].points, &pair[1].points);
            match a.len() == b.len() {
                true => a.iter().zip(b).map(|(a, b)| a.impulse.distance(b.impulse)).sum(),
                false => size(&pair[0]) + size(&pair[1]),
            }
        };
        let sums = own.iter().map(sum).fold(0.0, f64::max);
        [sums / weight, own.windows(2).map(change).fold(0.0, f64::max) / weight]
    }
}

/// Slides from 1 m/s until friction has stopped it.
fn slide(t: f64) -> (DVec3, DQuat) {
    let (speed, brake) = (1.0, 0.3 * G);
    let t = t.min(speed / brake);
    (DVec3::new(speed * t - 0.5 * brake * t * t, 0.02, 0.0), DQuat::IDENTITY)
}

#[test]
fn property_a_sliding_block_is_carried_and_braked_by_its_rows() {
    for rate in [1000.0, 240.0, 60.0] {
        let run = run(&table("block", rate, 0.6, slide));
        assert!((run.step * rate - 1.0).abs() < 1e-9, "{}", run.step);
        assert!(run.timeline.contacts.iter().all(|row| row.kind == ContactKind::Contact), "no impact");
        let (mass, first) = (run.mass("block"), 1.0 / rate);
        // All frames but the first and the last: from the middle of the first interval to that of the last.
        let time = 0.6 - first;
        let speed = 1.0 - 0.3 * G * 0.5 * first;
        let sum = run.impulse("block", [0.0, 1.0]);
        let [normal, tangential] = [sum.y / (mass * G * time) - 1.0, sum.x / (-mass * speed) - 1.0];
        println!("{rate} Hz: normal {normal:.1e}, tangential {tangential:.1e}");
        // Seen: 9e-6 and 4e-5.
        assert!(normal.abs() < 1e-4, "{rate} Hz: {normal}");
        assert!(tangential.abs() < 1e-4, "{rate} Hz: {tangential}");
        for (row, _) in run.rows("block", [0.0, 0.3]) {
            assert_eq!((row.body_b, row.normal), (run.id("floor"), DVec3::Y));
            assert!(row.impulse_n >= 0.0 && row.impulse_t.length() <= 0.43 * row.impulse_n + 1e-9, "{row:?}");
            assert!(row.point.y.abs() < 1e-6, "{row:?}");
        }
        // Four corners, of which those in front carry more: by μ times height over half of the length.
        let mut front = [0.0; 2];
        for (row, _) in run.rows("block", [0.05, 0.2]) {
            front[usize::from(row.point.x > slide(row.time).0.x)] += row.impulse_n;
        }
        let share = (front[1] - front[0]) / (front[1] + front[0]);
        println!("  front {share:.4}");
        assert!((share - 0.3 * 0.02 / 0.05).abs() < 0.01, "{share}");
        // Seen: 0.1250, as points within 2.7 mm of a corner count to it. A steady force has no sound: seen
        // 6e-14.
        let steady = run.heard("block", [0.1, 0.25]);
        println!("  steady {steady:?}");
        assert!(steady.iter().all(|heard| *heard < 1e-9), "{steady:?}");
    }
}

#[test]
fn property_what_rests_is_silent_with_and_without_noise() {
    for (rate, deviation) in [(1000.0, 0.0), (1000.0, 1e-6), (240.0, 1e-4)] {
        let still = |t: f64| {
            let jitter = |k: f64| deviation * 2.0 * ((t * 7919.0 + k).sin() * 43758.5453).sin();
            (DVec3::new(jitter(1.0), 0.02 + jitter(2.0), jitter(3.0)), DQuat::IDENTITY)
        };
        let run = run(&table("block", rate, 1.0, still));
        assert!(run.timeline.contacts.iter().all(|row| row.kind == ContactKind::Contact), "no impact");
        let weight = run.mass("block") * G * (1.0 - 1.0 / rate);
        let carried = run.impulse("block", [0.0, 2.0]).y / weight - 1.0;
        let heard = run.heard("block", [0.03, 0.97]);
        println!("{rate} Hz, {deviation:.0e} m: carried {carried:.1e}, heard {heard:?} of the weight");
        // Seen: 3e-5 of the weight, and 1e-14 of it that is heard.
        assert!(carried.abs() < 1e-3, "{carried}");
        assert!(heard.iter().all(|heard| *heard < 1e-9), "{heard:?}");
    }
}

#[test]
fn property_a_ball_that_rolls_is_braked_by_its_couple() {
    // The loss length b brakes by 5/7 b g / R.
    let (radius, brake) = (0.01, 5.0 / 7.0 * 0.0002 * G / 0.01);
    let roll = |t: f64| {
        let x = 0.5 * t - 0.5 * brake * t * t;
        (DVec3::new(x, radius, 0.5), DQuat::from_rotation_z(-x / radius))
    };
    for rate in [1000.0, 240.0] {
        let run = run(&table("ball", rate, 0.5, roll));
        let (mass, time) = (run.mass("ball"), 0.5 - 1.0 / rate);
        let sum = run.impulse("ball", [0.0, 1.0]);
        let couple: DVec3 = run.rows("ball", [0.0, 1.0]).iter().map(|(row, sign)| row.couple * *sign).sum();
        let balance = [
            sum.y / (mass * G * time) - 1.0,
            sum.x / (-mass * brake * time) - 1.0,
            couple.z / (1.4 * mass * brake * time * radius) - 1.0,
        ];
        println!("{rate} Hz: {balance:?}");
        // Seen: 1.4e-5, 1.1e-3, 2.4e-4: the couple is found to what the passes leave.
        assert!(balance[0].abs() < 1e-3 && balance[1].abs() < 0.03 && balance[2].abs() < 0.03, "{balance:?}");
    }
}

/// A ball bounces onto the floor, slides and then rolls: its impacts and rows sum to its change of momentum.
#[test]
fn property_impacts_and_lasting_contacts_share_one_momentum() {
    // Falls from 5 cm, bounces with e = 0.5 until 0.3 s, then slides on.
    let fall = (2.0 * 0.05 / G).sqrt();
    let height = |t: f64| {
        if t < fall {
            return 0.06 - 0.5 * G * t * t;
        }
        let (mut start, mut speed) = (fall, 0.5 * G * fall);
        while speed > 0.01 {
            let time = 2.0 * speed / G;
            if t < start + time {
                let t = t - start;
                return 0.01 + speed * t - 0.5 * G * t * t;
            }
            (start, speed) = (start + time, 0.5 * speed);
        }
        0.01
    };
    for rate in [1000.0, 240.0, 120.0] {
        let run = run(&table("ball", rate, 1.0, |t| (DVec3::new(0.3 * t, height(t), 0.5), DQuat::IDENTITY)));
        let impacts = run.timeline.impacts().len();
        let (mass, half) = (run.mass("ball"), 0.5 / rate);
        let mut worst = 0.0_f64;
        // From rest on to any later time: m (Δv − g Δt) of the frames.
        let velocity = |k: f64| (height((k + 1.0) / rate) - height(k / rate)) * rate;
        for last in [0.15_f64, 0.23, 0.35, 0.5, 0.7, 0.98] {
            let k = (last * rate).floor();
            let end = k / rate + half;
            let expected = mass * (velocity(k) - velocity(0.0) + G * (end - half));
            let sum = run.impulse("ball", [0.0, end]).y;
            worst = worst.max((sum / expected - 1.0).abs());
        }
        let drift = run.impulse("ball", [0.0, 2.0]).x / (mass * 0.3);
        println!("{rate} Hz: {impacts} impacts, momentum {worst:.1e}, along the floor {drift:.1e}");
        // Seen: 1e-5.
        assert!(worst < 1e-3, "{rate} Hz: {worst}");
        assert!(impacts >= 3, "{impacts}");
    }
}

/// Positions with noise of 0.1 mm, as of motion capture, do not become forces of the frame rate.
#[test]
fn property_noise_of_poses_does_not_become_a_force() {
    for (rate, deviation) in [(1000.0, 1e-5), (240.0, 1e-4)] {
        let mut seed = 11_u64;
        let mut noise = move || {
            let mut sum = -6.0;
            for _ in 0..12 {
                seed = seed * 48271 % 0x7fff_ffff;
                sum += seed as f64 / f64::from(0x7fff_ffff);
            }
            sum * deviation
        };
        let places: Vec<DVec3> = (0..=(0.3 * rate) as u32)
            .map(|k| slide(f64::from(k) / rate).0 + DVec3::new(noise(), noise(), noise()))
            .collect();
        let at = |t: f64| (places[(t * rate).round() as usize], DQuat::IDENTITY);
        let run = run(&table("block", rate, 0.3, at));
        let heard = run.heard("block", [0.05, 0.25]);
        let raw = 6.0_f64.sqrt() * deviation * rate * rate / G;
        println!("{rate} Hz: noise of the poses {raw:.2} of the weight, heard {heard:?}");
        // Seen: 0.02 and 0.03 of the noise, 0.03 and 0.05 of the weight.
        assert!(heard.iter().all(|heard| *heard < 0.05 * raw), "{heard:?}");
    }
}

#[test]
fn property_uneven_frames_are_told_and_few_give_no_rows() {
    let mut rows = table("block", 240.0, 0.5, slide);
    rows.push_str("0.55,block,0.17,0.02,0,0,0,0,1\n");
    let run = run(&rows);
    assert_eq!(run.step, 0.0);
    assert!(run.notices.iter().any(|notice| notice.contains("not evenly spaced")), "{:?}", run.notices);
    // One frame, two, three: at most one of them has a step.
    for count in 0..3 {
        let run = self::run(&table("block", 240.0, f64::from(count) / 240.0, slide));
        assert!(run.timeline.contacts.len() <= 4, "{count}");
    }
}

/// A brake that trembles at 100 Hz by a tenth of the weight is heard; the steady part of it is not.
#[test]
fn property_a_force_that_changes_is_heard() {
    let (rate, omega) = (1000.0, 2.0 * std::f64::consts::PI * 100.0);
    let amplitude = 0.1 * G / (omega * omega);
    let tremble = |t: f64| {
        let since = (t - 0.3).max(0.0);
        let way = amplitude * (omega * since - (omega * since).sin());
        (DVec3::new(0.5 * t - 0.05 * G * t * t + way, 0.02, 0.0), DQuat::IDENTITY)
    };
    let run = run(&table("block", rate, 0.6, tremble));
    let [before, heard] = [[0.05, 0.25], [0.35, 0.55]].map(|span| run.heard("block", span)[0]);
    // Frames of 1 ms see (sin x / x)² of it, x = π/10.
    let x = 0.5 * omega / rate;
    let expected = 0.1 * (x.sin() / x).powi(2);
    println!("steady {before:.1e}, trembling {heard:.4} of {expected:.4}");
    // Seen: 9e-14; the largest sample of a sine of ten samples is 0.951 of it.
    assert!(before < 1e-6, "{before}");
    assert!((heard / (expected * 0.951) - 1.0).abs() < 0.02, "{heard} {expected}");
}

/// Thirty boxes that land on each other and come to rest, searched in parts as a long table is.
#[test]
fn property_parts_of_a_recording_give_the_rows_of_one_piece() {
    let loaded = boxes::scene();
    let folder = tempfile::tempdir().unwrap();
    let table = boxes::poses(&loaded, 4, folder.path());
    let log = |part_length: f64| {
        let (poses, part_length) = (vec![table.clone()], Some(part_length));
        let files = MotionFiles {
            poses,
            axes: FileAxes { z_up: true, ..FileAxes::default() },
            part_length,
            raw_log: true,
            ..MotionFiles::default()
        };
        let out = folder.path().join("out.timeline");
        import_motion(&loaded, &files, &out, true).unwrap();
        read(folder.path(), Vec::new())
    };
    let [whole, parts] = [1e6, 0.61].map(log);
    let lasting = |run: &Run| -> Vec<ContactRow> {
        run.timeline.contacts.iter().filter(|row| row.impact_id == 0).copied().collect()
    };
    println!("{} rows of lasting contact", lasting(&whole).len());
    assert!(lasting(&whole).len() > 1000);
    assert!(lasting(&whole) == lasting(&parts), "{} rows in parts", lasting(&parts).len());
    // What the floor and the others give to each box from the first step to the last is m (Δv − g Δt).
    let mut errors = Vec::new();
    for body in whole.bodies.iter().filter(|body| body.mass.is_finite()) {
        let own: Vec<_> =
            whole.timeline.poses.iter().filter(|row| row.body == whole.id(&body.name)).collect();
        let (first, last) = (own[0], own[own.len() - 1]);
        let change = last.velocity.y - first.velocity.y + G * (last.time - first.time - whole.step);
        let sum = whole.impulse(&body.name, [0.0, f64::INFINITY]).y;
        errors.push((sum / (body.mass * change) - 1.0).abs());
    }
    errors.sort_by(f64::total_cmp);
    let [median, worst] = [errors[errors.len() / 2], errors[errors.len() - 1]];
    println!("balance of the boxes: median {median:.4}, worst {worst:.3}");
    // Seen: 0.019 and 0.207.
    assert!(median < 0.1 && worst < 0.25, "{errors:?}");
}

/// Bodies inside each other, under the floor, far off, or that shake: rows are finite, or a message says why.
#[test]
fn property_impossible_motion_gives_finite_rows_or_a_message() {
    let still = |place: DVec3| move |_: f64| (place, DQuat::IDENTITY);
    let block = table("block", 240.0, 0.3, slide);
    let shaken = |t: f64| (DVec3::Y * 0.02 * (1.0 + (5000.0 * t).sin()), DQuat::from_rotation_x(3000.0 * t));
    let cases = [
        block.clone() + &table("ball", 240.0, 0.3, still(DVec3::Y * 0.02)),
        table("block", 240.0, 0.3, still(DVec3::NEG_Y)),
        table("block", 240.0, 0.3, still(DVec3::splat(1e4))),
        table("block", 240.0, 0.3, shaken),
        block.clone() + "0.4,ball,0,0.01,0,0,0,0,1\n",
    ];
    for rows in cases {
        let run = run(&rows);
        for row in &run.timeline.contacts {
            let numbers = [row.point, row.normal, row.impulse(), row.couple, row.velocity];
            assert!(numbers.iter().all(|vector| vector.is_finite()) && row.impulse_n >= 0.0, "{row:?}");
        }
    }
    let folder = folder(SCENE, &[("poses.csv", &format!("{HEAD}{block}0.4,block,NaN,0,0,0,0,0,1\n"))]);
    let message = import(folder.path(), &["poses.csv"], &[], false).unwrap_err();
    assert!(message.contains("not finite") || message.contains("NaN"), "{message}");
}
