//! A rigid floor: the plane of a half-space in which every wave has a mirror image.

use glam::DVec3;

/// Reflecting floor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Floor {
    /// Free space.
    #[default]
    None,
    /// The plane y = `height` \[m\] reflects everything.
    ///
    /// Exact for the wave of each body: a source mirrored in the plane, its acceleration mirrored with it.
    /// The reflected wave is not scattered a second time by the body.
    Rigid {
        /// Height of the plane \[m\].
        height: f64,
    },
}

impl Floor {
    /// A point \[m\] mirrored in the floor; `None` without a floor.
    pub(crate) fn mirrored(self, point: DVec3) -> Option<DVec3> {
        match self {
            Floor::None => None,
            Floor::Rigid { height } => Some(DVec3 { y: 2.0 * height - point.y, ..point }),
        }
    }
}
