//! Absorption of walls: random-incidence absorption coefficients in octaves, as in tables of building
//! materials.
//!
//! A reflection at a wall of absorption α keeps √(1 − α) of the pressure, with its sign. The wall is assumed
//! to be hard, with a real reflectance independent of the angle. Not covered: porous walls, which change the
//! phase at low frequency.

use super::room_error::RoomError;

/// Centre frequencies of the octaves \[Hz\].
pub const OCTAVES: [f64; 7] = [125.0, 250.0, 500.0, 1000.0, 2000.0, 4000.0, 8000.0];

/// Share of the energy of a wave that a wall absorbs, for each of the [`OCTAVES`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallAbsorption(pub [f64; OCTAVES.len()]);

impl WallAbsorption {
    /// The same at all frequencies.
    pub fn even(share: f64) -> Self {
        WallAbsorption([share; OCTAVES.len()])
    }

    pub(super) fn check(&self) -> Result<(), RoomError> {
        match self.0.iter().zip(OCTAVES).find(|(share, _)| !(0.0..=1.0).contains(*share)) {
            Some((value, octave)) => Err(RoomError::Absorption { value: *value, octave }),
            None => Ok(()),
        }
    }

    /// Reflectance of the pressure \[-\] at a `frequency` \[Hz\]. It is interpolated over the logarithm of
    /// the frequency between the centres of octaves, and constant beyond the first and the last.
    pub fn reflectance(&self, frequency: f64) -> f64 {
        interpolated(&self.0.map(|share| (1.0 - share).sqrt()), frequency)
    }
}

/// A value for each octave, interpolated over the logarithm of the frequency \[Hz\].
pub(super) fn interpolated(values: &[f64; OCTAVES.len()], frequency: f64) -> f64 {
    let last = OCTAVES.len() - 1;
    let place = (frequency / OCTAVES[0]).log2().clamp(0.0, last as f64);
    let below = (place as usize).min(last - 1);
    let part = place - below as f64;
    values[below] + part * (values[below + 1] - values[below])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn octaves_are_met_and_joined() {
        let wall = WallAbsorption([0.0, 0.19, 0.36, 0.51, 0.64, 0.75, 1.0]);
        let seen = [0.0, 60.0, 125.0, 250.0, 500.0, 8000.0, 20_000.0].map(|f| wall.reflectance(f));
        for (seen, wanted) in seen.into_iter().zip([1.0, 1.0, 1.0, 0.9, 0.8, 0.0, 0.0]) {
            assert!((seen - wanted).abs() < 1e-12, "{seen} {wanted}");
        }
        let between = wall.reflectance(250.0 * 2.0_f64.sqrt());
        assert!((between - 0.85).abs() < 1e-12, "{between}");
        assert_eq!(WallAbsorption::even(0.36).reflectance(777.0), 0.8);
        let bad = WallAbsorption([0.0, 1.5, 0.0, 0.0, 0.0, 0.0, 0.0]);
        assert_eq!(bad.check(), Err(RoomError::Absorption { value: 1.5, octave: 250.0 }));
        assert!(WallAbsorption::even(f64::NAN).check().is_err());
    }
}
