//! Any text results in a scene or in located errors with remedies: never in a panic.

use clangor_core::scene::Scene;
use clangor_core::scene::instantiate::load_shape;
use proptest::prelude::*;

/// Scenes to mutilate; the rocks are left out, whose loading takes the time.
const SCENES: [&str; 5] = [
    include_str!("../../../../scenes/newtons-cradle.toml"),
    include_str!("../../../../scenes/pool-break.toml"),
    include_str!("../../../../scenes/dice.toml"),
    include_str!("../../../../scenes/key-chain.toml"),
    include_str!("../../../../docs/format/scene.md"),
];

/// Pieces of scenes, and pieces that belong nowhere.
const PIECES: [&str; 24] = [
    "[[body]]\n",
    "shape = \"sphere:0.01\"\n",
    "material = \"steel\"\n",
    "[render]\n",
    "version = 1\n",
    "[[listener]]\n",
    "position = [0, 1, 2]\n",
    "= ",
    "[",
    "]",
    "{",
    "}",
    "\"",
    "'''",
    "nan",
    "-inf",
    "1e999",
    "0x7fffffffffffffffffff",
    "\n",
    "#",
    "é",
    "\u{0}",
    "a.b.c = 3\n",
    "count = 100000\nplacement = { region = [[0,0,0],[0,0,0]] }\n",
];

fn check(text: &str) -> Result<(), TestCaseError> {
    match Scene::from_toml(text) {
        Ok(scene) => {
            // Spheres and planes only: the rest is a matter of the shapes.
            if references_are_cheap(&scene) {
                let _ = clangor_core::scene::instantiate(&scene, &mut load_shape);
            }
        }
        Err(errors) => {
            prop_assert!(!errors.0.is_empty());
            for error in errors.0 {
                let lines = text.lines().count().max(1) + 1;
                prop_assert!((1..=lines).contains(&error.place.line), "{}", error);
                prop_assert!(error.place.column >= 1);
                prop_assert!(error.place.span.end <= text.len().max(error.place.span.start));
                prop_assert!(!error.problem.to_string().is_empty() && !error.problem.remedy().is_empty());
            }
        }
    }
    Ok(())
}

fn references_are_cheap(scene: &Scene) -> bool {
    let count: usize = scene.bodies.iter().map(|b| b.count()).sum();
    count < 200 && scene.bodies.iter().all(|b| format!("{:?}", b.geometry).contains("sphere"))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn arbitrary_text(text in "\\PC{0,300}") {
        check(&text)?;
    }

    #[test]
    fn arbitrary_bytes(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
        check(&String::from_utf8_lossy(&bytes))?;
    }

    #[test]
    fn pieces_in_any_order(order in proptest::collection::vec(0..PIECES.len(), 0..40)) {
        let text: String = order.into_iter().map(|i| PIECES[i]).collect();
        check(&text)?;
    }

    #[test]
    fn mutilated_scenes(
        scene in 0..SCENES.len(),
        cuts in proptest::collection::vec((any::<prop::sample::Index>(), 0..12_usize, 0..PIECES.len()), 1..6),
    ) {
        let mut text: Vec<char> = SCENES[scene].chars().collect();
        for (at, length, piece) in cuts {
            let start = at.index(text.len().max(1)).min(text.len());
            let end = (start + length).min(text.len());
            text.splice(start..end, PIECES[piece].chars());
        }
        check(&text.into_iter().collect::<String>())?;
    }
}

#[test]
fn deep_nesting_is_an_error() {
    for text in [
        format!("version = {}1", "[".repeat(100_000)),
        format!("{} = 1", "a.".repeat(100_000) + "a"),
        format!("a = {}", "{ a = ".repeat(100_000)),
        format!("[{}]", "a.".repeat(100_000) + "a"),
    ] {
        assert!(Scene::from_toml(&text).is_err());
    }
}

#[test]
fn many_errors_on_one_line_take_no_longer_than_on_many() {
    let text = format!("version = 1\nbody = [{}]", "{ shape = 1, material = \"steel\" }, ".repeat(20_000));
    // 0.7 MB on one line: counting its characters anew for every error took 6 s.
    assert_eq!(Scene::from_toml(&text).unwrap_err().0.len(), 20_000);
}
