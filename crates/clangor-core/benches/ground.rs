//! Level of the ground beside the click of a falling body, and its cost:
//! `cargo bench --profile release -p clangor-core --bench ground`.

use std::sync::Arc;
use std::time::Instant;

use clangor_core::body::BodyId;
use clangor_core::contact::ForceProfile;
use clangor_core::contact::hertz::HertzContact;
use clangor_core::glam::{DQuat, DVec3};
use clangor_core::material::PairCoefficients;
use clangor_core::material::presets::preset;
use clangor_core::medium::Medium;
use clangor_core::reference::SlabSource;
use clangor_core::synthesis::ground::{Ground, GroundSource};
use clangor_core::synthesis::listener::Floor;
use clangor_core::synthesis::{
    AccelerationPulse, BlockMemory, Listener, OverlapAdd, RenderSettings, Renderer, SoundSource,
};

const BALL: BodyId = BodyId(0);
const GROUND: BodyId = BodyId(1);
/// Of the scene ball-drop: 0.5 m away, 39° above the floor; and near the floor, 1 m away.
const LISTENERS: [(&str, DVec3); 2] =
    [("39° up", DVec3::new(0.3, 0.4, 0.4)), ("6° up", DVec3::new(1.0, 0.1, 0.0))];

/// A falling ball and the ground, at the moment of their impact.
fn impact(body: &str, radius: f64, ground: &str) -> (AccelerationPulse, AccelerationPulse) {
    let (body, floor) = (preset(body).unwrap(), preset(ground).unwrap());
    let mass = body.density * 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
    let speed = (2.0 * 9.81 * 0.5f64).sqrt();
    let duration = HertzContact {
        inverse_mass: 1.0 / mass,
        relative_radii: [radius; 2],
        compliance: body.contact_compliance() + floor.contact_compliance(),
        speed,
    }
    .duration();
    let velocity_change = (1.0 + PairCoefficients::of(&body, &floor).restitution.at(speed)) * speed;
    let ground = Arc::new(GroundSource::try_new(&floor, &Medium::AIR).unwrap());
    let click = AccelerationPulse {
        body: BALL,
        time: 0.0,
        duration,
        shape: ForceProfile::HalfSine.into(),
        centre: DVec3::Y * radius,
        orientation: DQuat::IDENTITY,
        velocity_change: DVec3::Y * velocity_change,
        angular_velocity_change: DVec3::ZERO,
        source: SoundSource::Sphere { radius },
    };
    let pressed = AccelerationPulse {
        body: GROUND,
        centre: DVec3::ZERO,
        velocity_change: DVec3::ZERO,
        source: SoundSource::Ground { ground: ground.into(), impulse: mass * velocity_change },
        ..click.clone()
    };
    (click, pressed)
}

/// Energies ∫ p² dt [Pa² s] of two clicks.
fn energies(clicks: [&AccelerationPulse; 2], place: DVec3) -> [f64; 2] {
    let settings = RenderSettings::default().with_floor(Floor::Rigid { height: 0.0 });
    let mut renderer = Renderer::new(&Listener::fixed("listener", place), &settings).unwrap();
    clicks.into_iter().for_each(|click| renderer.push(click).unwrap());
    let mut signal = OverlapAdd::new(1, 0);
    renderer.take_all().iter().for_each(|job| signal.add(&job.render()));
    [BALL, GROUND].map(|body| signal.energies()[&body])
}

fn main() {
    for (name, material, radius) in
        [("steel ball of 7.5 mm", "steel", 0.0075), ("100 g of ceramic", "ceramic", 0.0207)]
    {
        println!("{name}, falling 0.5 m: level of the ground over that of the click");
        for ground in ["soil", "wood", "concrete", "granite", "steel", "rubber"] {
            let (click, pressed) = impact(material, radius, ground);
            let levels = LISTENERS.map(|(place, position)| {
                let [own, ground] = energies([&click, &pressed], position);
                format!("{place}: {:+.1} dB", 10.0 * (ground / own).log10())
            });
            println!("  {ground:9} τ = {:4.0} µs   {}", 1e6 * click.duration, levels.join("   "));
        }
    }
    // Impacts all over a floor of 2 m by 2 m: the directions computed for them are part of the cost.
    for (what, index) in [("click of the sphere", 0), ("ground", 1), ("slab", 2)] {
        for (count, distance) in [(10, 0.5), (200, 0.5), (5000, 0.5), (5000, 2.0), (5000, 8.0)] {
            let (click, pressed) = impact("steel", 0.0075, "concrete");
            let mut one = if index == 0 { click } else { pressed };
            if index == 2
                && let SoundSource::Ground { ground, .. } = &mut one.source
            {
                let concrete = preset("concrete").unwrap();
                *ground = Ground::Reference(Arc::new(SlabSource::try_new(&concrete, &Medium::AIR).unwrap()));
            }
            let place = DVec3::new(0.8, 0.6, 0.0) * distance;
            let begin = Instant::now();
            let mut renderer =
                Renderer::new(&Listener::fixed("listener", place), &RenderSettings::default()).unwrap();
            for i in 0..count {
                // Golden sections fill a square evenly.
                let part = |step: f64| 2.0 * (f64::from(i) * step).fract() - 1.0;
                let beside = DVec3::new(part(0.754_877_666), 0.0, part(0.569_840_290));
                let centre = one.centre + beside;
                renderer
                    .push(&AccelerationPulse { time: 0.1 * f64::from(i), centre, ..one.clone() })
                    .unwrap();
            }
            let jobs = renderer.take_all();
            let mut memory = BlockMemory::default();
            jobs.iter().for_each(|job| drop(job.render_with(&mut memory)));
            let seconds = begin.elapsed().as_secs_f64();
            let again = Instant::now();
            jobs.iter().for_each(|job| drop(job.render_with(&mut memory)));
            println!(
                "{what} at {distance} m, {count} impacts: {:.0} µs each, {:.0} µs with all directions kept",
                1e6 * seconds / f64::from(count),
                1e6 * again.elapsed().as_secs_f64() / f64::from(count)
            );
        }
    }
}
