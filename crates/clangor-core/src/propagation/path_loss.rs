//! What walls and air leave of the pressure of a wave on its way: a real factor for each frequency.

use super::{Air, ImageSource, OCTAVES, Room};
use crate::propagation::wall::interpolated;

/// From a source to a receiver, what is lost besides the spreading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathLoss {
    /// Product of the reflectances of all walls that were met, in octaves.
    reflectances: [f64; OCTAVES.len()],
    air: Option<Air>,
    /// Whether the wave is multiplied by the distance \[m\] it has come.
    unspread: bool,
}

impl Default for PathLoss {
    fn default() -> Self {
        PathLoss::through(None)
    }
}

impl PathLoss {
    /// Of the direct way through air that takes from the sound, or does not.
    pub fn through(air: Option<Air>) -> Self {
        PathLoss { reflectances: [1.0; OCTAVES.len()], air, unspread: false }
    }

    /// Of the way by the walls that an image has met.
    pub fn by(image: &ImageSource, room: &Room, air: Option<Air>) -> Self {
        let mut loss = PathLoss::through(air);
        for (wall, times) in room.walls.iter().zip(image.reflections) {
            for (product, share) in loss.reflectances.iter_mut().zip(wall.0) {
                *product *= (1.0 - share).powf(0.5 * f64::from(times));
            }
        }
        loss
    }

    /// The same, times the distance in metres: what
    /// [`LateReverberation`](crate::propagation::LateReverberation) takes.
    pub fn unspread(self) -> Self {
        PathLoss { unspread: true, ..self }
    }

    /// Whether nothing changes.
    pub fn is_none(&self) -> bool {
        *self == PathLoss::default()
    }

    /// At a `frequency` \[Hz\]: what the walls leave, and the attenuation in the air [1/m].
    pub fn at(&self, frequency: f64) -> (f64, f64) {
        let walls = interpolated(&self.reflectances, frequency);
        (walls, self.air.map_or(0.0, |air| air.attenuation(frequency)))
    }

    /// Of a wave with these [`at`](Self::at) that has come `distance` \[m\].
    pub fn gain(&self, (walls, attenuation): (f64, f64), distance: f64) -> f64 {
        let spread = if self.unspread { distance } else { 1.0 };
        spread * walls * (-attenuation * distance).exp()
    }
}
