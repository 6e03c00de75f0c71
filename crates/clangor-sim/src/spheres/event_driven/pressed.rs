//! Balls that press on several others at once: their motion through the time of the contacts, in steps.
//!
//! An impact of two balls that have nothing else within reach is over at an instant, by the law of
//! [`impact`](crate::spheres::impact). Where another ball or a plane would be met before the bodies part, all
//! of them move by Hertz's forces ([`compliant_cluster`](crate::spheres::compliant_cluster)) until they do
//! not touch. A ball that is met meanwhile joins; a ball that touches nothing leaves, and flies on in closed
//! form.
//!
//! The balls of a cluster are no partners of predicted events: the cluster finds whom they meet. Their records
//! hold the end of the last step, from which the next one begins at an event of the first of them.
//!
//! A contact becomes one row of the log, at its onset: the sum of its impulses, and the largest approach
//! speed, as a contact without a gap starts from rest. In the raw log it has a row for each step.
//!
//! Impacts slower than 5 cm/s, and those that have come to rest under load, are left to the law of impacts.
//! Differs: the elastic energy of contacts that have come to rest is lost.

use clangor_core::body::BodyId;
use clangor_core::contact::compliant::restitution_damping;
use clangor_core::contact::hertz::HertzContact;
use clangor_core::timeline::{ContactKind, ContactRow, PoseRow};
use glam::{DQuat, DVec3};

use super::ball::MotionPhase;
use super::cluster::Participant;
use super::engine::{Engine, NEVER, PRESSED};
use super::support;
use crate::record::Recorder;
use crate::spheres::cells::cell_of;
use crate::spheres::compliant_cluster::{CompliantCluster, Mover, Partner, Press, PressLaw};
use crate::spheres::tolerances::TOUCH;

/// How far the surroundings count: the way of the approach in this many contact times.
pub(super) const REACH: f64 = 2.0;
/// Steps between two searches of neighbours.
const LIST_STEPS: u32 = 16;
/// Rate of the overlap below which a contact rests, over v_min.
const REST: f64 = 0.1;
/// Contact times after which a contact at rest is left to its load.
const SETTLED: f64 = 40.0;
/// Slowest approach that begins a cluster \[m/s\]; \[PAN\] §4.3 has it as the slowest one that sounds.
pub(super) const SLOWEST: f64 = 0.05;

/// How impacts among several balls are solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Compliance {
    /// Steps per contact time.
    pub(crate) steps: f64,
}

/// The balls that press on each other now.
#[derive(Default)]
pub(super) struct Pressed {
    /// Balls, in the order of the cluster.
    pub(super) members: Vec<u32>,
    /// Whether a member has made no step yet.
    fresh: Vec<bool>,
    cluster: CompliantCluster,
    /// Contacts, in the order of the cluster.
    tracks: Vec<Track>,
    /// Balls near a member that are not members.
    outsiders: Vec<(usize, u32)>,
    /// Time of the records of the members \[s\].
    time: f64,
    /// Steps until neighbours are sought again.
    countdown: u32,
    /// Step \[s\].
    step: f64,
    /// Largest approach speed at which a contact began \[m/s\].
    speed: f64,
}

/// What is known of a contact besides its forces.
#[derive(Clone, Default)]
struct Track {
    /// Index of the plane, if it is one.
    plane: Option<usize>,
    /// What is logged of it, from its onset on.
    open: Option<OpenContact>,
}

/// A contact from its onset on.
#[derive(Clone)]
struct OpenContact {
    row: ContactRow,
    poses: Vec<PoseRow>,
    impulse: DVec3,
    fastest: f64,
    /// Steps for which it has been at rest.
    quiet: u32,
    /// Rows of the steps, for the raw log.
    rows: Vec<ContactRow>,
}

/// How a ball meets its partner.
pub(super) struct MeetingSpeed {
    /// Unit normal towards the ball.
    normal: DVec3,
    /// Approach speed \[m/s\].
    pub(super) speed: f64,
    /// Hertz's contact time \[s\]; not finite for bodies without compliance.
    pub(super) duration: f64,
}

impl Pressed {
    /// Renumbers the balls.
    pub(super) fn renumber(&mut self, new_of: &[u32]) {
        self.members.iter_mut().for_each(|ball| *ball = new_of[*ball as usize]);
        self.outsiders.iter_mut().for_each(|(_, ball)| *ball = new_of[*ball as usize]);
    }

    fn is_listed(&self, one: usize, two: usize) -> bool {
        self.cluster.presses.iter().any(|press| match press.partner {
            Partner::Ball(other) => (press.ball, other) == (one, two) || (press.ball, other) == (two, one),
            _ => false,
        })
    }

    fn is_on_plane(&self, member: usize, plane: usize) -> bool {
        let pairs = self.cluster.presses.iter().zip(&self.tracks);
        pairs.into_iter().any(|(press, track)| press.ball == member && track.plane == Some(plane))
    }

    /// Removes the contacts and members that `stays` rejects.
    fn retain(&mut self, stays: &[bool], press_stays: &[bool]) {
        let mut new_of = Vec::with_capacity(stays.len());
        let mut count = 0;
        for stay in stays {
            new_of.push(count);
            count += usize::from(*stay);
        }
        let keep = |flags: &[bool], at: &mut usize| {
            *at += 1;
            flags[*at - 1]
        };
        let mut at = 0;
        self.members.retain(|_| keep(stays, &mut at));
        at = 0;
        self.fresh.retain(|_| keep(stays, &mut at));
        at = 0;
        self.cluster.balls.retain(|_| keep(stays, &mut at));
        at = 0;
        self.tracks.retain(|_| keep(press_stays, &mut at));
        at = 0;
        self.cluster.presses.retain(|_| keep(press_stays, &mut at));
        for press in &mut self.cluster.presses {
            press.ball = new_of[press.ball];
            if let Partner::Ball(other) = &mut press.partner {
                *other = new_of[*other];
            }
        }
        self.countdown = 0;
    }
}

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
        let step = duration / self.compliance.map_or(1.0, steps_per_contact);
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
            self.next[ball] = super::engine::Next { contact: time, partner, ..NEVER };
            self.schedule.set(ball, time);
        }
    }

    /// Makes a ball a member.
    fn enter(&mut self, pressed: &mut Pressed, ball: usize) {
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
                let Plane { normal, offset, material } = self.plane(plane);
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

    /// Lists the contacts and neighbours of the members, and takes in those that will be met in this step.
    fn gather(&mut self, pressed: &mut Pressed) {
        loop {
            if pressed.countdown == 0 {
                self.list(pressed);
            }
            let h = pressed.step;
            let met = pressed.outsiders.iter().find(|&&(member, other)| {
                let mover = &pressed.cluster.balls[member];
                let x = mover.position + (mover.velocity + self.gravity * (0.5 * h)) * h;
                let (y, _) = self.state(other as usize, self.now + h);
                x.distance(y) <= mover.radius + self.balls[other as usize].radius
            });
            match met {
                Some(&(_, other)) => self.enter(pressed, other as usize),
                None => return,
            }
        }
    }

    /// Lists the contacts and neighbours of the members.
    fn list(&mut self, pressed: &mut Pressed) {
        // Pairs that do not touch are listed anew.
        let presses = pressed.cluster.presses.iter().zip(&pressed.tracks);
        let known: Vec<bool> = presses
            .map(|(press, track)| track.open.is_some() || matches!(press.partner, Partner::Support(_)))
            .collect();
        pressed.retain(&vec![true; pressed.members.len()], &known);
        let fastest = pressed.cluster.balls.iter().map(|b| b.velocity.length()).fold(0.0, f64::max);
        let margin = |speed: f64| 2.0 * f64::from(LIST_STEPS) * pressed.step * (2.0 * fastest + speed);
        let (mut near_balls, mut near_planes) = (Vec::new(), Vec::new());
        pressed.outsiders.clear();
        for (member, &ball) in pressed.members.iter().enumerate() {
            if !self.traits[ball as usize].free {
                continue;
            }
            let mover = &pressed.cluster.balls[member];
            for (index, plane) in self.planes.iter().enumerate() {
                let gap = plane.normal.dot(mover.position) - plane.offset - mover.radius;
                if gap < margin(0.0) && !pressed.is_on_plane(member, index) {
                    near_planes.push((member, index, gap));
                }
            }
            self.for_each_near(ball as usize, |other, record| {
                let (y, w) = record.at(self.now);
                let gap = mover.position.distance(y) - mover.radius - record.radius;
                if gap < margin(w.length()) {
                    match pressed.members.iter().position(|&b| b as usize == other) {
                        Some(theirs) => near_balls.push((member.min(theirs), member.max(theirs), gap)),
                        None => pressed.outsiders.push((member, other as u32)),
                    }
                }
            });
        }
        // Contacts in the order of the members, whatever the order of the cells.
        near_balls.sort_by_key(|&(one, two, _)| (one, two));
        near_balls.dedup_by_key(|&mut (one, two, _)| (one, two));
        for (one, two, gap) in near_balls {
            if !pressed.is_listed(one, two) {
                let [a, b] = [one, two].map(|member| pressed.members[member] as usize);
                let law = self.law_of_balls(a, b, gap.min(0.0));
                let inverse_mass = self.inverse_mass_of(a, Participant::Ball(b));
                self.add_press(pressed, (one, Partner::Ball(two)), None, (law, inverse_mass, gap));
            }
        }
        for (member, index, gap) in near_planes {
            let ball = pressed.members[member] as usize;
            let law = self.law_on_plane(ball, index, gap.min(0.0));
            let plane = &self.planes[index];
            let partner = Partner::Plane(plane.normal, plane.offset);
            let inverse_mass = self.traits[ball].inverse_mass;
            self.add_press(pressed, (member, partner), Some(index), (law, inverse_mass, gap));
        }
        pressed.outsiders.sort_unstable();
        pressed.countdown = LIST_STEPS;
    }

    fn add_press(
        &self,
        pressed: &mut Pressed,
        (member, partner): (usize, Partner),
        plane: Option<usize>,
        (law, inverse_mass, gap): (PressLaw, f64, f64),
    ) {
        let duration = self.contact_time(&law, inverse_mass, pressed.speed);
        let steps = self.compliance.map_or(1.0, steps_per_contact);
        if duration > 0.0 {
            pressed.step = pressed.step.min(duration / steps);
        }
        pressed.cluster.presses.push(Press::new(member, partner, law, -gap.max(0.0)));
        pressed.tracks.push(Track { plane, open: None });
    }

    /// Logs the contacts that have opened, and releases the balls that touch nothing.
    fn leave(&mut self, pressed: &mut Pressed, recorder: &mut Recorder<'_>) -> std::io::Result<()> {
        let steps = self.compliance.map_or(1.0, steps_per_contact);
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

    /// Logs what the contacts did in a step; begins the tracks of those that have closed.
    fn log_step(&self, pressed: &mut Pressed, recorder: &mut Recorder<'_>) -> std::io::Result<()> {
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
    fn sign(&self, pressed: &Pressed, press: &Press) -> f64 {
        let body = |member: usize| self.traits[pressed.members[member] as usize].body;
        match press.partner {
            Partner::Ball(other) if body(other) < body(press.ball) => -1.0,
            _ => 1.0,
        }
    }

    /// The row of a contact for the step that has been made: at the time of its beginning, when the records
    /// take on the velocities of its end, with the point in its middle.
    fn press_row(&self, pressed: &Pressed, k: usize, kind: ContactKind) -> ContactRow {
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
        }
    }

    /// The states of the balls of a contact before the step.
    fn poses_of(&self, pressed: &Pressed, press: &Press) -> Vec<PoseRow> {
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
            if record.bucket != super::grid::NOWHERE && edge.is_finite() {
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
                let law = self.law_on_plane(ball, index, gap.min(0.0));
                let plane = Partner::Plane(normal, offset);
                pressed.cluster.presses[k] = Press::new(press.ball, plane, law, -gap.max(0.0));
            }
        }
    }

    /// Logs the contacts that still last at the end of a run.
    pub(super) fn end_press(&mut self, recorder: &mut Recorder<'_>) -> std::io::Result<()> {
        let open = self.pressed.tracks.iter_mut().filter_map(|track| track.open.take());
        open.into_iter().try_for_each(|open| close(open, recorder))
    }

    /// How a ball meets its partner now.
    pub(super) fn approach(&self, ball: usize, partner: Participant) -> MeetingSpeed {
        let (x, v) = self.state(ball, self.now);
        let (normal, w) = match partner {
            Participant::Ball(other) => {
                let (y, w) = self.state(other, self.now);
                ((x - y).normalize_or(DVec3::Y), w)
            }
            Participant::Plane(plane) => (self.planes[plane].normal, DVec3::ZERO),
        };
        let speed = -normal.dot(v - w);
        let law = self.law_of(ball, partner, 0.0);
        let duration = self.contact_time(&law, self.inverse_mass_of(ball, partner), speed);
        MeetingSpeed { normal, speed, duration }
    }

    /// Hertz's law of a ball and its partner, whose surfaces meet or overlap by −`gap`.
    pub(super) fn law_of(&self, ball: usize, partner: Participant, gap: f64) -> PressLaw {
        match partner {
            Participant::Ball(other) => self.law_of_balls(ball, other, gap),
            Participant::Plane(plane) => self.law_on_plane(ball, plane, gap),
        }
    }

    pub(super) fn inverse_mass_of(&self, ball: usize, partner: Participant) -> f64 {
        let other = match partner {
            Participant::Ball(other) => self.traits[other].inverse_mass,
            Participant::Plane(_) => 0.0,
        };
        self.traits[ball].inverse_mass + other
    }

    /// Hertz's law of two balls whose surfaces meet, or that overlap by −`gap`.
    fn law_of_balls(&self, a: usize, b: usize, gap: f64) -> PressLaw {
        let radii = [a, b].map(|ball| self.balls[ball].radius);
        let contact = HertzContact {
            inverse_mass: self.inverse_mass_of(a, Participant::Ball(b)),
            relative_radii: [1.0 / radii.iter().map(|r| 1.0 / r).sum::<f64>(); 2],
            compliance: self.compliances[a] + self.compliances[b],
            speed: 1.0,
        };
        let pair = self.pairs.of(self.traits[a].material, self.traits[b].material);
        press_law(&contact, pair.restitution, pair.friction, radii[0] + radii[1] + gap)
    }

    /// Hertz's law of a ball on a plane.
    fn law_on_plane(&self, ball: usize, plane: usize, gap: f64) -> PressLaw {
        let radius = self.balls[ball].radius;
        let contact = HertzContact {
            inverse_mass: self.traits[ball].inverse_mass,
            relative_radii: [radius; 2],
            compliance: self.compliances[ball] + self.planes[plane].compliance,
            speed: 1.0,
        };
        let pair = self.pairs.of(self.traits[ball].material, self.planes[plane].material);
        press_law(&contact, pair.restitution, pair.friction, radius + gap)
    }

    /// Hertz's contact time \[s\].
    pub(super) fn contact_time(&self, law: &PressLaw, inverse_mass: f64, speed: f64) -> f64 {
        let speed = speed.max(SLOWEST);
        let approach = (1.25 * speed * speed / (inverse_mass * law.stiffness)).powf(0.4);
        clangor_core::contact::hertz_pulse::DURATION_OVER_APPROACH_TIME * approach / speed
    }

    fn plane(&self, index: usize) -> Plane {
        let plane = &self.planes[index];
        Plane { normal: plane.normal, offset: plane.offset, material: plane.material }
    }
}

/// Steps per contact time.
pub(super) fn steps_per_contact(compliance: Compliance) -> f64 {
    compliance.steps
}

/// A plane, copied out of the engine.
struct Plane {
    normal: DVec3,
    offset: f64,
    material: u32,
}

fn press_law(contact: &HertzContact, restitution: f64, friction: f64, reach: f64) -> PressLaw {
    let stiffness = contact.stiffness();
    let damping = restitution_damping(restitution) * (stiffness / contact.inverse_mass).sqrt();
    PressLaw { stiffness, damping, friction, reach }
}

/// Logs a contact that is over.
fn close(mut open: OpenContact, recorder: &mut Recorder<'_>) -> std::io::Result<()> {
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
