//! How many modes a body has below a frequency, before anything is meshed or solved.
//!
//! The mean wall is h = 2V/A, with the volume V and the surface A: the thickness of a plate or shell, and a
//! third of the diameter of a ball. Below the first resonance of the wall, c_T/2h, the body counts as a plate
//! of area S = A/2, with the modes of bending, of shear and of compression in its plane (Cremer and Heckl,
//! *Körperschall*); above it as a solid with a free surface (Dupuis, Mazo and Onsager, J. Chem. Phys. 33,
//! 1960):
//!
//! ```text
//! plate:  N = S f √(m″/D)/2 + π S f² (1/c_P² + 1/c_T²)    D = E h³/12(1 − ν²),  m″ = ρ h
//! solid:  N = 4π V f³ (1/c_L³ + 2/c_T³)/3 + π A f² (3 − 3q + 2q²)/4(1 − q)c_T²    q = c_T²/c_L²
//! c_P² = E/ρ(1 − ν²),  c_T² = E/2ρ(1 + ν),  c_L² = E(1 − ν)/ρ(1 + ν)(1 − 2ν)
//! ```
//!
//! Averages for many modes: boundaries, curvature and slender forms change the first few, so that a count
//! below ten says only that there are few. Not a solution: `eigensolver` counts them.

use std::f64::consts::PI;

use clangor_core::material::Material;

/// How modes are counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModalDensity {
    /// As those of a plate.
    Plate,
    /// As those of a solid.
    Solid,
}

/// Estimated number of modes below a frequency \[Hz\] of a body of this volume \[m³\] and surface \[m²\], and
/// by which density.
pub fn modes_below(volume: f64, area: f64, frequency: f64, material: &Material) -> (f64, ModalDensity) {
    let Material { youngs_modulus, poisson_ratio, density, .. } = *material;
    let wall = 2.0 * volume / area;
    if frequency < 0.5 * shear_speed(material) / wall {
        let plane_strain = youngs_modulus / (1.0 - poisson_ratio * poisson_ratio);
        let bending = (plane_strain * wall * wall / (12.0 * density)).sqrt();
        let count =
            0.25 * area * frequency / bending + in_plane_modes_below(volume, area, frequency, material);
        return (count, ModalDensity::Plate);
    }
    (solid_modes_below(volume, area, frequency, material), ModalDensity::Solid)
}

/// c_T [m/s].
fn shear_speed(material: &Material) -> f64 {
    let Material { youngs_modulus, poisson_ratio, density, .. } = *material;
    (0.5 * youngs_modulus / (density * (1.0 + poisson_ratio))).sqrt()
}

/// The modes of shear and compression in the plane of a plate of this volume \[m³\] and surface \[m²\] below
/// a frequency \[Hz\].
pub(crate) fn in_plane_modes_below(_: f64, area: f64, frequency: f64, material: &Material) -> f64 {
    let Material { youngs_modulus, poisson_ratio, density, .. } = *material;
    let plane_strain = youngs_modulus / (1.0 - poisson_ratio * poisson_ratio);
    let in_plane = density / plane_strain + shear_speed(material).powi(-2);
    PI * 0.5 * area * frequency * frequency * in_plane
}

/// The modes of a solid of this volume \[m³\] and surface \[m²\] below a frequency \[Hz\].
pub(crate) fn solid_modes_below(volume: f64, area: f64, frequency: f64, material: &Material) -> f64 {
    let poisson_ratio = material.poisson_ratio;
    // q; 0 for an incompressible material.
    let q = (1.0 - 2.0 * poisson_ratio).max(0.0) / (2.0 - 2.0 * poisson_ratio);
    let wavenumber = frequency / shear_speed(material);
    let inside = 4.0 / 3.0 * PI * volume * wavenumber.powi(3) * (q.powf(1.5) + 2.0);
    let surface = 0.25 * PI * area * wavenumber.powi(2) * (3.0 - 3.0 * q + 2.0 * q * q) / (1.0 - q);
    inside + surface
}

/// The frequency \[Hz\], at most `highest`, below which a body of this volume \[m³\] and surface \[m²\] has
/// about `count` modes.
pub fn frequency_of_mode(count: f64, volume: f64, area: f64, highest: f64, material: &Material) -> f64 {
    let fewer = |frequency: f64| modes_below(volume, area, frequency, material).0 < count;
    if fewer(highest) {
        return highest;
    }
    let [mut low, mut high] = [0.0, highest];
    while high - low > 1e-3 * high {
        let middle = 0.5 * (low + high);
        *(if fewer(middle) { &mut low } else { &mut high }) = middle;
    }
    low
}

#[cfg(test)]
mod tests {
    use clangor_core::material::presets;

    use super::*;

    #[test]
    fn the_frequency_of_a_mode_has_so_many_below() {
        let steel = presets::STEEL.material();
        for (volume, area, highest) in [(6e-5, 0.121, 2e4), (4.3e-3, 0.17, 2e4), (1e-6, 1e-3, 2e4)] {
            for count in [30.0, 100.0] {
                let frequency = frequency_of_mode(count, volume, area, highest, &steel);
                let below = modes_below(volume, area, frequency, &steel).0;
                assert!(frequency <= highest);
                // The two densities do not join where one takes over from the other.
                assert!(below <= count, "{below} of {count}");
                assert!(frequency == highest || below > 0.5 * count, "{below} of {count}");
            }
        }
    }
}
