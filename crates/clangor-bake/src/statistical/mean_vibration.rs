//! Vibration of a body in the mean over many modes: how many there are, how its surface gives way, and how
//! well it radiates, as functions of the frequency.
//!
//! ```text
//! Re Y = (π/2) n(ω) ⟨U_n²⟩        mean mobility of a surface whose modes have the normal motion U_n [kg^−½]
//! P    = ½ ρ c A σ ⟨U_n²⟩/ω²      power of a mode of unit acceleration q̈
//! ```
//!
//! The wall is an elastic layer (`layer_waves`) of thickness h, the median through the body along inward
//! normals, and of area V/h: Re Y and the slowest surface wave k_s go from those of a plate to those of a
//! half-space. Modes are those of bending, k_s² V/(4πh), and of the plane of a plate; where waves fit across
//! the wall, c_T/4h to c_T/h, those of a solid take over (`modal_density`). Only modes of bending share the
//! energy of a normal force in a plate, all modes in a solid.
//!
//! Radiation efficiency, μ = k_s c/ω, of both faces:
//!
//! ```text
//! μ < 1:  σ = 1/√(1 − μ²)        μ > 1:  σ of free edges (`edge_radiation`) of length 4√(V/h)
//! both at most σ_c = max(1, 0.35 (k √(V/h))^{1/2})                                     [Leppington1982]
//! ```
//!
//! Values are used as ratios of two frequencies: levels are those of the known modes below. So neither the
//! length of edges nor a factor on Re Y at edges counts.

use std::f64::consts::{PI, TAU};

use clangor_core::material::Material;
use clangor_core::medium::Medium;

use super::edge_radiation::edge_power;
use super::layer_waves::Layer;
use crate::modal_analysis::modal_density::{in_plane_modes_below, solid_modes_below};

/// Relative step of derivatives by frequency.
const STEP: f64 = 1e-3;
/// h f/c_T at which a wall begins to be a solid, and from which it is one.
const SOLID_FROM: f64 = 0.25;
const SOLID_AT: f64 = 1.0;
/// σ at coincidence of a square plate, over (k √S)^{1/2}.
const AT_COINCIDENCE: f64 = 0.35;

/// A body as a wall of its thickness.
#[derive(Clone, Debug)]
pub(super) struct MeanVibration {
    layer: Layer,
    material: Material,
    volume: f64,
    area: f64,
}

impl MeanVibration {
    /// Of a volume \[m³\], surface \[m²\] and wall \[m\].
    pub(super) fn new(material: &Material, volume: f64, area: f64, wall: f64) -> Self {
        MeanVibration { layer: Layer::new(material, wall), material: material.clone(), volume, area }
    }

    /// Re Y of a normal force on a face [m/(N s)].
    pub(super) fn mobility(&self, frequency: f64) -> f64 {
        self.layer.mobility(TAU * frequency)
    }

    /// Modes below a frequency, without what edges add.
    pub(super) fn modes_below(&self, frequency: f64) -> f64 {
        let solid = self.solid_part(frequency);
        let below =
            |of: fn(f64, f64, f64, &Material) -> f64| of(self.volume, self.area, frequency, &self.material);
        let plate = self.bending_below(frequency) + below(in_plane_modes_below);
        (1.0 - solid) * plate + solid * below(solid_modes_below)
    }

    /// The same per hertz.
    pub(super) fn density(&self, frequency: f64) -> f64 {
        derivative(frequency, |f| self.modes_below(f))
    }

    /// dk_s/df [1/(m Hz)].
    pub(super) fn wavenumber_slope(&self, frequency: f64) -> f64 {
        derivative(frequency, |f| self.surface_wavenumber(f))
    }

    /// k_s [1/m].
    pub(super) fn surface_wavenumber(&self, frequency: f64) -> f64 {
        self.layer.surface_wavenumber(TAU * frequency)
    }

    /// ⟨U_n²⟩ of the modes that share the energy of a normal force [1/kg].
    pub(super) fn normal_motion(&self, frequency: f64) -> f64 {
        let solid = self.solid_part(frequency);
        let sharing = (1.0 - solid) * self.bending_density(frequency)
            + solid * self.slope(frequency, solid_modes_below);
        // n(ω) = n(f)/2π.
        2.0 * self.mobility(frequency) / (PI * sharing / TAU)
    }

    /// μ = k_s/k.
    pub(super) fn slowness(&self, frequency: f64, medium: &Medium) -> f64 {
        self.surface_wavenumber(frequency) * medium.sound_speed / (TAU * frequency)
    }

    /// σ of both faces.
    pub(super) fn efficiency(&self, frequency: f64, medium: &Medium) -> f64 {
        let wavenumber = TAU * frequency / medium.sound_speed;
        let slowness = self.slowness(frequency, medium);
        let side = (self.volume / self.layer.thickness).sqrt();
        let most = (AT_COINCIDENCE * (wavenumber * side).sqrt()).max(1.0);
        let free = if slowness < 1.0 {
            (1.0 - slowness * slowness).sqrt().recip()
        } else {
            let poisson = self.material.poisson_ratio;
            4.0 * side * edge_power(slowness, poisson) / (wavenumber * 2.0 * side * side)
        };
        free.min(most)
    }

    /// 0 for a plate, 1 for a solid.
    fn solid_part(&self, frequency: f64) -> f64 {
        let waves = self.layer.thickness * frequency / self.layer.shear_speed;
        let t = ((waves / SOLID_FROM).ln() / (SOLID_AT / SOLID_FROM).ln()).clamp(0.0, 1.0);
        t * t * (3.0 - 2.0 * t)
    }

    /// Modes of bending: k_s² S/4π.
    fn bending_below(&self, frequency: f64) -> f64 {
        self.surface_wavenumber(frequency).powi(2) * self.volume / self.layer.thickness / (4.0 * PI)
    }

    fn bending_density(&self, frequency: f64) -> f64 {
        derivative(frequency, |f| self.bending_below(f))
    }

    fn slope(&self, frequency: f64, below: fn(f64, f64, f64, &Material) -> f64) -> f64 {
        derivative(frequency, |f| below(self.volume, self.area, f, &self.material))
    }
}

fn derivative(at: f64, of: impl Fn(f64) -> f64) -> f64 {
    (of(at * (1.0 + STEP)) - of(at * (1.0 - STEP))) / (2.0 * STEP * at)
}
