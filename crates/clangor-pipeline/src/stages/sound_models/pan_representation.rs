//! Sound models in the representation of \[PAN\], for comparison.

use clangor_bake::reference::{PanForm, PanModelError, pan_model};
use clangor_core::reference::pan_file::PanFile;
use clangor_core::sound_model::files::model_file::ModelFile;

/// A model in the representation of \[PAN\].
///
/// # Errors
/// [`PanModelError`].
pub fn pan_representation(file: &ModelFile, form: PanForm) -> Result<PanFile, PanModelError> {
    let mut origin = file.origin.clone();
    origin.warnings.push(match form {
        PanForm::Angles { rows, columns } => {
            format!("the published representation on {rows} by {columns} directions: compare, do not trust")
        }
        PanForm::Octant { tolerance } => {
            format!("the published representation on an octant, tolerance {tolerance}: compare, do not trust")
        }
    });
    Ok(PanFile { model: pan_model(&file.acceleration, form)?, solid: file.solid.clone(), origin })
}
