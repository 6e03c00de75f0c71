//! Limits of a live world.

/// Largest number of bodies, including removed ones.
pub const MOST_BODIES: usize = 20_000;
/// Longest time of one advance \[s\].
pub const LONGEST_ADVANCE: f64 = 60.0;
/// Largest speed that a ball may be given \[m/s\].
pub const FASTEST: f64 = 200.0;
/// Smallest and largest radius of a ball \[m\].
pub const RADII: [f64; 2] = [1e-4, 100.0];
/// Largest distance of a ball from the origin \[m\].
pub(super) const FARTHEST: f64 = 1e5;
