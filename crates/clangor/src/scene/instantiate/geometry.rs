//! Geometry of bodies: which of it a scene needs, and the part that needs no files.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::copies::variation;
use super::{GeometryError, LoadedGeometry};
use crate::body::{MeshSurface, Surface};
use crate::geometry::convex::ConvexPart;
use crate::scene::Scene;
use crate::scene::body_description::{Geometry, GeometryReference};
use crate::shape::{Form, Shape};

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

impl GeometryReference {
    /// What tells geometries apart.
    pub(super) fn key(&self) -> (Geometry, u64) {
        (self.geometry.clone(), self.scale.to_bits())
    }
}

/// Loads a shape of the library, and refuses files: the loader of a scene without mesh files, and a part of any other.
///
/// Mass properties are those of [`Shape::surface`]; of a scaled shape that is no sphere, those of its mesh.
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
    let scale = reference.scale;
    let (surface, mass) = if scale == 1.0 {
        shape.surface().map_err(|e| refuse(e.to_string()))?
    } else if let Some(radius) = shape.sphere_radius() {
        let sphere = Shape::try_new(Form::Sphere { radius: radius * scale }, None);
        sphere.map_err(|e| refuse(e.to_string()))?.surface().map_err(|e| refuse(e.to_string()))?
    } else {
        let mut mesh = shape.mesh();
        mesh.vertices.iter_mut().for_each(|v| *v *= scale);
        let parts = shape.parts().iter().map(|part| scaled(part, scale)).collect();
        let (surface, mass) = MeshSurface::try_new(mesh, parts).map_err(|e| refuse(e.to_string()))?;
        (Surface::Mesh(surface), mass)
    };
    Ok(LoadedGeometry { surface: Arc::new(surface), mass, warnings: Vec::new() })
}

fn scaled(part: &ConvexPart, scale: f64) -> ConvexPart {
    match part {
        ConvexPart::Ball { centre, radius } => {
            ConvexPart::Ball { centre: *centre * scale, radius: radius * scale }
        }
        ConvexPart::Cylinder { centre, axis, radius, half_height } => ConvexPart::Cylinder {
            centre: *centre * scale,
            axis: *axis,
            radius: radius * scale,
            half_height: half_height * scale,
        },
        ConvexPart::Hull(points) => ConvexPart::Hull(points.iter().map(|p| *p * scale).collect()),
    }
}
