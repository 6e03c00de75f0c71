//! The list `[[listener]]`.

use glam::DVec3;

use super::motion;
use super::names::{Names, name};
use super::reader::{Decoder, Node, Quantity, Section};
use crate::pose::{Pose, Track};
use crate::scene::diagnostic::Problem;
use crate::scene::listener::{ListenerDescription, look_along};

pub(super) const KEYS: &[&str] = &["name", "preset", "position", "facing", "spacing", "keyframes"];
pub(super) const KEYFRAME_KEYS: &[&str] = &["time", "position", "facing"];

/// The microphone of the papers [m]: \[PAN\] §5.
const PAN_MICROPHONE: DVec3 = DVec3::new(1.0, 1.8, 1.0);

const DEFAULT_FACING: DVec3 = DVec3::NEG_Z;

pub(super) fn listeners(d: &mut Decoder<'_>, top: &Section<'_>) -> Vec<ListenerDescription> {
    let mut names = Names::default();
    let mut listeners = Vec::new();
    for (index, section) in top.list(d, "listener", KEYS).into_iter().enumerate() {
        let name = name(d, &section, &format!("listener-{}", index + 1), &mut names);
        let spacing = section.number(d, "spacing", Quantity::between(1e-4, 100.0, "m"));
        section.exclude(d, "keyframes", "position", "`position`");
        section.exclude(d, "keyframes", "preset", "`preset`");
        section.exclude(d, "position", "preset", "`preset`");
        section.exclude(d, "facing", "keyframes", "`keyframes`, which hold their own");
        let preset = section.choice(d, "preset", &[("pan-microphone", PAN_MICROPHONE)]);
        let position = section.vector(d, "position", "m").or(preset);
        if !["position", "preset", "keyframes"].iter().any(|key| section.mentions(key)) {
            section.missing(d, "position", "an array of 3 numbers in m, or `keyframes`, or `preset`");
        }
        let track = match section.get("keyframes") {
            Some(node) => keyframes(d, &node),
            None => facing(d, &section)
                .zip(position)
                .map(|(orientation, position)| Track::fixed(Pose { position, orientation })),
        };
        if let Some(track) = track {
            listeners.push(ListenerDescription { name, track, spacing, place: section.place.clone() });
        }
    }
    listeners
}

fn keyframes(d: &mut Decoder<'_>, node: &Node<'_>) -> Option<Track> {
    motion::track(d, node, KEYFRAME_KEYS, facing)
}

fn facing(d: &mut Decoder<'_>, section: &Section<'_>) -> Option<glam::DQuat> {
    let Some(node) = section.get("facing") else { return look_along(DEFAULT_FACING) };
    let turn = look_along(node.direction(d)?);
    if turn.is_none() {
        d.error(
            node.place(d),
            Problem::NoDirection {
                expected: "a direction that is not vertical, so that left and right have a meaning",
            },
        );
    }
    turn
}
