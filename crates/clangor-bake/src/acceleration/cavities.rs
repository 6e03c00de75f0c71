//! Whether a body encloses air that resonates: by the part of its convex hull that it leaves empty.

use clangor_core::geometry::hull::extreme_hull;
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::geometry::tri_mesh::TriMesh;

/// A body that fills less than this fraction of its hull has cavities, or is a bent plate.
const CONVEX: f64 = 0.7;
/// Directions that sample the hull: its volume to one or two per cent.
const HULL_DIRECTIONS: usize = 300;

/// Whether a body leaves a large part of its convex hull empty.
pub(crate) fn has_cavities(mesh: &TriMesh, mass: &MassProperties) -> bool {
    let hull = extreme_hull(mesh, HULL_DIRECTIONS).and_then(|hull| MassProperties::of(&hull));
    hull.is_ok_and(|hull| mass.volume < CONVEX * hull.volume)
}
