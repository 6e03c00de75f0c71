//! The columns of the tables: each ties a name and a type in the file to a field of a row.

use clangor_core::body::{BodyId, Life};
use clangor_core::quantity::EFFECTIVE_MASS;
use clangor_core::timeline::{ContactKind, ContactRow, FractureRow, PoseRow};
use glam::{DQuat, DVec3};

use super::error::RowProblem;
use super::resolution;

/// A column of a table of `R`.
pub(super) struct Column<R> {
    pub(super) name: &'static str,
    pub(super) field: Field<R>,
}

/// Columns of earlier versions of the format that have been renamed: the former name and the present one.
const FORMER_NAMES: &[(&str, &str)] = &[("blow_energy", "impact_energy")];

impl<R> Column<R> {
    /// Whether a table may lack it.
    pub(super) fn is_optional(&self) -> bool {
        matches!(self.field, Field::OptionalF32(..))
    }

    /// Whether a row has a value that a table without this optional column would lose.
    pub(super) fn is_needed_by(&self, row: &R) -> bool {
        matches!(self.field, Field::OptionalF32(get, _) if get(row).is_some())
    }

    /// Whether a column of a file is this one, under its name or the one that it had before.
    pub(super) fn is_named(&self, found: &str) -> bool {
        found == self.name || FORMER_NAMES.contains(&(found, self.name))
    }
}

/// How a column is stored, and the field behind it: how to get it from a row and how to set it.
pub(super) enum Field<R> {
    F64(fn(&R) -> f64, fn(&mut R, f64)),
    F32(fn(&R) -> f64, fn(&mut R, f64)),
    /// A 32-bit float that a row, or the whole table, may lack; 0 and NaN are read as none.
    OptionalF32(fn(&R) -> Option<f64>, fn(&mut R, Option<f64>)),
    U32(fn(&R) -> u32, fn(&mut R, u32)),
    U64(fn(&R) -> u64, fn(&mut R, u64)),
    /// The kind of a contact; setting it fails for a code that is none.
    Kind(fn(&R) -> u8, fn(&mut R, u8) -> bool),
}

/// A row that is stored as a table: contacts, poses, fractures, forces and their samples.
pub(super) trait TableRow: Copy + 'static {
    /// The columns, in the order of the file.
    fn columns() -> Vec<Column<Self>>;
    /// A row to set the fields of.
    const BLANK: Self;
    /// Time \[s\].
    fn time(&self) -> f64;
    /// The row as the file keeps it, before rounding to 32 bits.
    fn stored(&self) -> Self;
    /// What columns alone cannot check: `lives` are those of the bodies.
    fn check(&self, lives: &[Life]) -> Result<(), RowProblem>;
}

/// A column of 32-bit floats.
macro_rules! float {
    ($name:literal, $($field:tt)+) => {
        Column { name: $name, field: Field::F32(|r| r.$($field)+, |r, v| r.$($field)+ = v) }
    };
}

/// A column of 64-bit floats.
macro_rules! double {
    ($name:literal, $($field:tt)+) => {
        Column { name: $name, field: Field::F64(|r| r.$($field)+, |r, v| r.$($field)+ = v) }
    };
}

pub(super) use {double, float};

/// The optional column of contacts.
pub(super) const EFFECTIVE_MASS_COLUMN: &str = "effective_mass";

/// How far a stored unit vector may be from length 1: f32 rounding is 1e-7, the rest is for hand-made tables.
const UNIT_TOLERANCE: f64 = 1e-3;

impl TableRow for ContactRow {
    fn columns() -> Vec<Column<Self>> {
        vec![
            Column { name: "t", field: Field::F64(|r| r.time, |r, v| r.time = v) },
            Column { name: "body_a", field: Field::U32(|r| r.body_a.0, |r, v| r.body_a = BodyId(v)) },
            Column { name: "body_b", field: Field::U32(|r| r.body_b.0, |r, v| r.body_b = BodyId(v)) },
            Column {
                name: "kind",
                field: Field::Kind(
                    |r| r.kind as u8,
                    |r, v| ContactKind::from_code(v).map(|kind| r.kind = kind).is_some(),
                ),
            },
            float!("point_x", point.x),
            float!("point_y", point.y),
            float!("point_z", point.z),
            float!("normal_x", normal.x),
            float!("normal_y", normal.y),
            float!("normal_z", normal.z),
            float!("impulse_n", impulse_n),
            float!("impulse_t_x", impulse_t.x),
            float!("impulse_t_y", impulse_t.y),
            float!("impulse_t_z", impulse_t.z),
            float!("couple_x", couple.x),
            float!("couple_y", couple.y),
            float!("couple_z", couple.z),
            float!("velocity_x", velocity.x),
            float!("velocity_y", velocity.y),
            float!("velocity_z", velocity.z),
            float!("depth", depth),
            Column { name: "impact_id", field: Field::U64(|r| r.impact_id, |r, v| r.impact_id = v) },
            Column {
                name: EFFECTIVE_MASS_COLUMN,
                field: Field::OptionalF32(|r| r.effective_mass, |r, v| r.effective_mass = v),
            },
        ]
    }

    const BLANK: Self = ContactRow {
        time: 0.0,
        body_a: BodyId(0),
        body_b: BodyId(0),
        kind: ContactKind::Impact,
        point: DVec3::ZERO,
        normal: DVec3::ZERO,
        impulse_n: 0.0,
        impulse_t: DVec3::ZERO,
        couple: DVec3::ZERO,
        velocity: DVec3::ZERO,
        depth: 0.0,
        impact_id: 0,
        effective_mass: None,
    };

    fn time(&self) -> f64 {
        self.time
    }

    fn stored(&self) -> Self {
        resolution::stored(self)
    }

    fn check(&self, lives: &[Life]) -> Result<(), RowProblem> {
        check_alive("body_a", self.body_a, self.time, lives)?;
        if self.body_b != BodyId::WORLD {
            check_alive("body_b", self.body_b, self.time, lives)?;
        }
        if let Some(value) = self.effective_mass.filter(|mass| !EFFECTIVE_MASS.admits(*mass)) {
            return Err(RowProblem::EffectiveMass { value });
        }
        // A link has no surface and need not have a normal.
        if self.kind == ContactKind::Constraint && self.normal == DVec3::ZERO {
            return Ok(());
        }
        check_unit("normal", self.normal.length_squared())
    }
}

impl TableRow for PoseRow {
    fn columns() -> Vec<Column<Self>> {
        vec![
            Column { name: "t", field: Field::F64(|r| r.time, |r, v| r.time = v) },
            Column { name: "body", field: Field::U32(|r| r.body.0, |r, v| r.body = BodyId(v)) },
            float!("position_x", position.x),
            float!("position_y", position.y),
            float!("position_z", position.z),
            float!("orientation_x", orientation.x),
            float!("orientation_y", orientation.y),
            float!("orientation_z", orientation.z),
            float!("orientation_w", orientation.w),
            float!("velocity_x", velocity.x),
            float!("velocity_y", velocity.y),
            float!("velocity_z", velocity.z),
            float!("angular_velocity_x", angular_velocity.x),
            float!("angular_velocity_y", angular_velocity.y),
            float!("angular_velocity_z", angular_velocity.z),
        ]
    }

    const BLANK: Self = PoseRow {
        time: 0.0,
        body: BodyId(0),
        position: DVec3::ZERO,
        orientation: DQuat::IDENTITY,
        velocity: DVec3::ZERO,
        angular_velocity: DVec3::ZERO,
    };

    fn time(&self) -> f64 {
        self.time
    }

    fn stored(&self) -> Self {
        *self
    }

    fn check(&self, lives: &[Life]) -> Result<(), RowProblem> {
        check_alive("body", self.body, self.time, lives)?;
        check_unit("orientation", self.orientation.length_squared())
    }
}

impl TableRow for FractureRow {
    fn columns() -> Vec<Column<Self>> {
        vec![
            double!("t", time),
            Column { name: "parent", field: Field::U32(|r| r.parent.0, |r, v| r.parent = BodyId(v)) },
            Column {
                name: "first_child",
                field: Field::U32(|r| r.first_child.0, |r, v| r.first_child = BodyId(v)),
            },
            Column { name: "children", field: Field::U32(|r| r.children, |r, v| r.children = v) },
            double!("impact_energy", impact_energy),
            double!("strain_energy", strain_energy),
            double!("fracture_energy", fracture_energy),
            double!("kinetic_energy_gain", kinetic_energy_gain),
            double!("crack_area", crack_area),
            double!("duration", duration),
            Column { name: "seed", field: Field::U64(|r| r.seed, |r, v| r.seed = v) },
        ]
    }

    const BLANK: Self = FractureRow::of(BodyId(0));

    fn time(&self) -> f64 {
        self.time
    }

    fn stored(&self) -> Self {
        *self
    }

    fn check(&self, lives: &[Life]) -> Result<(), RowProblem> {
        let bodies = lives.len();
        let Some(parent) = lives.get(self.parent.index()) else {
            return Err(RowProblem::Body { column: "parent", body: self.parent.0, bodies });
        };
        let first = self.first_child.index();
        let pieces = lives.get(first..first.saturating_add(self.children as usize)).unwrap_or_default();
        let born = |life: &Life| life.parent == Some(self.parent) && life.birth == self.time;
        if pieces.is_empty() || !pieces.iter().all(born) || parent.death != self.time {
            return Err(RowProblem::Pieces {
                first: self.first_child.0,
                count: self.children,
                time: self.time,
            });
        }
        Ok(())
    }
}

/// Refuses a body that is not there, or not at that time.
fn check_alive(column: &'static str, id: BodyId, time: f64, lives: &[Life]) -> Result<(), RowProblem> {
    let Some(life) = lives.get(id.index()) else {
        return Err(RowProblem::Body { column, body: id.0, bodies: lives.len() });
    };
    // A time that is not finite is refused as such.
    if life.holds(time) || !time.is_finite() {
        return Ok(());
    }
    Err(RowProblem::NotAlive { column, body: id.0, time, birth: life.birth, death: life.death })
}

fn check_unit(column: &'static str, length_squared: f64) -> Result<(), RowProblem> {
    if (length_squared - 1.0).abs() <= 2.0 * UNIT_TOLERANCE {
        Ok(())
    } else {
        Err(RowProblem::NotUnit { column, length: length_squared.sqrt() })
    }
}

#[cfg(test)]
mod tests {
    use super::super::table::reader::TableReader;
    use super::super::table::writer::TableWriter;
    use super::*;

    /// A time and the energy of impacts, the latter under the name of version 1 if `FORMER`.
    #[derive(Clone, Copy, Debug, PartialEq)]
    struct Row<const FORMER: bool> {
        time: f64,
        energy: f64,
    }

    impl<const FORMER: bool> TableRow for Row<FORMER> {
        fn columns() -> Vec<Column<Self>> {
            let name = if FORMER { "blow_energy" } else { "impact_energy" };
            let energy = Column { name, field: Field::F64(|r: &Self| r.energy, |r, v| r.energy = v) };
            vec![double!("t", time), energy]
        }

        const BLANK: Self = Row { time: 0.0, energy: 0.0 };

        fn time(&self) -> f64 {
            self.time
        }

        fn stored(&self) -> Self {
            *self
        }

        fn check(&self, _: &[Life]) -> Result<(), RowProblem> {
            Ok(())
        }
    }

    #[test]
    fn a_column_is_found_under_its_former_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("fractures.parquet");
        let mut table = TableWriter::<Row<true>>::create(&path, Vec::new(), 0.0).unwrap();
        table.push(&Row { time: 0.5, energy: 1.25 }).unwrap();
        table.finish().unwrap();
        let mut table = TableReader::<Row<false>>::open(&path, 1, Vec::new(), 0.0).unwrap();
        table.next_block().unwrap();
        assert_eq!(table.block(), [Row { time: 0.5, energy: 1.25 }]);
    }
}
