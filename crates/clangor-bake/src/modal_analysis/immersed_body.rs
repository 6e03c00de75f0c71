//! A closed surface of any form in cells that it cuts, as a rule larger than its walls, by
//! [`finite_cells`](crate::fem::finite_cells).
//!
//! Cells of order 4 are about half a bending wave long. The error of a frequency is estimated from order 3 on
//! the same grid: the spaces are nested, so that both are too high, the lower order by more. Where walls meet
//! at inner edges, less is gained by order 4, and the same difference means a larger error, most of all in
//! cells with the end of a slit or a corner of a plate (`order_gain`). There, cells are halved again and
//! again where modes are resolved least (`local_refinement`); elsewhere all become smaller. On a few nodes,
//! the change from order 3 to 4 alone shows no error: one grid of smaller cells follows in any case, at all
//! inner edges if there are some.
//!
//! Where a body has mirror planes, the cells are on one side of them (see
//! [`mirror_parities`](super::mirror_parities)). The other side then is the image of this one, noise of the
//! surface included.

mod draft_cells;
mod face_directions;
mod local_refinement;
mod mirrors;
mod order_gain;
mod through_holes;

use std::borrow::Cow;
use std::collections::BTreeMap;

use clangor_core::geometry::components::solid_count;
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::geometry::refine::refine_to_edge;
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::sound_model::modal::surface::ModalSurface;
use glam::{DMat3, DVec3};

use draft_cells::draft_edge;
use mirrors::Mirrors;
use through_holes::hole_spacing;

use super::mirror_parities::{MirrorParities, PartMode, PartNodes};
use super::{Finer, ModalAnalysisError, RefinableDiscretization, Spectrum, largest, shortest_wave};
use crate::cost::work_limit::WorkLimit;
use crate::fem::finite_cells::{CellGrid, FiniteCells, Order, Planes, Refinement, edge_for, expected};
use crate::fem::supports::{Holding, Support, SupportError, SupportKind, SupportRegion};
use crate::fem::{ElasticConstants, ElasticSystem};
use crate::geometry_class::inner_creases::{Walls, singular_edges};
use crate::mesh::decimate::decimate;
use crate::mesh::tetrahedra::isosurface_stuffing::StuffingError;

/// Edge of the cells in shortest waves for an error of [`WAVE_ERROR`], of eighth order in the edge.
const EDGE_IN_WAVES: f64 = 0.6;
const WAVE_ERROR: f64 = 0.005;
const WAVE_ORDER: f64 = 8.0;
/// Least number of cells along the longest extent: of compact bodies, and of thin ones, whose parts may be
/// much smaller. Seen: frequencies of a coil spring of eight turns 3 % high with two, 0.3 % with four.
const LEAST_CELLS: f64 = 2.0;
const LEAST_THIN_CELLS: f64 = 6.0;
/// Largest edge in typical walls: thinner walls lose digits.
const LONGEST_IN_WALLS: f64 = 30.0;
/// Error of order 3 in that of order 4. Seen: 6 to 8 on a bowl.
const ORDER_GAIN: f64 = 6.0;
/// The same of compact bodies with inner edges, whose arms a larger cell ties together.
const LONGEST_IN_BLOCKS: f64 = 1.5;
/// Largest edge in the spacing of holes, and the gain of order 4 where there are several.
const LONGEST_IN_HOLES: f64 = 0.5;
const PERFORATED_GAIN: f64 = 2.0;
/// Order at which their frequencies converge with the edge. Seen: 2.4 from cells of 65 to 26 mm (brick of
/// 215 × 103 × 65 mm with three holes of 35 mm).
const PERFORATED_CONVERGENCE: f64 = 2.0;
/// Order at which frequencies converge with the edge; edges and creases keep it low.
const CONVERGENCE: f64 = 4.0;
/// The same for walls that meet at sharp inner edges. The bending of a wall of thickness t with a radius R
/// dies away over √(Rt) from the edge, which is less than a cell. Seen: gains of 3.1 (first mode of an open
/// box of 4 mm), 1.9 to 2.4 (tin of 80 × 60 × 0.8 mm); orders of 1.0 (bottle of 2 mm) to 1.4 (tin).
const CREASED_GAIN: f64 = 2.2;
/// The same of compact bodies, whose stress is singular there. Seen: gains of 1.55 (ball of 6 cm with a slot
/// of 1 cm) and 1.8 (bracket).
const COMPACT_GAIN: f64 = 1.6;
/// The same from order 2 to order 3.
const DRAFT_GAIN: f64 = 3.0;
const CREASED_CONVERGENCE: f64 = 1.0;
/// The same where inner edges are short, as at the end of a slit.
const SINGULAR_CONVERGENCE: f64 = 1.0;
/// Factor on the node limit for the estimate of a grid that is not made yet.
const MOST_EXPECTED: f64 = 1.5;
/// Share of the node limit for accurate grids that are finer than the waves in the band want: a node of a
/// cell has many more neighbours than one of a tetrahedron. Seen: 3.7 GB and 55 s of CPU time for the 92
/// modes of a tin on 57 000 nodes.
const FINER_SHARE: f64 = 0.75;
/// Least ratio of edges that is worth another grid.
const LEAST_RATIO: f64 = 1.1;
/// Nodes of thin bodies below which the change from one order to the next alone does not show an error. Seen:
/// 2.0 % where 0.85 % was expected (angle iron of 300 × 30 × 30 × 3 mm to 1.5 kHz, 650 nodes).
const FEW_NODES: usize = 2000;
/// Nodes of bodies with inner edges below which neither that nor smaller cells at some of the edges do. Seen:
/// 6.5 % for 0.3 % (bar with a T section of 300 × 24 × 20 × 4 mm, 650 nodes), 5.6 % for 0.4 % (square bar
/// that ends within a cylinder, 1085 nodes).
const FEW_NODES_AT_EDGES: usize = 5000;
/// Largest error that few nodes may hide.
const LARGEST_HIDDEN: f64 = 0.07;
/// Ratio of edges that shows it, and the accuracy where cells are halved, over that asked for.
const CONFIRMING_RATIO: f64 = 1.5;
const CONFIRMING_ACCURACY: f64 = 0.5;
/// Longest edge of the surface that carries the shapes, in cells.
const SURFACE_EDGE: f64 = 0.35;
/// Largest distance of that surface from the input, in walls.
const SURFACE_ERROR: f64 = 0.1;
/// The same of a draft.
const DRAFT_SURFACE_ERROR: f64 = 0.25;

/// Distance of the end of a clamp from that of the body that is none, in cells.
const END: f64 = 1e-3;

/// How much work the grids of a body may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CellEffort {
    /// Orders 3 and 4 in cells as small as the accuracy needs.
    Accurate,
    /// Orders 2 and 3 in a few large cells.
    Draft,
}

/// A closed surface, and the lengths that set the size of cells.
pub(super) struct ImmersedBody<'a> {
    surface: Cow<'a, TriMesh>,
    constants: &'a ElasticConstants,
    /// Longest extent \[m\].
    size: f64,
    walls: Walls,
    /// Ends of the inner edges where stress is singular \[m\].
    singular_edges: Vec<[DVec3; 2]>,
    /// Spacing of its holes \[m\], if it has several.
    hole_spacing: Option<f64>,
    /// \[m³\]
    volume: f64,
    /// Most nodes of a grid.
    most_nodes: usize,
    effort: CellEffort,
    /// What holds the body; empty if it is free.
    supports: &'a [Support],
    mirrors: Option<Mirrors>,
}

/// A grid with displacements of one order.
pub(super) struct Immersed {
    cells: FiniteCells,
    /// Edge of the largest cells \[m\].
    edge: f64,
    order: Order,
    refinement: Refinement,
    /// Expected error of each mode in that on the grid before; empty if it is that of smaller edges.
    shares: Vec<f64>,
    /// Whether the grid before was the same of a lower order.
    is_by_order: bool,
    /// Whether cells at all inner edges were halved.
    is_finer_at_edges: bool,
}

impl<'a> ImmersedBody<'a> {
    pub(super) fn new(
        surface: Cow<'a, TriMesh>,
        constants: &'a ElasticConstants,
        most_nodes: usize,
        effort: CellEffort,
    ) -> Result<Self, ModalAnalysisError> {
        let parts = solid_count(&surface).map_err(StuffingError::Input)?;
        if parts > 1 {
            return Err(ModalAnalysisError::LooseParts(parts));
        }
        let (low, high) = surface.bounds();
        let walls = Walls::of(&surface);
        let volume = MassProperties::of(&surface).map_err(StuffingError::Input)?.volume;
        let size = (high - low).max_element();
        let (supports, mirrors): (&[Support], _) = (&[], None);
        let singular_edges = singular_edges(&surface, &walls);
        let hole_spacing = hole_spacing(&surface);
        Ok(ImmersedBody {
            surface,
            constants,
            size,
            walls,
            singular_edges,
            hole_spacing,
            volume,
            most_nodes,
            effort,
            supports,
            mirrors,
        })
    }

    /// The same body, held.
    pub(super) fn held_by(self, supports: &'a [Support]) -> Self {
        ImmersedBody { supports, mirrors: None, ..self }
    }

    /// The surface in the axes of the grid.
    fn framed(&self) -> &TriMesh {
        self.mirrors.as_ref().map_or(&self.surface, |mirrors| &mirrors.surface)
    }

    fn holding(&self, mesh: &Immersed) -> Result<Holding, SupportError> {
        mesh.cells.holding(&self.surface, self.supports, self.constants, self.walls.thickness)
    }

    /// Order of all grids but the first.
    fn last_order(&self) -> Order {
        match self.effort {
            CellEffort::Accurate => Order::Fourth,
            CellEffort::Draft => Order::Third,
        }
    }

    /// Whether a grid has so few nodes that all cells at inner edges are to become smaller.
    fn may_hide_edges(&self, mesh: &Immersed, accuracy: f64) -> bool {
        let has_edges = self.walls.creased || !self.singular_edges.is_empty();
        let is_few = !mesh.is_finer_at_edges && mesh.cells.node_count() < FEW_NODES_AT_EDGES;
        has_edges && is_few && accuracy <= LARGEST_HIDDEN
    }

    /// Error of the lower order in that of the higher.
    fn order_gain(&self) -> f64 {
        match (self.walls.creased, self.effort) {
            (false, _) if self.hole_spacing.is_some() => PERFORATED_GAIN,
            (false, _) => ORDER_GAIN,
            (true, CellEffort::Draft) => DRAFT_GAIN,
            (true, CellEffort::Accurate) if self.walls.thin => CREASED_GAIN,
            (true, CellEffort::Accurate) => COMPACT_GAIN,
        }
    }

    fn with(&self, edge: f64, order: Order) -> Result<Immersed, ModalAnalysisError> {
        let most = MOST_EXPECTED * self.most_nodes as f64;
        let parts = |planes: [bool; 3]| MirrorParities(planes).parities().count() as f64;
        let expected = |edge: f64, parts: f64| {
            expected(self.surface.area(), self.volume, edge).map(|count| count / parts)
        };
        let fits = |parts: f64| {
            let ([elements, nodes], wall) = (expected(edge, parts), self.walls.thickness);
            match nodes > most {
                true => {
                    Err(ModalAnalysisError::TooFine { wall, edge, elements, nodes, most: self.most_nodes })
                }
                false => Ok(()),
            }
        };
        if let Some(mirrors) = &self.mirrors {
            fits(parts(mirrors.planes))?;
            let grid = CellGrid::on_one_side(&mirrors.surface, edge, mirrors.planes);
            fits(parts(grid.mirrored()))?;
            return self.on(grid, order);
        }
        fits(1.0)?;
        let planes = self.ends_of_clamps(edge);
        let aligned = edge_for(&planes, edge);
        let edge = if expected(aligned, 1.0)[1] > most { edge } else { aligned };
        self.on(CellGrid::around(&self.surface, edge, &planes), order)
    }

    fn on(&self, grid: CellGrid, order: Order) -> Result<Immersed, ModalAnalysisError> {
        let refinement = Refinement::default();
        let cells = FiniteCells::new(self.framed(), (grid, &refinement), order, self.walls.thickness)?;
        Ok(Immersed {
            cells,
            edge: grid.edge,
            order,
            refinement,
            shares: Vec::new(),
            is_by_order: false,
            is_finer_at_edges: false,
        })
    }

    /// Where clamps in boxes end within the body, by more than rounding in cells of an edge \[m\].
    fn ends_of_clamps(&self, edge: f64) -> Planes {
        let (low, high) = self.surface.bounds();
        let boxes = self.supports.iter().filter(|support| {
            support.kind == SupportKind::Clamped && matches!(support.region, SupportRegion::Box { .. })
        });
        let regions: Vec<&SupportRegion> = boxes.map(|support| &support.region).collect();
        std::array::from_fn(|a| {
            let ends = regions.iter().flat_map(|region| region.ends(a));
            let rounding = END * edge;
            ends.filter(|end| *end > low[a] + rounding && *end < high[a] - rounding).collect()
        })
    }

    /// The triangles on which shapes are given: short against waves, and not many more than that needs.
    fn carrier(&self, edge: f64) -> TriMesh {
        let longest = SURFACE_EDGE * edge;
        let error = match self.effort {
            CellEffort::Accurate => SURFACE_ERROR,
            CellEffort::Draft => DRAFT_SURFACE_ERROR,
        };
        decimate(&refine_to_edge(&self.surface, longest), longest, error * self.walls.thickness)
    }
}

impl RefinableDiscretization for ImmersedBody<'_> {
    type Mesh = Immersed;
    type Modes = Vec<PartMode>;

    fn method(&self) -> &'static str {
        match self.effort {
            CellEffort::Accurate => "cells of fourth order, cut by the surface",
            CellEffort::Draft => "a few cells of third order, cut by the surface",
        }
    }

    fn convergence(&self) -> f64 {
        match (self.walls.creased, self.singular_edges.is_empty()) {
            (true, _) => CREASED_CONVERGENCE,
            (false, false) => SINGULAR_CONVERGENCE,
            (false, true) if self.hole_spacing.is_some() => PERFORATED_CONVERGENCE,
            (false, true) => CONVERGENCE,
        }
    }

    fn first_ratio(&self) -> f64 {
        // From order 3 to order 4 on the same grid.
        1.0
    }

    fn coarse(&self, limit: f64, accuracy: f64) -> Result<Immersed, ModalAnalysisError> {
        let wave = shortest_wave(self.constants, self.walls.thickness, limit);
        let edge_in_waves = EDGE_IN_WAVES * (accuracy / WAVE_ERROR).min(1.0).powf(WAVE_ORDER.recip());
        let is_creased_block = self.walls.creased && !self.walls.thin;
        let in_walls = if is_creased_block { LONGEST_IN_BLOCKS } else { LONGEST_IN_WALLS };
        let least = if self.walls.thin { LEAST_THIN_CELLS } else { LEAST_CELLS };
        let longest = [self.size / least, in_walls * self.walls.thickness];
        let between_holes = self.hole_spacing.map(|spacing| LONGEST_IN_HOLES * spacing);
        let edge = longest.into_iter().chain(between_holes).fold(edge_in_waves * wave, f64::min);
        match self.effort {
            CellEffort::Draft => {
                let fewer = draft_edge(self.surface.area(), self.volume);
                self.draft_cells(edge.max(fewer))
            }
            CellEffort::Accurate => self.with(edge, Order::Third),
        }
    }

    fn finer(
        &self,
        than: &Immersed,
        wanted: &Finer<'_, Vec<PartMode>>,
    ) -> Result<Immersed, ModalAnalysisError> {
        let (last, ratio) = (self.last_order(), wanted.ratio);
        if than.order < last {
            let shares = self.shares_of_order(than, wanted.modes);
            return Ok(Immersed { shares, is_by_order: true, ..self.on(than.cells.grid(), last)? });
        }
        if self.effort == CellEffort::Draft {
            return self.with(than.edge / ratio, last);
        }
        // As much work in all parities as of a body without mirror planes.
        let parities = than.mirrors().parities().count() as f64;
        let most = FINER_SHARE * self.most_nodes as f64 / parities.powf(CellGrid::WORK.recip());
        let too_fine = || {
            let of_whole = expected(self.surface.area(), self.volume, than.edge / ratio);
            let [elements, nodes] = of_whole.map(|count| count / parities);
            let (wall, most) = (self.walls.thickness, most as usize);
            ModalAnalysisError::TooFine { wall, edge: than.edge / ratio, elements, nodes, most }
        };
        let is_met = largest(wanted.errors) <= wanted.accuracy;
        if self.walls.creased || !self.singular_edges.is_empty() {
            if self.may_hide_edges(than, wanted.accuracy)
                && let Some(mesh) = self.finer_at_edges(than, (wanted.errors.len(), most))?
            {
                return Ok(mesh);
            }
            let part = if is_met { CONFIRMING_ACCURACY } else { 1.0 };
            let wanted = Finer { accuracy: part * wanted.accuracy, ..*wanted };
            return self.finer_where_needed(than, &wanted, most)?.ok_or_else(too_fine);
        }
        if is_met {
            return self.with(than.edge / CONFIRMING_RATIO, last);
        }
        // The nodes of thin walls are as many as their cells have area.
        let finest = than.edge * (than.cells.node_count() as f64 / most).sqrt();
        let edge = (than.edge / ratio).max(finest);
        if than.edge < LEAST_RATIO * edge {
            return Err(too_fine());
        }
        self.with(edge, last)
    }

    fn size(&self, mesh: &Immersed) -> (usize, f64) {
        let longer = if mesh.order < self.last_order() {
            self.order_gain().powf(self.convergence().recip())
        } else {
            1.0
        };
        (mesh.cells.node_count(), longer * mesh.edge)
    }

    fn is_to_confirm(&self, mesh: &Immersed, accuracy: f64) -> bool {
        let is_few = mesh.is_by_order && mesh.cells.node_count() < FEW_NODES;
        let may_hide = self.walls.thin && is_few && accuracy <= LARGEST_HIDDEN;
        self.effort == CellEffort::Accurate && (may_hide || self.may_hide_edges(mesh, accuracy))
    }

    fn error_share(&self, mesh: &Immersed, mode: usize) -> Option<f64> {
        mesh.shares.get(mode).copied()
    }

    fn solve(
        &self,
        mesh: &Immersed,
        limit: f64,
        work: &WorkLimit,
    ) -> Result<Spectrum<Vec<PartMode>>, ModalAnalysisError> {
        let system = mesh.cells.system(self.constants);
        let system = match self.supports.is_empty() {
            true => system,
            false => system.held_by(&self.holding(mesh)?),
        };
        let nodes = PartNodes { places: mesh.cells.nodes(), on_planes: &mesh.cells.on_mirrors() };
        Ok(mesh.mirrors().spectrum(&system, nodes, limit, work)?)
    }

    fn support_damping(
        &self,
        mesh: &Immersed,
        modes: &Vec<PartMode>,
        count: usize,
    ) -> Result<Vec<f64>, SupportError> {
        if self.supports.is_empty() {
            return Ok(vec![0.0; count]);
        }
        let holding = self.holding(mesh)?;
        Ok(modes.iter().take(count).map(|part| holding.damping(&part.mode.shape)).collect())
    }

    fn system(&self, mesh: &Immersed) -> Option<ElasticSystem> {
        (mesh.mirrors() == MirrorParities::default()).then(|| mesh.cells.system(self.constants))
    }

    fn shapes(
        &self,
        mesh: &Immersed,
        modes: &Vec<PartMode>,
        count: usize,
    ) -> (ModalSurface, Vec<Vec<DVec3>>) {
        let carrier = self.carrier(mesh.edge);
        let (nodes, triangles) = six_nodes(&carrier);
        let mirrors = mesh.mirrors();
        let (centre, frame) = match &self.mirrors {
            Some(mirrors) => (mirrors.centre, mirrors.frame),
            None => (DVec3::ZERO, DMat3::IDENTITY),
        };
        let modes = &modes[..count.min(modes.len())];
        let places: Vec<DVec3> = nodes.iter().map(|node| frame.transpose() * (*node - centre)).collect();
        let sums: Vec<_> = places.iter().map(|at| mesh.cells.interpolation(mirrors.folded(*at))).collect();
        let shape = |PartMode { parity, mode }: &PartMode| {
            let motion = |(at, (corners, weights)): (&DVec3, &(&[u32], Vec<f64>))| {
                let motion = corners.iter().zip(weights).map(|(n, w)| mode.shape[*n as usize] * *w).sum();
                frame * mirrors.unfolded(*parity, *at, motion)
            };
            places.iter().zip(&sums).map(motion).collect()
        };
        (ModalSurface { nodes, triangles }, modes.iter().map(shape).collect())
    }
}

impl Immersed {
    /// The mirror planes of the grid.
    fn mirrors(&self) -> MirrorParities {
        MirrorParities(self.cells.grid().mirrored())
    }
}

/// A surface with a node in the middle of each side.
fn six_nodes(surface: &TriMesh) -> (Vec<DVec3>, Vec<[u32; 6]>) {
    let mut nodes = surface.vertices.clone();
    let mut middles: BTreeMap<[u32; 2], u32> = BTreeMap::new();
    let mut middle = |a: u32, b: u32| {
        *middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
            nodes.push(0.5 * (nodes[a as usize] + nodes[b as usize]));
            nodes.len() as u32 - 1
        })
    };
    let triangles = surface
        .triangles
        .iter()
        .map(|[a, b, c]| [*a, *b, *c, middle(*a, *b), middle(*b, *c), middle(*c, *a)]);
    let triangles = triangles.collect();
    (nodes, triangles)
}
