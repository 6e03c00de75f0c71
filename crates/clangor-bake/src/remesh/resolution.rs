//! How long edges may be for an accuracy, and how many unknowns that makes.
//!
//! Three things limit the error of linear elements whose triangles keep the volume:
//!
//! * the wave: longest edge λ/6 for 0.3 %, of second order;
//! * the wall: near the rim of a thin wall the two faces see each other, and sharp edges have a singular flow;
//! * the radius of the edges, which the size field follows by itself down to the shortest edge.
//!
//! The level error at edges of length h on a wall of thickness w is about 2.8 % (h/w)^{4/3}: measured on the sharp-edged
//! key of 1.8 mm at kR 2 to 7 against its own refinement, where edges of 1.4, 1.0, 0.75 mm are off by 1.35, 0.85, 0.5 %.
//! A solid body counts as a wall of 0.2 of its bounding radius, for the sake of sharp edges: a die with R = 12 mm and edges rounded to about 1 mm is off
//! by 1.1, 0.4, 0.1 % at 2.0, 1.2, 0.8 mm and kR 4.

use std::f64::consts::TAU;

use clangor::geometry::surface_tree::SurfaceTree;
use clangor::geometry::tri_mesh::TriMesh;
use glam::{BVec3, DVec3};

use super::{Guided, RemeshError, RemeshOptions, input_mass};

/// Level error of edges as long as the wall is thick.
const WALL_ERROR: f64 = 0.028;
/// Its order in the edge length.
const WALL_ORDER: f64 = 4.0 / 3.0;
/// Level error of edges of a sixth of the wavelength; of second order.
const WAVE_ERROR: f64 = 0.003;
/// Thickness that a solid body counts as, in bounding radii.
const SOLID: f64 = 0.2;
/// Longest edge in bounding radii, and in walls: whatever the wavelength and the accuracy, the shape must be seen.
const LONGEST: f64 = 0.35;
const LONGEST_IN_WALLS: f64 = 0.8;
/// Part of the surface that may be thinner than the wall thickness that counts.
const THIN_PART: f64 = 0.05;
/// Points at which the wall is measured.
const PROBES: usize = 2000;
/// Vertices of an isotropic mesh, in those of equilateral triangles with the target edges.
const DENSITY: f64 = 0.93;

/// Edge lengths for an accuracy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resolution {
    /// The edge lengths.
    pub options: RemeshOptions,
    /// Unknowns that they make, within some 15 %.
    pub unknowns: usize,
    /// Thickness of the thin walls of the body: 5 % of the surface have less \[m\].
    pub wall: f64,
    /// Where the wall is thinnest.
    pub thinnest: DVec3,
}

/// Chooses edge lengths for wavenumbers up to `max_wavenumber` [1/m] and a level error of `accuracy`.
///
/// # Errors
/// [`RemeshError::Input`] for a surface that bounds no solid, [`RemeshError::Edges`] for a wavenumber or an accuracy
/// from which no edge lengths follow.
pub fn resolution(input: &TriMesh, max_wavenumber: f64, accuracy: f64) -> Result<Resolution, RemeshError> {
    let sound = accuracy > 0.0 && max_wavenumber > 0.0;
    if !sound {
        return Err(RemeshError::Edges { min_edge: f64::NAN, max_edge: TAU / max_wavenumber / 6.0 });
    }
    let mass = input_mass(input)?;
    let centred = input.relative_to(mass.centre_of_mass);
    let radius = centred.bounding_radius(DVec3::ZERO);
    let (wall, thinnest) = wall_thickness(&centred);
    let wave = TAU / max_wavenumber / 6.0 * (accuracy / WAVE_ERROR).sqrt().min(1.0);
    let max_edge = wave.min(LONGEST * radius);
    let share = (accuracy / WALL_ERROR).powf(1.0 / WALL_ORDER).min(LONGEST_IN_WALLS);
    let options = RemeshOptions { min_edge: max_edge.min(share * wall.min(SOLID * radius)), max_edge };
    options.check()?;
    let unknowns = Guided::new(&centred, BVec3::FALSE, &options).expected_vertices(DENSITY);
    Ok(Resolution { options, unknowns, wall, thinnest: thinnest + mass.centre_of_mass })
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
