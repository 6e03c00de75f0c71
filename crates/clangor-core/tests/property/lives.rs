//! Bodies that are born and die: valid times of impacts, poses, and the end of their sound.

use std::f64::consts::PI;

use crate::ringing::{body, impact, mode, source};
use clangor_core::body::{Body, BodyId, Life, Motion};
use clangor_core::contact::{
    ContactError, ContactSettings, ForceSettings, PoseHistory, StruckBodies, crack_pulses, impact_pulses,
};
use clangor_core::glam::{DMat3, DVec3};
use clangor_core::material::Damping;
use clangor_core::medium::Medium;
use clangor_core::pose::Pose;
use clangor_core::sound_model::AccelerationRule;
use clangor_core::sound_model::rule::{SoundRule, rules_with_pieces};
use clangor_core::synthesis::modal::{ModalSettings, ModalVoice};
use clangor_core::synthesis::{Listener, RenderSettings};
use clangor_core::timeline::{ContactKind, ContactRow, FractureRow, Timeline, TimelineSink};
use num_complex::Complex64;

const BREAKS: f64 = 0.1;

/// A body that breaks into two; the first piece breaks into two more at twice the time.
fn broken() -> (Vec<Body>, Timeline) {
    let start = vec![body(Motion::Free)];
    let mut timeline = Timeline::default();
    let pieces = |parent: u32, time: f64| -> Vec<Body> {
        let piece = |x: f64| Body {
            name: format!("piece of {parent} at {x}"),
            pose: Pose::at(DVec3::X * x),
            mass: 0.5,
            inertia: DMat3::IDENTITY * 0.1,
            life: Life::of_piece(BodyId(parent), time),
            ..body(Motion::Free)
        };
        vec![piece(-0.2), piece(0.2)]
    };
    for (parent, first, time) in [(0, 1, BREAKS), (1, 3, 2.0 * BREAKS)] {
        let row = FractureRow {
            time,
            first_child: BodyId(first),
            children: 2,
            duration: 1e-4,
            ..FractureRow::of(BodyId(parent))
        };
        timeline.fracture(&row, &pieces(parent, time)).unwrap();
    }
    (start, timeline)
}

fn row(kind: ContactKind, time: f64, [a, b]: [u32; 2]) -> ContactRow {
    ContactRow {
        time,
        body_a: BodyId(a),
        body_b: BodyId(b),
        kind,
        point: DVec3::new(0.0, 0.03, 0.01),
        normal: DVec3::X,
        impulse_n: 0.2,
        impulse_t: DVec3::Y * 0.1,
        couple: DVec3::Z * 1e-3,
        velocity: if kind == ContactKind::Impact { DVec3::NEG_X } else { DVec3::ZERO },
        depth: 0.0,
        impact_id: 7,
        effective_mass: None,
    }
}

#[test]
fn a_timeline_lists_all_bodies_and_their_lives() {
    let (start, timeline) = broken();
    let lives: Vec<_> = timeline.all_bodies(&start).iter().map(|b| (b.life.birth, b.life.death)).collect();
    let later = 2.0 * BREAKS;
    let lasting = f64::INFINITY;
    let expected = [(0.0, BREAKS), (BREAKS, later), (BREAKS, lasting), (later, lasting), (later, lasting)];
    assert_eq!(lives, expected);
    let rules = |of: &[SoundRule]| -> Vec<AccelerationRule> {
        rules_with_pieces(&timeline.all_bodies(&start), of).iter().map(|rule| rule.acceleration).collect()
    };
    assert_eq!(rules(&[AccelerationRule::Own.into()]), [AccelerationRule::Own; 5]);
    assert_eq!(rules(&[])[..2], [AccelerationRule::Auto, AccelerationRule::Proxy]);
}

#[test]
fn the_unborn_and_the_dead_are_not_struck() {
    let (start, timeline) = broken();
    let bodies = timeline.all_bodies(&start);
    let poses = PoseHistory::try_new(&bodies, &[]).unwrap();
    let settings = ContactSettings::default();
    for (id, time, alive) in [
        (0, BREAKS, true),
        (0, BREAKS + 1e-4, false),
        (1, BREAKS - 1e-4, false),
        (1, BREAKS, true),
        (2, 9.0, true),
        (4, BREAKS, false),
    ] {
        let rows = [row(ContactKind::Impact, time, [id, u32::MAX])];
        let outcome = impact_pulses(&bodies, &rows, &poses, &settings);
        match outcome {
            Ok((pulses, _)) => assert!(alive && pulses.len() == 1, "{id} at {time}"),
            Err(error) => {
                assert!(!alive && matches!(error, ContactError::NotAlive { .. }), "{error}");
                assert!(error.to_string().contains("which lives from"), "{error}");
            }
        }
    }
    // Before its birth a body is where it will be born.
    assert_eq!(poses.at(BodyId(2), 0.0).position, DVec3::X * 0.2);
    assert_eq!(poses.life(BodyId(1)).parent, Some(BodyId(0)));
}

#[test]
fn cracks_push_both_sides_apart_for_as_long_as_the_fracture_takes() {
    let (start, timeline) = broken();
    let bodies = timeline.all_bodies(&start);
    let poses = PoseHistory::try_new(&bodies, &[]).unwrap();
    let rows = [row(ContactKind::Fracture, BREAKS, [1, 2]), row(ContactKind::Fracture, BREAKS, [1, 2])];
    let struck = StruckBodies::rigid(&bodies, &poses);
    // Crack pulses ignore impacts, and impact pulses ignore cracks.
    let (none, report) = impact_pulses(&bodies, &rows, &poses, &ContactSettings::default()).unwrap();
    assert!(none.is_empty() && report.slow == 0);
    let pulses = crack_pulses(struck, &rows, &timeline.fractures, &ForceSettings::default()).unwrap();
    let [pulse] = &pulses[..] else { panic!("{pulses:?}") };
    assert_eq!((pulse.time, pulse.duration, pulse.impact_id), (BREAKS, 1e-4, 7));
    let [Some(a), Some(b)] = pulse.bodies else { panic!("both move") };
    assert_eq!((a.body, b.body), (BodyId(1), BodyId(2)));
    // Residual seen: 0.
    assert!(
        (a.impulse + b.impulse).length() < 1e-15 && (a.impulse - DVec3::new(0.4, 0.2, 0.0)).length() < 1e-15
    );
    // ½ m V² is the energy of the two by the crack alone. Residual seen: 0.
    let energy = |share: &clangor_core::contact::BodyPulse| {
        let (p, l) = (share.impulse.length_squared(), share.angular_impulse.length_squared());
        0.5 * (p / 0.5 + l / 0.1)
    };
    let given = 0.5 * pulse.effective_mass * pulse.speed.powi(2);
    assert!((given / (energy(&a) + energy(&b)) - 1.0).abs() < 1e-14, "{pulse:?}");
    let about_origin = |share: &clangor_core::contact::BodyPulse| {
        share.angular_impulse + share.pose.position.cross(share.impulse)
    };
    assert!((about_origin(&a) + about_origin(&b)).length() < 1e-15);
    // Nothing else gives a crack its duration.
    let orphan = [row(ContactKind::Fracture, BREAKS, [1, 2])];
    let error = crack_pulses(struck, &orphan, &[], &ForceSettings::default()).unwrap_err();
    assert!(matches!(error, ContactError::NoDuration { .. }), "{error}");
}

/// Samples of a bell that dies, at 1 m.
fn heard(death: f64, count: usize) -> Vec<f64> {
    let modes = vec![mode(1200.0, DVec3::Z, vec![Complex64::new(0.6, -0.8)])];
    let source = source(modes, &Damping::T60(2.0), &ModalSettings::default());
    let bell = Body { life: Life { death, ..Life::LASTING }, ..body(Motion::Free) };
    let poses = PoseHistory::try_new(&[bell], &[]).unwrap();
    let listener = Listener::fixed("microphone", DVec3::new(0.0, 0.0, 1.0));
    let mut voice =
        ModalVoice::new(source, BodyId(0), &poses, &listener, &RenderSettings::default()).unwrap();
    voice.push_pulses(&[impact(0.01, 1e-4, Pose::IDENTITY)]).unwrap();
    let mut sound = Vec::new();
    // In stretches, as a renderer does.
    for first in (0..count).step_by(1000) {
        let mut channels = vec![vec![0.0; 1000]];
        voice.render_block(first as i64, &mut channels).unwrap();
        sound.append(&mut channels[0]);
    }
    sound
}

#[test]
fn the_sound_of_a_dying_body_fades_and_what_has_left_it_arrives() {
    let rate = 48_000.0;
    let (whole, cut) = (heard(f64::INFINITY, 12_000), heard(BREAKS, 12_000));
    let level = whole.iter().fold(0.0f64, |m, p| m.max(p.abs()));
    let arrives = (BREAKS + 1.0 / Medium::AIR.sound_speed) * rate;
    let mut residual = 0.0f64;
    for (k, (whole, cut)) in whole.iter().zip(&cut).enumerate() {
        let part = ((k as f64 - arrives) / (1e-3 * rate)).clamp(0.0, 1.0);
        residual = residual.max((whole * 0.5 * (1.0 + (PI * part).cos()) - cut).abs());
    }
    // Residual seen: 5e-6 of the level, by the kink of the window between two samples at its ends.
    assert!(residual < 5e-5 * level, "{:e}", residual / level);
    // The delay between two samples reaches 32 samples to both sides.
    assert!(cut[(arrives + 0.0018 * rate) as usize..].iter().all(|p| *p == 0.0));
    assert!(cut[..arrives as usize - 40] == whole[..arrives as usize - 40]);
}
