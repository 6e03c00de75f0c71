//! Limits of a live world.

/// Most bodies, those that have been removed included.
pub const MOST_BODIES: usize = 20_000;
/// Furthest that one advance goes \[s\].
pub const LONGEST_ADVANCE: f64 = 60.0;
/// Fastest that a ball may be set to move [m/s].
pub const FASTEST: f64 = 200.0;
/// Radii of balls \[m\].
pub const RADII: [f64; 2] = [1e-4, 100.0];
/// Farthest from the origin \[m\].
pub(super) const FARTHEST: f64 = 1e5;
