//! Whether the times and lengths of a recording are in seconds and metres, found by how its bodies fall.
//!
//! ```text
//! a / g = u²        times in units of u seconds, read as seconds
//! a / g = 1/l       lengths in units of l metres, read as metres
//! ```
//!
//! The median of the falls of a file is held against the gravity of the scene. A recording in which some
//! bodies fall with g is right, whatever else moves in it; one in which all fall alike, but by a factor of
//! two or more faster or slower, has another unit, another gravity, or is in slow motion.
//!
//! Not a correction: the user says what is meant.

use std::fmt;
use std::path::{Path, PathBuf};

use clangor_core::quantity::{readable, rounded};
use glam::DVec3;

use super::file_units::{FileUnits, LikelyUnit, SAME_UNIT, likely_unit};
use super::free_falls::{FallSpeeds, FallsAlong, FreeFalls};
use super::recording::Frame;

/// Share of the falls that agree with gravity from which on the units are right, and the factor within which
/// they agree.
const AGREES: (f64, f64) = (0.1, 1.25);
/// Factor from the gravity of the scene from which on falls are reported.
const OTHER: f64 = 2.0;
/// Factor from the median within which the middle half of the falls must lie.
const ALIKE: f64 = 1.08;
/// Frames in falls that show a known unit, and another one.
const FEWEST: (u64, u64) = (2, 10);
/// Accelerations over gravity that friction, springs, wheels and eased keys have too. Without a likely unit
/// they show nothing.
const ODD: (f64, f64) = (0.2, 5.0);
/// What the falls of bodies say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Falls {
    /// Nothing.
    Unknown,
    /// The units are right.
    Agree,
    /// Their acceleration is another [m/s²].
    Differ(f64),
}

/// Holds falls against gravity [m/s²].
pub(crate) fn judge(falls: &FallSpeeds, gravity: f64) -> Falls {
    let frames = falls.frames();
    let quartiles = [0.25, 0.5, 0.75].map(|share| falls.quantile(share));
    let [Some(low), Some(median), Some(high)] = quartiles else { return Falls::Unknown };
    if !gravity.is_normal() {
        return Falls::Unknown;
    }
    if falls.near(gravity, AGREES.1).0 as f64 >= AGREES.0 * frames as f64 {
        return Falls::Agree;
    }
    let is_alike = median <= ALIKE * low && high <= ALIKE * median;
    let is_other = !(gravity / OTHER..=gravity * OTHER).contains(&median);
    if is_alike && is_other && frames >= FEWEST.0 {
        Falls::Differ(falls.near(median, ALIKE).1)
    } else {
        Falls::Unknown
    }
}

/// The unit that the falls of one body show, while its file is read.
pub(crate) fn unit_of_body(falls: &FreeFalls, gravity: f64, units: FileUnits) -> Option<LikelyUnit> {
    match judge(falls.along(FallsAlong::Gravity), gravity) {
        Falls::Differ(acceleration) => likely_unit(acceleration / gravity, units),
        _ => None,
    }
}

/// The unit of length that the last three frames of a body show, if they fall along gravity [m/s²].
pub(crate) fn unit_of_frames(frames: [&Frame; 3], gravity: DVec3, units: FileUnits) -> Option<LikelyUnit> {
    let [a, b, c] = frames;
    let velocity = |from: &Frame, to: &Frame| (to.pose.position - from.pose.position) / (to.time - from.time);
    let acceleration = 2.0 * (velocity(b, c) - velocity(a, b)) / (c.time - a.time);
    let ratio = acceleration.dot(gravity) / gravity.length_squared();
    let is_fall =
        ratio > 0.0 && (acceleration - gravity * ratio).length() <= SAME_UNIT * acceleration.length();
    let unit = is_fall.then(|| likely_unit(ratio, units)).flatten();
    unit.filter(LikelyUnit::makes_faster)
}

/// A file whose bodies fall in another way than the scene.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FallWarning {
    file: PathBuf,
    body: String,
    row: u64,
    along: FallsAlong,
    /// [m/s²].
    acceleration: f64,
    /// [m/s²].
    gravity: f64,
    unit: Option<LikelyUnit>,
}

impl fmt::Display for FallWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let FallWarning { file, body, row, along, acceleration, gravity, unit } = self;
        let number = |value: f64| readable(rounded(value, 3));
        let direction = match along {
            FallsAlong::Gravity => "",
            FallsAlong::MinusZ => " along -z",
            FallsAlong::PlusZ => " along +z",
        };
        write!(
            f,
            "{}, row {row}: {body} falls{direction} with {} m/s², the gravity of the scene is {} m/s²",
            file.display(),
            number(*acceleration),
            number(*gravity)
        )?;
        match along {
            FallsAlong::Gravity => {}
            FallsAlong::MinusZ => write!(f, "; the file seems to have z up, which --up z turns")?,
            FallsAlong::PlusZ => write!(f, "; the file seems to have y up: leave out --up z")?,
        }
        match unit {
            Some(unit) => write!(f, "; {unit}"),
            None if (acceleration / gravity - 1.0).abs() < AGREES.1 - 1.0 => Ok(()),
            None => write!(
                f,
                ", {} times as much; its unit of time or length may be another (--time-scale, --scale), \
                 or its gravity, which the scene should then have, or it is in slow motion; impacts are \
                 found by the gravity of the scene",
                number(acceleration / gravity)
            ),
        }
    }
}

/// A body, its file and its falls.
pub(crate) struct FallingBody<'a> {
    /// The file.
    pub(crate) file: &'a Path,
    /// Name of the body.
    pub(crate) name: &'a str,
    /// Its falls.
    pub(crate) falls: &'a FreeFalls,
}

/// What is wrong with the falls of each file, under a gravity [m/s²], read in these units; `is_turned` says
/// that z became y.
pub(crate) fn fall_warnings(
    bodies: &[FallingBody<'_>],
    gravity: f64,
    units: FileUnits,
    is_turned: bool,
) -> Vec<FallWarning> {
    let mut files: Vec<&Path> = bodies.iter().map(|body| body.file).collect();
    files.sort_unstable();
    files.dedup();
    let warning = |file: &Path| {
        let own = || bodies.iter().filter(|body| body.file == file);
        let [fall, minus, plus] = FallsAlong::ALL.map(|direction| {
            let mut all = FallSpeeds::default();
            own().for_each(|body| all.extend(body.falls.along(direction)));
            all
        });
        let (along, acceleration) = match judge(&fall, gravity) {
            Falls::Agree => return None,
            Falls::Differ(acceleration) => (FallsAlong::Gravity, acceleration),
            Falls::Unknown if fall.frames() > 0 => return None,
            Falls::Unknown => match (judge(&minus, gravity), judge(&plus, gravity)) {
                (Falls::Differ(acceleration), Falls::Unknown) if !is_turned => {
                    (FallsAlong::MinusZ, acceleration)
                }
                (Falls::Unknown, Falls::Differ(acceleration)) if is_turned => {
                    (FallsAlong::PlusZ, acceleration)
                }
                (Falls::Unknown, Falls::Agree) if is_turned => (FallsAlong::PlusZ, gravity),
                _ => return None,
            },
        };
        let near = |body: &FallingBody<'_>| body.falls.along(along).near(acceleration, ALIKE).0;
        let body = own().max_by_key(|body| near(body))?;
        let frames: u64 = own().map(near).sum();
        let unit = likely_unit(acceleration / gravity, units).filter(|_| acceleration != gravity);
        let ratio = acceleration / gravity;
        let is_like_gravity = along != FallsAlong::Gravity || (ODD.0..ODD.1).contains(&ratio);
        if unit.is_none() && (frames < FEWEST.1 || acceleration != gravity && is_like_gravity) {
            return None;
        }
        let (row, name) = (body.falls.along(along).first_row, body.name.into());
        Some(FallWarning { file: file.into(), body: name, row, along, acceleration, gravity, unit })
    };
    files.into_iter().filter_map(warning).collect()
}

/// Whether the falls of any file are those of the scene, under a gravity [m/s²].
pub(crate) fn any_agrees(bodies: &[FallingBody<'_>], gravity: f64) -> bool {
    bodies.iter().any(|body| judge(body.falls.along(FallsAlong::Gravity), gravity) == Falls::Agree)
}
