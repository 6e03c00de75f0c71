//! What is wrong with a `[[body.support]]`.

/// Problem of a support of a scene.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SupportProblem {
    /// No stiffness along any axis.
    #[error("the support has no stiffness along any axis")]
    NoStiffness,
    /// A box with a lowest corner that is not lowest.
    #[error("along {axis} the box ends at {high} m, which is not above {low} m, where it begins")]
    EmptyBox {
        /// Name of the axis.
        axis: char,
        /// Where it begins \[m\].
        low: f64,
        /// Where it ends \[m\].
        high: f64,
    },
    /// A clamp on a body that moves freely.
    #[error("a body that moves freely cannot be clamped: nothing holds the clamp")]
    ClampedFree,
    /// A sphere.
    #[error("the body `{body}` is a sphere, which is rigid in impacts")]
    Sphere {
        /// The body.
        body: String,
    },
    /// No part of the body is in the region.
    #[error("the support does not touch the body `{body}`: its region is {distance:.3e} m from it")]
    Off {
        /// The body.
        body: String,
        /// Distance from the nearest point of the surface \[m\].
        distance: f64,
    },
    /// Two clamps share a part of the body.
    #[error("this clamp overlaps the one on line {first_line}")]
    Overlap {
        /// Line of the other.
        first_line: usize,
    },
    /// A clamp that leaves nothing of the body to vibrate.
    #[error("this clamp holds all of the body `{body}`, so that nothing of it can vibrate")]
    Whole {
        /// The body.
        body: String,
    },
    /// The supports together leave the body free.
    #[error("the supports of `{body}` leave {motions} of the six motions of the whole body free")]
    Free {
        /// The body.
        body: String,
        /// Number of free motions.
        motions: usize,
    },
}

impl SupportProblem {
    /// The correction of the text.
    pub fn remedy(&self) -> &'static str {
        match self {
            SupportProblem::NoStiffness => "write a stiffness above 0 along at least one axis",
            SupportProblem::EmptyBox { .. } => "write the lowest corner as `low`, the opposite one as `high`",
            SupportProblem::ClampedFree => {
                "set motion = \"fixed\" or `keyframes`, or use kind = \"sprung\" or \"feet\""
            }
            SupportProblem::Sphere { .. } => "delete the support, or give the body another shape",
            SupportProblem::Off { .. } => {
                "move or widen it: its coordinates are those of the shape or file, in metres"
            }
            SupportProblem::Overlap { .. } => "make them one, or move them apart",
            SupportProblem::Whole { .. } => "make it smaller, or delete it and write `modal = false`",
            SupportProblem::Free { .. } => {
                "add a support, widen one, or give springs a stiffness along all three axes"
            }
        }
    }
}
