//! Balls that fall onto endless plates, from the text of a scene to the motion and the file: Zener's
//! restitution with both solvers, and the far field straight above.

use std::collections::BTreeSet;
use std::f64::consts::TAU;
use std::ops::ControlFlow;
use std::path::Path;

use crate::falling_balls::{options, render_spheres, samples};
use clangor_core::contact::{ContactSettings, PoseHistory, impact_pulses};
use clangor_core::glam::DVec3;
use clangor_core::material::ThinPlate;
use clangor_core::medium::Medium;
use clangor_core::synthesis::{Listener, SoundPart};
use clangor_core::timeline::Timeline;
use clangor_pipeline::stages::load::{LoadedScene, scene_from_text};
use clangor_pipeline::stages::render::RenderSummary;
use clangor_pipeline::stages::simulate::simulate_impacts;

/// A ball 1 mm above a weightless plate, at a speed, without losses of the contact.
fn scene(solver: &str, radius: f64, speed: f64, thickness: f64) -> LoadedScene {
    let text = format!(
        r#"
version = 1
gravity = [0.0, 0.0, 0.0]
[simulation]
solver = "{solver}"
duration = 0.01
[material.clear]
base = "glass"
restitution = 1.0
[material.hard]
base = "steel"
restitution = 1.0
[[body]]
name = "ball"
shape = "sphere:{radius}"
material = "hard"
position = [0.0, {height}, 0.0]
velocity = [0.0, -{speed}, 0.0]
[[plane]]
name = "pane"
material = "clear"
thickness = {thickness}
[[listener]]
name = "microphone"
position = [0.0, 0.0, 1.0]
"#,
        height = radius + 1e-3
    );
    scene_from_text(Path::new("plate.toml"), text, &|_| ()).unwrap()
}

fn run(loaded: &LoadedScene) -> Timeline {
    simulate_impacts(loaded, &BTreeSet::new(), &mut |_| ControlFlow::Continue(())).unwrap().0
}

/// \[Zener1941\]: ∫s^{3/2} − 1 of s̈ + (1 + λ d/dt) s^{3/2} = 0, by Heun's method in small steps.
fn zener(lambda: f64) -> f64 {
    let h = 1e-5;
    let rate = |s: f64, z: f64| [1.0 - z - lambda * s.max(0.0).powf(1.5), s.max(0.0).powf(1.5)];
    let (mut s, mut z) = (0.0_f64, 0.0_f64);
    loop {
        let [ds, dz] = rate(s, z);
        let [es, ez] = rate(s + h * ds, z + h * dz);
        s += 0.5 * h * (ds + es);
        z += 0.5 * h * (dz + ez);
        if s <= 1e-9 || z > 2.0 {
            return z - 1.0;
        }
    }
}

#[test]
fn balls_bounce_off_plates_as_zener_says() {
    for solver in ["spheres", "rigid"] {
        for (radius, speed, thickness) in
            [(0.005, 1.0, 0.010), (0.005, 1.0, 0.005), (0.0075, 2.0, 0.004), (0.005, 0.5, 0.003)]
        {
            let loaded = scene(solver, radius, speed, thickness);
            let [ball, plate] = &loaded.world.bodies[..] else { panic!("two bodies") };
            let constants = ThinPlate::new(&plate.material, thickness);
            // λ = m/(8 √(D m″) T₀), T₀ = (m/(k √V))^{2/5}, k = 4/3 E* √R.
            let stiffness = 4.0 / 3.0 * radius.sqrt()
                / (ball.material.contact_compliance() + plate.material.contact_compliance());
            let time = (ball.mass / (stiffness * speed.sqrt())).powf(0.4);
            let plane_strain = 1.0 / plate.material.contact_compliance();
            let impedance =
                8.0 * (plane_strain * thickness.powi(3) / 12.0 * plate.material.density * thickness).sqrt();
            assert!((impedance / constants.point_impedance() - 1.0).abs() < 1e-12);
            let exact = zener(ball.mass / (impedance * time));
            let impulse: f64 = run(&loaded).contacts.iter().map(|row| row.impulse_n).sum();
            let found = impulse / (ball.mass * speed) - 1.0;
            println!("{solver} λ {:.3}: {found:.4} of {exact:.4}", ball.mass / (impedance * time));
            // Residual seen: below 1e-4.
            assert!((found - exact).abs() < 0.005, "{solver} {thickness}: {found} of {exact}");
        }
    }
}

fn hear(loaded: &LoadedScene, timeline: &Timeline, ear: DVec3, file: &Path) -> RenderSummary {
    render_spheres(loaded, timeline, &options(Listener::fixed("ear", ear), 0.4), file)
}

#[test]
fn a_plate_sends_the_force_of_a_ball_straight_up_and_down() {
    let text = r#"
version = 1
[simulation]
duration = 0.25
[[body]]
name = "ball"
shape = "sphere:0.02"
material = "rubber"
position = [0.0, 0.12, 0.0]
[[plane]]
name = "sheet"
material = "steel"
thickness = 0.003
[[listener]]
name = "ear"
position = [0, 50, 0]
"#;
    let loaded = scene_from_text(Path::new("sheet.toml"), text.into(), &|_| ()).unwrap();
    let timeline = run(&loaded);
    let bodies = &loaded.world.bodies;
    let poses = PoseHistory::try_new(bodies, &timeline.poses).unwrap();
    let (pulses, _) = impact_pulses(bodies, &timeline.contacts, &poses, &ContactSettings::default()).unwrap();
    assert_eq!(pulses.len(), 1);
    let pulse = &pulses[0];
    let impulse: f64 = pulse.points.iter().map(|(_, j)| j.length()).sum();
    let (height, Medium { density, sound_speed }) = (50.0, Medium::AIR);
    let mass = ThinPlate::new(&bodies[1].material, 0.003).mass_per_area;
    // p = −ρ/(2π m″ R) (F − ∫F(t') e^{−(t−t')/T} dt'/T), T = m″/2ρc: the plate as a mass with fluid on both
    // sides, straight above.
    let slowing = mass / (2.0 * density * sound_speed);
    let scale = -density / (TAU * mass * height);
    let rate = 48_000.0;
    let mut memory = 0.0;
    let exact: Vec<f64> = (0..(0.4 * rate) as usize)
        .map(|n| {
            let mut mean = 0.0;
            for part in 0..16 {
                let since =
                    (n as f64 + (f64::from(part) - 7.5) / 16.0) / rate - height / sound_speed - pulse.onset;
                let force = impulse * pulse.shape.value(since, pulse.duration);
                memory += (force - memory) / (slowing * rate * 16.0);
                mean += force / 16.0;
            }
            scale * (mean - memory)
        })
        .collect();
    let folder = tempfile::tempdir().unwrap();
    for (name, y, sign) in [("up", height, 1.0), ("down", -height - 0.003, -1.0)] {
        let summary = hear(&loaded, &timeline, DVec3::Y * y, &folder.path().join(format!("{name}.wav")));
        let stem =
            summary.files.iter().find(|f| f.stem.is_some_and(|s| s.part == SoundPart::Ground)).unwrap();
        let heard = samples(&stem.path);
        let (mut sums, mut worst, mut peak) = ([0.0, 0.0], 0.0_f64, 0.0_f64);
        for (p, q) in heard.iter().zip(&exact) {
            sums[0] += p * p;
            sums[1] += q * q;
            worst = worst.max((p - sign * q).abs());
            peak = peak.max(q.abs());
        }
        let level = 10.0 * (sums[0] / sums[1]).log10();
        println!("{name}: {level:.3} dB, {:.1e} of the peak {peak:.2e} Pa", worst / peak);
        // Residual seen: 0.028 dB and 4.0e-3.
        assert!(level.abs() < 0.2 && worst < 0.03 * peak, "{level} {worst}");
    }
}
