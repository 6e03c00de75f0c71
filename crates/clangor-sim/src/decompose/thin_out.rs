//! A few points whose convex hull is close to that of many.
//!
//! First the farthest in evenly spread directions, then, one by one, the point that is farthest outside the
//! hull so far. The hull grows by one point at a time, and the height of every other point above it is
//! renewed only where faces have gone or come.

use std::collections::HashSet;
use std::f64::consts::PI;

use clangor_core::geometry::hull::convex_hull;
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::glam::DVec3;
use parry3d_f64::transformation::try_convex_hull;

/// Points this close to the hull count as on it, over its diagonal.
const ON_HULL: f64 = 1e-6;
/// Height above a face from which a new point sees it, over the diagonal: rounding.
const ROUNDING: f64 = 1e-12;

/// At most `most` points whose hull is close to that of all.
pub(super) fn thin_out(points: &[DVec3], most: usize) -> Vec<DVec3> {
    // Points without volume have no hull; they are dropped later.
    let points = try_convex_hull(points).map_or_else(|_| points.to_vec(), |(corners, _)| corners);
    if points.len() <= most {
        return points;
    }
    let mut kept = spread(&points, most / 2);
    let Ok(hull) = convex_hull(&kept) else { return kept };
    let mut growing = Growing::new(hull, points);
    while kept.len() < most {
        let Some(point) = growing.grow() else { break };
        kept.push(point);
    }
    kept
}

/// The points that are farthest in evenly spread directions.
fn spread(points: &[DVec3], directions: usize) -> Vec<DVec3> {
    let golden_angle = PI * (3.0 - 5.0_f64.sqrt());
    let mut chosen: Vec<usize> = (0..directions)
        .filter_map(|k| {
            let y = 1.0 - (2 * k + 1) as f64 / directions as f64;
            let (sin, cos) = (golden_angle * k as f64).sin_cos();
            let level = (1.0 - y * y).sqrt();
            let direction = DVec3::new(level * cos, y, level * sin);
            let height = |i: &usize| direction.dot(points[*i]);
            (0..points.len()).max_by(|i, j| height(i).total_cmp(&height(j)))
        })
        .collect();
    chosen.sort_unstable();
    chosen.dedup();
    chosen.into_iter().map(|i| points[i]).collect()
}

/// A face of the hull: its corners, and its plane n·x = d.
struct Face {
    corners: [u32; 3],
    normal: DVec3,
    offset: f64,
    /// Number in order of creation.
    name: usize,
}

impl Face {
    fn height(&self, x: DVec3) -> f64 {
        self.normal.dot(x) - self.offset
    }
}

/// A point, its height above the face that it is highest above, and that face.
struct Outside {
    point: DVec3,
    height: f64,
    face: usize,
}

/// A hull, and the points that may still be outside.
struct Growing {
    vertices: Vec<DVec3>,
    faces: Vec<Face>,
    named: usize,
    outside: Vec<Outside>,
    diagonal: f64,
}

impl Growing {
    fn new(hull: TriMesh, points: Vec<DVec3>) -> Self {
        let diagonal = hull.diagonal();
        let mut growing =
            Growing { vertices: hull.vertices, faces: Vec::new(), named: 0, outside: Vec::new(), diagonal };
        hull.triangles.into_iter().for_each(|corners| growing.add_face(corners));
        growing.outside = points.into_iter().map(|point| highest(&growing.faces, point)).collect();
        growing
    }

    fn add_face(&mut self, corners: [u32; 3]) {
        let [a, b, c] = corners.map(|i| self.vertices[i as usize]);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        self.faces.push(Face { corners, normal, offset: normal.dot(a), name: self.named });
        self.named += 1;
    }

    /// Adds the point that is farthest outside; `None` if all are on the hull.
    fn grow(&mut self) -> Option<DVec3> {
        // What is inside stays inside.
        let on_hull = ON_HULL * self.diagonal;
        self.outside.retain(|o| o.height > on_hull);
        let farthest = self.outside.iter().max_by(|a, b| a.height.total_cmp(&b.height))?;
        let point = farthest.point;
        let rounding = ROUNDING * self.diagonal;
        let (seen, hidden): (Vec<Face>, Vec<Face>) =
            std::mem::take(&mut self.faces).into_iter().partition(|face| face.height(point) > rounding);
        self.faces = hidden;
        // The rim of the seen faces: their directed edges whose opposite is not theirs.
        let sides = |f: &Face| {
            let [a, b, c] = f.corners;
            [(a, b), (b, c), (c, a)]
        };
        let edges: HashSet<(u32, u32)> = seen.iter().flat_map(sides).collect();
        let gone: HashSet<usize> = seen.iter().map(|face| face.name).collect();
        let kept = self.faces.len();
        let apex = self.vertices.len() as u32;
        self.vertices.push(point);
        for (u, v) in seen.iter().flat_map(sides).filter(|(u, v)| !edges.contains(&(*v, *u))) {
            self.add_face([u, v, apex]);
        }
        let (faces, new) = (&self.faces, &self.faces[kept..]);
        for outside in &mut self.outside {
            if gone.contains(&outside.face) {
                *outside = highest(faces, outside.point);
                continue;
            }
            let above = highest(new, outside.point);
            if above.height > outside.height {
                *outside = above;
            }
        }
        Some(point)
    }
}

/// A point above the face that it is highest above.
fn highest(faces: &[Face], point: DVec3) -> Outside {
    let start = Outside { point, height: f64::NEG_INFINITY, face: usize::MAX };
    faces.iter().fold(start, |best, face| {
        let height = face.height(point);
        if height > best.height { Outside { point, height, face: face.name } } else { best }
    })
}
