//! Isosurface stuffing: the interior of any closed surface, filled with tetrahedra of nearly equal size.
//!
//! A body-centred cubic grid has tetrahedra of one well-shaped form. Each edge of the grid that crosses the
//! surface has a cut point. A grid point with a cut nearby moves onto it. Tetrahedra that are still cut keep
//! their inner part, bounded by the remaining cuts, which is divided again. Since no cuts remain near grid
//! points, no part is a sliver.
//!
//! Source: Labelle and Shewchuk (2007), "Isosurface stuffing: fast tetrahedral meshes with good dihedral
//! angles", with their warping thresholds. Differs: the grid has one size, so walls decide it; inner parts
//! are divided by another rule (`clip`); the midpoints of surface edges move onto the surface; and the result
//! is compared with the input, in volume and in the number of handles and cavities, because a wall thinner
//! than the grid gets holes.

mod clip;

use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::geometry::solid::MeshError;
use clangor_core::geometry::surface_tree::SurfaceTree;
use clangor_core::geometry::topology::Topology;
use clangor_core::geometry::tri_mesh::TriMesh;
use glam::{DVec3, IVec3};

use super::{TetMesh, TetMeshError};
use clip::{Clipped, inner_part};

/// Fraction of a long or a short edge within which a cut attracts its end.
const NEAR_LONG: f64 = 0.249_99;
const NEAR_SHORT: f64 = 0.411_89;
/// Pieces lower than this fraction of the edge are dropped.
const FLAT: f64 = 0.003;
/// Largest relative error of the volume.
const VOLUME_TOLERANCE: f64 = 0.03;
/// Finest grid relative to the wall thickness, and number of refinements.
const GRID_PER_WALL: f64 = 1.05;
const REFINEMENT: f64 = 0.8;
const REFINEMENTS: usize = 3;
/// Most points of a grid.
const MOST_POINTS: f64 = 8e6;

/// Reasons why a surface cannot be filled.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum StuffingError {
    /// Invalid edge length.
    #[error("the edge of the grid is {0} m, but must be positive")]
    Edge(f64),
    /// The surface is not closed, or has no interior.
    #[error("the surface bounds no solid, so it has no inside to mesh: {0}; a shell needs a thickness")]
    Input(MeshError),
    /// The grid would be too large.
    #[error(
        "a grid of {edge:.3e} m, which walls of {wall:.3e} m need, has {points:.1e} points, too many; \
         thicken the walls"
    )]
    TooFine {
        /// Edge \[m\].
        edge: f64,
        /// Thinnest walls \[m\].
        wall: f64,
        /// Points of the grid.
        points: f64,
    },
    /// Unresolved walls.
    #[error(
        "a grid of {edge:.3e} m does not resolve the surface: volume off by {volume_error:.1e}, Euler \
         characteristic {found} instead of {expected}; the thinnest walls are about {wall:.3e} m"
    )]
    Unresolved {
        /// Edge \[m\].
        edge: f64,
        /// Relative error.
        volume_error: f64,
        /// Vertices − edges + faces of the result's surface.
        found: i64,
        /// The same for the input.
        expected: i64,
        /// Thickness \[m\].
        wall: f64,
    },
    /// The pieces do not form a valid mesh.
    #[error("the tetrahedra make no mesh: {0}")]
    Tetrahedra(#[from] TetMeshError),
}

/// Report of a filling.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StuffingReport {
    /// Edge of the grid \[m\].
    pub edge: f64,
    /// Thickness that all but 2 % of the surface exceeds \[m\].
    pub wall: f64,
    /// Relative error of the volume.
    pub volume_error: f64,
}

/// Fills a closed surface with a grid of at most `edge` \[m\], finer where walls require it.
///
/// # Errors
/// [`StuffingError`].
pub fn stuff(surface: &TriMesh, edge: f64) -> Result<(TetMesh, StuffingReport), StuffingError> {
    if !(edge > 0.0 && edge.is_finite()) {
        return Err(StuffingError::Edge(edge));
    }
    // Mass, topology and thinnest wall of the input.
    let mass = MassProperties::of(surface).map_err(StuffingError::Input)?;
    Topology::try_new(surface).map_err(StuffingError::Input)?;
    let tree = SurfaceTree::new(surface);
    let wall = wall_thickness(surface, &tree);
    let expected = euler_characteristic(&surface.triangles);
    let mut edge = edge.min(GRID_PER_WALL * wall);
    let mut failure = StuffingError::Edge(edge);
    // Refine until topology and volume agree with the input.
    for _ in 0..=REFINEMENTS {
        let (low, high) = surface.bounds();
        let points = 2.0 * ((high - low) / edge + 3.0).element_product();
        if points > MOST_POINTS {
            return Err(StuffingError::TooFine { edge, wall, points });
        }
        let Clipped { points, tetrahedra } = Grid::new(surface, &tree, edge).clip();
        if tetrahedra.is_empty() {
            // The whole body lies between the points of the grid.
            failure = StuffingError::Unresolved { edge, volume_error: -1.0, found: 0, expected, wall };
            edge *= REFINEMENT;
            continue;
        }
        // Midpoints of surface edges move to the nearest point of the surface.
        let nearest = |p: DVec3| tree.nearest(surface, p).map_or(p, |n| n.position);
        let mesh = TetMesh::curved(points, &tetrahedra, |middle, _, _| nearest(middle))?;
        // Euler characteristic and volume of the result.
        let faces: Vec<[u32; 3]> = mesh.surface().iter().map(|f| [f[0], f[1], f[2]]).collect();
        let found = euler_characteristic(&faces);
        let volume_error = mesh.quality().volume / mass.volume - 1.0;
        if found == expected && volume_error.abs() <= VOLUME_TOLERANCE {
            return Ok((mesh, StuffingReport { edge, wall, volume_error }));
        }
        failure = StuffingError::Unresolved { edge, volume_error, found, expected, wall };
        edge *= REFINEMENT;
    }
    Err(failure)
}

/// Vertices − edges + faces: 2 for each closed part, less 2 for each handle.
fn euler_characteristic(triangles: &[[u32; 3]]) -> i64 {
    let distinct = |mut keys: Vec<[u32; 2]>| {
        keys.sort_unstable();
        keys.dedup();
        keys.len() as i64
    };
    let vertices = distinct(triangles.iter().flatten().map(|v| [*v, 0]).collect());
    let sides = |t: &[u32; 3]| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]].map(|[a, b]| [a.min(b), a.max(b)]);
    let edges = distinct(triangles.iter().flat_map(sides).collect());
    vertices - edges + triangles.len() as i64
}

/// Thickness along the inward normal that 98 % of the area exceeds \[m\].
pub(crate) fn wall_thickness(surface: &TriMesh, tree: &SurfaceTree) -> f64 {
    wall_quantile(surface, tree, 0.02)
}

/// Thickness along the inward normal that all but a share of the area exceeds \[m\].
pub(crate) fn wall_quantile(surface: &TriMesh, tree: &SurfaceTree, share: f64) -> f64 {
    let slack = 1e-6 * surface.diagonal();
    let mut walls: Vec<(f64, f64)> = (0..surface.triangles.len())
        .map(|t| {
            let area = surface.area_vector(t);
            let inward = -area.normalize_or_zero();
            let through = tree.first_hit(surface, surface.centroid(t), inward, slack);
            (through.unwrap_or(f64::INFINITY), area.length())
        })
        .collect();
    walls.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut rest = share * walls.iter().map(|w| w.1).sum::<f64>();
    walls
        .iter()
        .find(|(_, area)| {
            rest -= area;
            rest <= 0.0
        })
        .map_or(f64::INFINITY, |w| w.0)
}

/// A body-centred cubic grid: two cubic ones, the second shifted by half an edge along each axis.
struct Grid<'a> {
    surface: &'a TriMesh,
    tree: &'a SurfaceTree,
    edge: f64,
    /// Cubes along each axis.
    cells: IVec3,
    positions: Vec<DVec3>,
    /// Depth below the surface \[m\]: positive inside, zero on it.
    depth: Vec<f64>,
}

impl<'a> Grid<'a> {
    fn new(surface: &'a TriMesh, tree: &'a SurfaceTree, edge: f64) -> Self {
        let (low, high) = surface.bounds();
        // One cube of margin on each side, and the middle of the body at the middle of a cube.
        let cells = ((high - low) / edge).ceil().as_ivec3() + IVec3::splat(3);
        let origin = 0.5 * (low + high) - 0.5 * edge * cells.as_dvec3();
        let count = cells + IVec3::ONE;
        let mut positions = Vec::with_capacity(2 * (count.x * count.y * count.z) as usize);
        for half in [0.0, 0.5] {
            for z in 0..count.z {
                for y in 0..count.y {
                    for x in 0..count.x {
                        let at = IVec3::new(x, y, z).as_dvec3() + half;
                        positions.push(origin + edge * at);
                    }
                }
            }
        }
        let far = 2.0 * edge;
        let depth = |p: &DVec3| {
            let depth = -tree.signed_distance(surface, *p).unwrap_or(far);
            // A depth within rounding of the surface is exactly zero.
            if depth.abs() < 1e-6 * edge { 0.0 } else { depth }
        };
        let depth = positions.iter().map(depth).collect();
        Grid { surface, tree, edge, cells, positions, depth }
    }

    /// Number of the point `at` of the first or second cubic grid.
    fn number(&self, half: usize, at: IVec3) -> Option<usize> {
        let count = self.cells + IVec3::ONE;
        let inside = at.cmpge(IVec3::ZERO).all() && at.cmplt(count).all();
        let index = (at.z * count.y + at.y) * count.x + at.x;
        inside.then(|| half * (count.x * count.y * count.z) as usize + index as usize)
    }

    fn place(&self, number: usize) -> (usize, IVec3) {
        let count = self.cells + IVec3::ONE;
        let all = (count.x * count.y * count.z) as usize;
        let (half, index) = (number / all, (number % all) as i32);
        (half, IVec3::new(index % count.x, index / count.x % count.y, index / (count.x * count.y)))
    }

    /// The fourteen neighbours of a point, with a flag for long edges.
    fn neighbours(&self, number: usize) -> impl Iterator<Item = (usize, bool)> {
        let (half, at) = self.place(number);
        let axes = [IVec3::X, IVec3::Y, IVec3::Z];
        let long = axes.into_iter().flat_map(move |a| [self.number(half, at + a), self.number(half, at - a)]);
        // Point i of the second grid is the middle of cube i of the first.
        let shift = if half == 0 { -1 } else { 0 };
        let short = (0..8).map(move |k| {
            let corner = IVec3::new(k & 1, k >> 1 & 1, k >> 2) + shift;
            self.number(1 - half, at + corner)
        });
        long.flatten().map(|n| (n, true)).chain(short.flatten().map(|n| (n, false)))
    }

    /// The point where the edge from an inner to an outer point meets the surface.
    fn cut(&self, inside: usize, outside: usize) -> DVec3 {
        let (from, to) = (self.positions[inside], self.positions[outside]);
        let direction = to - from;
        let hit = self.tree.first_hit(self.surface, from, direction, 0.0).filter(|s| *s < 1.0);
        let by_depth = self.depth[inside] / (self.depth[inside] - self.depth[outside]);
        from + direction * hit.unwrap_or(by_depth)
    }

    /// Warps points onto nearby cuts.
    fn warp(&mut self) {
        for n in 0..self.positions.len() {
            if self.depth[n] == 0.0 || self.depth[n].abs() > self.edge {
                continue;
            }
            let own = self.positions[n];
            let mut nearest: Option<(f64, DVec3)> = None;
            for (other, long) in self.neighbours(n) {
                if self.depth[n] * self.depth[other] >= 0.0 {
                    continue;
                }
                let cut = if self.depth[n] > 0.0 { self.cut(n, other) } else { self.cut(other, n) };
                let away = cut.distance(own);
                let reach = if long { NEAR_LONG } else { NEAR_SHORT * 0.75_f64.sqrt() } * self.edge;
                if away < reach && nearest.is_none_or(|(least, _)| away < least) {
                    nearest = Some((away, cut));
                }
            }
            if let Some((_, cut)) = nearest {
                self.positions[n] = cut;
                self.depth[n] = 0.0;
            }
        }
    }

    /// The inner parts of all tetrahedra.
    fn clip(mut self) -> Clipped {
        // Warp, then compute the remaining cuts.
        self.warp();
        let mut cuts: Vec<([u32; 2], DVec3)> = Vec::new();
        for n in
            (0..self.positions.len()).filter(|n| self.depth[*n] > 0.0 && self.depth[*n] <= 2.0 * self.edge)
        {
            for (other, _) in self.neighbours(n).filter(|(other, _)| self.depth[*other] < 0.0) {
                cuts.push(([n as u32, other as u32], self.cut(n, other)));
            }
        }
        // Number the cut points after the grid points.
        cuts.sort_unstable_by_key(|(pair, _)| *pair);
        let grid_points = self.positions.len();
        let mut points = self.positions.clone();
        points.extend(cuts.iter().map(|(_, p)| *p));
        let cut = |inside: u32, outside: u32| {
            let index = cuts.partition_point(|(pair, _)| *pair < [inside, outside]);
            (grid_points + index) as u32
        };
        let mut clipped = Clipped { points, tetrahedra: Vec::new() };
        // Keep, drop or clip each tetrahedron.
        for tetrahedron in self.tetrahedra() {
            let depth = tetrahedron.map(|n| self.depth[n as usize]);
            if depth.iter().all(|d| *d == 0.0) {
                // All corners were moved: between the two faces of a wall, or flat on the surface.
                let corners = tetrahedron.map(|n| self.positions[n as usize]);
                if self.worth_keeping(corners) {
                    clipped.tetrahedra.push(tetrahedron);
                }
                continue;
            }
            inner_part(&mut clipped, tetrahedron, depth, &cut);
        }
        // A corner that barely missed the surface leaves a flat piece on it, which is dropped. Inside, the
        // gap would appear as a cavity.
        clipped.drop_flatter_than(FLAT * self.edge);
        clipped.compact()
    }

    fn worth_keeping(&self, corners: [DVec3; 4]) -> bool {
        let [a, b, c, d] = corners;
        let height = (b - a).cross(c - a).dot(d - a).abs() / self.edge.powi(2);
        let middle = 0.25 * (a + b + c + d);
        let depth = -self.tree.signed_distance(self.surface, middle).unwrap_or(0.0);
        height > 0.1 * self.edge && depth > 0.02 * self.edge
    }

    /// All tetrahedra that touch the interior: each contains a long edge of each grid, at right angles.
    fn tetrahedra(&self) -> Vec<[u32; 4]> {
        let axes = [IVec3::X, IVec3::Y, IVec3::Z];
        let mut all = Vec::new();
        let half_size = self.positions.len() / 2;
        for n in 0..half_size {
            let (_, at) = self.place(n);
            for k in 0..3 {
                let Some(end) = self.number(0, at + axes[k]) else { continue };
                let (u, v) = (axes[(k + 1) % 3], axes[(k + 2) % 3]);
                let ring = [IVec3::ZERO, -u, -u - v, -v].map(|step| self.number(1, at + step));
                for q in 0..4 {
                    if let (Some(a), Some(b)) = (ring[q], ring[(q + 1) % 4]) {
                        let tetrahedron = [n, end, a, b];
                        let deepest =
                            tetrahedron.iter().map(|n| self.depth[*n]).fold(f64::NEG_INFINITY, f64::max);
                        if deepest >= 0.0 {
                            all.push(tetrahedron.map(|n| n as u32));
                        }
                    }
                }
            }
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use clangor_core::shape::Shape;

    use super::*;

    #[test]
    fn a_ball_and_a_thin_ring_are_filled() {
        let fill = |text: &str, edge: f64| {
            let surface = Shape::parse(text).expect("a shape").mesh();
            stuff(&surface, edge).expect("a fillable surface")
        };
        let (ball, report) = fill("sphere:1@0.1", 0.3);
        let quality = ball.quality();
        assert!((quality.volume / (4.0 / 3.0 * PI) - 1.0).abs() < 0.01 && report.edge == 0.3, "{quality:?}");
        assert!(quality.smallest_angle > 0.1, "{quality:?}");
        // Seen: 2.8 % on a grid of 2.54 mm, 2/3 of the wall.
        let (_, report) = fill("torus:0.02x0.002", 0.01);
        assert!(report.edge < 0.004 && report.volume_error.abs() < VOLUME_TOLERANCE, "{report:?}");
        // Seen: 1.80 %.
        let (_, report) = fill("torus:0.02x0.002", 0.002);
        assert!(report.edge == 0.002 && report.volume_error.abs() < 0.02, "{report:?}");
    }

    #[test]
    fn an_open_surface_is_refused() {
        let mut surface = Shape::parse("sphere:1@0.3").expect("a shape").mesh();
        surface.triangles.pop();
        assert!(matches!(stuff(&surface, 0.3), Err(StuffingError::Input(MeshError::Open { .. }))));
        assert!(matches!(stuff(&surface, 0.0), Err(StuffingError::Edge(_))));
    }
}
