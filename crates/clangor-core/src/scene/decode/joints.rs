//! The lists `[[hinge]]`, `[[ball_joint]]`, `[[rod]]` and `[[rope]]`.

use super::links::{NamedBodies, body_name, target};
use super::reader::{Decoder, Quantity, Section};
use crate::scene::link_description::{JointDescription, JointForm, LinkTarget};

pub(super) const HINGE_KEYS: &[&str] = &["body", "to", "point", "axis", "damping", "collide"];
const BALL_KEYS: &[&str] = &["body", "to", "point", "damping", "collide"];
pub(super) const ROPE_KEYS: &[&str] = &["body", "point", "to", "to_point", "length", "collide"];
const ROD_KEYS: &[&str] = &["body", "point", "to", "to_point", "collide"];

const BODY: &str = "the name of a body in quotes";
const POINT: &str = "an array of 3 numbers in m";

pub(super) fn joints(
    d: &mut Decoder<'_>,
    top: &Section<'_>,
    bodies: &NamedBodies<'_>,
) -> Vec<JointDescription> {
    let mut joints = Vec::new();
    for section in top.list(d, "hinge", HINGE_KEYS) {
        let axis = section.get("axis").and_then(|node| node.direction(d));
        if !section.has("axis") {
            section.missing(d, "axis", "an array of 3 numbers, the direction of the axis");
        }
        let damping = damping(d, &section);
        let form = axis.map(|axis| JointForm::Hinge { axis, damping });
        joints.extend(pivot(d, &section, bodies, form));
    }
    for section in top.list(d, "ball_joint", BALL_KEYS) {
        let damping = damping(d, &section);
        joints.extend(pivot(d, &section, bodies, Some(JointForm::Ball { damping })));
    }
    for section in top.list(d, "rod", ROD_KEYS) {
        joints.extend(line(d, &section, bodies, JointForm::Rod));
    }
    for section in top.list(d, "rope", ROPE_KEYS) {
        let length = section.number(d, "length", Quantity::between(1e-6, 1e5, "m"));
        joints.extend(line(d, &section, bodies, JointForm::Rope { length }));
    }
    joints
}

fn damping(d: &mut Decoder<'_>, section: &Section<'_>) -> f64 {
    section.number(d, "damping", Quantity::between(0.0, 1e9, "N m s")).unwrap_or(0.0)
}

/// A joint at one point of two bodies, or of a body and the world. Such bodies often overlap there.
fn pivot(
    d: &mut Decoder<'_>,
    section: &Section<'_>,
    bodies: &NamedBodies<'_>,
    form: Option<JointForm>,
) -> Option<JointDescription> {
    let body = body_name(d, section, "body", bodies, false);
    let to = body_name(d, section, "to", bodies, false);
    let point = section.vector(d, "point", "m");
    let collide = section.boolean(d, "collide").unwrap_or(false);
    for (key, expected) in [("body", BODY), ("point", POINT)] {
        if !section.has(key) {
            section.missing(d, key, expected);
        }
    }
    if section.has("to") && to.is_none() {
        return None;
    }
    let point = point?;
    let to = match to {
        Some(name) => LinkTarget::Body { name, point: Some(point) },
        None => LinkTarget::Point(point),
    };
    let place = section.place.clone();
    Some(JointDescription { body: body?, point: Some(point), to, form: form?, collide, place })
}

/// A rod or rope between two points.
fn line(
    d: &mut Decoder<'_>,
    section: &Section<'_>,
    bodies: &NamedBodies<'_>,
    form: JointForm,
) -> Option<JointDescription> {
    let body = body_name(d, section, "body", bodies, false);
    let to = target(d, section, bodies);
    let point = section.vector(d, "point", "m");
    let collide = section.boolean(d, "collide").unwrap_or(true);
    for (key, expected) in
        [("body", BODY), ("to", "the name of a body, or a point as an array of 3 numbers in m")]
    {
        if !section.has(key) {
            section.missing(d, key, expected);
        }
    }
    let place = section.place.clone();
    Some(JointDescription { body: body?, point, to: to?, form, collide, place })
}
