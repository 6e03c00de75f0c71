//! The columns of both tables: each ties a name and a type in the file to a field of a row.

use clangor::body::BodyId;
use clangor::timeline::{ContactKind, ContactRow, PoseRow};
use glam::{DQuat, DVec3};

use super::{RowProblem, resolution};

/// A column of a table of `R`.
pub(super) struct Column<R> {
    pub(super) name: &'static str,
    pub(super) field: Field<R>,
}

/// How a column is stored, and the field behind it: how to get it from a row and how to set it.
pub(super) enum Field<R> {
    F64(fn(&R) -> f64, fn(&mut R, f64)),
    F32(fn(&R) -> f64, fn(&mut R, f64)),
    U32(fn(&R) -> u32, fn(&mut R, u32)),
    U64(fn(&R) -> u64, fn(&mut R, u64)),
    /// The kind of a contact; setting it fails for a code that is none.
    Kind(fn(&R) -> u8, fn(&mut R, u8) -> bool),
}

/// A row that is stored as a table. Two are: contacts and poses.
pub(super) trait TableRow: Copy + 'static {
    /// The columns, in the order of the file.
    fn columns() -> Vec<Column<Self>>;
    /// A row to set the fields of.
    const BLANK: Self;
    /// Time \[s\].
    fn time(&self) -> f64;
    /// The row as the file keeps it, before rounding to 32 bits.
    fn stored(&self) -> Self;
    /// What columns alone cannot check.
    fn check(&self, bodies: usize) -> Result<(), RowProblem>;
}

/// A column of 32-bit floats.
macro_rules! float {
    ($name:literal, $($field:tt)+) => {
        Column { name: $name, field: Field::F32(|r| r.$($field)+, |r, v| r.$($field)+ = v) }
    };
}

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
    };

    fn time(&self) -> f64 {
        self.time
    }

    fn stored(&self) -> Self {
        resolution::stored(self)
    }

    fn check(&self, bodies: usize) -> Result<(), RowProblem> {
        if self.body_a.index() >= bodies {
            return Err(RowProblem::Body { column: "body_a", body: self.body_a.0, bodies });
        }
        if self.body_b != BodyId::WORLD && self.body_b.index() >= bodies {
            return Err(RowProblem::Body { column: "body_b", body: self.body_b.0, bodies });
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

    fn check(&self, bodies: usize) -> Result<(), RowProblem> {
        if self.body.index() >= bodies {
            return Err(RowProblem::Body { column: "body", body: self.body.0, bodies });
        }
        check_unit("orientation", self.orientation.length_squared())
    }
}

fn check_unit(column: &'static str, length_squared: f64) -> Result<(), RowProblem> {
    if (length_squared - 1.0).abs() <= 2.0 * UNIT_TOLERANCE {
        Ok(())
    } else {
        Err(RowProblem::NotUnit { column, length: length_squared.sqrt() })
    }
}
