//! Units of time and length of files, and which of them explain a fall that is too fast or too slow.
//!
//! ```text
//! a / g = u²        times in units of u seconds, read as seconds
//! a / g = 1/l       lengths in units of l metres, read as metres
//! ```
//!
//! Not for two units that are wrong at once: no number separates them.

use std::fmt;

/// Share by which a unit may differ from one that is known.
pub(super) const SAME_UNIT: f64 = 0.02;
/// Frames in a second of which a number of the frame is taken for a time.
const FRAME_RATES: [f64; 12] = [24.0, 25.0, 30.0, 48.0, 50.0, 60.0, 90.0, 100.0, 120.0, 144.0, 200.0, 240.0];
/// Units of length \[m\].
const LENGTHS: [(f64, &str); 5] =
    [(1.0, "metres"), (0.01, "centimetres"), (0.001, "millimetres"), (0.0254, "inches"), (0.3048, "feet")];
/// Units of time \[s\].
const TIMES: [(f64, &str); 3] = [(1.0, "seconds"), (1e-3, "milliseconds"), (1e-6, "microseconds")];

/// Unit of length of a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LengthUnit {
    /// Its length \[m\].
    pub metres: f64,
}

impl Default for LengthUnit {
    fn default() -> Self {
        LengthUnit { metres: 1.0 }
    }
}

/// Unit of time of a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeUnit {
    /// Its length \[s\].
    pub seconds: f64,
}

impl Default for TimeUnit {
    fn default() -> Self {
        TimeUnit { seconds: 1.0 }
    }
}

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
    /// Of length: its size \[m\], and its name.
    Length(f64, &'static str),
    /// Of time: its length \[s\], and its name.
    Time(f64, &'static str),
    /// The times are numbers of frames, at this rate \[Hz\].
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
