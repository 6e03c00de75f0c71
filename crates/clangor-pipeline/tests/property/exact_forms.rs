//! Bodies that would do as ellipsoids have fields of their own where these are few and cheap.

use clangor_core::body::Body;
use clangor_core::scene::Scene;
use clangor_core::scene::instantiate::{instantiate, load_shape};
use clangor_core::synthesis::RenderSettings;
use clangor_core::synthesis::source_rule::{Reason, SourceKind};
use clangor_pipeline::formats::soundbank::default_bank;
use clangor_pipeline::stages::sound_models::AccelerationSettings;
use clangor_pipeline::stages::sound_models::patience::PATIENCE;

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

fn reasons(shapes: &[String], patience: f64) -> Vec<(bool, Reason)> {
    let bank = default_bank();
    let settings = AccelerationSettings::new(RenderSettings::default().max_wavenumber(), 0.01, patience);
    let all = settings.decide(&bodies(shapes), &[], bank.as_ref());
    all[..shapes.len()].iter().map(|d| (d.kind == SourceKind::Own, d.reason)).collect()
}

#[test]
fn property_few_forms_have_their_own_fields_and_many_are_ellipsoids() {
    let shapes = ["die:0.016x0.002", "coin", "rock:3x0.01", "die:0.016x0.002"].map(String::from);
    assert_eq!(reasons(&shapes, PATIENCE), [(true, Reason::ExactForm { forms: 3 }); 4]);
    // Without patience, nothing is baked that an ellipsoid can stand for.
    assert!(reasons(&shapes, 0.0).iter().all(|(own, _)| !own));
    let many: Vec<String> = (0..9).map(|i| format!("die:{}x0.001", 0.01 + 0.001 * f64::from(i))).collect();
    let found = reasons(&many, PATIENCE);
    assert!(found.iter().all(|(_, reason)| matches!(reason, Reason::SmallAndConvex { .. })), "{found:?}");
    assert!(reasons(&many[1..], PATIENCE).iter().all(|(own, _)| *own));
}
