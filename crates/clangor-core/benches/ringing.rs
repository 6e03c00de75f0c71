//! Processor time of modal sound, on one core:
//! `cargo bench --profile release -p clangor-core --bench ringing`.
//! Other programs do not count where the system reports thread time (Linux).
//!
//! * `bank`: modes ringing at 48 kHz with one, two and four receivers, with fixed and with varying transfers;
//!   the number of modes in real time, and the growth of the cost with their number.
//! * `impacts`: the same with a hundred impacts a second.
//! * `voice`: these 76 modes in a body that is struck four times a second while it moves, for two receivers
//!   over a floor: the total cost of a plate.
//! * `transfer`: the transfers of 76 modes of about 70 000 coefficients for a new place, as timed by \[FRAC\]
//!   (156 ms on eight cores, 0.3 ms on its graphics processor), and with \[FRAC\]'s own rule for the order.
//!
//! Words after `--` select among them.

mod thread_time;

use std::hint::black_box;
use std::sync::Arc;

use clangor_core::body::{Body, BodyId, Motion, Surface};
use clangor_core::contact::{BodyPulse, ForceProfile, HertzRange, ImpactPulse, PoseHistory};
use clangor_core::glam::{DMat3, DQuat, DVec3};
use clangor_core::material::presets;
use clangor_core::medium::Medium;
use clangor_core::pose::{Keyframe, Pose, Track};
use clangor_core::sound_model::modal::model::{ModalMode, ModalModel, ModalTransfer};
use clangor_core::sound_model::modal::surface::ModalSurface;
use clangor_core::synthesis::listener::Floor;
use clangor_core::synthesis::modal::{
    ModalPressure, ModalSettings, ModalSource, ModalVoice, Resonance, ResonatorBank, TransferEvaluator,
    TransferMemory, TransferOrder,
};
use clangor_core::synthesis::{Listener, RenderSettings, SampleRate};
use num_complex::Complex64;
use thread_time::thread_time;

/// So small that no mode comes to rest, however many seconds a measurement plays: modes at rest cost nothing.
const UNDAMPED: f64 = 1e-9;

/// The least time [s] of several measurements, each of which repeats until the steps of the clock do not
/// matter.
fn best(mut work: impl FnMut()) -> f64 {
    let mut measure = || {
        let begin = thread_time();
        let mut repeats = 0;
        while thread_time() - begin < 0.1 {
            work();
            repeats += 1;
        }
        (thread_time() - begin) / f64::from(repeats)
    };
    (0..5).map(|_| measure()).fold(f64::INFINITY, f64::min)
}

/// Time [s] for a second of this number of modes and receivers.
fn bank(modes: usize, receivers: usize, moving: bool, impacts: bool) -> f64 {
    let resonances: Vec<Resonance> = (0..modes)
        .map(|i| Resonance { frequency: 100.0 + 19_000.0 * i as f64 / modes as f64, damping_ratio: UNDAMPED })
        .collect();
    let rate = SampleRate::HZ_48000;
    let mut bank = ResonatorBank::new(&resonances, receivers, rate, 21_600.0, ModalPressure::Acceleration);
    let transfers = [1.0, 2.0].map(|p| (0..modes).map(|i| Complex64::cis(p * i as f64)).collect::<Vec<_>>());
    let amplitudes = vec![1.0; modes];
    (0..receivers).for_each(|path| bank.set_transfers(path, &transfers[0]));
    bank.jump_to_transfers();
    bank.add_pulse(&ForceProfile::HalfSine.into(), 100.0, 50e-6, &amplitudes);
    let mut outputs: Vec<Vec<f64>> = (0..receivers).map(|_| Vec::with_capacity(48_000)).collect();
    let mut block = 0;
    best(|| {
        outputs.iter_mut().for_each(Vec::clear);
        for _ in 0..250 {
            if moving {
                (0..receivers).for_each(|path| bank.set_transfers(path, &transfers[block % 2]));
            }
            if impacts && block % 5 < 2 {
                bank.add_pulse(
                    &ForceProfile::HalfSine.into(),
                    bank.position() as f64 + 100.5,
                    50e-6,
                    &amplitudes,
                );
            }
            block += 1;
            bank.render(192, &mut outputs);
        }
        black_box(&outputs);
    })
}

/// Transfers of 76 modes with their kR.
fn plate() -> Vec<(ModalTransfer, f64)> {
    // 76 modes up to 20 kHz whose orders sum up to 2176, as those of a plate whose modes are evenly spread.
    let transfers: Vec<(ModalTransfer, f64)> = (0..76)
        .map(|i| {
            let order = (i as f64 * 32.0 / 75.0 + 12.6).round() as usize;
            let value = |k: usize| Complex64::new((k as f64).sin(), (k as f64).cos());
            let coefficients = (0..(order + 1).pow(2)).map(value).collect();
            (ModalTransfer { order, coefficients }, order as f64 - 4.0)
        })
        .collect();
    let total: usize = transfers.iter().map(|(t, _)| t.order).sum();
    assert!((2100..2250).contains(&total), "{total}");
    transfers
}

/// Time [s] for a second of a plate.
fn voice() -> f64 {
    let corners = [DVec3::ZERO, DVec3::X, DVec3::Y].map(|x| 0.1 * x);
    let middles = [(0, 1), (1, 2), (2, 0)].map(|(a, b)| 0.5 * (corners[a] + corners[b]));
    let modes = plate().into_iter().enumerate().map(|(i, (transfer, _))| ModalMode {
        frequency: 20_000.0 * (i + 1) as f64 / 77.0,
        mesh_error: 0.0,
        support_damping: 0.0,
        shape: vec![DVec3::Y; 6],
        transfer: Some(transfer),
    });
    let model = ModalModel {
        radius: 0.13,
        medium: Medium::AIR,
        density: 2700.0,
        max_frequency: 20_000.0,
        statistical_above: None,
        surface: ModalSurface {
            nodes: corners.into_iter().chain(middles).collect(),
            triangles: vec![[0, 1, 2, 3, 4, 5]],
        },
        modes: modes.collect(),
    };
    let key = |time: f64| {
        let position = DVec3::new(0.3 * time, 0.4, 0.0);
        Keyframe { time, pose: Pose { position, orientation: DQuat::from_rotation_y(3.0 * time) } }
    };
    let track = Track::try_new((-1..13).map(|i| key(f64::from(i))).collect()).expect("ascending times");
    let surface = Surface::Sphere { radius: 0.13 };
    let body = Body::new("plate", presets::CERAMIC.material(), surface, 0.5, DMat3::IDENTITY)
        .at(track.sample(0.0).0)
        .with_motion(Motion::Keyframed(track.clone()))
        .with_edge_radius(1e-3);
    let poses = PoseHistory::try_new(std::slice::from_ref(&body), &[]).expect("a history");
    let settings = RenderSettings::default().with_floor(Floor::Rigid { height: 0.0 });
    let listener = Listener::spaced_pair("ears", Track::fixed(Pose::at(DVec3::new(1.0, 1.8, 1.0))), 0.2);
    let source = ModalSource::new(Arc::new(model), &body.material.damping, &ModalSettings::default());
    let source = Arc::new(source.expect("a good model"));
    let pulses: Vec<ImpactPulse> = (0..40)
        .map(|i| {
            let onset = 0.01 + 0.25 * f64::from(i);
            let share = BodyPulse {
                body: BodyId(0),
                pose: track.sample(onset).0,
                impulse: DVec3::Y,
                velocity_change: DVec3::Y,
                angular_impulse: DVec3::ZERO,
                angular_velocity_change: DVec3::ZERO,
                transit_ratio: 1.0,
                modal_gain: 1.0,
            };
            ImpactPulse {
                impact_id: 0,
                time: onset,
                onset,
                duration: 5e-5,
                shape: ForceProfile::HalfSine.into(),
                speed: 1.0,
                effective_mass: 1.0,
                radius: 1.0,
                range: HertzRange::Within,
                point: DVec3::ZERO,
                normal: DVec3::Y,
                velocity_before: None,
                pair: [BodyId(0), BodyId::WORLD],
                bodies: [Some(share), None],
                points: vec![(share.pose.position, DVec3::Y)],
                modal_energy_ratio: 0.0,
            }
        })
        .collect();
    let mut channels = vec![vec![0.0; 4800]; 2];
    let ten_seconds = best(|| {
        let mut voice =
            ModalVoice::new(Arc::clone(&source), BodyId(0), &poses, &listener, &settings).expect("receivers");
        voice.push_pulses(&pulses).expect("finite pulses");
        (0..100).for_each(|i| voice.render_block(4800 * i, &mut channels).expect("above the floor"));
        black_box(&channels);
    });
    0.1 * ten_seconds
}

/// Time [s] for the transfers of a place, and the number of coefficients.
fn transfer(orders: TransferOrder) -> (f64, usize) {
    let transfers = plate();
    let evaluator = TransferEvaluator::new(transfers.iter().map(|(t, k)| (Some(t), *k)), orders);
    let (mut memory, mut values) = (TransferMemory::default(), Vec::new());
    let mut angle = 0.0f64;
    let time = best(|| {
        angle += 0.1;
        let (sin, cos) = angle.sin_cos();
        evaluator.evaluate(DVec3::new(cos, 0.3, sin) * (2.0 + cos), &mut memory, &mut values);
        black_box(&values);
    });
    (time, evaluator.coefficients())
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with('-')).collect();
    let wanted = |name: &str| words.is_empty() || words.iter().any(|word| name == word);
    if wanted("transfer") {
        for (name, orders) in [("baked", TransferOrder::Baked), ("FRAC", TransferOrder::Reference)] {
            let (time, coefficients) = transfer(orders);
            println!("transfer, orders {name}: {coefficients} coefficients, {:.4} ms", 1e3 * time);
        }
    }
    if wanted("bank") {
        for modes in [1_000, 5_000, 20_000] {
            for (receivers, moving) in [(1, false), (1, true), (2, true), (4, true)] {
                let time = bank(modes, receivers, moving, false);
                let (each, real_time) = (1e9 * time / (48_000.0 * modes as f64), modes as f64 / time);
                let how = if moving { "moving" } else { "at rest" };
                println!(
                    "bank, {modes} modes, {receivers} receivers {how}: {time:.4} s/s, {each:.3} ns a mode \
                     and sample, \
                     {real_time:.0} modes in real time"
                );
            }
            let ears = |moving| bank(modes, 2, moving, false) / bank(modes, 1, moving, false);
            println!(
                "bank, {modes} modes: two receivers cost {:.2} times one at rest, {:.2} times one moving",
                ears(false),
                ears(true)
            );
        }
    }
    if wanted("voice") {
        println!("voice, 76 modes, moving, 2 receivers and a floor: {:.4} s/s", voice());
    }
    if wanted("impacts") {
        let time = bank(1_000, 1, true, true);
        println!(
            "impacts, 1000 modes, 100 a second: {time:.4} s/s, {:.0} modes in real time",
            1_000.0 / time
        );
    }
}
