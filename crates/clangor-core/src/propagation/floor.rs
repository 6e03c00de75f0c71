//! A rigid floor: the plane of a half-space in which every wave has a mirror image.

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
