//! Links as a timeline stores them: springs, rods, joints and loads.

use clangor_core::body::link::LoadCurve;
use clangor_core::body::{JointKind, Link, LinkEnd};
use clangor_core::quantity;
use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::checks::Checks;
use crate::formats::timeline_file::error::TimelineError;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub(super) enum LinkFields {
    Hang {
        body: u32,
        anchor: [f64; 3],
    },
    Spring {
        body: u32,
        #[serde(default, skip_serializing_if = "is_origin")]
        at: [f64; 3],
        to: LinkEndFields,
        rest_length: f64,
        stiffness: f64,
        damping: f64,
    },
    Joint {
        body: u32,
        at: [f64; 3],
        to: LinkEndFields,
        kind: JointFields,
        collide: bool,
    },
    Load {
        body: u32,
        at: [f64; 3],
        force: Vec<(f64, [f64; 3])>,
        torque: Vec<(f64, [f64; 3])>,
    },
}

fn is_origin(point: &[f64; 3]) -> bool {
    *point == [0.0; 3]
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub(super) enum JointFields {
    Ball { damping: f64 },
    Hinge { axis: [f64; 3], damping: f64 },
    Rod { length: f64 },
    Rope { length: f64 },
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub(super) enum LinkEndFields {
    Point([f64; 3]),
    Body(u32),
    PointOfBody { body: u32, at: [f64; 3] },
}

/// A link as it is stored.
pub(super) fn encode(link: &Link) -> LinkFields {
    let end = |to: &LinkEnd| match to {
        LinkEnd::Point(point) => LinkEndFields::Point(point.to_array()),
        LinkEnd::Body { body, at: DVec3::ZERO } => LinkEndFields::Body(body.0),
        LinkEnd::Body { body, at } => LinkEndFields::PointOfBody { body: body.0, at: at.to_array() },
    };
    let curve =
        |curve: &LoadCurve| curve.points().iter().map(|(time, value)| (*time, value.to_array())).collect();
    match link {
        Link::Hang { body, anchor } => LinkFields::Hang { body: body.0, anchor: anchor.to_array() },
        Link::Spring { body, at, to, rest_length, stiffness, damping } => LinkFields::Spring {
            body: body.0,
            at: at.to_array(),
            to: end(to),
            rest_length: *rest_length,
            stiffness: *stiffness,
            damping: *damping,
        },
        Link::Joint { body, at, to, kind, collide } => LinkFields::Joint {
            body: body.0,
            at: at.to_array(),
            to: end(to),
            kind: match *kind {
                JointKind::Ball { damping } => JointFields::Ball { damping },
                JointKind::Hinge { axis, damping } => JointFields::Hinge { axis: axis.to_array(), damping },
                JointKind::Rod { length } => JointFields::Rod { length },
                JointKind::Rope { length } => JointFields::Rope { length },
            },
            collide: *collide,
        },
        Link::Load { body, at, force, torque } => {
            LinkFields::Load { body: body.0, at: at.to_array(), force: curve(force), torque: curve(torque) }
        }
    }
}

/// Stored links, with every body, length and curve checked.
pub(super) fn decode(checks: &Checks<'_>, links: &[LinkFields]) -> Result<Vec<Link>, TimelineError> {
    links.iter().enumerate().map(|(index, link)| decode_one(checks, index, link)).collect()
}

fn decode_one(checks: &Checks<'_>, index: usize, link: &LinkFields) -> Result<Link, TimelineError> {
    let name = |field: &str| format!("links[{index}].{field}");
    let body_id = |body: u32| checks.body_id(&name("body"), body);
    let end = |to: &LinkEndFields| {
        Ok::<_, TimelineError>(match to {
            LinkEndFields::Point(point) => LinkEnd::Point(DVec3::from_array(*point)),
            LinkEndFields::Body(body) => LinkEnd::centre(body_id(*body)?),
            LinkEndFields::PointOfBody { body, at } => {
                LinkEnd::Body { body: body_id(*body)?, at: DVec3::from_array(*at) }
            }
        })
    };
    let curve = |field: &str, points: &[(f64, [f64; 3])]| {
        let points = points.iter().map(|(time, value)| (*time, DVec3::from_array(*value))).collect();
        let problem = || checks.field(&name(field), "has times that do not increase".into());
        LoadCurve::try_new(points).ok_or_else(problem)
    };
    Ok(match link {
        LinkFields::Hang { body, anchor } => {
            Link::Hang { body: body_id(*body)?, anchor: DVec3::from_array(*anchor) }
        }
        LinkFields::Spring { body, at, to, rest_length, stiffness, damping } => {
            checks.quantity(&name("rest_length"), *rest_length, quantity::REST_LENGTH)?;
            checks.quantity(&name("stiffness"), *stiffness, quantity::STIFFNESS)?;
            checks.quantity(&name("damping"), *damping, quantity::SPRING_DAMPING)?;
            Link::Spring {
                body: body_id(*body)?,
                at: DVec3::from_array(*at),
                to: end(to)?,
                rest_length: *rest_length,
                stiffness: *stiffness,
                damping: *damping,
            }
        }
        LinkFields::Joint { body, at, to, kind, collide } => Link::Joint {
            body: body_id(*body)?,
            at: DVec3::from_array(*at),
            to: end(to)?,
            kind: joint_kind(kind, checks, &name("kind"))?,
            collide: *collide,
        },
        LinkFields::Load { body, at, force, torque } => Link::Load {
            body: body_id(*body)?,
            at: DVec3::from_array(*at),
            force: curve("force", force)?,
            torque: curve("torque", torque)?,
        },
    })
}

fn joint_kind(kind: &JointFields, checks: &Checks<'_>, name: &str) -> Result<JointKind, TimelineError> {
    Ok(match *kind {
        JointFields::Ball { damping } => JointKind::Ball { damping },
        JointFields::Hinge { axis, damping } => {
            let axis = DVec3::from_array(axis).try_normalize();
            let problem = || checks.field(name, "has an axis without direction".into());
            JointKind::Hinge { axis: axis.ok_or_else(problem)?, damping }
        }
        JointFields::Rod { length } => {
            JointKind::Rod { length: checks.positive(name, length).map(|()| length)? }
        }
        JointFields::Rope { length } => {
            JointKind::Rope { length: checks.positive(name, length).map(|()| length)? }
        }
    })
}
