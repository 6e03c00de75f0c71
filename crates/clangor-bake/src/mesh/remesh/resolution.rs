//! Edge lengths for an accuracy, and the resulting number of unknowns.
//!
//! Three things limit the error of linear elements whose triangles keep the volume:
//!
//! * the wave: longest edge λ/6 for 0.3 %, of second order;
//! * the wall: near the rim of a thin wall the two faces interact;
//! * the edges of the body: the flow around a sharp edge is singular; around a rounded one it is as smooth as
//!   the rounding.
//!
//! The level error at edges of length h is about
//!
//! ```text
//! 2.8 % (h/w)^{4/3} Σ τ min(1, (h/1.3ρ)²),   w = min(wall, 0.17R, 1/k)
//! ```
//!
//! where τ is the fraction of the edges of the body that are rounded with radius ρ: of the integral of the
//! curvature over the area wherever the radius of curvature is below half the bounding radius R. A sharp edge
//! has ρ = 0, a sphere has no edges.
//!
//! Constants measured against refined meshes at 20 kHz, with h and the level error of
//!
//! - a sharp key of 1.8 mm: 1.4, 1.0, 0.75 mm, 1.35, 0.85, 0.5 %; a sharp cube of 15 mm: 1.4, 1.0, 0.7, 0.5
//!   mm, 1.3, 0.7, 0.3, 0.2 %;
//! - cubes of 15 mm with ρ = 0.5 mm: 1.0, 0.7, 0.5 mm, 0.8, 0.24, 0.04 %; with ρ = 1 mm: 1.4, 1.0, 0.7 mm,
//!   0.6, 0.13, 0.03 %; with ρ = 3 mm: 2.9, 1.9, 1.4 mm, 1.3, 0.33, 0.17 %;
//! - a die of 15 mm with edges rounded by 0.6 to 2.5 mm: 2.0, 1.6, 1.2, 1.0, 0.8 mm, 1.2, 0.8, 0.4, 0.2, 0.1
//!   %.
//!
//! Edges are no longer than λ/6, but for bodies of many unknowns: these have edges of up to λ/4.65 at 1 %,
//! which lose about that at the end of the band. A mug of 98 mm with edges of λ/4.65 and λ/4 differs from one
//! of λ/6 by 0.12 and 0.27 % at 9.5 kHz, by 0.93 and 2.0 % at 18.5 kHz, of a band to 20 kHz.
//!
//! The size field itself refines to 0.6 of the local radius of curvature, down to the shortest edge.

use std::f64::consts::TAU;

use clangor_core::geometry::surface_tree::SurfaceTree;
use clangor_core::geometry::tri_mesh::TriMesh;
use glam::{BVec3, DVec3};

use super::{Guided, RemeshError, RemeshOptions, input_mass};

/// Level error of edges as long as the wall is thick.
const WALL_ERROR: f64 = 0.028;
/// Its order in the edge length.
const WALL_ORDER: f64 = 4.0 / 3.0;
/// Level error of edges of a sixth of the wavelength; of second order.
pub(crate) const WAVE_ERROR: f64 = 0.003;
/// Unknowns above which edges grow past a sixth of the wavelength where the error allows it, the share of the
/// error left to the waves then, and the longest edge in sixths of a wavelength.
pub(crate) const MANY: f64 = 2500.0;
pub(crate) const WAVE_SHARE: f64 = 0.5;
pub(crate) const COARSEST: f64 = 1.45;
/// Effective thickness of a solid body, in bounding radii; at short waves the wavelength over 2π.
const SOLID: f64 = 0.17;
/// Edge length, in radii of a rounding, above which the rounding acts as sharp.
const BLUNT: f64 = 1.3;
/// Largest radius of an edge, in bounding radii: gentler curvature is a face.
const EDGE: f64 = 0.5;
/// Longest edge in bounding radii, and in walls: the minimum resolution of the shape at any wavelength and
/// accuracy.
const LONGEST: f64 = 0.35;
const LONGEST_IN_WALLS: f64 = 0.8;
/// Relative error of the volume that may be hidden, in that of the level. Tori with few edges around their
/// wire are off by 0.4 to 0.9 % for 1 % with this share, and by 1.2 % with all of it.
const VOLUME_SHARE: f64 = 0.3;
/// Fraction of the surface that may be thinner than the wall thickness used.
const THIN_PART: f64 = 0.05;
/// Points at which the wall is measured.
const PROBES: usize = 2000;
/// Vertices of an isotropic mesh, in those of equilateral triangles with the target edges.
const DENSITY: f64 = 0.93;

/// Edge lengths for an accuracy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resolution {
    /// The level error.
    pub accuracy: f64,
    /// The edge lengths.
    pub options: RemeshOptions,
    /// Resulting number of unknowns, within some 15 %.
    pub unknowns: usize,
    /// Thickness of the thin walls of the body: 5 % of the surface have less \[m\].
    pub wall: f64,
    /// Position of the thinnest wall.
    pub thinnest: DVec3,
}

impl Resolution {
    /// The same with edges as long as the waves allow on all of a surface of this area \[m²\], whatever its
    /// walls and edges need.
    pub(crate) fn with_long_edges(&self, area: f64) -> Self {
        let edge = self.options.max_edge;
        let options = RemeshOptions { min_edge: edge, max_edge: edge, ..self.options };
        let unknowns = (DENSITY * area / (0.75_f64.sqrt() * edge * edge)).ceil() as usize;
        Resolution { options, unknowns, ..*self }
    }
}

/// Chooses edge lengths for wavenumbers up to `max_wavenumber` [1/m] and a level error of `accuracy`.
///
/// # Errors
/// [`RemeshError::Input`] for a surface that encloses no solid, [`RemeshError::Edges`] for an invalid
/// wavenumber or accuracy.
pub fn resolution(input: &TriMesh, max_wavenumber: f64, accuracy: f64) -> Result<Resolution, RemeshError> {
    let sound = accuracy > 0.0 && max_wavenumber > 0.0;
    if !sound {
        return Err(RemeshError::Edges { min_edge: f64::NAN, max_edge: TAU / max_wavenumber / 6.0 });
    }
    let mass = input_mass(input)?;
    let centred = input.relative_to(mass.centre_of_mass);
    let radius = centred.bounding_radius(DVec3::ZERO);
    let (wall, thinnest) = wall_thickness(&centred);
    let sixth = TAU / max_wavenumber / 6.0;
    let [longest, coarse] = [1.0, WAVE_SHARE]
        .map(|share| (share * accuracy / WAVE_ERROR).sqrt())
        .map(|sixths| (sixth * sixths.min(COARSEST)).min(LONGEST * radius));
    let longest = longest.min(sixth);
    let guided = |shortest: f64, max_edge: f64| {
        let mut options = RemeshOptions::new(max_edge.min(shortest), max_edge);
        options.volume_error = options.volume_error.max(VOLUME_SHARE * accuracy);
        options.check().map(|()| (Guided::new(&centred, BVec3::FALSE, &options), options))
    };
    let thickness = wall.min(SOLID * radius).min(max_wavenumber.recip());
    let sharp = (accuracy / WALL_ERROR).powf(WALL_ORDER.recip()) * thickness;
    let (first, _) = guided(sharp, longest)?;
    let edges: Vec<(f64, f64)> = first.turning().into_iter().filter(|(r, _)| *r < EDGE * radius).collect();
    let error = |h: f64| WALL_ERROR * (h / thickness).powf(WALL_ORDER) * sharpness(&edges, h);
    let shortest = longest_within(accuracy, [sharp, LONGEST * radius], error);
    let shortest = shortest.min(LONGEST_IN_WALLS * wall);
    let (mut field, mut options) = guided(shortest, longest)?;
    let mut unknowns = field.expected_vertices(DENSITY);
    let many = (unknowns as f64 / MANY).sqrt();
    if many > 1.0 && coarse > longest {
        (field, options) = guided(shortest, coarse.min(longest * many))?;
        unknowns = field.expected_vertices(DENSITY);
    }
    Ok(Resolution { accuracy, options, unknowns, wall, thinnest: thinnest + mass.centre_of_mass })
}

/// Relative error of edges with these (radius, extent) at edge length h, in that of sharp edges: Σ τ min(1,
/// (h/1.3ρ)²).
fn sharpness(edges: &[(f64, f64)], h: f64) -> f64 {
    let total: f64 = edges.iter().map(|e| e.1).sum();
    let part = |(radius, extent): &(f64, f64)| extent * (h / (BLUNT * radius)).powi(2).min(1.0);
    edges.iter().map(part).sum::<f64>() / total.max(f64::MIN_POSITIVE)
}

/// The largest h between two bounds whose `error`, which grows with h, is at most `accuracy`; the lower bound
/// if none is.
fn longest_within(accuracy: f64, [mut low, mut high]: [f64; 2], error: impl Fn(f64) -> f64) -> f64 {
    if error(high) <= accuracy {
        return high.max(low);
    }
    while high > 1.001 * low {
        let middle = 0.5 * (low + high);
        *(if error(middle) <= accuracy { &mut low } else { &mut high }) = middle;
    }
    low
}

/// Thickness along inward rays: the 5 % quantile over the area \[m\], and where it is least.
fn wall_thickness(mesh: &TriMesh) -> (f64, DVec3) {
    let tree = SurfaceTree::new(mesh);
    let offset = 1e-9 * mesh.bounding_radius(DVec3::ZERO);
    let step = mesh.triangles.len().div_ceil(PROBES).max(1);
    let mut probes: Vec<(f64, f64, DVec3)> = (0..mesh.triangles.len())
        .step_by(step)
        .filter_map(|t| {
            let (origin, area) = (mesh.centroid(t), mesh.area_vector(t));
            let depth = tree.first_hit(mesh, origin, -area.normalize_or_zero(), offset)?;
            Some((depth, area.length(), origin))
        })
        .collect();
    probes.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let total: f64 = probes.iter().map(|p| p.1).sum();
    let mut below = 0.0;
    let counts = |p: &&(f64, f64, DVec3)| {
        below += p.1;
        below > THIN_PART * total
    };
    let wall = probes.iter().find(counts).map_or(mesh.diagonal(), |p| p.0);
    (wall, probes.first().map_or(DVec3::ZERO, |p| p.2))
}
