//! Operations of the eigensolver, from the size of its factors.
//!
//! ```text
//! factor      1.25 ( 1.8 M + 270 N )
//! iteration   s factors + 1.45 (3.4 m + 45 s) ( 12 N + 900 n ),    s at least 1 in the last term
//! ```
//!
//! M multiplications and N numbers of a factor, n unknowns, m modes in s slices, which take 45 solves each
//! and 3.4 for each mode. A fifth is order and assembly, and a seventh of the solves finds modes anew.
//! Estimated and measured CPU time [s] of all meshes, of 1300 to 122 000 unknowns at last:
//!
//! ```text
//! spring 61, 71; fork 20, 20; triangle 44, 47; gear 24, 18; mug 64, 60        in cells
//! tuning fork 6.2, 6.7        in prisms
//! wine glass 1.6, 2.1         by its section
//! ```

use crate::fem::elimination::Elimination;

/// Operations for each multiplication and for each number of a factor.
const FACTOR: [f64; 2] = [1.8, 270.0];
/// Operations of a solve for each number of a factor and for each unknown.
const SOLVE: [f64; 2] = [12.0, 900.0];
/// Solves for each mode and for each slice. Seen: 417 for 105 modes, 131 for 20, 61 for 5.
const SOLVES: [f64; 2] = [3.4, 45.0];
/// Work with what is beside factors, and beside solves, in that without.
const BESIDE: f64 = 1.25;
const FOUND_ANEW: f64 = 1.15;

/// A factorisation.
pub(crate) fn factor(structure: &Elimination) -> f64 {
    let fill = structure.fill();
    BESIDE * (FACTOR[0] * fill.multiplications + FACTOR[1] * fill.numbers)
}

/// The iterations of so many slices for so many modes, with their factors; without slices, for the first mode
/// above the band.
pub(crate) fn iteration(structure: &Elimination, slices: usize, modes: usize) -> f64 {
    let each = SOLVE[0] * structure.fill().numbers + SOLVE[1] * structure.size() as f64;
    let solves = SOLVES[0] * modes as f64 + SOLVES[1] * slices.max(1) as f64;
    slices as f64 * factor(structure) + BESIDE * FOUND_ANEW * solves * each
}
