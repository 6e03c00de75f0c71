//! What happens between a click and the file: the floor, the band limit, the cost.

use clangor_core::acoustics::Acoustics;
use clangor_core::body::BodyId;
use clangor_core::contact::ForceProfile;
use clangor_core::glam::{DQuat, DVec3};
use clangor_core::synthesis::listener::Floor;
use clangor_core::synthesis::{
    AccelerationPulse, Listener, OverlapAdd, RenderSettings, Renderer, SampleRate, SoundSource,
};
use rayon::prelude::*;
use std::f64::consts::TAU;

use super::{Check, Extent, Fault, Outcome, Timing, Validation, cpu_time};

const SECTION: &str = "Rendering";

pub(super) fn run(_extent: Extent, table: &mut Validation) -> Outcome {
    let click = AccelerationPulse {
        body: BodyId(0),
        time: 1e-3,
        duration: 40e-6,
        shape: ForceProfile::HalfSine.into(),
        centre: DVec3::new(0.0, 0.2, 0.0),
        orientation: DQuat::IDENTITY,
        velocity_change: DVec3::new(0.2, 1.0, 0.0),
        angular_velocity_change: DVec3::ZERO,
        source: SoundSource::Sphere { radius: 0.0075 },
    };
    floor(&click, table)?;
    aliasing(&click, table)?;
    cost(table)
}

fn settings(rate: u32, floor: Floor) -> Result<RenderSettings, Fault> {
    Ok(RenderSettings {
        sample_rate: SampleRate::try_new(rate)?,
        start: -2e-3,
        acoustics: Acoustics { floor, ..Acoustics::default() },
        ..RenderSettings::default()
    })
}

/// Pressure of some clicks at a fixed receiver.
fn sound(
    clicks: &[AccelerationPulse],
    receiver: DVec3,
    settings: &RenderSettings,
    seconds: f64,
) -> Result<Vec<f64>, Fault> {
    let mut renderer = Renderer::new(&Listener::fixed("ear", receiver), settings)?;
    for click in clicks {
        renderer.push(click)?;
    }
    let jobs = renderer.take_all();
    let blocks: Vec<_> = jobs.par_iter().map(|job| job.render()).collect();
    let mut signal = OverlapAdd::new(1, 0);
    blocks.iter().for_each(|block| signal.add(block));
    Ok(signal.take_until((seconds * settings.sample_rate.as_f64()) as i64).swap_remove(0))
}

/// Relative L2 distance of two signals.
fn distance(a: &[f64], b: &[f64]) -> f64 {
    let square = |x: f64| x * x;
    let error: f64 = a.iter().zip(b).map(|(x, y)| square(x - y)).sum();
    (error / b.iter().map(|y| square(*y)).sum::<f64>()).sqrt()
}

/// A rigid floor is a mirror: the same sound as from the click and its mirror image in free space.
fn floor(click: &AccelerationPulse, table: &mut Validation) -> Outcome {
    let receiver = DVec3::new(0.4, 0.5, -0.3);
    let mirrored = |v: DVec3| DVec3::new(v.x, -v.y, v.z);
    let image = AccelerationPulse {
        centre: mirrored(click.centre),
        velocity_change: mirrored(click.velocity_change),
        ..click.clone()
    };
    let reflected =
        sound(std::slice::from_ref(click), receiver, &settings(48_000, Floor::Rigid { height: 0.0 })?, 0.02)?;
    let free = sound(&[click.clone(), image], receiver, &settings(48_000, Floor::None)?, 0.02)?;
    table.checks.push(Check {
        section: SECTION,
        quantity: "click above a rigid floor".into(),
        reference: "the click and its mirror image in free space",
        error: distance(&reflected, &free),
        bar: 1e-12,
        unit: "",
    });
    Ok(())
}

/// 48 kHz and 192 kHz agree in the band that both hold.
fn aliasing(click: &AccelerationPulse, table: &mut Validation) -> Outcome {
    let receiver = DVec3::new(0.4, 0.5, -0.3);
    let spectrum = |rate: u32| -> Result<Vec<f64>, Fault> {
        let signal = sound(std::slice::from_ref(click), receiver, &settings(rate, Floor::None)?, 0.02)?;
        let step = 1.0 / f64::from(rate);
        let bin = |k: u32| {
            let omega = TAU * (100.0 + 19_900.0 * f64::from(k) / 199.0);
            let sum = |f: fn(f64) -> f64| {
                signal.iter().enumerate().map(|(i, p)| p * f(omega * i as f64 * step) * step).sum::<f64>()
            };
            [sum(f64::cos), sum(f64::sin)]
        };
        Ok((0..200).flat_map(bin).collect())
    };
    table.checks.push(Check {
        section: SECTION,
        quantity: "spectrum 100 Hz–20 kHz of a click rendered at 48 kHz".into(),
        reference: "the same click at 192 kHz",
        error: distance(&spectrum(48_000)?, &spectrum(192_000)?),
        bar: 1e-4,
        unit: "",
    });
    Ok(())
}

/// The cost of a dense scene: 23 000 impacts of two bodies each, two receivers.
fn cost(table: &mut Validation) -> Outcome {
    let impacts: u32 = 23_000;
    let mut listener = Listener::fixed("ears", DVec3::new(1.0, 1.8, 1.0));
    listener.receivers = vec![DVec3::X * -0.1, DVec3::X * 0.1];
    let begin = cpu_time();
    let mut renderer = Renderer::new(&listener, &settings(48_000, Floor::None)?)?;
    for i in 0..impacts {
        // A low-discrepancy spread over 5 s, the table of PAN, and durations of 20 to 100 µs.
        let golden = |k: f64| (f64::from(i) * k).fract();
        let click = AccelerationPulse {
            body: BodyId(i % 50),
            time: 5.0 * f64::from(i) / f64::from(impacts),
            duration: 20e-6 + 80e-6 * golden(0.618_033_988_7),
            shape: ForceProfile::HalfSine.into(),
            centre: DVec3::new(1.8 * golden(0.414_213_562) - 0.9, 0.41, 0.8 * golden(0.732_050_807) - 0.4),
            orientation: DQuat::IDENTITY,
            velocity_change: DVec3::new(0.1, 1.0, 0.0),
            angular_velocity_change: DVec3::ZERO,
            source: SoundSource::Sphere { radius: 0.0075 },
        };
        let other = AccelerationPulse {
            body: BodyId(50 + i % 50),
            velocity_change: -click.velocity_change,
            ..click.clone()
        };
        renderer.push(&click)?;
        renderer.push(&other)?;
    }
    let jobs = renderer.take_all();
    let blocks: Vec<_> = jobs.par_iter().map(|job| job.render()).collect();
    let mut signal = OverlapAdd::new(2, 0);
    blocks.iter().for_each(|block| signal.add(block));
    signal.take_until(5 * 48_000);
    table.timings.push(Timing {
        what: format!("synthesis of {impacts} impacts of two bodies, two receivers, 5 s at 48 kHz"),
        cpu_seconds: cpu_time() - begin,
    });
    Ok(())
}
