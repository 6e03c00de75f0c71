//! Absorption of sound in air: ISO 9613-1:1993, "Acoustics — Attenuation of sound during propagation outdoors
//! — Part 1: Calculation of the absorption of sound by the atmosphere".
//!
//! ```text
//! α = 8.686 f² { 1.84e-11 (p/p_r)⁻¹ (T/T₀)^½ + (T/T₀)^(−5/2) [ 0.01275 e^(−2239.1/T) / (f_O + f²/f_O)
//!                                                           + 0.1068 e^(−3352/T) / (f_N + f²/f_N) ] } [dB/m]
//! f_O = (p/p_r) (24 + 4.04e4 h (0.02 + h)/(0.391 + h))                         oxygen
//! f_N = (p/p_r) (T/T₀)^(−½) (9 + 280 h exp(−4.17 ((T/T₀)^(−⅓) − 1)))           nitrogen
//! h = h_r (p_sat/p_r)/(p/p_r),   p_sat/p_r = 10^(4.6151 − 6.8346 (273.16/T)^1.261)
//! ```
//!
//! with T₀ = 293.15 K, p_r = 101.325 kPa, and the relative humidity h_r in percent. Included are viscosity,
//! heat conduction and molecular relaxation; not wind or fog. The associated dispersion, below 1e-4 of the
//! speed, is neglected.

use std::f64::consts::LN_10;

/// The state of air.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Air {
    /// Temperature [°C].
    pub celsius: f64,
    /// Relative humidity, 0 to 1 \[-\].
    pub humidity: f64,
    /// Pressure \[Pa\].
    pub pressure: f64,
}

impl Default for Air {
    /// Indoor air: 20 °C, relative humidity 0.5, sea level.
    fn default() -> Self {
        Air { celsius: 20.0, humidity: 0.5, pressure: REFERENCE_PRESSURE }
    }
}

/// p_r \[Pa\].
const REFERENCE_PRESSURE: f64 = 101_325.0;

/// Decibels per neper: pressure falls by the factor e over this level difference.
const DECIBELS_PER_NEPER: f64 = 20.0 / LN_10;

impl Air {
    /// Attenuation of pressure [1/m], e^(−αr), of a wave of `frequency` \[Hz\].
    pub fn attenuation(&self, frequency: f64) -> f64 {
        let kelvin = self.celsius + 273.15;
        let warmth = kelvin / 293.15;
        let pressure = self.pressure / REFERENCE_PRESSURE;
        let saturation = 10.0_f64.powf(4.6151 - 6.8346 * (273.16 / kelvin).powf(1.261));
        let h = 100.0 * self.humidity * saturation / pressure;
        let oxygen = pressure * (24.0 + 4.04e4 * h * (0.02 + h) / (0.391 + h));
        let nitrogen =
            pressure / warmth.sqrt() * (9.0 + 280.0 * h * (-4.17 * (warmth.cbrt().recip() - 1.0)).exp());
        let square = frequency * frequency;
        let classical = 1.84e-11 / pressure * warmth.sqrt();
        let vibration = 0.01275 * (-2239.1 / kelvin).exp() / (oxygen + square / oxygen)
            + 0.1068 * (-3352.0 / kelvin).exp() / (nitrogen + square / nitrogen);
        let decibels = 8.686 * square * (classical + warmth.powf(-2.5) * vibration);
        decibels / DECIBELS_PER_NEPER
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn attenuation_is_that_of_the_table() {
        // ISO 9613-2:1996, table 2 [dB/km], octaves from 63 Hz to 8 kHz, whose exact middles are powers of
        // 10^0.3.
        let table = [
            (10.0, 0.7, [0.1, 0.4, 1.0, 1.9, 3.7, 9.7, 32.8, 117.0]),
            (20.0, 0.7, [0.1, 0.3, 1.1, 2.8, 5.0, 9.0, 22.9, 76.6]),
            (30.0, 0.7, [0.1, 0.3, 1.0, 3.1, 7.4, 12.7, 23.1, 59.3]),
            (15.0, 0.2, [0.3, 0.6, 1.2, 2.7, 8.2, 28.2, 88.8, 202.0]),
            (15.0, 0.5, [0.1, 0.5, 1.2, 2.2, 4.2, 10.8, 36.2, 129.0]),
            (15.0, 0.8, [0.1, 0.3, 1.1, 2.4, 4.1, 8.3, 23.7, 82.8]),
        ];
        for (celsius, humidity, row) in table {
            let air = Air { celsius, humidity, ..Air::default() };
            for (k, printed) in row.into_iter().enumerate() {
                let frequency = 1000.0 * 10.0_f64.powf(0.3 * (k as f64 - 4.0));
                let seen = 1000.0 * DECIBELS_PER_NEPER * air.attenuation(frequency);
                // Half a unit of the last printed digit.
                let rounding = if printed > 100.0 { 0.5 } else { 0.05 };
                assert!(
                    (seen - printed).abs() < rounding + 2e-3 * printed,
                    "{celsius} {frequency} {seen} {printed}"
                );
            }
        }
    }
}
