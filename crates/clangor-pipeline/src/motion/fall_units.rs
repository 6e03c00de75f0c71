//! Whether the times and lengths of a recording are in seconds and metres, told by how its bodies fall.
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

use super::free_falls::{FallSpeeds, FallsAlong, FreeFalls};
use super::recording::{Frame, LengthUnit, TimeUnit};

/// Share of the falls that agree with gravity from which on the units are right, and the factor within which
/// they agree.
const AGREES: (f64, f64) = (0.1, 1.25);
/// Factor from the gravity of the scene from which on falls are told.
const OTHER: f64 = 2.0;
/// Factor from the median within which the middle half of the falls must lie.
const ALIKE: f64 = 1.08;
/// Share by which a unit may differ from one that is known.
const SAME_UNIT: f64 = 0.02;
/// Frames in falls that tell of a known unit, and of another one.
const FEWEST: (u64, u64) = (2, 10);
/// Frames in a second of which a number of the frame is taken for a time.
const FRAME_RATES: [f64; 12] = [24.0, 25.0, 30.0, 48.0, 50.0, 60.0, 90.0, 100.0, 120.0, 144.0, 200.0, 240.0];
/// Units of length \[m\].
const LENGTHS: [(f64, &str); 5] =
    [(1.0, "metres"), (0.01, "centimetres"), (0.001, "millimetres"), (0.0254, "inches"), (0.3048, "feet")];
/// Units of time \[s\].
const TIMES: [(f64, &str); 3] = [(1.0, "seconds"), (1e-3, "milliseconds"), (1e-6, "microseconds")];

/// Units in which files are read.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FileUnits {
    /// Of length.
    pub length: LengthUnit,
    /// Of time.
    pub time: TimeUnit,
}

/// The unit that a file seems to have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LikelyUnit {
    /// Of length: metres, and its name.
    Length(f64, &'static str),
    /// Of time: seconds, and its name.
    Time(f64, &'static str),
    /// The times are numbers of frames, so many in a second.
    Frames(f64),
}

impl fmt::Display for LikelyUnit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            LikelyUnit::Length(1.0, _) => write!(f, "its lengths seem to be in metres: leave out --scale"),
            LikelyUnit::Time(1.0, _) => write!(f, "its times seem to be in seconds: leave out --time-scale"),
            LikelyUnit::Length(metres, name) => {
                write!(f, "its lengths seem to be in {name}: import it with --scale {metres}")
            }
            LikelyUnit::Time(seconds, name) => {
                write!(f, "its times seem to be in {name}: import it with --time-scale {seconds}")
            }
            LikelyUnit::Frames(rate) => write!(
                f,
                "its times seem to be the numbers of frames, {rate} in a second: import it with --time-scale \
                 1/{rate}"
            ),
        }
    }
}

impl LikelyUnit {
    /// Whether the unit makes speeds too large as they are: one of length, or a time that was scaled.
    pub(crate) fn makes_faster(&self) -> bool {
        matches!(self, LikelyUnit::Length(..) | LikelyUnit::Time(1.0, _))
    }
}

/// The unit in which a file would fall as the scene does, that falls `ratio` times as fast in these units.
pub(crate) fn likely_unit(ratio: f64, units: FileUnits) -> Option<LikelyUnit> {
    let is_near = |value: f64, known: f64| (value / known - 1.0).abs() <= SAME_UNIT;
    let (metres, seconds) = (units.length.metres / ratio, units.time.seconds * ratio.sqrt());
    let time = TIMES.into_iter().find(|(known, _)| is_near(seconds, *known));
    let length = LENGTHS.into_iter().find(|(known, _)| is_near(metres, *known));
    let rate = FRAME_RATES.into_iter().find(|rate| is_near(seconds, rate.recip()));
    // An option that was given is doubted first.
    let doubted = [
        length.filter(|(known, _)| *known == 1.0).map(|(known, name)| LikelyUnit::Length(known, name)),
        time.map(|(known, name)| LikelyUnit::Time(known, name)),
        length.map(|(known, name)| LikelyUnit::Length(known, name)),
        rate.map(LikelyUnit::Frames),
    ];
    doubted.into_iter().flatten().next()
}

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

/// The unit that the falls of one body tell, while its file is read.
pub(crate) fn unit_of_body(falls: &FreeFalls, gravity: f64, units: FileUnits) -> Option<LikelyUnit> {
    match judge(falls.along(FallsAlong::Gravity), gravity) {
        Falls::Differ(acceleration) => likely_unit(acceleration / gravity, units),
        _ => None,
    }
}

/// The unit of length that the last three frames of a body tell, if they fall along gravity [m/s²].
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
        if unit.is_none() && frames < FEWEST.1 {
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
