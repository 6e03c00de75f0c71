//! The lists `[[hang]]` and `[[spring]]`, and the ends of all links.

use std::collections::BTreeMap;

use super::names::Names;
use super::reader::{Decoder, Section};
use crate::quantity;
use crate::scene::body_description::{BodyDescription, Copies};
use crate::scene::link_description::{Anchor, HangDescription, LinkTarget, SpringDescription};

pub(super) const HANG_KEYS: &[&str] = &["body", "anchor", "offset"];

pub(super) fn hangs(
    d: &mut Decoder<'_>,
    top: &Section<'_>,
    bodies: &NamedBodies<'_>,
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
    bodies: &NamedBodies<'_>,
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
        let stiffness = section.number(d, "stiffness", quantity::STIFFNESS);
        let damping = section.number(d, "damping", quantity::SPRING_DAMPING).unwrap_or(0.0);
        let rest_length = section.number(d, "rest_length", quantity::REST_LENGTH);
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
    bodies: &NamedBodies<'_>,
) -> Option<LinkTarget> {
    let node = section.get("to")?;
    if node.is_text() {
        let point = section.vector(d, "to_point", "m");
        return body_name(d, section, "to", bodies, false).map(|name| LinkTarget::Body { name, point });
    }
    section.exclude(d, "to_point", "to", "`to`, which is a point already");
    node.vector(d, "m").map(LinkTarget::Point)
}

/// The bodies of a scene by name.
pub(super) struct NamedBodies<'b> {
    bodies: &'b [BodyDescription],
    /// Indices in the order of the names.
    by_name: BTreeMap<&'b str, usize>,
    names: &'b Names,
}

impl<'b> NamedBodies<'b> {
    pub(super) fn new(bodies: &'b [BodyDescription], names: &'b Names) -> Self {
        let by_name = bodies.iter().enumerate().map(|(index, body)| (body.name.as_str(), index)).collect();
        NamedBodies { bodies, by_name, names }
    }

    fn find(&self, name: &str) -> Option<&'b BodyDescription> {
        self.by_name.get(name).map(|&index| &self.bodies[index])
    }

    /// Whether a name is that of a body, of a copy, or with `groups` of all copies.
    fn has(&self, name: &str, groups: bool) -> bool {
        if self.find(name).is_some_and(|body| groups || body.copies == Copies::One) {
            return true;
        }
        let Some((group, number)) = name.rsplit_once('-') else { return false };
        let copy = number.parse::<usize>().ok().and_then(|number| number.checked_sub(1));
        self.find(group)
            .filter(|body| body.copies != Copies::One)
            .is_some_and(|body| copy.is_some_and(|copy| copy < body.count() && body.copy_name(copy) == name))
    }
}

/// The name of a body, or of all copies of a `[[body]]` where `groups` says so.
pub(super) fn body_name(
    d: &mut Decoder<'_>,
    section: &Section<'_>,
    key: &'static str,
    bodies: &NamedBodies<'_>,
    groups: bool,
) -> Option<String> {
    let node = section.get(key)?;
    let name = node.text(d, "the name of a body in quotes")?;
    if bodies.has(name, groups) {
        return Some(name.to_owned());
    }
    // Its own errors are listed already.
    if bodies.names.is_faulty(name) {
        return None;
    }
    let shown = |b: &BodyDescription| match b.copies {
        Copies::One => b.name.clone(),
        _ if groups => b.name.clone(),
        _ => b.copy_name(0),
    };
    let known: Vec<String> = bodies.bodies.iter().take(d.comparable()).map(shown).collect();
    d.unknown_name(node.place(d), "body", name, known.iter().map(String::as_str));
    None
}
