//! Frames of bodies that another program moved, checked: finite numbers, rising times, unit rotations, and
//! no jumps that no body makes.

use clangor_core::body::BodyId;
use clangor_core::pose::Pose;
use glam::DVec3;

/// Latest frame, as the longest duration of a scene \[s\].
pub const MAX_TIME: f64 = 3600.0;
/// How far the length of a quaternion may be from 1; it is made 1.
const UNIT_TOLERANCE: f64 = 0.01;
/// A jump is a frame this many times as fast as those before and after it.
const JUMP_RATIO: f64 = 10.0;
/// Slowest frame that is taken for a jump [m/s].
const JUMP_SPEED: f64 = 5.0;
/// Ratio of the longest to the shortest distance of frames from which a notice is given.
const UNEVEN: f64 = 1.5;
/// Share of the frames in which a body must fall along z for the axes to be doubted.
const DOUBTFUL_SHARE: f64 = 0.3;

/// Pose of a body at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Time \[s\].
    pub time: f64,
    /// Pose of the centre of mass.
    pub pose: Pose,
    /// Where it stands in its file: the line of a text, the row of a table, or the number of a frame.
    pub row: u64,
}

/// Frames of one body.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordedBody {
    /// The body.
    pub body: BodyId,
    /// In order of time, at least one.
    pub frames: Vec<Frame>,
}

/// Why a recording cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RecordingError {
    /// A number is NaN or infinite.
    #[error("body {body}, row {row}: {what} is not finite")]
    NotFinite {
        /// The body.
        body: String,
        /// The row.
        row: u64,
        /// Time, position or orientation.
        what: &'static str,
    },
    /// A time that no timeline has.
    #[error("body {body}, row {row}: t = {time} s; times run from 0 to {MAX_TIME} s")]
    Time {
        /// The body.
        body: String,
        /// The row.
        row: u64,
        /// The time \[s\].
        time: f64,
    },
    /// Times that do not rise.
    #[error(
        "body {body}, row {row}: t = {time} s comes after t = {before} s; the frames of a body need rising \
         times, from one clock"
    )]
    Order {
        /// The body.
        body: String,
        /// The row.
        row: u64,
        /// Its time \[s\].
        time: f64,
        /// Time of the frame before \[s\].
        before: f64,
    },
    /// A quaternion that is no rotation.
    #[error("body {body}, row {row}: the orientation has length {length}, not 1")]
    NotUnit {
        /// The body.
        body: String,
        /// The row.
        row: u64,
        /// Length of the quaternion.
        length: f64,
    },
    /// A body that is somewhere else from one frame to the next.
    #[error(
        "body {body}, row {row}: it moves {distance} m within {span} s, which is {speed} m/s; a body that is \
         put elsewhere must be hidden (scale 0) or another body"
    )]
    Teleport {
        /// The body.
        body: String,
        /// Row of the later frame.
        row: u64,
        /// How far \[m\].
        distance: f64,
        /// Time between the frames \[s\].
        span: f64,
        /// Their quotient [m/s].
        speed: f64,
    },
}

/// What is allowed in a recording, but should be known.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RecordingNotice {
    /// Distances of frames that differ.
    #[error(
        "body {body}: frames are {shortest} s to {longest} s apart; impacts are less exact in the longer ones"
    )]
    Uneven {
        /// The body.
        body: String,
        /// Shortest distance \[s\].
        shortest: f64,
        /// Longest distance \[s\].
        longest: f64,
    },
    /// Bodies of tables that fall sideways.
    #[error("bodies fall along -z, not along gravity: the file seems to have z up; import it with --up z")]
    ZUp,
    /// Bodies of glTF files that fall sideways.
    #[error(
        "bodies fall along -z, not along gravity: the glTF file seems to have z up, which the format does \
         not allow; export it with +Y up"
    )]
    ZUpInGltf,
    /// A body that turns too fast for its frames.
    #[error(
        "body {body}, row {row}: it turns by {degrees:.0}° within a frame; its spin cannot be told beyond \
         180°"
    )]
    FastTurn {
        /// The body.
        body: String,
        /// The row.
        row: u64,
        /// The angle \[°\].
        degrees: f64,
    },
}

/// Checks the frames of a body called `name` and makes its rotations unit; `sound_speed` [m/s] is that of
/// the medium, which no body reaches.
///
/// # Errors
/// [`RecordingError`] with the first bad row.
pub fn check_frames(name: &str, frames: &mut [Frame], sound_speed: f64) -> Result<(), RecordingError> {
    for k in 0..frames.len() {
        let Frame { time, pose, row } = frames[k];
        let body = || name.to_string();
        let not_finite = |what| RecordingError::NotFinite { body: body(), row, what };
        if !time.is_finite() {
            return Err(not_finite("t"));
        }
        if !pose.position.is_finite() {
            return Err(not_finite("position"));
        }
        if !pose.orientation.is_finite() {
            return Err(not_finite("orientation"));
        }
        if !(0.0..=MAX_TIME).contains(&time) {
            return Err(RecordingError::Time { body: body(), row, time });
        }
        let length = pose.orientation.length();
        if (length - 1.0).abs() > UNIT_TOLERANCE {
            return Err(RecordingError::NotUnit { body: body(), row, length });
        }
        frames[k].pose.orientation = pose.orientation / length;
        if let Some(before) = k.checked_sub(1).map(|k| frames[k].time).filter(|before| *before >= time) {
            return Err(RecordingError::Order { body: body(), row, time, before });
        }
    }
    check_jumps(name, frames, sound_speed)
}

fn check_jumps(name: &str, frames: &[Frame], sound_speed: f64) -> Result<(), RecordingError> {
    let speeds: Vec<f64> = frames.windows(2).map(|w| speed(&w[0], &w[1])).collect();
    for (k, &speed) in speeds.iter().enumerate() {
        let before = if k > 0 { speeds[k - 1] } else { f64::INFINITY };
        let after = speeds.get(k + 1).copied().unwrap_or(f64::INFINITY);
        let alone = speed > JUMP_SPEED && speed > JUMP_RATIO * before.max(after);
        if alone || speed >= sound_speed {
            let (from, to) = (frames[k], frames[k + 1]);
            return Err(RecordingError::Teleport {
                body: name.into(),
                row: to.row,
                distance: from.pose.position.distance(to.pose.position),
                span: to.time - from.time,
                speed,
            });
        }
    }
    Ok(())
}

fn speed(from: &Frame, to: &Frame) -> f64 {
    from.pose.position.distance(to.pose.position) / (to.time - from.time)
}

/// What should be known about checked frames, of which the first `from_gltf` bodies come from glTF files;
/// `name` gives the names of the bodies, `gravity` is in m/s².
pub fn notices(
    bodies: &[RecordedBody],
    from_gltf: usize,
    name: &dyn Fn(BodyId) -> String,
    gravity: DVec3,
) -> Vec<RecordingNotice> {
    let mut found = Vec::new();
    for recorded in bodies {
        let spans = recorded.frames.windows(2).map(|w| w[1].time - w[0].time);
        let (shortest, longest) =
            spans.fold((f64::INFINITY, 0.0_f64), |(low, high), s| (low.min(s), high.max(s)));
        if longest > UNEVEN * shortest {
            found.push(RecordingNotice::Uneven { body: name(recorded.body), shortest, longest });
        }
        let turned = |w: &[Frame]| w[0].pose.rotation_to(&w[1].pose).length();
        let fastest = recorded.frames.windows(2).map(|w| (turned(w), w[1].row));
        if let Some((angle, row)) =
            fastest.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|(angle, _)| *angle > 2.0)
        {
            found.push(RecordingNotice::FastTurn {
                body: name(recorded.body),
                row,
                degrees: angle.to_degrees(),
            });
        }
    }
    let (gltf, tables) = bodies.split_at(from_gltf.min(bodies.len()));
    found.extend(falls_along_z(gltf, gravity).then_some(RecordingNotice::ZUpInGltf));
    found.extend(falls_along_z(tables, gravity).then_some(RecordingNotice::ZUp));
    found
}

/// Whether bodies accelerate by g along −z in a good share of the frames, and hardly ever along gravity.
fn falls_along_z(bodies: &[RecordedBody], gravity: DVec3) -> bool {
    let g = gravity.length();
    let near = |a: DVec3, direction: DVec3| (a - direction * g).length() < 0.2 * g;
    let (mut all, mut along_z, mut right) = (0_u32, 0_u32, 0_u32);
    for w in bodies.iter().flat_map(|recorded| recorded.frames.windows(3)) {
        let [h, k] = [w[1].time - w[0].time, w[2].time - w[1].time];
        let [v, u] =
            [(w[1].pose.position - w[0].pose.position) / h, (w[2].pose.position - w[1].pose.position) / k];
        let acceleration = (u - v) / (0.5 * (h + k));
        if acceleration.length() > 0.2 * g {
            all += 1;
            along_z += u32::from(near(acceleration, DVec3::NEG_Z));
            right += u32::from(near(acceleration, gravity / g));
        }
    }
    g > 0.0 && f64::from(along_z) > DOUBTFUL_SHARE * f64::from(all) && right * 10 < along_z
}
