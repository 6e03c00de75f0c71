//! Cross-checks: two independent methods agree.

#[expect(dead_code, reason = "parts of it are for other tests")]
#[path = "../baked_bodies/mod.rs"]
mod baked_bodies;
#[path = "../../../clangor-core/tests/compliant_bodies/comparison.rs"]
mod comparison;
#[expect(dead_code, reason = "parts of it are for other tests")]
#[path = "../../../clangor-core/tests/compliant_bodies/mod.rs"]
mod compliant_bodies;
#[path = "../../../clangor-core/tests/compliant_bodies/integrator.rs"]
mod integrator;
#[path = "../solids/plates.rs"]
mod plates;
#[path = "../solids/mod.rs"]
mod solids;

mod axisymmetric_modes;
mod baked_impacts;
mod bem_fdtd;
mod closed_cavities;
mod compact_cells;
mod creased_walls;
mod detect_axisymmetry;
mod draft;
mod first_frequency;
mod many_wavenumbers;
mod mirrored_waves;
mod modal_axisymmetric_bem;
mod modal_bem_fdtd;
mod motion_fits;
mod off_centre_click;
mod perforated_plates;
mod plate_volume;
mod statistical;
mod thin_clicks;
