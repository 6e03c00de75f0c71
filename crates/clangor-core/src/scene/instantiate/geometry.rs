//! Geometry of bodies: which of it a scene needs, and the part that needs no files.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::copies::variation;
use super::{GeometryError, LoadedGeometry};
use crate::scene::body_description::{Geometry, GeometryReference};
use crate::scene::scene_description::Scene;
use crate::shape::Shape;

/// Every distinct geometry of a scene, in the order of its bodies: what the loader of
/// [`instantiate`](super::instantiate()) will be asked for.
pub fn references(scene: &Scene) -> Vec<GeometryReference> {
    let mut seen = BTreeSet::new();
    let mut references = Vec::new();
    for description in &scene.bodies {
        for copy in 0..description.count() {
            let reference = variation(scene, description, copy).reference;
            if seen.insert(reference.key()) {
                references.push(reference);
            }
        }
    }
    references
}

/// Loads a shape of the library, and refuses files: the loader of a scene without mesh files, and a part of
/// any other.
///
/// # Errors
/// The shape's own words.
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
