//! From the axes and units of tables and contact lists to metres, seconds and y up.

use glam::{DQuat, DVec3};

use crate::formats::contact_list::ListedContact;
use crate::motion::recording::{LengthUnit, TimeUnit};

/// Axes and units of tables and contact lists.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FileAxes {
    /// Whether z points up, instead of y.
    pub z_up: bool,
    /// Unit of length: of places, depths and speeds. Impulses and couples are in N s and N m s.
    pub unit: LengthUnit,
    /// Unit of time. Speeds are in a unit of length per second.
    pub time_unit: TimeUnit,
}

/// The way from the axes and the unit of length of files to ours.
#[derive(Clone, Copy)]
pub(super) struct FileFrame {
    turn: DQuat,
    metres: f64,
}

impl FileAxes {
    /// Takes the rows of a list to seconds.
    pub(super) fn in_seconds(&self, rows: &mut [ListedContact]) {
        rows.iter_mut().for_each(|listed| listed.row.time *= self.time_unit.seconds);
    }

    /// Takes the rows of a list to metres and y up.
    pub(super) fn in_metres(&self, rows: &mut [ListedContact]) {
        let file = FileFrame::of(*self);
        for ListedContact { row, .. } in rows {
            for vector in [&mut row.normal, &mut row.impulse_t, &mut row.couple] {
                *vector = file.direction(*vector);
            }
            for vector in [&mut row.point, &mut row.velocity] {
                *vector = file.place(*vector);
            }
            row.depth *= self.unit.metres;
        }
    }
}

impl FileFrame {
    pub(super) fn of(axes: FileAxes) -> Self {
        let z_up = DQuat::from_rotation_x(-std::f64::consts::FRAC_PI_2);
        let turn = if axes.z_up { z_up } else { DQuat::IDENTITY };
        FileFrame { turn, metres: axes.unit.metres }
    }

    /// Whether files are in metres with y up.
    pub(super) fn is_identity(self) -> bool {
        self.turn == DQuat::IDENTITY && self.metres == 1.0
    }

    /// A direction, an impulse [N s] or a couple [N m s].
    pub(super) fn direction(self, vector: DVec3) -> DVec3 {
        self.turn * vector
    }

    /// A place \[m\], or a velocity \[m/s\].
    pub(super) fn place(self, vector: DVec3) -> DVec3 {
        self.turn * vector * self.metres
    }

    /// From the axes of the file to ours.
    pub(super) fn turn(self) -> DQuat {
        self.turn
    }

    pub(super) fn orientation(self, orientation: DQuat) -> DQuat {
        self.turn * orientation
    }
}
