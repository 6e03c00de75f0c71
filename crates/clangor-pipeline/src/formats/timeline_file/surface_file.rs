//! Mesh surfaces as binary PLY: positions and mean curvature in `f64`, so that they come back bit by bit.
//!
//! A file is named after the hash of its content.

use std::fs;
use std::path::Path;

use clangor_core::body::MeshSurface;

use super::error::TimelineError;
use super::hash;
use crate::formats::mesh_reader::{Located, MeshFault, ply};

/// Name of the vertex property that holds the mean curvature [1/m].
const CURVATURE: &str = "mean_curvature";

/// The content of the file of a surface.
pub(super) fn to_bytes(surface: &MeshSurface) -> Vec<u8> {
    let comment = "metres, centre of mass at the origin; mean_curvature in 1/m, positive where convex";
    ply::to_bytes(&surface.mesh, CURVATURE, &surface.mean_curvature, comment)
}

/// Reads the surface with this hash and volume [m³].
pub(super) fn read(path: &Path, expected_hash: &str, volume: f64) -> Result<MeshSurface, TimelineError> {
    let bytes = fs::read(path).map_err(|source| hash::read_error(path, source))?;
    hash::check(path, &hash::of(&bytes), expected_hash)?;
    let mesh_error = |l: Located| TimelineError::Mesh { path: path.into(), place: l.place, fault: l.fault };
    let ply = ply::parse(&bytes, Some(CURVATURE)).map_err(mesh_error)?;
    let fault = if ply.mesh.triangles.is_empty() {
        Some(MeshFault::Empty)
    } else if ply.extra.len() != ply.mesh.vertices.len() {
        Some(MeshFault::Syntax { reason: "the vertices lack the property mean_curvature" })
    } else if !ply.extra.iter().all(|h| h.is_finite()) {
        Some(MeshFault::NotFinite)
    } else {
        None
    };
    match fault {
        Some(fault) => Err(mesh_error(Located::whole(fault))),
        None => Ok(MeshSurface::restored(ply.mesh, ply.extra, volume)),
    }
}
