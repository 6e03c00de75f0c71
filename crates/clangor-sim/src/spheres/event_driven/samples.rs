//! Samples of the log: poses, and impulses of lasting contacts, which are exact because forces are constant
//! within a phase.

use clangor_core::body::BodyId;
use clangor_core::timeline::{ContactKind, ContactRow, PoseRow};
use glam::DVec3;

use super::engine::Engine;
use super::island::Far;
use crate::SimulationError;
use crate::body_state::BodyState;
use crate::record::Recorder;

/// Marks a row of a spring or rod.
const LINK: usize = 1 << 31;

impl Engine {
    /// Adds the impulses of the present phase up to now.
    pub(super) fn accumulate(&mut self, ball: usize) {
        if self.pending.is_none() || self.island_place(ball).is_some() {
            return;
        }
        let Some(pending) = self.pending.as_mut().map(|all| &mut all[ball]) else { return };
        let span = self.now - std::mem::replace(&mut pending.until, self.now);
        let Some(phase) = self.phases[ball].as_deref().filter(|_| span > 0.0) else { return };
        let record = &self.balls[ball];
        let (position, velocity) = record.at(self.now);
        let omega = self.spins[ball].omega + self.spins[ball].alpha * (self.now - record.time);
        for reaction in &phase.reactions {
            let plane = &self.planes[reaction.ground.plane];
            let (normal, body_b) = (plane.normal, BodyId(plane.body));
            let body_a = BodyId(self.traits[ball].body);
            let row = pending
                .row(reaction.ground.plane, || empty_row(ContactKind::Contact, body_a, body_b, normal));
            row.time = self.now;
            row.impulse_n += reaction.normal * span;
            row.impulse_t += reaction.tangential * span;
            row.couple += reaction.couple * span;
            row.point = position - normal * record.radius;
            row.velocity = velocity - omega.cross(normal) * record.radius;
            row.depth = record.radius - (normal.dot(position) - plane.offset);
        }
    }

    /// Adds the impulse \[N s\] along the normal of a plane by which a ball that comes to lie on it loses the
    /// speed that rounding has left.
    pub(super) fn accumulate_removed(&mut self, ball: usize, plane: usize, impulse: f64) {
        let Some(pending) = self.pending.as_mut().filter(|_| impulse != 0.0) else { return };
        let normal = self.planes[plane].normal;
        let (body_a, body_b) = (BodyId(self.traits[ball].body), BodyId(self.planes[plane].body));
        let row = pending[ball].row(plane, || empty_row(ContactKind::Contact, body_a, body_b, normal));
        row.time = self.now;
        row.impulse_n += impulse;
        row.point = self.balls[ball].position - normal * self.balls[ball].radius;
    }

    /// Adds the impulses of the springs and rods of an island up to now.
    ///
    /// A spring between two balls becomes two rows against the world, each at the centre of its ball: a link
    /// exerts no torque about the centre, and the far centre has moved in between.
    pub(super) fn accumulate_links(&mut self, index: usize) {
        let Some(pending) = self.pending.as_mut() else { return };
        let island = &self.islands[index];
        let since = island.balls.first().map_or(self.now, |&ball| pending[ball].until);
        for &ball in &island.balls {
            pending[ball].until = self.now;
        }
        if since >= self.now {
            return;
        }
        let (by_springs, by_rods) = island.impulses(since, self.now);
        let mut add = |place: usize, key: usize, far: DVec3, far_body: BodyId, impulse: DVec3| {
            let ball = island.balls[place];
            let (position, velocity) = island.arcs[place].at(self.now);
            let body_a = BodyId(self.traits[ball].body);
            let normal = (position - far).normalize_or(DVec3::Y);
            let row = pending[ball]
                .row(LINK + key, || empty_row(ContactKind::Constraint, body_a, far_body, normal));
            let whole = row.impulse() + impulse;
            row.normal = normal;
            row.impulse_n = whole.dot(normal);
            row.impulse_t = whole - normal * row.impulse_n;
            (row.time, row.point, row.velocity) = (self.now, position, velocity);
        };
        for (key, (spring, impulse)) in island.springs.iter().zip(by_springs).enumerate() {
            let near = island.arcs[spring.ball].at(self.now).0;
            let far = match spring.to {
                Far::Point(point) => point,
                Far::Ball(other) => {
                    add(other, key, near, spring.far_body, -impulse);
                    island.arcs[other].at(self.now).0
                }
            };
            add(spring.ball, key, far, spring.far_body, impulse);
        }
        for (key, (rod, impulse)) in island.rods.iter().zip(by_rods).enumerate() {
            add(rod.ball, island.springs.len() + key, rod.anchor, BodyId::WORLD, impulse);
        }
    }

    /// Logs the reaction impulses of the rods of a ball in an impact.
    pub(super) fn log_rods(
        &self,
        island: usize,
        place: usize,
        impulse: DVec3,
        recorder: &mut Recorder<'_>,
    ) -> std::io::Result<()> {
        if self.pending.is_none() || impulse == DVec3::ZERO {
            return Ok(());
        }
        let island = &self.islands[island];
        let record = &self.balls[island.balls[place]];
        let mut rest = impulse;
        let rods: Vec<_> = island.rods.iter().filter(|r| r.ball == place).collect();
        for (k, rod) in rods.iter().enumerate() {
            let normal = (record.position - rod.anchor).normalize_or(DVec3::Y);
            // The part that the other rod cannot take; the last rod takes the remainder.
            let share = match rods.get(k + 1) {
                Some(other) => {
                    let e = (record.position - other.anchor).normalize_or(DVec3::Y);
                    let across = normal - e * e.dot(normal);
                    normal * (across.dot(rest) / across.length_squared().max(1e-12))
                }
                None => rest,
            };
            rest -= share;
            let body = BodyId(self.traits[island.balls[place]].body);
            let mut row = empty_row(ContactKind::Constraint, body, BodyId::WORLD, normal);
            (row.time, row.point, row.velocity) = (self.now, record.position, record.velocity);
            row.impulse_n = share.dot(normal);
            row.impulse_t = share - normal * row.impulse_n;
            recorder.contact(&[row], &[])?;
        }
        Ok(())
    }

    /// Writes the impulses of lasting contacts since the last sample.
    pub(super) fn write_lasting(&mut self, recorder: &mut Recorder<'_>) -> Result<(), SimulationError> {
        if self.pending.is_some() {
            (0..self.islands.len()).for_each(|island| self.accumulate_links(island));
        }
        for ball in 0..self.balls.len() {
            self.accumulate(ball);
            let Some(pending) = self.pending.as_mut().map(|all| &mut all[ball]) else { return Ok(()) };
            for (_, row) in pending.rows.drain(..) {
                recorder.contact(&[row], &[])?;
            }
        }
        Ok(())
    }

    /// Writes the poses of all moving bodies, in their order in the world.
    pub(super) fn write_poses(&self, recorder: &mut Recorder<'_>) -> Result<(), SimulationError> {
        for (body, BodyState { pose, velocity, angular_velocity }) in self.states() {
            recorder.pose(&PoseRow {
                time: self.now,
                body: BodyId(body),
                position: pose.position,
                orientation: pose.orientation,
                velocity,
                angular_velocity,
            })?;
        }
        Ok(())
    }
}

fn empty_row(kind: ContactKind, body_a: BodyId, body_b: BodyId, normal: DVec3) -> ContactRow {
    ContactRow {
        time: 0.0,
        body_a,
        body_b,
        kind,
        point: DVec3::ZERO,
        normal,
        impulse_n: 0.0,
        impulse_t: DVec3::ZERO,
        couple: DVec3::ZERO,
        velocity: DVec3::ZERO,
        depth: 0.0,
        impact_id: 0,
        effective_mass: None,
    }
}
