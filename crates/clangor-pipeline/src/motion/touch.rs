//! A point where two surfaces touch.

use glam::DVec3;

/// A point where two surfaces touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Touch {
    /// Midway between the surfaces [m, world].
    pub(super) point: DVec3,
    /// Unit, from the second surface to the first.
    pub(super) normal: DVec3,
    /// Distance of the surfaces \[m\], negative where they overlap.
    pub(super) gap: f64,
}

impl Touch {
    /// The same from the second surface.
    pub(super) fn turned(self) -> Self {
        Touch { normal: -self.normal, ..self }
    }
}
