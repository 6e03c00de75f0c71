//! The bank of ringing ellipsoids of a material: out of the cache, or baked and put there, which takes
//! minutes once.
//!
//! Ceramic is played by the bank of glass, from which it differs little
//! (`clangor_core::sound_model::soundbank::modal_soundbank`): a bank belongs to the first of a few common
//! materials that it serves.

use std::ops::ControlFlow;

use clangor_bake::soundbank::modal::{ModalSoundbankBakeError, ModalSoundbankOptions, build_bank};
use clangor_core::material::Material;
use clangor_core::material::presets::GLASS;
use clangor_core::medium::Medium;
use clangor_core::sound_model::files::modal_soundbank_file::{ModalSoundbankFile, ModalSoundbankOrigin};
use clangor_core::sound_model::soundbank::modal_soundbank::{BankMaterial, ModalSoundbank, serves};

use crate::formats::model_cache::{Lookup, ModelCache, modal_soundbank_key};

/// The bank of glass that comes with the program: `clangor bank build --modal --material glass`.
const DEFAULT_BANK: &[u8] = include_bytes!("../../../../data/modal_soundbank.safetensors");

/// The bank that comes with the program; `None` is impossible, and a test says so.
pub fn default_modal_soundbank() -> Option<ModalSoundbank> {
    Some(ModalSoundbankFile::decode(DEFAULT_BANK).ok()?.bank)
}

/// What a bank has to know of a material, and of what carries the sound.
pub fn bank_material(material: &Material, medium: Medium) -> BankMaterial {
    let Material { youngs_modulus, density, poisson_ratio, .. } = *material;
    BankMaterial { youngs_modulus, density, poisson_ratio, medium }
}

/// Bakes a bank. `progress` is told which part of the work is done, from 0 to 1.
///
/// # Errors
/// [`ModalSoundbankBakeError`].
pub fn build_modal_soundbank(
    material: &str,
    options: &ModalSoundbankOptions,
    progress: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<ModalSoundbankFile, ModalSoundbankBakeError> {
    let bank = build_bank(options, progress)?;
    let origin = ModalSoundbankOrigin {
        program: format!("clangor {}", env!("CARGO_PKG_VERSION")),
        inputs: modal_soundbank_key(options),
        material: material.into(),
        asked_accuracy: options.accuracy,
        spacing: options.spacing,
        least_first_frequency: options.least_first_frequency,
        largest_size: options.largest_size,
        max_frequency: options.max_frequency,
    };
    Ok(ModalSoundbankFile { bank, origin })
}

/// A bank, and what had to be done for it.
#[derive(Clone, Debug, PartialEq)]
pub struct ObtainedBank {
    /// The bank.
    pub bank: ModalSoundbank,
    /// What the person should know.
    pub remarks: Vec<String>,
}

/// The material whose bank a body of another is played with.
fn shared_material(material: &Material, medium: Medium) -> (String, BankMaterial) {
    let wanted = bank_material(material, medium);
    let glass = bank_material(&GLASS.material(), medium);
    match serves(&glass, &wanted) {
        Ok(()) => (GLASS.name.into(), glass),
        Err(_) => (material.name.clone(), wanted),
    }
}

/// Whether the bank for a material is there without a bake.
pub fn is_at_hand(material: &Material, medium: Medium, cache: Option<&ModelCache>) -> bool {
    let (_, of) = shared_material(material, medium);
    let comes = default_modal_soundbank().is_some_and(|bank| serves(bank.material(), &of).is_ok());
    let key = modal_soundbank_key(&ModalSoundbankOptions::new(of));
    comes || cache.is_some_and(|cache| cache.path::<ModalSoundbankFile>(&key).is_file())
}

/// The bank for a material: out of the cache, or baked and put there.
///
/// # Errors
/// [`ModalSoundbankBakeError`].
pub fn obtain_modal_soundbank(
    material: &Material,
    medium: Medium,
    cache: Option<&ModelCache>,
    progress: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<ObtainedBank, ModalSoundbankBakeError> {
    let mut remarks = Vec::new();
    let (name, of) = shared_material(material, medium);
    if let Some(bank) = default_modal_soundbank().filter(|bank| serves(bank.material(), &of).is_ok()) {
        return Ok(ObtainedBank { bank, remarks });
    }
    let options = ModalSoundbankOptions::new(of);
    let key = modal_soundbank_key(&options);
    match cache.map_or(Lookup::Missing, |cache| cache.read::<ModalSoundbankFile>(&key)) {
        Lookup::Found(file) => return Ok(ObtainedBank { bank: file.bank, remarks }),
        Lookup::Missing => {}
        Lookup::Invalid(why) => remarks.push(format!("{why}; it is baked again")),
    }
    let mut file = build_modal_soundbank(&name, &options, progress)?;
    // What is played is what a file keeps, now and after.
    let stored = file.encode().and_then(|bytes| ModalSoundbankFile::decode(&bytes));
    if let Ok(stored) = stored {
        file = stored;
    }
    if let Some(Err(error)) = cache.map(|cache| cache.write(&file)) {
        remarks.push(format!("the modal bank of {name} is not kept: {error}"));
    }
    Ok(ObtainedBank { bank: file.bank, remarks })
}

#[cfg(test)]
mod tests {
    use clangor_core::material::presets::{CERAMIC, PLASTIC};

    use super::*;

    #[test]
    fn a_small_bank_of_glass_comes_with_the_program() {
        let bank = default_modal_soundbank().expect("a bank");
        assert!(serves(bank.material(), &bank_material(&GLASS.material(), Medium::AIR)).is_ok());
        assert!(DEFAULT_BANK.len() < 2_000_000, "{} bytes", DEFAULT_BANK.len());
    }

    #[test]
    fn materials_that_differ_little_share_a_bank() {
        let of = |material: Material| shared_material(&material, Medium::AIR).0;
        assert_eq!(of(GLASS.material()), "glass");
        assert_eq!(of(CERAMIC.material()), "glass");
        assert_eq!(of(PLASTIC.material()), "plastic");
    }
}
