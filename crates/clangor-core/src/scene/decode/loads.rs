//! The list `[[force]]`: forces and torques on a body over time.

use glam::DVec3;

use super::links::{NamedBodies, body_name};
use super::reader::{Decoder, Node, Quantity, Section};
use crate::body::link::LoadCurve;
use crate::scene::diagnostic::Problem;
use crate::scene::link_description::LoadDescription;

pub(super) const KEYS: &[&str] = &["body", "point", "force", "torque", "start", "end"];

/// Time without end \[s\].
const NEVER: f64 = 1e12;
/// Largest component of a force \[N\] or a torque \[N m\].
const STRONGEST: f64 = 1e9;

pub(super) fn loads(
    d: &mut Decoder<'_>,
    top: &Section<'_>,
    bodies: &NamedBodies<'_>,
) -> Vec<LoadDescription> {
    let mut loads = Vec::new();
    for section in top.list(d, "force", KEYS) {
        let body = body_name(d, &section, "body", bodies, false);
        if !section.has("body") {
            section.missing(d, "body", "the name of a body in quotes");
        }
        if !section.mentions("force") && !section.has("torque") {
            section.missing(d, "force", "3 numbers in N, or rows [s, N, N, N], or `torque`");
        }
        let point = section.vector(d, "point", "m");
        let start = section.number(d, "start", Quantity::between(0.0, 1e9, "s"));
        let end = section.number(d, "end", Quantity::between(0.0, 1e9, "s"));
        let span = (start.unwrap_or(0.0), end.unwrap_or(NEVER));
        if let Some(node) = section.get("end")
            && span.1 <= span.0
        {
            d.error(
                node.place(d),
                Problem::Conflict { key: "end", other: "a `start` that is not before it" },
            );
        }
        let nodes = [section.get("force"), section.get("torque")];
        let constant = nodes.iter().flatten().any(|node| !has_rows(d, node));
        for key in ["start", "end"] {
            if let Some(node) = section.get(key).filter(|_| !constant) {
                d.error(node.place(d), Problem::Conflict { key, other: "rows alone, which have times" });
            }
        }
        let [force, torque] = [("N", &nodes[0]), ("N m", &nodes[1])]
            .map(|(unit, node)| node.as_ref().map(|node| curve(d, node, (unit, span))));
        let read = [&force, &torque].iter().all(|curve| !matches!(curve, Some(None)));
        if let (Some(body), true) = (body, read) {
            loads.push(LoadDescription {
                body,
                point,
                force: force.flatten().unwrap_or_default(),
                torque: torque.flatten().unwrap_or_default(),
                place: section.place.clone(),
            });
        }
    }
    loads
}

/// Three numbers, constant from `start` to `end`, or rows of a time and three numbers.
fn curve(
    d: &mut Decoder<'_>,
    node: &Node<'_>,
    (unit, (start, end)): (&'static str, (f64, f64)),
) -> Option<LoadCurve> {
    let expected = format!("an array of 3 numbers in {unit}, or rows [time in s, and 3 numbers in {unit}]");
    let elements = node.elements(d, &expected)?;
    let strength = Quantity::between(-STRONGEST, STRONGEST, unit);
    if !elements.first().is_some_and(Node::is_array) {
        let value = DVec3::from_array(node.numbers::<3>(d, strength)?);
        return LoadCurve::try_new(vec![(start, value), (end, value)]);
    }
    if elements.len() < 2 {
        let expected = format!("two rows or more [time in s, and 3 numbers in {unit}]");
        d.error(node.place(d), Problem::WrongLength { found: elements.len(), expected });
        return None;
    }
    let mut points: Vec<(f64, DVec3)> = Vec::with_capacity(elements.len());
    for row in &elements {
        let [time, x, y, z] = row.numbers::<4>(d, strength)?;
        if let Some((previous, _)) = points.last().copied().filter(|(last, _)| *last >= time) {
            d.error(row.place(d), Problem::UnorderedTimes { time, previous });
            return None;
        }
        points.push((time, DVec3::new(x, y, z)));
    }
    LoadCurve::try_new(points)
}

/// Whether a force or a torque is written as rows.
fn has_rows(d: &mut Decoder<'_>, node: &Node<'_>) -> bool {
    node.is_array()
        && node.elements(d, "an array").is_some_and(|rows| rows.first().is_some_and(Node::is_array))
}
