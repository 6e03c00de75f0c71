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

    /// Dry air at 101.325 kPa and a temperature [°C], as an ideal gas: `ρ = p/(R T)`, `c = √(γ R T)` with
    /// R = 287.05 J/(kg K) and γ = 1.4.
    pub fn dry_air(celsius: f64) -> Medium {
        const PRESSURE: f64 = 101_325.0;
        const GAS_CONSTANT: f64 = 287.05;
        const HEAT_CAPACITY_RATIO: f64 = 1.4;
        let kelvin = celsius + 273.15;
        Medium {
            density: PRESSURE / (GAS_CONSTANT * kelvin),
            sound_speed: (HEAT_CAPACITY_RATIO * GAS_CONSTANT * kelvin).sqrt(),
        }
    }
}

impl Default for Medium {
    fn default() -> Self {
        Medium::AIR
    }
}
