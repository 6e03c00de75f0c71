//! What holds a body of a scene: `[[body.support]]`, before the mass and the surface of the body are known.
//!
//! ```text
//! k = stiffness of each region,   or  M (2π f)² in all, shared equally by the regions of the support
//! c = damping of each region,     or  2 ζ √(M k_all) in all, likewise
//! ```

use std::f64::consts::TAU;

use glam::DVec3;

use super::diagnostic::Place;
use crate::body::support::{Support, SupportKind, SupportRegion};

/// A `[[body.support]]`: one region or several that hold alike. Lengths are those of the scaled body.
#[derive(Clone, Debug, PartialEq)]
pub struct SupportDescription {
    /// Where it holds.
    pub places: SupportPlaces,
    /// How.
    pub rule: SupportRule,
    /// Place of the support in the text.
    pub place: Place,
}

/// Where a support holds, in the frame of the shape or file.
#[derive(Clone, Debug, PartialEq)]
pub enum SupportPlaces {
    /// In one region.
    Region(SupportRegion),
    /// In a ball about each of several points.
    Points {
        /// The points \[m\].
        points: Vec<DVec3>,
        /// Radius of the balls \[m\]; `None`: [`POINT_RADIUS`] of the bounding radius of the body.
        radius: Option<f64>,
    },
}

/// Radius of the ball about a point over the bounding radius of the body.
pub const POINT_RADIUS: f64 = 0.02;

/// How a support holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SupportRule {
    /// Nothing moves there.
    Clamped,
    /// Springs and dampers.
    Sprung {
        /// Of the springs.
        stiffness: SupportStiffness,
        /// Of the dampers.
        damping: SupportDamping,
    },
}

/// Stiffness of a support.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SupportStiffness {
    /// Of each region, along each axis [N/m].
    OfEach(DVec3),
    /// Such that the body bounces on all of its regions together at this frequency \[Hz\].
    Bounce(f64),
}

/// Damping of a support.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SupportDamping {
    /// Of each region, along each axis [N s/m].
    OfEach(DVec3),
    /// Damping ratio of the body that bounces on all of its regions together.
    Ratio(f64),
}

/// Bounce \[Hz\] of a body on its feet, and its damping ratio, unless the scene says otherwise: soft rubber.
pub const FEET_FREQUENCY: f64 = 15.0;
/// See [`FEET_FREQUENCY`].
pub const FEET_DAMPING_RATIO: f64 = 0.1;

impl SupportDescription {
    /// The supports of a body of this mass \[kg\] and bounding radius \[m\], whose centre of mass is at
    /// `centre` \[m\] in the frame of the shape or file.
    pub fn resolve(&self, mass: f64, radius: f64, centre: DVec3) -> Vec<Support> {
        let regions: Vec<SupportRegion> = match &self.places {
            SupportPlaces::Region(region) => vec![region.about(centre)],
            SupportPlaces::Points { points, radius: own } => {
                let radius = own.unwrap_or(POINT_RADIUS * radius);
                points.iter().map(|p| SupportRegion::Ball { centre: *p - centre, radius }).collect()
            }
        };
        let count = regions.len() as f64;
        let kind = match self.rule {
            SupportRule::Clamped => SupportKind::Clamped,
            SupportRule::Sprung { stiffness, damping } => {
                let stiffness = match stiffness {
                    SupportStiffness::OfEach(stiffness) => stiffness,
                    SupportStiffness::Bounce(frequency) => {
                        DVec3::splat(mass * (TAU * frequency).powi(2) / count)
                    }
                };
                let damping = match damping {
                    SupportDamping::OfEach(damping) => damping,
                    SupportDamping::Ratio(ratio) => {
                        stiffness.map(|k| 2.0 * ratio * (mass * k * count).sqrt() / count)
                    }
                };
                SupportKind::Sprung { stiffness, damping }
            }
        };
        regions.into_iter().map(|region| Support { region, kind }).collect()
    }
}
