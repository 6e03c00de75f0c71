//! Whether the times of a list of contacts are in seconds, compared with the duration of its scene.
//!
//! ```text
//! t_last > 100 T        milliseconds of a list that is as long as a tenth of the scene
//! t_last > 5 T, all times whole        numbers of frames, or of steps
//! ```
//!
//! A warning, no error: in a scene with the default duration, whole times up to the first limit may be
//! seconds, and are not reported. Lists that come with a recording are held against its own clock instead
//! (`contact_checks`).

use std::fmt;

use clangor_core::scene::simulation_description::SimulationDescription;

use crate::formats::contact_list::ListedContact;

/// Durations of the scene from which on a list is too long, and from which on one with whole times is.
const TOO_LONG: (f64, f64) = (100.0, 5.0);
/// Fewest contacts whose times are whole by no chance.
const FEWEST: usize = 4;

/// A list that lasts far longer than its scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LongClock {
    row: usize,
    last: f64,
    duration: f64,
    is_whole: bool,
}

/// Holds a list, in order of time, against a scene of this duration \[s\].
pub(crate) fn long_clock(rows: &[ListedContact], duration: f64) -> Option<LongClock> {
    let ListedContact { line, row, .. } = rows.last()?;
    let is_whole = rows.len() >= FEWEST && rows.iter().all(|listed| listed.row.time.fract() == 0.0);
    let is_default = duration == SimulationDescription::default().duration;
    let most = if is_whole && !is_default { TOO_LONG.1 } else { TOO_LONG.0 };
    (row.time > most * duration).then_some(LongClock { row: *line, last: row.time, duration, is_whole })
}

impl fmt::Display for LongClock {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let LongClock { row, last, duration, is_whole } = self;
        let also = if *is_whole { "all times are whole, and " } else { "" };
        write!(
            f,
            "{also}the last contact is at t = {last} s (row {row}), but the scene lasts \
             {duration} s; t is in seconds: divide milliseconds by 1000 and frame numbers by the \
             frames per second, or set the duration of the scene"
        )
    }
}
