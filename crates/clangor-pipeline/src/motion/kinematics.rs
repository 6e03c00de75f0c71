//! Velocities of a recorded body between its frames, their jumps beyond gravity, and its free flight
//! continued past a frame.
//!
//! ```text
//! vₖ = (xₖ₊₁ − xₖ) / h        Lₖ = R I Rᵀ ωₖ  in the middle of the frame
//! Δvₖ = vₖ − vₖ₋₁ − g h̄      ΔLₖ = Lₖ − Lₖ₋₁
//! x(t) = xₖ + v τ + g (τ² + h τ) / 2        L constant, ω = R I⁻¹ Rᵀ L
//! ```
//!
//! In free flight both jumps are zero: vₖ is the velocity in the middle of the frame exactly, ωₖ to second
//! order in the angle of a frame. An impulse J between frames k and k+1 gives Δvₖ + Δvₖ₊₁ = J / m.
//!
//! Before the first frame there is no velocity. A body that is released at rest there has
//! Δv₀ = v₀ − g h/2 and ΔL₀ = L₀, which are zero unless something hits it in its first frame.

use std::ops::Range;

use clangor_core::pose::Pose;
use glam::{DMat3, DQuat, DVec3};

use super::recording::Frame;
use super::soft_contacts::{FrameChange, gather, soft_pushes};

/// Steps of the rotation over one continued frame.
const ROTATION_STEPS: u32 = 8;

/// Distances of a push from the weight, over the weight, up to which it supports and holds the body.
const SUPPORTED: f64 = 0.5;
const HELD: f64 = 0.05;
/// The same distance of a single push in noise, in deviations of one axis; most frames whose mean is asked
/// then; and the noise of the mean of n pushes, times n, over that of one: neighbours share their noise.
const IN_NOISE: f64 = 4.0;
const MOST_IN_MEAN: usize = 16;
const OF_MEAN: f64 = 0.82;
/// Largest ratio of the pushes of two frames of a force that lasts, and the least cosine between them.
const ALIKE_SIZE: f64 = 3.0;
const ALIKE_DIRECTION: f64 = 0.8;

/// Mass of a body and what moves it between impacts.
#[derive(Clone, Copy, Debug)]
pub(super) struct Inertia {
    /// \[kg\].
    pub(super) mass: f64,
    /// About the centre of mass, body frame [kg m²].
    inertia: DMat3,
    /// Its inverse.
    inverse: DMat3,
    /// Gravity [m/s²].
    pub(super) gravity: DVec3,
}

impl Inertia {
    /// Of a mass \[kg\] with an inertia about its centre [kg m², body], under gravity [m/s²].
    pub(super) fn new(mass: f64, inertia: DMat3, gravity: DVec3) -> Self {
        Inertia { mass, inertia, inverse: inertia.inverse(), gravity }
    }

    /// I⁻¹ of a body turned by `orientation`, world frame.
    pub(super) fn inverse_at(&self, orientation: DQuat) -> DMat3 {
        let rotation = DMat3::from_quat(orientation);
        rotation * self.inverse * rotation.transpose()
    }

    /// A jump of the velocity [m/s] and the angular momentum [kg m²/s] of a body turned by `orientation`.
    fn jump(&self, (velocity, angular_momentum): (DVec3, DVec3), orientation: DQuat, span: f64) -> Jump {
        if angular_momentum == DVec3::ZERO {
            return Jump { velocity, angular_momentum, size: velocity.length(), span };
        }
        let own = orientation.inverse() * angular_momentum;
        let turning = own.dot(self.inverse * own).max(0.0) / self.mass;
        Jump { velocity, angular_momentum, size: (velocity.length_squared() + turning).sqrt(), span }
    }
}

/// Position and motion of a body at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct State {
    /// Pose.
    pub(super) pose: Pose,
    /// [m/s].
    pub(super) velocity: DVec3,
    /// World [rad/s].
    pub(super) angular_velocity: DVec3,
}

impl State {
    /// Velocity of the point of the body at `point` [m, world].
    pub(super) fn velocity_at(&self, point: DVec3) -> DVec3 {
        self.velocity + self.angular_velocity.cross(point - self.pose.position)
    }
}

/// Mean motion between two frames.
#[derive(Clone, Copy, Debug)]
pub(super) struct Interval {
    /// \[s\].
    pub(super) length: f64,
    /// [m/s].
    pub(super) velocity: DVec3,
    /// World [rad/s].
    pub(super) angular_velocity: DVec3,
    /// World [kg m²/s].
    angular_momentum: DVec3,
}

/// Change of motion at a frame beyond that of free flight.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Jump {
    /// Δv [m/s].
    pub(super) velocity: DVec3,
    /// ΔL [kg m²/s].
    pub(super) angular_momentum: DVec3,
    /// √(Δv² + ΔL·I⁻¹ΔL / m) [m/s].
    pub(super) size: f64,
    /// Mean length of the frames before and after \[s\].
    pub(super) span: f64,
}

/// How a recorded body begins in its first frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Start {
    /// At rest or in motion, as its first jumps say.
    Unknown,
    /// Something holds it, so that it is not released.
    Carried,
    /// It is released at rest, and lands after this part of the frame.
    Falls(f64),
}

/// A recorded body with its velocities and jumps.
pub(super) struct Kinematics<'a> {
    pub(super) frames: &'a [Frame],
    pub(super) inertia: Inertia,
    pub(super) intervals: Vec<Interval>,
    /// One for each frame; zero at the first and the last. Soft pushes are one jump (`soft_contacts`).
    pub(super) jumps: Vec<Jump>,
    /// The frames of pushes that are taken as one jump, in order.
    pub(super) soft: Vec<Range<usize>>,
    /// What impacts that are found have not yet explained of the jumps.
    pub(super) left: Vec<Jump>,
    /// Jump at the first frame of a body that is released at rest there.
    pub(super) release: Jump,
    /// How it begins there.
    pub(super) start: Start,
    /// Index of the last frame that is no repetition of the one before.
    pub(super) last_key: usize,
    /// Deviation of Δv on one axis that is noise [m/s].
    noise: f64,
}

impl<'a> Kinematics<'a> {
    pub(super) fn new(frames: &'a [Frame], inertia: Inertia) -> Self {
        let intervals: Vec<Interval> = frames.windows(2).map(|w| interval(&w[0], &w[1], &inertia)).collect();
        let mut changes = vec![FrameChange::default(); frames.len()];
        for (k, pair) in intervals.windows(2).enumerate() {
            let span = 0.5 * (pair[0].length + pair[1].length);
            let velocity = pair[1].velocity - pair[0].velocity - inertia.gravity * span;
            let angular_momentum = pair[1].angular_momentum - pair[0].angular_momentum;
            changes[k + 1] = FrameChange { velocity, angular_momentum, span };
        }
        let soft = soft_pushes(&changes, inertia.gravity);
        soft.iter().for_each(|push| gather(&mut changes, push.clone(), inertia.gravity));
        let jump = |(change, frame): (&FrameChange, &Frame)| {
            let of_motion = (change.velocity, change.angular_momentum);
            inertia.jump(of_motion, frame.pose.orientation, change.span)
        };
        let jumps: Vec<Jump> = changes.iter().zip(frames).map(jump).collect();
        let release = intervals.first().map_or_else(Jump::default, |first| {
            let span = 0.5 * first.length;
            let velocity = first.velocity - inertia.gravity * span;
            inertia.jump((velocity, first.angular_momentum), frames[0].pose.orientation, span)
        });
        let held = frames.iter().rev().zip(frames.iter().rev().skip(1)).take_while(|(b, a)| b.row == a.row);
        let last_key = frames.len().saturating_sub(1 + held.count());
        let left = jumps.clone();
        let (start, noise) = (Start::Unknown, 0.0);
        Kinematics { frames, inertia, intervals, jumps, soft, left, release, start, last_key, noise }
    }

    /// The same where the deviation of Δv on one axis is noise [m/s].
    pub(super) fn set_noise(&mut self, noise: f64) {
        self.noise = noise;
    }

    /// Jump that noise alone makes of a steady push [m/s].
    pub(super) fn noisy_jump(&self) -> f64 {
        IN_NOISE * self.noise
    }

    /// Nothing is left of the jump at a frame.
    pub(super) fn clear(&mut self, frame: usize) {
        self.left[frame] = Jump { span: self.left[frame].span, ..Jump::default() };
    }

    /// Takes an impulse at an instant from what is left: its change of the velocity [m/s] and of the angular
    /// momentum [kg m²/s].
    pub(super) fn explain(&mut self, time: f64, (velocity, angular_momentum): (DVec3, DVec3)) {
        let Some(index) = self.interval_at(time).filter(|_| self.is_recorded_at(time)) else { return };
        let part = (time - self.frames[index].time) / self.intervals[index].length;
        let rest = |jump: &Jump, share: f64| {
            (jump.velocity - velocity * share, jump.angular_momentum - angular_momentum * share)
        };
        if index == 0 {
            let Jump { span, .. } = self.release;
            let orientation = self.frames[0].pose.orientation;
            self.release = self.inertia.jump(rest(&self.release, 1.0 - part), orientation, span);
        }
        for (k, share) in [(index, 1.0 - part), (index + 1, part)] {
            if k > 0 && k + 1 < self.frames.len() {
                let orientation = self.frames[k].pose.orientation;
                self.left[k] = self.inertia.jump(rest(&self.left[k], share), orientation, self.left[k].span);
            }
        }
    }

    /// The interval that holds a time; the first or last outside.
    pub(super) fn interval_at(&self, time: f64) -> Option<usize> {
        let (frames, last) = (self.frames, self.intervals.len().checked_sub(1)?);
        // Frames of even rate need no search.
        let part = (time - frames[0].time) / (frames[last + 1].time - frames[0].time);
        let guess = (part * (last + 1) as f64) as usize;
        let holds = |k: usize| k <= last && frames[k].time <= time && time < frames[k + 1].time;
        let near = [guess, guess.saturating_sub(1), guess + 1].into_iter().find(|k| holds(*k));
        let search = || frames.partition_point(|frame| frame.time <= time).saturating_sub(1).min(last);
        Some(near.unwrap_or_else(search))
    }

    /// A ball that holds the centre of the body at all instants within two frames of `time`: centre and
    /// radius \[m\].
    pub(super) fn way_around(&self, time: f64) -> Option<(DVec3, f64)> {
        let index = self.interval_at(time)?;
        let near = &self.intervals[index.saturating_sub(3)..(index + 4).min(self.intervals.len())];
        let speed = near.iter().map(|interval| interval.velocity.length()).fold(0.0, f64::max);
        let span = near.iter().map(|interval| interval.length).fold(0.0, f64::max);
        let fall = self.inertia.gravity.length() * span;
        Some((self.frames[index].pose.position, 4.0 * span * (speed + 2.0 * fall)))
    }

    /// The motion of interval `index` continued to `time` with the acceleration that the body had before it.
    pub(super) fn continued(&self, index: usize, time: f64) -> State {
        let (interval, end) = (self.intervals[index], self.frames[index + 1]);
        let tau = time - end.time;
        let acceleration = self.acceleration_before(index);
        let h = interval.length;
        let position =
            end.pose.position + interval.velocity * tau + acceleration * (0.5 * (tau * tau + h * tau));
        let velocity = interval.velocity + acceleration * (tau + 0.5 * h);
        let mut orientation = end.pose.orientation;
        let step = tau / f64::from(ROTATION_STEPS);
        let momentum = interval.angular_momentum;
        let spin = |q: DQuat| self.inertia.inverse_at(q) * momentum;
        for _ in 0..ROTATION_STEPS {
            let middle = DQuat::from_scaled_axis(spin(orientation) * (0.5 * step)) * orientation;
            orientation = (DQuat::from_scaled_axis(spin(middle) * step) * orientation).normalize();
        }
        State { pose: Pose { position, orientation }, velocity, angular_velocity: spin(orientation) }
    }

    /// A body that is released at rest in its first frame, falling at `time`.
    pub(super) fn released(&self, time: f64) -> State {
        let Frame { time: start, pose, .. } = self.frames[0];
        let (tau, gravity) = (time - start, self.inertia.gravity);
        let pose = Pose { position: pose.position + gravity * (0.5 * tau * tau), ..pose };
        State { pose, velocity: gravity * tau, angular_velocity: DVec3::ZERO }
    }

    /// Gravity in free flight; nothing where a support has held the body in the frame before.
    fn acceleration_before(&self, index: usize) -> DVec3 {
        let gravity = self.inertia.gravity;
        if self.is_supported(index) { DVec3::ZERO } else { gravity }
    }

    /// Whether a steady force has cancelled gravity at the frame at which interval `index` begins.
    pub(super) fn is_supported(&self, index: usize) -> bool {
        index == 0 && self.start == Start::Carried || self.is_weight(index, SUPPORTED)
    }

    /// The same more strictly, by which what rests or is carried is told from what rattles; not at the ends.
    pub(super) fn is_held(&self, index: usize) -> bool {
        index > 0
            && index + 1 < self.frames.len()
            && self.beyond_weight(index).length() < self.allowed(index, HELD)
    }

    /// Whether it is held beside an impact: noise that is not known from a steady moment would take what
    /// rattles for held elsewhere.
    pub(super) fn is_held_in_noise(&self, index: usize) -> bool {
        index > 0 && index + 1 < self.frames.len() && self.is_weight(index, HELD)
    }

    /// What the push at a frame has beyond the weight [m/s].
    fn beyond_weight(&self, index: usize) -> DVec3 {
        self.jumps[index].velocity + self.inertia.gravity * self.jumps[index].span
    }

    /// This share of the weight in a frame [m/s].
    fn allowed(&self, index: usize, within: f64) -> f64 {
        within * self.inertia.gravity.length() * self.jumps[index].span
    }

    /// Whether the push at a frame is the weight, within this share of it. Where noise exceeds that share,
    /// the mean of the frames from it on, or of those up to it, says so.
    fn is_weight(&self, index: usize, within: f64) -> bool {
        let (allowed, beyond) = (self.allowed(index, within), self.beyond_weight(index).length());
        if self.noisy_jump() <= allowed || allowed <= 0.0 || beyond >= allowed + self.noisy_jump() {
            return beyond < allowed;
        }
        let count = (OF_MEAN * self.noisy_jump() / allowed).ceil() as usize + 1;
        let count = count.min(MOST_IN_MEAN);
        let ends = [index.checked_sub(count - 1), Some(index)];
        ends.into_iter().flatten().any(|first| {
            let is_inside = first > 0 && first + count < self.frames.len();
            let sum = || (first..first + count).map(|k| self.beyond_weight(k)).sum::<DVec3>();
            is_inside && sum().length() < allowed * count as f64 + OF_MEAN * self.noisy_jump()
        })
    }

    /// Whether a time lies between the first frame and the last.
    pub(super) fn is_recorded_at(&self, time: f64) -> bool {
        let ends = self.frames.first().zip(self.frames.last());
        ends.is_some_and(|(first, last)| (first.time..=last.time).contains(&time))
    }

    /// State at a time in a frame without an impact: the frame before continued; the means of the frame where
    /// that has a jump, or none is before it. Outside the frames the body rests in its first or last pose.
    pub(super) fn at(&self, time: f64) -> Option<State> {
        let index = self.interval_at(time)?;
        if !self.is_recorded_at(time) {
            let end = if time < self.frames[0].time { 0 } else { self.frames.len() - 1 };
            let pose = self.frames[end].pose;
            return Some(State { pose, velocity: DVec3::ZERO, angular_velocity: DVec3::ZERO });
        }
        let jump = self.jumps[index];
        let is_smooth = jump.size < 2.0 * self.inertia.gravity.length() * jump.span;
        if index > 0 && is_smooth {
            return Some(self.continued(index - 1, time));
        }
        let (from, interval) = (self.frames[index], self.intervals[index]);
        let tau = (time - from.time).clamp(0.0, interval.length);
        let position = from.pose.position + interval.velocity * tau;
        let turn = DQuat::from_scaled_axis(interval.angular_velocity * tau);
        let orientation = (turn * from.pose.orientation).normalize();
        let Interval { velocity, angular_velocity, .. } = interval;
        Some(State { pose: Pose { position, orientation }, velocity, angular_velocity })
    }
}

/// Whether the pushes of two frames that follow each other may be those of a force that lasts.
pub(super) fn go_over(push: DVec3, next: DVec3) -> bool {
    let (one, two) = (push.length(), next.length());
    one.max(two) < ALIKE_SIZE * one.min(two) && push.dot(next) > ALIKE_DIRECTION * one * two
}

fn interval(from: &Frame, to: &Frame, inertia: &Inertia) -> Interval {
    let length = to.time - from.time;
    let velocity = (to.pose.position - from.pose.position) / length;
    // What rests does not turn, which need not be computed.
    if from.pose.orientation == to.pose.orientation {
        let (angular_velocity, angular_momentum) = (DVec3::ZERO, DVec3::ZERO);
        return Interval { length, velocity, angular_velocity, angular_momentum };
    }
    let angular_velocity = from.pose.rotation_to(&to.pose) / length;
    // Half way on the shorter way from one rotation to the other.
    let (start, end) = (from.pose.orientation, to.pose.orientation);
    let middle = (start + if start.dot(end) < 0.0 { -end } else { end }).normalize();
    let angular_momentum = middle * (inertia.inertia * (middle.inverse() * angular_velocity));
    Interval { length, velocity, angular_velocity, angular_momentum }
}
