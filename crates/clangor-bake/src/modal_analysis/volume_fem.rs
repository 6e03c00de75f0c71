//! Volume finite elements on meshes: boxes with hexahedra, flat plates with prisms, ellipsoids with
//! tetrahedra of a structured grid. All other closed surfaces are in cells
//! ([`immersed_body`](super::immersed_body)).
//!
//! Plates have one cell through the thickness where waves are long. Its displacements are quadratic, so the
//! shear stress through the thickness is constant instead of parabolic, which raises a frequency by about
//! 0.02 (2π t/λ)², t the thickness and λ the wavelength. Above five cells per wavelength, two cells of order
//! 4 remove this error.

use std::f64::consts::PI;

use clangor_core::sound_model::modal::surface::ModalSurface;
use glam::DVec3;

use super::mirror_parities::{MirrorParities, PartNodes};
use super::mirrored_box::MirroredBox;
use super::plate_mesh::plate_mesh;
use super::plate_sizes::{CornerSizes, PlateSizes, error_at_corners};
use super::{
    Finer, ModalAnalysisError, ModalAnalysisOptions, RefinableDiscretization, Spectrum, shortest_wave,
};
use crate::cost::work_limit::WorkLimit;
use crate::fem::across_walls::Unknowns;
use crate::fem::bricks::box_of_bricks;
use crate::fem::prisms::{Prisms, plate_of_prisms};
use crate::fem::supports::{Holding, Support, SupportError, SupportKind};
use crate::fem::{ElasticConstants, ElasticSystem};
use crate::geometry_class::flat_plate::FlatPlate;
use crate::mesh::tetrahedra::isosurface_stuffing::StuffingError;
use crate::mesh::tetrahedra::{TetMesh, ball, block};
use crate::modal_analysis::eigensolver::{ModalError, Mode};

/// Elements per shortest wavelength for an error of about 1 %.
const ELEMENTS_PER_WAVE: f64 = 5.0;
/// Least number of elements along the longest extent.
const LEAST_ELEMENTS: f64 = 6.0;
/// Largest thickness of a box with one cell, in the edge length for the waves.
const ONE_CELL: f64 = 0.2;

/// Tetrahedra of a ball before even division.
const ICOSAHEDRON_FACES: f64 = 20.0;
/// Nodes per tetrahedron far from the surface; near it there are more.
const NODES_PER_TETRAHEDRON: f64 = 4.0 / 3.0;

/// Most sides of the coarse mesh of a plate at its inner corners, over the lengths of the outline there: the
/// first that needs at most a part of all nodes.
const AT_CORNERS: [f64; 4] = [1.0, 4.0, 16.0, 64.0];
const COARSE_PART: f64 = 0.15;

/// Largest part of the error at inner corners that counts as left by a finer mesh, which may be no finer
/// there.
const MOST_LEFT: f64 = 0.9;

/// Nodes of a level per triangle of a plate.
const NODES_PER_PLATE_ELEMENT: f64 = 9.0;

/// A body, and the lengths that set its mesh size.
pub(super) struct VolumeFem<'a> {
    form: Filling,
    constants: &'a ElasticConstants,
    /// Longest extent \[m\].
    size: f64,
    /// Thickness of the walls \[m\].
    wall: f64,
    /// Volume \[m³\].
    volume: f64,
    /// Most nodes of a mesh.
    most_nodes: usize,
    /// What holds the body; empty if it is free.
    supports: &'a [Support],
}

/// What is filled with elements.
pub(super) enum Filling {
    /// Semi-axes \[m\].
    Ellipsoid(DVec3),
    /// Full edges \[m\].
    Block(DVec3),
    Plate(FlatPlate),
}

/// A mesh and its resolution.
pub(super) struct Filled {
    mesh: TetMesh,
    /// Edge of its elements \[m\].
    edge: f64,
    /// Elements along each direction of a structured grid.
    cells: [usize; 3],
    /// Sizes at the inner corners of a plate.
    at_corners: CornerSizes,
    /// Σ s h at these corners \[m²\], in proportion to the error; 0 without any.
    corner_error: f64,
    /// Part of the errors on the mesh before that is left, if more than convergence says.
    share: Option<f64>,
    /// The solved part of a box.
    part: Option<TetMesh>,
    /// The elements of a plate.
    prisms: Option<Prisms>,
}

impl<'a> VolumeFem<'a> {
    pub(super) fn new(form: Filling, constants: &'a ElasticConstants, most_nodes: usize) -> Self {
        let (size, wall, volume) = match &form {
            Filling::Ellipsoid(semi_axes) => (
                2.0 * semi_axes.max_element(),
                2.0 * semi_axes.min_element(),
                4.0 / 3.0 * PI * semi_axes.element_product(),
            ),
            Filling::Block(edges) => (edges.max_element(), edges.min_element(), edges.element_product()),
            Filling::Plate(plate) => (plate.longest(), plate.thickness, plate.area() * plate.thickness),
        };
        VolumeFem { form, constants, size, wall, volume, most_nodes, supports: &[] }
    }

    /// The same body, held.
    pub(super) fn held_by(self, supports: &'a [Support]) -> Self {
        VolumeFem { supports, ..self }
    }

    fn clamps(&self) -> impl Iterator<Item = &Support> {
        self.supports.iter().filter(|support| support.kind == SupportKind::Clamped)
    }

    /// Cells of a box, up to half as many more, such that clamps end close to nodes between elements.
    fn aligned(&self, cells: [usize; 3]) -> [usize; 3] {
        let Filling::Block(edges) = self.form else { return cells };
        std::array::from_fn(|a| {
            let ends: Vec<f64> = (self.clamps().flat_map(|clamp| clamp.region.ends(a)))
                .map(|end| end / edges[a] + 0.5)
                .filter(|end| *end > 0.0 && *end < 1.0)
                .collect();
            if cells[a] < 4 || ends.is_empty() {
                return cells[a];
            }
            let misfit = |count: usize| {
                let off = |end: &f64| {
                    let place = end * (count / 2) as f64;
                    (place - place.round()).abs() / count as f64
                };
                ends.iter().map(off).fold(0.0, f64::max)
            };
            let counts = (cells[a]..=cells[a] + cells[a] / 2).step_by(2);
            let close = counts.map(|count| (count, misfit(count)));
            close.min_by(|x, y| x.1.total_cmp(&y.1)).map_or(cells[a], |(count, _)| count)
        })
    }

    fn assembled(&self, mesh: &Filled) -> ElasticSystem {
        let unknowns = if self.supports.is_empty() { Unknowns::AcrossWalls } else { Unknowns::AtNodes };
        match (&self.form, &mesh.prisms) {
            (Filling::Block(edges), _) => {
                box_of_bricks(&mesh.mesh, *edges, mesh.cells, self.constants, unknowns)
            }
            (_, Some(prisms)) => plate_of_prisms(prisms, &mesh.mesh.nodes, self.constants, unknowns),
            _ => ElasticSystem::new(&mesh.mesh, self.constants),
        }
    }

    /// Elements and nodes of a mesh before it is made: exact for a box, an upper estimate for others.
    fn expected(&self, cells: [usize; 3], edge: f64, at_corners: CornerSizes) -> [f64; 2] {
        let cells = cells.map(|n| n as f64);
        match &self.form {
            Filling::Ellipsoid(_) => {
                let elements = ICOSAHEDRON_FACES * cells[0].powi(3);
                [elements, NODES_PER_TETRAHEDRON * elements]
            }
            Filling::Block(_) => [cells.iter().product(), cells.iter().map(|n| 2.0 * n + 1.0).product()],
            Filling::Plate(plate) => {
                // Triangles with sides of two edges, and eight nodes each on every level.
                let even = self.volume / self.wall / (3.0_f64.sqrt() * edge * edge);
                let elements = even + PlateSizes::new(plate, 2.0 * edge, at_corners).around_corners();
                [
                    elements,
                    NODES_PER_PLATE_ELEMENT * (2 * cells_across(self.wall, edge) + 1) as f64 * elements,
                ]
            }
        }
    }

    /// The edge of the coarse mesh of a plate that waves want as short \[m\], and sizes at its corners.
    fn plate_sizes(&self, plate: &FlatPlate, edge: f64) -> (f64, CornerSizes) {
        // Finer across arms too, at whose edges torsion varies over the thickness.
        let edge = edge.min(0.5 * plate.mean_width());
        let [first @ .., last] = &AT_CORNERS;
        let part = COARSE_PART * self.most_nodes as f64;
        let at = |of_sides: &f64| CornerSizes { of_sides: *of_sides, coarsest: 2.0 * edge, part: 1.0 };
        let fits = |of_sides: &&f64| self.expected([0; 3], edge, at(of_sides))[1] <= part;
        (edge, at(first.iter().find(fits).unwrap_or(last)))
    }

    /// The longest edge of the coarse mesh \[m\] for waves up to a limit \[Hz\].
    fn coarse_edge(&self, limit: f64, accuracy: f64) -> f64 {
        let elements = ELEMENTS_PER_WAVE * (0.01 / accuracy).powf(0.25);
        let wave = shortest_wave(self.constants, self.wall, limit);
        self.first_ratio() * (wave / elements).min(self.size / LEAST_ELEMENTS)
    }

    fn with_cells(
        &self,
        cells: [usize; 3],
        edge: f64,
        at_corners: CornerSizes,
    ) -> Result<Filled, ModalAnalysisError> {
        let broken = StuffingError::from;
        let cells = self.aligned(cells);
        let [elements, nodes] = self.expected(cells, edge, at_corners);
        if nodes > self.most_nodes as f64 {
            let (wall, most) = (self.wall, self.most_nodes);
            return Err(ModalAnalysisError::TooFine { wall, edge, elements, nodes, most });
        }
        let filled = |mesh, edge| {
            let (corner_error, share, part, prisms) = (0.0, None, None, None);
            Filled { mesh, edge, cells, at_corners, corner_error, share, part, prisms }
        };
        Ok(match &self.form {
            Filling::Ellipsoid(semi_axes) => {
                let edge = semi_axes.max_element() / cells[0] as f64;
                let mesh = ball::ellipsoid(*semi_axes, cells[0]).map_err(broken)?;
                filled(mesh, edge)
            }
            Filling::Plate(plate) => {
                let sizes = PlateSizes::new(plate, 2.0 * edge, at_corners);
                let (mesh, prisms) =
                    plate_mesh(plate, &sizes, cells_across(self.wall, edge)).map_err(broken)?;
                let corner_error = error_at_corners(&plate.outline, &prisms.corners);
                Filled { corner_error, prisms: Some(prisms), ..filled(mesh, edge) }
            }
            Filling::Block(edges) => {
                let mirrored = MirroredBox { edges: *edges, cells, constants: self.constants };
                let part = Some(mirrored.part().map_err(broken)?);
                let edge = (0..3).map(|a| edges[a] / cells[a] as f64).fold(0.0, f64::max);
                let mesh = block::block(*edges, cells).map_err(broken)?;
                Filled { part, ..filled(mesh, edge) }
            }
        })
    }
}

/// Cells across a plate for elements of an edge length: one, of second order, where it is thin.
fn cells_across(wall: f64, edge: f64) -> usize {
    if wall <= ONE_CELL * edge { 1 } else { 2 }
}

/// Cells along the axes of a box for elements of an edge length, or finer: one, two, or a multiple that
/// mirror planes can divide.
fn box_cells(edges: DVec3, edge: f64) -> [usize; 3] {
    edges.to_array().map(|length| match length / edge {
        cells if cells <= ONE_CELL => 1,
        cells if cells <= 2.0 => 2,
        cells => 4 * (0.25 * cells - 1e-9).ceil() as usize,
    })
}

/// The next such number.
fn more_cells(cells: usize) -> usize {
    if cells == 1 { 2 } else { 4 * (cells / 4 + 1) }
}

impl RefinableDiscretization for VolumeFem<'_> {
    type Mesh = Filled;
    type Modes = Vec<Mode>;

    fn method(&self) -> &'static str {
        match self.form {
            Filling::Ellipsoid(_) => "quadratic tetrahedra in a divided icosahedron",
            Filling::Block(_) => "bricks of fourth order, of second across where thin",
            Filling::Plate(_) => "prisms of fourth order, of second across where thin",
        }
    }

    fn convergence(&self) -> f64 {
        match self.form {
            // The ends of clamps.
            _ if self.clamps().next().is_some() => 1.0,
            Filling::Ellipsoid(_) => 4.0,
            // Near the edges of a plate, torsion varies over its thickness, which is shorter than a
            // hexahedron. At re-entrant corners of a plate, `plate_sizes` sees to order two.
            Filling::Block(_) | Filling::Plate(_) => 2.0,
        }
    }

    fn first_ratio(&self) -> f64 {
        1.5
    }

    fn coarse(&self, limit: f64, accuracy: f64) -> Result<Filled, ModalAnalysisError> {
        let edge = self.coarse_edge(limit, accuracy);
        let count = |length: f64| (length / edge).ceil().max(1.0) as usize;
        let even = CornerSizes { of_sides: 1.0, coarsest: edge, part: 1.0 };
        match &self.form {
            Filling::Ellipsoid(semi_axes) => self.with_cells([count(semi_axes.max_element()); 3], edge, even),
            Filling::Block(edges) => self.with_cells(box_cells(*edges, edge), edge, even),
            Filling::Plate(plate) => {
                let (edge, at) = self.plate_sizes(plate, edge);
                self.with_cells([0; 3], edge, at)
            }
        }
    }

    fn finer(&self, than: &Filled, wanted: &Finer<'_, Vec<Mode>>) -> Result<Filled, ModalAnalysisError> {
        let ratio = wanted.ratio;
        let edge = than.edge / ratio;
        let cells = match &self.form {
            Filling::Block(edges) => {
                let enough = box_cells(*edges, edge);
                std::array::from_fn(|a| match edges[a] <= edge {
                    // Through a plate, order 4 has long converged.
                    true => enough[a],
                    false => enough[a].max(more_cells(than.cells[a])),
                })
            }
            _ => than.cells.map(|n| (n as f64 * ratio - 1e-9).ceil() as usize),
        };
        let at = than.at_corners;
        let finer = self.with_cells(cells, edge, CornerSizes { part: at.part / (ratio * ratio), ..at })?;
        let at_corners = match than.corner_error > 0.0 {
            true => (finer.corner_error / than.corner_error).min(MOST_LEFT),
            false => 0.0,
        };
        let elsewhere = (finer.edge / than.edge).powf(self.convergence());
        Ok(Filled { share: (at_corners > elsewhere).then_some(at_corners), ..finer })
    }

    fn error_share(&self, mesh: &Filled, _mode: usize) -> Option<f64> {
        mesh.share
    }

    fn size(&self, mesh: &Filled) -> (usize, f64) {
        (mesh.mesh.nodes.len(), mesh.edge)
    }

    fn solve(
        &self,
        mesh: &Filled,
        limit: f64,
        work: &WorkLimit,
    ) -> Result<Spectrum<Vec<Mode>>, ModalAnalysisError> {
        // Supports break the mirror symmetry of a box.
        if let (Filling::Block(edges), Some(part), true) = (&self.form, &mesh.part, self.supports.is_empty())
        {
            let mirrored = MirroredBox { edges: *edges, cells: mesh.cells, constants: self.constants };
            return Ok(mirrored.solve(&mesh.mesh, part, (limit, work))?);
        }
        let system = self.assembled(mesh);
        let system = match self.supports.is_empty() {
            true => system,
            false => system.held_by(&Holding::new(&mesh.mesh, self.supports)?),
        };
        Ok(spectrum(&system, limit, work)?)
    }

    fn support_damping(
        &self,
        mesh: &Filled,
        modes: &Vec<Mode>,
        count: usize,
    ) -> Result<Vec<f64>, SupportError> {
        if self.supports.is_empty() {
            return Ok(vec![0.0; count]);
        }
        let holding = Holding::new(&mesh.mesh, self.supports)?;
        Ok(modes.iter().take(count).map(|mode| holding.damping(&mode.shape)).collect())
    }

    fn system(&self, mesh: &Filled) -> Option<ElasticSystem> {
        Some(self.assembled(mesh))
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

/// Expected nodes of the last mesh of a plate for modes up to a limit \[Hz\]: of the second, with twice the
/// triangles of the first, as a rule.
pub(crate) fn plate_nodes(plate: FlatPlate, constants: &ElasticConstants, limit: f64, accuracy: f64) -> f64 {
    let body = VolumeFem::new(Filling::Plate(plate), constants, ModalAnalysisOptions::MOST_NODES);
    let Filling::Plate(plate) = &body.form else { return 0.0 };
    let (edge, at) = body.plate_sizes(plate, body.coarse_edge(limit, accuracy));
    2.0 * body.expected([0; 3], edge, at)[1]
}

/// All modes of a system up to a limit \[Hz\].
fn spectrum(system: &ElasticSystem, limit: f64, work: &WorkLimit) -> Result<Spectrum<Vec<Mode>>, ModalError> {
    let nodes = PartNodes { places: &[], on_planes: &[] };
    let Spectrum { frequencies, first, residual, modes } =
        MirrorParities::default().spectrum(system, nodes, limit, work)?;
    Ok(Spectrum { frequencies, first, residual, modes: modes.into_iter().map(|part| part.mode).collect() })
}
