//! Contacts as separated values with a header.

use super::{Entries, Entry, LineFault, Parsed, is_part_of};
use crate::formats::column_names::{listed, meant};
use crate::formats::record_table::PANDAS_INDEX;
use crate::formats::separated_values::SeparatedValues;

/// Where a value of a column goes.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Column {
    Time,
    BodyA,
    BodyB,
    Kind,
    Point(usize),
    Normal(usize),
    ImpulseN,
    ImpulseT(usize),
    Couple(usize),
    Velocity(usize),
    Speed,
    Depth,
    EffectiveMass,
    ImpactId,
    /// The numbers of the rows, as pandas has them.
    RowNumber,
}

pub(super) const COLUMNS: [(&str, Column); 24] = [
    ("t", Column::Time),
    ("body_a", Column::BodyA),
    ("body_b", Column::BodyB),
    ("kind", Column::Kind),
    ("point_x", Column::Point(0)),
    ("point_y", Column::Point(1)),
    ("point_z", Column::Point(2)),
    ("normal_x", Column::Normal(0)),
    ("normal_y", Column::Normal(1)),
    ("normal_z", Column::Normal(2)),
    ("impulse_n", Column::ImpulseN),
    ("impulse_t_x", Column::ImpulseT(0)),
    ("impulse_t_y", Column::ImpulseT(1)),
    ("impulse_t_z", Column::ImpulseT(2)),
    ("couple_x", Column::Couple(0)),
    ("couple_y", Column::Couple(1)),
    ("couple_z", Column::Couple(2)),
    ("velocity_x", Column::Velocity(0)),
    ("velocity_y", Column::Velocity(1)),
    ("velocity_z", Column::Velocity(2)),
    ("speed", Column::Speed),
    ("depth", Column::Depth),
    ("effective_mass", Column::EffectiveMass),
    ("impact_id", Column::ImpactId),
];

pub(super) fn parse(text: &str) -> Parsed {
    let mut header: Option<(SeparatedValues, Vec<(&'static str, Column)>)> = None;
    let mut entries = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let number = index + 1;
        if line.trim().is_empty() || line.starts_with('#') {
            continue;
        }
        let wrong = |fault| (number, fault);
        let divided = |fault| (number, LineFault::from(fault));
        match &mut header {
            None => {
                let (lines, names) = SeparatedValues::of_header(line).map_err(divided)?;
                header = Some((lines, parse_header(&names).map_err(wrong)?));
            }
            Some((lines, columns)) => {
                let values = lines.next(line, number as u64).map_err(divided)?;
                entries.push((number, parse_entry(columns, &values).map_err(wrong)?));
            }
        }
    }
    let columns =
        header.map_or_else(Vec::new, |(_, columns)| columns.iter().map(|(name, _)| *name).collect());
    Ok(Entries { columns, rows: entries })
}

pub(super) fn parse_header(names: &[String]) -> Result<Vec<(&'static str, Column)>, LineFault> {
    let mut columns: Vec<(&'static str, Column)> = Vec::new();
    for name in names {
        if name == PANDAS_INDEX {
            columns.push((PANDAS_INDEX, Column::RowNumber));
            continue;
        }
        let known = COLUMNS.iter().find(|(known, _)| known == name);
        let unknown = || LineFault::Unknown { name: name.clone(), remedy: remedy(name, names) };
        let (name, column) = *known.ok_or_else(unknown)?;
        if columns.iter().any(|(_, c)| *c == column) {
            return Err(LineFault::Twice { name: name.into() });
        }
        columns.push((name, column));
    }
    Ok(columns)
}

/// What every list needs, besides a velocity or speed.
const NEEDED: [&str; 5] = ["t", "body_a", "point", "normal", "impulse_n"];

/// What to do about a name that means nothing among the names of a list.
pub(super) fn remedy(unknown: &str, names: &[String]) -> String {
    let free = COLUMNS.iter().map(|(known, _)| *known).filter(|known| !names.iter().any(|n| n == known));
    let meant = meant(unknown, free);
    if !meant.is_empty() {
        return meant;
    }
    let is_missing = |needed: &&&str| !names.iter().any(|name| is_part_of(name, needed));
    let missing: Vec<&str> = NEEDED.iter().filter(is_missing).copied().collect();
    match missing.is_empty() {
        true => String::new(),
        false => {
            let there = listed(names.iter().map(String::as_str));
            format!("; {} missing, there are {there}", are(&missing))
        }
    }
}

fn are(names: &[&str]) -> String {
    format!("{} {}", names.join(", "), if names.len() == 1 { "is" } else { "are" })
}

pub(super) fn parse_entry(columns: &[(&'static str, Column)], values: &[String]) -> Result<Entry, LineFault> {
    if values.len() != columns.len() {
        return Err(LineFault::Width { values: values.len(), columns: columns.len() });
    }
    let mut entry = Entry::default();
    for ((name, column), text) in columns.iter().zip(values) {
        // An empty value is one left out.
        if text.is_empty() {
            continue;
        }
        let wrong = || LineFault::NotANumber { column: name, text: text.clone() };
        let number = || text.parse().ok().filter(|v: &f64| v.is_finite()).ok_or_else(wrong);
        match *column {
            Column::Time => entry.t = Some(number()?),
            Column::BodyA => entry.body_a = Some(text.clone()),
            Column::BodyB => entry.body_b = Some(text.clone()),
            Column::Kind => entry.kind = Some(text.clone()),
            Column::Point(axis) => entry.point[axis] = Some(number()?),
            Column::Normal(axis) => entry.normal[axis] = Some(number()?),
            Column::ImpulseN => entry.impulse_n = Some(number()?),
            Column::ImpulseT(axis) => entry.impulse_t[axis] = Some(number()?),
            Column::Couple(axis) => entry.couple[axis] = Some(number()?),
            Column::Velocity(axis) => entry.velocity[axis] = Some(number()?),
            Column::Speed => entry.speed = Some(number()?),
            Column::Depth => entry.depth = Some(number()?),
            // Tables write NaN for none.
            Column::EffectiveMass => {
                let mass = text.parse().ok().filter(|v: &f64| !v.is_infinite()).ok_or_else(wrong)?;
                entry.effective_mass = Some(mass);
            }
            Column::ImpactId => entry.impact_id = Some(text.parse().map_err(|_| wrong())?),
            Column::RowNumber => {}
        }
    }
    Ok(entry)
}
