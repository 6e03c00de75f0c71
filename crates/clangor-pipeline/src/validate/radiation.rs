//! The click of a sphere against the exact field, by a second route: spherical Hankel functions instead of
//! the two-pole form, Gauss–Legendre quadrature instead of the half-sine's closed spectrum.

use std::f64::consts::{PI, TAU};

use clangor_core::body::Body;
use clangor_core::contact::ForceProfile;
use clangor_core::glam::DVec3;
use clangor_core::material::presets;
use clangor_core::medium::Medium;
use clangor_core::sound_model::acceleration::sphere_radiation::SphereModel;
use clangor_core::synthesis::strike::{Strike, StrikeForce, strike};
use clangor_core::synthesis::{SampleRate, SoundSource};

use super::{Check, Extent, Outcome, Validation};

const SECTION: &str = "Acceleration noise of a sphere";

/// Complex number as (re, im).
type Complex = (f64, f64);

pub(super) fn run(_extent: Extent, table: &mut Validation) -> Outcome {
    let directions = [DVec3::new(0.0, 1.0, 0.0), DVec3::new(0.5, 0.7, -0.2), DVec3::new(-0.6, -0.3, 0.5)];
    for radius in [0.002, 0.0075, 0.03] {
        let mut worst = 0.0f64;
        for duration in [30e-6, 100e-6, 300e-6] {
            for distance in [1.2 * radius, 5.0 * radius, 1.0, 10.0] {
                for direction in directions {
                    let listener = direction.normalize() * distance;
                    worst = worst.max(spectrum_error(radius, duration, listener)?);
                }
            }
        }
        table.checks.push(Check {
            section: SECTION,
            quantity: format!(
                "spectrum 100 Hz–20 kHz, radius {} mm, τ 30–300 µs, 1.2 R to 10 m, three directions \
                 (relative L2, worst)",
                radius * 1e3
            ),
            reference: "h₁⁽²⁾ and quadrature of the half-sine",
            error: worst,
            bar: 1e-4,
            unit: "",
        });
    }
    Ok(())
}

/// Relative L2 error over the band of one impact.
fn spectrum_error(radius: f64, duration: f64, listener: DVec3) -> Result<f64, String> {
    let material = presets::preset("steel").ok_or("there is no preset steel")?;
    let body = Body::sphere("ball", material, radius).with_edge_radius(0.0);
    let impulse = DVec3::new(0.0, body.mass, 0.0);
    let impact = Strike {
        force: StrikeForce::Impulse { impulse, duration: Some(duration) },
        point: DVec3::new(0.0, -radius, 0.0),
        listener,
        profile: ForceProfile::HalfSine,
        steps: 16.0,
        sample_rate: SampleRate::HZ_48000,
        max_frequency: None,
        seconds: None,
        medium: Medium::AIR,
        room: None,
        sphere_model: SphereModel::Exact,
    };
    let sound = strike(&body, &SoundSource::Sphere { radius }, None, &impact).map_err(|e| e.to_string())?;
    let step = 1.0 / SampleRate::HZ_48000.as_f64();
    let (mut error, mut norm) = (0.0, 0.0);
    for k in 0..200 {
        let omega = TAU * (100.0 + (20_000.0 - 100.0) * f64::from(k) / 199.0);
        let (mut re, mut im) = (0.0, 0.0);
        for (time, pressure) in sound.times.iter().zip(&sound.pressures) {
            re += pressure * (omega * time).cos() * step;
            im -= pressure * (omega * time).sin() * step;
        }
        let exact = exact_spectrum(omega, radius, half_sine_spectrum(omega, duration), listener);
        error += (re - exact.0).powi(2) + (im - exact.1).powi(2);
        norm += exact.0.powi(2) + exact.1.powi(2);
    }
    Ok((error / norm).sqrt())
}

/// Pressure spectrum [Pa s] of a sphere that gains 1 m/s along y in a pulse of this spectrum.
///
/// p = −ρ a(ω) cos θ h₁(kr) / (k h₁′(ka)), which follows from ∂p/∂r = −ρ a cos θ on the sphere.
pub(super) fn exact_spectrum(omega: f64, radius: f64, pulse: Complex, listener: DVec3) -> Complex {
    let Medium { density, sound_speed } = Medium::AIR;
    let (k, r) = (omega / sound_speed, listener.length());
    let cosine = listener.y / r;
    let field = divide(hankel(k * r), scale(hankel_slope(k * radius), k));
    multiply(scale(field, -density * cosine), pulse)
}

/// h₁⁽²⁾(z) = −e^{−iz} (1/z) (1 − i/z).
fn hankel(z: f64) -> Complex {
    multiply((-z.cos(), z.sin()), (1.0 / z, -1.0 / (z * z)))
}

/// dh₁⁽²⁾/dz = h₀ − 2 h₁/z with h₀⁽²⁾ = i e^{−iz}/z.
fn hankel_slope(z: f64) -> Complex {
    let h0 = scale((z.sin(), z.cos()), 1.0 / z);
    let h1 = scale(hankel(z), 2.0 / z);
    (h0.0 - h1.0, h0.1 - h1.1)
}

/// ∫ (π/2τ) sin(πt/τ) e^{−iωt} dt over the contact, by Gauss–Legendre quadrature on 64 panels of 3 points.
fn half_sine_spectrum(omega: f64, duration: f64) -> Complex {
    const NODES: [(f64, f64); 3] =
        [(-0.774_596_669_241_483_4, 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.774_596_669_241_483_4, 5.0 / 9.0)];
    let panels = 64;
    let width = duration / f64::from(panels);
    let mut sum = (0.0, 0.0);
    for panel in 0..panels {
        for (node, weight) in NODES {
            let t = (f64::from(panel) + 0.5 * (1.0 + node)) * width;
            let force = PI / (2.0 * duration) * (PI * t / duration).sin() * weight * 0.5 * width;
            sum.0 += force * (omega * t).cos();
            sum.1 -= force * (omega * t).sin();
        }
    }
    sum
}

fn multiply(a: Complex, b: Complex) -> Complex {
    (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0)
}

fn divide(a: Complex, b: Complex) -> Complex {
    let norm = b.0 * b.0 + b.1 * b.1;
    scale(multiply(a, (b.0, -b.1)), 1.0 / norm)
}

fn scale(a: Complex, factor: f64) -> Complex {
    (a.0 * factor, a.1 * factor)
}
