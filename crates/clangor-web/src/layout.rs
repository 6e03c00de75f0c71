//! Layout of the numbers that the module and the page exchange, and the page's file that describes it.
//!
//! Events are rows of [`clangor_core::realtime::event_row`]. Contacts, bodies and links are rows of `f64`,
//! poses rows of `f32`; [`CONTACT_FIELDS`] and the lengths are here. `web/src/event-layout.js` is the text of
//! [`javascript`], written by
//!
//! ```sh
//! cargo run -p clangor-web --example event-layout > web/src/event-layout.js
//! ```
//!
//! A test compares the file with the text.

use std::fmt::Write;

use clangor_core::contact::ImpactPulse;
use clangor_core::realtime::event_row::{FIELDS, Field, KINDS, ROW};

/// Numbers of a row of an event.
pub const EVENT_STRIDE: usize = ROW;
/// Numbers of a contact in [`world_contacts`](crate::world::world_contacts).
pub const CONTACT_STRIDE: usize = 12;
/// Numbers of a pose in [`world_poses`](crate::world::world_poses).
pub const POSE_STRIDE: usize = 7;
/// Numbers of a body in [`world_bodies`](crate::world::world_bodies).
pub const BODY_STRIDE: usize = 8;
/// Numbers of a rod or a spring in [`world_links`](crate::world::world_links).
pub const LINK_STRIDE: usize = 8;
/// Numbers of [`synth_report`](crate::synth::synth_report).
pub const REPORT_STRIDE: usize = 13;

/// Onset of a contact.
const CONTACT_TIME: usize = 0;
/// First body, and behind it the second.
const CONTACT_BODIES: usize = 1;
const CONTACT_SPEED: usize = 3;
const CONTACT_IMPULSE: usize = 4;
const CONTACT_DURATION: usize = 5;
const CONTACT_POINT: usize = 6;
const CONTACT_MASS: usize = 9;

/// The fields of a contact.
pub const CONTACT_FIELDS: [Field; 8] = [
    ("time", CONTACT_TIME, "Onset [s]."),
    ("bodyA", CONTACT_BODIES, "Number of the first body."),
    ("bodyB", CONTACT_BODIES + 1, "Number of the second body; −1 for the immovable world."),
    ("speed", CONTACT_SPEED, "Approach speed [m/s]."),
    ("impulse", CONTACT_IMPULSE, "Normal impulse [N s]."),
    ("duration", CONTACT_DURATION, "Duration of the force [s]."),
    ("point", CONTACT_POINT, "Point of the contact [m], 3 numbers."),
    ("mass", CONTACT_MASS, "Effective mass [kg]."),
];

/// The row of the contact of an impact, between bodies of these numbers.
pub(crate) fn contact_row(pulse: &ImpactPulse, bodies: [f64; 2]) -> [f64; CONTACT_STRIDE] {
    let impulse: f64 = pulse.points.iter().map(|(_, j)| j.dot(pulse.normal)).sum();
    let mut row = [0.0; CONTACT_STRIDE];
    row[CONTACT_TIME] = pulse.onset;
    row[CONTACT_BODIES..][..2].copy_from_slice(&bodies);
    (row[CONTACT_SPEED], row[CONTACT_IMPULSE]) = (pulse.speed, impulse);
    (row[CONTACT_DURATION], row[CONTACT_MASS]) = (pulse.duration, pulse.effective_mass);
    row[CONTACT_POINT..][..3].copy_from_slice(&pulse.point.to_array());
    row
}

/// The text of `web/src/event-layout.js`.
pub fn javascript() -> String {
    let mut text = String::from(
        "// Layout of the rows of numbers that wasm module, worker, worklet and page exchange.\n\
         // SI units. Generated from crates/clangor-web/src/layout.rs; do not edit:\n\
         //   cargo run -p clangor-web --example event-layout > web/src/event-layout.js\n",
    );
    stride(&mut text, "EVENT_STRIDE", "Numbers per row of an event (f64).", EVENT_STRIDE);
    let events = FIELDS.iter().map(|(name, at, content)| (*name, *at as f64, *content));
    table(&mut text, "EVENT", "Offsets within an event.", events);
    table(&mut text, "EVENT_KIND", "Kinds of events.", KINDS);
    stride(&mut text, "CONTACT_STRIDE", "Numbers per contact (f64).", CONTACT_STRIDE);
    let contacts = CONTACT_FIELDS.iter().map(|(name, at, content)| (*name, *at as f64, *content));
    table(&mut text, "CONTACT", "Offsets within a contact.", contacts);
    let pose = "Numbers per pose (f32): position [m], then quaternion x, y, z, w.";
    stride(&mut text, "POSE_STRIDE", pose, POSE_STRIDE);
    stride(&mut text, "BODY_STRIDE", "Numbers per body (f64).", BODY_STRIDE);
    stride(&mut text, "LINK_STRIDE", "Numbers per rod or spring (f64).", LINK_STRIDE);
    stride(&mut text, "REPORT_STRIDE", "Numbers of the report of the synthesis (f64).", REPORT_STRIDE);
    text
}

fn stride(text: &mut String, name: &str, content: &str, value: usize) {
    // Writing to a string cannot fail.
    let _ = write!(text, "\n/** {content} */\nexport const {name} = {value};\n");
}

fn table(
    text: &mut String,
    name: &str,
    content: &str,
    rows: impl IntoIterator<Item = (&'static str, f64, &'static str)>,
) {
    let _ = write!(text, "\n/** {content} */\nexport const {name} = {{\n");
    for (field, value, content) in rows {
        let _ = write!(text, "  /** {content} */\n  {field}: {value},\n");
    }
    text.push_str("};\n");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_file_of_the_page_is_up_to_date() {
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../web/src/event-layout.js");
        let text = std::fs::read_to_string(file).unwrap();
        let command = "cargo run -p clangor-web --example event-layout > web/src/event-layout.js";
        assert!(text == javascript(), "web/src/event-layout.js is out of date: {command}");
    }
}
