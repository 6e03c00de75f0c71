//! The list `[[body.support]]`.

use glam::DVec3;

use super::reader::{Decoder, Quantity, Section};
use crate::body::Motion;
use crate::body::support::SupportRegion;
use crate::scene::diagnostic::Problem;
use crate::scene::support_description::{
    FEET_DAMPING_RATIO, FEET_FREQUENCY, SupportDamping, SupportDescription, SupportPlaces, SupportRule,
    SupportStiffness,
};
use crate::scene::support_problem::SupportProblem;

pub(super) const KEYS: &[&str] =
    &["kind", "at", "radius", "low", "high", "points", "stiffness", "frequency", "damping", "damping_ratio"];

#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Clamped,
    Sprung,
    Feet,
}

const KINDS: &[(&str, Kind)] = &[("clamped", Kind::Clamped), ("sprung", Kind::Sprung), ("feet", Kind::Feet)];

/// Lengths of regions.
const LENGTH: Quantity = Quantity::above(0.0, 1e3, "m");

pub(super) fn supports(
    d: &mut Decoder<'_>,
    body: &Section<'_>,
    motion: Option<&Motion>,
) -> Vec<SupportDescription> {
    let sections = body.list(d, "support", KEYS);
    sections.iter().filter_map(|section| support(d, section, motion)).collect()
}

fn support(
    d: &mut Decoder<'_>,
    section: &Section<'_>,
    motion: Option<&Motion>,
) -> Option<SupportDescription> {
    if !section.has("kind") {
        section.missing(d, "kind", "\"clamped\", \"sprung\" or \"feet\"");
    }
    let kind = section.choice(d, "kind", KINDS);
    if let (Some(node), Some(Kind::Clamped), Some(Motion::Free)) = (section.get("kind"), kind, motion) {
        d.error(node.place(d), Problem::Support(SupportProblem::ClampedFree));
    }
    let places = places(d, section);
    let rule = rule(d, section, kind?);
    Some(SupportDescription { places: places?, rule: rule?, place: section.place.clone() })
}

fn places(d: &mut Decoder<'_>, section: &Section<'_>) -> Option<SupportPlaces> {
    for key in ["at", "low", "high"] {
        section.exclude(d, "points", key, "a region of its own");
    }
    for key in ["low", "high"] {
        section.exclude(d, key, "at", "`at` and `radius`");
    }
    section.exclude(d, "radius", "low", "the box of `low` and `high`");
    let radius = section.number(d, "radius", LENGTH);
    if let Some(node) = section.get("points") {
        let expected = "an array of at least one point, such as [[-0.1, 0, 0], [0.1, 0, 0]]";
        let nodes = node.elements(d, expected)?;
        if nodes.is_empty() {
            d.error(node.place(d), Problem::WrongLength { found: 0, expected: expected.into() });
            return None;
        }
        let points: Vec<Option<DVec3>> = nodes.iter().map(|node| node.vector(d, "m")).collect();
        let points = points.into_iter().collect::<Option<Vec<DVec3>>>()?;
        return (radius.is_some() || !section.has("radius"))
            .then_some(SupportPlaces::Points { points, radius });
    }
    if section.has("low") || section.has("high") {
        for key in ["low", "high"] {
            if !section.has(key) {
                section.missing(d, key, "a corner of the box as an array of 3 numbers in m");
            }
        }
        let (low, high) = (section.vector(d, "low", "m"), section.vector(d, "high", "m"));
        let (low, high) = (low?, high?);
        if let Some(axis) = (0..3).find(|axis| low[*axis] >= high[*axis]) {
            let (name, node) = (['x', 'y', 'z'][axis], section.get("high")?);
            let problem = SupportProblem::EmptyBox { axis: name, low: low[axis], high: high[axis] };
            d.error(node.place(d), Problem::Support(problem));
            return None;
        }
        return Some(SupportPlaces::Region(SupportRegion::Box { low, high }));
    }
    if !section.has("at") {
        let expected = "the centre of a ball as an array of 3 numbers in m, with `radius`; or `low` and \
                        `high`, or `points`";
        section.missing(d, "at", expected);
        return None;
    }
    if !section.has("radius") {
        section.missing(d, "radius", "the radius of the ball in m");
    }
    let centre = section.vector(d, "at", "m");
    Some(SupportPlaces::Region(SupportRegion::Ball { centre: centre?, radius: radius? }))
}

fn rule(d: &mut Decoder<'_>, section: &Section<'_>, kind: Kind) -> Option<SupportRule> {
    let springs = ["stiffness", "frequency", "damping", "damping_ratio"];
    if kind == Kind::Clamped {
        for key in springs.into_iter().filter(|key| section.has(key)) {
            section.exclude(d, key, "kind", "`kind = \"clamped\"`, which gives nowhere");
        }
        return Some(SupportRule::Clamped);
    }
    section.exclude(d, "frequency", "stiffness", "`stiffness`");
    section.exclude(d, "damping_ratio", "damping", "`damping`");
    let stiffness = axes(d, section, "stiffness", (1e12, "N/m"));
    let frequency = section.number(d, "frequency", Quantity::above(0.0, 1e5, "Hz"));
    let damping = axes(d, section, "damping", (1e12, "N s/m"));
    let ratio = section.number(d, "damping_ratio", Quantity::between(0.0, 1.0, ""));
    if let (Some(node), Some(DVec3::ZERO)) = (section.get("stiffness"), stiffness) {
        d.error(node.place(d), Problem::Support(SupportProblem::NoStiffness));
        return None;
    }
    let stiffness = match (stiffness, frequency) {
        (Some(stiffness), _) => SupportStiffness::OfEach(stiffness),
        (None, Some(frequency)) => SupportStiffness::Bounce(frequency),
        (None, None) if section.has("stiffness") || section.has("frequency") => return None,
        (None, None) if kind == Kind::Feet => SupportStiffness::Bounce(FEET_FREQUENCY),
        (None, None) => {
            section.missing(d, "stiffness", "a number or an array of 3 numbers in N/m, or `frequency`");
            return None;
        }
    };
    let damping = match (damping, ratio) {
        (Some(damping), _) => SupportDamping::OfEach(damping),
        (None, Some(ratio)) => SupportDamping::Ratio(ratio),
        (None, None) if section.has("damping") || section.has("damping_ratio") => return None,
        (None, None) if kind == Kind::Feet => SupportDamping::Ratio(FEET_DAMPING_RATIO),
        (None, None) => SupportDamping::OfEach(DVec3::ZERO),
    };
    Some(SupportRule::Sprung { stiffness, damping })
}

/// One number for all three axes, or three, from 0.
fn axes(
    d: &mut Decoder<'_>,
    section: &Section<'_>,
    key: &'static str,
    (most, unit): (f64, &'static str),
) -> Option<DVec3> {
    let node = section.get(key)?;
    let quantity = Quantity::between(0.0, most, unit);
    match node.is_array() {
        true => node.numbers::<3>(d, quantity).map(DVec3::from_array),
        false => node.number(d, quantity).map(DVec3::splat),
    }
}
