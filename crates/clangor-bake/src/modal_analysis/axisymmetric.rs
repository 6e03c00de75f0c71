//! Modes of axisymmetric bodies, computed on the section.
//!
//! A mode of such a body has an azimuthal order m. It varies around the axis as cos mφ and, for m > 0, a
//! second mode of the same frequency as sin mφ. The remaining equations are two-dimensional,
//!
//! ```text
//! K_m u = ω² M u,    u = (U, V, W) on the section
//! ```
//!
//! with thousands of unknowns where the volume needs a hundred thousand. Pairs of modes are exactly
//! degenerate.

mod axisymmetric_surface;
mod section_element;
pub(crate) mod section_mesh;
mod spectrum;
pub(super) mod triangulation;

use std::borrow::Cow;

use clangor_core::geometry::meridian::Meridian;
use clangor_core::sound_model::modal::surface::ModalSurface;
use glam::{DQuat, DVec3};

use crate::cost::work_limit::WorkLimit;
use crate::fem::{ElasticConstants, ElasticSystem};
use crate::geometry_class::bake_geometry::Axisymmetry;
use crate::modal_analysis::{Finer, ModalAnalysisError, RefinableDiscretization, Spectrum, shortest_wave};
use axisymmetric_surface::AxisymmetricSurface;
use section_mesh::SectionMesh;
use spectrum::{SectionMode, spectrum};

/// Elements per shortest wavelength of the coarse mesh, and on the surface where shapes are given.
const SECTION_ELEMENTS: f64 = 3.0;
const SURFACE_ELEMENTS: f64 = 6.0;
/// Edges of the coarse mesh, relative to the limit for a wall.
const COARSE_FINENESS: f64 = 0.8;
/// Sine of the angle above which a re-entrant edge counts as sharp.
const LEAST_INNER_EDGE: f64 = 0.2;
/// Least number of surface elements along the bounding radius.
const LEAST_SURFACE_ELEMENTS: f64 = 6.0;

/// A body of revolution.
pub(crate) struct AxisymmetricBody<'a> {
    meridian: Cow<'a, Meridian>,
    /// From the axis of the section, y, to that of the body.
    rotation: DQuat,
    constants: &'a ElasticConstants,
}

/// A mesh of the section.
pub(crate) struct AxisymmetricMesh {
    section: SectionMesh,
    /// Edges \[m\] that are short enough for the band and the size of the body.
    most: f64,
    /// Refinement factor on them.
    fineness: f64,
    /// Edges of the surface \[m\].
    surface_edge: f64,
}

impl<'a> AxisymmetricBody<'a> {
    pub(crate) fn new(axisymmetry: Axisymmetry<'a>, constants: &'a ElasticConstants) -> Self {
        let rotation = axisymmetry.rotation();
        AxisymmetricBody { meridian: axisymmetry.meridian, rotation, constants }
    }

    fn section(&self, most: f64, fineness: f64) -> Result<SectionMesh, ModalAnalysisError> {
        SectionMesh::new(&self.meridian, most, fineness).ok_or(ModalAnalysisError::Section)
    }
}

impl RefinableDiscretization for AxisymmetricBody<'_> {
    type Mesh = AxisymmetricMesh;
    type Modes = Vec<SectionMode>;

    fn method(&self) -> &'static str {
        "quadratic triangles on the section, order by order"
    }

    fn convergence(&self) -> f64 {
        // Order 4 for smooth geometry and small elements. Few layers across a wall reduce it, sharp
        // re-entrant edges more.
        if has_inner_edge(&self.meridian) { 2.0 } else { 3.0 }
    }

    fn first_ratio(&self) -> f64 {
        2.0
    }

    fn coarse(&self, limit: f64, _accuracy: f64) -> Result<AxisymmetricMesh, ModalAnalysisError> {
        let radius = self.meridian.bounding_radius();
        let wave = shortest_wave(self.constants, section_mesh::wall(&self.meridian), limit);
        let most = (wave / SECTION_ELEMENTS).min(0.5 * radius);
        let surface_edge = (wave / SURFACE_ELEMENTS).min(radius / LEAST_SURFACE_ELEMENTS);
        let fineness = COARSE_FINENESS;
        Ok(AxisymmetricMesh { section: self.section(most, fineness)?, most, fineness, surface_edge })
    }

    fn finer(
        &self,
        than: &AxisymmetricMesh,
        wanted: &Finer<'_, Vec<SectionMode>>,
    ) -> Result<AxisymmetricMesh, ModalAnalysisError> {
        let (most, fineness) = (than.most, than.fineness / wanted.ratio);
        Ok(AxisymmetricMesh { section: self.section(most, fineness)?, fineness, ..*than })
    }

    fn size(&self, mesh: &AxisymmetricMesh) -> (usize, f64) {
        (mesh.section.nodes.len(), mesh.fineness)
    }

    fn solve(
        &self,
        mesh: &AxisymmetricMesh,
        limit: f64,
        work: &WorkLimit,
    ) -> Result<Spectrum<Vec<SectionMode>>, ModalAnalysisError> {
        let found = spectrum(&mesh.section, self.constants, limit, work)?;
        let both = |m: &SectionMode| std::iter::repeat_n(m.frequency, if m.order == 0 { 1 } else { 2 });
        Ok(Spectrum {
            frequencies: found.modes.iter().flat_map(both).collect(),
            first: found.first,
            residual: found.residual,
            modes: found.modes,
        })
    }

    fn system(&self, _mesh: &AxisymmetricMesh) -> Option<ElasticSystem> {
        None
    }

    fn shapes(
        &self,
        mesh: &AxisymmetricMesh,
        modes: &Vec<SectionMode>,
        count: usize,
    ) -> (ModalSurface, Vec<Vec<DVec3>>) {
        let mut axisymmetric = AxisymmetricSurface::new(&self.meridian, mesh.surface_edge);
        let shape =
            |m: &SectionMode, across: bool| axisymmetric.shape(&mesh.section, &m.motion, m.order, across);
        let both = |m: &SectionMode| {
            let second = (m.order > 0).then(|| shape(m, true));
            std::iter::once(shape(m, false)).chain(second)
        };
        let mut shapes: Vec<Vec<DVec3>> = modes.iter().flat_map(both).take(count).collect();
        if self.rotation != DQuat::IDENTITY {
            let all = axisymmetric.surface.nodes.iter_mut().chain(shapes.iter_mut().flatten());
            all.for_each(|x| *x = self.rotation * *x);
        }
        (axisymmetric.surface, shapes)
    }
}

/// Whether any joint of two pieces is re-entrant.
fn has_inner_edge(meridian: &Meridian) -> bool {
    let pieces = meridian.pieces();
    let next = pieces.iter().skip(1).chain(meridian.is_loop().then(|| &pieces[0]));
    pieces.iter().zip(next).any(|(before, after)| {
        let (from, to) = (before.velocity(1.0).normalize_or_zero(), after.velocity(0.0).normalize_or_zero());
        from.perp_dot(to) < -LEAST_INNER_EDGE
    })
}
