//! The ground as a slab, [FRAC] §6: the number of its modes, and impacts as the response of those modes.

use std::f64::consts::TAU;
use std::sync::Arc;

use clangor_core::body::BodyId;
use clangor_core::contact::ForceProfile;
use clangor_core::glam::{DQuat, DVec3};
use clangor_core::material::presets::preset;
use clangor_core::medium::Medium;
use clangor_core::reference::SlabSource;
use clangor_core::synthesis::ground::{Ground, GroundSource};
use clangor_core::synthesis::{
    AccelerationPulse, Listener, OverlapAdd, RenderSettings, Renderer, SoundSource,
};
use num_complex::Complex64;

fn heard(ground: Ground, place: DVec3, duration: f64, impulse: f64) -> Vec<f64> {
    let click = AccelerationPulse {
        body: BodyId(0),
        time: 0.01,
        duration,
        shape: ForceProfile::HalfSine.into(),
        centre: DVec3::ZERO,
        orientation: DQuat::IDENTITY,
        velocity_change: DVec3::ZERO,
        angular_velocity_change: DVec3::ZERO,
        source: SoundSource::Ground { ground, impulse },
    };
    let settings = RenderSettings::default();
    let mut renderer = Renderer::new(&Listener::fixed("", place), &settings).unwrap();
    renderer.push(&click).unwrap();
    let mut signal = OverlapAdd::new(1, 0);
    renderer.take_all().iter().for_each(|job| signal.add(&job.render()));
    signal.take_until(48_000).swap_remove(0)
}

fn slab() -> Arc<SlabSource> {
    Arc::new(SlabSource::try_new(&preset("concrete").unwrap(), &Medium::AIR).unwrap())
}

#[test]
fn a_slab_of_concrete_has_the_thousand_modes_of_the_paper() {
    let slab = slab();
    let excited = slab.modes().len();
    println!("{} modes between 700 Hz and 4 kHz, {excited} of them driven in the middle", slab.all_modes());
    assert!((900..1200).contains(&slab.all_modes()) && (200..400).contains(&excited));
    assert!(slab.modes().iter().all(|mode| mode.efficiency > 1.0 && mode.efficiency < 1.1));
}

#[test]
fn an_impact_on_the_slab_is_the_response_of_its_modes() {
    let slab = slab();
    let (duration, impulse) = (2e-4, 0.3);
    for place in [DVec3::new(0.5, 1.2, -0.3), DVec3::new(6.0, 4.0, 5.0)] {
        let sound = heard(Ground::Reference(Arc::clone(&slab)), place, duration, impulse);
        let distance = place.length();
        let (mut difference, mut largest): (f64, f64) = (0.0, 0.0);
        for k in 1..60 {
            let omega = TAU * 120.0 * f64::from(k);
            let (re, im) = ForceProfile::HalfSine.spectrum(omega, duration);
            let delay = Complex64::from_polar(impulse, -omega * (0.01 + distance / 343.2));
            let exact = slab.transfer(distance, omega) * Complex64::new(re, im) * delay;
            let samples = sound.iter().enumerate();
            let heard: Complex64 =
                samples.map(|(i, p)| Complex64::from_polar(p / 48_000.0, -omega * i as f64 / 48_000.0)).sum();
            difference = difference.max((heard - exact).norm());
            largest = largest.max(exact.norm());
        }
        println!("{distance:.1} m: {:.1e}", difference / largest);
        // Residual seen: 2e-7.
        assert!(difference < 1e-5 * largest, "{:e}", difference / largest);
    }
}

#[test]
fn the_slab_is_about_as_loud_as_the_half_space_where_it_rings() {
    // Level between 700 Hz and 4 kHz, at the radius of the slab.
    let half_space = GroundSource::try_new(&preset("concrete").unwrap(), &Medium::AIR).unwrap();
    let place = DVec3::new(2.0, 5.5, 2.4);
    let sounds = [Ground::Reference(slab()), Arc::new(half_space).into()].map(|g| heard(g, place, 2e-4, 0.3));
    let [slab, half_space] = sounds.map(|sound| {
        let power = |k: i32| {
            let omega = TAU * 20.0 * f64::from(k);
            let samples = sound.iter().enumerate();
            samples
                .map(|(i, p)| Complex64::from_polar(*p, -omega * i as f64 / 48_000.0))
                .sum::<Complex64>()
                .norm_sqr()
        };
        (36..200).map(power).sum::<f64>()
    });
    let level = 10.0 * (slab / half_space).log10();
    println!("{level:.1} dB");
    assert!(level.abs() < 10.0, "{level}");
}
