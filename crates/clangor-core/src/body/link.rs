//! What joins a body to another one or to a fixed point: springs, joints, rods and ropes, and loads from
//! outside.
//!
//! A point of a body is given in the body frame, whose origin is the centre of mass.

use glam::DVec3;

use super::BodyId;

/// A force or constraint on a point of a body.
#[derive(Clone, Debug, PartialEq)]
pub enum Link {
    /// An inextensible, massless rod from a fixed point to the centre of a sphere, which it holds at that
    /// distance.
    Hang {
        /// The sphere.
        body: BodyId,
        /// Fixed end of the rod \[m\], world.
        anchor: DVec3,
    },
    /// A linear spring.
    Spring {
        /// The body at one end.
        body: BodyId,
        /// Its point \[m\], body frame.
        at: DVec3,
        /// The other end.
        to: LinkEnd,
        /// Length without force \[m\].
        rest_length: f64,
        /// Stiffness \[N/m\].
        stiffness: f64,
        /// Damping along the spring \[N s/m\].
        damping: f64,
    },
    /// A massless constraint.
    Joint {
        /// The body at one end.
        body: BodyId,
        /// Its point \[m\], body frame.
        at: DVec3,
        /// The other end.
        to: LinkEnd,
        /// What it holds.
        kind: JointKind,
        /// Whether the two bodies may touch.
        collide: bool,
    },
    /// A force and a torque that act on a body over time. They move it; they do not make it vibrate.
    Load {
        /// The body.
        body: BodyId,
        /// Where the force acts \[m\], body frame.
        at: DVec3,
        /// Force over time \[N\], world axes.
        force: LoadCurve,
        /// Torque over time \[N m\], world axes.
        torque: LoadCurve,
    },
}

/// The far end of a link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LinkEnd {
    /// A fixed point \[m\], world.
    Point(DVec3),
    /// A point of a body.
    Body {
        /// The body.
        body: BodyId,
        /// The point \[m\], body frame.
        at: DVec3,
    },
}

/// What a joint holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum JointKind {
    /// The two points coincide.
    Ball {
        /// Viscous damping of the relative rotation \[N m s\].
        damping: f64,
    },
    /// The two points coincide, and both bodies turn about one axis only.
    Hinge {
        /// Unit vector along the axis, frame of the near body.
        axis: DVec3,
        /// Viscous damping of the rotation about the axis \[N m s\].
        damping: f64,
    },
    /// The two points keep their distance.
    Rod {
        /// That distance \[m\].
        length: f64,
    },
    /// The two points are no farther apart than this; a taut rope stops them without rebound.
    Rope {
        /// Largest distance \[m\].
        length: f64,
    },
}

impl Link {
    /// The bodies at its ends.
    pub fn bodies(&self) -> impl Iterator<Item = BodyId> {
        let (near, far) = match self {
            Link::Hang { body, .. } | Link::Load { body, .. } => (*body, None),
            Link::Spring { body, to, .. } | Link::Joint { body, to, .. } => (*body, to.body()),
        };
        std::iter::once(near).chain(far)
    }

    /// Whether it is a rod of a hung sphere, or a spring between centres of mass and fixed points.
    pub fn joins_centres(&self) -> bool {
        match self {
            Link::Hang { .. } => true,
            Link::Spring { at, to, .. } => {
                let far = match to {
                    LinkEnd::Point(_) => DVec3::ZERO,
                    LinkEnd::Body { at, .. } => *at,
                };
                *at == DVec3::ZERO && far == DVec3::ZERO
            }
            Link::Joint { .. } | Link::Load { .. } => false,
        }
    }
}

impl LinkEnd {
    /// The centre of mass of a body.
    pub fn centre(body: BodyId) -> Self {
        LinkEnd::Body { body, at: DVec3::ZERO }
    }

    /// The body at this end.
    pub fn body(&self) -> Option<BodyId> {
        match self {
            LinkEnd::Point(_) => None,
            LinkEnd::Body { body, .. } => Some(*body),
        }
    }
}

/// A vector over time: straight lines between points, zero before the first and after the last.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoadCurve {
    points: Vec<(f64, DVec3)>,
}

impl LoadCurve {
    /// A curve through points whose times \[s\] increase; `None` if they do not, or a number is not finite.
    pub fn try_new(points: Vec<(f64, DVec3)>) -> Option<Self> {
        let ordered = points.windows(2).all(|pair| pair[0].0 < pair[1].0);
        let finite = points.iter().all(|(time, value)| time.is_finite() && value.is_finite());
        (ordered && finite).then_some(LoadCurve { points })
    }

    /// Its points, in order of time.
    pub fn points(&self) -> &[(f64, DVec3)] {
        &self.points
    }

    /// Integral from `start` to `end` \[s\], exact.
    pub fn integral(&self, start: f64, end: f64) -> DVec3 {
        let after = self.points.partition_point(|(time, _)| *time <= start).max(1);
        let mut sum = DVec3::ZERO;
        for pair in self.points[after.min(self.points.len()).saturating_sub(1)..].windows(2) {
            let ((from, a), (to, b)) = (pair[0], pair[1]);
            let (left, right) = (start.max(from), end.min(to));
            if from >= end {
                break;
            }
            if right > left {
                let value = |time: f64| a.lerp(b, (time - from) / (to - from));
                sum += (value(left) + value(right)) * (0.5 * (right - left));
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_load_curve_is_integrated_exactly() {
        let points = vec![(1.0, DVec3::ZERO), (2.0, DVec3::X * 3.0), (4.0, DVec3::X)];
        let curve = LoadCurve::try_new(points).unwrap();
        // Areas of a triangle and a trapezium; rounding only.
        assert!((curve.integral(0.0, 9.0).x - 5.5).abs() < 1e-14);
        assert!((curve.integral(1.0, 1.5).x - 0.375).abs() < 1e-14);
        assert!((curve.integral(1.5, 3.0).x - (1.125 + 2.5)).abs() < 1e-14);
        assert_eq!(curve.integral(4.0, 5.0), DVec3::ZERO);
        assert_eq!(curve.integral(0.0, 1.0), DVec3::ZERO);
        assert_eq!(LoadCurve::default().integral(0.0, 1.0), DVec3::ZERO);
    }

    #[test]
    fn times_of_a_load_curve_increase() {
        assert!(LoadCurve::try_new(vec![(1.0, DVec3::X), (1.0, DVec3::Y)]).is_none());
        assert!(LoadCurve::try_new(vec![(f64::NAN, DVec3::X)]).is_none());
    }
}
