//! Uneven noisy meshes of shapes: what scanners and careless exports make of a body.
//!
//! The edges of a clean mesh are split, the longest first, by lengths that vary smoothly from place to place
//! by a factor of three and at random; one split in ten takes any edge, and one in fifty cuts off a sliver.
//! Vertices off the creases slide along the surface, and all move along their normals by up to `noise` times
//! the mean edge around them. The body is then turned, scaled and moved. The surface stays closed and free of
//! crossings.
//!
//! The guide is a finer mesh of the same surface, onto which new vertices are projected.

use std::cmp::Ordering;
use std::collections::{BinaryHeap, HashMap};

use clangor_core::geometry::curvature::vertex_normals;
use clangor_core::geometry::surface_tree::SurfaceTree;
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::glam::{DQuat, DVec3};
use clangor_core::math::random::SplitMix;
use clangor_core::shape::{Shape, ShapeError};

/// Triangles of the clean mesh, over those wanted.
const CLEAN_SHARE: f64 = 0.3;
/// Most by which the clean mesh is coarser than the shape's own.
const COARSEST: f64 = 2.0;
/// Edge of the guide over that of the clean mesh, and most triangles of the guide.
const GUIDE_EDGE: f64 = 0.35;
const MOST_GUIDE_TRIANGLES: f64 = 400e3;
/// Share of splits at any edge, and of those that cut off slivers.
const RANDOM_SPLITS: f64 = 0.1;
const SLIVERS: f64 = 0.02;
/// Where along an edge a sliver ends, and how far from the middle the others may be.
const SLIVER_END: f64 = 0.04;
const OFF_MIDDLE: f64 = 0.2;
/// Distance by which vertices slide, over the least height of the triangles around them.
const SLIDE: f64 = 0.2;
/// Most noise over that height: slivers stay clear of their neighbours.
const MOST_NOISE: f64 = 0.3;
/// Cosine of the angle between triangles across an edge from which it is a crease: 25°.
const CREASE: f64 = 0.906;

/// How messy a mesh is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MessyOptions {
    /// Seed of all random choices.
    pub(crate) seed: u64,
    /// Number of triangles, to within one.
    pub(crate) triangles: usize,
    /// Largest displacement along the normal, over the mean edge around a vertex.
    pub(crate) noise: f64,
    /// Range of the factor on all lengths.
    pub(crate) scale: [f64; 2],
}

/// A messy mesh, and how it lies: a vertex is `scale · rotation · x + offset`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MessyMesh {
    /// The mesh.
    pub(crate) mesh: TriMesh,
    /// Factor on all lengths.
    pub(crate) scale: f64,
    /// Rotation of the shape.
    pub(crate) rotation: DQuat,
    /// Place of the origin of the shape \[m\].
    pub(crate) offset: DVec3,
}

/// A messy mesh of a shape of the library.
///
/// # Errors
/// [`ShapeError`] if the text is no shape.
pub(crate) fn messy_shape(text: &str, options: MessyOptions) -> Result<MessyMesh, ShapeError> {
    let shape = Shape::parse(text)?;
    let own = shape.mesh().triangles.len() as f64;
    let wanted = CLEAN_SHARE * options.triangles as f64;
    let edge = shape.edge() * (own / wanted).sqrt().min(COARSEST);
    let clean = shape.clone().with_edge(edge)?;
    let most = (clean.mesh().triangles.len() as f64 / MOST_GUIDE_TRIANGLES).sqrt();
    let guide = shape.with_edge(edge * GUIDE_EDGE.max(most))?;
    Ok(messy_mesh(&clean.mesh(), &guide.mesh(), options))
}

/// A messy mesh of the surface that `clean` and the finer `guide` sample.
pub(crate) fn messy_mesh(clean: &TriMesh, guide: &TriMesh, options: MessyOptions) -> MessyMesh {
    let mut random = SplitMix::new(options.seed);
    let guide = Guide { mesh: guide, tree: SurfaceTree::new(guide) };
    let mut mesh = split(clean, &guide, options.triangles, &mut random);
    displace(&mut mesh, &guide, options.noise, &mut random);
    let scale = random.uniform(options.scale[0], options.scale[1]);
    let rotation = DQuat::from_axis_angle(random.direction(), random.uniform(0.0, std::f64::consts::PI));
    let offset = random.direction() * mesh.diagonal() * scale * random.uniform(0.0, 2.0);
    mesh.vertices.iter_mut().for_each(|v| *v = scale * (rotation * *v) + offset);
    MessyMesh { mesh, scale, rotation, offset }
}

struct Guide<'a> {
    mesh: &'a TriMesh,
    tree: SurfaceTree,
}

impl Guide<'_> {
    /// The point of the surface nearest to `x` that faces as `normal` does; `x` itself if that is further
    /// than `within` \[m\].
    fn project(&self, x: DVec3, normal: DVec3, within: f64) -> DVec3 {
        let faces = |t: usize| self.mesh.area_vector(t).normalize_or_zero().dot(normal) > CREASE;
        self.tree.nearest_where(self.mesh, x, within, faces).map_or(x, |nearest| nearest.position)
    }
}

/// An edge that waits to be split; the longest comes first.
struct Waiting {
    length: f64,
    ends: (u32, u32),
}

impl PartialEq for Waiting {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Waiting {}

impl PartialOrd for Waiting {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Waiting {
    fn cmp(&self, other: &Self) -> Ordering {
        self.length.total_cmp(&other.length).then(self.ends.cmp(&other.ends))
    }
}

/// A closed mesh whose edges can be split.
struct Splitting {
    mesh: TriMesh,
    /// The triangle on the left of each directed edge. Only looked up, never walked.
    left: HashMap<(u32, u32), u32>,
    queue: BinaryHeap<Waiting>,
    /// Waves of the density: direction times wavenumber \[1/m\] and phase.
    waves: Vec<(DVec3, f64)>,
}

impl Splitting {
    fn new(clean: &TriMesh, random: &mut SplitMix) -> Self {
        let size = clean.diagonal().max(f64::MIN_POSITIVE);
        let waves = (0..4)
            .map(|_| (random.direction() * random.uniform(4.0, 16.0) / size, random.uniform(0.0, 6.3)))
            .collect();
        let mut splitting =
            Splitting { mesh: clean.clone(), left: HashMap::new(), queue: BinaryHeap::new(), waves };
        for t in 0..clean.triangles.len() {
            splitting.enter(t, random);
        }
        splitting
    }

    /// Relative density of vertices at a point, from 1 to 3.
    fn density(&self, x: DVec3) -> f64 {
        let sum: f64 = self.waves.iter().map(|(k, phase)| (k.dot(x) + phase).sin()).sum();
        2.0 + (0.6 * sum).tanh()
    }

    /// Takes note of the edges of a triangle.
    fn enter(&mut self, t: usize, random: &mut SplitMix) {
        let corners = self.mesh.triangles[t];
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            self.left.insert((a, b), t as u32);
            let [p, q] = [a, b].map(|i| self.mesh.vertices[i as usize]);
            let length = p.distance(q) * self.density(0.5 * (p + q)) * random.uniform(0.6, 1.0);
            self.queue.push(Waiting { length, ends: (a, b) });
        }
    }

    /// Splits an edge of the mesh at `share` of its length.
    fn split(&mut self, (a, b): (u32, u32), share: f64, guide: &Guide<'_>, random: &mut SplitMix) {
        let (Some(&first), Some(&second)) = (self.left.get(&(a, b)), self.left.get(&(b, a))) else { return };
        let (first, second) = (first as usize, second as usize);
        let normals = [first, second].map(|t| self.mesh.area_vector(t).normalize_or_zero());
        let [p, q] = [a, b].map(|i| self.mesh.vertices[i as usize]);
        let mut x = p.lerp(q, share);
        if normals[0].dot(normals[1]) > CREASE {
            x = guide.project(x, (normals[0] + normals[1]).normalize_or_zero(), 0.2 * p.distance(q));
        }
        let m = self.mesh.vertices.len() as u32;
        self.mesh.vertices.push(x);
        let apex = |t: usize| self.mesh.triangles[t].into_iter().find(|i| *i != a && *i != b).unwrap_or(m);
        let (c, d) = (apex(first), apex(second));
        self.left.remove(&(a, b));
        self.left.remove(&(b, a));
        self.mesh.triangles[first] = [a, m, c];
        self.mesh.triangles[second] = [b, m, d];
        self.mesh.triangles.extend([[m, b, c], [m, a, d]]);
        let count = self.mesh.triangles.len();
        for t in [first, second, count - 2, count - 1] {
            self.enter(t, random);
        }
    }
}

fn split(clean: &TriMesh, guide: &Guide<'_>, triangles: usize, random: &mut SplitMix) -> TriMesh {
    let mut splitting = Splitting::new(clean, random);
    while splitting.mesh.triangles.len() + 1 < triangles {
        let ends = if random.uniform(0.0, 1.0) < RANDOM_SPLITS {
            let t = random.uniform(0.0, splitting.mesh.triangles.len() as f64) as usize;
            let k = random.uniform(0.0, 3.0) as usize;
            let corners = splitting.mesh.triangles[t];
            (corners[k], corners[(k + 1) % 3])
        } else {
            let Some(longest) = splitting.queue.pop() else { break };
            longest.ends
        };
        let share = match random.uniform(0.0, 1.0) < SLIVERS {
            true => SLIVER_END,
            false => 0.5 + random.uniform(-OFF_MIDDLE, OFF_MIDDLE),
        };
        splitting.split(ends, share, guide, random);
    }
    splitting.mesh
}

/// What surrounds a vertex.
#[derive(Clone, Copy)]
struct Around {
    /// Sum of the edges of its triangles \[m\], and their number.
    edges: f64,
    count: f64,
    /// Least height of a triangle \[m\].
    height: f64,
    creased: bool,
}

fn surroundings(mesh: &TriMesh) -> Vec<Around> {
    let unknown = Around { edges: 0.0, count: 0.0, height: f64::INFINITY, creased: false };
    let mut around = vec![unknown; mesh.vertices.len()];
    let mut normal_across: HashMap<(u32, u32), DVec3> = HashMap::new();
    for (t, corners) in mesh.triangles.iter().enumerate() {
        let lengths = [0, 1, 2].map(|k| {
            let [p, q] = [corners[k], corners[(k + 1) % 3]].map(|i| mesh.vertices[i as usize]);
            p.distance(q)
        });
        let area = mesh.area_vector(t);
        let height = 2.0 * area.length() / lengths.iter().fold(0.0, |a: f64, b| a.max(*b));
        let normal = area.normalize_or_zero();
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            for i in [a, b] {
                let v = &mut around[i as usize];
                v.edges += lengths[k];
                v.count += 1.0;
                v.height = v.height.min(height);
            }
            match normal_across.get(&(b, a)) {
                Some(other) if other.dot(normal) < CREASE => {
                    [a, b].iter().for_each(|i| around[*i as usize].creased = true);
                }
                Some(_) => {}
                None => {
                    normal_across.insert((a, b), normal);
                }
            }
        }
    }
    around
}

fn displace(mesh: &mut TriMesh, guide: &Guide<'_>, noise: f64, random: &mut SplitMix) {
    for (i, around) in surroundings(mesh).into_iter().enumerate() {
        let step = random.direction() * SLIDE * around.height;
        if around.creased {
            continue;
        }
        let x = mesh.vertices[i];
        if let Some(nearest) = guide.tree.nearest(guide.mesh, x) {
            let normal = guide.mesh.area_vector(nearest.triangle).normalize_or_zero();
            mesh.vertices[i] = guide.project(x + step - step.dot(normal) * normal, normal, around.edges);
        }
    }
    let normals = vertex_normals(mesh);
    for (i, around) in surroundings(mesh).into_iter().enumerate() {
        let most = (noise * around.edges / around.count.max(1.0)).min(MOST_NOISE * around.height);
        mesh.vertices[i] += normals[i].normalize_or_zero() * random.uniform(-1.0, 1.0) * most;
    }
}
