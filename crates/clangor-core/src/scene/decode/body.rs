//! The list `[[body]]`.

use glam::{DQuat, DVec3};

use super::breaking::breaking;
use super::material::Materials;
use super::motion::{body_track, orientation};
use super::names::{Names, name};
use super::reader::{Decoder, Node, Quantity, Section};
use super::settings::{RINGING, SOUNDS};
use super::{geometry, given_mass};
use crate::body::{Guide, Motion};
use crate::material::{Material, presets};
use crate::pose::Pose;
use crate::quantity;
use crate::scene::body_description::{BodyDescription, Copies, PlacedBy, RandomPlacement};
use crate::scene::breaking::Breaking;
use crate::scene::diagnostic::{Doubt, Problem};
use crate::scene::scene_description::MAX_BODIES;
use crate::sound_model::rule::ModalRule;

pub(super) const KEYS: &[&str] = &[
    "name",
    "preset",
    "shape",
    "mesh",
    "scale",
    "material",
    "mass",
    "centre_of_mass",
    "inertia",
    "position",
    "origin",
    "orientation",
    "velocity",
    "angular_velocity",
    "motion",
    "keyframes",
    "press",
    "let_go",
    "edge_radius",
    "collision_error",
    "acceleration",
    "modal",
    "fracture",
    "support",
    "positions",
    "count",
    "placement",
];
pub(super) const PLACEMENT_KEYS: &[&str] = &["region", "seed", "orientation", "max_spin"];

/// Keys that a preset sets.
const PRESET_KEYS: &[&str] = &[
    "shape",
    "mesh",
    "scale",
    "position",
    "origin",
    "orientation",
    "velocity",
    "angular_velocity",
    "motion",
    "keyframes",
    "positions",
    "count",
    "placement",
];

/// A preset body, by its name in scenes.
#[derive(Clone, Copy)]
struct BodyPreset {
    shape: &'static str,
    position: DVec3,
    material: &'static presets::Preset,
}

/// The table of the papers: \[PAN\] §5 prints 1.8 m along x, 0.8 m along z, top at 0.4 m. The thickness of 3
/// cm and the wood are ours.
const PAN_TABLE: BodyPreset =
    BodyPreset { shape: "box:1.8x0.03x0.8", position: DVec3::new(0.0, 0.385, 0.0), material: &presets::WOOD };

pub(super) fn bodies(
    d: &mut Decoder<'_>,
    top: &Section<'_>,
    materials: &Materials,
    sound_speed: f64,
    names: &mut Names,
) -> Vec<BodyDescription> {
    let mut bodies = Vec::new();
    let mut total = 0u64;
    for (index, section) in top.list(d, "body", KEYS).into_iter().enumerate() {
        let name = name(d, &section, &format!("body-{}", index + 1), names);
        let Some(body) = body(d, &section, name.clone(), materials, sound_speed) else {
            names.mark_faulty(name);
            continue;
        };
        total = total.saturating_add(body.count() as u64);
        if total > MAX_BODIES {
            let problem = Problem::TooManyBodies { count: total, limit: MAX_BODIES };
            d.error(body.place, problem);
            break;
        }
        if body.copies != Copies::One {
            for copy in 0..body.count() {
                names.take(d, &body.copy_name(copy), &body.place);
            }
        }
        bodies.push(body);
    }
    bodies
}

fn body(
    d: &mut Decoder<'_>,
    section: &Section<'_>,
    name: String,
    materials: &Materials,
    sound_speed: f64,
) -> Option<BodyDescription> {
    let preset = section.choice(d, "preset", &[("pan-table", PAN_TABLE)]);
    for key in PRESET_KEYS {
        section.exclude(d, key, "preset", "`preset`, which sets it");
    }
    let copies = copies(d, section);
    let several = !matches!(copies, Some(Copies::One));
    let geometry = geometry::geometry(d, section, preset.map(|p| p.shape), several);
    let scale = geometry::scale(d, section, several);
    let material = material(d, section, materials, preset.map(|p| p.material));
    let given_mass = given_mass::given_mass(d, section);
    section.exclude(d, "origin", "position", "`position`");
    let origin = section.vector(d, "origin", "m");
    let position = section.vector(d, "position", "m").or(preset.map(|p| p.position)).or(origin);
    let placed_by = if origin.is_some() { PlacedBy::Origin } else { PlacedBy::CentreOfMass };
    let orientation = match section.get("orientation") {
        Some(node) => orientation(d, &node),
        None => Some(DQuat::IDENTITY),
    };
    let motion = if preset.is_some() { Some(Motion::Fixed) } else { motion(d, section, sound_speed) };
    let velocity = velocity(d, section, "velocity", sound_speed);
    let angular_velocity = section.vector(d, "angular_velocity", "rad/s");
    let sound = section.choice(d, "acceleration", SOUNDS);
    let ringing = section.get("modal").and_then(|node| match node.is_boolean() {
        true => node.boolean(d).map(|rings| if rings { ModalRule::Own } else { ModalRule::Never }),
        false => node.choice(d, "modal", RINGING),
    });
    let breaking =
        section.get("fracture").map(|node| breakable(d, section, &node, motion.as_ref(), material.as_ref()));
    let supports = super::support::supports(d, section, motion.as_ref());
    let edge_radius = section.number(d, "edge_radius", quantity::EDGE_RADIUS);
    section.exclude(d, "collision_error", "shape", "`shape`, whose convex parts are known");
    section.exclude(d, "collision_error", "preset", "`preset`, whose convex parts are known");
    let collision_error = section.number(d, "collision_error", Quantity::between(1e-4, 1.0, ""));
    if !matches!(motion, Some(Motion::Free) | None) {
        refuse_velocities(d, section);
    }
    let (geometry, geometry_place) = geometry?;
    let mut pose = Pose { position: position.unwrap_or(DVec3::ZERO), orientation: orientation? };
    let motion = motion?;
    if let Some(track) = motion.track() {
        pose = track.sample(0.0).0;
    }
    Some(BodyDescription {
        scale: scale?,
        given_mass,
        pose,
        placed_by,
        velocity: velocity.unwrap_or(DVec3::ZERO),
        angular_velocity: angular_velocity.unwrap_or(DVec3::ZERO),
        motion,
        edge_radius,
        collision_error,
        sound,
        ringing: ringing.unwrap_or_default(),
        breaking: breaking.flatten(),
        supports,
        copies: copies?,
        place: section.place.clone(),
        geometry_place,
        ..BodyDescription::new(name, material?, geometry)
    })
}

/// An error for each velocity of a body that is not free.
fn refuse_velocities(d: &mut Decoder<'_>, section: &Section<'_>) {
    for key in ["velocity", "angular_velocity"] {
        if let Some(node) = section.get(key) {
            d.error(node.place(d), Problem::Conflict { key, other: "a motion that is not \"free\"" });
        }
    }
}

pub(super) fn material(
    d: &mut Decoder<'_>,
    section: &Section<'_>,
    materials: &Materials,
    preset: Option<&presets::Preset>,
) -> Option<Material> {
    if let (Some(preset), false) = (preset, section.has("material")) {
        return Some(materials.preset(preset));
    }
    if !section.has("material") {
        section.missing(d, "material", "the name of a material in quotes, such as \"steel\"");
    }
    materials.named(d, section, "material")
}

/// The fracture settings of a body, if it can break.
fn breakable(
    d: &mut Decoder<'_>,
    section: &Section<'_>,
    node: &Node<'_>,
    motion: Option<&Motion>,
    material: Option<&Material>,
) -> Option<Breaking> {
    let breaking = breaking(d, node);
    let unknown = |material: &Material| {
        let strength = material.tensile_strength.is_none().then_some("tensile_strength");
        strength.or(material.fracture_energy.is_none().then_some("fracture_energy"))
    };
    if let Some(material) = material
        && let Some(missing) = unknown(material)
    {
        d.error(node.place(d), Problem::CannotBreak { material: material.name.clone(), missing });
    }
    if matches!(motion, Some(Motion::Fixed | Motion::Keyframed(_) | Motion::Guided(_))) {
        let other = "a motion that nothing changes";
        for key in ["preset", "keyframes", "motion"].into_iter().filter(|key| section.has(key)).take(1) {
            section.exclude(d, "fracture", key, other);
        }
    }
    breaking
}

fn motion(d: &mut Decoder<'_>, section: &Section<'_>, sound_speed: f64) -> Option<Motion> {
    let motion = section.choice(d, "motion", &[("free", false), ("fixed", true)]);
    let press = section.number(d, "press", quantity::PRESS);
    let let_go = section.number(d, "let_go", Quantity::between(0.0, 1e9, "s"));
    let Some(node) = section.get("keyframes") else {
        for key in ["press", "let_go"] {
            if let Some(node) = section.get(key) {
                d.error(node.place(d), Problem::Needs { key, other: "`keyframes`" });
            }
        }
        return match motion {
            None if section.has("motion") => None,
            fixed => Some(if fixed == Some(true) { Motion::Fixed } else { Motion::Free }),
        };
    };
    section.exclude(d, "motion", "keyframes", "`keyframes`");
    section.exclude(d, "position", "keyframes", "`keyframes`, which hold their own");
    section.exclude(d, "origin", "keyframes", "`keyframes`, which hold their own");
    section.exclude(d, "orientation", "keyframes", "`keyframes`, which hold their own");
    section.exclude(d, "positions", "keyframes", "`keyframes`");
    section.exclude(d, "count", "keyframes", "`keyframes`");
    let track = body_track(d, &node, sound_speed)?;
    Some(match (press, let_go) {
        (None, None) => Motion::Keyframed(track),
        _ => Motion::Guided(Guide { track, press, let_go }),
    })
}

fn velocity(d: &mut Decoder<'_>, section: &Section<'_>, key: &str, sound_speed: f64) -> Option<DVec3> {
    // Above this speed, neither Hertz's law nor the rigid body is a valid approximation.
    const USUAL_SPEED: f64 = 100.0;
    let node = section.get(key)?;
    let velocity = node.vector(d, "m/s")?;
    let speed = velocity.length();
    if speed >= sound_speed {
        d.error(node.place(d), Problem::Supersonic { speed, sound_speed });
        return None;
    }
    if speed > USUAL_SPEED {
        d.warn(
            node.place(d),
            Doubt::Unusual { what: "a speed", value: speed, unit: "m/s", usual: "0 to 100" },
        );
    }
    Some(velocity)
}

fn copies(d: &mut Decoder<'_>, section: &Section<'_>) -> Option<Copies> {
    for key in ["positions", "count"] {
        section.exclude(d, "position", key, "the positions of copies");
        section.exclude(d, "origin", key, "the positions of copies");
    }
    section.exclude(d, "positions", "count", "`count` and `placement`");
    if let Some(node) = section.get("positions") {
        return positions(d, &node).map(Copies::At);
    }
    match (section.get("count"), section.get("placement")) {
        (None, None) => Some(Copies::One),
        (Some(node), None) => {
            d.error(node.place(d), Problem::Needs { key: "count", other: "`placement`" });
            None
        }
        (None, Some(node)) => {
            d.error(node.place(d), Problem::Needs { key: "placement", other: "`count`" });
            None
        }
        (Some(count), Some(node)) => {
            let count = count.integer(d, 1, MAX_BODIES as i64).map(|count| count as usize);
            let placement = placement(d, &node, section);
            Some(Copies::Random(RandomPlacement { count: count?, ..placement? }))
        }
    }
}

fn positions(d: &mut Decoder<'_>, node: &Node<'_>) -> Option<Vec<DVec3>> {
    let expected = "an array of at least one position, such as [[0, 0.1, 0], [0, 0.2, 0]]";
    let nodes = node.elements(d, expected)?;
    if nodes.is_empty() {
        d.error(node.place(d), Problem::WrongLength { found: 0, expected: expected.into() });
        return None;
    }
    let read: Vec<Option<DVec3>> = nodes.iter().map(|node| node.vector(d, "m")).collect();
    read.into_iter().collect()
}

/// Reads a placement without its count.
fn placement(d: &mut Decoder<'_>, node: &Node<'_>, body: &Section<'_>) -> Option<RandomPlacement> {
    let section = node.section(d, PLACEMENT_KEYS)?;
    let expected = "two corners in m, such as [[-0.1, 0.1, -0.1], [0.1, 0.5, 0.1]]";
    if !section.has("region") {
        section.missing(d, "region", expected);
    }
    let region = section.get("region").and_then(|node| region(d, &node, expected));
    let seed = section.integer(d, "seed", 0, i64::MAX).map(|seed| seed as u64);
    let random_orientation = section.choice(d, "orientation", &[("random", true), ("same", false)]);
    if random_orientation == Some(true) {
        body.exclude(d, "orientation", "placement", "a random orientation");
    }
    let max_spin = section.number(d, "max_spin", Quantity::between(0.0, 1e5, "rad/s"));
    Some(RandomPlacement {
        count: 0,
        region: region?,
        seed,
        random_orientation: random_orientation.unwrap_or(false),
        max_spin: max_spin.unwrap_or(0.0),
        place: section.place,
    })
}

fn region(d: &mut Decoder<'_>, node: &Node<'_>, expected: &str) -> Option<[DVec3; 2]> {
    let corners = node.elements(d, expected)?;
    let [low, high] = corners.as_slice() else {
        d.error(node.place(d), Problem::WrongLength { found: corners.len(), expected: expected.into() });
        return None;
    };
    let (low_place, low, high) = (low.place(d), low.vector(d, "m"), high.vector(d, "m"));
    let (low, high) = (low?, high?);
    if low.cmpgt(high).any() {
        let axis = (0..3).find(|axis| low[*axis] > high[*axis]).unwrap_or(0);
        let expected = "the least x, y, z first, then the greatest".to_owned();
        d.error(low_place, Problem::OutOfRange { value: low[axis], expected });
        return None;
    }
    Some([low, high])
}
