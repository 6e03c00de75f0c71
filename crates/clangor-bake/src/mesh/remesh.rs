//! Remeshing of a surface for boundary elements: near-equilateral triangles, small where curvature is high.
//!
//! ```text
//! input ─► sharp edges ─► edge length h ─► split, collapse, flip, smooth ─► fit to the input ─► exact volume
//!          crease         size_field       isotropic, editable_mesh         volume_fit
//! ```
//!
//! The accuracy of the solver is that of the geometry as long as edges are short relative to the wavelength:
//! a volume error of 1 % is a pressure error of 1 %. The flat triangles are therefore fitted to the input in
//! the mean, and the volume is made exact. Handles, holes and cavities survive, because every operation
//! preserves the topology. The two faces of a thin wall are distinguished by their normals.
//!
//! It does not repair: the input must enclose a solid, see [`check_solid`].

mod crease;
mod editable_mesh;
mod guide;
mod isotropic;
mod quality;
pub mod resolution;
mod size_field;
mod symmetric_mesh;
pub(super) mod volume_fit;

use std::f64::consts::PI;

use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::geometry::refine::refine_to_edge;
use clangor_core::geometry::solid::{MeshError, check_solid};
use clangor_core::geometry::topology::Topology;
use clangor_core::geometry::tri_mesh::TriMesh;
use glam::{BVec3, DVec3};

use crease::{Creases, SMOOTH};
use guide::Guide;
use symmetric_mesh::positive_half;
pub(crate) use symmetric_mesh::{frame_of, images_of};
use volume_fit::Freedom;

pub use symmetric_mesh::{ImageVertex, SymmetricMesh};

/// Largest relative error of the volume that the final uniform offset may hide, unless another is allowed.
const VOLUME_TOLERANCE: f64 = 1e-3;
/// Factor on edge lengths when the volume error is larger, and number of attempts.
const REFINEMENT: f64 = 0.8;
const REFINEMENTS: usize = 3;
/// Turning angle above which an edge is sharp \[rad\]: 40°.
const SHARP: f64 = 0.698;
/// Shortest net of sharp edges that is kept, in shortest target edges.
const SHORTEST_NET: f64 = 12.0;
/// Largest number of triangles after dividing long edges of the input for the size field.
const GUIDE_TRIANGLES: f64 = 60e3;

/// Edge lengths of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RemeshOptions {
    /// Shortest target edge \[m\]: on sharp edges and where the radius of curvature is small.
    pub min_edge: f64,
    /// Longest target edge \[m\]: on flat faces; a sixth of the shortest wavelength or less.
    pub max_edge: f64,
    /// Largest relative error of the volume that the final uniform offset may hide: above it, edges become
    /// shorter.
    pub volume_error: f64,
}

impl RemeshOptions {
    /// Edges \[m\] from `min_edge` to `max_edge`; at most a thousandth of the volume is hidden.
    pub fn new(min_edge: f64, max_edge: f64) -> Self {
        RemeshOptions { min_edge, max_edge, volume_error: VOLUME_TOLERANCE }
    }

    fn check(&self) -> Result<(), RemeshError> {
        let RemeshOptions { min_edge, max_edge, .. } = *self;
        let sound = min_edge > 0.0 && min_edge <= max_edge && max_edge.is_finite();
        if sound { Ok(()) } else { Err(RemeshError::Edges { min_edge, max_edge }) }
    }
}

/// Report of a remeshing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RemeshReport {
    /// Vertices: unknowns of a P1 solver.
    pub unknowns: usize,
    /// Relative error of the volume before the final offset made it exact.
    pub volume_error: f64,
    /// Smallest angle of any triangle \[rad\].
    pub smallest_angle: f64,
    /// 5th percentile of the smallest angles \[rad\].
    pub small_angle: f64,
    /// The edge lengths used: as requested, or shorter where the volume required it.
    pub options: RemeshOptions,
}

/// Reasons why a mesh cannot be remeshed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RemeshError {
    /// Invalid edge lengths.
    #[error(
        "edge lengths from {min_edge:.3e} m to {max_edge:.3e} m: the first must be positive, the second no \
         less"
    )]
    Edges {
        /// Shortest \[m\].
        min_edge: f64,
        /// Longest \[m\].
        max_edge: f64,
    },
    /// The input encloses no solid.
    #[error("the surface cannot be remeshed: {0}")]
    Input(MeshError),
    /// The output encloses no solid: edges are too long for the shape.
    #[error(
        "edges down to {min_edge:.3e} m are too long for this surface, which they make {error}; ask for \
         shorter ones"
    )]
    Tangled {
        /// Shortest target edge tried \[m\].
        min_edge: f64,
        /// Defect of the result.
        error: MeshError,
    },
    /// Too large an error of the volume.
    #[error("edges down to {min_edge:.3e} m change the volume by {volume_error:.2e}; ask for shorter ones")]
    Volume {
        /// Shortest target edge tried \[m\].
        min_edge: f64,
        /// Relative error.
        volume_error: f64,
    },
}

/// Remeshes a closed surface.
///
/// # Errors
/// [`RemeshError`].
pub fn remesh(input: &TriMesh, options: &RemeshOptions) -> Result<(TriMesh, RemeshReport), RemeshError> {
    let (symmetric, report) = remesh_symmetric(input, &[], options)?;
    let centre = MassProperties::of(input).map_err(RemeshError::Input)?.centre_of_mass;
    Ok((symmetric.cell.relative_to(-centre), report))
}

/// Remeshes a closed surface that is symmetric about planes through its centre of mass with the orthogonal
/// unit normals `planes`, such that the result is exactly so. The result is about the centre of mass.
///
/// The input on one side of a plane defines the result.
/// [`mirror_planes`](crate::geometry_class::mirror_symmetry::mirror_planes) gives the distance of the other
/// side from it.
///
/// # Errors
/// [`RemeshError`].
pub fn remesh_symmetric(
    input: &TriMesh,
    planes: &[DVec3],
    options: &RemeshOptions,
) -> Result<(SymmetricMesh, RemeshReport), RemeshError> {
    Topology::try_new(input).map_err(RemeshError::Input)?;
    let mass = MassProperties::of(input).map_err(RemeshError::Input)?;
    let mut options = *options;
    let sound =
        options.min_edge > 0.0 && options.min_edge <= options.max_edge && options.max_edge.is_finite();
    if !sound {
        return Err(RemeshError::Edges { min_edge: options.min_edge, max_edge: options.max_edge });
    }
    // Cut the input down to the cell between the planes.
    let (frame, mirrors) = frame_of(planes);
    let mut cell = input.relative_to(mass.centre_of_mass);
    cell.vertices.iter_mut().for_each(|v| *v = frame.transpose() * *v);
    let mut volume = mass.volume;
    for axis in (0..3).filter(|k| mirrors.test(*k)) {
        cell = positive_half(&cell, axis);
        volume *= 0.5;
    }
    // Remesh the cell, with shorter edges after each failure, until the whole is a valid solid.
    let mut failure = RemeshError::Edges { min_edge: options.min_edge, max_edge: options.max_edge };
    for _ in 0..=REFINEMENTS {
        match attempt(&cell, mirrors, volume, &options) {
            Ok((cell, report)) => {
                let symmetric = SymmetricMesh { cell, mirrors, frame };
                let (whole, _) = symmetric.whole();
                match check_solid(&whole) {
                    Ok(_) => {
                        return Ok((symmetric, RemeshReport { unknowns: whole.vertices.len(), ..report }));
                    }
                    Err(error) => failure = RemeshError::Tangled { min_edge: options.min_edge, error },
                }
            }
            Err(error) => failure = error,
        }
        options.min_edge *= REFINEMENT;
        options.max_edge *= REFINEMENT;
    }
    Err(failure)
}

/// Mass properties of an input that is closed.
fn input_mass(input: &TriMesh) -> Result<MassProperties, RemeshError> {
    // Indices and coordinates first: the pairing of edges depends on them.
    let mass = MassProperties::of(input).map_err(RemeshError::Input)?;
    Topology::try_new(input).map_err(RemeshError::Input)?;
    Ok(mass)
}

/// Remeshes a surface about the origin, or the part of one between planes of symmetry, with given edge
/// lengths.
fn attempt(
    input: &TriMesh,
    mirrors: BVec3,
    volume: f64,
    options: &RemeshOptions,
) -> Result<(TriMesh, RemeshReport), RemeshError> {
    let Guided { surface, creases, size } = Guided::new(input, mirrors, options);
    let guide = Guide::new(&surface, &size);
    let (mut mesh, anchors) = isotropic::remesh_isotropic(&surface, &creases, &size, &guide);
    let freedom: Vec<Freedom> = anchors
        .iter()
        .zip(&mesh.vertices)
        .map(|(anchor, v)| Freedom {
            axes: !(mirrors & v.cmpeq(DVec3::ZERO)),
            sharp: creases.is_sharp(*anchor),
        })
        .collect();
    volume_fit::fit(&mut mesh, &freedom, &guide);
    let volume_error = volume_fit::cone_volume(&mesh) / volume - 1.0;
    if volume_error.is_nan() || volume_error.abs() > options.volume_error {
        return Err(RemeshError::Volume { min_edge: options.min_edge, volume_error });
    }
    volume_fit::offset_to_volume(&mut mesh, &freedom, volume);
    let (smallest_angle, small_angle) = quality::smallest_angles(&mesh);
    let unknowns = mesh.vertices.len();
    let report = RemeshReport { unknowns, volume_error, smallest_angle, small_angle, options: *options };
    Ok((mesh, report))
}

/// The input with its sharp edges and target sizes.
struct Guided {
    surface: TriMesh,
    creases: Creases,
    /// Target edge length at each vertex \[m\].
    size: Vec<f64>,
}

impl Guided {
    fn new(input: &TriMesh, mirrors: BVec3, options: &RemeshOptions) -> Self {
        let RemeshOptions { min_edge, max_edge, .. } = *options;
        // Sizes are stored at vertices, so triangles must be small enough to represent the gradation.
        let finest = (2.3 * input.area() / GUIDE_TRIANGLES).sqrt();
        let surface = refine_to_edge(input, min_edge.max(finest));
        let creases = Creases::find(&surface, SHARP, SHORTEST_NET * min_edge, mirrors);
        let size = size_field::size_field(&surface, &creases, mirrors, min_edge, max_edge);
        Guided { surface, creases, size }
    }
    /// Distribution of the surface's curvature: radius of curvature \[m\], 0 on sharp edges, and integral of
    /// the curvature over the area \[m\]. An edge of length L contributes L π/2, rounded or sharp.
    fn turning(&self) -> Vec<(f64, f64)> {
        let curvature = size_field::curvature(&self.surface, &self.creases, BVec3::FALSE);
        let mut areas = vec![0.0; curvature.len()];
        let mut sharp = 0.0;
        for (t, corners) in self.surface.triangles.iter().enumerate() {
            let area = self.surface.area_vector(t).length();
            corners.iter().for_each(|v| areas[*v as usize] += area / 3.0);
            let ends = self.surface.corners(t);
            for k in (0..3).filter(|k| self.creases.sides[t][*k] != SMOOTH) {
                // Each edge is visited from both triangles.
                sharp += 0.25 * PI * ends[k].distance(ends[(k + 1) % 3]);
            }
        }
        let smooth = curvature.iter().zip(&areas).filter(|(k, _)| **k > 0.0 && k.is_finite());
        std::iter::once((0.0, sharp)).chain(smooth.map(|(k, area)| (1.0 / k, k * area))).collect()
    }
    /// Vertices of a mesh with the target sizes, `density` times those of equilateral triangles.
    fn expected_vertices(&self, density: f64) -> usize {
        let per_area = |t: usize| {
            let inverse = self.surface.triangles[t].map(|v| self.size[v as usize].powi(-2));
            inverse.iter().sum::<f64>() / 3.0
        };
        let sum: f64 = (0..self.surface.triangles.len())
            .map(|t| self.surface.area_vector(t).length() * per_area(t))
            .sum();
        (density * sum / 0.75_f64.sqrt()).ceil() as usize
    }
}
