//! The part of a timeline folder that is heard.

use std::collections::BTreeSet;

use clangor_core::body::BodyId;
use clangor_core::timeline::Timeline;

use crate::formats::timeline_file::{TimelineError, TimelineReader};
use crate::stages::resting_poses::RestingPoses;

/// The impacts of a timeline folder and the poses of their bodies at them, and all poses but those of rest of
/// the bodies that are `followed` and of their pieces, and all recorded forces, leaving the rest on the disk;
/// with `rolling`, what touches them gently too.
///
/// # Errors
/// [`TimelineError`] for rows that cannot be read.
pub fn read_impacts(
    reader: &TimelineReader,
    followed: &BTreeSet<BodyId>,
    rolling: bool,
) -> Result<Timeline, TimelineError> {
    let mut timeline = Timeline {
        fractures: reader.fractures().to_vec(),
        births: reader.births().to_vec(),
        ..Timeline::default()
    };
    let mut followed = followed.clone();
    for fracture in reader.fractures() {
        if followed.contains(&fracture.parent) {
            followed.extend(fracture.pieces());
        }
    }
    for row in reader.contacts()? {
        let row = row?;
        let gentle = || rolling && [row.body_a, row.body_b].iter().any(|id| followed.contains(id));
        if row.impact_id != 0 || gentle() {
            timeline.contacts.push(row);
        }
    }
    timeline.contacts.sort_by(|a, b| a.time.total_cmp(&b.time));
    timeline.forces = reader.forces_of(&timeline.impacts())?;
    let impacts = timeline.contacts.iter().filter(|r| r.impact_id != 0);
    let times: Vec<f64> = impacts.map(|r| r.time).collect();
    // A pose at an impact has its very time; where there is none, its neighbours at the pose rate are needed.
    let margin =
        if reader.header().origin.pose_rate > 0.0 { 1.5 / reader.header().origin.pose_rate } else { 0.0 };
    let mut resting = RestingPoses::default();
    for row in reader.poses()? {
        let row = row?;
        let after = times.partition_point(|t| *t < row.time - margin);
        if times.get(after).is_some_and(|t| *t <= row.time + margin) {
            timeline.poses.extend(resting.always(&row));
        } else if followed.contains(&row.body) {
            timeline.poses.extend(resting.kept(&row));
        }
    }
    timeline.poses.sort_by(|a, b| a.time.total_cmp(&b.time));
    Ok(timeline)
}
