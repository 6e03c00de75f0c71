//! How wide a contact is on the faces next to an edge: see [`touched_form`](super::touched_form).

use glam::DVec3;

/// How far a contact goes: its largest approach, and its largest half width.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ContactScale {
    /// d \[m\].
    pub(super) approach: f64,
    /// L \[m\].
    pub(super) reach: f64,
}

impl ContactScale {
    /// Distance w \[m\] at which a face of some slope, whose edge has a rounding ρ \[m\], is lower than the
    /// tangent plane by the approach.
    pub(super) fn width(self, slope: f64, rounding: f64) -> f64 {
        let ContactScale { approach, reach } = self;
        let free = if approach <= 0.5 * rounding * slope * slope {
            (2.0 * rounding * approach).sqrt()
        } else {
            approach / slope + 0.5 * rounding * slope
        };
        free.min(reach)
    }

    /// 2 d/L² [1/m]: the relative curvature of a contact as wide as its reach.
    pub(super) fn least_curvature(self) -> f64 {
        2.0 * self.approach / (self.reach * self.reach)
    }
}

/// Slope, at least 0 and infinite where it is upright, with which the steepest of the faces falls away from
/// the tangent plane along a direction in it.
pub(super) fn slope(faces: &[DVec3], normal: DVec3, direction: DVec3) -> f64 {
    faces.iter().fold(0.0, |steepest, face| {
        let (along, upward) = (face.dot(direction), face.dot(normal));
        match along > 0.0 {
            true if upward > 0.0 => f64::max(steepest, along / upward),
            true => f64::INFINITY,
            false => steepest,
        }
    })
}
