//! Geometry of bodies: the result of a loader, and the loader that needs no files.

use std::sync::Arc;

use glam::DVec3;

use crate::body::{MeshSurface, Surface};
use crate::geometry::convex::ConvexPart;
use crate::geometry::mass_properties::MassProperties;
use crate::geometry::principal_curvature::Curvature;
use crate::scene::body_description::{Geometry, GeometryReference};
use crate::scene::diagnostic::shape_remedy;
use crate::shape::{Form, Shape, ShapeError};

/// Geometry of a body, as the loader returns it.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadedGeometry {
    /// The surface, centre of mass at the origin, scaled.
    pub surface: Arc<Surface>,
    /// Mass properties of unit density, scaled, in the frame of the shape or file; a given centre of mass has
    /// the inertia of the homogeneous solid about its own.
    pub mass: MassProperties,
    /// Warnings for the user.
    pub warnings: Vec<String>,
}

impl LoadedGeometry {
    /// The same solid with another centre of mass \[m\], in the frame of the shape or file. The inertia stays
    /// that of the homogeneous solid about its own centre. A sphere becomes a mesh that collides as the
    /// sphere.
    ///
    /// # Errors
    /// A sphere without a mesh.
    pub fn with_centre_of_mass(self, centre: DVec3) -> Result<Self, GeometryError> {
        let away = centre - self.mass.centre_of_mass;
        let surface = match &*self.surface {
            Surface::Sphere { radius } => off_centre_sphere(*radius, away)?,
            Surface::Mesh(mesh) => Surface::Mesh(mesh.relative_to(away)),
            plane => plane.clone(),
        };
        let mass = MassProperties { centre_of_mass: centre, ..self.mass };
        Ok(LoadedGeometry { surface: Arc::new(surface), mass, ..self })
    }
}

/// A sphere whose centre is at −`away` \[m\].
fn off_centre_sphere(radius: f64, away: DVec3) -> Result<Surface, GeometryError> {
    let refuse = |reason: String| GeometryError { reason, remedy: "leave out its centre of mass".into() };
    let sphere = Shape::try_new(Form::Sphere { radius }, None).map_err(|e| refuse(e.to_string()))?;
    let parts = vec![ConvexPart::Ball { centre: DVec3::ZERO, radius }];
    let (mut surface, _) = MeshSurface::try_new(sphere.mesh(), parts).map_err(|e| refuse(e.to_string()))?;
    let count = surface.mesh.vertices.len();
    let round = Curvature::isotropic(radius.recip());
    surface.mean_curvature = vec![radius.recip(); count];
    Ok(Surface::Mesh(surface.with_curvature(vec![round; count]).relative_to(away)))
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
    let refuse =
        |error: ShapeError| GeometryError { reason: error.to_string(), remedy: shape_remedy(&error) };
    let shape = Shape::parse(text).map_err(refuse)?;
    let (surface, mass) = shape.surface().map_err(|error| refuse(ShapeError::Mesh(error)))?;
    let (surface, mass) = match reference.scale {
        1.0 => (surface, mass),
        scale => (surface.scaled(scale), mass.scaled(scale)),
    };
    let geometry = LoadedGeometry { surface: Arc::new(surface), mass, warnings: Vec::new() };
    match reference.centre_of_mass {
        Some(centre) => geometry.with_centre_of_mass(centre),
        None => Ok(geometry),
    }
}
