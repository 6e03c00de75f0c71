//! The section `[room]`.

use super::reader::{Decoder, Node, Quantity, Section};
use crate::acoustics::Acoustics;
use crate::propagation::{Air, OCTAVES, ReverberationTimes, Room, RoomError, WallAbsorption};
use crate::scene::diagnostic::Problem;

pub(super) const ROOM_KEYS: &[&str] = &["lowest", "highest", "absorption", "images", "late"];
/// Names of the walls, in their order, after the name for all other walls.
pub(super) const WALL_KEYS: &[&str] = &["walls", "x_low", "x_high", "floor", "ceiling", "z_low", "z_high"];

/// Largest order of image sources: above it, reflections are not audible as single echoes.
const MOST_IMAGES: i64 = 8;

pub(super) fn room(d: &mut Decoder<'_>, top: &Section<'_>) -> Option<Room> {
    let section = top.get("room")?.section(d, ROOM_KEYS)?;
    room_of(d, &section)
}

/// The room that a section describes.
pub(super) fn room_of(d: &mut Decoder<'_>, section: &Section<'_>) -> Option<Room> {
    let mut corner = |key| match section.get(key) {
        Some(node) => node.vector(d, "m"),
        None => {
            section.missing(d, key, "a corner of the room, such as [0, 0, 0], in m");
            None
        }
    };
    let (lowest, highest) = (corner("lowest"), corner("highest"));
    let walls = match section.get("absorption") {
        Some(node) => absorption(d, &node),
        None => {
            section.missing(d, "absorption", "the share of the energy that walls absorb, such as 0.1");
            None
        }
    };
    let image_order = section.integer(d, "images", 0, MOST_IMAGES).unwrap_or(2) as u32;
    let late = section.boolean(d, "late").unwrap_or(true);
    let room = Room { lowest: lowest?, highest: highest?, walls: walls?, image_order, late };
    if let (Err(error @ RoomError::Empty { .. }), Some(node)) = (room.check(), section.get("highest")) {
        d.error(node.place(d), Problem::Room(error));
        return None;
    }
    Some(room)
}

/// Notes an error where neither the walls nor the air of a room end its reverberation.
pub(super) fn check_reverberation(d: &mut Decoder<'_>, top: &Section<'_>, acoustics: &Acoustics) {
    let Some(room) = &acoustics.room else { return };
    let Some(section) = top.get("room") else { return };
    let node = section.get(d, "absorption").unwrap_or(section);
    check_damped(d, &node, (room, acoustics.air.as_ref()), acoustics.medium.sound_speed);
}

/// The same at a place, for a room filled with air that absorbs or not.
pub(super) fn check_damped(
    d: &mut Decoder<'_>,
    node: &Node<'_>,
    (room, air): (&Room, Option<&Air>),
    sound_speed: f64,
) {
    let times = ReverberationTimes::new(room, air, sound_speed);
    let undamped = OCTAVES.into_iter().find(|octave| !times.at(*octave).is_finite());
    if let Some(octave) = undamped.filter(|_| room.late) {
        d.error(node.place(d), Problem::Room(RoomError::Undamped { octave }));
    }
}

fn absorption(d: &mut Decoder<'_>, node: &Node<'_>) -> Option<[WallAbsorption; 6]> {
    if node.peek_number().is_some() || node.is_array() {
        return one_wall(d, node).map(|wall| [wall; 6]);
    }
    let section = node.section(d, WALL_KEYS)?;
    let others = section.get(WALL_KEYS[0]).and_then(|node| one_wall(d, &node));
    let mut walls = [None; 6];
    for (wall, key) in walls.iter_mut().zip(&WALL_KEYS[1..]) {
        *wall = match section.get(key) {
            Some(node) => one_wall(d, &node),
            None => others,
        };
        if !section.has(key) && !section.has(WALL_KEYS[0]) {
            section.missing(d, key, "what it absorbs, or `walls` for all that are not named");
        }
    }
    let [a, b, c, e, f, g] = walls;
    Some([a?, b?, c?, e?, f?, g?])
}

/// One number for all octaves, or one for each.
pub(super) fn one_wall(d: &mut Decoder<'_>, node: &Node<'_>) -> Option<WallAbsorption> {
    let share = Quantity::between(0.0, 1.0, "");
    match node.is_array() {
        true => node.numbers::<{ OCTAVES.len() }>(d, share).map(WallAbsorption),
        false => node.number(d, share).map(WallAbsorption::even),
    }
}
