//! The fracture of one body, limited by its strain energy.

use super::error::FractureError;
use super::pattern::{PatternSettings, draw_pattern};
use super::piece::Piece;
use super::split::{CrackFace, Score, Split, split_by_regions, split_by_scores};

/// The pieces and energies of a broken body.
#[derive(Clone, Debug, PartialEq)]
pub struct Shatter {
    /// The pieces, in the frame of the body.
    pub pieces: Vec<Piece>,
    /// The triangles between them.
    pub crack_faces: Vec<CrackFace>,
    /// Strain energy E_S before the fracture \[J\].
    pub strain_energy: f64,
    /// Energy E_F = G_c A_F of the cracks \[J\]; at most η E_S.
    pub fracture_energy: f64,
}

impl Shatter {
    /// Energy that remains for the motion of the pieces, E_S − E_F \[J\].
    pub fn surplus(&self) -> f64 {
        self.strain_energy - self.fracture_energy
    }
}

/// Breaks a body as far as its strain energy \[J\] allows; `energy_density` \[J/m³\] is given for each corner
/// of its mesh. `None` if the energy is too small for any crack.
///
/// # Errors
/// [`FractureError`].
pub fn shatter(
    body: &Piece,
    energy_density: &[f64],
    strain_energy: f64,
    settings: &PatternSettings,
) -> Result<Option<Shatter>, FractureError> {
    let Some(pattern) = draw_pattern(&body.mesh, energy_density, strain_energy, settings)? else {
        return Ok(None);
    };
    Ok(afforded(split_by_regions(body, &pattern.region)?, strain_energy, settings))
}

/// Breaks a body along all its scored planes at once. `None` if they do not divide it, or if the cracks need
/// more than the available strain energy \[J\].
///
/// # Errors
/// [`FractureError`].
pub fn shatter_along(
    body: &Piece,
    scores: &[Score],
    strain_energy: f64,
    settings: &PatternSettings,
) -> Result<Option<Shatter>, FractureError> {
    settings.check()?;
    if !(strain_energy >= 0.0 && strain_energy.is_finite()) {
        return Err(FractureError::Setting { setting: "strain energy", value: strain_energy });
    }
    Ok(afforded(split_by_scores(body, scores)?, strain_energy, settings))
}

fn afforded(split: Option<Split>, strain_energy: f64, settings: &PatternSettings) -> Option<Shatter> {
    let Split { pieces, crack_faces } = split?;
    let area: f64 = crack_faces.iter().map(|f| f.area_vector().length()).sum();
    let fracture_energy = settings.fracture_energy * area;
    // The tolerance covers the other order of summation in the pattern.
    let affordable = settings.efficiency * strain_energy * (1.0 + 1e-12);
    (fracture_energy <= affordable).then_some(Shatter { pieces, crack_faces, strain_energy, fracture_energy })
}
