//! Faces of the surface in a cell, and which of them belong to different walls.
//!
//! A face is a smooth piece of the surface: it ends where the surface turns sharply or with a small radius.
//! Two faces belong to different walls if each lies in front of the other: the sides of an inner edge, the
//! two sides of a slit. They belong to one wall if each lies behind the other (the two sides of a rib), or
//! both in one plane. Fillets are too narrow to be faces: what they join is divided as at a sharp edge. The
//! end of a slit is as narrow, but what is behind it is a wall of its own.
//!
//! The depth below a wall is that below the tangent plane at the nearest point of its faces.

use std::collections::BTreeMap;

use clangor_core::geometry::surface_tree::SurfaceTree;
use clangor_core::geometry::topology::Topology;
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::math::disjoint_sets::DisjointSets;
use glam::DVec3;

use super::division::Division;
use super::grid::CellGrid;
use super::polygon::Polygon;

/// Cosine of the least turn of a sharp edge: 30°.
const SHARP: f64 = 0.866;
/// Radius below which an inner turn, or an outer one, counts as sharp, in cells, and the sine of the least
/// such turn.
const RADIUS: f64 = 0.3;
const OUTER_RADIUS: f64 = 0.1;
const LEAST_TURN: f64 = 0.03;
/// Width of a fillet, in cells, and length of its inner edges, in its own.
const FILLET: f64 = 0.12;
const FILLET_EDGES: f64 = 1.2;
/// Cosine between what lies beyond two inner edges of a strip, below which it is the end of a slit.
const FACING: f64 = -0.5;
/// Sine of the angle above the tangent plane from which on a point is in front, and below which it is
/// behind.
const FRONT: f64 = 0.3;
const BEHIND: f64 = 0.1;
/// Part of the area of a face that must be in front, or behind.
const MOST: f64 = 0.5;
const NEARLY_ALL: f64 = 0.8;
/// Least area of a face in squares of the wall, and most faces of a cell, the largest: noise on a fine mesh
/// makes sharp edges around single triangles.
const LEAST_AREA: f64 = 0.1;
const MOST_FACES: usize = 24;
/// Most pieces of a face that are tested.
const SAMPLES: usize = 24;
/// Distance around a cell from which faces count, in walls, and its limits in cells.
const MARGIN: f64 = 1.3;
const MARGINS: [f64; 2] = [0.05, 0.6];
/// Depth by which walls are set apart, in cells: divisions do not coincide with planes of the grid.
const APART: f64 = 1.7e-7;

/// A surface in units of cells, with what is sharp in it.
pub(super) struct Faces {
    surface: TriMesh,
    /// By triangle and side.
    neighbours: Vec<[u32; 3]>,
    sides: Vec<[Side; 3]>,
    /// Distance around a cell from which faces count.
    margin: f64,
    /// Triangles near each cell.
    near: BTreeMap<[usize; 3], Vec<u32>>,
}

#[derive(Clone, Copy, PartialEq)]
enum Side {
    Smooth,
    Outer,
    Inner,
}

/// A smooth piece of the surface in a cell.
#[derive(Default)]
struct Face {
    area: f64,
    /// Middles and areas of its pieces.
    pieces: Vec<(DVec3, f64)>,
    bounds: Option<(DVec3, DVec3)>,
    /// Length of its inner edges.
    inner: f64,
    /// Normals of the triangles beyond them.
    beyond: Vec<DVec3>,
}

impl Faces {
    /// Faces of a surface with walls of a thickness \[m\], in the cells that are `wanted`; `None` if the
    /// surface is open.
    pub(super) fn new(
        surface: &TriMesh,
        grid: &CellGrid,
        wall: f64,
        wanted: impl Fn([usize; 3]) -> bool,
    ) -> Option<Self> {
        let neighbours = Topology::try_new(surface).ok()?.neighbours;
        let vertices = surface.vertices.iter().map(|v| (*v - grid.origin) / grid.edge).collect();
        let surface = TriMesh { vertices, triangles: surface.triangles.clone() };
        let sides = (0..surface.triangles.len())
            .map(|t| [0, 1, 2].map(|k| side(&surface, t, k, neighbours[t][k] as usize)))
            .collect();
        let margin = (MARGIN * wall / grid.edge).clamp(MARGINS[0], MARGINS[1]);
        let mut faces = Faces { surface, neighbours, sides, margin, near: BTreeMap::new() };
        for t in 0..faces.surface.triangles.len() {
            let triangle = Polygon::triangle(faces.surface.corners(t));
            let (low, high) = triangle.bounds();
            let range = |axis: usize| {
                let first = (low[axis] - margin).floor().max(0.0) as usize;
                let last = ((high[axis] + margin).floor() as usize).min(grid.counts[axis] - 1);
                first..=last
            };
            for place in range(0).flat_map(|i| range(1).flat_map(move |j| range(2).map(move |k| [i, j, k]))) {
                if wanted(place) && !faces.around(&triangle, place).is_empty() {
                    faces.near.entry(place).or_default().push(t as u32);
                }
            }
        }
        Some(faces)
    }

    /// The part of a polygon in a cell and its margin.
    fn around(&self, polygon: &Polygon, place: [usize; 3]) -> Polygon {
        (0..3).fold(*polygon, |polygon, axis| {
            let low = place[axis] as f64;
            polygon.clipped(axis, low - self.margin, 1.0).clipped(axis, low + 1.0 + self.margin, -1.0)
        })
    }

    /// How the walls in a cell divide it; `None` if there is only one.
    pub(super) fn division(&self, place: [usize; 3]) -> Option<Division> {
        let near = self.near.get(&place)?;
        let face_of = self.faces_of(near);
        let count = face_of.iter().max()? + 1;
        if count < 2 {
            return None;
        }
        let faces = self.measured(place, near, &face_of, count);
        let least = LEAST_AREA * (self.margin / MARGIN).powi(2);
        let mut counts: Vec<usize> =
            (0..count).filter(|face| faces[*face].area > least && !faces[*face].is_fillet()).collect();
        counts.sort_by(|a, b| faces[*b].area.total_cmp(&faces[*a].area));
        counts.truncate(MOST_FACES);
        if counts.len() < 2 {
            return None;
        }
        counts.sort_unstable();
        let sheets: Vec<Sheet> = counts
            .iter()
            .map(|face| {
                let own = near.iter().zip(&face_of).filter(|(_, of)| *of == face);
                Sheet::new(own.map(|(t, _)| self.surface.corners(*t as usize)))
            })
            .collect();
        // Sine of the angle from the tangent plane at the nearest point of a face, and the distance there.
        let height = |face: usize, at: DVec3| {
            sheets[face].nearest(at).map_or((0.0, 0.0), |(distance, depth)| {
                (if distance > 0.0 { -depth / distance } else { 0.0 }, distance)
            })
        };
        // Part of face a in front of face b and behind it, and its mean distance.
        let lies = |a: usize, b: usize| {
            let (mut front, mut behind, mut away, mut all) = (0.0, 0.0, 0.0, 0.0);
            for (middle, area) in faces[counts[a]].samples() {
                let (height, distance) = height(b, middle);
                all += area;
                away += area * distance;
                front += if height > FRONT { area } else { 0.0 };
                behind += if height < BEHIND { area } else { 0.0 };
            }
            [front / all, behind / all, away / all]
        };
        let size = counts.len();
        let relation: Vec<Vec<[f64; 3]>> = (0..size)
            .map(|a| (0..size).map(|b| if a == b { [0.0; 3] } else { lies(a, b) }).collect())
            .collect();
        let apart = |a: usize, b: usize| relation[a][b][0].min(relation[b][a][0]) > MOST;
        let together = |a: usize, b: usize| relation[a][b][1].min(relation[b][a][1]) > NEARLY_ALL;
        let meeting: Vec<usize> = (0..size).filter(|a| (0..size).any(|b| b != *a && apart(*a, b))).collect();
        let mut pairs: Vec<[usize; 2]> = meeting
            .iter()
            .flat_map(|a| meeting.iter().map(move |b| [*a, *b]))
            .filter(|[a, b]| a < b && together(*a, *b))
            .collect();
        // The two sides of one wall are nearer to each other than to those of another.
        let distance = |[a, b]: &[usize; 2]| relation[*a][*b][2].min(relation[*b][*a][2]);
        pairs.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
        let walls = grouped(&meeting, &pairs, apart);
        if walls.len() < 2 {
            return None;
        }
        let corner = DVec3::from_array(place.map(|n| n as f64));
        Some(Division::new(walls.len(), |wall, at| {
            let nearest = walls[wall].iter().filter_map(|face| sheets[*face].nearest(at + corner));
            let nearest = nearest.min_by(|a, b| a.0.total_cmp(&b.0));
            nearest.map_or(f64::NEG_INFINITY, |(_, depth)| APART * (wall * wall) as f64 + depth)
        }))
    }

    /// The face of each of some triangles, from 0.
    fn faces_of(&self, near: &[u32]) -> Vec<usize> {
        let mut faces = DisjointSets::new(near.len());
        for (k, t) in near.iter().enumerate() {
            for side in 0..3 {
                if self.sides[*t as usize][side] == Side::Smooth
                    && let Ok(other) = near.binary_search(&self.neighbours[*t as usize][side])
                {
                    faces.join(k, other);
                }
            }
        }
        let mut numbers = BTreeMap::new();
        (0..near.len())
            .map(|k| {
                let next = numbers.len();
                *numbers.entry(faces.root(k)).or_insert(next)
            })
            .collect()
    }

    fn measured(&self, place: [usize; 3], near: &[u32], face_of: &[usize], count: usize) -> Vec<Face> {
        let mut faces: Vec<Face> = (0..count).map(|_| Face::default()).collect();
        for (t, face) in near.iter().zip(face_of) {
            let (t, face) = (*t as usize, &mut faces[*face]);
            let piece = self.around(&Polygon::triangle(self.surface.corners(t)), place);
            let (middle, area) = piece.middle_and_area();
            face.area += area;
            face.pieces.push((middle, area));
            let (low, high) = piece.bounds();
            let (least, most) = face.bounds.unwrap_or((low, high));
            face.bounds = Some((least.min(low), most.max(high)));
            for k in (0..3).filter(|k| self.sides[t][*k] == Side::Inner) {
                let [a, b] = [k, (k + 1) % 3].map(|k| self.surface.corners(t)[k]);
                let side = self.around(&Polygon::triangle([a, b, b]), place);
                let (low, high) = side.bounds();
                if !side.is_empty() {
                    let other = self.neighbours[t][k] as usize;
                    face.inner += high.distance(low);
                    face.beyond.push(self.surface.area_vector(other).normalize_or_zero());
                }
            }
        }
        faces
    }
}

/// The triangles of a face.
struct Sheet {
    mesh: TriMesh,
    tree: SurfaceTree,
}

impl Sheet {
    fn new(corners: impl Iterator<Item = [DVec3; 3]>) -> Self {
        let vertices: Vec<DVec3> = corners.flatten().collect();
        let triangles = (0..vertices.len() as u32 / 3).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        let mesh = TriMesh { vertices, triangles };
        Sheet { tree: SurfaceTree::new(&mesh), mesh }
    }

    /// Distance of the nearest point, and depth below the tangent plane there.
    fn nearest(&self, at: DVec3) -> Option<(f64, f64)> {
        let nearest = self.tree.nearest(&self.mesh, at)?;
        let normal = self.mesh.area_vector(nearest.triangle).normalize_or_zero();
        Some((nearest.distance, -normal.dot(at - nearest.position)))
    }
}

impl Face {
    /// Whether it is a strip between inner edges, beyond which the surface does not face itself.
    fn is_fillet(&self) -> bool {
        let length = self.bounds.map_or(0.0, |(low, high)| high.distance(low));
        let is_strip = self.area < FILLET * length && self.inner > FILLET_EDGES * length;
        is_strip && !self.beyond.iter().any(|a| self.beyond.iter().any(|b| a.dot(*b) < FACING))
    }

    fn samples(&self) -> impl Iterator<Item = (DVec3, f64)> {
        self.pieces.iter().copied().step_by(self.pieces.len().div_ceil(SAMPLES).max(1))
    }
}

/// Sets of faces that belong together, none of which are apart.
fn grouped(faces: &[usize], pairs: &[[usize; 2]], apart: impl Fn(usize, usize) -> bool) -> Vec<Vec<usize>> {
    let mut sets: Vec<Vec<usize>> = faces.iter().map(|face| vec![*face]).collect();
    for pair in pairs {
        let [a, b] = pair.map(|face| sets.iter().position(|set| set.contains(&face)).unwrap_or(0));
        if a != b && !sets[a].iter().any(|x| sets[b].iter().any(|y| apart(*x, *y))) {
            let set = sets.remove(a.max(b));
            sets[a.min(b)].extend(set);
        }
    }
    sets
}

/// What side k of a triangle is, with a neighbour across it.
fn side(surface: &TriMesh, t: usize, k: usize, other: usize) -> Side {
    let [first, second] = [t, other].map(|t| surface.area_vector(t));
    let (areas, normals) =
        ([first.length(), second.length()], [first.normalize_or_zero(), second.normalize_or_zero()]);
    let [a, b] = [k, (k + 1) % 3].map(|k| surface.corners(t)[k]);
    let turn = normals[0].cross(normals[1]).length();
    let cosine = normals[0].dot(normals[1]);
    // Mean height of both triangles above the side.
    let width = (areas[0] + areas[1]) / a.distance(b);
    let inner = (surface.centroid(other) - surface.centroid(t)).dot(normals[0]) > 0.0;
    let tight = turn > LEAST_TURN && turn * if inner { RADIUS } else { OUTER_RADIUS } > width;
    if areas[0] == 0.0 || areas[1] == 0.0 || !(cosine < SHARP || tight) {
        return Side::Smooth;
    }
    if inner { Side::Inner } else { Side::Outer }
}
