//! The bank of ringing ellipsoids that fits a material: the one that comes with the program, one of the cache, or baked now.
//!
//! The bank of the program is of glass in air; it serves what differs little from it, as ceramic does
//! (`clangor::model::modal_bank`). Another material has a bank of its own, which takes minutes once.

use std::ops::ControlFlow;

use clangor::material::Material;
use clangor::medium::Medium;
use clangor::model::modal_bank::{BankMaterial, ModalSoundbank};
use clangor::model::modal_bank_file::{ModalBankFile, ModalBankOrigin};
use clangor_bake::modal_bank::{BankOptions, ModalBankBakeError, build_bank};

use crate::model_cache::{Lookup, ModelCache, modal_bank_key};

/// What `clangor bank build --modal --material glass` made, as it comes with the program.
const DEFAULT_BANK: &[u8] = include_bytes!("../../../data/modal_bank.safetensors");

/// The bank that comes with the program; `None` if it cannot be used.
pub fn default_modal_bank() -> Option<ModalSoundbank> {
    Some(ModalBankFile::decode(DEFAULT_BANK).ok()?.bank)
}

/// What a bank has to know of a material, and of what carries the sound.
pub fn bank_material(material: &Material, medium: Medium) -> BankMaterial {
    let Material { youngs_modulus, density, poisson_ratio, .. } = *material;
    BankMaterial { youngs_modulus, density, poisson_ratio, medium }
}

/// Bakes a bank. `progress` is told which part of the work is done, from 0 to 1.
///
/// # Errors
/// [`ModalBankBakeError`].
pub fn build_modal_bank(
    material: &str,
    options: &BankOptions,
    progress: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<ModalBankFile, ModalBankBakeError> {
    let bank = build_bank(options, progress)?;
    let origin = ModalBankOrigin {
        program: format!("clangor {}", env!("CARGO_PKG_VERSION")),
        inputs: modal_bank_key(options),
        material: material.into(),
        asked_accuracy: options.accuracy,
        spacing: options.spacing,
        least_first_frequency: options.least_first_frequency,
        largest_size: options.largest_size,
        max_frequency: options.max_frequency,
    };
    Ok(ModalBankFile { bank, origin })
}

/// A bank, and what had to be done for it.
#[derive(Clone, Debug, PartialEq)]
pub struct ObtainedBank {
    /// The bank.
    pub bank: ModalSoundbank,
    /// What the person should know.
    pub remarks: Vec<String>,
}

/// The bank for a material: that of the program if it serves, one of the cache, or one that is baked and put there.
///
/// # Errors
/// [`ModalBankBakeError`].
pub fn obtain_modal_bank(
    material: &Material,
    medium: Medium,
    cache: Option<&ModelCache>,
    progress: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<ObtainedBank, ModalBankBakeError> {
    let wanted = bank_material(material, medium);
    let mut remarks = Vec::new();
    if let Some(bank) = default_modal_bank().filter(|bank| bank.serves(&wanted).is_ok()) {
        return Ok(ObtainedBank { bank, remarks });
    }
    let options = BankOptions::new(wanted);
    let key = modal_bank_key(&options);
    match cache.map_or(Lookup::Missing, |cache| cache.read_modal_bank(&key)) {
        Lookup::Found(file) => return Ok(ObtainedBank { bank: file.bank, remarks }),
        Lookup::Missing => {}
        Lookup::Invalid(why) => remarks.push(format!("{why}; it is baked again")),
    }
    let mut file = build_modal_bank(&material.name, &options, progress)?;
    // What is played is what a file keeps, now and after.
    let stored = file.encode().and_then(|bytes| ModalBankFile::decode(&bytes));
    if let Ok(stored) = stored {
        file = stored;
    }
    if let Some(Err(error)) = cache.map(|cache| cache.write_modal_bank(&file)) {
        remarks.push(format!("the modal bank of {} is not kept: {error}", material.name));
    }
    Ok(ObtainedBank { bank: file.bank, remarks })
}

#[cfg(test)]
mod tests {
    use clangor::material::presets::{CERAMIC, GLASS, PLASTIC};

    use super::*;

    #[test]
    fn the_bank_that_is_shipped_can_be_played() {
        let bank = default_modal_bank().expect("a bank");
        assert!(DEFAULT_BANK.len() < 2_000_000, "{} bytes", DEFAULT_BANK.len());
        let serves = |material: &Material| bank.serves(&bank_material(material, Medium::AIR)).is_ok();
        assert!(serves(&GLASS.material()) && serves(&CERAMIC.material()) && !serves(&PLASTIC.material()));
        let origin = ModalBankFile::decode(DEFAULT_BANK).expect("a bank").origin;
        let options = BankOptions::new(bank_material(&GLASS.material(), Medium::AIR));
        assert_eq!(origin.inputs, modal_bank_key(&options));
    }
}
