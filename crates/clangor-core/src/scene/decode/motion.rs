//! Orientations and keyframes.

use glam::{DQuat, DVec3};

use super::reader::{Decoder, Node, Quantity, Section};
use crate::pose::{Keyframe, Pose, Track};
use crate::scene::diagnostic::Problem;

pub(super) const ORIENTATION_KEYS: &[&str] = &["axis", "degrees", "quaternion"];
pub(super) const KEYFRAME_KEYS: &[&str] = &["time", "position", "orientation"];

/// `{ axis = [x, y, z], degrees = angle }` or `{ quaternion = [x, y, z, w] }`.
pub(super) fn orientation(d: &mut Decoder<'_>, node: &Node<'_>) -> Option<DQuat> {
    let section = node.section(d, ORIENTATION_KEYS)?;
    section.exclude(d, "quaternion", "axis", "`axis` and `degrees`");
    if let Some(node) = section.get("quaternion") {
        // Hand-written components are rounded; a larger deviation from 1 is taken for a mistake.
        const MAX_LENGTH_ERROR: f64 = 1e-2;
        let quaternion = DQuat::from_array(node.numbers::<4>(d, Quantity::between(-2.0, 2.0, ""))?);
        if (quaternion.length() - 1.0).abs() > MAX_LENGTH_ERROR {
            let expected = "a unit quaternion [x, y, z, w], such as [0, 0, 0, 1]".to_owned();
            d.error(node.place(d), Problem::OutOfRange { value: quaternion.length(), expected });
            return None;
        }
        return Some(quaternion.normalize());
    }
    for (key, expected) in [("axis", "an array of 3 numbers"), ("degrees", "a number in degrees")] {
        if !section.has(key) {
            section.missing(d, key, expected);
        }
    }
    let axis = section.get("axis").and_then(|node| node.direction(d));
    let degrees = section.number(d, "degrees", Quantity::between(-1e6, 1e6, "degrees"));
    Some(DQuat::from_axis_angle(axis?, degrees?.to_radians()))
}

/// Keyframes of a body: time, position, orientation. It moves slower than sound.
pub(super) fn body_track(d: &mut Decoder<'_>, node: &Node<'_>, sound_speed: f64) -> Option<Track> {
    let track = track(d, node, KEYFRAME_KEYS, |d, section| match section.get("orientation") {
        Some(node) => orientation(d, &node),
        None => Some(DQuat::IDENTITY),
    })?;
    let mut slow = true;
    for (index, pair) in track.keys().windows(2).enumerate() {
        let speed = pair[1].pose.position.distance(pair[0].pose.position) / (pair[1].time - pair[0].time);
        if speed >= sound_speed {
            let key = node.elements(d, "").and_then(|nodes| nodes.into_iter().nth(index + 1));
            let place = key.map_or_else(|| node.place(d), |key| key.place(d));
            d.error(place, Problem::Supersonic { speed, sound_speed });
            slow = false;
        }
    }
    slow.then_some(track)
}

/// Keyframes whose orientation `orient` reads.
pub(super) fn track(
    d: &mut Decoder<'_>,
    node: &Node<'_>,
    keys: &'static [&'static str],
    orient: fn(&mut Decoder<'_>, &Section<'_>) -> Option<DQuat>,
) -> Option<Track> {
    let expected = "an array of tables, such as [{ time = 0.0, position = [0, 0, 0] }]";
    let nodes = node.elements(d, expected)?;
    if nodes.is_empty() {
        d.error(node.place(d), Problem::WrongLength { found: 0, expected: expected.into() });
    }
    let mut keyframes: Vec<Keyframe> = Vec::with_capacity(nodes.len());
    let mut whole = !nodes.is_empty();
    for node in nodes {
        let keyframe = keyframe(d, &node, keys, orient);
        if let (Some(keyframe), Some(last)) = (keyframe, keyframes.last())
            && keyframe.time <= last.time
        {
            let problem = Problem::UnorderedTimes { time: keyframe.time, previous: last.time };
            d.error(node.place(d), problem);
        }
        whole &= keyframe.is_some();
        keyframes.extend(keyframe);
    }
    if whole { Track::try_new(keyframes) } else { None }
}

fn keyframe(
    d: &mut Decoder<'_>,
    node: &Node<'_>,
    keys: &'static [&'static str],
    orient: fn(&mut Decoder<'_>, &Section<'_>) -> Option<DQuat>,
) -> Option<Keyframe> {
    let section = node.section(d, keys)?;
    for (key, expected) in [("time", "a number in s"), ("position", "an array of 3 numbers in m")] {
        if !section.has(key) {
            section.missing(d, key, expected);
        }
    }
    let time = section.number(d, "time", Quantity::between(-1e5, 1e5, "s"));
    let position: Option<DVec3> = section.vector(d, "position", "m");
    let orientation = orient(d, &section);
    Some(Keyframe { time: time?, pose: Pose { position: position?, orientation: orientation? } })
}
