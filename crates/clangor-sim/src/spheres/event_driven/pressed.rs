//! Balls that press on several others at once: their motion through the time of the contacts, in steps.
//!
//! An impact of two balls that have nothing else within reach is over at an instant, by the law of
//! [`impact`](crate::spheres::impact). Where another ball or a plane would be met before the bodies part, all
//! of them move by Hertz's forces ([`compliant_cluster`](crate::spheres::compliant_cluster)) until they do
//! not touch. A ball that is met meanwhile joins; a ball that touches nothing leaves, and flies on in closed
//! form.
//!
//! The balls of a cluster are no partners of predicted events: the cluster finds whom they meet. Their
//! records hold the end of the last step, from which the next one begins at an event of the first of them.
//!
//! A contact becomes one row of the log, at its onset: the sum of its impulses, and the largest approach
//! speed, as a contact without a gap starts from rest. In the raw log it has a row for each step.
//!
//! Impacts slower than 5 cm/s, and those that have come to rest under load, are left to the law of impacts.
//! Differs: the elastic energy of contacts that have come to rest is lost.

use glam::{DQuat, DVec3};

use super::ball::MotionPhase;
use super::cluster::Participant;
use super::engine::{Engine, NEVER, Next, PRESSED};
use super::grid::NOWHERE;
use super::press_laws::{MeetingSpeed, SLOWEST};
use super::press_log::close;
use super::press_state::{Pressed, Track};
use super::support;
use crate::record::Recorder;
use crate::spheres::bodies::Plane;
use crate::spheres::cells::cell_of;
use crate::spheres::compliant_cluster::{Mover, Partner, Press, PressLaw};
use crate::spheres::tolerances::TOUCH;

/// How far the surroundings count: the way of the approach in this many contact times.
pub(super) const REACH: f64 = 2.0;
/// Contact times after which a contact at rest is left to its load.
const SETTLED: f64 = 40.0;

impl Engine {
    /// Whether an impact of a ball happens among others that it will press on.
    pub(super) fn is_crowded(&self, ball: usize, partner: Participant) -> bool {
        if self.compliance.is_none() || !self.islands.is_empty() || !self.traits[ball].free {
            return false;
        }
        let MeetingSpeed { normal, speed, duration } = self.approach(ball, partner);
        if !(speed >= SLOWEST && duration.is_finite()) {
            return false;
        }
        let reach = REACH * speed * duration;
        let near = |one: usize| {
            let (x, _) = self.state(one, self.now);
            let radius = self.balls[one].radius;
            let mut found = self.planes.iter().enumerate().any(|(index, plane)| {
                let is_partner = matches!(partner, Participant::Plane(other) if other == index);
                let along = plane.normal.dot(normal).abs() > 0.05;
                !is_partner && along && plane.normal.dot(x) - plane.offset - radius < reach
            });
            self.for_each_near(one, |other, record| {
                let of_pair = other == ball || matches!(partner, Participant::Ball(b) if other == b);
                if !of_pair && !found {
                    let (y, _) = record.at(self.now);
                    found = x.distance(y) - radius - record.radius < reach;
                }
            });
            found
        };
        let is_free = |other: usize| self.traits[other].free;
        near(ball) || matches!(partner, Participant::Ball(other) if is_free(other) && near(other))
    }

    /// Begins to press a ball on another or on a plane.
    pub(super) fn begin_press(
        &mut self,
        ball: usize,
        partner: Participant,
        recorder: &mut Recorder<'_>,
    ) -> std::io::Result<()> {
        let mut pressed = std::mem::take(&mut self.pressed);
        let MeetingSpeed { speed, duration, .. } = self.approach(ball, partner);
        let step = duration / self.compliance.map_or(1.0, |c| c.steps);
        let is_first = pressed.members.is_empty();
        if is_first {
            pressed.time = self.now;
        }
        pressed.step = if is_first { step } else { pressed.step.min(step) };
        pressed.speed = if is_first { speed } else { pressed.speed.max(speed) };
        self.enter(&mut pressed, ball);
        if let Participant::Ball(other) = partner {
            self.enter(&mut pressed, other);
        }
        // A cluster that is under way takes them in at its next step.
        let done = if is_first { self.press_on(&mut pressed, recorder) } else { Ok(()) };
        self.pressed = pressed;
        done
    }

    /// Makes the next step of the balls that press on each other.
    pub(super) fn continue_press(&mut self, recorder: &mut Recorder<'_>) -> std::io::Result<()> {
        let mut pressed = std::mem::take(&mut self.pressed);
        let done = self.press_on(&mut pressed, recorder);
        self.pressed = pressed;
        done
    }

    fn press_on(&mut self, pressed: &mut Pressed, recorder: &mut Recorder<'_>) -> std::io::Result<()> {
        // Contacts that have opened, and balls that touch nothing any more.
        self.leave(pressed, recorder)?;
        if pressed.members.is_empty() {
            return Ok(());
        }
        // Whom they meet in this step.
        self.gather(pressed);
        // The step, and what it does to the records and the log.
        let h = pressed.step;
        pressed.cluster.step(h, self.gravity);
        self.work += 1 + pressed.cluster.presses.len() as u64 / 4;
        pressed.countdown -= 1;
        self.log_step(pressed, recorder)?;
        self.write_back(pressed);
        pressed.time = self.now + h;
        pressed.fresh.fill(false);
        self.schedule_press(pressed);
        Ok(())
    }

    /// The first member that moves has the event of the next step.
    fn schedule_press(&mut self, pressed: &Pressed) {
        let mut leader = true;
        for &ball in &pressed.members {
            let ball = ball as usize;
            if !self.traits[ball].free {
                continue;
            }
            let time = if std::mem::take(&mut leader) { self.now + pressed.step } else { f64::INFINITY };
            let partner = if time.is_finite() { PRESSED } else { NEVER.partner };
            self.next[ball] = Next { contact: time, partner, ..NEVER };
            self.schedule.set(ball, time);
        }
    }

    /// Makes a ball a member.
    pub(super) fn enter(&mut self, pressed: &mut Pressed, ball: usize) {
        if pressed.members.contains(&(ball as u32)) {
            return;
        }
        let member = pressed.members.len();
        let free = self.traits[ball].free;
        if free {
            // A cluster under way is ahead by a part of its step.
            let now = std::mem::replace(&mut self.now, pressed.time);
            self.bring_forward(ball);
            self.now = now;
            for plane in 0..self.planes.len() {
                // A plane that it rests on is rigid.
                let Plane { normal, offset, material, .. } = self.planes[plane];
                let record = &mut self.balls[ball];
                let gap = normal.dot(record.position) - offset - record.radius;
                if gap <= TOUCH && support::in_touch(normal.dot(record.velocity)) {
                    record.velocity -= normal * normal.dot(record.velocity);
                    let friction = self.pairs.of(self.traits[ball].material, material).friction;
                    let law = PressLaw { stiffness: 0.0, damping: 0.0, friction, reach: 0.0 };
                    pressed.cluster.presses.push(Press::new(member, Partner::Support(normal), law, 0.0));
                    pressed.tracks.push(Track { plane: Some(plane), open: None });
                }
            }
            let record = &mut self.balls[ball];
            record.motion_phase = MotionPhase::Pressed;
            // Gravity acts evenly within a step, the forces at its beginning.
            record.acceleration = self.gravity;
            record.generation = record.generation.wrapping_add(1);
            self.spins[ball].alpha = DVec3::ZERO;
            self.phases[ball] = None;
            self.next[ball] = NEVER;
            self.schedule.set(ball, f64::INFINITY);
        }
        let (record, spin, traits) = (&self.balls[ball], &self.spins[ball], &self.traits[ball]);
        pressed.members.push(ball as u32);
        pressed.fresh.push(true);
        pressed.cluster.balls.push(Mover {
            position: record.position,
            velocity: record.velocity,
            omega: spin.omega,
            inverse_mass: traits.inverse_mass,
            inverse_inertia: traits.inverse_inertia,
            radius: record.radius,
            held: [DVec3::ZERO; 2],
        });
        pressed.countdown = 0;
    }

    /// Logs the contacts that have opened, and releases the balls that touch nothing.
    fn leave(&mut self, pressed: &mut Pressed, recorder: &mut Recorder<'_>) -> std::io::Result<()> {
        let steps = self.compliance.map_or(1.0, |c| c.steps);
        let mut holds = pressed.fresh.clone();
        for k in 0..pressed.tracks.len() {
            let press = &pressed.cluster.presses[k];
            let Some(open) = &pressed.tracks[k].open else { continue };
            if press.overlap <= 0.0 {
                let over = pressed.tracks[k].open.take();
                over.map_or(Ok(()), |over| close(over, recorder))?;
                continue;
            }
            if f64::from(open.quiet) < SETTLED * steps {
                holds[press.ball] = true;
                if let Partner::Ball(other) = press.partner {
                    holds[other] = true;
                }
            }
        }
        if holds.iter().all(|hold| *hold) {
            return Ok(());
        }
        let stays: Vec<bool> = pressed
            .cluster
            .presses
            .iter()
            .map(|press| holds[press.ball] && !matches!(press.partner, Partner::Ball(b) if !holds[b]))
            .collect();
        for (track, _) in pressed.tracks.iter_mut().zip(&stays).filter(|(_, stays)| !**stays) {
            if let Some(open) = track.open.take() {
                close(open, recorder)?;
            }
        }
        let leaving: Vec<usize> = pressed
            .members
            .iter()
            .zip(&holds)
            .filter(|(ball, hold)| !**hold && self.traits[**ball as usize].free)
            .map(|(ball, _)| *ball as usize)
            .collect();
        pressed.retain(&holds, &stays);
        for &ball in &leaving {
            self.accumulate(ball);
            self.balls[ball].motion_phase = MotionPhase::Steady;
            self.next[ball] = NEVER;
            self.start_phase(ball, None);
        }
        for &ball in &leaving {
            self.predict(ball);
        }
        Ok(())
    }

    /// Puts the end of a step into the records of the balls.
    fn write_back(&mut self, pressed: &mut Pressed) {
        let edge = self.grid.edge();
        for (member, &ball) in pressed.members.iter().enumerate() {
            let ball = ball as usize;
            if !self.traits[ball].free {
                continue;
            }
            let mover = pressed.cluster.balls[member];
            let (record, spin) = (&mut self.balls[ball], &mut self.spins[ball]);
            let turn = 0.5 * (spin.omega + mover.omega) * pressed.step;
            spin.orientation = (DQuat::from_scaled_axis(turn) * spin.orientation).normalize();
            spin.omega = mover.omega;
            (record.position, record.velocity) = (mover.position, mover.velocity);
            record.time = self.now + pressed.step;
            record.generation = record.generation.wrapping_add(1);
            if record.bucket != NOWHERE && edge.is_finite() {
                let cell = cell_of(record.position, edge);
                if cell != record.cell {
                    self.grid.remove(&mut self.balls, ball);
                    self.balls[ball].cell = cell;
                    self.grid.insert(&mut self.balls, ball);
                }
            }
        }
        // A ball that rises from its support meets the plane again by Hertz's law.
        for k in 0..pressed.tracks.len() {
            let press = &pressed.cluster.presses[k];
            let (Partner::Support(normal), Some(index)) = (press.partner, pressed.tracks[k].plane) else {
                continue;
            };
            if press.normal_impulse == 0.0 && normal.dot(pressed.cluster.balls[press.ball].velocity) > 0.0 {
                let (ball, offset) = (pressed.members[press.ball] as usize, self.planes[index].offset);
                let gap = normal.dot(self.balls[ball].position) - offset - self.balls[ball].radius;
                let law = self.law_on_plane(ball, index, gap.min(0.0), pressed.speed);
                let plane = Partner::Plane(normal, offset);
                pressed.cluster.presses[k] = Press::new(press.ball, plane, law, -gap.max(0.0));
            }
        }
    }
}
