//! JSON lines: one object per line, vectors as lists of three numbers, bodies as names or numbers.

use serde::Deserialize;
use serde::de::IgnoredAny;

use super::{Entries, Entry, LineFault, Parsed};
use crate::formats::calendar_times::remedy;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Fields {
    t: f64,
    body_a: BodyField,
    body_b: Option<BodyField>,
    kind: Option<String>,
    point: [f64; 3],
    normal: [f64; 3],
    impulse_n: f64,
    impulse_t: Option<[f64; 3]>,
    couple: Option<[f64; 3]>,
    velocity: Option<[f64; 3]>,
    speed: Option<f64>,
    depth: Option<f64>,
    effective_mass: Option<f64>,
    impact_id: Option<u64>,
    /// The number of the row, as pandas has it.
    #[serde(rename = "__index_level_0__")]
    _row_number: Option<IgnoredAny>,
}

#[derive(Deserialize)]
#[serde(untagged, expecting = "expected the name or the number of a body")]
enum BodyField {
    Number(u32),
    Name(String),
}

impl From<BodyField> for String {
    fn from(field: BodyField) -> Self {
        match field {
            BodyField::Number(number) => number.to_string(),
            BodyField::Name(name) => name,
        }
    }
}

pub(super) fn parse(text: &str) -> Parsed {
    let mut entries = Vec::new();
    for (index, line) in text.lines().enumerate() {
        if line.trim().is_empty() || line.starts_with('#') {
            continue;
        }
        let fields = serde_json::from_str(line).map_err(|e| (index + 1, fault(&e)))?;
        entries.push((index + 1, entry(fields)));
    }
    Ok(Entries { columns: Vec::new(), rows: entries })
}

fn entry(fields: Fields) -> Entry {
    let vector = |v: Option<[f64; 3]>| v.map_or([None; 3], |v| v.map(Some));
    Entry {
        t: Some(fields.t),
        body_a: Some(fields.body_a.into()),
        body_b: fields.body_b.map(String::from),
        kind: fields.kind,
        point: fields.point.map(Some),
        normal: fields.normal.map(Some),
        impulse_n: Some(fields.impulse_n),
        impulse_t: vector(fields.impulse_t),
        couple: vector(fields.couple),
        velocity: vector(fields.velocity),
        speed: fields.speed,
        depth: fields.depth,
        effective_mass: fields.effective_mass,
        impact_id: fields.impact_id,
    }
}

fn fault(error: &serde_json::Error) -> LineFault {
    // The line that serde_json counts is always the first; the caller adds ours.
    let text = error.to_string();
    let reason = text.rsplit_once(" at line ").map_or(text.as_str(), |(reason, _)| reason);
    LineFault::Syntax { column: error.column(), reason: format!("{reason}{}", remedy("t", reason)) }
}
