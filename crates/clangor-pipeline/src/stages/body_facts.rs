//! Size and wall of a body, and how many modes it has below a frequency, before anything is meshed or solved.
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
//! below ten says only that there are few. Not a solution: `clangor modes` counts them.

use std::f64::consts::PI;

use clangor_core::body::Surface;
use clangor_core::glam::DVec3;
use clangor_core::material::Material;

/// Upper end of the band in which modes are counted \[Hz\]: that of hearing.
pub const AUDIBLE: f64 = 20_000.0;

/// Sizes of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyFacts {
    /// Least and greatest corner of the bounding box in the frame of the body \[m\].
    pub bounds: [DVec3; 2],
    /// Surface A \[m²\].
    pub area: f64,
    /// Volume V \[m³\].
    pub volume: f64,
}

/// How modes are counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModalDensity {
    /// As those of a plate.
    Plate,
    /// As those of a solid.
    Solid,
}

impl BodyFacts {
    /// The sizes of a surface; `None` for a half-space and an endless plate.
    pub fn of(surface: &Surface) -> Option<Self> {
        match surface {
            Surface::HalfSpace | Surface::Plate { .. } => None,
            Surface::Sphere { radius } => Some(BodyFacts {
                bounds: [DVec3::splat(-radius), DVec3::splat(*radius)],
                area: 4.0 * PI * radius * radius,
                volume: 4.0 / 3.0 * PI * radius.powi(3),
            }),
            Surface::Mesh(surface) => {
                let (low, high) = surface.mesh.bounds();
                Some(BodyFacts { bounds: [low, high], area: surface.mesh.area(), volume: surface.volume })
            }
        }
    }

    /// Edges of the bounding box \[m\].
    pub fn edges(&self) -> DVec3 {
        self.bounds[1] - self.bounds[0]
    }

    /// Mean wall h = 2V/A \[m\].
    pub fn wall(&self) -> f64 {
        2.0 * self.volume / self.area
    }

    /// Estimated number of modes below a frequency \[Hz\], and by which density.
    pub fn modes_below(&self, frequency: f64, material: &Material) -> (f64, ModalDensity) {
        let Material { youngs_modulus, poisson_ratio, density, .. } = *material;
        let wall = self.wall();
        let plane_strain = youngs_modulus / (1.0 - poisson_ratio * poisson_ratio);
        let shear_speed = (0.5 * youngs_modulus / (density * (1.0 + poisson_ratio))).sqrt();
        if frequency < 0.5 * shear_speed / wall {
            let bending = (plane_strain * wall * wall / (12.0 * density)).sqrt();
            let in_plane = density / plane_strain + shear_speed.powi(-2);
            let area = 0.5 * self.area;
            let count = 0.5 * area * frequency / bending + PI * area * frequency * frequency * in_plane;
            return (count, ModalDensity::Plate);
        }
        // q; 0 for an incompressible material.
        let q = (1.0 - 2.0 * poisson_ratio).max(0.0) / (2.0 - 2.0 * poisson_ratio);
        let wavenumber = frequency / shear_speed;
        let inside = 4.0 / 3.0 * PI * self.volume * wavenumber.powi(3) * (q.powf(1.5) + 2.0);
        let surface = 0.25 * PI * self.area * wavenumber.powi(2) * (3.0 - 3.0 * q + 2.0 * q * q) / (1.0 - q);
        (inside + surface, ModalDensity::Solid)
    }
}

#[cfg(test)]
mod tests {
    use clangor_core::material::presets;
    use clangor_core::shape::Shape;

    use super::*;

    #[test]
    fn analytic_a_plate_has_its_bending_modes() {
        let facts = BodyFacts::of(&Shape::parse("box:0.4x0.001x0.4").unwrap().surface().unwrap().0).unwrap();
        let glass = presets::GLASS.material();
        let (count, density) = facts.modes_below(2000.0, &glass);
        let speed = (glass.youngs_modulus / (1.0 - glass.poisson_ratio.powi(2)) / glass.density).sqrt();
        // N = √3 S f/(h c_P); the edges add 0.5 % of surface, and waves in the plane 1 %.
        let bending = 3.0_f64.sqrt() * 0.16 * 2000.0 / (0.001 * speed);
        assert_eq!(density, ModalDensity::Plate);
        assert!((count / bending - 1.0).abs() < 0.03, "{count} and {bending}");
        assert!((facts.edges() - DVec3::new(0.4, 0.001, 0.4)).length() < 1e-12);
        assert!((facts.wall() / 0.001 - 1.0).abs() < 0.006);
    }

    const COUNTED: [(&str, &str, f64, f64); 7] = [
        ("bowl", "ceramic", 20_000.0, 39.0),
        ("plate", "ceramic", 20_000.0, 108.0),
        ("wineglass", "glass", 10_000.0, 19.0),
        ("box:0.3x0.002x0.2", "steel", 3000.0, 39.0),
        ("sphere:0.1", "steel", 60_000.0, 392.0),
        ("box:0.1x0.08x0.12", "wood", 30_000.0, 37.0),
        ("cylinder:0.03x0.06", "steel", 100_000.0, 96.0),
    ];

    #[test]
    fn cross_estimates_are_near_the_counts_of_the_solver() {
        // `clangor modes SHAPE --material NAME --max-frequency HZ`: complete by count.
        for (shape, preset, frequency, counted) in COUNTED {
            let facts = BodyFacts::of(&Shape::parse(shape).unwrap().surface().unwrap().0).unwrap();
            let material = presets::preset(preset).unwrap();
            let (count, density) = facts.modes_below(frequency, &material);
            println!("{shape} {preset} to {frequency}: {count:.1} {density:?}, counted {counted}");
            assert!((0.5..2.0).contains(&(count / counted)), "{shape}: {count} of {counted}");
        }
        assert_eq!(BodyFacts::of(&Surface::HalfSpace), None);
    }
}
