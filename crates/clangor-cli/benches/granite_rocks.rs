//! A thousand granite rocks fall into a bin, simulated by the program: CPU time, solved impacts, silence.
//!
//! `cargo bench -p clangor-cli --bench granite_rocks -- [KEY=VALUE]..`
//!
//! Keys: `program` (the one of this build): another build of `clangor` to measure on the same scene; `rocks`
//! (1000); `seconds` (6). The scene is written beside the timeline, into the folder of temporary files of the
//! build.

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use clangor_pipeline::formats::timeline_file::TimelineReader;

/// Approach speed of a hard impact [m/s].
const HARD: f64 = 0.5;
/// Speed of a rock at rest [m/s].
const STILL: f64 = 0.05;
/// Part of the rocks that may still move in a heap that has settled.
const STRAGGLERS: f64 = 0.01;

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn argument(key: &str) -> Option<String> {
    std::env::args().find_map(|word| Some(word.strip_prefix(key)?.strip_prefix('=')?.to_owned()))
}

/// Rocks of 4 to 8 cm, each of a form of its own, above a bin of 60 by 60 cm.
fn scene(rocks: usize, seconds: f64) -> String {
    let mut text = format!(
        r#"version = 1

[simulation]
duration = {seconds:?}

[[body]]
name = "rock"
shape = "rock:{{n}}x0.04@0.02"
scale = [0.5, 1.0]
material = "granite"
count = {rocks}
placement = {{ region = [[-0.24, 0.1, -0.24], [0.24, 4.1, 0.24]], seed = 18, orientation = "random" }}

[[plane]]
name = "ground"
material = "granite"

[[listener]]
name = "ears"
position = [0.0, 5.0, 0.0]
"#
    );
    for (name, point, normal) in [
        ("left", "[-0.3, 0, 0]", "[1, 0, 0]"),
        ("right", "[0.3, 0, 0]", "[-1, 0, 0]"),
        ("back", "[0, 0, -0.3]", "[0, 0, 1]"),
        ("front", "[0, 0, 0.3]", "[0, 0, -1]"),
    ] {
        let wall = format!("name = \"{name}\"\npoint = {point}\nnormal = {normal}\n");
        text += &format!("\n[[plane]]\n{wall}material = \"granite\"\nthin = true\n");
    }
    text
}

/// User and system time of all programs that this one ran \[s\].
fn cpu_of_children() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // The program name, in parentheses, may contain spaces.
    let fields: Vec<&str> = stat.rsplit(')').next().unwrap_or("").split_whitespace().collect();
    let ticks = |i: usize| fields.get(i).and_then(|f| f.parse::<f64>().ok()).unwrap_or(f64::NAN);
    (ticks(13) + ticks(14)) / 100.0
}

fn run() -> Result<(), Box<dyn std::error::Error>> {
    let number = |key: &str, default: f64| argument(key).map_or(Ok(default), |text| text.parse::<f64>());
    let (rocks, seconds) = (number("rocks", 1000.0)? as usize, number("seconds", 6.0)?);
    let program = argument("program").unwrap_or_else(|| env!("CARGO_BIN_EXE_clangor").into());
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR"));
    std::fs::create_dir_all(&folder)?;
    let (file, timeline) = (folder.join("granite-rocks.toml"), folder.join("granite-rocks.timeline"));
    std::fs::write(&file, scene(rocks, seconds))?;
    let mut command = Command::new(&program);
    command.arg("simulate").arg(&file).arg("-o").arg(&timeline).args(["--force", "--json"]);
    let output = command.stderr(std::process::Stdio::inherit()).output()?;
    if !output.status.success() {
        return Err(format!("{program}: {}", output.status).into());
    }
    let report: serde_json::Value = serde_json::from_slice(&output.stdout)?;
    println!("{program}, {}: CPU {:.1} s", file.display(), cpu_of_children());
    for key in ["impacts", "solved_impacts", "unsolved_impacts", "contact_rows", "pose_rows"] {
        println!("{key}: {}", report[key]);
    }
    println!("deepest overlap: {} m", report["deepest_overlap_m"]);
    silence(&timeline, rocks)
}

/// Prints how many impacts were hard, and when the rocks came to rest.
fn silence(timeline: &Path, rocks: usize) -> Result<(), Box<dyn std::error::Error>> {
    let reader = TimelineReader::open(timeline)?;
    let mut hard = std::collections::BTreeSet::new();
    for row in reader.contacts()? {
        let row = row?;
        if row.approach_speed() > HARD {
            hard.insert(row.impact_id);
        }
    }
    let mut moved = vec![0.0_f64; rocks];
    let (mut fastest, mut end) = (0.0_f64, 0.0_f64);
    for row in reader.poses()? {
        let row = row?;
        let Some(last) = moved.get_mut(row.body.index()) else { continue };
        let speed = row.velocity.length();
        if speed > STILL {
            *last = last.max(row.time);
        }
        if row.time > end {
            (end, fastest) = (row.time, 0.0);
        }
        fastest = fastest.max(speed);
    }
    moved.sort_by(f64::total_cmp);
    let settled = moved[((1.0 - STRAGGLERS) * rocks as f64) as usize - 1];
    println!("impacts above {HARD} m/s: {}", hard.len());
    println!(
        "below {} cm/s: half of the rocks after {:.2} s, 99 % after {settled:.2} s, all after {:.2} s; \
         at the end the fastest has {:.1} cm/s",
        STILL * 1e2,
        moved[rocks / 2],
        moved[rocks - 1],
        fastest * 1e2
    );
    Ok(())
}
