//! Every shipped scene decodes and instantiates without an error or a warning.

use clangor::scene::instantiate::load_shape;
use clangor::scene::{Scene, instantiate};

#[test]
fn ball_drop_becomes_a_ball_above_a_plane() {
    let text = include_str!("../../../scenes/ball-drop.toml");
    let scene = Scene::from_toml(text).unwrap();
    assert_eq!(scene.warnings, []);
    let instance = instantiate(&scene, &mut load_shape).unwrap();
    assert_eq!(instance.world.bodies.len(), 2);
    assert_eq!(instance.warnings, []);
}
