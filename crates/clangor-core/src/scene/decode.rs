//! From TOML to a [`Scene`]: one decoder per section, errors collected throughout.
//!
//! A syntax error does not hide other errors: the parser recovers, and the rest is decoded. Possible
//! consequences of the syntax error are not reported (errors on the same lines, missing keys, unknown names).

mod body;
mod breaking;
mod former_keys;
mod geometry;
mod given_mass;
mod joints;
mod links;
mod listener;
mod loads;
mod material;
mod motion;
mod names;
mod plane;
mod reader;
mod room;
mod settings;
mod strike_recipe;
mod support;

use std::collections::BTreeSet;

use toml::Spanned;
use toml::de::DeTable;

use super::diagnostic::{Doubt, Place, Problem, SceneError, SceneErrors};
use super::instantiate::{Loader, file_errors};
use super::listener::{below_floor, outside};
use super::scene_description::{STANDARD_GRAVITY, Scene, VERSION};
use crate::body::Motion;
use names::Names;
use reader::{Decoder, Section};

const TOP_KEYS: &[&str] = &[
    "version",
    "medium",
    "gravity",
    "material",
    "body",
    "plane",
    "hang",
    "spring",
    "hinge",
    "ball_joint",
    "rod",
    "rope",
    "force",
    "listener",
    "simulation",
    "render",
    "room",
];

impl Scene {
    /// Reads a scene.
    ///
    /// # Errors
    /// Every error of the text, in its order: TOML syntax, unknown keys, wrong types and ranges, undefined
    /// names, conflicting settings.
    pub fn from_toml(text: &str) -> Result<Scene, SceneErrors> {
        match decode(text) {
            (scene, errors) if errors.is_empty() => Ok(scene),
            (_, errors) => Err(SceneErrors(errors)),
        }
    }

    /// As [`from_toml`](Self::from_toml). If there are errors, the mesh files are loaded too, so that missing
    /// and invalid files are reported with the rest.
    ///
    /// # Errors
    /// As `from_toml`, and those of the files beside them.
    pub fn from_toml_with_files(text: &str, load: &mut Loader<'_>) -> Result<Scene, SceneErrors> {
        let (scene, mut errors) = decode(text);
        if errors.is_empty() {
            return Ok(scene);
        }
        errors.extend(file_errors(&scene, load));
        errors.sort_by_key(|e| e.place.order());
        Err(SceneErrors(errors))
    }
}

/// The readable part of a scene, and every error.
fn decode(text: &str) -> (Scene, Vec<SceneError>) {
    let (text, tree, syntax_errors) = parse(text);
    let mut d = Decoder::new(text);
    let scene = decode_tree(&mut d, tree.get_ref());
    if !syntax_errors.is_empty() {
        keep_certain_errors(&mut d, &syntax_errors);
    }
    d.errors.sort_by_key(|e| e.place.order());
    d.warnings.sort_by_key(|w| w.place.order());
    (Scene { warnings: d.warnings, ..scene }, d.errors)
}

/// Text after the first syntax error that is judged \[bytes\].
const AFTER_FIRST_SYNTAX_ERROR: usize = 1 << 16;

/// The part of a text that is judged, its tree, and its syntax errors. A file that is no scene at all may
/// have millions of errors: then the text is judged up to a line some way after the first one.
fn parse(text: &str) -> (&str, Spanned<DeTable<'_>>, Vec<toml::de::Error>) {
    let first = match DeTable::parse(text) {
        Ok(tree) => return (text, tree, Vec::new()),
        Err(error) => error.span().map_or(0, |span| span.start),
    };
    let end = text.floor_char_boundary(first.saturating_add(AFTER_FIRST_SYNTAX_ERROR));
    let end = match text[..end].rfind('\n') {
        Some(line_end) if line_end > first && end < text.len() => line_end + 1,
        _ => end,
    };
    let judged = &text[..end];
    let (tree, mut errors) = DeTable::parse_recoverable(judged);
    if end < text.len() {
        // An error at the end comes from the cut.
        errors.retain(|e| e.span().is_none_or(|span| span.start < end));
    }
    (judged, tree, errors)
}

/// Adds the syntax errors, and drops errors that may result from them.
fn keep_certain_errors(d: &mut Decoder<'_>, syntax_errors: &[toml::de::Error]) {
    let mut places: Vec<(Place, String)> = syntax_errors
        .iter()
        .map(|e| (d.place(e.span().unwrap_or(0..0), ""), e.message().to_owned()))
        .collect();
    // The parser may have two words for one fault, as for the number -.2.
    places.dedup_by_key(|(place, _)| place.span.start);
    let broken_lines: BTreeSet<usize> = places.iter().map(|(place, _)| place.line).collect();
    d.errors.retain(|e| {
        let echo = matches!(
            e.problem,
            Problem::Missing { .. } | Problem::UnknownName { .. } | Problem::Needs { .. }
        );
        !echo && e.place.span != (0..0) && !broken_lines.contains(&e.place.line)
    });
    for (place, message) in places {
        d.error(place, Problem::Syntax { message });
    }
}

fn decode_tree<'t>(d: &mut Decoder<'t>, tree: &'t DeTable<'t>) -> Scene {
    let start = d.place(0..0, "");
    let top = Section::new(d, tree, start, TOP_KEYS);
    check_version(d, &top);
    let medium = settings::medium(d, &top);
    let gravity = top.vector(d, "gravity", "m/s²").unwrap_or(STANDARD_GRAVITY);
    let simulation = settings::simulation(d, &top);
    let (render, mut acoustics) = settings::render(d, &top, medium);
    let materials = material::materials(d, &top, simulation.contact);
    let mut names = Names::default();
    let bodies = body::bodies(d, &top, &materials, acoustics.medium.sound_speed, &mut names);
    let planes = plane::planes(d, &top, &materials, &mut names, &mut acoustics);
    let named = links::NamedBodies::new(&bodies, &names);
    let hangs = links::hangs(d, &top, &named);
    let springs = links::springs(d, &top, &named);
    let joints = joints::joints(d, &top, &named);
    let loads = loads::loads(d, &top, &named);
    let listeners = listener::listeners(d, &top);
    let scene = Scene {
        acoustics,
        gravity,
        bodies,
        planes,
        hangs,
        springs,
        joints,
        loads,
        listeners,
        materials: materials.into_custom(),
        simulation,
        render,
        warnings: Vec::new(),
    };
    d.errors.extend(below_floor(&scene.listeners, scene.acoustics.floor));
    if let Some(room) = &scene.acoustics.room {
        d.errors.extend(outside(&scene.listeners, room));
    }
    room::check_reverberation(d, &top, &scene.acoustics);
    check_silence(d, &scene, &top);
    scene
}

fn check_version(d: &mut Decoder<'_>, top: &Section<'_>) {
    let Some(node) = top.get("version") else {
        top.missing(d, "version", "version = 1, on the first line");
        return;
    };
    if let Some(found) = node.integer(d, i64::MIN, i64::MAX)
        && found != VERSION
    {
        d.error(node.place(d), Problem::UnsupportedVersion { found });
    }
}

/// Warns of scenes that make no sound.
fn check_silence(d: &mut Decoder<'_>, scene: &Scene, top: &Section<'_>) {
    if scene.listeners.is_empty() {
        d.warn(top.place.clone(), Doubt::NoListener);
    }
    let moving = |b: &super::body_description::BodyDescription| match &b.motion {
        Motion::Fixed => false,
        Motion::Keyframed(track) => !track.is_fixed(),
        Motion::Guided(guide) => !guide.track.is_fixed() || guide.let_go.is_some() || guide.press.is_some(),
        Motion::Free => {
            scene.gravity.length() > 0.0
                || b.velocity.length() > 0.0
                || b.angular_velocity.length() > 0.0
                || !scene.springs.is_empty()
                || !scene.loads.is_empty()
        }
    };
    let bodies: usize = scene.bodies.iter().map(|b| b.count()).sum();
    if !scene.bodies.iter().any(moving) {
        d.warn(top.place.clone(), Doubt::NothingMoves);
    } else if bodies + scene.planes.len() < 2 {
        d.warn(top.place.clone(), Doubt::NothingToHit);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DOCUMENT: &str = include_str!("../../../../docs/format/scene.md");

    /// Keys in the first column of the tables under a heading.
    fn documented(heading: &str) -> Vec<&'static str> {
        let start = DOCUMENT.find(&format!("{heading}\n")).unwrap_or_else(|| panic!("no heading {heading}"));
        let rest = &DOCUMENT[start + heading.len()..];
        let end = rest.find("\n#").unwrap_or(rest.len());
        rest[..end]
            .lines()
            .filter_map(|line| line.strip_prefix("| `")?.split_once("` |").map(|(k, _)| k))
            .collect()
    }

    #[test]
    fn every_key_is_documented_and_every_documented_key_exists() {
        let sections: &[(&str, &[&[&str]])] = &[
            ("## Top level", &[TOP_KEYS]),
            ("## Medium", &[settings::MEDIUM_KEYS]),
            ("## Materials", &[material::KEYS]),
            ("## Bodies", &[body::KEYS]),
            ("### Orientation", &[motion::ORIENTATION_KEYS]),
            ("### Keyframes", &[motion::KEYFRAME_KEYS]),
            ("### Random placement", &[body::PLACEMENT_KEYS]),
            ("### Fracture", &[breaking::KEYS, breaking::SCORE_KEYS]),
            ("### Supports", &[support::KEYS]),
            ("## Planes", &[plane::KEYS]),
            ("## Hung spheres", &[links::HANG_KEYS]),
            ("## Springs", &[links::SPRING_KEYS]),
            ("## Joints", &[joints::HINGE_KEYS]),
            ("## Rods and ropes", &[joints::ROPE_KEYS]),
            ("## Forces", &[loads::KEYS]),
            ("## Listeners", &[listener::KEYS, listener::KEYFRAME_KEYS]),
            ("## Simulation", &[settings::SIMULATION_KEYS]),
            ("## Render", &[settings::RENDER_KEYS, settings::COMPRESSOR_KEYS]),
            ("## Room", &[room::ROOM_KEYS, room::WALL_KEYS]),
        ];
        for (heading, keys) in sections {
            let mut accepted: Vec<&str> = keys.iter().flat_map(|keys| keys.iter().copied()).collect();
            let mut written = documented(heading);
            accepted.sort_unstable();
            written.sort_unstable();
            assert_eq!(accepted, written, "{heading}");
        }
    }

    #[test]
    fn the_examples_of_the_document_decode() {
        let examples: Vec<&str> =
            DOCUMENT.split("```toml\n").skip(1).map(|rest| rest.split("```").next().unwrap()).collect();
        assert!(examples.len() >= 9);
        for example in examples {
            let text =
                if example.contains("version") { example.into() } else { format!("version = 1\n{example}") };
            let scene = Scene::from_toml(&text).unwrap_or_else(|e| panic!("{example}\n{e}"));
            // A text without bodies may lack a listener; a scene with bodies may not.
            assert!(scene.bodies.is_empty() || scene.warnings.is_empty(), "{example}\n{:?}", scene.warnings);
        }
    }
}
