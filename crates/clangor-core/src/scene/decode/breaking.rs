//! The table `fracture` of a `[[body]]`.

use glam::DVec3;

use super::reader::{Decoder, Node, Quantity, Section};
use crate::scene::breaking::{Breaking, Load, Reaction, Score};

pub(super) const KEYS: &[&str] =
    &["edge", "seed", "smallest_piece", "most_pieces", "crack_impulses", "reaction", "load", "scores"];
pub(super) const SCORE_KEYS: &[&str] = &["point", "normal", "depth"];

pub(super) fn breaking(d: &mut Decoder<'_>, node: &Node<'_>) -> Option<Breaking> {
    let section = node.section(d, KEYS)?;
    let length = Quantity::above(0.0, 1e3, "m");
    let reactions =
        [("inertia-relief", Reaction::InertiaRelief), ("least-residual", Reaction::LeastResidual)];
    let loads = [("history", Load::History), ("half-sine-peak", Load::HalfSinePeak), ("step", Load::Step)];
    let default = Breaking::default();
    Some(Breaking {
        edge: section.number(d, "edge", length),
        seed: section.integer(d, "seed", 0, i64::MAX).map(|seed| seed as u64),
        smallest_piece: section.number(d, "smallest_piece", length),
        most_pieces: section
            .integer(d, "most_pieces", 2, 10_000)
            .map_or(default.most_pieces, |most| most as usize),
        crack_impulses: section.boolean(d, "crack_impulses").unwrap_or(default.crack_impulses),
        reaction: section.choice(d, "reaction", &reactions).unwrap_or(default.reaction),
        load: section.choice(d, "load", &loads).unwrap_or(default.load),
        scores: section.list(d, "scores", SCORE_KEYS).iter().filter_map(|s| score(d, s)).collect(),
    })
}

fn score(d: &mut Decoder<'_>, section: &Section<'_>) -> Option<Score> {
    if !section.has("normal") {
        section.missing(d, "normal", "a vector that is not zero, such as [1, 0, 0]");
    }
    let point = section.vector(d, "point", "m").unwrap_or(DVec3::ZERO);
    let depth = section.number(d, "depth", Quantity::between(0.0, 1.0, "m")).unwrap_or(0.0);
    Some(Score { point, normal: section.get("normal")?.direction(d)?, depth })
}
