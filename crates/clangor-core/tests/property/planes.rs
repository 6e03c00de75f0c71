//! Reflections in planes of any orientation: against sources mirrored by hand, against the walls of a room,
//! and what is not heard behind a plane.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use crate::ringing::{impact, mode, poses, source, still};
use clangor_core::acoustics::Acoustics;
use clangor_core::body::{BodyId, Motion};
use clangor_core::contact::ForceProfile;
use clangor_core::glam::{DQuat, DVec3};
use clangor_core::material::{Damping, presets};
use clangor_core::medium::Medium;
use clangor_core::pose::{Keyframe, Pose, Track};
use clangor_core::propagation::{
    Air, Floor, PlanesError, ReflectingPlane, ReflectingPlanes, Room, WallAbsorption,
};
use clangor_core::synthesis::ground::{Ground, GroundSource};
use clangor_core::synthesis::modal::{ModalSettings, ModalSource, ModalVoice};
use clangor_core::synthesis::{
    AccelerationPulse, Listener, OverlapAdd, RenderSettings, Renderer, SoundSource, SynthesisError,
};
use num_complex::Complex64;

const SAMPLES: usize = 4096;

fn hard(normal: DVec3, offset: f64) -> ReflectingPlane {
    ReflectingPlane { normal: normal.normalize(), offset, absorption: WallAbsorption::even(0.0) }
}

/// Two tilted planes and a vertical one, all below or beside what sounds.
fn tilted() -> [ReflectingPlane; 3] {
    [
        hard(DVec3::new(0.3, 1.0, -0.2), -0.4),
        hard(DVec3::new(-0.6, 0.5, 1.0), -0.9),
        hard(DVec3::new(1.0, 0.0, -0.7), -0.5),
    ]
}

fn among(planes: &[ReflectingPlane], order: u32) -> RenderSettings {
    let planes = ReflectingPlanes::try_new(planes, order).unwrap();
    RenderSettings::default().with_acoustics(Acoustics { planes, ..Acoustics::default() })
}

fn click(centre: DVec3, velocity_change: DVec3) -> AccelerationPulse {
    AccelerationPulse {
        body: BodyId(0),
        time: 0.0123,
        duration: 50e-6,
        shape: ForceProfile::HalfSine.into(),
        centre,
        orientation: DQuat::IDENTITY,
        velocity_change,
        angular_velocity_change: DVec3::ZERO,
        source: SoundSource::Sphere { radius: 0.0075 },
    }
}

fn microphone() -> Listener {
    Listener::fixed("microphone", DVec3::new(0.4, 0.5, 0.2))
}

fn heard(clicks: &[AccelerationPulse], listener: &Listener, settings: &RenderSettings) -> Vec<f64> {
    let mut renderer = Renderer::new(listener, settings).unwrap();
    clicks.iter().for_each(|click| renderer.push(click).unwrap());
    let mut signal = OverlapAdd::new(1, 0);
    renderer.take_all().iter().for_each(|job| signal.add(&job.render()));
    signal.take_until(SAMPLES as i64).swap_remove(0)
}

/// Largest difference over the largest value of `b`.
fn difference(a: &[f64], b: &[f64]) -> f64 {
    let largest = b.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / largest
}

/// A click with its mirror image, by the law of reflection alone.
fn mirrored(click: &AccelerationPulse, plane: &ReflectingPlane) -> AccelerationPulse {
    let across = |v: DVec3| 2.0 * v.dot(plane.normal) * plane.normal;
    AccelerationPulse {
        centre: click.centre - across(click.centre - plane.offset * plane.normal),
        velocity_change: click.velocity_change - across(click.velocity_change),
        ..click.clone()
    }
}

#[test]
fn a_plane_makes_the_click_of_the_mirrored_source() {
    let click = click(DVec3::new(0.1, 0.2, -0.1), DVec3::new(0.3, -1.0, 0.2));
    let key = |time, position: DVec3| Keyframe { time, pose: Pose::at(position) };
    let walk = vec![key(0.0, DVec3::new(0.4, 0.5, 0.2)), key(0.05, DVec3::new(0.9, 0.6, -0.1))];
    let walking = Listener::mono("walking", Track::try_new(walk).unwrap());
    for plane in tilted() {
        for listener in [microphone(), walking.clone()] {
            let clicks = [click.clone(), mirrored(&click, &plane)];
            let wanted = heard(&clicks, &listener, &RenderSettings::default());
            let seen = heard(&clicks[..1], &listener, &among(&[plane], 1));
            let direct = heard(&clicks[..1], &listener, &RenderSettings::default());
            // Residuals seen: up to 1e-15.
            let apart = difference(&seen, &wanted);
            assert!(apart < 1e-6 && difference(&direct, &wanted) > 0.05, "{apart:e}");
        }
    }
}

/// Modes whose fields have all parities; `mirrored` in the plane z = 0 of the body.
fn bell(is_mirrored: bool) -> Arc<ModalSource> {
    let coefficient = |i: usize, k: usize| {
        let order = k.isqrt();
        // Y_lm of order l and degree m = k − l² − l changes its sign with z if l + m is odd.
        let odd = (order + k - order * order - order) % 2 == 1;
        let sign = if is_mirrored && odd { -1.0 } else { 1.0 };
        sign * Complex64::cis((i * k) as f64 * 0.7) / (1 + k) as f64
    };
    let modes = (0..12).map(|i| {
        let coefficients = (0..(1 + i % 4_usize).pow(2)).map(|k| coefficient(i, k)).collect();
        mode(400.0 + 1290.0 * i as f64, DVec3::new(0.3, 1.0, 2.0), coefficients)
    });
    source(modes.collect(), &Damping::LossFactor(0.01), &ModalSettings::default())
}

fn ring(source: &Arc<ModalSource>, track: Track, settings: &RenderSettings) -> Vec<f64> {
    let pose = track.sample(0.01).0;
    let (history, listener) = (poses(Motion::Keyframed(track)), microphone());
    let mut voice = ModalVoice::new(Arc::clone(source), BodyId(0), &history, &listener, settings).unwrap();
    voice.push_pulses(&[impact(0.01, 60e-6, pose)]).unwrap();
    let mut channels = [vec![0.0; SAMPLES]];
    voice.render_block(0, &mut channels).unwrap();
    let [channel] = channels;
    channel
}

#[test]
fn a_plane_makes_the_ringing_of_the_mirrored_source() {
    for plane in tilted() {
        // The z axis of the body is along the normal, so that its mirror image has the same axes.
        let orientation = DQuat::from_rotation_arc(DVec3::Z, plane.normal);
        let path = [DVec3::new(0.1, 0.3, -0.1), DVec3::new(0.3, 0.4, 0.2)];
        let track = |mirror: bool| {
            let place = |p: DVec3| {
                let depth = if mirror { plane.height(p) } else { 0.0 };
                p - 2.0 * depth * plane.normal
            };
            let key =
                |(time, position)| Keyframe { time, pose: Pose { position: place(position), orientation } };
            Track::try_new([0.0, 0.1].into_iter().zip(path).map(key).collect()).unwrap()
        };
        let free = RenderSettings::default();
        let direct = ring(&bell(false), track(false), &free);
        let image = ring(&bell(true), track(true), &free);
        let wanted: Vec<f64> = direct.iter().zip(&image).map(|(a, b)| a + b).collect();
        let seen = ring(&bell(false), track(false), &among(&[plane], 1));
        // Residuals seen: up to 8.2e-8.
        let apart = difference(&seen, &wanted);
        assert!(apart < 1e-6 && difference(&direct, &wanted) > 0.05, "{apart:e}");
    }
}

#[test]
fn a_tilted_wedge_has_the_images_of_a_kaleidoscope() {
    // A wedge of 60°, tilted as a whole: five images around its edge.
    let tilt = DQuat::from_scaled_axis(DVec3::new(0.4, -0.3, 0.7));
    let edge = DVec3::new(-0.2, -0.3, 0.1);
    let angle = PI / 3.0;
    let plane = |normal: DVec3| ReflectingPlane::through(edge, tilt * normal, WallAbsorption::even(0.0));
    let wedge = [plane(DVec3::Y), plane(DVec3::new(angle.sin(), -angle.cos(), 0.0))];
    let at = |turn: f64, radius: f64, along: f64| {
        edge + tilt * DVec3::new(radius * turn.cos(), radius * turn.sin(), along)
    };
    let velocity = |turn: f64, mirrored: bool| {
        // A velocity that turns and is mirrored with the image; (0.5, 0.8, 0.3) in the frame of the source.
        let side = if mirrored { -0.8 } else { 0.8 };
        tilt * (DQuat::from_rotation_z(turn) * DVec3::new(0.5, side, 0.3))
    };
    for (part, ear) in [(0.3, 0.7), (0.45, 0.4), (0.9, 0.2)] {
        let source = part * angle;
        let listener = Listener::fixed("ear", at(ear * angle, 0.9, 0.3));
        let even = [0.0, TAU / 3.0, 2.0 * TAU / 3.0].map(|turn| (turn + source, false));
        let odd = [0.0, TAU / 3.0, 2.0 * TAU / 3.0].map(|turn| (turn - source, true));
        let clicks: Vec<AccelerationPulse> = even
            .into_iter()
            .chain(odd)
            .map(|(turn, mirrored)| click(at(turn, 0.5, 0.0), velocity(turn, mirrored)))
            .collect();
        let wanted = heard(&clicks, &listener, &RenderSettings::default());
        let apart = difference(&heard(&clicks[..1], &listener, &among(&wedge, 3)), &wanted);
        // Residuals seen: up to 8.1e-11.
        assert!(apart < 1e-6, "{part} {ear}: {apart:e}");
        let second = difference(&heard(&clicks[..1], &listener, &among(&wedge, 2)), &wanted);
        assert!(second > 0.01, "the third order is heard: {second:e}");
    }
}

#[test]
fn a_corner_of_planes_is_the_corner_of_a_room() {
    let felt = WallAbsorption([0.05, 0.19, 0.36, 0.51, 0.64, 0.75, 0.8]);
    let walls = [(DVec3::X, -0.8, felt), (DVec3::Y, -0.3, WallAbsorption::even(0.2)), (DVec3::Z, -0.7, felt)];
    let planes = walls.map(|(normal, offset, absorption)| ReflectingPlane { normal, offset, absorption });
    let nothing = WallAbsorption::even(1.0);
    let room = Room {
        lowest: DVec3::new(-0.8, -0.3, -0.7),
        highest: DVec3::splat(3.0),
        walls: [walls[0].2, nothing, walls[1].2, nothing, walls[2].2, nothing],
        image_order: 3,
        late: false,
    };
    let air = Some(Air::default());
    let planes = among(&planes, 3);
    let planes = planes.with_acoustics(Acoustics { air, ..planes.acoustics });
    let acoustics = Acoustics { air, room: Some(room), ..Acoustics::default() };
    let room = RenderSettings::default().with_acoustics(acoustics);
    let click = click(DVec3::new(0.1, 0.2, -0.1), DVec3::new(0.3, -1.0, 0.2));
    let [by_planes, by_room] =
        [&planes, &room].map(|settings| heard(std::slice::from_ref(&click), &microphone(), settings));
    // Residuals seen: 0, and 1e-16 for modes.
    let apart = difference(&by_planes, &by_room);
    assert!(apart < 1e-9, "{apart:e}");
    let [by_planes, by_room] =
        [&planes, &room].map(|settings| ring(&bell(false), Track::fixed(Pose::IDENTITY), settings));
    let apart = difference(&by_planes, &by_room);
    assert!(apart < 1e-9, "{apart:e}");
}

#[test]
fn no_image_is_heard_behind_a_plane() {
    let free = RenderSettings::default();
    let above = DVec3::new(0.1, 0.2, -0.1);
    let velocity = DVec3::new(0.3, -1.0, 0.2);
    for plane in tilted() {
        let below = above - 2.5 * plane.height(above) * plane.normal;
        let settings = among(&[plane], 2);
        // The source behind the plane.
        let hidden = [click(below, velocity)];
        assert_eq!(heard(&hidden, &microphone(), &settings), heard(&hidden, &microphone(), &free));
        let track = || Track::fixed(Pose::at(below));
        assert_eq!(ring(&bell(false), track(), &settings), ring(&bell(false), track(), &free));
        // The listener behind it.
        let listener = Listener::fixed("ear", below);
        let clicks = [click(above, velocity)];
        assert_eq!(heard(&clicks, &listener, &settings), heard(&clicks, &listener, &free));
    }
}

#[test]
fn a_reflecting_plane_below_is_the_rigid_floor() {
    let click = [click(DVec3::new(0.1, 0.2, -0.1), DVec3::new(0.3, -1.0, 0.2))];
    let ground = hard(DVec3::Y, -0.1);
    let floor = RenderSettings::default().with_floor(Floor::Rigid { height: -0.1 });
    let by_floor = heard(&click, &microphone(), &floor);
    assert_eq!(heard(&click, &microphone(), &among(&[ground], 1)), by_floor);
    // Where both are, there is one path.
    let both = among(&[ground], 2).with_floor(Floor::Rigid { height: -0.1 });
    assert_eq!(heard(&click, &microphone(), &both), by_floor);
}

#[test]
fn the_sound_of_the_ground_is_reflected_in_walls_but_not_in_itself() {
    let solid = GroundSource::try_new(&presets::GRANITE.material(), &Medium::AIR).unwrap();
    let source = SoundSource::Ground { ground: Ground::HalfSpace(Arc::new(solid)), impulse: 0.02 };
    let pressed = [AccelerationPulse { source, ..click(DVec3::new(0.1, 0.0, -0.1), DVec3::ZERO) }];
    let (ground, wall) = (hard(DVec3::Y, 0.0), hard(DVec3::X, -0.5));
    let free = heard(&pressed, &microphone(), &RenderSettings::default());
    assert_eq!(heard(&pressed, &microphone(), &among(&[ground], 1)), free);
    let reflected = heard(&pressed, &microphone(), &among(&[wall], 1));
    assert_eq!(heard(&pressed, &microphone(), &among(&[ground, wall], 2)), reflected);
    // Seen: 0.44.
    let apart = difference(&free, &reflected);
    assert!(apart > 0.05, "{apart}");
}

#[test]
fn planes_that_cannot_reflect_are_refused() {
    let many: Vec<_> = (0..8).map(|k| hard(DVec3::new(f64::from(k), 1.0, 0.0), -1.0)).collect();
    assert!(ReflectingPlanes::try_new(&many[..7], 2).is_ok());
    let too_many = |count, limit, order| Err(PlanesError::TooMany { count, limit, order });
    assert_eq!(ReflectingPlanes::try_new(&many, 1), too_many(8, 7, 1));
    assert_eq!(ReflectingPlanes::try_new(&many[..4], 3), too_many(4, 3, 3));
    assert_eq!(ReflectingPlanes::try_new(&many[..3], 4), too_many(3, 2, 4));
    for order in [0, 5] {
        assert_eq!(ReflectingPlanes::try_new(&many[..1], order), Err(PlanesError::Order { order }));
    }
    let twice = ReflectingPlanes::try_new(&[many[0], many[1], many[0]], 1);
    assert_eq!(twice, Err(PlanesError::Same { first: 0, second: 2 }));
    let bad = |plane| ReflectingPlanes::try_new(&[many[0], plane], 1);
    let long = ReflectingPlane { normal: DVec3::new(0.0, 1.1, 0.0), ..many[1] };
    assert!(matches!(bad(long), Err(PlanesError::Place { plane: 1, .. })));
    assert!(matches!(
        bad(ReflectingPlane { offset: f64::NAN, ..many[1] }),
        Err(PlanesError::Place { plane: 1, .. })
    ));
    let loud = ReflectingPlane { absorption: WallAbsorption::even(-0.1), ..many[1] };
    assert_eq!(bad(loud), Err(PlanesError::Absorption { plane: 1, value: -0.1 }));
    // In a room, only its walls reflect.
    let walls = [WallAbsorption::even(0.1); 6];
    let room = Room { lowest: -DVec3::ONE, highest: DVec3::ONE, walls, image_order: 1, late: false };
    let settings = among(&many[..1], 1);
    let settings = settings.with_acoustics(Acoustics { room: Some(room), ..settings.acoustics });
    let refused = Err(SynthesisError::Planes(PlanesError::AndRoom));
    assert_eq!(Renderer::new(&microphone(), &settings).map(|_| ()), refused);
    let (history, listener) = (still(), microphone());
    let voice = ModalVoice::new(bell(false), BodyId(0), &history, &listener, &settings);
    assert_eq!(voice.map(|_| ()), refused);
}
