//! Rows of bodies that rest, left out: a body that sleeps for an hour has the same pose a thousand times a
//! second.
//!
//! Of rows that follow each other with the same pose and velocity, only the first is kept, and the last
//! before a change. Between them the pose is that of both, and after the last row of all a body keeps it.

use std::collections::BTreeMap;

use clangor_core::body::BodyId;
use clangor_core::timeline::PoseRow;

/// The rows of each body that were kept last and that were left out last.
#[derive(Default)]
pub(crate) struct RestingPoses {
    last: BTreeMap<BodyId, PoseRow>,
    left_out: BTreeMap<BodyId, PoseRow>,
}

impl RestingPoses {
    /// The rows to keep because of one, of a body in order of time: none while it rests.
    pub(crate) fn kept(&mut self, row: &PoseRow) -> impl Iterator<Item = PoseRow> + use<> {
        let rests = self.last.get(&row.body).is_some_and(|last| PoseRow { time: row.time, ..*last } == *row);
        let (before, now) = if rests {
            self.left_out.insert(row.body, *row);
            (None, None)
        } else {
            self.last.insert(row.body, *row);
            (self.left_out.remove(&row.body), Some(*row))
        };
        before.into_iter().chain(now)
    }

    /// The rows to keep because of one that is kept in any case.
    pub(crate) fn always(&mut self, row: &PoseRow) -> impl Iterator<Item = PoseRow> + use<> {
        let before = self.left_out.remove(&row.body);
        self.last.insert(row.body, *row);
        before.into_iter().chain([*row])
    }

    /// The row of a body that was left out last, to be kept because something happens at its time.
    pub(crate) fn needed(&mut self, body: BodyId) -> Option<PoseRow> {
        self.left_out.remove(&body)
    }
}

#[cfg(test)]
mod tests {
    use clangor_core::glam::{DQuat, DVec3};

    use super::*;

    fn row(time: f64, body: u32, height: f64) -> PoseRow {
        PoseRow {
            time,
            body: BodyId(body),
            position: DVec3::Y * height,
            orientation: DQuat::IDENTITY,
            velocity: DVec3::ZERO,
            angular_velocity: DVec3::ZERO,
        }
    }

    #[test]
    fn a_rest_has_its_first_and_its_last_row() {
        let mut poses = RestingPoses::default();
        let mut kept = Vec::new();
        for k in 0..1000 {
            let height = if (100..900).contains(&k) { 0.5 } else { f64::from(k) };
            kept.extend(poses.kept(&row(f64::from(k), 0, height)));
            kept.extend(poses.kept(&row(f64::from(k), 1, 0.0)));
        }
        let of = |body: u32| kept.iter().filter(move |row| row.body == BodyId(body)).map(|row| row.time);
        assert_eq!(of(1).collect::<Vec<_>>(), [0.0]);
        assert_eq!(of(0).filter(|t| (99.5..900.5).contains(t)).collect::<Vec<_>>(), [100.0, 899.0, 900.0]);
        assert_eq!(of(0).count(), 202);
        // What is hit at rest has its row.
        assert_eq!(poses.needed(BodyId(1)).map(|row| row.time), Some(999.0));
        assert_eq!(poses.needed(BodyId(1)), None);
    }
}
