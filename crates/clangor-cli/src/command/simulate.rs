//! `clangor simulate`: dynamics only.

pub(super) mod breaking;

use clangor_pipeline::formats::timeline_file::TimelineReader;
use clangor_pipeline::stages::fracture_report::FractureReport;
use clangor_pipeline::stages::simulate::simulate_to_folder;
use clangor_sim::SimulationReport;
use serde_json::json;

use super::impact_modes::impact_modes;
use super::{check_ending, collision_parts, load, refuse_overwriting};
use crate::arguments::{Global, Simulate};
use crate::console::{Console, counted};
use crate::failure::Failure;

pub(crate) fn run(options: &Simulate, global: &Global, console: &Console) -> Result<(), Failure> {
    let output = options.output.clone().unwrap_or_else(|| options.scene.with_extension("timeline"));
    check_ending(&output, "timeline")?;
    if let Some(path) = &options.report {
        check_ending(path, "json")?;
        refuse_overwriting(&options.scene, path)?;
    }
    let adjust = |scene: &mut clangor_core::scene::Scene| {
        scene.simulation.duration = options.duration.unwrap_or(scene.simulation.duration);
    };
    let mut loaded = load(&options.scene, global, &adjust, console)?;
    impact_modes(&mut loaded, global, console)?;
    let progress = console.progress("simulate", loaded.scene.simulation.duration);
    let (report, rows) =
        simulate_to_folder(&loaded, options.raw_log, &output, options.force, &mut |t| progress.reached(t))?;
    drop(progress);
    say_simulated(console, &report);
    if report.fractures > 0 || options.report.is_some() {
        let timeline = TimelineReader::open(&output).map_err(Failure::new)?;
        let fractures =
            FractureReport::new(&timeline.bodies(), timeline.fractures()).with_impacts(&report.breaking);
        breaking::say_energies(console, &fractures.totals);
        if let Some(path) = &options.report {
            breaking::write(path, &fractures)?;
        }
    }
    console.say(format_args!(
        "{}: {}, {}",
        output.display(),
        counted(rows.contacts as usize, "contact row", "contact rows"),
        counted(rows.poses as usize, "pose row", "pose rows")
    ));
    console.json(&json!({
        "timeline": output.display().to_string(),
        "impacts": report.impacts,
        "dropped_impacts": report.dropped_impacts,
        "fractures": report.fractures,
        "births": report.births,
        "contact_rows": rows.contacts,
        "pose_rows": rows.poses,
        "solved_impacts": report.solved,
        "unsolved_impacts": report.fallen_back,
        "deepest_overlap_m": report.deepest_overlap,
        "breaking": breaking::json(&report.breaking),
        "simulated_s": report.time,
        "collision_parts": collision_parts::json(&loaded),
    }));
    Ok(())
}

/// One line about a simulation.
pub(super) fn say_simulated(console: &Console, report: &SimulationReport) {
    console.say(format_args!(
        "simulated {} s: {}, {} more slower than v_min, deepest overlap {:.2} µm",
        report.time,
        counted(report.impacts as usize, "impact", "impacts"),
        report.dropped_impacts,
        report.deepest_overlap * 1e6
    ));
    if report.solved + report.fallen_back > 0 {
        console.say(format_args!(
            "{} on bodies that give way, {} of which could not be solved",
            counted((report.solved + report.fallen_back) as usize, "impact", "impacts"),
            report.fallen_back
        ));
    }
    if report.fractures > 0 {
        console.say(format_args!(
            "{} broke, and {} were born",
            counted(report.fractures as usize, "body", "bodies"),
            counted(report.births as usize, "piece", "pieces")
        ));
    }
    breaking::say(console, &report.breaking);
}
