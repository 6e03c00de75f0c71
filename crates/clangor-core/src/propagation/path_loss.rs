//! Attenuation along a propagation path by walls and air: a real factor for each frequency.

use super::wall::interpolated;
use super::{Air, ImageSource, OCTAVES, WallAbsorption};

/// Loss of a path from a source to a receiver, apart from spherical spreading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathLoss {
    /// Product of the reflectances of all walls on the path, in octaves.
    reflectances: [f64; OCTAVES.len()],
    air: Option<Air>,
    /// Whether the wave is multiplied by the length of its path \[m\].
    unspread: bool,
}

impl Default for PathLoss {
    fn default() -> Self {
        PathLoss::through(None)
    }
}

impl PathLoss {
    /// Of the direct path, through air that absorbs or not.
    pub fn through(air: Option<Air>) -> Self {
        PathLoss { reflectances: [1.0; OCTAVES.len()], air, unspread: false }
    }

    /// Of the path of an image by reflectors of this absorption.
    pub fn by(image: &ImageSource, walls: &[WallAbsorption], air: Option<Air>) -> Self {
        let mut loss = PathLoss::through(air);
        for (wall, times) in walls.iter().zip(image.reflections) {
            for (product, share) in loss.reflectances.iter_mut().zip(wall.0) {
                *product *= (1.0 - share).powf(0.5 * f64::from(times));
            }
        }
        loss
    }

    /// The same, times the distance in metres: the input of
    /// [`LateReverberation`](crate::propagation::LateReverberation).
    pub fn unspread(self) -> Self {
        PathLoss { unspread: true, ..self }
    }

    /// Whether there are no losses.
    pub fn is_none(&self) -> bool {
        *self == PathLoss::default()
    }

    /// Whether walls filter the wave.
    pub fn has_walls(&self) -> bool {
        self.reflectances != [1.0; OCTAVES.len()]
    }

    /// Whether both lose the same, up to rounding.
    pub(super) fn is_close(&self, other: &PathLoss) -> bool {
        let pairs = self.reflectances.iter().zip(&other.reflectances);
        let close = pairs.map(|(a, b)| (a - b).abs()).all(|difference| difference < 1e-12);
        close && (self.air, self.unspread) == (other.air, other.unspread)
    }

    /// At a `frequency` \[Hz\]: reflectance of the walls \[-\], and attenuation in air [1/m].
    pub fn at(&self, frequency: f64) -> (f64, f64) {
        let walls = interpolated(&self.reflectances, frequency);
        (walls, self.air.map_or(0.0, |air| air.attenuation(frequency)))
    }

    /// Factor for a wave with these losses [`at`](Self::at) a frequency over a path of `distance` \[m\].
    pub fn gain(&self, (walls, attenuation): (f64, f64), distance: f64) -> f64 {
        let spread = if self.unspread { distance } else { 1.0 };
        spread * walls * (-attenuation * distance).exp()
    }
}
