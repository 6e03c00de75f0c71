//! A ball shot at free panes of glass through the stages of a simulation: the modes that are found before
//! anything moves give Zener's restitution, whatever the cache holds.

use std::collections::BTreeSet;
use std::ops::ControlFlow;
use std::path::Path;

use clangor_core::timeline::Timeline;
use clangor_pipeline::formats::model_cache::ModelCache;
use clangor_pipeline::stages::find_impact_modes::find_impact_modes;
use clangor_pipeline::stages::load::{LoadedScene, scene_from_text};
use clangor_pipeline::stages::simulate::simulate_impacts;
use clangor_sim::SimulationReport;

/// A steel ball of 5 mm 1 mm above a weightless pane, at 1 m/s, without losses of the contact.
fn scene(pane: &str, top: f64, contact: &str) -> LoadedScene {
    let text = format!(
        r#"
version = 1
gravity = [0.0, 0.0, 0.0]

[simulation]
solver = "rigid"
contact = "{contact}"
duration = 0.01

[material.clear]
base = "glass"
restitution = 1.0

[material.hard]
base = "steel"
restitution = 1.0

[[body]]
name = "pane"
shape = "{pane}"
material = "clear"

[[body]]
name = "ball"
shape = "sphere:0.005"
material = "hard"
position = [0.0, {height}, 0.0]
velocity = [0.0, -1.0, 0.0]

[[listener]]
name = "microphone"
position = [0.0, 0.0, 1.0]
"#,
        height = top + 0.006
    );
    scene_from_text(Path::new("panes.toml"), text, &|_| ()).unwrap()
}

fn run(loaded: &LoadedScene) -> (Timeline, SimulationReport) {
    simulate_impacts(loaded, &BTreeSet::new(), &mut |_| ControlFlow::Continue(())).unwrap()
}

/// (impulse)/(m V) − 1.
fn bounce(loaded: &LoadedScene) -> f64 {
    let (timeline, report) = run(loaded);
    assert_eq!((report.solved, report.fallen_back), (1, 0));
    timeline.contacts.iter().map(|row| row.impulse_n).sum::<f64>() / loaded.world.bodies[1].mass - 1.0
}

/// Restitutions of a supported pane with all modes, of an ODE of all coordinates.
fn panes_bounce(panes: &[(f64, f64)]) {
    for (thickness, known) in panes {
        let mut loaded = scene(&format!("box:0.25x{thickness}x0.25"), 0.5 * thickness, "compliant");
        let modes = find_impact_modes(&loaded, None, &mut |_| ControlFlow::Continue(())).unwrap();
        loaded.give_modes(modes);
        assert_eq!(loaded.modes.count(), 1);
        let restitution = bounce(&loaded);
        println!("{thickness}: {restitution:.4} of {known} after {:?}", loaded.modes.obtained);
        assert!((restitution - known).abs() < 0.02, "{thickness}: {restitution}");
    }
}

#[test]
fn thick_panes_bounce_as_with_all_modes() {
    panes_bounce(&[(0.006, 0.652), (0.010, 0.855)]);
}

#[test]
#[ignore = "a minute, for the modes"]
fn thin_panes_bounce_as_with_all_modes() {
    panes_bounce(&[(0.003, 0.171), (0.004, 0.383)]);
}

#[test]
fn motion_does_not_depend_on_the_cache() {
    let folder = tempfile::tempdir().unwrap();
    let cache = ModelCache::new(folder.path());
    let find = |cache: Option<&ModelCache>| {
        let mut loaded = scene("coin:0.02x0.0012@0.0005", 0.0006, "compliant");
        let modes = find_impact_modes(&loaded, cache, &mut |_| ControlFlow::Continue(())).unwrap();
        loaded.give_modes(modes);
        (loaded.modes.obtained[0].1, run(&loaded))
    };
    let (none, without) = find(None);
    let (empty, first) = find(Some(&cache));
    let (full, second) = find(Some(&cache));
    assert_eq!([none, empty, full], [false, false, true]);
    assert!(without.1.solved > 0);
    assert_eq!(without, first);
    assert_eq!(without, second);
    // Nothing is found for rigid contacts, and for bodies that hardly vibrate.
    for (shape, top, contact) in
        [("coin:0.02x0.0012@0.0005", 0.0006, "rigid"), ("box:0.03x0.02x0.03", 0.01, "compliant")]
    {
        let mut loaded = scene(shape, top, contact);
        let modes = find_impact_modes(&loaded, None, &mut |_| ControlFlow::Continue(())).unwrap();
        loaded.give_modes(modes);
        assert_eq!(loaded.modes.count(), 0, "{shape}");
    }
}

#[test]
fn thin_bodies_without_modes_bounce_as_whole_bodies() {
    let text = |rule: &str| {
        format!(
            r#"
version = 1

[[body]]
name = "coin"
shape = "coin:0.02x0.0012@0.0005"
material = "ceramic"
position = [0, 1, 0]
{rule}

[[body]]
name = "block"
shape = "box:0.03x0.02x0.03"
material = "ceramic"

[[listener]]
name = "microphone"
position = [0, 0, 1]
"#
        )
    };
    let restitutions = |rule: &str| {
        let mut loaded = scene_from_text(Path::new("coin.toml"), text(rule), &|_| ()).unwrap();
        let modes = find_impact_modes(&loaded, None, &mut |_| ControlFlow::Continue(())).unwrap();
        loaded.give_modes(modes);
        [0, 1].map(|body| loaded.world.bodies[body].material.restitution)
    };
    assert_eq!(restitutions(""), [0.98, 0.98]);
    assert_eq!(restitutions("modal = \"none\""), [0.7, 0.98]);
}
