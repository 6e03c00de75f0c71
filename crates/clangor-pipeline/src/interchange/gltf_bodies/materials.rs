//! Materials of nodes by their names.

use clangor_core::body::World;
use clangor_core::material::{Material, presets};

/// The material of a name, which may have the number that Blender gives to copies: `steel.001`.
pub(super) fn material(world: &World, materials: &[Material], name: &str) -> Option<Material> {
    let find = |name: &str| {
        let all = world.bodies.iter().map(|body| &body.material).chain(materials);
        let used = all.into_iter().find(|material| material.name == name);
        used.cloned().or_else(|| presets::preset(name))
    };
    find(name).or_else(|| find(without_number(name)?))
}

/// The known name that is the same but for case and the number of a copy.
pub(super) fn similar_name(world: &World, materials: &[Material], name: &str) -> Option<String> {
    let wanted = without_number(name).unwrap_or(name).to_lowercase();
    let is_similar = |name: &&str| name.to_lowercase() == wanted;
    let of_scene = world.bodies.iter().map(|body| &body.material).chain(materials);
    let of_scene = of_scene.map(|material| material.name.as_str()).find(is_similar);
    of_scene.or_else(|| presets::names().find(is_similar)).map(ToString::to_string)
}

/// A name without the number of a copy, if it has one.
fn without_number(name: &str) -> Option<&str> {
    let (original, end) = name.rsplit_once('.')?;
    (end.len() == 3 && end.bytes().all(|b| b.is_ascii_digit())).then_some(original)
}
