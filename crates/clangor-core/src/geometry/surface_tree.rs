//! Nearest point of a surface, and inside or outside, in logarithmic time.
//!
//! A binary tree of axis-parallel boxes over the triangles, split at the median of the centroids. The sign of
//! the distance comes from the angle-weighted pseudonormal of the nearest face, edge or vertex, which is
//! right for every closed surface: Bærentzen and Aanæs (2005).

use glam::DVec3;

use super::curvature::vertex_normals;
use super::sharp_place::{JoinedMesh, SharpPlace};
use super::topology::Topology;
use super::tri_mesh::TriMesh;

const LEAF_TRIANGLES: usize = 4;
/// More than the nodes ever waiting: one for each level of a tree over 2³² triangles, split in halves.
const MOST_PENDING: usize = 64;

/// A tree over the triangles of a mesh. It holds no geometry of its own: queries take the mesh that it was
/// built from.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceTree {
    nodes: Vec<Node>,
    /// Triangles in the order of the leaves.
    order: Vec<u32>,
    vertex_normals: Vec<DVec3>,
    /// Empty for a surface that is not closed, which has no inside.
    neighbours: Vec<[u32; 3]>,
}

/// A box, and its triangles `order[start..end]` (leaf) or its children: the next node and `right`.
#[derive(Clone, Debug, PartialEq)]
struct Node {
    low: DVec3,
    high: DVec3,
    start: u32,
    end: u32,
    /// 0 for a leaf.
    right: u32,
}

/// Nodes to be looked at. The tree is as deep as the logarithm of the triangles, so that no memory need be
/// asked for.
struct Stack {
    nodes: [u32; MOST_PENDING],
    count: usize,
}

impl Stack {
    fn of_root() -> Self {
        Stack { nodes: [0; MOST_PENDING], count: 1 }
    }

    fn pop(&mut self) -> Option<u32> {
        self.count = self.count.checked_sub(1)?;
        Some(self.nodes[self.count])
    }

    fn push(&mut self, children: [u32; 2]) {
        self.nodes[self.count..self.count + 2].copy_from_slice(&children);
        self.count += 2;
    }
}

/// The point of a surface nearest to another point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearestPoint {
    /// The triangle.
    pub triangle: usize,
    /// Weights of its corners; they sum to 1.
    pub weights: [f64; 3],
    /// The point \[m\].
    pub position: DVec3,
    /// Distance to it \[m\].
    pub distance: f64,
}

impl SurfaceTree {
    /// Builds the tree of a mesh whose indices are in range.
    pub fn new(mesh: &TriMesh) -> Self {
        let count = mesh.triangles.len();
        let boxes: Vec<(DVec3, DVec3)> = (0..count).map(|t| bounds_of(mesh.corners(t))).collect();
        let mut tree = SurfaceTree {
            nodes: Vec::new(),
            order: (0..count as u32).collect(),
            vertex_normals: vertex_normals(mesh),
            neighbours: Topology::try_new(mesh).map(|t| t.neighbours).unwrap_or_default(),
        };
        if count > 0 {
            tree.build(&boxes, 0, count);
        }
        tree
    }

    fn build(&mut self, boxes: &[(DVec3, DVec3)], start: usize, end: usize) -> u32 {
        let (low, high) = self.order[start..end]
            .iter()
            .map(|t| boxes[*t as usize])
            .reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
            .unwrap_or_default();
        let index = self.nodes.len();
        self.nodes.push(Node { low, high, start: start as u32, end: end as u32, right: 0 });
        if end - start > LEAF_TRIANGLES {
            let extent = high - low;
            let axis = if extent.x >= extent.y.max(extent.z) {
                0
            } else if extent.y >= extent.z {
                1
            } else {
                2
            };
            let middle = (end - start) / 2;
            let key = |t: u32| boxes[t as usize].0[axis] + boxes[t as usize].1[axis];
            self.order[start..end]
                .select_nth_unstable_by(middle, |a, b| key(*a).total_cmp(&key(*b)).then(a.cmp(b)));
            self.build(boxes, start, start + middle);
            self.nodes[index].right = self.build(boxes, start + middle, end);
        }
        index as u32
    }

    /// The point of the surface nearest to `point`; `None` without triangles or where `point` is not finite.
    pub fn nearest(&self, mesh: &TriMesh, point: DVec3) -> Option<NearestPoint> {
        self.nearest_where(mesh, point, f64::INFINITY, |_| true)
    }

    /// The point nearest to `point` on the triangles that `accept` takes, if it is closer than `within`
    /// \[m\].
    pub fn nearest_where(
        &self,
        mesh: &TriMesh,
        point: DVec3,
        within: f64,
        accept: impl Fn(usize) -> bool,
    ) -> Option<NearestPoint> {
        let mut best: Option<NearestPoint> = None;
        let mut limit = within;
        let mut stack = Stack::of_root();
        while let Some(index) = stack.pop() {
            let Some(node) = self.nodes.get(index as usize) else { continue };
            if box_distance(node, point) >= limit {
                continue;
            }
            if node.right != 0 {
                let (left, right) = (index + 1, node.right);
                let near_left = box_distance(&self.nodes[left as usize], point)
                    <= box_distance(&self.nodes[right as usize], point);
                stack.push(if near_left { [right, left] } else { [left, right] });
                continue;
            }
            for t in self.order[node.start as usize..node.end as usize].iter().map(|t| *t as usize) {
                let (weights, position) = nearest_on_triangle(point, mesh.corners(t));
                let distance = position.distance(point);
                if distance < limit && accept(t) {
                    limit = distance;
                    best = Some(NearestPoint { triangle: t, weights, position, distance });
                }
            }
        }
        best
    }

    /// How far along `direction` (a unit vector) the ray from `origin` first meets the surface after `from`
    /// \[m\].
    pub fn first_hit(&self, mesh: &TriMesh, origin: DVec3, direction: DVec3, from: f64) -> Option<f64> {
        let inverse = direction.recip();
        let mut nearest: Option<f64> = None;
        let mut stack = Stack::of_root();
        while let Some(index) = stack.pop() {
            let Some(node) = self.nodes.get(index as usize) else { continue };
            let (a, b) = ((node.low - origin) * inverse, (node.high - origin) * inverse);
            let (enter, leave) = (a.min(b).max_element(), a.max(b).min_element());
            // Written so that the NaN of a ray within the plane of a side passes.
            if enter > leave || leave < from || nearest.is_some_and(|n| enter > n) {
                continue;
            }
            if node.right != 0 {
                stack.push([node.right, index + 1]);
                continue;
            }
            for t in &self.order[node.start as usize..node.end as usize] {
                let hit = along_ray(origin, direction, mesh.corners(*t as usize)).filter(|s| *s > from);
                nearest = [nearest, hit].into_iter().flatten().reduce(f64::min);
            }
        }
        nearest
    }

    /// Distance from the surface \[m\], negative inside; `None` without triangles or where the surface is
    /// open.
    pub fn signed_distance(&self, mesh: &TriMesh, point: DVec3) -> Option<f64> {
        let nearest = self.nearest(mesh, point)?;
        let normal = self.normal_at(mesh, &nearest)?;
        Some(nearest.distance.copysign((point - nearest.position).dot(normal)))
    }

    /// An outward normal at a point of the surface, not of unit length: that of its triangle, of both
    /// triangles on an edge, of all triangles at a vertex by angle. `None` where the surface is open.
    fn normal_at(&self, mesh: &TriMesh, nearest: &NearestPoint) -> Option<DVec3> {
        let neighbours = self.neighbours.get(nearest.triangle)?;
        let corners = mesh.triangles[nearest.triangle];
        let zero = nearest.weights.map(|w| w == 0.0);
        Some(match zero {
            [false, false, false] => mesh.area_vector(nearest.triangle),
            [false, true, true] => self.vertex_normals[corners[0] as usize],
            [true, false, true] => self.vertex_normals[corners[1] as usize],
            [true, true, false] => self.vertex_normals[corners[2] as usize],
            _ => {
                let opposite = zero.iter().position(|z| *z).unwrap_or(0);
                let across = neighbours[(opposite + 1) % 3] as usize;
                mesh.area_vector(nearest.triangle).normalize() + mesh.area_vector(across).normalize()
            }
        })
    }

    /// The unit normal at a point of the surface, linear between those of the vertices; that of the triangle
    /// where they cancel.
    pub fn smooth_normal(&self, mesh: &TriMesh, nearest: &NearestPoint) -> DVec3 {
        let corners = mesh.triangles[nearest.triangle];
        let sum: DVec3 = (0..3).map(|k| nearest.weights[k] * self.vertex_normals[corners[k] as usize]).sum();
        let face = || mesh.area_vector(nearest.triangle).normalize_or(DVec3::Y);
        sum.try_normalize().unwrap_or_else(face)
    }

    /// The crease or corner within `tolerance` \[m\] of a point of the surface; `None` where it is smooth,
    /// and for a surface that is not closed.
    pub fn sharp_place(&self, mesh: &TriMesh, nearest: &NearestPoint, tolerance: f64) -> Option<SharpPlace> {
        self.joined(mesh)?.sharp_place(nearest.triangle, nearest.position, tolerance)
    }

    /// The mesh with the neighbours of its triangles; `None` for a surface that is not closed.
    pub(super) fn joined<'a>(&'a self, mesh: &'a TriMesh) -> Option<JoinedMesh<'a>> {
        (!self.neighbours.is_empty()).then_some(JoinedMesh { mesh, neighbours: &self.neighbours })
    }

    /// The outward unit normal at the point of the surface nearest to `point`; `None` without triangles or
    /// where the surface is open.
    pub fn outward_normal(&self, mesh: &TriMesh, point: DVec3) -> Option<DVec3> {
        self.outward_normal_of(mesh, &self.nearest(mesh, point)?)
    }

    /// The same at a point of the surface that is known.
    pub fn outward_normal_of(&self, mesh: &TriMesh, nearest: &NearestPoint) -> Option<DVec3> {
        self.normal_at(mesh, nearest)?.try_normalize()
    }

    /// Calls `visit` with every pair of triangles whose boxes, grown by `margin` \[m\], overlap, each pair
    /// once.
    pub(super) fn overlapping_pairs(
        &self,
        mesh: &TriMesh,
        margin: f64,
        visit: &mut dyn FnMut(usize, usize) -> bool,
    ) {
        let mut stack = vec![0_u32];
        for t in 0..mesh.triangles.len() {
            let (low, high) = bounds_of(mesh.corners(t));
            let (low, high) = (low - margin, high + margin);
            let apart = |l: DVec3, h: DVec3| l.cmpgt(high).any() || h.cmplt(low).any();
            stack.push(0);
            while let Some(index) = stack.pop() {
                let node = &self.nodes[index as usize];
                if apart(node.low, node.high) {
                    continue;
                }
                if node.right != 0 {
                    stack.extend([index + 1, node.right]);
                    continue;
                }
                for other in &self.order[node.start as usize..node.end as usize] {
                    let other = *other as usize;
                    let (l, h) = bounds_of(mesh.corners(other));
                    if other > t && !apart(l, h) && visit(t, other) {
                        return;
                    }
                }
            }
        }
    }
}

fn bounds_of([a, b, c]: [DVec3; 3]) -> (DVec3, DVec3) {
    (a.min(b).min(c), a.max(b).max(c))
}

fn box_distance(node: &Node, point: DVec3) -> f64 {
    (point - point.clamp(node.low, node.high)).length()
}

/// Where along a ray a triangle lies, borders included.
///
/// Source: Möller and Trumbore (1997), "Fast, Minimum Storage Ray/Triangle Intersection".
fn along_ray(origin: DVec3, direction: DVec3, [a, b, c]: [DVec3; 3]) -> Option<f64> {
    let (ab, ac, ao) = (b - a, c - a, origin - a);
    let across = direction.cross(ac);
    let volume = ab.dot(across);
    let around = ao.cross(ab);
    let (u, v) = (ao.dot(across) / volume, direction.dot(around) / volume);
    let inside = u >= 0.0 && v >= 0.0 && u + v <= 1.0;
    inside.then(|| ac.dot(around) / volume)
}

/// Nearest point of a triangle and its weights; a weight is exactly zero off its corner's edges.
///
/// Source: Ericson, "Real-Time Collision Detection" (2004), section 5.1.5.
fn nearest_on_triangle(p: DVec3, [a, b, c]: [DVec3; 3]) -> ([f64; 3], DVec3) {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return ([1.0, 0.0, 0.0], a);
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return ([0.0, 1.0, 0.0], b);
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let v = d1 / (d1 - d3);
        return ([1.0 - v, v, 0.0], a + ab * v);
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return ([0.0, 0.0, 1.0], c);
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let w = d2 / (d2 - d6);
        return ([1.0 - w, 0.0, w], a + ac * w);
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        let w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return ([0.0, 1.0 - w, w], b + (c - b) * w);
    }
    let sum = va + vb + vc;
    let (v, w) = (vb / sum, vc / sum);
    ([1.0 - v - w, v, w], a + ab * v + ac * w)
}
