//! Convex parts of a mesh that a scene reads from a file, by approximate convex decomposition.
//!
//! A mesh that is convex, or close to it, is its own hull. Any other is cut into voxels and the voxels into
//! clusters (V-HACD: Mamou, "Volumetric hierarchical approximate convex decomposition", Game Engine Gems 3,
//! 2016; the implementation is parry's); the part is the hull of the surface within each cluster. What the
//! parts miss or add is measured, not assumed. Cavities are left out: nothing reaches them.

mod thin_out;

use std::borrow::Cow;

use clangor_core::geometry::components::outer_triangles;
use clangor_core::geometry::convex::ConvexPart;
use clangor_core::geometry::hull::convex_hull;
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::geometry::parts_fit::measure_parts;
use clangor_core::geometry::solid::MeshError;
use clangor_core::geometry::surface_tree::SurfaceTree;
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::glam::{DVec2, DVec3};
use parry3d_f64::transformation::vhacd::{VHACD, VHACDParameters};
use parry3d_f64::transformation::voxelization::FillMode;

use thin_out::thin_out;

/// A single hull that adds more than this share of the volume is rejected without measuring it.
const MOST_ADDED_BY_ONE_HULL: f64 = 0.3;

/// Resolution and limits of a decomposition.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DecomposeSettings {
    /// Voxels along the longest side.
    pub resolution: u32,
    /// Most parts; the decomposition halves, so that powers of two fit best.
    pub most_parts: u32,
    /// One hull is good enough where it adds less than this share of the volume, or nowhere leaves the
    /// surface by this share of the diagonal: shallow hollows, such as the pips of a die, are filled.
    pub tolerance: f64,
    /// Most points per part.
    pub most_points: usize,
    /// Volume that a part may add by convexity, as a share of the whole, before it is cut again.
    pub concavity: f64,
}

const DEFAULT: DecomposeSettings = DecomposeSettings {
    resolution: 100,
    tolerance: 0.03,
    most_parts: 128,
    most_points: 160,
    concavity: 0.001,
};

impl Default for DecomposeSettings {
    fn default() -> Self {
        DEFAULT
    }
}

/// Convex parts and their deviation from the mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Decomposition {
    /// The parts, in the frame of the mesh.
    pub parts: Vec<ConvexPart>,
    /// Largest distance between the surface and that of the parts' union \[m\].
    pub surface_error: f64,
    /// Volume of the union over that of the mesh with its cavities filled, minus 1.
    pub volume_error: f64,
}

/// Why a mesh has no convex parts.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DecomposeError {
    /// The mesh is no solid.
    #[error("the mesh cannot be decomposed: {0}")]
    Mesh(#[from] MeshError),
    /// The decomposition came back empty.
    #[error(
        "the mesh has no convex parts at {resolution} voxels along its longest side; raise the resolution"
    )]
    NoParts {
        /// Voxels along the longest side.
        resolution: u32,
    },
}

/// Convex parts of a closed mesh.
///
/// # Errors
/// [`DecomposeError`] if the mesh is not closed or the decomposition is empty.
pub fn convex_parts(mesh: &TriMesh, settings: DecomposeSettings) -> Result<Decomposition, DecomposeError> {
    let mesh = &*outer_surface(mesh);
    let volume = MassProperties::of(mesh)?.volume;
    let hull = thin_out(&mesh.vertices, settings.most_points);
    // Measuring is slow where the hull deviates much; its volume shows that first.
    let added = convex_hull(&hull).map_or(f64::INFINITY, |hull| union_volume(&[hull]) / volume - 1.0);
    if added < MOST_ADDED_BY_ONE_HULL
        && let Some(whole) = measured(mesh, volume, &[hull])?
        && (added < settings.tolerance || whole.surface_error < 0.3 * settings.tolerance * mesh.diagonal())
    {
        return Ok(whole);
    }
    let clusters = voxel_clusters(mesh, settings);
    measured(mesh, volume, &clusters)?.ok_or(DecomposeError::NoParts { resolution: settings.resolution })
}

/// Resolutions that [`convex_parts_within`] tries, coarse to fine.
const LEVELS: [DecomposeSettings; 4] = [
    DecomposeSettings { resolution: 32, most_parts: 16, concavity: 0.01, ..DEFAULT },
    DecomposeSettings { resolution: 64, most_parts: 64, concavity: 0.003, ..DEFAULT },
    DEFAULT,
    DecomposeSettings { resolution: 160, most_parts: 512, concavity: 0.0003, ..DEFAULT },
];

/// The coarsest convex parts whose surface is within `error` \[m\] of that of a closed mesh: one hull, or the
/// clusters of voxels at rising resolution. If even the finest are farther off, those that are nearest; their
/// [`surface_error`](Decomposition::surface_error) tells.
///
/// # Errors
/// As [`convex_parts`].
pub fn convex_parts_within(mesh: &TriMesh, error: f64) -> Result<Decomposition, DecomposeError> {
    let mesh = &*outer_surface(mesh);
    let volume = MassProperties::of(mesh)?.volume;
    let hull = thin_out(&mesh.vertices, DEFAULT.most_points);
    let mut nearest: Option<Decomposition> = None;
    let groups = std::iter::once_with(|| vec![hull])
        .chain(LEVELS.iter().map(|settings| voxel_clusters(mesh, *settings)));
    for group in groups {
        let Some(found) = measured(mesh, volume, &group)? else { continue };
        if found.surface_error <= error {
            return Ok(found);
        }
        if nearest.as_ref().is_none_or(|best| found.surface_error < best.surface_error) {
            nearest = Some(found);
        }
    }
    nearest.ok_or(DecomposeError::NoParts { resolution: LEVELS[LEVELS.len() - 1].resolution })
}

/// A surface without those of its cavities.
fn outer_surface(mesh: &TriMesh) -> Cow<'_, TriMesh> {
    let Some(outer) = outer_triangles(mesh) else { return Cow::Borrowed(mesh) };
    let kept = mesh.triangles.iter().zip(outer).filter(|(_, outer)| *outer).map(|(triangle, _)| *triangle);
    let outer = TriMesh { vertices: mesh.vertices.clone(), triangles: kept.collect() };
    // Drops the vertices of the cavities.
    Cow::Owned(outer.weld(0.0))
}

/// The hulls of groups of points, compared with the mesh; `None` if all of them are flat.
fn measured(
    mesh: &TriMesh,
    volume: f64,
    groups: &[Vec<DVec3>],
) -> Result<Option<Decomposition>, DecomposeError> {
    let solids: Vec<TriMesh> = groups.iter().filter_map(|points| convex_hull(points).ok()).collect();
    if solids.is_empty() {
        return Ok(None);
    }
    let parts: Vec<ConvexPart> = solids.iter().map(|s| ConvexPart::Hull(s.vertices.clone())).collect();
    let surface_error = measure_parts(mesh, &parts, mesh.diagonal() / 60.0)?.worst();
    let volume_error = union_volume(&solids) / volume - 1.0;
    Ok(Some(Decomposition { parts, surface_error, volume_error }))
}

/// The points of each cluster of voxels.
fn voxel_clusters(mesh: &TriMesh, settings: DecomposeSettings) -> Vec<Vec<DVec3>> {
    let parameters = VHACDParameters {
        resolution: settings.resolution,
        max_convex_hulls: settings.most_parts,
        concavity: settings.concavity,
        fill_mode: FillMode::FloodFill { detect_cavities: false },
        ..VHACDParameters::default()
    };
    let clusters = VHACD::decompose(&parameters, &mesh.vertices, &mesh.triangles, true);
    let tree = SurfaceTree::new(mesh);
    let surface_points = clusters.compute_primitive_intersections(&mesh.vertices, &mesh.triangles);
    let mut points_of = Vec::new();
    for (cluster, mut points) in clusters.voxel_parts().iter().zip(surface_points) {
        // A cut through the interior ends in whole voxels, so that adjacent parts meet.
        let half = 0.5 * cluster.scale;
        for voxel in cluster.voxels().iter().filter(|v| v.is_on_surface) {
            let centre = cluster.get_voxel_point(voxel);
            let inside = tree.signed_distance(mesh, centre).is_some_and(|d| d < -half * 3.0_f64.sqrt());
            if inside {
                let corner = |k: u32| {
                    DVec3::from_array([0, 1, 2].map(|axis| if k >> axis & 1 == 1 { half } else { -half }))
                };
                points.extend((0..8).map(|k| centre + corner(k)));
            }
        }
        points_of.push(thin_out(&points, settings.most_points));
    }
    points_of
}

/// Volume of the union of convex bodies [m³]: exact lengths along parallel lines, the midpoint rule across
/// them.
fn union_volume(solids: &[TriMesh]) -> f64 {
    const LINES: usize = 200;
    let bounds: Vec<(DVec3, DVec3)> = solids.iter().map(TriMesh::bounds).collect();
    let (low, high) = bounds.iter().copied().reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))).unwrap_or_default();
    let plane = |solid: &TriMesh, t: usize| {
        let normal = solid.area_vector(t);
        (normal, normal.dot(solid.corners(t)[0]))
    };
    let planes_of = |solid: &TriMesh| (0..solid.triangles.len()).map(|t| plane(solid, t)).collect();
    let planes: Vec<Vec<(DVec3, f64)>> = solids.iter().map(planes_of).collect();
    let step = DVec2::new(high.y - low.y, high.z - low.z) / LINES as f64;
    let mut sum = 0.0;
    for row in 0..LINES {
        for column in 0..LINES {
            let y = low.y + step.x * (row as f64 + 0.5);
            let z = low.z + step.y * (column as f64 + 0.5);
            let mut spans: Vec<(f64, f64)> = planes
                .iter()
                .zip(&bounds)
                .filter(|(_, (l, h))| (l.y..h.y).contains(&y) && (l.z..h.z).contains(&z))
                .filter_map(|(planes, _)| span_along_x(planes, y, z))
                .collect();
            spans.sort_by(|a, b| a.0.total_cmp(&b.0));
            let mut end = f64::NEG_INFINITY;
            for (from, to) in spans {
                sum += (to - from.max(end)).max(0.0);
                end = end.max(to);
            }
        }
    }
    sum * step.x * step.y
}

/// Interval of x in which the line of given y and z is inside a convex body of these planes n·x = d.
fn span_along_x(planes: &[(DVec3, f64)], y: f64, z: f64) -> Option<(f64, f64)> {
    let (mut from, mut to) = (f64::NEG_INFINITY, f64::INFINITY);
    for (normal, offset) in planes {
        let room = offset - normal.y * y - normal.z * z;
        if normal.x > 0.0 {
            to = to.min(room / normal.x);
        } else if normal.x < 0.0 {
            from = from.max(room / normal.x);
        } else if room < 0.0 {
            return None;
        }
    }
    (from < to).then_some((from, to))
}
