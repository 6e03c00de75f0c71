//! Recipes of data sets, [`StrikeRecipe`].

use glam::DVec3;
use toml::de::DeTable;

use super::geometry::{geometry, scale};
use super::material::{Materials, materials};
use super::names::{Names, name};
use super::reader::{Decoder, Node, Quantity, Section};
use super::room::{ROOM_KEYS, check_damped, room_of};
use super::{keep_certain_errors, parse};
use crate::material::Material;
use crate::medium::Medium;
use crate::quantity;
use crate::scene::body_description::Geometry;
use crate::scene::diagnostic::{Problem, SceneErrors};
use crate::scene::simulation_description::ContactModel;
use crate::scene::strike_recipe::{
    Distribution, ListenerPlacement, StrikeRecipe, StrikeRoom, StrikerDescription, StruckObject,
};

const RECIPE_KEYS: &[&str] = &[
    "version",
    "seed",
    "count",
    "strikes",
    "repeat",
    "sample_rate",
    "seconds",
    "materials",
    "material",
    "object",
    "striker",
    "force",
    "listener",
    "room",
];
const OBJECT_KEYS: &[&str] = &["name", "shape", "mesh", "model", "scale", "materials", "points"];
const STRIKER_KEYS: &[&str] = &["materials", "radius", "speed"];
const FORCE_KEYS: &[&str] = &["impulse", "duration"];
const LISTENER_KEYS: &[&str] = &["position", "distance", "direction", "azimuth", "elevation"];
const STRIKE_ROOM_KEYS: &[&str] =
    &["name", "body", ROOM_KEYS[0], ROOM_KEYS[1], ROOM_KEYS[2], ROOM_KEYS[3], ROOM_KEYS[4]];

/// Most strikes of a recipe.
const MOST_STRIKES: i64 = 1_000_000_000_000;
const SPEED: Quantity = Quantity::above(0.0, 1e3, "m/s");
const IMPULSE: Quantity = Quantity::above(0.0, 1e6, "N s");
const CONTACT: Quantity = Quantity::between(1e-9, 1.0, "s");
const DISTANCE: Quantity = Quantity::above(0.0, 1e5, "m");
const AZIMUTH: Quantity = Quantity::between(-360.0, 360.0, "degrees");
const ELEVATION: Quantity = Quantity::between(-90.0, 90.0, "degrees");

impl StrikeRecipe {
    /// Reads a recipe.
    ///
    /// # Errors
    /// Every error of the text, in its order.
    pub fn from_toml(text: &str) -> Result<Self, SceneErrors> {
        let (text, tree, syntax_errors) = parse(text);
        let mut d = Decoder::new(text);
        let recipe = recipe(&mut d, tree.get_ref());
        if !syntax_errors.is_empty() {
            keep_certain_errors(&mut d, &syntax_errors);
        }
        d.errors.sort_by_key(|e| e.place.order());
        if d.errors.is_empty() { Ok(recipe) } else { Err(SceneErrors(d.errors)) }
    }
}

fn recipe<'t>(d: &mut Decoder<'t>, tree: &'t DeTable<'t>) -> StrikeRecipe {
    let start = d.place(0..0, "");
    let top = Section::new(d, tree, start, RECIPE_KEYS);
    if top.has("version") {
        super::check_version(d, &top);
    }
    let default = StrikeRecipe::default();
    let own = materials(d, &top, ContactModel::Compliant);
    let shared = material_list(d, &top, &own);
    let mut strikers = strikers(d, &top, &own);
    strikers.extend(forces(d, &top));
    let recipe = StrikeRecipe {
        seed: top.integer(d, "seed", 0, i64::MAX).map_or(default.seed, |seed| seed as u64),
        count: top.integer(d, "count", 1, MOST_STRIKES).map(|count| count as u64),
        table: top.text(d, "strikes", "the path of a table in quotes").map(str::to_owned),
        repeat: top.integer(d, "repeat", 1, MOST_STRIKES).map_or(default.repeat, |n| n as u64),
        sample_rate: top
            .integer(d, "sample_rate", 8000, 384_000)
            .map_or(default.sample_rate, |rate| rate as u32),
        seconds: top.number(d, "seconds", Quantity::between(0.001, 3600.0, "s")).unwrap_or(default.seconds),
        objects: objects(d, &top, &own, &shared),
        strikers,
        listeners: listeners(d, &top),
        rooms: rooms(d, &top),
        materials: own.into_custom(),
    };
    top.exclude(d, "count", "strikes", "`strikes`, whose rows are the strikes");
    if !top.mentions("strikes") {
        top.missing(d, "count", "the number of strikes, or `strikes`, the path of a table");
        top.missing(d, "object", "a body as [[object]] with `shape` or `mesh`");
        top.missing(d, "listener", "[[listener]] with `position` or `distance`");
        if !top.mentions("force") {
            top.missing(d, "striker", "[[striker]] with `materials`, `radius` and `speed`, or [[force]]");
        }
    }
    recipe
}

/// The materials that `materials` names: a name, or a list of names.
fn material_list(d: &mut Decoder<'_>, section: &Section<'_>, materials: &Materials) -> Vec<Material> {
    let Some(node) = section.get("materials") else { return Vec::new() };
    let nodes = match node.is_array() {
        true => node.elements(d, "a list of names of materials").unwrap_or_default(),
        false => vec![node.clone()],
    };
    if nodes.is_empty() {
        let expected = "the names of one material or more, such as [\"steel\"]".into();
        d.error(node.place(d), Problem::WrongLength { found: 0, expected });
    }
    nodes.iter().filter_map(|node| materials.of_node(d, node)).collect()
}

fn objects(
    d: &mut Decoder<'_>,
    top: &Section<'_>,
    own: &Materials,
    shared: &[Material],
) -> Vec<StruckObject> {
    let mut names = Names::default();
    let mut objects = Vec::new();
    for section in top.list(d, "object", OBJECT_KEYS) {
        section.exclude(d, "model", "shape", "`shape`");
        section.exclude(d, "model", "mesh", "`mesh`");
        let geometry = match section.text(d, "model", "the path of a sound model in quotes") {
            Some(path) => Some((Geometry::File(path.to_owned()), section.place.clone())),
            None if section.mentions("model") => None,
            None => geometry(d, &section, None, false),
        };
        let scale = scale(d, &section, false).map_or(1.0, |[scale, _]| scale);
        let mut materials = material_list(d, &section, own);
        if !section.mentions("materials") {
            materials = shared.to_vec();
            if !top.mentions("materials") {
                section.missing(d, "materials", "names of materials, here or for all objects");
            }
        }
        let points = points(d, &section);
        let Some((geometry, place)) = geometry else { continue };
        let (Geometry::Shape(word) | Geometry::File(word)) = &geometry;
        let name = name(d, &section, word, &mut names);
        objects.push(StruckObject { name, geometry, scale, materials, points, place });
    }
    objects
}

fn points(d: &mut Decoder<'_>, section: &Section<'_>) -> Vec<DVec3> {
    let Some(node) = section.get("points") else { return Vec::new() };
    let nodes = node.elements(d, "a list of points such as [[0, 0.03, 0]]").unwrap_or_default();
    nodes.iter().filter_map(|node| node.vector(d, "m")).collect()
}

fn strikers(d: &mut Decoder<'_>, top: &Section<'_>, own: &Materials) -> Vec<StrikerDescription> {
    let mut strikers = Vec::new();
    for section in top.list(d, "striker", STRIKER_KEYS) {
        section.missing(d, "materials", "the name of a material, or a list of names");
        let materials = material_list(d, &section, own);
        let radius = needed(d, &section, "radius", quantity::RADIUS);
        let speed = needed(d, &section, "speed", SPEED);
        let (Some(radius), Some(speed)) = (radius, speed) else { continue };
        strikers.push(StrikerDescription::Ball { materials, radius, speed });
    }
    strikers
}

fn forces(d: &mut Decoder<'_>, top: &Section<'_>) -> Vec<StrikerDescription> {
    let mut forces = Vec::new();
    for section in top.list(d, "force", FORCE_KEYS) {
        let impulse = needed(d, &section, "impulse", IMPULSE);
        let duration = section.get("duration").and_then(|node| distribution(d, &node, CONTACT));
        forces.extend(impulse.map(|impulse| StrikerDescription::Force { impulse, duration }));
    }
    forces
}

fn listeners(d: &mut Decoder<'_>, top: &Section<'_>) -> Vec<ListenerPlacement> {
    let mut listeners = Vec::new();
    for section in top.list(d, "listener", LISTENER_KEYS) {
        for key in ["distance", "direction", "azimuth", "elevation"] {
            section.exclude(d, key, "position", "`position`");
        }
        for key in ["azimuth", "elevation"] {
            section.exclude(d, key, "direction", "`direction`");
        }
        if let Some(node) = section.get("position") {
            listeners.extend(coordinates(d, &node).map(ListenerPlacement::Position));
            continue;
        }
        section.missing(d, "distance", "a number in m, or a range such as [0.5, 2], or `position`");
        let distance = section.get("distance").and_then(|node| distribution(d, &node, DISTANCE));
        let direction = section.get("direction").map(|node| node.direction(d));
        let azimuth = angles(d, &section, "azimuth", AZIMUTH, [0.0, 360.0]);
        let elevation = angles(d, &section, "elevation", ELEVATION, [-90.0, 90.0]);
        let Some(distance) = distance else { continue };
        match direction {
            Some(direction) => {
                listeners.extend(direction.map(|direction| ListenerPlacement::Along { direction, distance }));
            }
            None => listeners.push(ListenerPlacement::Around { distance, azimuth, elevation }),
        }
    }
    listeners
}

/// A range of angles in degrees, or one angle, as radians.
fn angles(
    d: &mut Decoder<'_>,
    section: &Section<'_>,
    key: &str,
    quantity: Quantity,
    default: [f64; 2],
) -> [f64; 2] {
    let read = section.get(key).and_then(|node| distribution(d, &node, quantity));
    let range = match read {
        None => default,
        Some(Distribution::Constant(angle)) => [angle, angle],
        Some(Distribution::Uniform(range) | Distribution::LogUniform(range)) => range,
    };
    range.map(f64::to_radians)
}

fn rooms(d: &mut Decoder<'_>, top: &Section<'_>) -> Vec<StrikeRoom> {
    let mut names = Names::default();
    let mut rooms = Vec::new();
    for (index, section) in top.list(d, "room", STRIKE_ROOM_KEYS).into_iter().enumerate() {
        let name = name(d, &section, &format!("room-{}", index + 1), &mut names);
        section.missing(d, "body", "the place of the body in the room, such as [2, 1, 1.5], in m");
        let body = section.get("body").and_then(|node| coordinates(d, &node));
        let Some(room) = room_of(d, &section) else { continue };
        if let Some(node) = section.get("absorption") {
            check_damped(d, &node, (&room, None), Medium::AIR.sound_speed);
        }
        rooms.extend(body.map(|body| StrikeRoom { name, room, body }));
    }
    rooms
}

/// Three coordinates, each a number or a range.
fn coordinates(d: &mut Decoder<'_>, node: &Node<'_>) -> Option<[Distribution; 3]> {
    let expected = "an array of 3 numbers in m, or ranges such as [[-1, 1], 0.5, 0]";
    let elements = node.elements(d, expected)?;
    if elements.len() != 3 {
        let expected = expected.into();
        d.error(node.place(d), Problem::WrongLength { found: elements.len(), expected });
        return None;
    }
    let read: Vec<_> = elements.iter().map(|node| distribution(d, node, quantity::COORDINATE)).collect();
    let [x, y, z] = read[..] else { return None };
    Some([x?, y?, z?])
}

/// A key that must be there.
fn needed(
    d: &mut Decoder<'_>,
    section: &Section<'_>,
    key: &'static str,
    quantity: Quantity,
) -> Option<Distribution> {
    section.missing(d, key, format!("{}, or a range such as [low, high]", quantity.expected()));
    section.get(key).and_then(|node| distribution(d, &node, quantity))
}

/// A number, a range `[low, high]`, or `{ log = [low, high] }`.
fn distribution(d: &mut Decoder<'_>, node: &Node<'_>, quantity: Quantity) -> Option<Distribution> {
    if node.is_array() {
        return range(d, node, quantity).map(Distribution::Uniform);
    }
    if !node.is_table() {
        return node.number(d, quantity).map(Distribution::Constant);
    }
    let section = node.section(d, &["log"])?;
    section.missing(d, "log", "a range of positive numbers, such as { log = [0.1, 10] }");
    let node = section.get("log")?;
    let [low, high] = range(d, &node, quantity)?;
    if low <= 0.0 {
        let expected = "a range of positive numbers, such as { log = [0.1, 10] }".into();
        d.error(node.place(d), Problem::OutOfRange { value: low, expected });
        return None;
    }
    Some(Distribution::LogUniform([low, high]))
}

fn range(d: &mut Decoder<'_>, node: &Node<'_>, quantity: Quantity) -> Option<[f64; 2]> {
    let [low, high] = node.numbers::<2>(d, quantity)?;
    if low > high {
        let expected = "the smaller number first, such as [0.5, 2]".into();
        d.error(node.place(d), Problem::OutOfRange { value: low, expected });
        return None;
    }
    Some([low, high])
}

#[cfg(test)]
mod tests {
    use super::*;

    const DOCUMENT: &str = include_str!("../../../../../docs/format/dataset.md");

    #[test]
    fn property_every_key_is_documented_and_every_documented_key_exists() {
        let sections: &[(&str, &[&str])] = &[
            ("## Top level", RECIPE_KEYS),
            ("## Objects", OBJECT_KEYS),
            ("## Strikers", STRIKER_KEYS),
            ("## Forces", FORCE_KEYS),
            ("## Listeners", LISTENER_KEYS),
            ("## Rooms", STRIKE_ROOM_KEYS),
        ];
        for (heading, keys) in sections {
            let start = DOCUMENT.find(&format!("{heading}\n")).unwrap_or_else(|| panic!("no {heading}"));
            let rest = &DOCUMENT[start + heading.len()..];
            let end = rest.find("\n#").unwrap_or(rest.len());
            let rows = rest[..end].lines().filter_map(|line| line.strip_prefix("| `")?.split_once("` |"));
            let mut written: Vec<&str> = rows.map(|(key, _)| key).collect();
            let mut accepted = keys.to_vec();
            accepted.sort_unstable();
            written.sort_unstable();
            assert_eq!(accepted, written, "{heading}");
        }
    }

    #[test]
    fn property_the_examples_of_the_document_decode() {
        let examples = DOCUMENT.split("```toml\n").skip(1).filter_map(|rest| rest.split("```").next());
        let mut count = 0;
        for example in examples {
            count += 1;
            StrikeRecipe::from_toml(example).unwrap_or_else(|errors| panic!("{example}\n{errors}"));
        }
        assert!(count >= 2);
    }

    #[test]
    fn property_mistakes_are_reported_together_with_their_lines() {
        let text = "count = 0\nmaterials = [\"stel\"]\n[[object]]\nshape = \"bowl\"\n[[force]]\n\
                    impulse = [2, 1]\n[[listener]]\ndistance = -1\nazimut = 3\n";
        let errors = StrikeRecipe::from_toml(text).unwrap_err();
        let lines: Vec<usize> = errors.0.iter().map(|error| error.place.line).collect();
        assert_eq!(lines, [1, 2, 6, 8, 9], "{errors}");
        let errors = errors.to_string();
        assert!(errors.contains("did you mean `steel`?") && errors.contains("did you mean `azimuth`?"));
        let empty = StrikeRecipe::from_toml("seed = 1\n").unwrap_err();
        assert_eq!(empty.0.len(), 4, "{empty}");
    }
}
