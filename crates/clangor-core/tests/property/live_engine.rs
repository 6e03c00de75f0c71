//! Robustness of a live engine: too many events, late and distant ones, invalid numbers; and changes without
//! audible clicks.

use std::sync::Arc;

use crate::ringing::{mode, source};
use clangor_core::glam::DVec3;
use clangor_core::material::Damping;
use clangor_core::pose::Pose;
use clangor_core::realtime::{
    Budget, Controller, Engine, EngineSettings, Event, ImpactEvent, ImpactTarget, Part, SendError,
    SoundingObject, engine,
};
use clangor_core::synthesis::listener::Floor;
use clangor_core::synthesis::modal::{ModalSettings, ModalSource};
use num_complex::Complex64;

const BLOCK: usize = 128;

/// One mode at 400 Hz that hardly decays, with equal pressure in all directions.
fn hum() -> Arc<ModalSource> {
    let modes = vec![mode(400.0, DVec3::Z, vec![Complex64::ONE])];
    source(modes, &Damping::T60(30.0), &ModalSettings { radiation_damping: false, ..Default::default() })
}

fn marble(time: f64) -> ImpactEvent {
    ImpactEvent {
        target: ImpactTarget::Sphere { radius: 0.01 },
        time,
        duration: 60e-6,
        force: None,
        pose: Pose::IDENTITY,
        velocity_change: DVec3::Y,
        angular_velocity_change: DVec3::ZERO,
        point: DVec3::ZERO,
        impulse: 0.01 * DVec3::Y,
    }
}

fn bell(slot: usize, time: f64) -> ImpactEvent {
    ImpactEvent { target: ImpactTarget::Object { slot }, impulse: 0.01 * DVec3::Z, ..marble(time) }
}

fn both_ears(place: DVec3) -> Event {
    Event::Receivers([place, place + 0.17 * DVec3::X])
}

fn start(settings: &EngineSettings) -> (Controller, Engine) {
    let (mut controller, engine) = engine(settings).unwrap();
    controller.send(both_ears(DVec3::new(0.3, 0.5, 0.8))).unwrap();
    (controller, engine)
}

/// The samples of the first receiver in this number of blocks.
fn listen(engine: &mut Engine, blocks: usize) -> Vec<f64> {
    (0..blocks).flat_map(|_| engine.render(BLOCK)[0].clone()).collect()
}

/// Largest change from one sample to the next.
fn steepest(samples: &[f64]) -> f64 {
    samples.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max)
}

fn loudest(samples: &[f64]) -> f64 {
    samples.iter().fold(0.0, |m: f64, p| m.max(p.abs()))
}

#[test]
fn a_million_impacts_a_second_are_borne_and_counted() {
    let settings = EngineSettings::default();
    let (mut controller, mut engine) = start(&settings);
    for slot in 0..8 {
        controller.put(slot, Some(SoundingObject::new(None, Some(hum()), &settings))).unwrap();
    }
    let (mut sent, mut full) = (0, 0);
    for block in 0..40 {
        for k in 0..2667 {
            let time = engine.time() + 1e-6 * f64::from(k);
            let impact = if k % 3 == 0 { bell(k as usize % 8, time) } else { marble(time) };
            match controller.send(Event::Impact(impact)) {
                Ok(()) => sent += 1,
                Err(error) => {
                    assert_eq!(error, SendError::Full);
                    full += 1;
                }
            }
        }
        let heard = engine.render(BLOCK);
        assert!(heard.iter().flatten().all(|p| p.is_finite()), "block {block}");
    }
    let report = controller.report();
    assert_eq!((report.taken, report.lost), (sent, full));
    // Two ears: two waves of each click, at most 100 in a block.
    assert!(report.waves <= 40 * 100 && report.shed > 10_000, "{report:?}");
    // Afterwards the state is as before.
    listen(&mut engine, 200);
    let before = controller.report();
    controller.send(Event::Impact(marble(engine.time()))).unwrap();
    assert!(loudest(&listen(&mut engine, 20)) > 0.0);
    let after = controller.report();
    assert_eq!((after.waves, after.shed), (before.waves + 2, before.shed));
}

#[test]
fn nonsense_is_refused_and_counted() {
    let (mut controller, mut engine) = start(&EngineSettings::default());
    let good = marble(0.0);
    let pose =
        |pose| Event::Pose { slot: 0, time: 0.0, pose, velocity: DVec3::ZERO, angular_velocity: DVec3::ZERO };
    let turned =
        Pose { orientation: clangor_core::glam::DQuat::from_xyzw(9.0, 0.0, 0.0, 1.0), ..Pose::IDENTITY };
    let nonsense = [
        Event::Impact(ImpactEvent { time: f64::NAN, ..good.clone() }),
        Event::Impact(ImpactEvent { time: f64::INFINITY, ..good.clone() }),
        Event::Impact(ImpactEvent { time: 1e9, ..good.clone() }),
        Event::Impact(ImpactEvent { duration: -1.0, ..good.clone() }),
        Event::Impact(ImpactEvent { duration: 1e3, ..good.clone() }),
        Event::Impact(ImpactEvent { duration: 1e306, ..good.clone() }),
        Event::Impact(ImpactEvent { target: ImpactTarget::Sphere { radius: 1e-160 }, ..good.clone() }),
        Event::Impact(ImpactEvent { velocity_change: 1e300 * DVec3::Y, ..good.clone() }),
        Event::Impact(ImpactEvent { velocity_change: DVec3::NAN, ..good.clone() }),
        Event::Impact(ImpactEvent { pose: Pose::at(DVec3::INFINITY), ..good.clone() }),
        Event::Impact(ImpactEvent { pose: turned, ..good.clone() }),
        Event::Impact(ImpactEvent { target: ImpactTarget::Sphere { radius: 0.0 }, ..good.clone() }),
        Event::Impact(bell(3, 0.0)),
        Event::Impact(bell(usize::MAX, 0.0)),
        pose(turned),
        pose(Pose::at(1e308 * DVec3::X)),
        Event::Pose {
            slot: 0,
            time: 0.0,
            pose: Pose::IDENTITY,
            velocity: DVec3::ZERO,
            angular_velocity: 1e200 * DVec3::X,
        },
        pose(Pose::IDENTITY),
        Event::Receivers([DVec3::NAN, DVec3::ZERO]),
        Event::Put { slot: 1 << 40, object: None },
    ];
    let count = nonsense.len() as u64;
    for event in nonsense {
        controller.send(event).unwrap();
    }
    // A force too long for a wave is rejected at both ears; a wave from too far away is left out.
    controller.send(Event::Impact(ImpactEvent { duration: 1.0, ..good.clone() })).unwrap();
    controller.send(Event::Impact(ImpactEvent { pose: Pose::at(1e4 * DVec3::X), ..good.clone() })).unwrap();
    assert!(listen(&mut engine, 40).iter().all(|p| !p.is_nan()));
    let report = controller.report();
    assert_eq!((report.refused, report.distant), (count + 2, 2), "{report:?}");
}

#[test]
fn late_events_are_rendered_late_and_whole() {
    let wave = |time: f64, blocks: usize| {
        let (mut controller, mut engine) = start(&EngineSettings::default());
        listen(&mut engine, blocks);
        controller.send(Event::Impact(marble(time))).unwrap();
        (listen(&mut engine, 12), controller.report().late)
    };
    let ((in_time, none), (late, one)) = (wave(0.0, 0), wave(-30.0, 3));
    assert_eq!((none, one), (0, 1));
    // The same click, but for where between two samples it begins.
    // Residual seen: 4e-14.
    assert!((loudest(&late) / loudest(&in_time) - 1.0).abs() < 0.1);
}

#[test]
fn too_many_modes_fade_out_the_quietest() {
    // Of three hums the budget allows two: 16 modes and the delay lines, for two ears.
    let budget = Budget { mode_paths: 2 * 2 * (16 + 8), ..Budget::default() };
    let settings = EngineSettings { budget, ..EngineSettings::default() };
    let play = |impacts: &[(usize, f64)]| {
        let (mut controller, mut engine) = start(&settings);
        for slot in 0..3 {
            controller.put(slot, Some(SoundingObject::new(None, Some(hum()), &settings))).unwrap();
        }
        for (slot, strength) in impacts {
            let impact = bell(*slot, 0.02 * *slot as f64);
            controller
                .send(Event::Impact(ImpactEvent { impulse: *strength * impact.impulse, ..impact }))
                .unwrap();
        }
        (listen(&mut engine, 100), controller.report())
    };
    let (heard, report) = play(&[(0, 1.0), (1, 0.1), (2, 1.0)]);
    assert_eq!((report.shed_voices, report.modes), (1, 32), "{report:?}");
    let (both, _) = play(&[(0, 1.0), (2, 1.0)]);
    // The two loud ones remain, without a step in the transition.
    let apart = heard[9000..].iter().zip(&both[9000..]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    // Residual seen: 0; the steepest is 1 %.
    assert!(apart < 1e-9 * loudest(&both), "{apart:e}");
    assert!(steepest(&heard[6400..]) < 0.06 * loudest(&heard), "{}", steepest(&heard[6400..]));
}

#[test]
fn what_changes_makes_no_click() {
    let place = DVec3::new(0.3, 0.5, 0.8);
    let other = || EngineSettings::default().with_floor(Floor::Rigid { height: -0.5 });
    let another = SoundingObject::new(None, Some(hum()), &other());
    // Afterwards: silence, or sound.
    let changes: [(&str, bool, Vec<Event>); 10] = [
        ("nothing", true, vec![]),
        ("the ears step aside", true, vec![both_ears(DVec3::new(0.5, 0.6, 0.9))]),
        ("the ears are somewhere else", true, vec![both_ears(DVec3::new(3.0, 2.0, 4.0))]),
        ("the ears are below the floor", true, vec![both_ears(place - 2.0 * DVec3::Y)]),
        ("the ears are far away", false, vec![both_ears(100.0 * DVec3::X)]),
        ("reflections are switched off", true, vec![Event::Switch(Part::Reflections, false)]),
        ("ringing is switched off", false, vec![Event::Switch(Part::Modal, false)]),
        ("the object is no more", false, vec![Event::End { slot: 0, time: 0.0 }]),
        ("another takes its place", false, vec![Event::Put { slot: 0, object: Some(Box::new(another)) }]),
        ("all stops", false, vec![Event::Silence]),
    ];
    for (name, sounds, events) in changes {
        let settings = other();
        let (mut controller, mut engine) = start(&settings);
        controller.put(0, Some(SoundingObject::new(None, Some(hum()), &settings))).unwrap();
        controller.send(Event::Impact(bell(0, 0.0))).unwrap();
        let before = listen(&mut engine, 30);
        let level = loudest(&before[2560..]);
        events.into_iter().for_each(|event| controller.send(event).unwrap());
        let mut after = before[before.len() - 1..].to_vec();
        for frames in [128, 129, 40].into_iter().cycle().take(60) {
            after.extend_from_slice(&engine.render(frames)[0]);
        }
        // A hum at 400 Hz moves by 2π 400/48000 = 5.2 % from sample to sample, a fade within 1 ms by 2 %.
        let steep = steepest(&after) / level;
        // Seen: 5.0 to 5.5 %.
        assert!(steep < 0.085, "{name}: {steep}");
        assert_eq!(loudest(&after[4500..]) > 0.0, sounds, "{name}");
    }
}

#[test]
fn an_object_too_large_for_the_budget_rings_all_the_same() {
    for frames in [128, 100, 4096] {
        let budget = Budget { transfers: 0, ..Budget::default() };
        let settings = EngineSettings { budget, ..EngineSettings::default() };
        let (mut controller, mut engine) = start(&settings);
        for slot in 0..2 {
            controller.put(slot, Some(SoundingObject::new(None, Some(hum()), &settings))).unwrap();
            controller.send(Event::Impact(bell(slot, 0.01))).unwrap();
        }
        let heard: Vec<f64> = (0..60).flat_map(|_| engine.render(frames)[0].clone()).collect();
        // Two begin at once, and the budget allows one: the other waits for a block.
        let report = controller.report();
        let heard_of = (report.shed, report.late, report.voices);
        assert!(loudest(&heard) > 0.0 && heard_of == (0, 1, 2), "{frames}: {report:?}");
    }
}

#[test]
fn an_ear_inside_what_rings_hears_no_nonsense() {
    let settings = EngineSettings::default();
    let (mut controller, mut engine) = start(&settings);
    controller.put(0, Some(SoundingObject::new(None, Some(hum()), &settings))).unwrap();
    controller.send(both_ears(DVec3::ZERO)).unwrap();
    controller.send(Event::Impact(bell(0, 0.0))).unwrap();
    controller.send(Event::Impact(marble(0.0))).unwrap();
    let heard = listen(&mut engine, 20);
    assert!(heard.iter().all(|p| p.is_finite()) && loudest(&heard) > 0.0);
    assert_eq!(controller.report().inside, 1);
}

#[test]
fn blocks_of_any_length_sound_alike() {
    let render = |lengths: &[usize]| {
        let settings = EngineSettings::default();
        let (mut controller, mut engine) = start(&settings);
        controller.put(0, Some(SoundingObject::new(None, Some(hum()), &settings))).unwrap();
        controller.send(Event::Impact(marble(0.01))).unwrap();
        controller.send(Event::Impact(bell(0, 0.012))).unwrap();
        let mut heard = Vec::new();
        for length in lengths.iter().cycle() {
            if heard.len() >= 4800 {
                break;
            }
            heard.extend_from_slice(&engine.render(*length)[0]);
        }
        heard.truncate(4800);
        heard
    };
    let even = render(&[128]);
    for lengths in [&[1_usize][..], &[4096], &[37, 128, 900]] {
        let other = render(lengths);
        let apart = even.iter().zip(&other).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        // Residual seen: 0.
        assert!(apart < 1e-6 * loudest(&even), "{lengths:?}: {:e}", apart / loudest(&even));
    }
}

#[test]
fn objects_that_are_replaced_come_back_to_be_freed() {
    let settings = EngineSettings::default();
    let (mut controller, mut engine) = start(&settings);
    let ringing = hum();
    let held = Arc::strong_count(&ringing);
    for _ in 0..5 {
        let object = SoundingObject::new(None, Some(Arc::clone(&ringing)), &settings);
        controller.put(0, Some(object)).unwrap();
        engine.render(BLOCK);
    }
    controller.put(0, None).unwrap();
    listen(&mut engine, 200);
    controller.send(both_ears(DVec3::ONE)).unwrap();
    assert_eq!(Arc::strong_count(&ringing), held);
    drop(engine);
    assert_eq!(controller.send(both_ears(DVec3::ONE)), Err(SendError::Gone));
    assert_eq!(controller.report().lost, 0);
}
