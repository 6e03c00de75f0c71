//! What is sampled: poses, and the impulses of lasting contacts, exact because forces are constant within a phase.

use clangor::body::BodyId;
use clangor::timeline::{ContactKind, ContactRow, PoseRow};
use glam::DVec3;

use super::engine::Engine;
use crate::SimulationError;
use crate::record::Recorder;

/// Impulses of a ball's lasting contacts since the last sample.
#[derive(Clone, Debug, Default)]
pub(super) struct Pending {
    rows: Vec<ContactRow>,
    /// Until when they are summed [s].
    until: f64,
}

impl Engine<'_> {
    /// Adds the impulses of the present phase up to now.
    pub(super) fn bank(&mut self, ball: usize) {
        let Some(pending) = self.pending.as_mut().map(|all| &mut all[ball]) else { return };
        let span = self.now - std::mem::replace(&mut pending.until, self.now);
        let Some(phase) = self.phases[ball].as_deref().filter(|_| span > 0.0) else { return };
        let record = &self.balls[ball];
        let (position, velocity) = record.at(self.now);
        let omega = self.spins[ball].omega + self.spins[ball].alpha * (self.now - record.time);
        for reaction in &phase.reactions {
            let plane = &self.planes[reaction.ground.plane];
            let (normal, body_b) = (plane.normal, BodyId(plane.body));
            let at = pending.rows.iter().position(|row| row.body_b == body_b).unwrap_or_else(|| {
                pending.rows.push(ContactRow {
                    time: self.now,
                    body_a: BodyId(self.traits[ball].body),
                    body_b,
                    kind: ContactKind::Contact,
                    point: DVec3::ZERO,
                    normal,
                    impulse_n: 0.0,
                    impulse_t: DVec3::ZERO,
                    couple: DVec3::ZERO,
                    velocity: DVec3::ZERO,
                    depth: 0.0,
                    impact_id: 0,
                });
                pending.rows.len() - 1
            });
            let row = &mut pending.rows[at];
            row.impulse_n += reaction.normal * span;
            row.impulse_t += reaction.tangential * span;
            row.couple += reaction.couple * span;
            row.point = position - normal * record.radius;
            row.velocity = velocity - omega.cross(normal) * record.radius;
            row.depth = record.radius - (normal.dot(position) - plane.offset);
        }
    }

    /// Writes the impulses of lasting contacts since the last sample.
    pub(super) fn write_lasting(&mut self, recorder: &mut Recorder<'_>) -> Result<(), SimulationError> {
        for ball in 0..self.balls.len() {
            self.bank(ball);
            let Some(pending) = self.pending.as_mut().map(|all| &mut all[ball]) else { return Ok(()) };
            for mut row in pending.rows.drain(..) {
                row.time = self.now;
                recorder.contact(&[row], &[])?;
            }
        }
        Ok(())
    }

    /// Writes the poses of all moving bodies, in their order in the world.
    pub(super) fn write_poses(&self, recorder: &mut Recorder<'_>) -> Result<(), SimulationError> {
        for &ball in &self.by_body {
            let (record, spin) = (&self.balls[ball as usize], &self.spins[ball as usize]);
            let (position, velocity) = record.at(self.now);
            let (orientation, angular_velocity) = spin.after(self.now - record.time);
            recorder.pose(&PoseRow {
                time: self.now,
                body: BodyId(self.traits[ball as usize].body),
                position,
                orientation,
                velocity,
                angular_velocity,
            })?;
        }
        Ok(())
    }
}
