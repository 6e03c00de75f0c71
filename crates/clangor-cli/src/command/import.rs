//! `clangor import`: what another tool or a person wrote becomes a timeline.

use std::path::Path;

use clangor_core::scene::diagnostic::Doubt;
use clangor_pipeline::interchange::body_files::{ListReading, ListedMotion, import_contacts};
use clangor_pipeline::interchange::file_frame::FileAxes;
use clangor_pipeline::interchange::motion_import::{MotionFiles, import_motion};
use clangor_pipeline::motion::recording::{LengthUnit, TimeUnit};
use clangor_pipeline::stages::load::load_scene;
use serde_json::json;

use super::{check_ending, load};
use crate::arguments::{FileAxesArguments, Global, Import, ImportFormat, RecordedMotion, UpAxis};
use crate::console::{Console, counted};
use crate::diagnostics::draw_warnings;
use crate::failure::Failure;

/// Confidence below which an impact is reported as doubtful.
const DOUBTFUL: f64 = 0.5;

pub(crate) fn run(options: &Import, global: &Global, console: &Console) -> Result<(), Failure> {
    match &options.format {
        ImportFormat::Contacts { scene, list, output, at_rest, axes, force } => {
            check_ending(output, "timeline")?;
            let loaded = load(scene, global, &|_| (), console)?;
            let motion = if *at_rest { ListedMotion::AtRest } else { ListedMotion::Flights };
            let reading = ListReading { motion, axes: of_axes(axes) };
            let imported = import_contacts(&loaded, list, reading, output, *force)?;
            imported.warnings.iter().for_each(|warning| console.warn(warning));
            imported.notices.iter().for_each(|notice| console.note(notice));
            let contacts = imported.rows.contacts;
            let poses = imported.rows.poses;
            console.say(format_args!("{}: {}, {}", output.display(), rows_of(contacts), poses_of(poses)));
            let written = output.to_string_lossy();
            console.json(&json!({
                "timeline": written, "contact_rows": contacts, "pose_rows": poses,
                "warnings": imported.warnings, "notices": imported.notices,
            }));
            Ok(())
        }
        ImportFormat::Gltf { scene, files, poses, leave_out, animation, common } => {
            let files = MotionFiles {
                gltf: files.clone(),
                poses: poses.clone(),
                leave_out: leave_out.clone(),
                animation: animation.clone(),
                ..of_motion(common)
            };
            motion(scene, &files, common, console)
        }
        ImportFormat::Poses { scene, files, common } => {
            let files = MotionFiles { poses: files.clone(), ..of_motion(common) };
            motion(scene, &files, common, console)
        }
    }
}

fn rows_of(count: u64) -> String {
    counted(count as usize, "contact row", "contact rows")
}

fn poses_of(count: u64) -> String {
    counted(count as usize, "pose", "poses")
}

fn of_axes(axes: &FileAxesArguments) -> FileAxes {
    FileAxes {
        z_up: axes.up == UpAxis::Z,
        unit: LengthUnit { metres: axes.scale },
        time_unit: TimeUnit { seconds: axes.time_scale },
    }
}

fn of_motion(common: &RecordedMotion) -> MotionFiles {
    MotionFiles {
        contacts: common.contacts.clone(),
        axes: of_axes(&common.axes),
        raw_log: common.raw_log,
        ..MotionFiles::default()
    }
}

fn motion(
    scene: &Path,
    files: &MotionFiles,
    common: &RecordedMotion,
    console: &Console,
) -> Result<(), Failure> {
    let RecordedMotion { output, force, .. } = common;
    check_ending(output, "timeline")?;
    let loaded = load_scene(scene, &|_| ())?;
    // The scene need not move anything itself.
    let moves = |doubt: &Doubt| matches!(doubt, Doubt::NothingMoves | Doubt::NothingToHit);
    let warnings: Vec<_> = loaded.warnings.iter().filter(|warning| !moves(&warning.doubt)).collect();
    for drawn in draw_warnings(scene, &loaded.text, warnings.into_iter()) {
        console.drawn(drawn);
    }
    let imported = import_motion(&loaded, files, output, *force).map_err(Failure::new)?;
    imported.warnings.iter().for_each(|warning| console.warn(warning));
    imported.notices.iter().for_each(|notice| console.note(notice));
    let (moved, rows) = (imported.moved, &imported.rows);
    console.say(format_args!(
        "{}: {}, {}, {}",
        output.display(),
        counted(moved, "moved body", "moved bodies"),
        poses_of(rows.poses),
        rows_of(rows.contacts)
    ));
    let mut report = json!({
        "timeline": output.to_string_lossy(),
        "moved_bodies": moved, "pose_rows": rows.poses, "contact_rows": rows.contacts,
        "warnings": imported.warnings, "notices": imported.notices,
    });
    if let Some(found) = &imported.found {
        let impacts = found.confidence.len();
        let doubtful = found.confidence.iter().filter(|confidence| **confidence < DOUBTFUL).count();
        let doubt = match doubtful {
            0 => String::new(),
            1 => ", 1 of which explains less than half of the jump".into(),
            more => format!(", {more} of which explain less than half of the jump"),
        };
        console.say(format_args!("{} found in the motion{doubt}", counted(impacts, "impact", "impacts")));
        report["impacts"] = json!((1_u64..).zip(&found.confidence).collect::<Vec<_>>());
        report["jumps_without_contact"] = json!(found.untouched);
    }
    console.json(&report);
    Ok(())
}
