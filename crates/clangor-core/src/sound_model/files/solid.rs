//! The solid that was baked, as part of a file: mass properties and surface, so that it can be struck without
//! its mesh.

use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

use crate::body::{MeshSurface, Surface};
use crate::geometry::mass_properties::MassProperties;
use crate::geometry::solid::MeshError;
use crate::geometry::tri_mesh::TriMesh;
use crate::quantity;
use crate::sound_model::files::number_checks::within;
use crate::sound_model::files::surface_mesh::{check_mesh, put_mesh, take_mesh};
use crate::sound_model::files::tensor_file::{TensorFileError, TensorReader, TensorWriter};

/// The solid that was baked.
#[derive(Clone, Debug, PartialEq)]
pub struct Solid {
    /// Name given by the user: a shape or a mesh file.
    pub name: String,
    /// Volume, centre of mass in the frame of the file, and inertia, all of unit density.
    pub mass: MassProperties,
    /// The surface, centre of mass at the origin; `None` for a sphere of the model's radius.
    pub surface: Option<TriMesh>,
}

/// The solid in the header of a file.
#[derive(Serialize, Deserialize)]
pub(crate) struct SolidDescription {
    name: String,
    volume_m3: f64,
    centre_of_mass_m: [f64; 3],
    /// Rows of the inertia tensor.
    inertia_per_density_m5: [[f64; 3]; 3],
}

impl Solid {
    /// The surface of a body of this solid; without a stored surface, a sphere of `radius` \[m\].
    ///
    /// # Errors
    /// [`MeshError`] for a surface that does not bound a solid.
    pub fn body_surface(&self, radius: f64) -> Result<Surface, MeshError> {
        Ok(match &self.surface {
            None => Surface::Sphere { radius },
            Some(mesh) => Surface::Mesh(MeshSurface::try_new(mesh.clone(), Vec::new())?.0),
        })
    }

    /// Adds the surface to a file, and returns the description of the rest.
    pub(crate) fn put(&self, file: &mut TensorWriter) -> SolidDescription {
        if let Some(surface) = &self.surface {
            put_mesh(file, "solid", surface);
        }
        SolidDescription {
            name: self.name.clone(),
            volume_m3: self.mass.volume,
            centre_of_mass_m: self.mass.centre_of_mass.to_array(),
            inertia_per_density_m5: self.mass.inertia.transpose().to_cols_array_2d(),
        }
    }

    /// Reads it from a file.
    pub(crate) fn take(file: &TensorReader<'_>, solid: SolidDescription) -> Result<Self, TensorFileError> {
        let mass = MassProperties {
            volume: solid.volume_m3,
            centre_of_mass: DVec3::from_array(solid.centre_of_mass_m),
            inertia: DMat3::from_cols_array_2d(&solid.inertia_per_density_m5).transpose(),
        };
        Ok(Solid { name: solid.name, mass, surface: take_mesh(file, "solid")? })
    }

    /// Rejects mass properties that no solid of this bounding radius \[m\] has.
    pub(crate) fn check(&self, radius: f64) -> Result<(), TensorFileError> {
        if let Some(surface) = &self.surface {
            check_mesh("solid", surface, radius)?;
        }
        let mass = &self.mass;
        within("the volume", mass.volume, &quantity::VOLUME)?;
        if !mass.centre_of_mass.is_finite() {
            return Err(TensorFileError::value("the centre of mass", "is not finite"));
        }
        let symmetric = mass.inertia.abs_diff_eq(mass.inertia.transpose(), 1e-9 * mass.inertia.x_axis.x);
        if !(symmetric && mass.inertia.determinant() > 0.0 && mass.inertia.is_finite()) {
            return Err(TensorFileError::value("the inertia tensor", "is not that of a solid"));
        }
        Ok(())
    }
}
