//! Poses of the bodies at [`FRAME_RATE`], from the birth of each body until it dies or comes to rest.

use clangor_core::body::{Body, BodyId};
use clangor_core::contact::PoseHistory;

use super::FRAME_RATE;

pub(super) struct Motions {
    /// Positions \[m\] and orientations x, y, z, w; the rows of a body are consecutive.
    pub(super) rows: Vec<[f32; 7]>,
    /// Motion of each body.
    pub(super) bodies: Vec<Motion>,
}

/// The poses of a body: row `first_row` is its pose at the time `first_frame` over the rate, or at its birth
/// if that is later.
pub(super) struct Motion {
    pub(super) first_frame: u32,
    pub(super) first_row: usize,
    pub(super) rows: usize,
}

impl Motions {
    pub(super) fn of(bodies: &[Body], poses: &PoseHistory, duration: f64) -> Self {
        let mut rows: Vec<[f32; 7]> = Vec::new();
        let motion = |(index, body): (usize, &Body)| {
            let first_row = rows.len();
            let (birth, end) = (body.life.birth, body.life.death.min(duration).max(body.life.birth));
            let first_frame = (birth * FRAME_RATE).floor();
            for frame in first_frame as u32..=(end * FRAME_RATE).ceil() as u32 {
                let time = (f64::from(frame) / FRAME_RATE).clamp(birth, end);
                let pose = poses.at(BodyId(index as u32), time);
                let (x, q) = (pose.position.as_vec3(), pose.orientation.normalize().as_quat());
                rows.push([x.x, x.y, x.z, q.x, q.y, q.z, q.w]);
            }
            // Equal poses at the end are stored once.
            while rows.len() > first_row + 1 && rows[rows.len() - 1] == rows[rows.len() - 2] {
                rows.pop();
            }
            Motion { first_frame: first_frame as u32, first_row, rows: rows.len() - first_row }
        };
        let bodies = bodies.iter().enumerate().map(motion).collect();
        Motions { rows, bodies }
    }
}
