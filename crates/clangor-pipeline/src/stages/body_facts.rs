//! Size and wall of a body, and how many modes it has below a frequency, before anything is meshed or solved.
//!
//! Modes are counted by their density ([`clangor_bake::modal_analysis::modal_density`]).

use std::f64::consts::PI;

use clangor_bake::modal_analysis::modal_density::{ModalDensity, modes_below};
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
        modes_below(self.volume, self.area, frequency, material)
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
