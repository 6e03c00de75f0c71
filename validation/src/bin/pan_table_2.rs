//! \[PAN\] Table 2 and \[PROXY\] Table 2: the time to synthesise the sound of every scene of the papers, on
//! generated timelines of the printed numbers of impulses.
//!
//! `cargo run --release -p clangor-validation --bin pan_table_2 [-- NAME …]`;
//! a name is any part of that of a scene.
//!
//! The papers' scenes are not published, only their numbers of impulses faster than v_min. Here each is an
//! impulse between two sounding bodies of the scene; with a table, one of them is the table, which is silent.
//! Times are CPU time from the timeline to the WAV file (contact forces, synthesis, writing), for one
//! microphone; the papers' are of 8 cores. Fields are baked first, to 20 kHz at 1 % (with the mug to 6 kHz),
//! and kept in the system's temporary folder.

use clangor_core::sound_model::AccelerationRule;
use clangor_pipeline::formats::soundbank::default_bank;

use clangor_validation::paper_scene::{Group, Stage, cache};

/// A scene: name, seconds, impulses, printed time of synthesis \[s\], band of the fields \[Hz\], groups,
/// table.
struct Scene(&'static str, f64, usize, f64, f64, Vec<Group>, bool);

const fn own(shape: &'static str, material: &'static str, count: usize) -> Group {
    Group { shape, material, count, rule: AccelerationRule::Own }
}

const fn proxy(shape: &'static str, material: &'static str, count: usize) -> Group {
    Group { shape, material, count, rule: AccelerationRule::Proxy }
}

/// Band of the fields, and that of scenes with the mug \[Hz\].
const BAND: f64 = 20_000.0;
const MUG: f64 = 6_000.0;

/// Scenes of \[PAN\] Table 2.
fn pan_scenes() -> Vec<Scene> {
    let ball = || Group { rule: AccelerationRule::Auto, ..own("sphere:0.0075", "steel", 50) };
    let coins = |count| own("coin", "copper", count);
    let dice = || vec![own("die:0.015x0.0005", "plastic", 5), own("die", "plastic", 5)];
    vec![
        Scene("ball drop", 5.0, 23_411, 7.96, BAND, vec![ball()], false),
        Scene("coin drop", 8.0, 22_959, 16.0, BAND, vec![coins(50)], false),
        Scene("coin drop with table", 8.0, 24_045, 18.19, BAND, vec![coins(50)], true),
        Scene("dice drop", 5.0, 3_414, 0.88, BAND, dice(), false),
        Scene("dice drop with table", 5.0, 683, 0.40, BAND, dice(), true),
        Scene(
            "key chain",
            5.0,
            48_828,
            12.36,
            BAND,
            vec![own("key", "copper", 4), own("ring", "copper", 1)],
            false,
        ),
        Scene("mug and coin drop", 5.0, 3_796, 2.68, MUG, vec![own("mug", "ceramic", 1), coins(10)], false),
        Scene("multiple bowl drop", 5.0, 1_992, 3.29, BAND, vec![own("bowl", "ceramic", 10)], false),
        Scene("multiple mug drop", 5.0, 319, 10.33, MUG, vec![own("mug", "ceramic", 10)], false),
        Scene("multiple plate drop", 5.0, 1_303, 3.72, BAND, vec![own("plate", "ceramic", 10)], false),
        Scene(
            "plate fracture, 11 pieces",
            5.0,
            1_293,
            2.23,
            BAND,
            vec![proxy("shard:{n}x0.08", "ceramic", 11)],
            false,
        ),
        Scene(
            "glass fracture, 71 pieces",
            2.0,
            2_507,
            3.77,
            BAND,
            vec![proxy("shard:{n}x0.04", "glass", 71)],
            false,
        ),
    ]
}

/// Scenes of \[PROXY\] Table 2.
fn proxy_scenes() -> Vec<Scene> {
    vec![
        Scene(
            "PROXY plate fracture",
            5.0,
            1_293,
            1.0,
            BAND,
            vec![proxy("shard:{n}x0.08", "ceramic", 11)],
            false,
        ),
        Scene(
            "PROXY multiple plate fracture",
            4.0,
            5_921,
            40.0,
            BAND,
            vec![proxy("shard:{n}x0.08", "ceramic", 110)],
            false,
        ),
        Scene(
            "PROXY glass fracture, 71 pieces",
            2.0,
            2_507,
            2.0,
            BAND,
            vec![proxy("shard:{n}x0.04", "glass", 71)],
            false,
        ),
        Scene(
            "PROXY glass fracture, 316 pieces",
            3.0,
            18_787,
            12.0,
            BAND,
            vec![proxy("shard:{n}x0.02", "glass", 316)],
            false,
        ),
        Scene("PROXY rock pile, large", 6.0, 210_741, 192.0, BAND, rocks(0.05), false),
        Scene("PROXY rock pile, small", 6.0, 96_579, 97.0, BAND, rocks(0.015), false),
    ]
}

/// A thousand rocks of different shapes, from 0.2 to 1.8 times the mean radius.
fn rocks(mean: f64) -> Vec<Group> {
    (0..10)
        .map(|size| {
            let radius = mean * (0.29 + 0.158 * f64::from(size));
            // Shapes live until the end of the program.
            let shape: &'static str = format!("rock:{{n}}x{radius:.5}@{:.5}", 0.5 * radius).leak();
            proxy(shape, "granite", 100)
        })
        .collect()
}

fn main() {
    let wanted: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    let folder = tempfile::tempdir().expect("a temporary folder");
    let bank = default_bank();
    let cache = cache();
    println!("| scene | seconds | impulses | bodies that sound | CPU time | per impulse | printed |");
    println!("|---|---|---|---|---|---|---|");
    for Scene(name, seconds, impulses, printed, band, groups, table) in
        pan_scenes().into_iter().chain(proxy_scenes())
    {
        if !wanted.is_empty() && !wanted.iter().any(|w| name.contains(w.as_str())) {
            continue;
        }
        let stage = Stage::new(&groups, table);
        let models = stage.models(band, &cache, bank.as_ref());
        let timeline = stage.timeline(impulses, seconds);
        let file = folder.path().join("scene.wav");
        let best = (0..3)
            .map(|_| stage.render(&models, &timeline, seconds, &file))
            .min_by(|a, b| a.seconds.total_cmp(&b.seconds))
            .expect("three runs");
        println!(
            "| {name} | {seconds} | {impulses} | {} | {:.2} s | {:.0} µs | {printed} s |",
            best.clicks,
            best.seconds,
            1e6 * best.seconds / impulses as f64
        );
    }
}
