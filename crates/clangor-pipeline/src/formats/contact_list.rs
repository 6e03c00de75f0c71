//! Contacts that were written by hand or by a program: JSON lines (`.jsonl`), comma-separated values (`.csv`)
//! or Parquet (`.parquet`).
//!
//! One contact per line, columns named as in `docs/format/timeline.md`, bodies by name or by number. Only
//! what an impact needs must be given; the rest has a default:
//!
//! | CSV columns | JSON field | default |
//! |---|---|---|
//! | `t` | `t` | required \[s\] |
//! | `body_a` | `body_a` | required |
//! | `body_b` | `body_b` | the immovable `world` |
//! | `kind` | `kind` | `impact`; or `contact`, `constraint`, `fracture`, `sleep`, or their numbers in a
//! timeline |
//! | `point_x` `_y` `_z` | `point` | required \[m\] |
//! | `normal_x` `_y` `_z` | `normal` | required, from B to A; made a unit vector |
//! | `impulse_n` | `impulse_n` | required \[N s\] |
//! | `impulse_t_x` `_y` `_z` | `impulse_t` | 0 |
//! | `couple_x` `_y` `_z` | `couple` | 0 |
//! | `velocity_x` `_y` `_z`, or `speed` | `velocity`, or `speed` | required: relative velocity of A before,
//! or the speed of approach \[m/s\] |
//! | `depth` | `depth` | 0 |
//! | `effective_mass` | `effective_mass` | that of the bodies alone, beside poses with the joints
//! of the scene, as for 0 and NaN; above 0 of links on joints \[kg\] |
//! | `impact_id` | `impact_id` | a number of its own for each impact, 0 for other kinds |
//!
//! Parquet has the columns of CSV. CSV needs a header line; empty lines and lines that begin with `#` are
//! skipped in both. Rows may come in any order and are sorted by time.

mod csv;
mod jsonl;
mod parquet;

use std::io;
use std::path::{Path, PathBuf};

use clangor_core::body::BodyId;
use clangor_core::quantity;
use clangor_core::timeline::{ContactKind, ContactRow};
use glam::DVec3;

use crate::formats::calendar_times::remedy;
use crate::formats::column_names::listed;
use crate::formats::input_file::read_bounded;
use crate::formats::named_bodies::NamedBodies;
use crate::formats::record_table::RecordTableError;
use crate::formats::separated_values::{ValueFault, values_of};

/// Why a contact list could not be read.
#[derive(Debug, thiserror::Error)]
pub enum ContactListError {
    /// The operating system refused.
    #[error("cannot read {path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// The extension names neither format.
    #[error("{path} is no contact list; name it .jsonl, .csv or .parquet")]
    Extension {
        /// The file.
        path: PathBuf,
    },
    /// The bytes are not text.
    #[error("{path} is not UTF-8 text from byte {at} on; save it as UTF-8")]
    NotText {
        /// The file.
        path: PathBuf,
        /// Where the text ends.
        at: usize,
    },
    /// A Parquet file cannot be read.
    #[error(transparent)]
    Table(#[from] RecordTableError),
    /// A row of a Parquet file is wrong.
    #[error("{path}, row {row}: {fault}")]
    Row {
        /// The file.
        path: PathBuf,
        /// The row, from 0.
        row: usize,
        /// What is wrong there.
        fault: LineFault,
    },
    /// A line is wrong.
    #[error("{path}, line {line}: {fault}")]
    Line {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What is wrong there.
        fault: LineFault,
    },
}

/// What is wrong with a line of a contact list.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LineFault {
    /// A required value is missing.
    #[error("{column} is missing")]
    Missing {
        /// Its name.
        column: &'static str,
    },
    /// A required column that a list does not have.
    #[error("{column} is missing: {found}")]
    NoColumn {
        /// Its name.
        column: &'static str,
        /// The columns that are there.
        found: String,
    },
    /// A name that means nothing.
    #[error("column {name} is unknown; docs/format/timeline.md lists the columns{remedy}")]
    Unknown {
        /// The name.
        name: String,
        /// The column that is likely meant, or those that are missing and those that are there.
        remedy: String,
    },
    /// A line that cannot be divided into values.
    #[error(transparent)]
    Values(#[from] ValueFault),
    /// A column given twice.
    #[error("column {name} comes twice")]
    Twice {
        /// The name.
        name: String,
    },
    /// A value that is no finite number.
    #[error("{column} is {text}, not a finite number{}", remedy(column, text))]
    NotANumber {
        /// The column.
        column: &'static str,
        /// What is there.
        text: String,
    },
    /// A number beyond what its quantity can be.
    #[error("{column} is {value:e}; it must be {expected}")]
    Range {
        /// The column.
        column: &'static str,
        /// What is there.
        value: f64,
        /// What may be there.
        expected: String,
    },
    /// An impact that pulls, or an approach that recedes.
    #[error(
        "{column} is {value}, below 0; the normal points from body_b to body_a, so that an impact is positive"
    )]
    Negative {
        /// The column.
        column: &'static str,
        /// What is there.
        value: f64,
    },
    /// An impact that gives nothing.
    #[error("impulse_n is 0, but an impact has an impulse; leave the row out, or give its kind as contact")]
    NoImpulse,
    /// The same quantity in two ways.
    #[error("velocity and speed are both given; leave out one")]
    SpeedTwice,
    /// A body that does not exist.
    #[error("{column} is {text}, which is neither the name nor the number of a body{remedy}")]
    Body {
        /// The column.
        column: &'static str,
        /// What is there.
        text: String,
        /// The name that is likely meant, or nothing.
        remedy: String,
    },
    /// A kind of contact that does not exist.
    #[error("kind is {text}, none of impact, contact, constraint, fracture, sleep")]
    Kind {
        /// What is there.
        text: String,
    },
    /// A normal without direction.
    #[error("the normal is zero; it points from body_b to body_a")]
    NoNormal,
    /// More or fewer values than the header has columns.
    #[error("{}, but the header has {columns} columns", values_of(*values))]
    Width {
        /// Values on the line.
        values: usize,
        /// Columns of the header.
        columns: usize,
    },
    /// Text that is no JSON.
    #[error("at column {column}: {reason}")]
    Syntax {
        /// Place in the line, from 1.
        column: usize,
        /// What is wrong.
        reason: String,
    },
}

/// A contact of a list.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ListedContact {
    /// Its line, or its row of a Parquet file, from 0.
    pub line: usize,
    /// The contact.
    pub row: ContactRow,
    /// Whether the list names the second body: another, or the `world`.
    pub names_second: bool,
}

/// Name of the immovable surroundings, unless a body has it.
const WORLD_NAME: &str = "world";

/// Reads a contact list; the extension tells the format.
///
/// # Errors
/// [`ContactListError`] names the line and the column.
pub fn read_contact_list(path: &Path, bodies: &NamedBodies<'_>) -> Result<Vec<ContactRow>, ContactListError> {
    Ok(read_listed_contacts(path, bodies)?.into_iter().map(|listed| listed.row).collect())
}

/// As [`read_contact_list`], each row with its place in the list.
///
/// # Errors
/// [`ContactListError`] names the line and the column.
pub fn read_listed_contacts(
    path: &Path,
    bodies: &NamedBodies<'_>,
) -> Result<Vec<ListedContact>, ContactListError> {
    let entries = read_entries(path)?.and_then(|Entries { columns, rows }| {
        rows.into_iter()
            .map(|(line, entry)| {
                let names_second = entry.body_b.is_some();
                let (row, is_numbered) =
                    entry.into_row(bodies).map_err(|fault| (line, fault.in_list_of(&columns)))?;
                Ok((ListedContact { line, row, names_second }, is_numbered))
            })
            .collect::<Result<Vec<_>, _>>()
    });
    let is_table = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("parquet"));
    let rows = entries.map_err(|(line, fault)| match is_table {
        true => ContactListError::Row { path: path.into(), row: line, fault },
        false => ContactListError::Line { path: path.into(), line, fault },
    })?;
    Ok(finish(rows))
}

/// Largest list that is read \[bytes\].
const MOST_BYTES: u64 = 1 << 32;

fn read_entries(path: &Path) -> Result<Parsed, ContactListError> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    let parse = match extension.as_str() {
        "jsonl" => jsonl::parse,
        "csv" => csv::parse,
        "parquet" => return parquet::parse(path),
        _ => return Err(ContactListError::Extension { path: path.into() }),
    };
    let bytes = read_bounded(path, MOST_BYTES)
        .map_err(|source| ContactListError::Io { path: path.into(), source })?;
    let text = String::from_utf8(bytes)
        .map_err(|e| ContactListError::NotText { path: path.into(), at: e.utf8_error().valid_up_to() })?;
    // Editors of one system put a mark before the text.
    let text = text.strip_prefix('\u{FEFF}').unwrap_or(&text);
    Ok(parse(text))
}

/// Numbers the impacts that have no number yet, and sorts.
fn finish(rows: Vec<(ListedContact, bool)>) -> Vec<ListedContact> {
    let mut next = rows.iter().map(|(listed, _)| listed.row.impact_id).max().unwrap_or(0);
    let mut rows: Vec<ListedContact> = rows
        .into_iter()
        .map(|(mut listed, is_numbered)| {
            if !is_numbered && listed.row.kind == ContactKind::Impact {
                next = next.saturating_add(1);
                listed.row.impact_id = next;
            }
            listed
        })
        .collect();
    rows.sort_by(|a, b| a.row.time.total_cmp(&b.row.time));
    rows
}

/// A line before its defaults are filled in.
#[derive(Default)]
struct Entry {
    t: Option<f64>,
    body_a: Option<String>,
    body_b: Option<String>,
    kind: Option<String>,
    point: [Option<f64>; 3],
    normal: [Option<f64>; 3],
    impulse_n: Option<f64>,
    impulse_t: [Option<f64>; 3],
    couple: [Option<f64>; 3],
    velocity: [Option<f64>; 3],
    speed: Option<f64>,
    depth: Option<f64>,
    effective_mass: Option<f64>,
    impact_id: Option<u64>,
}

/// Lines with their numbers, or the first wrong line.
type Parsed = Result<Entries, (usize, LineFault)>;

/// The lines of a list.
#[derive(Default)]
struct Entries {
    /// Names of its columns; none of JSON lines.
    columns: Vec<&'static str>,
    rows: Vec<(usize, Entry)>,
}

impl LineFault {
    /// The same of a list with these columns.
    fn in_list_of(self, columns: &[&'static str]) -> Self {
        match self {
            LineFault::Missing { column }
                if !columns.is_empty() && !columns.iter().any(|name| is_part_of(name, column)) =>
            {
                LineFault::NoColumn {
                    column,
                    found: format!("there are {}", listed(columns.iter().copied())),
                }
            }
            other => other,
        }
    }
}

/// Whether a column holds a quantity or a component of it.
fn is_part_of(name: &str, quantity: &str) -> bool {
    let component = name.strip_prefix(quantity).and_then(|rest| rest.strip_prefix('_'));
    name == quantity || component.is_some_and(|axis| ["x", "y", "z"].contains(&axis))
}

impl Entry {
    /// The row, and whether its impact was numbered.
    fn into_row(self, bodies: &NamedBodies<'_>) -> Result<(ContactRow, bool), LineFault> {
        let find = |column: &'static str, text: &str| {
            let wrong = || LineFault::Body { column, text: text.into(), remedy: bodies.meant(text) };
            bodies.find(text).ok_or_else(wrong)
        };
        let body_a = find("body_a", self.body_a.as_deref().ok_or(LineFault::Missing { column: "body_a" })?)?;
        let body_b = match self.body_b.as_deref() {
            None => BodyId::WORLD,
            Some(WORLD_NAME) if !bodies.has(WORLD_NAME) => BodyId::WORLD,
            Some(text) if text.parse() == Ok(BodyId::WORLD.0) => BodyId::WORLD,
            Some(text) => find("body_b", text)?,
        };
        let kind = match self.kind.as_deref().unwrap_or("impact") {
            "impact" => ContactKind::Impact,
            "contact" => ContactKind::Contact,
            "constraint" => ContactKind::Constraint,
            "fracture" => ContactKind::Fracture,
            "sleep" => ContactKind::Sleep,
            other => {
                let code = other.parse().ok().and_then(ContactKind::from_code);
                code.ok_or_else(|| LineFault::Kind { text: other.into() })?
            }
        };
        let needed = |column, value: Option<f64>| value.ok_or(LineFault::Missing { column });
        let normal = needed_vector("normal", self.normal)?;
        // The length of the largest component is taken out first, so that no square over- or underflows.
        let largest = normal.abs().max_element();
        let normal = (normal / largest).try_normalize().ok_or(LineFault::NoNormal)?;
        let impulse_n = needed("impulse_n", self.impulse_n)?;
        let pushes = [("impulse_n", impulse_n), ("speed", self.speed.unwrap_or(0.0))];
        if kind == ContactKind::Impact
            && let Some((column, value)) = pushes.into_iter().find(|(_, value)| *value < 0.0)
        {
            return Err(LineFault::Negative { column, value });
        }
        if kind == ContactKind::Impact && impulse_n == 0.0 {
            return Err(LineFault::NoImpulse);
        }
        let velocity = match self.speed {
            Some(_) if self.velocity != [None; 3] => return Err(LineFault::SpeedTwice),
            Some(speed) => normal * -speed,
            None if self.velocity == [None; 3] => {
                return Err(LineFault::Missing { column: "velocity or speed" });
            }
            None => needed_vector("velocity", self.velocity)?,
        };
        let row = ContactRow {
            time: needed("t", self.t)?,
            body_a,
            body_b,
            kind,
            point: needed_vector("point", self.point)?,
            normal,
            impulse_n,
            impulse_t: vector_or_zero("impulse_t", self.impulse_t)?,
            couple: vector_or_zero("couple", self.couple)?,
            velocity,
            depth: self.depth.unwrap_or(0.0),
            impact_id: self.impact_id.unwrap_or(0),
            effective_mass: self.effective_mass.filter(|mass| !mass.is_nan() && *mass != 0.0),
        };
        check_ranges(&row)?;
        Ok((row, self.impact_id.is_some()))
    }
}

/// Rejects numbers beyond the ranges of their quantities, with which sums and squares would overflow.
fn check_ranges(row: &ContactRow) -> Result<(), LineFault> {
    let vectors = [
        ("point", row.point, &quantity::COORDINATE),
        ("impulse_t", row.impulse_t, &quantity::IMPULSE),
        ("couple", row.couple, &quantity::ANGULAR_IMPULSE),
        ("velocity", row.velocity, &quantity::VELOCITY),
    ];
    let numbers =
        [("impulse_n", row.impulse_n, &quantity::IMPULSE), ("depth", row.depth, &quantity::COORDINATE)];
    let mass = row.effective_mass.map(|mass| ("effective_mass", mass, &quantity::EFFECTIVE_MASS));
    let components = vectors.into_iter().flat_map(|(column, vector, range)| {
        vector.to_array().into_iter().map(move |value| (column, value, range))
    });
    match components.chain(numbers).chain(mass).find(|(_, value, range)| !range.admits(*value)) {
        Some((column, value, range)) => Err(LineFault::Range { column, value, expected: range.expected() }),
        None => Ok(()),
    }
}

fn needed_vector(column: &'static str, values: [Option<f64>; 3]) -> Result<DVec3, LineFault> {
    match values {
        [Some(x), Some(y), Some(z)] => Ok(DVec3::new(x, y, z)),
        _ => Err(LineFault::Missing { column }),
    }
}

/// A vector may be left out, but not one of its components.
fn vector_or_zero(column: &'static str, values: [Option<f64>; 3]) -> Result<DVec3, LineFault> {
    if values == [None; 3] { Ok(DVec3::ZERO) } else { needed_vector(column, values) }
}
