//! The lists `[[hang]]` and `[[spring]]`, and the ends of all links.

use super::reader::{Decoder, Quantity, Section};
use crate::scene::body_description::{BodyDescription, Copies};
use crate::scene::diagnostic::Problem;
use crate::scene::link_description::{Anchor, HangDescription, LinkTarget, SpringDescription};
use crate::scene::suggest::nearest;

pub(super) const HANG_KEYS: &[&str] = &["body", "anchor", "offset"];

pub(super) fn hangs(
    d: &mut Decoder<'_>,
    top: &Section<'_>,
    bodies: &[BodyDescription],
) -> Vec<HangDescription> {
    let mut hangs = Vec::new();
    for section in top.list(d, "hang", HANG_KEYS) {
        let body = body_name(d, &section, "body", bodies, true);
        if body.is_none() && !section.has("body") {
            section.missing(d, "body", "the name of a body in quotes");
        }
        section.exclude(d, "offset", "anchor", "`anchor`");
        let anchor = section.vector(d, "anchor", "m").map(Anchor::Point);
        let offset = section.vector(d, "offset", "m").map(Anchor::Offset);
        if !section.mentions("offset") && !section.has("anchor") {
            section.missing(d, "anchor", "an array of 3 numbers in m, or `offset`");
        }
        if let (Some(body), Some(anchor)) = (body, anchor.or(offset)) {
            hangs.push(HangDescription { body, anchor, place: section.place.clone() });
        }
    }
    hangs
}

pub(super) const SPRING_KEYS: &[&str] =
    &["body", "point", "to", "to_point", "rest_length", "stiffness", "damping"];

pub(super) fn springs(
    d: &mut Decoder<'_>,
    top: &Section<'_>,
    bodies: &[BodyDescription],
) -> Vec<SpringDescription> {
    let mut springs = Vec::new();
    for section in top.list(d, "spring", SPRING_KEYS) {
        let body = body_name(d, &section, "body", bodies, false);
        let to = target(d, &section, bodies);
        for (key, expected) in [
            ("body", "the name of a body in quotes"),
            ("to", "the name of a body, or a point as an array of 3 numbers in m"),
            ("stiffness", "a number in N/m"),
        ] {
            if !section.has(key) {
                section.missing(d, key, expected);
            }
        }
        let stiffness = section.number(d, "stiffness", Quantity::between(1e-9, 1e12, "N/m"));
        let damping = section.number(d, "damping", Quantity::between(0.0, 1e12, "N s/m")).unwrap_or(0.0);
        let rest_length = section.number(d, "rest_length", Quantity::between(0.0, 1e5, "m"));
        if let (Some(body), Some(to), Some(stiffness)) = (body, to, stiffness) {
            let place = section.place.clone();
            let point = section.vector(d, "point", "m");
            springs.push(SpringDescription { body, point, to, rest_length, stiffness, damping, place });
        }
    }
    springs
}

/// The far end of a spring, rod or rope: `to` and `to_point`.
pub(super) fn target(
    d: &mut Decoder<'_>,
    section: &Section<'_>,
    bodies: &[BodyDescription],
) -> Option<LinkTarget> {
    let node = section.get("to")?;
    if node.is_text() {
        let point = section.vector(d, "to_point", "m");
        return body_name(d, section, "to", bodies, false).map(|name| LinkTarget::Body { name, point });
    }
    section.exclude(d, "to_point", "to", "`to`, which is a point already");
    node.vector(d, "m").map(LinkTarget::Point)
}

/// The name of a body, or of all copies of a `[[body]]` where `groups` says so.
pub(super) fn body_name(
    d: &mut Decoder<'_>,
    section: &Section<'_>,
    key: &'static str,
    bodies: &[BodyDescription],
    groups: bool,
) -> Option<String> {
    let node = section.get(key)?;
    let name = node.text(d, "the name of a body in quotes")?;
    let stands_for = |b: &BodyDescription| match b.copies {
        Copies::One => b.name == name,
        _ if groups && b.name == name => true,
        _ => name.strip_prefix(&b.name).and_then(|rest| rest.strip_prefix('-')).is_some_and(|number| {
            let copy = number.parse::<usize>().ok().filter(|n| (1..=b.count()).contains(n));
            copy.is_some_and(|n| b.copy_name(n - 1) == name)
        }),
    };
    if bodies.iter().any(stands_for) {
        return Some(name.to_owned());
    }
    let known: Vec<String> = bodies
        .iter()
        .map(|b| match b.copies {
            Copies::One => b.name.clone(),
            _ if groups => b.name.clone(),
            _ => b.copy_name(0),
        })
        .collect();
    let nearest = nearest(name, known.iter().map(String::as_str));
    d.error(node.place(d), Problem::UnknownName { what: "body", name: name.to_owned(), nearest, known });
    None
}
