//! Bodies filled with tetrahedra: by grids of their own for boxes and ellipsoids, else by a grid cut at the surface.

use std::borrow::Cow;

use clangor::geometry::hull::convex_hull;
use clangor::geometry::icosahedron::icosahedron;
use clangor::geometry::surface_tree::SurfaceTree;
use clangor::geometry::tri_mesh::TriMesh;
use clangor::model::modal_surface::ModalSurface;
use glam::DVec3;

use super::{Divisible, Spectrum, VibrationError, shortest_wave};
use crate::acceleration_noise::BakeGeometry;
use crate::elasticity::{ElasticConstants, ElasticSystem};
use crate::modes::{ModalError, Mode, solve};
use crate::tetrahedra::stuffing::{StuffingError, stuff, wall_thickness};
use crate::tetrahedra::{TetMesh, ball, block};

/// Elements on the shortest wave for an error of about 1 %.
const ELEMENTS_PER_WAVE: f64 = 5.0;
/// Thickness of walls over the longest extent that counts as thin.
const THIN: f64 = 0.1;
/// Elements along the longest extent at least.
const LEAST_ELEMENTS: f64 = 6.0;

/// A grid that loses too much of the body is made finer by this, so often.
const COARSE_STEP: f64 = 0.55;
const COARSE_TRIALS: i32 = 3;

/// A body, and what decides how fine its meshes must be.
pub(super) struct FilledBody<'a> {
    form: Filling<'a>,
    constants: &'a ElasticConstants,
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
pub(super) struct Filled {
    mesh: TetMesh,
    /// Edge of its elements \[m\].
    edge: f64,
    /// Elements along each direction of a grid of its own.
    cells: [usize; 3],
}

impl<'a> FilledBody<'a> {
    /// Bodies of revolution, which have something better, are not for this.
    pub(super) fn of(
        geometry: &'a BakeGeometry,
        constants: &'a ElasticConstants,
    ) -> Result<Self, VibrationError> {
        Ok(match geometry {
            BakeGeometry::Ellipsoid { semi_axes } => FilledBody {
                form: Filling::Ellipsoid(*semi_axes),
                constants,
                size: 2.0 * semi_axes.max_element(),
                wall: 2.0 * semi_axes.min_element(),
            },
            BakeGeometry::RoundedBox { edges, round: 0.0 } => FilledBody {
                form: Filling::Block(*edges),
                constants,
                size: edges.max_element(),
                wall: edges.min_element(),
            },
            BakeGeometry::RoundedBox { edges, round } => {
                Self::of_surface(Cow::Owned(rounded_box(*edges, *round)?), constants)
            }
            BakeGeometry::Mesh(mesh) => Self::of_surface(Cow::Borrowed(mesh), constants),
            BakeGeometry::Revolution(_) => return Err(VibrationError::Section),
        })
    }

    fn of_surface(surface: Cow<'a, TriMesh>, constants: &'a ElasticConstants) -> Self {
        let (low, high) = surface.bounds();
        let wall = wall_thickness(&surface, &SurfaceTree::new(&surface));
        FilledBody { form: Filling::Surface(surface), constants, size: (high - low).max_element(), wall }
    }

    fn with_cells(&self, cells: [usize; 3], edge: f64) -> Result<Filled, VibrationError> {
        let broken = StuffingError::from;
        Ok(match &self.form {
            Filling::Ellipsoid(semi_axes) => {
                let edge = semi_axes.max_element() / cells[0] as f64;
                Filled { mesh: ball::ellipsoid(*semi_axes, cells[0]).map_err(broken)?, edge, cells }
            }
            Filling::Block(edges) => {
                Filled { mesh: block::block(*edges, cells).map_err(broken)?, edge, cells }
            }
            Filling::Surface(surface) => {
                let (mesh, report) = stuff(surface, edge)?;
                match mesh.parts() {
                    1 => Filled { mesh, edge: report.edge, cells },
                    parts => return Err(VibrationError::LooseParts(parts)),
                }
            }
        })
    }
}

impl Divisible for FilledBody<'_> {
    type Mesh = Filled;
    type Modes = Vec<Mode>;

    fn method(&self) -> &'static str {
        match self.form {
            Filling::Ellipsoid(_) => "quadratic tetrahedra in a divided icosahedron",
            Filling::Block(_) => "quadratic tetrahedra in a grid of cells",
            Filling::Surface(_) => "quadratic tetrahedra in a body-centred cubic grid",
        }
    }

    fn convergence(&self) -> f64 {
        match self.form {
            Filling::Ellipsoid(_) => 4.0,
            // Few layers across a plate miss part of its shear.
            Filling::Block(_) => 3.0,
            // Each grid cuts sharp edges elsewhere.
            Filling::Surface(_) => 2.0,
        }
    }

    fn first_ratio(&self) -> f64 {
        match self.form {
            // Walls already demand a grid that is finer than waves do.
            Filling::Surface(_) if self.wall < THIN * self.size => 1.25,
            _ => 1.5,
        }
    }

    fn coarse(&self, limit: f64, accuracy: f64) -> Result<Filled, VibrationError> {
        let elements = ELEMENTS_PER_WAVE * (0.01 / accuracy).powf(0.25);
        let wave = shortest_wave(self.constants, self.wall, limit);
        let edge = self.first_ratio() * (wave / elements).min(self.size / LEAST_ELEMENTS);
        let count = |length: f64| (length / edge).ceil().max(1.0) as usize;
        match &self.form {
            Filling::Ellipsoid(semi_axes) => self.with_cells([count(semi_axes.max_element()); 3], edge),
            Filling::Block(edges) => self.with_cells(edges.to_array().map(count), edge),
            Filling::Surface(_) => {
                // Bodies with sharp edges lose much of their volume on a coarse grid.
                let mut trial = self.with_cells([0; 3], edge);
                for k in 1..COARSE_TRIALS {
                    match trial {
                        Err(VibrationError::Mesh(StuffingError::Unresolved { .. })) => {
                            trial = self.with_cells([0; 3], edge * COARSE_STEP.powi(k));
                        }
                        _ => break,
                    }
                }
                trial
            }
        }
    }

    fn finer(&self, than: &Filled, ratio: f64) -> Result<Filled, VibrationError> {
        let cells = than.cells.map(|n| (n as f64 * ratio - 1e-9).ceil() as usize);
        self.with_cells(cells, than.edge / ratio)
    }

    fn size(&self, mesh: &Filled) -> (usize, f64) {
        (mesh.mesh.nodes.len(), mesh.edge)
    }

    fn solve(&self, mesh: &Filled, limit: f64) -> Result<Spectrum<Vec<Mode>>, ModalError> {
        match solve(&ElasticSystem::new(&mesh.mesh, self.constants), limit) {
            Ok(found) => Ok(Spectrum {
                frequencies: found.modes.iter().map(|m| m.frequency).collect(),
                first: found.modes.first().map_or(f64::INFINITY, |m| m.frequency),
                residual: found.residual,
                modes: found.modes,
            }),
            // A finer mesh may have some.
            Err(ModalError::Silent { first, .. }) => {
                Ok(Spectrum { frequencies: Vec::new(), first, residual: 0.0, modes: Vec::new() })
            }
            Err(error) => Err(error),
        }
    }

    fn system(&self, mesh: &Filled) -> Option<ElasticSystem> {
        Some(ElasticSystem::new(&mesh.mesh, self.constants))
    }

    fn shapes(&self, mesh: &Filled, modes: &Vec<Mode>, count: usize) -> (ModalSurface, Vec<Vec<DVec3>>) {
        let mut triangles = mesh.mesh.surface();
        let mut kept: Vec<u32> = triangles.iter().flatten().copied().collect();
        kept.sort_unstable();
        kept.dedup();
        for node in triangles.iter_mut().flatten() {
            *node = kept.partition_point(|k| *k < *node) as u32;
        }
        let on_surface = |all: &[DVec3]| -> Vec<DVec3> { kept.iter().map(|n| all[*n as usize]).collect() };
        let surface = ModalSurface { nodes: on_surface(&mesh.mesh.nodes), triangles };
        (surface, modes.iter().take(count).map(|m| on_surface(&m.shape)).collect())
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
