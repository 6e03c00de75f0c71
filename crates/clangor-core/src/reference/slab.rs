//! \[FRAC\] §6: the ground as a slab of 9 m × 9 m × 0.9 m that rings at 700 Hz to 4 kHz. The force acts at
//! its middle, and distances count from the point of impact.
//!
//! ```text
//! q̈ᵢ + 2ξωᵢ q̇ᵢ + ωᵢ² qᵢ = Uᵢ F,   p(t) = Σ |pᵢ| qᵢ(t − r/c)          [FRAC] eq. (8)
//! |pᵢ| = ρc ωᵢ Uᵢ √(ab σᵢ/8π) / max(r, R)
//! ```
//!
//! with Uᵢ the motion of the middle, and R the radius of the slab. |pᵢ| spreads the power of the mode over a
//! half-sphere.
//!
//! Differs: \[FRAC\] solves for the modes of a concrete slab and their multipoles. Here they have a closed
//! form: Mindlin's plate (shear and rotary inertia, with the correction that gives short waves the speed of
//! Rayleigh's), supported along its edges, the upper side in a baffle. A mode faster than sound radiates σ =
//! 1/√(1 − (kc/ω)²) of its power as a piston; slower ones radiate nothing. Between those frequencies it has
//! 1113 modes of bending and shear, where the paper counts 1000. Modes with a node in the middle, three of
//! four, are silent.
//!
//! The physical defects of the published model are kept: the sound comes from a point, and stops at 700 Hz
//! and 4 kHz. [`source`](crate::synthesis::ground::source) has neither defect.

use std::f64::consts::{PI, TAU};
use std::sync::{Arc, OnceLock};

use num_complex::Complex64;

use crate::material::Material;
use crate::medium::Medium;
use crate::synthesis::ground::half_space::{GroundError, HalfSpace};
use crate::synthesis::spectrum::{ArrivingForce, Grid, LANES, Rotation, Spectrum};

/// Length of the edges \[m\].
const EDGE: f64 = 9.0;
/// Thickness \[m\].
const THICKNESS: f64 = 0.9;
/// Band of the modes \[Hz\].
const BAND: [f64; 2] = [700.0, 4000.0];
/// Relative amplitude at which a mode is no longer followed: e^−9.2, 80 dB.
const FOLDS: f64 = 9.2;
/// Number of block lengths for which the response is cached: powers of two.
const LENGTHS: usize = 32;

/// A mode that an impact on the middle drives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlabMode {
    /// ω without damping [rad/s].
    pub omega: f64,
    /// ξ \[-\].
    pub damping_ratio: f64,
    /// U² of the middle [1/kg].
    pub motion_square: f64,
    /// σ.
    pub efficiency: f64,
}

/// The slab of a material under a medium.
#[derive(Clone, Debug)]
pub struct SlabSource {
    medium: Medium,
    modes: Vec<SlabMode>,
    /// Modes of the band, those with a node in the middle included.
    all_modes: usize,
    /// p·max(r, R)/F [Pa m/N] at the bins of blocks, by the logarithm of their length.
    responses: Vec<OnceLock<Response>>,
}

/// A response at the bins of a grid.
#[derive(Clone, Debug, PartialEq)]
struct Response {
    spacing_hz: f64,
    values: Vec<Complex64>,
}

impl PartialEq for SlabSource {
    fn eq(&self, other: &Self) -> bool {
        self.medium == other.medium && self.modes == other.modes
    }
}

impl SlabSource {
    /// A slab of a material under a medium.
    ///
    /// # Errors
    /// [`GroundError`] for numbers that no solid or medium has.
    pub fn try_new(material: &Material, medium: &Medium) -> Result<Self, GroundError> {
        let Medium { density, sound_speed } = *medium;
        if !(density > 0.0 && density.is_finite()) {
            return Err(GroundError::Medium { value: sound_speed, density });
        }
        let solid = HalfSpace::try_new(material, sound_speed)?;
        let plate = Mindlin::new(material, &solid);
        let (mut modes, mut all_modes) = (Vec::new(), 0);
        let wave = |m: u32, n: u32| PI / EDGE * f64::from(m).hypot(f64::from(n));
        let audible = |m, n| plate.branches(wave(m, n))[0].omega < TAU * BAND[1];
        for m in (1..).take_while(|m| audible(*m, 1)) {
            for n in (1..).take_while(|n| audible(m, *n)) {
                for Branch { omega, motion } in plate.branches(wave(m, n)) {
                    let frequency = omega / TAU;
                    if !(BAND[0]..BAND[1]).contains(&frequency) {
                        continue;
                    }
                    all_modes += 1;
                    if m % 2 == 0 || n % 2 == 0 {
                        continue;
                    }
                    let slowness = (wave(m, n) * sound_speed / omega).powi(2);
                    modes.push(SlabMode {
                        omega,
                        damping_ratio: material.damping.damping_ratio(frequency),
                        motion_square: 4.0 / (material.density * THICKNESS * EDGE * EDGE) * motion,
                        efficiency: if slowness < 1.0 { 1.0 / (1.0 - slowness).sqrt() } else { 0.0 },
                    });
                }
            }
        }
        Ok(SlabSource { medium: *medium, modes, all_modes, responses: vec![OnceLock::new(); LENGTHS] })
    }

    /// The modes that an impact drives.
    pub fn modes(&self) -> &[SlabMode] {
        &self.modes
    }

    /// Modes of the band, those with a node in the middle included.
    pub fn all_modes(&self) -> usize {
        self.all_modes
    }

    /// R \[m\]: within this distance of the point of impact the sound is that at R.
    pub fn radius() -> f64 {
        0.5 * (2.0 * EDGE * EDGE + THICKNESS * THICKNESS).sqrt()
    }

    /// Pressure over force [Pa/N] at an angular frequency [rad/s] and a distance \[m\], without the delay.
    pub fn transfer(&self, distance: f64, omega: f64) -> Complex64 {
        self.response(omega) / distance.max(SlabSource::radius())
    }

    /// p·max(r, R)/F [Pa m/N].
    fn response(&self, omega: f64) -> Complex64 {
        let Medium { density, sound_speed } = self.medium;
        let scale = density * sound_speed * EDGE / (8.0 * PI).sqrt();
        let part = |mode: &SlabMode| {
            let gain = scale * mode.omega * mode.motion_square * mode.efficiency.sqrt();
            let below = mode.omega * mode.omega - omega * omega;
            gain / Complex64::new(below, 2.0 * mode.damping_ratio * mode.omega * omega)
        };
        self.modes.iter().map(part).sum()
    }

    /// Decay time of an impact \[s\].
    pub(crate) fn ring_time(&self) -> f64 {
        let decay =
            self.modes.iter().map(|mode| mode.damping_ratio * mode.omega).fold(f64::INFINITY, f64::min);
        if decay > 0.0 && decay.is_finite() { FOLDS / decay } else { 0.0 }
    }
}

/// A slab under an impact, as it is received at a distance.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SlabTransfer {
    source: Arc<SlabSource>,
    /// Impulse into it over max(r, R) [N s/m].
    strength: f64,
}

impl SlabTransfer {
    /// Of an impulse [N s], received at a distance \[m\].
    pub(crate) fn new(source: &Arc<SlabSource>, impulse: f64, distance: f64) -> Self {
        SlabTransfer { source: Arc::clone(source), strength: impulse / distance.max(SlabSource::radius()) }
    }

    /// Adds an impact to a spectrum.
    #[inline(always)]
    pub(crate) fn add(&self, spectrum: &mut Spectrum, grid: &Grid, force: &ArrivingForce) {
        let SlabTransfer { source, strength } = self;
        let response = || {
            let values = grid.omega.iter().map(|omega| source.response(*omega)).collect();
            Response { spacing_hz: grid.spacing_hz, values }
        };
        let slot = grid.omega.len().next_power_of_two().trailing_zeros() as usize;
        let own: Response;
        let kept = match source.responses.get(slot).map(|slot| slot.get_or_init(response)) {
            Some(kept) if kept.spacing_hz == grid.spacing_hz && kept.values.len() == grid.omega.len() => kept,
            _ => {
                own = response();
                &own
            }
        };
        let mut delay = Rotation::<LANES>::new(-TAU * grid.spacing_hz * force.middle);
        for first in (0..grid.omega.len()).step_by(LANES) {
            for lane in 0..LANES {
                let k = first + lane;
                let (force_re, force_im) = force.at(k, grid.omega[k]);
                let pressed = *strength * Complex64::new(force_re, force_im);
                let pressure = pressed * kept.values[k] * Complex64::new(delay.cos[lane], delay.sin[lane]);
                spectrum.re[k] += pressure.re;
                spectrum.im[k] += pressure.im;
            }
            delay.advance();
        }
    }
}

/// Waves of a plate by Mindlin 1951.
struct Mindlin {
    /// ρh [kg/m²].
    mass: f64,
    /// ρh³/12 \[kg\].
    inertia: f64,
    /// Bending stiffness \[N m\].
    bending: f64,
    /// Shear stiffness κμh [N/m].
    shear: f64,
}

/// One of the two waves of a wavenumber.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Branch {
    omega: f64,
    /// Fraction of the kinetic energy in the transverse motion.
    motion: f64,
}

impl Mindlin {
    fn new(material: &Material, solid: &HalfSpace) -> Self {
        let HalfSpace { shear_modulus, poisson_ratio, .. } = *solid;
        let correction = (solid.rayleigh_speed() / solid.shear_speed()).powi(2);
        let cube = THICKNESS.powi(3) / 12.0;
        Mindlin {
            mass: material.density * THICKNESS,
            inertia: material.density * cube,
            bending: material.youngs_modulus * cube / (1.0 - poisson_ratio * poisson_ratio),
            shear: correction * shear_modulus * THICKNESS,
        }
    }

    /// Bending, then shear: w = W cos kx and the turn Ψ sin kx with
    /// ρh ω² W = S k (k W − Ψ), (ρh³/12) ω² Ψ = D k² Ψ − S (k W − Ψ).
    fn branches(&self, k: f64) -> [Branch; 2] {
        let Mindlin { mass, inertia, bending, shear } = *self;
        let (a, b) = (shear * k * k / mass, -shear * k / (mass * inertia).sqrt());
        let c = (bending * k * k + shear) / inertia;
        let half = (0.25 * (a - c) * (a - c) + b * b).sqrt();
        [-half, half].map(|part| {
            let square = 0.5 * (a + c) + part;
            // For the slow wave, the product of both squares over the fast one loses no digits.
            let square = if part < 0.0 { (a * c - b * b) / (0.5 * (a + c) + half) } else { square };
            let turn = (square - a) / b;
            Branch { omega: square.sqrt(), motion: 1.0 / (1.0 + turn * turn) }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::presets::CONCRETE;

    #[test]
    fn long_waves_bend_as_kirchhoff_found_and_short_ones_run_as_rayleighs() {
        let material = CONCRETE.material();
        let solid = HalfSpace::try_new(&material, Medium::AIR.sound_speed).unwrap();
        let plate = Mindlin::new(&material, &solid);
        let k = 0.01;
        let thin = k * k * (plate.bending / plate.mass).sqrt();
        let [bending, shear] = plate.branches(k);
        assert!((bending.omega / thin - 1.0).abs() < 1e-4 && bending.motion > 0.999);
        // Thickness shear: ω = √(12 κ) c_S/h.
        let cutoff = 12f64.sqrt() * solid.rayleigh_speed() / THICKNESS;
        assert!((shear.omega / cutoff - 1.0).abs() < 1e-3 && shear.motion < 1e-3);
        let speed = plate.branches(200.0)[0].omega / 200.0;
        assert!((speed / solid.rayleigh_speed() - 1.0).abs() < 1e-3, "{speed}");
    }
}
