//! Few small exact forms have fields of their own; stones and heaps of different forms sound as ellipsoids.

use clangor_core::body::Body;
use clangor_core::scene::Scene;
use clangor_core::scene::instantiate::{instantiate, load_shape};
use clangor_core::synthesis::RenderSettings;
use clangor_core::synthesis::source_rule::{Reason, SourceKind};
use clangor_pipeline::formats::soundbank::default_bank;
use clangor_pipeline::stages::sound_models::AccelerationSettings;

fn bodies(shapes: &[String]) -> Vec<Body> {
    let mut text = String::from("version = 1\n");
    for (i, shape) in shapes.iter().enumerate() {
        text += &format!(
            "[[body]]\nname = \"b{i}\"\nshape = \"{shape}\"\nmaterial = \"steel\"\nposition = [0, {}, 0]\n",
            i + 1
        );
    }
    text += "[[plane]]\nmaterial = \"granite\"\n[[listener]]\nposition = [1, 1, 1]\n";
    instantiate(&Scene::from_toml(&text).unwrap(), &mut load_shape).unwrap().world.bodies
}

fn reasons(shapes: &[String], bake: bool) -> Vec<(bool, Reason)> {
    let bank = default_bank();
    let settings = AccelerationSettings::new(RenderSettings::default().max_wavenumber(), 0.01, bake);
    let all = settings.decide(&bodies(shapes), &[], bank.as_ref());
    all[..shapes.len()].iter().map(|d| (d.kind == SourceKind::Own, d.reason)).collect()
}

#[test]
fn few_exact_forms_are_computed_and_many_are_not() {
    let shapes = ["die:0.016x0.002", "coin", "rock:3x0.01", "die:0.016x0.002"].map(String::from);
    let found = reasons(&shapes, true);
    let exact = (true, Reason::ExactForm { forms: 2 });
    assert_eq!([found[0], found[1], found[3]], [exact; 3]);
    assert!(matches!(found[2], (false, Reason::SmallAndConvex { .. })), "{found:?}");
    assert!(reasons(&shapes, false).iter().all(|(own, _)| !own));
    let many: Vec<String> = (0..9).map(|i| format!("die:{}x0.001", 0.01 + 0.001 * f64::from(i))).collect();
    assert!(reasons(&many, true).iter().all(|(own, _)| !own));
    assert!(reasons(&many[1..], true).iter().all(|(own, _)| *own));
}
