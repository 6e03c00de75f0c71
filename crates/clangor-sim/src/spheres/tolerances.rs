//! Times, speeds and lengths below which the sphere solvers treat a quantity as zero.

/// Shortest flight between two impacts of bodies that are pressed together \[s\].
///
/// Under gravity g it replaces bounces slower than g·CONTACT_TIME/2: 0.25 mm/s on Earth, 200 times below the
/// audible speed ([`crate::record::RecordSettings::v_min`]).
pub(super) const CONTACT_TIME: f64 = 5e-5;
/// Surfaces nearer than this touch \[m\]: ten thousand times the rounding error of a position of 1 m.
pub(super) const TOUCH: f64 = 1e-12;
/// Impacts within this time of each other are simultaneous \[s\].
pub(super) const TIE: f64 = 1e-10;
/// An approach slower than this is rounding error \[m/s\].
pub(super) const QUIET_SPEED: f64 = 1e-11;
/// An acceleration smaller than this does not press bodies together \[m/s²\].
pub(super) const QUIET_ACCELERATION: f64 = 1e-9;
