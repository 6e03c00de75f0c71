//! Vibration inherited by the pieces of a broken body: a body that breaks into itself continues to ring, and
//! energy does not grow.

use std::f64::consts::PI;
use std::sync::Arc;

use crate::ringing::{body, impact};
use clangor_core::body::{Body, BodyId, Life, Motion};
use clangor_core::contact::{ImpactPulse, PoseHistory};
use clangor_core::glam::{DMat3, DQuat, DVec3};
use clangor_core::material::Damping;
use clangor_core::medium::Medium;
use clangor_core::pose::Pose;
use clangor_core::sound_model::modal::model::{ModalMode, ModalModel, ModalTransfer};
use clangor_core::sound_model::modal::surface::ModalSurface;
use clangor_core::sound_model::soundbank::modal_soundbank::{
    BankMaterial, ContactMapping, EllipsoidMode, ModalSoundbank, ProxyBody, RingingEllipsoid,
    parity_harmonics,
};
use clangor_core::synthesis::modal::modal_state_transfer::{
    Handed, SurfaceSample, bound_energy, handed_over, sample_count,
};
use clangor_core::synthesis::modal::{ModalSettings, ModalSource, ModalState, ModalVoice};
use clangor_core::synthesis::{Listener, RenderSettings};
use num_complex::Complex64;

/// Of the plate [m] and its material.
const SIZE: DVec3 = DVec3::new(0.2, 0.006, 0.12);
const DENSITY: f64 = 2700.0;
const BREAKS: f64 = 0.0313;

/// A plate from x = `from` to `to`, in axes that are turned, with modes of so many half-waves.
fn plate([from, to]: [f64; 2], turn: DQuat, lowest: f64) -> Arc<ModalSource> {
    let length = to - from;
    let centre = DVec3::X * 0.5 * (from + to);
    let (nx, nz) = (8, 6);
    let (mut nodes, mut triangles) = (Vec::new(), Vec::new());
    for side in [-0.5, 0.5] {
        let place = |i: f64, k: f64| {
            let x = DVec3::new(
                from + length * i / f64::from(nx),
                side * SIZE.y,
                SIZE.z * (k / f64::from(nz) - 0.5),
            );
            x - centre
        };
        for i in 0..nx {
            for k in 0..nz {
                let (i, k) = (f64::from(i), f64::from(k));
                let corners = [(i, k), (i + 1.0, k), (i + 1.0, k + 1.0), (i, k + 1.0)];
                for triangle in [[0, 1, 2], [0, 2, 3]] {
                    let corner = triangle.map(|c| corners[c]);
                    let first = nodes.len() as u32;
                    nodes.extend(corner.map(|(i, k)| place(i, k)));
                    nodes.extend([(0, 1), (1, 2), (2, 0)].map(|(a, b): (usize, usize)| {
                        place(0.5 * (corner[a].0 + corner[b].0), 0.5 * (corner[a].1 + corner[b].1))
                    }));
                    triangles.push(std::array::from_fn(|n| first + n as u32));
                }
            }
        }
    }
    let mass = DENSITY * SIZE.y * SIZE.z * length;
    let counts = [(2, 0), (0, 2), (1, 1), (2, 1), (1, 2), (3, 0), (3, 1), (2, 2), (0, 3), (4, 0)];
    let modes = counts.map(|(m, n): (u32, u32)| {
        let [m, n] = [m, n].map(f64::from);
        let norm = [m, n].iter().map(|count| if *count > 0.0 { 2.0 } else { 1.0 }).product::<f64>();
        let shape = |x: &DVec3| {
            let along = (m * PI * (x.x / length + 0.5)).cos();
            let across = (n * PI * (x.z / SIZE.z + 0.5)).cos();
            turn * DVec3::Y * (norm / mass).sqrt() * along * across
        };
        let wave = (m / length).powi(2) + (n / SIZE.z).powi(2);
        ModalMode {
            frequency: lowest * wave * SIZE.x * SIZE.x,
            mesh_error: 0.0,
            support_damping: 0.0,
            shape: nodes.iter().map(shape).collect(),
            transfer: Some(ModalTransfer { order: 0, coefficients: vec![Complex64::new(1.0 + m, n - 0.5)] }),
        }
    });
    let model = ModalModel {
        radius: 0.5 * SIZE.length(),
        medium: Medium::AIR,
        density: DENSITY,
        max_frequency: 20_000.0,
        statistical_above: None,
        surface: ModalSurface { nodes: nodes.iter().map(|x| turn * *x).collect(), triangles },
        modes: modes.to_vec(),
    };
    let source = ModalSource::new(Arc::new(model), &Damping::LossFactor(2e-3), &ModalSettings::default());
    Arc::new(source.unwrap())
}

/// Places on both faces of such a plate.
fn samples([from, to]: [f64; 2], turn: DQuat, count: usize) -> Vec<SurfaceSample> {
    let sample = |k: usize| {
        let part = |step: f64| (k as f64 * step).fract() - 0.5;
        let side = if k.is_multiple_of(2) { 1.0 } else { -1.0 };
        let place = DVec3::new((to - from) * part(0.7548777), side * 0.5 * SIZE.y, SIZE.z * part(0.5698403));
        SurfaceSample { place: turn * place, normal: turn * DVec3::Y * side }
    };
    (0..count).map(sample).collect()
}

/// A body that breaks into pieces with these poses, and one that does not.
fn bodies(pieces: &[Pose]) -> Vec<Body> {
    let mut bodies = vec![body(Motion::Fixed), body(Motion::Fixed)];
    bodies[0].life.death = BREAKS;
    let piece =
        |pose: &Pose| Body { pose: *pose, life: Life::of_piece(BodyId(0), BREAKS), ..body(Motion::Fixed) };
    bodies.extend(pieces.iter().map(piece));
    bodies
}

fn struck(id: u32) -> ImpactPulse {
    let mut pulse = impact(0.004, 1.5e-4, Pose::IDENTITY);
    pulse.points = vec![(DVec3::new(0.083, 0.003, 0.031), DVec3::new(0.0, 0.01, 0.0))];
    if let Some(share) = &mut pulse.bodies[0] {
        share.body = BodyId(id);
    }
    pulse
}

/// Samples of a body.
fn heard(source: &Arc<ModalSource>, id: u32, poses: &PoseHistory, state: Option<&ModalState>) -> Vec<f64> {
    let listener = Listener::fixed("ear", DVec3::new(0.3, 0.4, 0.2));
    let settings = RenderSettings::default();
    let mut voice = ModalVoice::new(Arc::clone(source), BodyId(id), poses, &listener, &settings).unwrap();
    voice.push_pulses(&[struck(0), struck(1)]).unwrap();
    if let Some(state) = state {
        voice.inherit_state(state).unwrap();
    }
    let mut channels = vec![vec![0.0; 4800]];
    voice.render_block(0, &mut channels).unwrap();
    channels.swap_remove(0)
}

fn state_at_death(source: &ModalSource) -> ModalState {
    ModalState::after_impacts(source, BodyId(0), &[struck(0), struck(1)], BREAKS)
}

/// Error where a body becomes itself, in rotated axes and a little off the grid of samples, over the peak of
/// the sound then.
fn residual(
    whole: &Arc<ModalSource>,
    piece: &Arc<ModalSource>,
    turn: DQuat,
    samples: &[SurfaceSample],
) -> f64 {
    let pose = Pose { position: DVec3::ZERO, orientation: turn.inverse() };
    let poses = PoseHistory::try_new(&bodies(&[pose]), &[]).unwrap();
    let state = state_at_death(whole);
    let mut handed = handed_over((whole, &state), piece, samples, [&Pose::IDENTITY, &pose], 1.0);
    let energy = state.energy(whole);
    let given = bound_energy(&mut [(piece, &mut handed)], energy);
    assert!(given <= energy * (1.0 + 1e-12) && given > 0.999 * energy, "{given} of {energy}");
    let expected = heard(whole, 1, &poses, None);
    let parts = [heard(whole, 0, &poses, None), heard(piece, 2, &poses, Some(&handed.state))];
    // The parent ends with its fade, and the piece is silent before.
    let fade = ((BREAKS + 0.54 / 343.2 - 5e-4) * 48_000.0) as usize;
    let peak = |samples: &[f64]| samples.iter().fold(0.0, |m: f64, p| m.max(p.abs()));
    assert!(peak(&parts[0][fade + 130..]) < 1e-9 * peak(&expected), "the parent goes on");
    assert!(peak(&parts[1][..fade - 60]) < 1e-9 * peak(&expected), "the piece comes too early");
    let near = peak(&expected[fade - 200..fade + 200]);
    let wrong = (0..expected.len()).map(|i| (parts[0][i] + parts[1][i] - expected[i]).abs());
    wrong.fold(0.0, f64::max) / near
}

#[test]
fn what_breaks_into_itself_rings_on() {
    let ends = [-0.5 * SIZE.x, 0.5 * SIZE.x];
    let whole = plate(ends, DQuat::IDENTITY, 150.0);
    for turn in [DQuat::IDENTITY, DQuat::from_euler(clangor_core::glam::EulerRot::XYZ, 0.7, -1.9, 0.4)] {
        let piece = plate(ends, turn, 150.0);
        let samples = samples(ends, turn, sample_count(piece.resonances().len()));
        let error = residual(&whole, &piece, turn, &samples);
        println!("a plate becomes itself: {error:.1e}");
        // Residual seen: 9e-9.
        assert!(error < 1e-6, "{error:e}");
    }
}

#[test]
fn an_ellipsoid_that_breaks_into_itself_rings_on() {
    let material =
        BankMaterial { youngs_modulus: 6.2e10, density: 2600.0, poisson_ratio: 0.2, medium: Medium::AIR };
    let degree = 4;
    let mode = |k: usize| {
        let parity = k as u8 % 8;
        let number = |i: usize, seed: f64| (1.7 * i as f64 + seed + k as f64).sin();
        let length = |p: u8| parity_harmonics(p, degree).len();
        let shape =
            [0, 1, 2].map(|axis| (0..length(parity ^ (1 << axis))).map(|i| number(i, axis as f64)).collect());
        let transfer =
            (0..parity_harmonics(parity, 3).len()).map(|i| 1e-3 * Complex64::new(number(i, 0.4), 0.3));
        let frequency = 500.0 * (k + 2) as f64;
        EllipsoidMode { frequency, parity, shape, order: 3, transfer: transfer.collect() }
    };
    let semi_axes = DVec3::new(0.1, 0.6, 0.9).normalize();
    let entry = RingingEllipsoid { semi_axes, max_frequency: 6000.0, modes: (0..9).map(mode).collect() };
    let bank = ModalSoundbank::try_new(material, degree, vec![entry]).unwrap();
    let square = semi_axes * semi_axes;
    let inertia = DMat3::from_diagonal((DVec3::splat(square.element_sum()) - square) * 1e-4);
    let proxy = bank
        .proxy_for(&ProxyBody { inertia, mass: 0.1, first_frequency: 2000.0, material, max_frequency: 2e4 })
        .unwrap();
    let transfers: Vec<_> = (0..proxy.mode_count()).map(|mode| proxy.transfer(mode)).collect();
    let source = ModalSource::of_proxy(
        proxy,
        ContactMapping::default(),
        &transfers,
        &Damping::LossFactor(2e-3),
        &ModalSettings::default(),
    );
    let source = Arc::new(source.unwrap());
    // Places of a box, which are not on the ellipsoid.
    let samples = samples([-0.1, 0.1], DQuat::IDENTITY, sample_count(source.resonances().len()));
    let error = residual(&source, &source, DQuat::IDENTITY, &samples);
    println!("an ellipsoid becomes itself: {error:.1e}");
    // Residual seen: 9e-9.
    assert!(error < 1e-6, "{error:e}");
}

#[test]
fn halves_have_no_more_than_the_whole_had() {
    let whole = plate([-0.1, 0.1], DQuat::IDENTITY, 150.0);
    let state = state_at_death(&whole);
    let energy = state.energy(&whole);
    for cut in [-0.06, 0.0, 0.03] {
        let ends = [[-0.1, cut], [cut, 0.1]];
        let pieces = ends.map(|ends| plate(ends, DQuat::IDENTITY, 150.0));
        let mut handed: Vec<Handed> = Vec::new();
        for (ends, piece) in ends.iter().zip(&pieces) {
            let pose = Pose::at(DVec3::X * 0.5 * (ends[0] + ends[1]));
            let samples = samples(*ends, DQuat::IDENTITY, sample_count(piece.resonances().len()));
            let mass = DENSITY * SIZE.y * SIZE.z * (ends[1] - ends[0]);
            handed.push(handed_over((&whole, &state), piece, &samples, [&Pose::IDENTITY, &pose], mass));
        }
        // Modes that are normal by mass share their energy out over the plate.
        let shares: f64 = handed.iter().map(|h| h.share).sum();
        assert!((shares / energy - 1.0).abs() < 0.05, "{shares} of {energy}");
        let free: f64 = handed.iter().zip(&pieces).map(|(h, piece)| h.state.energy(piece)).sum();
        // The whole bends more slowly than the halves, which take part of that motion as a rigid motion.
        let mut bounded: Vec<(&ModalSource, &mut Handed)> =
            pieces.iter().map(|piece| &**piece).zip(&mut handed).collect();
        let given = bound_energy(&mut bounded, energy);
        println!(
            "cut at {cut} m: {:.3} of the energy, {:.3} by the fit alone",
            given / energy,
            free / energy
        );
        assert!(given <= energy * (1.0 + 1e-12) && given > 0.02 * energy);
        let half = bound_energy(&mut bounded, 0.01 * energy);
        assert!(half <= 0.01 * energy * (1.0 + 1e-12), "{half}");
    }
}

#[test]
fn a_motion_as_a_whole_is_not_vibration() {
    // A small piece at the end of the plate is carried along by the longest wave, which hardly bends it.
    let whole = plate([-0.1, 0.1], DQuat::IDENTITY, 150.0);
    let mut state = ModalState::rest(&whole);
    state.0[0] = Complex64::new(0.3, -0.1);
    let ends = [0.085, 0.1];
    let piece = plate(ends, DQuat::IDENTITY, 150.0);
    let pose = Pose::at(DVec3::X * 0.0925);
    let samples = samples(ends, DQuat::IDENTITY, 200);
    let mass = DENSITY * SIZE.y * SIZE.z * 0.015;
    let handed = handed_over((&whole, &state), &piece, &samples, [&Pose::IDENTITY, &pose], mass);
    let moving: f64 = handed.state.0.iter().map(|w| w.re * w.re).sum::<f64>() / (0.3 * 0.3);
    println!("of the motion {moving:.1e}, and its share {:.2}", handed.share / state.energy(&whole));
    // It carries 0.14 of the energy. Residual seen: 2e-7.
    assert!(moving < 1e-5, "{moving:e}");
}
