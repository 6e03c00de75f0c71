//! Layout of the arrays of the far pairs: groups of source triangles, blocks of test triangles, fields and
//! sums of a pair.

use clangor_core::sound_model::acceleration::field::RIGID_DOFS;

/// Source triangles per group: the most lanes of any register.
pub(super) const GROUP: usize = 16;

/// Test triangles per block: their sums for one group fit in the first cache.
pub(super) const BLOCK: usize = 64;

/// Fields of a source triangle, each of [`GROUP`] lanes: three points.
pub(super) const POINT: usize = 0;
/// Unit normal.
pub(super) const NORMAL: usize = 9;
/// Area.
pub(super) const AREA: usize = 12;
/// curl of the three shape functions.
pub(super) const CURL: usize = 13;
/// x × n at the three points.
pub(super) const TURNING: usize = 22;
/// Number of fields.
pub(super) const FIELDS: usize = 31;

/// Sums of one test function and one group: both directions, three source functions, real and imaginary part.
pub(super) const SUMS: usize = 12;

/// Real and imaginary parts of the loads of one test function.
pub(super) const LOADS: usize = 2 * RIGID_DOFS;
