//! One joint at one instant: the directions that it blocks, and how far it is off.
//!
//! A joint holds a point a of a body and a point b of another one, or of the world. Each of its rows blocks
//! the relative velocity
//!
//! `d · (v_a − v_b) + τ_a · ω_a − τ_b · ω_b`,
//!
//! with `d` along an axis and `τ = arm × d` for the three rows that keep two points together, and `d = 0`,
//! `τ_a = τ_b = t` for the two rows of a hinge that block rotation about t across the axis. Rods and ropes
//! have one row, along the line between their ends. Rows of stiff springs give way (`stiff_spring`).

use clangor_core::body::{JointKind, Link, LinkEnd};
use clangor_core::pose::Pose;
use glam::DVec3;

use super::manifold::tangents;
use super::step_log::StepLog;
use super::stiff_spring::{Give, StiffSpring};

/// An end of a joint.
#[derive(Clone, Copy)]
pub(super) struct End {
    /// The body; `None` for the world.
    pub(super) body: Option<usize>,
    /// Its point \[m\], body frame, or world.
    at: DVec3,
}

/// A joint of the world.
pub(super) struct Joint {
    /// Near and far end.
    pub(super) ends: [End; 2],
    pub(super) kind: JointKind,
    /// The law of a stiff spring, which takes the place of its kind.
    pub(super) spring: Option<StiffSpring>,
    /// Axis of a hinge in the frame of the far end.
    far_axis: DVec3,
    pub(super) collide: bool,
}

/// The two ends at an instant.
pub(super) struct PlacedEnds {
    pub(super) points: [DVec3; 2],
    /// From the centres of mass to the points \[m\]; zero for the world.
    pub(super) arms: [DVec3; 2],
    axes: [DVec3; 2],
}

impl PlacedEnds {
    /// From the far end to the near one \[m\].
    pub(super) fn between(&self) -> DVec3 {
        self.points[0] - self.points[1]
    }
}

/// A direction that a joint blocks.
#[derive(Clone, Copy)]
pub(super) struct Blocked {
    pub(super) along: DVec3,
    pub(super) turning: [DVec3; 2],
}

impl Joint {
    /// The joint of a link, whose bodies have these poses at the start; `None` for a load, and for a spring
    /// that is not stiff.
    pub(super) fn of_link(
        link: &Link,
        spring: Option<StiffSpring>,
        poses: &dyn Fn(usize) -> Pose,
    ) -> Option<Self> {
        let (body, at, to, kind, collide) = match *link {
            Link::Hang { body, anchor } => {
                let length = poses(body.index()).position.distance(anchor);
                (body, DVec3::ZERO, LinkEnd::Point(anchor), JointKind::Rod { length }, true)
            }
            Link::Joint { body, at, to, kind, collide } => (body, at, to, kind, collide),
            Link::Spring { body, at, to, .. } => {
                let length = spring?.rest_length;
                (body, at, to, JointKind::Rod { length }, true)
            }
            Link::Load { .. } => return None,
        };
        let far = match to {
            LinkEnd::Point(at) => End { body: None, at },
            LinkEnd::Body { body, at } => End { body: Some(body.index()), at },
        };
        let far_axis = match kind {
            JointKind::Hinge { axis, .. } => {
                let world = poses(body.index()).orientation * axis;
                far.body.map_or(world, |body| poses(body).orientation.inverse() * world)
            }
            _ => DVec3::ZERO,
        };
        let near = End { body: Some(body.index()), at };
        Some(Joint { ends: [near, far], kind, spring, far_axis, collide })
    }

    /// Whether it only pulls.
    pub(super) fn is_rope(&self) -> bool {
        matches!(self.kind, JointKind::Rope { .. })
    }

    /// Its ends where the bodies have these poses.
    pub(super) fn placed(&self, poses: &dyn Fn(usize) -> Pose) -> PlacedEnds {
        let near_axis = if let JointKind::Hinge { axis, .. } = self.kind { axis } else { DVec3::ZERO };
        let place = |end: &End, axis: DVec3| match end.body {
            Some(body) => {
                let Pose { position, orientation } = poses(body);
                let arm = orientation * end.at;
                (position + arm, arm, orientation * axis)
            }
            None => (end.at, DVec3::ZERO, axis),
        };
        let [a, b] = [place(&self.ends[0], near_axis), place(&self.ends[1], self.far_axis)];
        PlacedEnds { points: [a.0, b.0], arms: [a.1, b.1], axes: [a.2, b.2] }
    }

    /// The directions that it blocks in a step \[s\].
    pub(super) fn blocked(&self, placed: &PlacedEnds, step: f64) -> Vec<Blocked> {
        let point = |along: DVec3| Blocked { along, turning: placed.arms.map(|arm| arm.cross(along)) };
        let turn = |about: DVec3| Blocked { along: DVec3::ZERO, turning: [about; 2] };
        if let Some(spring) = &self.spring {
            return spring.directions(placed.between(), step).into_iter().map(point).collect();
        }
        match self.kind {
            JointKind::Ball { .. } => DVec3::AXES.map(point).to_vec(),
            JointKind::Hinge { .. } => {
                let (one, two) = tangents(placed.axes[1]);
                DVec3::AXES.map(point).into_iter().chain([turn(one), turn(two)]).collect()
            }
            JointKind::Rod { .. } | JointKind::Rope { .. } => {
                vec![point(placed.between().normalize_or(DVec3::Y))]
            }
        }
    }

    /// How far the joint is off along each of its blocked directions \[m, or rad\]; a rope that is shorter
    /// than its length has a negative value.
    pub(super) fn errors(&self, placed: &PlacedEnds, blocked: &[Blocked]) -> Vec<f64> {
        let between = placed.between();
        if let Some(spring) = &self.spring {
            return spring.extensions(between, blocked.iter().map(|row| row.along));
        }
        match self.kind {
            JointKind::Rod { length } | JointKind::Rope { length } => vec![between.length() - length],
            JointKind::Ball { .. } | JointKind::Hinge { .. } => {
                let tilt = placed.axes[1].cross(placed.axes[0]);
                let off = |row: &Blocked| {
                    if row.along == DVec3::ZERO { tilt.dot(row.turning[0]) } else { between.dot(row.along) }
                };
                blocked.iter().map(off).collect()
            }
        }
    }

    /// How its rows give way in a step \[s\]; only those of springs do.
    pub(super) fn gives(&self, placed: &PlacedEnds, blocked: &[Blocked], step: f64) -> Vec<Option<Give>> {
        let Some(spring) = &self.spring else { return vec![None; blocked.len()] };
        let directions: Vec<DVec3> = blocked.iter().map(|row| row.along).collect();
        spring.gives(placed.between(), &directions, step).into_iter().map(Some).collect()
    }

    /// Energy \[J\] that it stores where the bodies have these poses; only a spring does.
    pub(super) fn stored(&self, poses: &dyn Fn(usize) -> Pose) -> f64 {
        self.spring.map_or(0.0, |spring| spring.energy(self.placed(poses).between().length()))
    }

    /// How far it is off, at most \[m, or rad\], where the bodies have these poses; NaN for a joint that is
    /// no number. A spring of any length is closed.
    pub(super) fn gap(&self, poses: &dyn Fn(usize) -> Pose) -> f64 {
        if self.spring.is_some() {
            return 0.0;
        }
        let placed = self.placed(poses);
        let errors = self.errors(&placed, &self.blocked(&placed, 0.0));
        let off =
            |error: f64| if self.is_rope() && error < 0.0 && error.is_finite() { 0.0 } else { error.abs() };
        // Unlike `max`, this keeps NaN.
        errors.into_iter().map(off).fold(0.0, |worst, error| if error <= worst { worst } else { error })
    }

    /// Writes the row of an impulse at the joint and a couple on its near body.
    pub(super) fn log(
        &self,
        placed: &PlacedEnds,
        (impulse, couple): (DVec3, DVec3),
        time: f64,
        log: &mut StepLog,
    ) {
        let [a, b] = [0, 1].map(|end| (self.ends[end].body, placed.arms[end]));
        log.link(time, [a, b], (placed.points[0], DVec3::ZERO), (impulse, couple));
    }

    /// Viscous damping \[N m s\], and the part of a relative angular velocity that it brakes.
    pub(super) fn damped(&self, placed: &PlacedEnds, spin: DVec3) -> (f64, DVec3) {
        match self.kind {
            JointKind::Ball { damping } => (damping, spin),
            JointKind::Hinge { damping, .. } => (damping, spin.project_onto_normalized(placed.axes[1])),
            JointKind::Rod { .. } | JointKind::Rope { .. } => (0.0, DVec3::ZERO),
        }
    }
}
