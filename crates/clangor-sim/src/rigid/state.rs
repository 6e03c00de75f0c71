//! The state of a body inside a step.
//!
//! A step of length Δt starts at t = 0. Between impulses a body flies freely through the pose (x_m, q_m) that
//! it has, or would have, at the middle of the step:
//!
//! `x(t) = x_m + u (t − Δt/2) + g t²/2`, `v(t) = u + g t`, `q(t) =` torque-free rotation of q_m by `t −
//! Δt/2`.
//!
//! Gravity is thus excluded from (x_m, u): a resting body has its rest position as x_m, and u = 0. An impulse
//! at t* is applied at the exact pose of t*, and the new flight is carried back to the middle:
//! [`BodyState::redirect`]. After the collision phase u becomes the velocity at the end of the step by `u +=
//! g Δt`, and the contact phase acts at (x_m, q_m).

use clangor_core::body::{Body, BodyId, Guide, Motion};
use clangor_core::pose::{Pose, Track};
use clangor_core::timeline::PoseRow;
use glam::{DMat3, DQuat, DVec3};

use super::flight::{angular_velocity, turn};
use super::mover::Mover;

/// Inertias that differ by less than this fraction are equal.
const ISOTROPY: f64 = 1e-12;

/// Law of motion of a body.
pub(super) enum Drive {
    Free,
    Fixed,
    Keyframed(Track),
    /// Free, but led along a track with at most this force \[N\] (`grip`).
    Gripped(Track, f64),
    /// The body has broken; only its index remains.
    Gone,
}

/// A body as it flies through a step.
pub(super) struct BodyState {
    pub(super) drive: Drive,
    /// When a track lets it go \[s\].
    let_go: Option<f64>,
    pub(super) shape: usize,
    /// Radius of the bounding ball about the centre of mass \[m\].
    pub(super) radius: f64,
    pub(super) mass: f64,
    inverse_inertia: DMat3,
    isotropic: bool,

    /// Pose at the start of the step.
    pub(super) position: DVec3,
    pub(super) orientation: DQuat,
    /// u in the collision phase, the velocity at the end of the step after it \[m/s\].
    pub(super) velocity: DVec3,
    /// About the centre of mass, world \[N m s\].
    pub(super) momentum: DVec3,
    /// Pose at the middle of the step, and derived quantities.
    pub(super) mid_position: DVec3,
    pub(super) mid_orientation: DQuat,
    pub(super) angular_velocity: DVec3,
    pub(super) world_inverse_inertia: DMat3,

    /// Time of the last impulse in this step \[s\].
    pub(super) last_hit: f64,
    /// Bound on the travel of its surface since the broad phase \[m\].
    pub(super) moved: f64,
    /// Travel that the broad phase allows \[m\].
    pub(super) margin: f64,
    pub(super) asleep: bool,
    /// Time for which it has been slow \[s\].
    pub(super) quiet: f64,
    /// Bodies that fell asleep together wake together.
    pub(super) island: usize,
    /// Velocities before the forces of the step [m/s, rad/s].
    pub(super) unforced: [DVec3; 2],
    /// What springs and loads changed of them [m/s, rad/s]; of a body on joints, all forces with the
    /// answer of its joints.
    pub(super) pushed: [DVec3; 2],
}

/// A body at one instant of a step.
#[derive(Clone, Copy)]
pub(super) struct Instant {
    pub(super) position: DVec3,
    pub(super) orientation: DQuat,
    pub(super) velocity: DVec3,
    pub(super) angular_velocity: DVec3,
    pub(super) momentum: DVec3,
    pub(super) inverse_mass: f64,
    pub(super) inverse_inertia: DMat3,
}

impl Instant {
    /// The body with this number at this time \[s\].
    pub(super) fn pose_row(&self, time: f64, body: usize) -> PoseRow {
        PoseRow {
            time,
            body: BodyId(body as u32),
            position: self.position,
            orientation: self.orientation,
            velocity: self.velocity,
            angular_velocity: self.angular_velocity,
        }
    }

    /// Velocity of the material point at `arm` from the centre of mass.
    pub(super) fn velocity_at(&self, arm: DVec3) -> DVec3 {
        self.velocity + self.angular_velocity.cross(arm)
    }

    /// The velocities that impulses change.
    pub(super) fn mover(&self) -> Mover {
        Mover {
            velocity: self.velocity,
            spin: self.angular_velocity,
            inverse_mass: self.inverse_mass,
            inverse_inertia: self.inverse_inertia,
        }
    }
}

impl BodyState {
    /// The initial state of a body; `Err` states what is wrong with it.
    pub(super) fn try_new(body: &Body, shape: usize, radius: f64) -> Result<Self, &'static str> {
        let drive = match &body.motion {
            Motion::Free => Drive::Free,
            Motion::Fixed => Drive::Fixed,
            Motion::Keyframed(track) => Drive::Keyframed(track.clone()),
            Motion::Guided(Guide { track, press: Some(press), .. }) => Drive::Gripped(track.clone(), *press),
            Motion::Guided(Guide { track, press: None, .. }) => Drive::Keyframed(track.clone()),
        };
        let let_go = if let Motion::Guided(guide) = &body.motion { guide.let_go } else { None };
        let free = matches!(drive, Drive::Free);
        let movable = body.motion.is_movable();
        let inverse_inertia = if movable { body.inertia.inverse() } else { DMat3::ZERO };
        if movable {
            let definite = body.inertia.determinant() > 0.0
                && body.inertia.to_cols_array().iter().all(|x| x.is_finite())
                && (0..3).all(|i| body.inertia.col(i)[i] > 0.0);
            if !(body.mass > 0.0 && body.mass.is_finite()) {
                return Err("has no positive mass");
            }
            if !definite || !inverse_inertia.is_finite() {
                return Err("has no positive inertia");
            }
            if !radius.is_finite() {
                return Err("is a half-space that is not fixed");
            }
        } else if !radius.is_finite() && !matches!(drive, Drive::Fixed) {
            return Err("is a half-space that is not fixed");
        }
        let (pose, velocity, spin) = match &drive {
            Drive::Keyframed(track) => (track.sample(0.0).0, DVec3::ZERO, DVec3::ZERO),
            Drive::Gripped(track, _) => track.sample(0.0),
            Drive::Free => (body.pose, body.velocity, body.angular_velocity),
            Drive::Fixed | Drive::Gone => (body.pose, DVec3::ZERO, DVec3::ZERO),
        };
        if !pose.position.is_finite() || !(pose.orientation.length() - 1.0).abs().le(&1e-6) {
            return Err("has no proper pose");
        }
        let orientation = pose.orientation.normalize();
        let trace = body.inertia.col(0).x + body.inertia.col(1).y + body.inertia.col(2).z;
        let deviation = body.inertia - DMat3::from_diagonal(DVec3::splat(trace / 3.0));
        let isotropic = deviation.to_cols_array().iter().all(|d| d.abs() <= ISOTROPY * trace);
        let to_body = orientation.inverse() * spin;
        let has_momentum = free || matches!(drive, Drive::Gripped(..));
        Ok(BodyState {
            momentum: if has_momentum { orientation * (body.inertia * to_body) } else { DVec3::ZERO },
            velocity,
            angular_velocity: spin,
            drive,
            let_go,
            shape,
            radius,
            mass: body.mass,
            inverse_inertia,
            isotropic,
            position: pose.position,
            orientation,
            mid_position: pose.position,
            mid_orientation: orientation,
            world_inverse_inertia: DMat3::ZERO,
            last_hit: 0.0,
            moved: 0.0,
            margin: 0.0,
            asleep: false,
            quiet: 0.0,
            island: usize::MAX,
            unforced: [DVec3::ZERO; 2],
            pushed: [DVec3::ZERO; 2],
        })
    }

    /// Whether impulses move it.
    pub(super) fn is_free(&self) -> bool {
        matches!(self.drive, Drive::Free | Drive::Gripped(..))
    }

    /// Whether impulses move it, now or once it is let go.
    pub(super) fn is_movable(&self) -> bool {
        self.is_free() || self.let_go.is_some()
    }

    /// The track along which it is led, and the largest force \[N\].
    pub(super) fn grip(&self) -> Option<(&Track, f64)> {
        if let Drive::Gripped(track, press) = &self.drive { Some((track, *press)) } else { None }
    }

    /// Lets the body go if its time has come by the start of a step; it keeps the velocity of its track.
    /// Returns whether it did.
    pub(super) fn release(&mut self, time: f64, step: f64) -> bool {
        if self.let_go.is_none_or(|let_go| let_go > time + 0.5 * step) {
            return false;
        }
        self.let_go = None;
        if let Drive::Keyframed(track) = &self.drive {
            let (pose, velocity, spin) = track.sample(time);
            (self.position, self.orientation) = (pose.position, pose.orientation.normalize());
            let to_body = self.orientation.inverse() * spin;
            self.velocity = velocity;
            self.momentum = self.orientation * (self.inverse_inertia.inverse() * to_body);
        }
        self.drive = Drive::Free;
        true
    }

    /// Whether its pose may ever change.
    pub(super) fn can_move(&self) -> bool {
        match &self.drive {
            Drive::Free | Drive::Gripped(..) => true,
            Drive::Fixed | Drive::Gone => false,
            Drive::Keyframed(track) => !track.is_fixed() || self.let_go.is_some(),
        }
    }

    /// Whether it has broken.
    pub(super) fn is_gone(&self) -> bool {
        matches!(self.drive, Drive::Gone)
    }

    /// Removes the body; its index stays.
    pub(super) fn vanish(&mut self) {
        self.drive = Drive::Gone;
        self.asleep = false;
    }

    /// Whether impulses and gravity move it at present.
    pub(super) fn is_awake(&self) -> bool {
        self.is_free() && !self.asleep
    }

    /// Whether its pose changes in this step.
    pub(super) fn is_moving(&self) -> bool {
        !self.asleep && self.can_move()
    }

    pub(super) fn inverse_mass(&self) -> f64 {
        if self.is_awake() { 1.0 / self.mass } else { 0.0 }
    }

    /// `gravity` if the body is awake, else zero.
    pub(super) fn gravity(&self, gravity: DVec3) -> DVec3 {
        if self.is_awake() { gravity } else { DVec3::ZERO }
    }

    /// Bound on the speed of any point of it \[m/s\].
    pub(super) fn surface_speed(&self) -> f64 {
        self.velocity.length() + self.spin_speed()
    }

    /// Bound on the speed of any point of it due to rotation \[m/s\].
    pub(super) fn spin_speed(&self) -> f64 {
        if self.radius.is_finite() { self.angular_velocity.length() * self.radius } else { 0.0 }
    }

    /// Kinetic energy at the start of the step \[J\].
    pub(super) fn kinetic_energy(&self) -> f64 {
        if !self.is_free() {
            return 0.0;
        }
        let spin = angular_velocity(self.orientation, self.momentum, &self.inverse_inertia);
        0.5 * self.mass * self.velocity.length_squared() + 0.5 * self.momentum.dot(spin)
    }

    /// Angular velocity at the start of the step \[rad/s\].
    pub(super) fn start_angular_velocity(&self) -> DVec3 {
        match &self.drive {
            Drive::Free | Drive::Gripped(..) => {
                angular_velocity(self.orientation, self.momentum, &self.inverse_inertia)
            }
            _ => self.angular_velocity,
        }
    }

    /// Prepares the middle of the step that starts at `time`.
    pub(super) fn begin_step(&mut self, time: f64, step: f64) {
        self.last_hit = 0.0;
        match &self.drive {
            Drive::Free | Drive::Gripped(..) if !self.asleep => {
                self.mid_position = self.position + self.velocity * (0.5 * step);
                self.mid_orientation = self.turned(self.orientation, 0.5 * step);
                self.refresh_middle();
            }
            Drive::Keyframed(track) => {
                let (pose, velocity, spin) = track.sample(time + 0.5 * step);
                (self.mid_position, self.mid_orientation) = (pose.position, pose.orientation);
                (self.velocity, self.angular_velocity) = (velocity, spin);
            }
            _ => {}
        }
        if self.is_moving() {
            self.moved += self.surface_speed() * step;
        }
    }

    /// Moves to the end of the step, at `end` \[s\]. The velocity is now that of the end.
    pub(super) fn end_step(&mut self, end: f64, step: f64) {
        match &self.drive {
            Drive::Free | Drive::Gripped(..) if !self.asleep => {
                self.position = self.mid_position + self.velocity * (0.5 * step);
                self.orientation = self.turned(self.mid_orientation, 0.5 * step);
            }
            Drive::Keyframed(track) => {
                let (pose, velocity, spin) = track.sample(end);
                (self.position, self.orientation) = (pose.position, pose.orientation);
                (self.velocity, self.angular_velocity) = (velocity, spin);
            }
            _ => {}
        }
    }

    /// Recomputes inverse inertia and angular velocity at the middle of the step.
    pub(super) fn refresh_middle(&mut self) {
        let rotation = DMat3::from_quat(self.mid_orientation);
        self.world_inverse_inertia = rotation * self.inverse_inertia * rotation.transpose();
        self.angular_velocity = self.world_inverse_inertia * self.momentum;
    }

    /// Pose at `t` of the step, gravity left out.
    pub(super) fn weightless_pose(&self, time: f64, step: f64, t: f64) -> (DVec3, DQuat) {
        let from_middle = t - 0.5 * step;
        match &self.drive {
            _ if from_middle == 0.0 => (self.mid_position, self.mid_orientation),
            Drive::Free | Drive::Gripped(..) if !self.asleep => (
                self.mid_position + self.velocity * from_middle,
                self.turned(self.mid_orientation, from_middle),
            ),
            Drive::Keyframed(track) => {
                let pose = track.sample(time + t).0;
                (pose.position, pose.orientation)
            }
            _ => (self.mid_position, self.mid_orientation),
        }
    }

    /// The body at `t` of the step, exactly.
    pub(super) fn at(&self, time: f64, step: f64, t: f64, gravity: DVec3) -> Instant {
        let (mut position, orientation) = self.weightless_pose(time, step, t);
        let mut instant = Instant {
            position,
            orientation,
            velocity: self.velocity,
            angular_velocity: self.angular_velocity,
            momentum: self.momentum,
            inverse_mass: 0.0,
            inverse_inertia: DMat3::ZERO,
        };
        match &self.drive {
            Drive::Free | Drive::Gripped(..) if !self.asleep => {
                position += gravity * (0.5 * t * t);
                let rotation = DMat3::from_quat(orientation);
                instant.position = position;
                instant.velocity += gravity * t;
                instant.inverse_mass = 1.0 / self.mass;
                instant.inverse_inertia = rotation * self.inverse_inertia * rotation.transpose();
                instant.angular_velocity = instant.inverse_inertia * self.momentum;
            }
            Drive::Keyframed(track) => {
                (_, instant.velocity, instant.angular_velocity) = track.sample(time + t);
            }
            _ => {}
        }
        instant
    }

    /// Continues from `instant`, the state right after an impulse at `t`.
    pub(super) fn redirect(&mut self, step: f64, t: f64, instant: &Instant, gravity: DVec3) {
        let to_middle = 0.5 * step - t;
        self.velocity = instant.velocity - gravity * t;
        self.momentum = instant.momentum;
        self.mid_position = instant.position + self.velocity * to_middle - gravity * (0.5 * t * t);
        self.mid_orientation = self.turned(instant.orientation, to_middle);
        self.refresh_middle();
        self.last_hit = t;
    }

    /// What changes of the momentum \[N s\] and the angular momentum \[N m s\] add to the kinetic energy
    /// \[J\].
    pub(super) fn energy_gain(&self, momentum: DVec3, angular: DVec3) -> f64 {
        let velocity = self.velocity + momentum / self.mass;
        let turned = self.momentum + angular;
        let spin = angular_velocity(self.orientation, turned, &self.inverse_inertia);
        0.5 * self.mass * velocity.length_squared() + 0.5 * turned.dot(spin) - self.kinetic_energy()
    }

    /// Makes these changes.
    pub(super) fn push(&mut self, momentum: DVec3, angular: DVec3) {
        self.velocity += momentum / self.mass;
        self.momentum += angular;
    }

    /// Applies an impulse and an angular impulse at the middle of the step, if the body is awake.
    pub(super) fn kick(&mut self, impulse: DVec3, angular: DVec3) {
        if self.is_awake() {
            self.velocity += impulse * self.inverse_mass();
            self.momentum += angular;
            self.angular_velocity = self.world_inverse_inertia * self.momentum;
        }
    }

    /// Applies an impulse of a spring or a load: that of a whole step.
    pub(super) fn push_for_step(&mut self, impulse: DVec3, angular: DVec3) {
        let before = [self.velocity, self.angular_velocity];
        self.kick(impulse, angular);
        self.pushed[0] += self.velocity - before[0];
        self.pushed[1] += self.angular_velocity - before[1];
    }

    /// What pushes changed of the velocity of the point at `arm` from the centre of mass \[m/s\].
    pub(super) fn pushed_at(&self, arm: DVec3) -> DVec3 {
        self.pushed[0] + self.pushed[1].cross(arm)
    }

    /// Upper bound of the inverse effective mass at a point \[m, body frame\], in all directions \[1/kg\].
    pub(super) fn largest_inverse_mass_at(&self, at: DVec3) -> f64 {
        if !self.is_movable() {
            return 0.0;
        }
        let softest = (0..3).map(|k| self.inverse_inertia.col(k).length()).sum::<f64>();
        self.mass.recip() + at.length_squared() * softest
    }

    /// Its pose at the start of the step.
    pub(super) fn start_pose(&self) -> Pose {
        Pose { position: self.position, orientation: self.orientation }
    }

    /// Its pose at the middle of the step.
    pub(super) fn middle_pose(&self) -> Pose {
        Pose { position: self.mid_position, orientation: self.mid_orientation }
    }

    /// The velocities that impulses change at the middle of the step.
    pub(super) fn mover(&self) -> Mover {
        Mover {
            velocity: self.velocity,
            spin: self.angular_velocity,
            inverse_mass: self.inverse_mass(),
            inverse_inertia: if self.is_awake() { self.world_inverse_inertia } else { DMat3::ZERO },
        }
    }

    /// The pose at the middle of the next step, after this one from `time` \[s\], if the velocities at the
    /// middle become those of `mover`.
    pub(super) fn next_middle(&self, mover: &Mover, time: f64, step: f64) -> Pose {
        if !self.is_awake() {
            let (position, orientation) = self.weightless_pose(time, step, 1.5 * step);
            return Pose { position, orientation };
        }
        let momentum = self.world_inverse_inertia.inverse() * mover.spin;
        Pose {
            position: self.mid_position + mover.velocity * step,
            orientation: turn(self.mid_orientation, momentum, &self.inverse_inertia, self.isotropic, step),
        }
    }

    /// Stops the body when it falls asleep.
    pub(super) fn stop(&mut self) {
        self.velocity = DVec3::ZERO;
        self.momentum = DVec3::ZERO;
        self.angular_velocity = DVec3::ZERO;
        (self.mid_position, self.mid_orientation) = (self.position, self.orientation);
        let rotation = DMat3::from_quat(self.orientation);
        self.world_inverse_inertia = rotation * self.inverse_inertia * rotation.transpose();
    }

    pub(super) fn is_finite(&self) -> bool {
        self.position.is_finite()
            && self.orientation.is_finite()
            && self.velocity.is_finite()
            && self.momentum.is_finite()
    }

    fn turned(&self, orientation: DQuat, duration: f64) -> DQuat {
        turn(orientation, self.momentum, &self.inverse_inertia, self.isotropic, duration)
    }
}
