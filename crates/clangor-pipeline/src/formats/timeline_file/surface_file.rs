//! Mesh surfaces as binary PLY: positions and curvatures in `f64`, so that they come back bit by bit.
//!
//! A file is named after the hash of its content. One without principal curvatures is read with the mean
//! curvature in all directions.

use std::fs;
use std::path::Path;

use clangor_core::body::MeshSurface;
use clangor_core::geometry::principal_curvature::Curvature;
use glam::DVec3;

use super::error::TimelineError;
use super::hash;
use crate::formats::mesh_reader::{Located, MeshFault, ply};

/// Names of the vertex properties: mean curvature, κ₁, κ₂ [1/m], and the direction of κ₁.
const PROPERTIES: [&str; 6] =
    ["mean_curvature", "curvature_1", "curvature_2", "direction_x", "direction_y", "direction_z"];

/// The content of the file of a surface.
pub(super) fn to_bytes(surface: &MeshSurface) -> Vec<u8> {
    let comment = "metres, centre of mass at the origin; curvatures in 1/m, positive where convex, \
                   curvature_1 along the direction";
    let values = |(mean, curvature): (&f64, &Curvature)| {
        let ([first, second], direction) = (curvature.principal, curvature.direction);
        [*mean, first, second, direction.x, direction.y, direction.z]
    };
    let rows: Vec<[f64; 6]> = surface.mean_curvature.iter().zip(&surface.curvature).map(values).collect();
    ply::to_bytes(&surface.mesh, PROPERTIES, &rows, comment)
}

/// Reads the surface with this hash and volume [m³].
pub(super) fn read(path: &Path, expected_hash: &str, volume: f64) -> Result<MeshSurface, TimelineError> {
    let bytes = fs::read(path).map_err(|source| hash::read_error(path, source))?;
    hash::check(path, &hash::of(&bytes), expected_hash)?;
    let mesh_error = |l: Located| TimelineError::Mesh { path: path.into(), place: l.place, fault: l.fault };
    let mut ply = ply::parse(&bytes, &PROPERTIES).map_err(mesh_error)?;
    let vertices = ply.mesh.vertices.len();
    let tensor = ply.extra.split_off(1);
    let mean = ply.extra.swap_remove(0);
    let has_tensor = tensor.iter().any(|values| !values.is_empty());
    let fault = if ply.mesh.triangles.is_empty() {
        Some(MeshFault::Empty)
    } else if mean.len() != vertices {
        Some(MeshFault::Syntax { reason: "the vertices lack the property mean_curvature" })
    } else if has_tensor && tensor.iter().any(|values| values.len() != vertices) {
        let reason =
            "the vertices have some of curvature_1, curvature_2, direction_x, _y and _z, but not all";
        Some(MeshFault::Syntax { reason })
    } else if !mean.iter().chain(tensor.iter().flatten()).all(|value| value.is_finite()) {
        Some(MeshFault::NotFinite)
    } else {
        None
    };
    if let Some(fault) = fault {
        return Err(mesh_error(Located::whole(fault)));
    }
    let surface = MeshSurface::restored(ply.mesh, mean, volume);
    let [first, second, x, y, z] = tensor.as_slice() else { return Ok(surface) };
    if !has_tensor {
        return Ok(surface);
    }
    let at =
        |i: usize| Curvature { principal: [first[i], second[i]], direction: DVec3::new(x[i], y[i], z[i]) };
    Ok(surface.with_curvature((0..vertices).map(at).collect()))
}
