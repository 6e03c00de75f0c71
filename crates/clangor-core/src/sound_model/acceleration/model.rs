//! What one body sounds like when it is accelerated: its field, its size, and the field close to it.

use crate::sound_model::acceleration::field::AccelerationField;
use crate::sound_model::acceleration::near_field::NearField;

/// The sound of a rigid body's acceleration, in the frame of the body: its centre of mass, the axes of its
/// mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct AccelerationModel {
    /// Bounding radius R \[m\] about the centre of mass, the unit of length of the field.
    pub radius: f64,
    /// The field outside the bounding sphere.
    pub field: AccelerationField,
    /// The field inside it; without it, a listener there hears the field of the bounding sphere.
    pub near: Option<NearField>,
}

impl AccelerationModel {
    /// Highest frequency \[Hz\] at which the model is known, in a medium of this speed of sound [m/s].
    pub fn max_frequency(&self, sound_speed: f64) -> f64 {
        self.field.max_wavenumber * sound_speed / (std::f64::consts::TAU * self.radius)
    }
}
