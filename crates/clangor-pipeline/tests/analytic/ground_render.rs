//! A ball that falls onto soil, from the text of a scene to the file: what the ground sends straight up is
//! its impedance, p = −ρ F′(t − h/c) / (2πh ρ_s c_P).

use std::collections::BTreeSet;
use std::f64::consts::TAU;
use std::ops::ControlFlow;
use std::path::Path;

use crate::falling_balls::{options, render_spheres, samples};
use clangor_core::contact::{ContactSettings, ForceSettings, PoseHistory, impact_pulses};
use clangor_core::glam::DVec3;
use clangor_core::medium::Medium;
use clangor_core::scene::render_description::{GroundSound, Parts};
use clangor_core::synthesis::ground::HalfSpace;
use clangor_core::synthesis::{Listener, SoundPart};
use clangor_core::timeline::Timeline;
use clangor_pipeline::stages::load::{LoadedScene, scene_from_text};
use clangor_pipeline::stages::render::{RenderOptions, RenderSummary};
use clangor_pipeline::stages::simulate::simulate_impacts;

const HEIGHT: f64 = 100.0;
const SCENE: &str = r#"
version = 1
[simulation]
duration = 0.4
[render]
pulse = "gaussian"
[[body]]
name = "ball"
shape = "sphere:0.02"
material = "steel"
position = [0.0, 0.52, 0.0]
[[plane]]
name = "meadow"
material = "soil"
[[plane]]
name = "wall"
material = "soil"
point = [-1.0, 0.0, 0.0]
normal = [1.0, 0.0, 0.0]
"#;

fn scene() -> (LoadedScene, Timeline) {
    let loaded = scene_from_text(Path::new("drop.toml"), SCENE.into(), &|_| ()).unwrap();
    let go_on = &mut |_| ControlFlow::Continue(());
    let (timeline, _) = simulate_impacts(&loaded, &BTreeSet::new(), go_on).unwrap();
    (loaded, timeline)
}

fn hear(
    loaded: &LoadedScene,
    timeline: &Timeline,
    ground: GroundSound,
    parts: Parts,
    file: &Path,
) -> RenderSummary {
    let forces = ForceSettings { profile: loaded.scene.render.pulse, ..ForceSettings::default() };
    let options = RenderOptions {
        contact: ContactSettings { forces, ..ContactSettings::default() },
        parts,
        ground,
        ..options(Listener::fixed("kite", DVec3::Y * HEIGHT), 0.9)
    };
    render_spheres(loaded, timeline, &options, file)
}

#[test]
fn soil_sends_the_force_of_a_ball_straight_up() {
    let (loaded, timeline) = scene();
    let settings = &loaded.scene.render;
    let folder = tempfile::tempdir().unwrap();
    let summary = hear(&loaded, &timeline, settings.ground, settings.parts, &folder.path().join("a.wav"));
    let stem = summary.files.iter().find(|f| f.stem.is_some_and(|s| s.part == SoundPart::Ground)).unwrap();
    assert!(stem.path.ends_with("a.meadow.ground.wav"), "{:?}", stem.path);
    let heard = samples(&stem.path);

    let bodies = &loaded.world.bodies;
    let poses = PoseHistory::try_new(bodies, &timeline.poses).unwrap();
    let contact = ContactSettings {
        forces: ForceSettings { profile: settings.pulse, ..ForceSettings::default() },
        ..ContactSettings::default()
    };
    let (pulses, _) = impact_pulses(bodies, &timeline.contacts, &poses, &contact).unwrap();
    assert_eq!(pulses.len(), 1);
    let (pulse, Medium { density, sound_speed }) = (&pulses[0], Medium::AIR);
    // Free fall, and what the coefficient of restitution makes of it.
    let impulse: f64 = pulse.points.iter().map(|(_, j)| j.length()).sum();
    let soil = &bodies[1].material;
    let solid = HalfSpace::try_new(soil, sound_speed).unwrap();
    let scale = density / (TAU * HEIGHT * soil.density * solid.pressure_speed());
    let exact = |t: f64| {
        let since = t - HEIGHT / sound_speed - pulse.onset;
        let x = since / pulse.duration - 0.5;
        // F′ = −12 x/τ F.
        12.0 * x / pulse.duration * impulse * pulse.shape.value(since, pulse.duration) * scale
    };
    let (mut worst, mut largest, mut sums) = (0.0f64, 0.0f64, [0.0, 0.0]);
    for (i, p) in heard.iter().enumerate() {
        let exact = exact(i as f64 / 48_000.0);
        worst = worst.max((p - exact).abs());
        largest = largest.max(exact.abs());
        sums[0] += p * p;
        sums[1] += exact * exact;
    }
    let level = 10.0 * (sums[0] / sums[1]).log10();
    println!(
        "τ = {:.2} ms, {largest:.2e} Pa: {:.1e} of the peak, {level:.3} dB",
        1e3 * pulse.duration,
        worst / largest
    );
    // Residual seen: 0.001 dB and 1.0e-4.
    assert!(level.abs() < 0.02 && worst < 2e-3 * largest, "{level} dB, {:e}", worst / largest);
    // The file holds what the summary says of it.
    let reported = summary.ground_energies.values().sum::<f64>() * 48_000.0 / sums[0];
    assert!((reported - 1.0).abs() < 1e-4 && summary.ground_energies.len() == 1, "{reported}");
}

#[test]
fn ground_is_a_part_that_can_be_left_out() {
    let (loaded, timeline) = scene();
    let folder = tempfile::tempdir().unwrap();
    let all = Parts::default();
    let only = Parts { acceleration: false, modal: false, ground: true };
    let parts = [
        ("all", GroundSound::HalfSpace, all),
        ("none", GroundSound::None, all),
        ("without", GroundSound::HalfSpace, Parts { ground: false, ..all }),
        ("only", GroundSound::HalfSpace, only),
    ];
    let [all, none, without, only] = parts.map(|(name, ground, parts)| {
        let file = folder.path().join(format!("{name}.wav"));
        hear(&loaded, &timeline, ground, parts, &file);
        samples(&file)
    });
    let power = |samples: &[f64]| samples.iter().map(|p| p * p).sum::<f64>();
    assert!(power(&only) > 0.0 && power(&none) > 0.0);
    assert_eq!(none, without);
    let apart: Vec<f64> = all.iter().zip(&none).zip(&only).map(|((a, n), o)| a - n - o).collect();
    let file = folder.path().join("slab.wav");
    let slab = hear(&loaded, &timeline, GroundSound::Slab, Parts::default(), &file);
    assert!(slab.ground_energies.values().all(|energy| *energy > 0.0) && slab.ground_energies.len() == 1);
    // Rounding of the files to 24 bits.
    assert!(power(&apart) < 1e-12 * power(&all), "{:e}", power(&apart) / power(&all));
}
