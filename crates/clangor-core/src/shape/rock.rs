//! Stones: the convex hull of points scattered about a squeezed sphere, scaled to a given volume.

use glam::DVec3;

use crate::geometry::hull::convex_hull;
use crate::geometry::mass_properties::MassProperties;
use crate::geometry::solid::MeshError;
use crate::geometry::tri_mesh::TriMesh;
use crate::math::random::SplitMix;

const POINTS: usize = 60;

/// The stone of a seed with the volume of a ball of radius `radius` \[m\], its centre of mass at the origin.
///
/// Points follow a golden spiral, each pushed by up to a third of the spacing and in or out by up to 12 %;
/// the axes are squeezed to between 0.65 and 1.
pub(super) fn rock_hull(seed: u64, radius: f64) -> Result<TriMesh, MeshError> {
    let mut random = SplitMix::new(seed);
    let squeeze = DVec3::from_array([0.0; 3].map(|_: f64| random.uniform(0.65, 1.0)));
    let golden_angle = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let spacing = (4.0 * std::f64::consts::PI / POINTS as f64).sqrt();
    let points: Vec<DVec3> = (0..POINTS)
        .map(|k| {
            let y = 1.0 - (2 * k + 1) as f64 / POINTS as f64;
            let (sin, cos) = (golden_angle * k as f64).sin_cos();
            let level = (1.0 - y * y).sqrt();
            let push =
                DVec3::from_array([0.0; 3].map(|_: f64| random.uniform(-spacing / 3.0, spacing / 3.0)));
            let direction = (DVec3::new(level * cos, y, level * sin) + push).normalize();
            direction * random.uniform(0.88, 1.0) * squeeze
        })
        .collect();
    let hull = convex_hull(&points)?;
    let mass = MassProperties::of(&hull)?;
    let scale = radius / (0.75 * mass.volume / std::f64::consts::PI).cbrt();
    let vertices = hull.vertices.iter().map(|v| (*v - mass.centre_of_mass) * scale).collect();
    Ok(TriMesh { vertices, triangles: hull.triangles })
}
