//! Convex parts: the pieces whose union collides as one body. Mass and inertia never come from them.

use glam::DVec3;

/// A convex piece of a body, in the frame of the shape that made it.
#[derive(Clone, Debug, PartialEq)]
pub enum ConvexPart {
    /// A ball: centre and radius \[m\].
    Ball {
        /// Centre \[m\].
        centre: DVec3,
        /// Radius \[m\].
        radius: f64,
    },
    /// A right circular cylinder with smooth side.
    Cylinder {
        /// Centre \[m\].
        centre: DVec3,
        /// Unit vector along the axis.
        axis: DVec3,
        /// Radius \[m\].
        radius: f64,
        /// Half of the height \[m\].
        half_height: f64,
    },
    /// The convex hull of points \[m\].
    Hull(Vec<DVec3>),
}

impl ConvexPart {
    /// The same part with all lengths multiplied by `factor`.
    pub fn scaled(&self, factor: f64) -> Self {
        match self {
            ConvexPart::Ball { centre, radius } => {
                ConvexPart::Ball { centre: *centre * factor, radius: *radius * factor }
            }
            ConvexPart::Cylinder { centre, axis, radius, half_height } => ConvexPart::Cylinder {
                centre: *centre * factor,
                axis: *axis,
                radius: *radius * factor,
                half_height: *half_height * factor,
            },
            ConvexPart::Hull(points) => ConvexPart::Hull(points.iter().map(|p| *p * factor).collect()),
        }
    }

    /// The same part in a frame whose origin is at `origin`.
    pub fn relative_to(&self, origin: DVec3) -> Self {
        match self {
            ConvexPart::Ball { centre, radius } => {
                ConvexPart::Ball { centre: *centre - origin, radius: *radius }
            }
            ConvexPart::Cylinder { centre, axis, radius, half_height } => ConvexPart::Cylinder {
                centre: *centre - origin,
                axis: *axis,
                radius: *radius,
                half_height: *half_height,
            },
            ConvexPart::Hull(points) => ConvexPart::Hull(points.iter().map(|p| *p - origin).collect()),
        }
    }
}
