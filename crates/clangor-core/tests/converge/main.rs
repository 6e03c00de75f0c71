//! Convergence: errors shrink with the resolution at the expected slope.

mod curvature;
mod geometry;
