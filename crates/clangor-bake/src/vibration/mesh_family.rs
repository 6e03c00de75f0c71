//! Which meshes a body gets: grids of its own for boxes and ellipsoids, else a filled surface; and how fine.
//!
//! ```text
//! λ = min(√(2π c_p t / (√12 f)), 0.92 c_s / f),    c_p² = E/(ρ (1 − ν²)),    c_s² = μ/ρ
//! ```
//!
//! is the shortest wave at f: of bending in walls of thickness t, or along a surface.

use std::borrow::Cow;
use std::f64::consts::TAU;

use clangor::geometry::hull::convex_hull;
use clangor::geometry::icosahedron::icosahedron;
use clangor::geometry::meridian::Meridian;
use clangor::geometry::surface_tree::SurfaceTree;
use clangor::geometry::tri_mesh::TriMesh;
use clangor::geometry::turning::{Ring, lace};
use glam::DVec3;

use crate::acceleration_noise::BakeGeometry;
use crate::elasticity::ElasticConstants;
use crate::tetrahedra::stuffing::{StuffingError, stuff, wall_thickness};
use crate::tetrahedra::{TetMesh, ball, block};

/// Elements on the shortest wave for an error of about 1 %.
const ELEMENTS_PER_WAVE: f64 = 5.0;
/// Elements along the longest extent at least.
const LEAST_ELEMENTS: f64 = 6.0;

/// Meshes of one body, coarse and fine.
pub(super) struct MeshFamily<'a> {
    form: Filling<'a>,
    /// Longest extent \[m\].
    size: f64,
    /// Thickness of the walls \[m\].
    wall: f64,
}

enum Filling<'a> {
    Ellipsoid(DVec3),
    Block(DVec3),
    Surface(Cow<'a, TriMesh>),
}

/// A mesh, and how fine it is.
pub(super) struct Sized {
    pub(super) mesh: TetMesh,
    /// Edge of its elements \[m\].
    pub(super) edge: f64,
    /// Elements along each direction of a grid of its own.
    cells: [usize; 3],
}

impl<'a> MeshFamily<'a> {
    pub(super) fn of(geometry: &'a BakeGeometry) -> Result<Self, StuffingError> {
        Ok(match geometry {
            BakeGeometry::Ellipsoid { semi_axes } => MeshFamily {
                form: Filling::Ellipsoid(*semi_axes),
                size: 2.0 * semi_axes.max_element(),
                wall: 2.0 * semi_axes.min_element(),
            },
            BakeGeometry::RoundedBox { edges, round: 0.0 } => MeshFamily {
                form: Filling::Block(*edges),
                size: edges.max_element(),
                wall: edges.min_element(),
            },
            BakeGeometry::RoundedBox { edges, round } => {
                Self::of_surface(Cow::Owned(rounded_box(*edges, *round)?))
            }
            BakeGeometry::Revolution(meridian) => Self::of_surface(Cow::Owned(turned(meridian))),
            BakeGeometry::Mesh(mesh) => Self::of_surface(Cow::Borrowed(mesh)),
        })
    }

    fn of_surface(surface: Cow<'a, TriMesh>) -> Self {
        let (low, high) = surface.bounds();
        let wall = wall_thickness(&surface, &SurfaceTree::new(&surface));
        MeshFamily { form: Filling::Surface(surface), size: (high - low).max_element(), wall }
    }

    /// In words.
    pub(super) fn name(&self) -> &'static str {
        match self.form {
            Filling::Ellipsoid(_) => "quadratic tetrahedra in a divided icosahedron",
            Filling::Block(_) => "quadratic tetrahedra in a grid of cells",
            Filling::Surface(_) => "quadratic tetrahedra in a body-centred cubic grid",
        }
    }

    /// Order p at which frequencies converge.
    pub(super) fn order(&self) -> f64 {
        match self.form {
            Filling::Ellipsoid(_) => 4.0,
            // Few layers across a plate miss part of its shear.
            Filling::Block(_) => 3.0,
            // Each grid cuts sharp edges elsewhere.
            Filling::Surface(_) => 2.0,
        }
    }

    /// Edge \[m\] at which frequencies up to `limit` \[Hz\] have about this error.
    pub(super) fn first_edge(&self, constants: &ElasticConstants, limit: f64, accuracy: f64) -> f64 {
        let ElasticConstants { lame_lambda: lambda, shear_modulus: mu, density } = *constants;
        let plate_speed = (4.0 * mu * (lambda + mu) / (lambda + 2.0 * mu) / density).sqrt();
        let bending = (TAU * plate_speed * self.wall / (12.0_f64.sqrt() * limit)).sqrt();
        let wave = bending.min(0.92 * (mu / density).sqrt() / limit);
        let elements = ELEMENTS_PER_WAVE * (0.01 / accuracy).powf(0.25);
        (wave / elements).min(self.size / LEAST_ELEMENTS)
    }

    /// A coarse mesh with elements of about `edge` \[m\].
    pub(super) fn coarse(&self, edge: f64) -> Result<Sized, StuffingError> {
        let count = |length: f64| (length / edge).ceil().max(1.0) as usize;
        match &self.form {
            Filling::Ellipsoid(semi_axes) => self.with_cells([count(semi_axes.max_element()); 3], edge),
            Filling::Block(edges) => self.with_cells(edges.to_array().map(count), edge),
            Filling::Surface(_) => self.with_cells([0; 3], edge),
        }
    }

    /// A mesh finer by about `ratio`, and by no less in any direction.
    pub(super) fn finer(&self, than: &Sized, ratio: f64) -> Result<Sized, StuffingError> {
        let cells = than.cells.map(|n| (n as f64 * ratio - 1e-9).ceil() as usize);
        self.with_cells(cells, than.edge / ratio)
    }

    fn with_cells(&self, cells: [usize; 3], edge: f64) -> Result<Sized, StuffingError> {
        Ok(match &self.form {
            Filling::Ellipsoid(semi_axes) => {
                let edge = semi_axes.max_element() / cells[0] as f64;
                Sized { mesh: ball::ellipsoid(*semi_axes, cells[0])?, edge, cells }
            }
            Filling::Block(edges) => Sized { mesh: block::block(*edges, cells)?, edge, cells },
            Filling::Surface(surface) => {
                let (mesh, report) = stuff(surface, edge)?;
                Sized { mesh, edge: report.edge, cells }
            }
        })
    }
}

/// The hull of a ball in each corner.
fn rounded_box(edges: DVec3, round: f64) -> Result<TriMesh, StuffingError> {
    const DIVISIONS: u32 = 6;
    let corner = 0.5 * edges - round;
    let mut points = Vec::new();
    for [a, b, c] in icosahedron() {
        for (i, j) in (0..=DIVISIONS).flat_map(|i| (0..=DIVISIONS - i).map(move |j| (i, j))) {
            let [u, v] = [i, j].map(|n| f64::from(n) / f64::from(DIVISIONS));
            let direction = (a * u + b * v + c * (1.0 - u - v)).normalize_or_zero().abs();
            let sign = |k: usize, axis: usize| if k >> axis & 1 == 1 { -1.0 } else { 1.0 };
            let signs = (0..8).map(|k| DVec3::from_array([0, 1, 2].map(|axis| sign(k, axis))));
            points.extend(signs.map(|signs| signs * (corner + round * direction)));
        }
    }
    convex_hull(&points).map_err(StuffingError::Input)
}

/// The surface of a body of revolution.
fn turned(meridian: &Meridian) -> TriMesh {
    let edge = meridian.bounding_radius() / 60.0;
    let mut rings = Vec::new();
    for piece in meridian.pieces() {
        let count = (piece.length(0.0, 1.0) / edge).ceil().max(6.0) as usize;
        for k in 0..count {
            let point = piece.point(k as f64 / count as f64);
            let around = if point.x <= 1e-9 * edge { 1 } else { 96 };
            let turns = (0..around).map(|k| f64::from(k) / f64::from(around)).collect();
            rings.push(Ring { radius: point.x, y: point.y, turns });
        }
    }
    if !meridian.is_loop() {
        let last = meridian.pieces().last().map_or(0.0, |p| p.point(1.0).y);
        rings.push(Ring { radius: 0.0, y: last, turns: vec![0.0] });
    }
    lace(&rings, meridian.is_loop())
}
