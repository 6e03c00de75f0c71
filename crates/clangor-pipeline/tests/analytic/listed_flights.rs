//! Free bodies fly between listed impacts: parabolas, spins by friction, and every codec alike; notices
//! name lists that lead elsewhere.

use std::fs;
use std::path::Path;

use crate::parquet_columns::write_columns;
use clangor_core::body::BodyId;
use clangor_core::timeline::{PoseRow, Timeline};
use clangor_pipeline::formats::timeline_file::TimelineReader;
use clangor_pipeline::interchange::body_files::{ListedMotion, import_contacts};
use clangor_pipeline::stages::load::load_scene;
use glam::DVec3;
use parquet::basic::{BrotliLevel, Compression, GzipLevel, ZstdLevel};

const SCENE: &str = r#"version = 1
[simulation]
duration = 1.2
[[body]]
name = "ball"
shape = "sphere:0.01"
material = "steel"
position = [0.0, 0.51, 0.0]
[[body]]
name = "idle"
shape = "sphere:0.01"
material = "steel"
position = [1.0, 2.0, 0.0]
[[plane]]
name = "floor"
material = "granite"
[[listener]]
position = [0.3, 0.4, 0.4]
"#;
const G: f64 = 9.80665;
/// Restitution of the list.
const E: f64 = 0.6;
/// Tangential over normal impulse of the first impact.
const RUB: f64 = 0.2;
const COLUMNS: [&str; 12] = [
    "t",
    "body_a",
    "point_x",
    "point_y",
    "point_z",
    "normal_x",
    "normal_y",
    "normal_z",
    "impulse_n",
    "impulse_t_x",
    "impulse_t_y",
    "impulse_t_z",
];
/// Poses have 32-bit floats: 3e-8 m at half a metre.
const ROUNDING: f64 = 1e-7;

/// When a ball that falls from 0.5 m first touches \[s\], and its speed then [m/s].
fn first_fall() -> [f64; 2] {
    [(1.0 / G).sqrt(), G.sqrt()]
}

fn mass() -> f64 {
    7850.0 * 4.0 / 3.0 * std::f64::consts::PI * 1e-6
}

/// The rows of two impacts, the first with friction along x, and their approaches.
fn rows() -> Vec<[f64; 13]> {
    let [time, speed] = first_fall();
    let again = time + 2.0 * E * speed / G;
    let (one, two) = (mass() * speed * (1.0 + E), mass() * speed * E * (1.0 + E));
    let drift = RUB * one / mass() * (again - time);
    vec![
        [time, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, one, RUB * one, 0.0, 0.0, speed],
        [again, 0.0, drift, 0.0, 0.0, 0.0, 1.0, 0.0, two, 0.0, 0.0, 0.0, E * speed],
    ]
}

fn csv(rows: &[[f64; 13]]) -> String {
    let line = |row: &[f64; 13]| row.map(|value| value.to_string()).join(",") + "\n";
    COLUMNS.join(",") + ",speed\n" + &rows.iter().map(line).collect::<String>()
}

fn write_parquet(path: &Path, rows: &[[f64; 13]], compression: Compression) {
    let names = COLUMNS.into_iter().chain(["speed"]).enumerate();
    let columns: Vec<(&str, Vec<f64>)> =
        names.map(|(index, name)| (name, rows.iter().map(|row| row[index]).collect())).collect();
    write_columns(path, &columns, compression);
}

/// Imports a list; its timeline and notices.
fn import(scene: &str, write: &dyn Fn(&Path), name: &str) -> Result<(Timeline, Vec<String>), String> {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scene.toml"), scene).unwrap();
    let list = folder.path().join(name);
    write(&list);
    let loaded = load_scene(&folder.path().join("scene.toml"), &|_| ()).unwrap();
    let out = folder.path().join("out.timeline");
    let imported = import_contacts(&loaded, &list, ListedMotion::Flights, &out, false);
    let notices = imported.map_err(|error| error.to_string())?.notices;
    Ok((TimelineReader::open(&out).unwrap().read_all().unwrap(), notices))
}

fn import_csv(scene: &str, rows: &[[f64; 13]]) -> (Timeline, Vec<String>) {
    import(scene, &|path| fs::write(path, csv(rows)).unwrap(), "list.csv").unwrap()
}

#[test]
fn analytic_a_ball_flies_on_parabolas_and_spins_by_friction() {
    let (timeline, notices) = import_csv(SCENE, &rows());
    assert_eq!(notices, ["2 contacts without body_b belong to the plane floor, on which they lie"]);
    let [time, speed] = first_fall();
    let again = rows()[1][0];
    let slide = RUB * (1.0 + E) * speed;
    let height = |t: f64| match t {
        t if t <= time => 0.51 - 0.5 * G * t * t,
        t if t <= again => 0.01 + E * speed * (t - time) - 0.5 * G * (t - time).powi(2),
        t => 0.01 + E * E * speed * (t - again) - 0.5 * G * (t - again).powi(2),
    };
    // r × J with r = −R y and J along x is along z: ω = R J / I = 2.5 slide / R.
    let spin = DVec3::Z * 2.5 * slide / 0.01;
    let before = |row: &&PoseRow| row.time <= time;
    let landing = again + 2.0 * E * E * speed / G;
    let mut worst = 0.0_f64;
    for row in timeline.poses.iter().filter(|row| row.time < landing) {
        assert_eq!(row.body, BodyId(0), "what is not listed does not move");
        let x = slide * (row.time - time).max(0.0);
        worst = worst.max(row.position.distance(DVec3::new(x, height(row.time), 0.0)));
        let expected = if before(&row) { DVec3::ZERO } else { spin };
        assert!((row.angular_velocity - expected).length() < 1e-5 * spin.length(), "{row:?}");
    }
    println!("largest distance {worst:e} m");
    assert!(worst < ROUNDING, "{worst}");
    // A pose at each impact, with the velocity before it.
    let at_impact: Vec<&PoseRow> = timeline.poses.iter().filter(|row| row.time == again).collect();
    assert!((at_impact.last().unwrap().velocity.y + E * speed).abs() < 1e-6, "{at_impact:?}");
    // The list ends there; the ball comes down once more and stays.
    let last = timeline.poses.last().unwrap();
    assert!(last.time < 1.19 && (last.position.y - 0.01).abs() < 1e-6, "{last:?}");
    assert_eq!(last.velocity, DVec3::ZERO);
}

#[test]
fn property_every_codec_of_a_list_gives_the_same_flights() {
    let expected = import_csv(SCENE, &rows());
    let codecs = [
        Compression::UNCOMPRESSED,
        Compression::SNAPPY,
        Compression::GZIP(GzipLevel::default()),
        Compression::LZ4_RAW,
        Compression::ZSTD(ZstdLevel::default()),
        Compression::BROTLI(BrotliLevel::default()),
    ];
    for codec in codecs {
        let found = import(SCENE, &|path| write_parquet(path, &rows(), codec), "list.parquet").unwrap();
        assert_eq!(found, expected, "{codec:?}");
    }
}

#[test]
fn property_a_list_that_flights_do_not_meet_is_told() {
    // A millimetre off, and an approach that is a tenth slower.
    let mut off = rows();
    (off[1][3], off[1][12]) = (0.001, 0.9 * off[1][12]);
    let (timeline, notices) = import_csv(SCENE, &off);
    assert!(!timeline.poses.is_empty());
    assert!(
        notices.iter().any(|n| n.contains("flights of ball miss") && n.contains("(row 3)")),
        "{notices:?}"
    );
    assert!(
        notices.iter().any(|n| n.contains("differs from that of the list by up to") && n.contains("(row 3")),
        "{notices:?}"
    );
    // Half a second too early: the ball is still in the air.
    let mut early = rows();
    early[0][0] = 0.05;
    let (timeline, notices) = import_csv(SCENE, &early);
    assert!(timeline.poses.is_empty());
    let wanted = "ball stays where the scene starts it: its flight under gravity and the listed \
    impulses passes \
                the contact of row 2 at 0.48";
    assert!(notices.iter().any(|n| n.contains(wanted)), "{notices:?}");
    // Something holds it.
    let held =
        SCENE.replace("[[listener]]", "[[hang]]\nbody = \"ball\"\nanchor = [0.0, 1.0, 0.0]\n[[listener]]");
    let (timeline, notices) = import_csv(&held, &rows());
    assert!(timeline.poses.is_empty());
    assert!(notices.iter().any(|n| n.contains("a link or a support holds it")), "{notices:?}");
}

#[test]
fn regression_a_list_without_impulses_is_refused_with_its_line() {
    let text = csv(&rows()).replace("impulse_n,", "depth,");
    let message = import(SCENE, &|path| fs::write(path, &text).unwrap(), "list.csv").unwrap_err();
    assert!(message.contains("line 2: impulse_n is missing"), "{message}");
}

#[test]
fn regression_impossible_rows_of_a_list_alone_are_refused_with_row_and_body() {
    let [time, speed] = first_fall();
    let head =
        COLUMNS.join(",").replace("t,body_a", "t,body_a,body_b") + ",velocity_x,velocity_y,velocity_z\n";
    let row = |second: &str, y: f64, impulse: f64, velocity: f64| {
        format!("{time},ball,{second},0,{y},0,0,1,0,{impulse},0,0,0,0,{velocity},0\n")
    };
    let usual = 1.6 * mass() * speed;
    let cases = [
        (row("ball", 0.0, usual, -speed), "row 2: ball touches itself"),
        (row("floor", 0.0, usual, speed), "row 2: ball recedes from what it hits"),
        (row("floor", 0.0, 1000.0 * usual, -speed), "row 2: impulse_n on ball is"),
        (row("floor", 3.7, usual, -speed), "row 2: the point is 3.7 m off the surface of floor"),
        (row("nobody", 0.0, usual, -speed), "line 2: body_b is nobody"),
        (row("floor", 0.0, f64::NAN, -speed), "line 2: impulse_n is NaN"),
    ];
    for (row, wanted) in cases {
        let text = head.clone() + &row;
        let message = import(SCENE, &|path| fs::write(path, &text).unwrap(), "list.csv").unwrap_err();
        assert!(message.contains(wanted), "{wanted}: {message}");
    }
}
