//! Geometry of bodies: the result of a loader, and the loader that needs no files.

use std::sync::Arc;

use crate::body::Surface;
use crate::geometry::mass_properties::MassProperties;
use crate::scene::body_description::{Geometry, GeometryReference};
use crate::shape::Shape;

/// Geometry of a body, as the loader returns it.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadedGeometry {
    /// The surface, centre of mass at the origin, scaled.
    pub surface: Arc<Surface>,
    /// Mass properties of unit density, scaled, in the frame of the shape or file.
    pub mass: MassProperties,
    /// Warnings for the user.
    pub warnings: Vec<String>,
}

/// Error of a loader.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{reason}; {remedy}")]
pub struct GeometryError {
    /// Reason.
    pub reason: String,
    /// Remedy.
    pub remedy: String,
}

/// Builds a shape or reads a mesh file.
pub type Loader<'a> = dyn FnMut(&GeometryReference) -> Result<LoadedGeometry, GeometryError> + 'a;

/// Loads a shape of the library, and rejects files. For scenes without mesh files, and as a part of other
/// loaders.
///
/// # Errors
/// The error of the shape.
pub fn load_shape(reference: &GeometryReference) -> Result<LoadedGeometry, GeometryError> {
    let Geometry::Shape(text) = &reference.geometry else {
        return Err(GeometryError {
            reason: "no mesh files can be read here".into(),
            remedy: "use a shape of the library".into(),
        });
    };
    let refuse = |reason: String| GeometryError { reason, remedy: "change the sizes of the shape".into() };
    let shape = Shape::parse(text).map_err(|e| refuse(e.to_string()))?;
    let (surface, mass) = shape.surface().map_err(|e| refuse(e.to_string()))?;
    let (surface, mass) = match reference.scale {
        1.0 => (surface, mass),
        scale => (surface.scaled(scale), mass.scaled(scale)),
    };
    Ok(LoadedGeometry { surface: Arc::new(surface), mass, warnings: Vec::new() })
}
