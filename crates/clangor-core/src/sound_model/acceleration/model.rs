//! Acceleration model of one body: its field, its size, and its near field.

use crate::sound_model::acceleration::field::AccelerationField;
use crate::sound_model::acceleration::near_field::NearField;

/// Pressure of a rigid body's acceleration, in the frame of the body: origin at the centre of mass, axes of
/// the mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct AccelerationModel {
    /// Bounding radius R \[m\] about the centre of mass, the unit of length of the field.
    pub radius: f64,
    /// The field outside the bounding sphere.
    pub field: AccelerationField,
    /// The field inside it; `None`: a listener there gets the field on the bounding sphere.
    pub near: Option<NearField>,
}

impl AccelerationModel {
    /// Highest frequency \[Hz\] of the model, in a medium of this speed of sound [m/s].
    pub fn max_frequency(&self, sound_speed: f64) -> f64 {
        self.field.max_wavenumber * sound_speed / (std::f64::consts::TAU * self.radius)
    }
}
