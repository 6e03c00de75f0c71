//! From the axes and the unit of length of tables and contact lists to metres and y up.

use glam::{DQuat, DVec3};

use super::MotionFiles;

/// Axes and unit of length of files.
#[derive(Clone, Copy)]
pub(super) struct FileFrame {
    turn: DQuat,
    metres: f64,
}

impl FileFrame {
    pub(super) fn of(files: &MotionFiles) -> Self {
        let z_up = DQuat::from_rotation_x(-std::f64::consts::FRAC_PI_2);
        let turn = if files.z_up { z_up } else { DQuat::IDENTITY };
        FileFrame { turn, metres: files.unit.metres }
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
