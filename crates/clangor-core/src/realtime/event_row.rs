//! An event as a row of [`ROW`] numbers, for programs that cannot exchange Rust values: the page, its
//! WebAssembly module, and replay files.
//!
//! [`FIELDS`] and [`KINDS`] are the one description of the layout. [`RowEncoder`] and [`RowDecoder`] use its
//! offsets; `clangor-web` writes the page's `event-layout.js` from it. SI units.
//!
//! A force history takes several rows ([`force_rows`]), before the first impact that has it and of its time.
//! The number of a history follows from its content: rows of several senders, or parts of a list of rows,
//! can be joined.

pub mod force_rows;

use glam::{DQuat, DVec3};

use self::force_rows::{ForceTable, number_of};
use super::event::{Event, ImpactEvent, ImpactTarget};
use crate::pose::Pose;

/// Numbers of a row.
pub const ROW: usize = 25;

/// A field of the row: name, first index, content.
pub type Field = (&'static str, usize, &'static str);

/// A kind of event: name, number, content.
pub type Kind = (&'static str, f64, &'static str);

const KIND: usize = 0;
const TIME: usize = 1;
const DURATION: usize = 2;
const RADIUS: usize = 3;
const SLOT: usize = 3;
const CENTRE: usize = 4;
const ORIENTATION: usize = 7;
const VELOCITY_CHANGE: usize = 11;
const ANGULAR_VELOCITY_CHANGE: usize = 14;
const POINT: usize = 17;
const IMPULSE: usize = 20;
const BODY: usize = 23;
const HISTORY: usize = 24;
const COUNT: usize = 2;
const START: usize = 3;
const STEP: usize = 4;
const FIRST: usize = 5;
const SAMPLES: usize = 6;

/// The fields of a row. Vectors take three numbers, quaternions four.
pub const FIELDS: [Field; 18] = [
    ("kind", KIND, "One of `EVENT_KIND`."),
    ("time", TIME, "Time [s], on the clock of the holder of the event."),
    ("duration", DURATION, "Duration of the force [s]."),
    ("radius", RADIUS, "Radius [m] of a sphere."),
    ("slot", SLOT, "Slot of a loaded object, in the place of the radius."),
    ("centre", CENTRE, "Centre of mass [m], 3 numbers."),
    ("orientation", ORIENTATION, "Quaternion x, y, z, w."),
    ("velocityChange", VELOCITY_CHANGE, "Change of the velocity [m/s], 3 numbers; of a pose the velocity."),
    (
        "angularVelocityChange",
        ANGULAR_VELOCITY_CHANGE,
        "Change of the angular velocity [rad/s], 3 numbers; of a pose the angular velocity.",
    ),
    ("point", POINT, "Point of the impact [m], 3 numbers."),
    ("impulse", IMPULSE, "Impulse on the body [N s], 3 numbers."),
    ("body", BODY, "Number of the body; the engine ignores it."),
    ("history", HISTORY, "Number of the force history; 0 for the engine's profile."),
    ("count", COUNT, "Number of samples of a force history."),
    ("start", START, "Time of its first sample after the onset [s]."),
    ("step", STEP, "Distance of its samples [s]."),
    ("first", FIRST, "Index of the first sample of the row."),
    ("samples", SAMPLES, "Samples [1/s] of a force of unit impulse, up to 17 numbers."),
];

const SPHERE_IMPACT: f64 = 0.0;
const OBJECT_IMPACT: f64 = 1.0;
const POSE: f64 = 2.0;
const END: f64 = 3.0;
const FORCE_HISTORY: f64 = 4.0;

/// The kinds of events.
pub const KINDS: [Kind; 5] = [
    ("sphereImpact", SPHERE_IMPACT, "An impact on a sphere."),
    ("objectImpact", OBJECT_IMPACT, "An impact on a loaded object."),
    ("pose", POSE, "The motion of a loaded object from a time on."),
    ("end", END, "The end of a loaded object."),
    ("forceHistory", FORCE_HISTORY, "A part of a force history."),
];

/// Writes events as rows.
#[derive(Debug, Default)]
pub struct RowEncoder {
    /// Numbers of the histories written for the impacts of this time \[s\].
    written: (f64, Vec<f64>),
}

impl RowEncoder {
    /// The rows of an impact, a pose or an end of a body with this number: those of a force history, unless
    /// it was written for another impact of the same time, and that of the event. Empty for other events.
    pub fn encode(&mut self, event: &Event, body: u32) -> Vec<[f64; ROW]> {
        let mut rows = Vec::new();
        if let Event::Impact(ImpactEvent { time, force: Some(force), .. }) = event {
            let number = number_of(force);
            if self.written.0 != *time {
                self.written = (*time, Vec::new());
            }
            if !self.written.1.contains(&number) {
                self.written.1.push(number);
                rows.extend(force_rows::rows(force, *time, body));
            }
        }
        rows.extend(encode(event, body));
        rows
    }
}

/// A decoded row.
pub enum DecodedRow {
    /// An event.
    Event(Event),
    /// A part of a force history, which the decoder keeps.
    ForceHistory,
    /// Neither: an unknown kind, or a history with bad numbers.
    Unknown,
}

/// Reads rows, and keeps the latest force histories for the impacts that have them.
#[derive(Debug, Default)]
pub struct RowDecoder {
    histories: ForceTable,
    /// Impacts without the history that they should have; the engine gives them its profile.
    pub missing: u64,
}

impl RowDecoder {
    /// Decodes a row. Numbers of events that are out of range are left to the engine, which rejects the
    /// event.
    pub fn decode(&mut self, row: &[f64; ROW]) -> DecodedRow {
        if row[KIND] == FORCE_HISTORY {
            return if self.histories.add(row) { DecodedRow::ForceHistory } else { DecodedRow::Unknown };
        }
        let Some(mut event) = decode(row) else { return DecodedRow::Unknown };
        if let Event::Impact(impact) = &mut event
            && row[HISTORY] != 0.0
        {
            impact.force = self.histories.history(row[HISTORY]);
            self.missing += u64::from(impact.force.is_none());
        }
        DecodedRow::Event(event)
    }
}

/// The row of an impact, a pose or an end of a body with this number; `None` for other events.
fn encode(event: &Event, body: u32) -> Option<[f64; ROW]> {
    let mut row = [0.0; ROW];
    row[BODY] = f64::from(body);
    match event {
        Event::Impact(impact) => {
            row[HISTORY] = impact.force.as_deref().map_or(0.0, number_of);
            (row[KIND], row[RADIUS]) = match impact.target {
                ImpactTarget::Sphere { radius } => (SPHERE_IMPACT, radius),
                ImpactTarget::Object { slot } => (OBJECT_IMPACT, slot as f64),
            };
            (row[TIME], row[DURATION]) = (impact.time, impact.duration);
            write_pose(&mut row, &impact.pose);
            write_vector(&mut row, VELOCITY_CHANGE, impact.velocity_change);
            write_vector(&mut row, ANGULAR_VELOCITY_CHANGE, impact.angular_velocity_change);
            write_vector(&mut row, POINT, impact.point);
            write_vector(&mut row, IMPULSE, impact.impulse);
        }
        Event::Pose { slot, time, pose, velocity, angular_velocity } => {
            (row[KIND], row[TIME], row[SLOT]) = (POSE, *time, *slot as f64);
            write_pose(&mut row, pose);
            write_vector(&mut row, VELOCITY_CHANGE, *velocity);
            write_vector(&mut row, ANGULAR_VELOCITY_CHANGE, *angular_velocity);
        }
        Event::End { slot, time } => {
            (row[KIND], row[TIME], row[SLOT]) = (END, *time, *slot as f64);
            write_pose(&mut row, &Pose::IDENTITY);
        }
        _ => return None,
    }
    Some(row)
}

/// The event of a row, without its history; `None` for an unknown kind.
fn decode(row: &[f64; ROW]) -> Option<Event> {
    let time = row[TIME];
    // A slot that does not exist stands for a negative number.
    let slot = if row[SLOT] >= 0.0 { row[SLOT] as usize } else { usize::MAX };
    let orientation = DQuat::from_slice(&row[ORIENTATION..]);
    let pose = Pose { position: vector(row, CENTRE), orientation };
    let impact = |target| {
        Event::Impact(ImpactEvent {
            target,
            time,
            duration: row[DURATION],
            force: None,
            pose,
            velocity_change: vector(row, VELOCITY_CHANGE),
            angular_velocity_change: vector(row, ANGULAR_VELOCITY_CHANGE),
            point: vector(row, POINT),
            impulse: vector(row, IMPULSE),
        })
    };
    match row[KIND] {
        SPHERE_IMPACT => Some(impact(ImpactTarget::Sphere { radius: row[RADIUS] })),
        OBJECT_IMPACT => Some(impact(ImpactTarget::Object { slot })),
        POSE => Some(Event::Pose {
            slot,
            time,
            pose,
            velocity: vector(row, VELOCITY_CHANGE),
            angular_velocity: vector(row, ANGULAR_VELOCITY_CHANGE),
        }),
        END => Some(Event::End { slot, time }),
        _ => None,
    }
}

fn vector(row: &[f64; ROW], at: usize) -> DVec3 {
    DVec3::from_slice(&row[at..])
}

fn write_vector(row: &mut [f64; ROW], at: usize, vector: DVec3) {
    row[at..at + 3].copy_from_slice(&vector.to_array());
}

fn write_pose(row: &mut [f64; ROW], pose: &Pose) {
    write_vector(row, CENTRE, pose.position);
    row[ORIENTATION..ORIENTATION + 4].copy_from_slice(&pose.orientation.to_array());
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::contact::ForceHistory;

    #[test]
    fn a_row_of_every_kind_is_decoded_and_encoded_unchanged() {
        for (name, kind, _) in KINDS.iter().filter(|(_, kind, _)| *kind != FORCE_HISTORY) {
            let mut row: [f64; ROW] = std::array::from_fn(|i| 1.0 + i as f64);
            (row[KIND], row[HISTORY]) = (*kind, 0.0);
            let event = decode(&row).unwrap();
            let again = encode(&event, row[BODY] as u32).unwrap();
            // A pose has no duration, point and impulse; an end has only slot and time.
            let carried = |at: usize| match *name {
                "pose" => at != DURATION && !(POINT..BODY).contains(&at),
                "end" => [KIND, TIME, SLOT, BODY].contains(&at),
                _ => true,
            };
            assert!((0..ROW).filter(|at| carried(*at)).all(|at| row[at] == again[at]), "{name}: {again:?}");
        }
        let mut row = [0.0; ROW];
        row[KIND] = 17.0;
        assert!(decode(&row).is_none() && encode(&Event::Silence, 0).is_none());
    }

    #[test]
    fn fields_fill_the_row_without_gap_or_overlap() {
        let mut starts: Vec<usize> = FIELDS[..13].iter().map(|(_, at, _)| *at).collect();
        starts.dedup();
        let sizes = [1, 1, 1, 1, 3, 4, 3, 3, 3, 3, 1, 1];
        let ends: Vec<usize> = starts.iter().zip(sizes).map(|(at, size)| at + size).collect();
        assert_eq!((&ends[..11], ends[11]), (&starts[1..], ROW));
    }

    fn impact(time: f64, force: &Arc<ForceHistory>) -> Event {
        let target = ImpactTarget::Sphere { radius: 0.01 };
        Event::Impact(ImpactEvent { force: Some(Arc::clone(force)), ..ImpactEvent::new(target, time, 1e-4) })
    }

    fn history(samples: usize) -> Arc<ForceHistory> {
        let values = (0..samples).map(|k| 1e4 / (1.0 + k as f64)).collect();
        Arc::new(ForceHistory::restored(-8e-5, 1.25e-5, values).unwrap())
    }

    /// The forces of the impacts of rows.
    fn forces(decoder: &mut RowDecoder, rows: &[[f64; ROW]]) -> Vec<Option<Arc<ForceHistory>>> {
        let force = |row| match decoder.decode(row) {
            DecodedRow::Event(Event::Impact(impact)) => Some(impact.force),
            _ => None,
        };
        rows.iter().filter_map(force).collect()
    }

    #[test]
    fn impacts_get_their_histories_back() {
        let (mut encoder, mut decoder) = (RowEncoder::default(), RowDecoder::default());
        let [short, long] = [17, 40].map(history);
        let events = [(0.1, &short), (0.1, &long), (0.1, &long), (0.2, &long)].map(|(t, f)| impact(t, f));
        let rows: Vec<_> = events.iter().flat_map(|event| encoder.encode(event, 3)).collect();
        // Rows of samples and of impacts: the long history is repeated at another time.
        assert_eq!(rows.len(), (1 + 1) + (3 + 1) + 1 + (3 + 1));
        let sent = [&short, &long, &long, &long];
        let whole = forces(&mut decoder, &rows);
        assert!(whole.iter().zip(sent).all(|(found, sent)| found.as_ref() == Some(sent)), "{whole:?}");
        assert!(Arc::ptr_eq(whole[1].as_ref().unwrap(), whole[3].as_ref().unwrap()));
        // Rows of two histories that are mixed, and a history without its middle.
        let mixed = [rows[2], rows[0], rows[3], rows[4], rows[1], rows[5]];
        assert_eq!(forces(&mut RowDecoder::default(), &mixed), whole[..2]);
        let mut decoder = RowDecoder::default();
        assert_eq!(forces(&mut decoder, &[rows[2], rows[4], rows[5]]), [None]);
        assert_eq!(decoder.missing, 1);
    }

    #[test]
    fn rows_of_bad_histories_are_unknown() {
        let rows = RowEncoder::default().encode(&impact(0.1, &history(40)), 0);
        for (at, value) in [
            (COUNT, f64::NAN),
            (COUNT, 1e9),
            (COUNT, 0.0),
            (STEP, 0.0),
            (START, f64::INFINITY),
            (FIRST, 5.0),
            (FIRST, -1.0),
            (HISTORY, f64::NAN),
        ] {
            let mut decoder = RowDecoder::default();
            let mut unknown = false;
            for mut row in rows.iter().copied().filter(|row| row[KIND] == FORCE_HISTORY) {
                row[at] = value;
                unknown |= matches!(decoder.decode(&row), DecodedRow::Unknown);
            }
            assert!(unknown, "{at}: {value}");
        }
        let mut bad = rows[1];
        bad[SAMPLES + 2] = f64::NAN;
        let mut decoder = RowDecoder::default();
        let kinds: Vec<bool> = [rows[0], bad, rows[2], rows[3]]
            .iter()
            .map(|row| !matches!(decoder.decode(row), DecodedRow::Unknown))
            .collect();
        assert_eq!((kinds, decoder.missing), (vec![true, true, false, true], 1));
    }
}
