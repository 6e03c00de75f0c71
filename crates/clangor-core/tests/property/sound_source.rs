//! Sources of bodies: the rule, its reasons, the choice of a scene, and the frame of an ellipsoid.

use clangor_core::body::Body;
use clangor_core::glam::DVec3;
use clangor_core::scene::Scene;
use clangor_core::scene::instantiate::{instantiate, load_shape};
use clangor_core::sound_model::AccelerationRule;
use clangor_core::sound_model::acceleration::field::{AccelerationField, Node, Term};
use clangor_core::sound_model::acceleration::model::AccelerationModel;
use clangor_core::sound_model::acceleration::model_evaluator::{BankEvaluator, ModelEvaluator};
use clangor_core::sound_model::acceleration::proxy_field::ProxyFields;
use clangor_core::sound_model::soundbank::ellipsoid_bank::{BankEntry, EllipsoidBank};
use clangor_core::synthesis::source_rule::{Reason, SourceKind, decide, source_of};
use clangor_core::synthesis::{RenderSettings, SoundSource};
use num_complex::Complex64;

/// A dipole that needs nothing to be true.
fn field() -> AccelerationField {
    AccelerationField {
        max_wavenumber: 20.0,
        ring_time: 10.0,
        nodes: vec![Node { s: Complex64::new(0.0, 1.0), weight: Complex64::ONE }],
        terms: vec![Term { n: 1, m: 0, degree: 2 }],
        real: vec![1.0],
        imaginary: vec![0.0],
    }
}

fn bank() -> BankEvaluator {
    let axes = [(1.0, 1.0), (0.9, 0.7), (1.0, 0.1), (0.3, 0.2)];
    let entries = axes.map(|(b, c)| BankEntry { b, c, field: field() }).to_vec();
    BankEvaluator::try_new(EllipsoidBank::try_new(entries).unwrap()).unwrap()
}

fn scene(shape: &str, more: &str) -> Scene {
    Scene::from_toml(&format!(
        "version = 1\n[[body]]\nshape = \"{shape}\"\nmaterial = \"steel\"\n{more}\n[[plane]]\nmaterial = \
         \"granite\"\n\
         [[listener]]\nposition = [1, 1, 1]\n"
    ))
    .unwrap()
}

fn body(shape: &str, more: &str) -> Body {
    instantiate(&scene(shape, more), &mut load_shape).unwrap().world.bodies.swap_remove(0)
}

#[test]
fn rule_goes_by_shape_size_and_hull() {
    let bank = bank();
    let k = RenderSettings::default().max_wavenumber();
    assert!((k - 2.0 * std::f64::consts::PI * 20_000.0 / 343.2).abs() < 1e-9);
    let auto = |shape: &str, more: &str| decide(&body(shape, more), AccelerationRule::Auto, Some(&bank), k);
    let rock = auto("rock:3x0.01", "");
    assert!(
        matches!((rock.kind, rock.reason), (SourceKind::Proxy(_), Reason::SmallAndConvex { .. })),
        "{rock}"
    );
    let die = auto("die", "");
    assert!(matches!(die.kind, SourceKind::Proxy(_)), "{die}");
    let bowl = auto("bowl", "scale = 0.2");
    assert!(matches!((bowl.kind, bowl.reason), (SourceKind::Own, Reason::Hollow { .. })), "{bowl}");
    let boulder = auto("rock:3x0.5", "");
    assert!(matches!((boulder.kind, boulder.reason), (SourceKind::Own, Reason::Large { .. })), "{boulder}");
    let ball = auto("sphere:0.01", "");
    assert_eq!((ball.kind, ball.reason), (SourceKind::Sphere, Reason::IsSphere));
    let fixed = auto("die", "motion = \"fixed\"");
    assert_eq!((fixed.kind, fixed.reason), (SourceKind::Sphere, Reason::Immovable));
    let alone = decide(&body("die", ""), AccelerationRule::Auto, None, k);
    assert_eq!((alone.kind, alone.reason), (SourceKind::Own, Reason::NoEllipsoid));
    // The text for a user.
    assert_eq!(bowl.to_string().split(':').next(), Some("field of its own"), "{bowl}");
    assert!(rock.to_string().contains("convex hull"), "{rock}");

    for (rule, kind) in
        [(AccelerationRule::Sphere, SourceKind::Sphere), (AccelerationRule::Own, SourceKind::Own)]
    {
        let asked = decide(&body("die", ""), rule, Some(&bank), k);
        assert_eq!((asked.kind, asked.reason), (kind, Reason::Asked));
    }
    let asked = decide(&body("bowl", ""), AccelerationRule::Proxy, Some(&bank), k);
    assert!(matches!((asked.kind, asked.reason), (SourceKind::Proxy(_), Reason::Asked)));
    let refused = decide(&body("bowl", ""), AccelerationRule::Proxy, None, k);
    assert_eq!((refused.kind, refused.reason), (SourceKind::Sphere, Reason::NoEllipsoid));
}

#[test]
fn what_is_missing_is_replaced_and_said() {
    let bank = bank();
    let bowl = body("bowl", "");
    let decision = decide(&bowl, AccelerationRule::Own, Some(&bank), 300.0);
    let radius = bowl.surface.bounding_radius();
    let mut proxies = ProxyFields::new(&bank, 300.0);
    let own = ModelEvaluator::try_new(&AccelerationModel { radius, field: field(), near: None }).unwrap();
    let (source, kind) = source_of(&bowl, &decision, Some(&mut proxies), Some(&own));
    assert!(matches!((source, kind), (SoundSource::Field(_), SourceKind::Own)));
    let (_, kind) = source_of(&bowl, &decision, Some(&mut proxies), None);
    assert!(matches!(kind, SourceKind::Proxy(_)));
    let (source, kind) = source_of(&bowl, &decision, None, None);
    assert_eq!((source, kind), (SoundSource::equal_volume_sphere(&bowl.surface), SourceKind::Sphere));
}

#[test]
fn an_ellipsoid_lies_as_its_body_does() {
    let body = body("box:0.01x0.03x0.02", "");
    let decision = decide(&body, AccelerationRule::Proxy, Some(&bank()), 300.0);
    let (SoundSource::Field(source), SourceKind::Proxy(proxy)) =
        source_of(&body, &decision, Some(&mut ProxyFields::new(&bank(), 300.0)), None)
    else {
        panic!("{decision}")
    };
    // The longest axis of the ellipsoid is x, of the box y; the shortest z, of the box x.
    assert!((source.body_from_field * DVec3::X).y.abs() > 0.999);
    assert!((source.body_from_field * DVec3::Z).x.abs() > 0.999);
    assert_eq!(source.radius, proxy.semi_axes.x);
}

#[test]
fn scenes_say_what_bodies_sound_as() {
    let text = |body: &str, render: &str| {
        let copies = "positions = [[0, 1, 0], [0, 2, 0]]";
        let scene = scene("die", &format!("{copies}\n{body}\n[render]\n{render}"));
        scene.sound_rules().into_iter().map(|rule| rule.acceleration).collect::<Vec<_>>()
    };
    assert_eq!(text("", ""), [AccelerationRule::Auto; 2]);
    assert_eq!(text("", "acceleration = \"sphere\""), [AccelerationRule::Sphere; 2]);
    assert_eq!(text("acceleration = \"proxy\"", "acceleration = \"own\""), [AccelerationRule::Proxy; 2]);
    let wrong = "version = 1\n[[body]]\nshape = \"die\"\nmaterial = \"steel\"\nacceleration = \"proxi\"\n";
    let errors = Scene::from_toml(wrong).unwrap_err().to_string();
    assert!(errors.contains("5:16") && errors.contains("`proxy`"), "{errors}");
}
