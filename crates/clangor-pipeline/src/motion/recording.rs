//! Frames of bodies that another program moved, and what can be wrong with them; `frame_checks` finds it.

use clangor_core::body::BodyId;
use clangor_core::pose::Pose;
use clangor_core::quantity::{COORDINATE, readable, rounded};

use super::file_units::LikelyUnit;
pub use super::file_units::{LengthUnit, TimeUnit};

/// Latest frame, as the longest duration of a scene \[s\].
pub const MAX_TIME: f64 = 3600.0;

/// Times above this are those of a clock \[s\]: a year.
const CLOCK: f64 = 3e7;

/// Frames after the last key of a body that moved up to it.
const HELD_FRAMES: u32 = 4;
/// Length of such a frame, at most \[s\].
const HELD_LENGTH: f64 = 1.0 / 24.0;

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
    /// In order of time, at least one. Those that only hold the last pose repeat its row.
    pub frames: Vec<Frame>,
    /// Bodies of one group are parts of one thing, and never hit each other.
    pub group: Option<usize>,
}

impl RecordedBody {
    /// Adds frames that hold the last pose of a body that moved up to it: a stop is seen by what follows it.
    pub(crate) fn hold_last(&mut self) {
        let [.., before, last] = self.frames[..] else { return };
        if before.pose == last.pose {
            return;
        }
        let span = (last.time - before.time).min(HELD_LENGTH);
        let held = (1..=HELD_FRAMES).map(|k| Frame { time: last.time + f64::from(k) * span, ..last });
        self.frames.extend(held.filter(|frame| frame.time <= MAX_TIME));
    }
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
    /// A place that no timeline has.
    #[error(
        "body {body}, row {row}: a coordinate is {}; {} is expected",
        readable(*value),
        COORDINATE.expected()
    )]
    Far {
        /// The body.
        body: String,
        /// The row.
        row: u64,
        /// The coordinate \[m\].
        value: f64,
    },
    /// A time that no timeline has.
    #[error(
        "body {body}, row {row}: t = {time} s; times run from 0 to {MAX_TIME} s{}",
        match time {
            time if *time < 0.0 => "; add the same time to all",
            time if *time > CLOCK => "; subtract the first time from all (times of a clock); times in \
                another unit need --time-scale, with its length in seconds",
            _ => "; times in milliseconds need --time-scale 0.001, in nanoseconds (timedelta of pandas) \
                --time-scale 1e-9, frame numbers --time-scale 1/24 for 24 in a second",
        }
    )]
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
         times, from one clock: sort the rows by t"
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
    #[error(
        "body {body}, row {row}: the orientation has length {}, not 1; {}",
        number(*length),
        match length {
            length if *length == 0.0 => "a body that does not turn has x, y, z = 0 and w = 1",
            _ => "divide the quaternion by its length",
        }
    )]
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
        "body {body}, row {row}: it moves {} m within {} s, which is {} m/s; {}",
        number(*distance), number(*span), number(*speed),
        match unit {
            _ if *repeats => "poses before it repeat each other while the body moves: leave the repeated \
                rows out".into(),
            Some(unit) => unit.to_string(),
            None => "a body that is put elsewhere must be hidden (scale 0) or another body, and a file in \
                centimetres needs --scale 0.01, one in millimetres --scale 0.001".into(),
        }
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
        /// The unit of the file, if its falls until then, or its last frames, show it.
        unit: Option<LikelyUnit>,
        /// Whether poses before it repeat while the body moves.
        repeats: bool,
    },
}

/// A computed number for people.
fn number(value: f64) -> String {
    readable(rounded(value, 4))
}

/// What is allowed in a recording, but should be known.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RecordingNotice {
    /// Distances of frames that differ.
    #[error(
        "body {body}: frames are {} s to {} s apart; impacts are less exact in the longer ones",
        number(*shortest), number(*longest)
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
    /// Quaternions of a table with the scalar first.
    #[error(
        "body {body}, row {row}: as it falls, its angular momentum is constant only if its orientation is \
         read as w, x, y, z; the columns orientation_x, _y, _z and _w probably hold w, x, y and z: \
         rename them, so that orientation_w holds the scalar"
    )]
    ScalarFirst {
        /// The body.
        body: String,
        /// Row in which its first fall ends.
        row: u64,
    },
    /// Bodies that all begin with (1, 0, 0, 0).
    #[error(
        "body {body}, row {row}: orientation_x is 1 and orientation_w 0 where the motion begins, which is \
         upside down; if orientation_x, _y, _z and _w hold w, x, y and z, rename them, so that orientation_w \
         holds the scalar"
    )]
    BeginsWithOne {
        /// The first body; all others begin so too.
        body: String,
        /// Its first row.
        row: u64,
    },
    /// Positions whose noise hides impacts.
    #[error(
        "body {body}: its positions have a noise of {} mm, which hides impacts below {} m/s at this rate{}",
        number(1e3 * noise), number(*hidden),
        match every {
            0 | 1 => String::new(),
            _ => {
                let left = number(hidden / f64::from(*every));
                format!("; with one frame of {every} alone, about {left} m/s")
            }
        }
    )]
    Noisy {
        /// The body.
        body: String,
        /// Deviation of a coordinate \[m\].
        noise: f64,
        /// Jump that does not stand out [m/s].
        hidden: f64,
        /// Frames of which one is enough for the impacts that others hide.
        every: u32,
    },
    /// Poses that repeat the one before while the body moves.
    #[error(
        "body {body}: {count} poses repeat the one before while it moves, the first in row {row}; leave the \
         repeated rows out, or each move after one is an impact"
    )]
    Repeated {
        /// The body.
        body: String,
        /// How many there are.
        count: u64,
        /// Row of the first.
        row: u64,
    },
    /// Poses of other instants than their times say.
    #[error(
        "body {body}: its poses are those of other instants than their t, by about {} ms, as of frames that \
         are taken at the nearest step of an engine: what moves fast seems to jump; write the time of the \
         step as t",
        number(1e3 * deviation)
    )]
    UnevenTimes {
        /// The body.
        body: String,
        /// Deviation of the times \[s\].
        deviation: f64,
    },
    /// Poses on straight lines between keys.
    #[error(
        "body {body}: from row {row} on, it moves straight between every {every} poses, as between keys that \
         are joined by lines; export the poses of the keys alone, or each key is a jump and an impact \
         between two keys is cut in two"
    )]
    StraightKeys {
        /// The body.
        body: String,
        /// Distance of the keys \[poses\].
        every: u64,
        /// Row of the first.
        row: u64,
    },
    /// A body that turns too fast for its frames.
    #[error(
        "body {body}, row {row}: it turns by {degrees:.0}° within a frame; turns beyond 180° cannot be \
         measured"
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
