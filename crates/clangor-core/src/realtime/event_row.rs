//! An event as a row of [`ROW`] numbers, for programs that cannot exchange Rust values: the page, its
//! WebAssembly module, and replay files.
//!
//! [`FIELDS`] and [`KINDS`] are the one description of the layout. The encoder and the decoder use its
//! offsets; `clangor-web` writes the page's `event-layout.js` from it. SI units.

use glam::{DQuat, DVec3};

use super::event::{Event, ImpactEvent, ImpactTarget};
use crate::pose::Pose;

/// Numbers of a row.
pub const ROW: usize = 24;

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

/// The fields of a row. Vectors take three numbers, quaternions four.
pub const FIELDS: [Field; 12] = [
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
];

const SPHERE_IMPACT: f64 = 0.0;
const OBJECT_IMPACT: f64 = 1.0;
const POSE: f64 = 2.0;
const END: f64 = 3.0;

/// The kinds of events.
pub const KINDS: [Kind; 4] = [
    ("sphereImpact", SPHERE_IMPACT, "An impact on a sphere."),
    ("objectImpact", OBJECT_IMPACT, "An impact on a loaded object."),
    ("pose", POSE, "The motion of a loaded object from a time on."),
    ("end", END, "The end of a loaded object."),
];

/// The row of an impact, a pose or an end of a body with this number; `None` for other events.
pub fn encode(event: &Event, body: u32) -> Option<[f64; ROW]> {
    let mut row = [0.0; ROW];
    row[BODY] = f64::from(body);
    match *event {
        Event::Impact(impact) => {
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
            (row[KIND], row[TIME], row[SLOT]) = (POSE, time, slot as f64);
            write_pose(&mut row, &pose);
            write_vector(&mut row, VELOCITY_CHANGE, velocity);
            write_vector(&mut row, ANGULAR_VELOCITY_CHANGE, angular_velocity);
        }
        Event::End { slot, time } => {
            (row[KIND], row[TIME], row[SLOT]) = (END, time, slot as f64);
            write_pose(&mut row, &Pose::IDENTITY);
        }
        _ => return None,
    }
    Some(row)
}

/// The event of a row; `None` for an unknown kind. Numbers out of range are left to the engine, which rejects
/// the event.
pub fn decode(row: &[f64; ROW]) -> Option<Event> {
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
    use super::*;

    #[test]
    fn a_row_of_every_kind_is_decoded_and_encoded_unchanged() {
        for (name, kind, _) in KINDS {
            let mut row: [f64; ROW] = std::array::from_fn(|i| 1.0 + i as f64);
            row[KIND] = kind;
            let event = decode(&row).unwrap();
            let again = encode(&event, row[BODY] as u32).unwrap();
            // A pose has no duration, point and impulse; an end has only slot and time.
            let carried = |at: usize| match name {
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
        let mut starts: Vec<usize> = FIELDS.iter().map(|(_, at, _)| *at).collect();
        starts.dedup();
        let sizes = [1, 1, 1, 1, 3, 4, 3, 3, 3, 3, 1];
        let ends: Vec<usize> = starts.iter().zip(sizes).map(|(at, size)| at + size).collect();
        assert_eq!((&ends[..10], ends[10]), (&starts[1..], ROW));
    }
}
