//! The fluid that carries the sound: density and speed of sound, the only two numbers linear acoustics needs.

/// A homogeneous fluid at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Medium {
    /// Density ρ [kg/m³].
    pub density: f64,
    /// Speed of sound c [m/s].
    pub sound_speed: f64,
}

impl Medium {
    /// Dry air at 20 °C and 101.325 kPa: 1.2041 kg/m³, 343.2 m/s, the values of \[PAN\] §2.
    pub const AIR: Medium = Medium { density: 1.2041, sound_speed: 343.2 };
}

impl Default for Medium {
    fn default() -> Self {
        Medium::AIR
    }
}
