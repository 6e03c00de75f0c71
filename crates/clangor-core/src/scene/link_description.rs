//! What a person writes about links: rods, ropes, springs, joints and loads, their ends by name and by the
//! points where they lie at the start.

use glam::DVec3;

use super::diagnostic::Place;
use crate::body::link::LoadCurve;

/// A `[[hang]]`: every sphere of a `[[body]]` on a massless rod.
#[derive(Clone, Debug, PartialEq)]
pub struct HangDescription {
    /// Name of the body, of one copy, or of all copies of a `[[body]]`.
    pub body: String,
    /// End of the rod.
    pub anchor: Anchor,
    /// Place of the link in the text.
    pub place: Place,
}

/// End of a rod.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Anchor {
    /// At a point \[m\], world.
    Point(DVec3),
    /// At this vector from the starting centre of each sphere \[m\].
    Offset(DVec3),
}

/// A `[[spring]]`.
#[derive(Clone, Debug, PartialEq)]
pub struct SpringDescription {
    /// Name of the body at one end.
    pub body: String,
    /// Where the spring holds it at t = 0 \[m\], world; `None`: its centre of mass.
    pub point: Option<DVec3>,
    /// The other end.
    pub to: LinkTarget,
    /// Length without force \[m\]; `None`: the distance at t = 0.
    pub rest_length: Option<f64>,
    /// Stiffness \[N/m\].
    pub stiffness: f64,
    /// Damping along the spring \[N s/m\].
    pub damping: f64,
    /// Place of the spring in the text.
    pub place: Place,
}

/// A `[[hinge]]`, `[[ball_joint]]`, `[[rod]]` or `[[rope]]`.
#[derive(Clone, Debug, PartialEq)]
pub struct JointDescription {
    /// Name of the body at one end.
    pub body: String,
    /// Where the joint holds it at t = 0 \[m\], world; `None`: its centre of mass.
    pub point: Option<DVec3>,
    /// The other end.
    pub to: LinkTarget,
    /// What it holds.
    pub form: JointForm,
    /// Whether the two bodies may touch.
    pub collide: bool,
    /// Place of the joint in the text.
    pub place: Place,
}

/// What a joint holds, as it is written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum JointForm {
    /// A `[[ball_joint]]`, with the damping of the rotation \[N m s\].
    Ball {
        /// Viscous damping of the rotation \[N m s\].
        damping: f64,
    },
    /// A `[[hinge]]`.
    Hinge {
        /// Unit vector along the axis at t = 0, world.
        axis: DVec3,
        /// Viscous damping of the rotation \[N m s\].
        damping: f64,
    },
    /// A `[[rod]]`, as long as the distance at t = 0.
    Rod,
    /// A `[[rope]]`.
    Rope {
        /// Its length \[m\]; `None`: the distance at t = 0.
        length: Option<f64>,
    },
}

/// A `[[force]]`.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadDescription {
    /// Name of the body.
    pub body: String,
    /// Where the force acts at t = 0 \[m\], world; `None`: at the centre of mass.
    pub point: Option<DVec3>,
    /// Force over time \[N\], world axes.
    pub force: LoadCurve,
    /// Torque over time \[N m\], world axes.
    pub torque: LoadCurve,
    /// Place of the load in the text.
    pub place: Place,
}

/// The far end of a link.
#[derive(Clone, Debug, PartialEq)]
pub enum LinkTarget {
    /// A body.
    Body {
        /// Its name.
        name: String,
        /// Where the link holds it at t = 0 \[m\], world; `None`: its centre of mass.
        point: Option<DVec3>,
    },
    /// A fixed point \[m\], world.
    Point(DVec3),
}
