//! The log of balls that press on each other: a row for each contact, or for each of its steps.

use clangor_core::body::BodyId;
use clangor_core::timeline::{ContactKind, ContactRow, PoseRow};
use glam::DVec3;

use super::engine::Engine;
use super::press_laws::SLOWEST;
use super::press_state::{OpenContact, Pressed};
use crate::record::Recorder;
use crate::spheres::compliant_cluster::{Mover, Partner, Press};

/// Rate of the overlap below which a contact rests, over that of the slowest cluster.
const REST: f64 = 0.1;

impl Engine {
    /// Logs what the contacts did in a step; begins the tracks of those that have closed.
    pub(super) fn log_step(&self, pressed: &mut Pressed, recorder: &mut Recorder<'_>) -> std::io::Result<()> {
        let raw = recorder.settings().raw;
        for k in 0..pressed.tracks.len() {
            let press = pressed.cluster.presses[k];
            if matches!(press.partner, Partner::Support(_)) {
                if raw && press.impulse != DVec3::ZERO {
                    let row = self.press_row(pressed, k, ContactKind::Contact);
                    recorder.contact(&[row], &[])?;
                }
                continue;
            }
            if press.overlap <= 0.0 && press.normal_impulse == 0.0 {
                continue;
            }
            let (sign, row) = (self.sign(pressed, &press), self.press_row(pressed, k, ContactKind::Impact));
            let poses = match pressed.tracks[k].open {
                None => self.poses_of(pressed, &press),
                Some(_) => Vec::new(),
            };
            let open = pressed.tracks[k].open.get_or_insert_with(|| OpenContact {
                row: ContactRow { time: self.now, ..row },
                poses,
                impulse: DVec3::ZERO,
                fastest: 0.0,
                quiet: 0,
                rows: Vec::new(),
            });
            open.impulse += sign * press.impulse;
            open.fastest = open.fastest.max(press.closing);
            open.quiet = if press.closing.abs() < REST * SLOWEST { open.quiet + 1 } else { 0 };
            if raw {
                open.rows.push(row);
            }
        }
        Ok(())
    }

    /// 1 if the ball of a contact is body A of its rows, else −1.
    pub(super) fn sign(&self, pressed: &Pressed, press: &Press) -> f64 {
        let body = |member: usize| self.traits[pressed.members[member] as usize].body;
        match press.partner {
            Partner::Ball(other) if body(other) < body(press.ball) => -1.0,
            _ => 1.0,
        }
    }

    /// The row of a contact for the step that has been made: at the time of its beginning, when the records
    /// take on the velocities of its end, with the point in its middle.
    pub(super) fn press_row(&self, pressed: &Pressed, k: usize, kind: ContactKind) -> ContactRow {
        let press = &pressed.cluster.presses[k];
        let sign = self.sign(pressed, press);
        let body = |member: usize| BodyId(self.traits[pressed.members[member] as usize].body);
        let mover = |member: usize| pressed.cluster.balls[member];
        let (a, point) = (mover(press.ball), press.point);
        let at_point = |m: Mover| m.velocity + m.omega.cross(point - m.position);
        let (partner, velocity) = match press.partner {
            Partner::Ball(other) | Partner::Along(other, _) => {
                (body(other), at_point(a) - at_point(mover(other)))
            }
            Partner::Plane(..) | Partner::Support(_) => {
                let plane = pressed.tracks[k].plane.map_or(BodyId::WORLD, |p| BodyId(self.planes[p].body));
                (plane, at_point(a))
            }
        };
        let (normal, impulse, velocity) = (sign * press.normal, sign * press.impulse, sign * velocity);
        let (body_a, body_b) =
            if sign > 0.0 { (body(press.ball), partner) } else { (partner, body(press.ball)) };
        let impulse_n = impulse.dot(normal);
        ContactRow {
            time: self.now,
            body_a,
            body_b,
            kind,
            point,
            normal,
            impulse_n,
            impulse_t: impulse - normal * impulse_n,
            couple: DVec3::ZERO,
            velocity: velocity - normal * (normal.dot(velocity) + press.closing),
            depth: press.depth.max(0.0),
            impact_id: 0,
            effective_mass: None,
        }
    }

    /// The states of the balls of a contact before the step.
    pub(super) fn poses_of(&self, pressed: &Pressed, press: &Press) -> Vec<PoseRow> {
        let far = match press.partner {
            Partner::Ball(other) => Some(other),
            _ => None,
        };
        let mut balls: Vec<usize> =
            [Some(press.ball), far].into_iter().flatten().map(|m| pressed.members[m] as usize).collect();
        balls.retain(|ball| self.traits[*ball].free);
        balls.sort_by_key(|ball| self.traits[*ball].body);
        let pose = |&ball: &usize| {
            let (record, spin) = (&self.balls[ball], &self.spins[ball]);
            PoseRow {
                time: self.now,
                body: BodyId(self.traits[ball].body),
                position: record.position,
                orientation: spin.orientation,
                velocity: record.velocity,
                angular_velocity: spin.omega,
            }
        };
        balls.iter().map(pose).collect()
    }

    /// Logs the contacts that still last at the end of a run.
    pub(super) fn end_press(&mut self, recorder: &mut Recorder<'_>) -> std::io::Result<()> {
        let open = self.pressed.tracks.iter_mut().filter_map(|track| track.open.take());
        open.into_iter().try_for_each(|open| close(open, recorder))
    }
}

/// Logs a contact that is over.
pub(super) fn close(mut open: OpenContact, recorder: &mut Recorder<'_>) -> std::io::Result<()> {
    let normal = open.row.normal;
    let approach = normal * (-open.fastest - normal.dot(open.row.velocity));
    match open.rows.first_mut() {
        Some(first) => {
            first.velocity += first.normal * (-open.fastest - first.normal.dot(first.velocity));
            recorder.impact(&open.rows, &open.poses)
        }
        None => {
            let impulse_n = open.impulse.dot(normal);
            let row = ContactRow {
                impulse_n,
                impulse_t: open.impulse - normal * impulse_n,
                velocity: open.row.velocity + approach,
                ..open.row
            };
            recorder.impact(&[row], &open.poses)
        }
    }
}
