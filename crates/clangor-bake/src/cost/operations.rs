//! Operations that a field takes, by each solver, from the size of its systems and the band: the basis of the
//! choice between solvers. No clock is read.
//!
//! ```text
//! frequencies   F = κ/Δκ + 12
//! triangles     Σ_classes ( A 0.43 n³ + F 350 n² ) + ( F 250 + 10⁴ + 450 κ ) g n²
//!               n unknowns of a class, g images, A = κ/1.5 anchors
//!               F ( Σ_classes 0.43 n³ + 250 g n² ) + …  where anchors do not fit, or n ≤ 1200
//!               F ( Σ_classes 0.43 n³ + 1500 g n² )     where the tables do not fit
//! motions       as the last two, with 10⁴ g n² for the tables, from 12 systems on
//! patches       F 6 ( 4 n³ + 300 n² )
//! meridian      F 3400 n², twice for a vessel with a narrow mouth
//! time domain   6 · 12.5 cells · steps
//! ```
//!
//! An estimate is good to a factor of two or three: the number of frequencies depends on the resonances of
//! the body.

use crate::acceleration::sampling::{SOLID_SPACING, VESSEL_DENSITY};
use crate::bem::triangles::sweep::anchors::{FEW, SPACING as ANCHOR_SPACING, WIDEST};
use crate::bem::triangles::sweep::{MEMORY as SWEEP_MEMORY, SHORTEST};

/// Systems for motions of the surface that are worth tables of what they share.
pub(crate) const MANY: usize = 12;

/// Bytes of a complex entry, and nodes of a table.
const BYTES: f64 = 8.0;
const TABLES: f64 = 7.0;

/// Work of a field.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FieldCost {
    /// Operations of [`bake`](crate::acceleration::bake()).
    pub operations: f64,
    /// Unknowns of a solve, of one part of a body with mirror planes; cells of a simulation in time.
    pub unknowns: f64,
}

/// Operations in a second of CPU time.
pub const PER_SECOND: f64 = 1e10;

/// Operations that no field takes without being asked for by its method: some ten minutes of two cores.
pub(crate) const MOST_OPERATIONS: f64 = 1.2e13;

/// Operations of a solver from which on a less accurate one may take its place, if it takes fewer by a
/// factor.
pub(crate) const CHEAP: f64 = 100.0 * PER_SECOND;
const PREFERENCE: f64 = 4.0;

/// Whether a solver that takes so many operations, infinitely many where it does not fit, takes long, and
/// much longer than another.
pub(crate) fn much_longer(operations: f64, others: f64) -> bool {
    operations >= CHEAP && operations > PREFERENCE * others
}

/// Operations up to which triangles solve the field of rigid motions, since they are more accurate: of a mug
/// they are within 0.3 %, time steps within 2 % up to 10 kHz and 4 % up to 20 kHz next to the resonances of
/// its cavity.
const WORTH: f64 = 6e12;

/// The same for the field of rigid motions by triangles, where no method is named.
pub(crate) fn field_in_time(elements: f64, time: f64) -> bool {
    elements > WORTH && much_longer(elements, time)
}

/// Frequencies beyond those of the spacing: near zero, and for tests.
const MORE_FREQUENCIES: f64 = 12.0;

/// Expected number of frequencies up to κ, for a spacing Δκ of the first solves.
fn frequencies(kappa: f64, spacing: f64) -> f64 {
    kappa / spacing + MORE_FREQUENCIES
}

/// Triangles with `unknowns` in each of `classes` systems and `images` mirror images.
pub(crate) fn triangles(unknowns: usize, systems: [usize; 2], kappa: f64, spacing: f64) -> f64 {
    let [classes, images] = systems.map(|count| count as f64);
    let (n, solves) = (unknowns as f64, frequencies(kappa, spacing));
    let alone = solves * solve(unknowns, systems);
    let tables = BYTES * TABLES * images * n * n;
    if tables > SWEEP_MEMORY as f64 || kappa < SHORTEST {
        return alone;
    }
    let shared = images * n * n * (250.0 * solves + 1e4 + 450.0 * kappa);
    let most = (SWEEP_MEMORY as f64 - tables) / (BYTES * classes * n * n);
    let anchors = (kappa / ANCHOR_SPACING).min(most);
    let anchored = unknowns > FEW && anchors * WIDEST >= kappa;
    let factors = 0.43 * classes * n.powi(3);
    let each = if anchored { 350.0 * classes * n * n } else { factors };
    (shared + solves * each + if anchored { anchors * factors } else { 0.0 }).min(alone)
}

/// Triangles at so many frequencies, for motions of the surface.
pub(crate) fn motions(unknowns: usize, systems: [usize; 2], solves: f64) -> f64 {
    let [classes, images] = systems.map(|count| count as f64);
    let n = unknowns as f64;
    let alone = solves * solve(unknowns, systems);
    if solves < MANY as f64 || BYTES * TABLES * images * n * n > SWEEP_MEMORY as f64 {
        return alone;
    }
    (images * n * n * (250.0 * solves + 1e4) + solves * 0.43 * classes * n.powi(3)).min(alone)
}

/// The same at one frequency.
pub(crate) fn solve(unknowns: usize, [classes, images]: [usize; 2]) -> f64 {
    let n = unknowns as f64;
    0.43 * classes as f64 * n.powi(3) + 1500.0 * images as f64 * n * n
}

/// Curved patches with `unknowns` on an octant.
pub(crate) fn patches(unknowns: usize, kappa: f64, spacing: f64) -> f64 {
    let n = unknowns as f64;
    frequencies(kappa, spacing) * 6.0 * (4.0 * n.powi(3) + 300.0 * n * n)
}

/// A meridian with `unknowns` at the highest frequency. The resonances of a vessel with a narrow mouth need
/// many frequencies, and their fit takes about as long again as the solves.
pub(crate) fn meridian(unknowns: usize, kappa: f64, has_narrow_mouth: bool) -> f64 {
    let each = 3400.0 * (unknowns as f64).powi(2);
    match has_narrow_mouth {
        true => 2.0 * frequencies(kappa, VESSEL_DENSITY) * each,
        false => frequencies(kappa, SOLID_SPACING) * each,
    }
}

/// Six motions on a grid.
pub(crate) fn time_domain(cells: f64, steps: f64) -> f64 {
    6.0 * 12.5 * cells * steps
}
