//! What tells whether two runs make the same data set: a hash of the program's version, the recipe, its
//! table, the files of its objects and the options of sound models.
//!
//! Files that only a table names are not hashed, as there may be a million.

use std::fs;
use std::path::Path;

use clangor_core::scene::strike_recipe::StrikeRecipe;
use twox_hash::xxhash3_128::Hasher;

use super::error::DatasetError;
use super::struck_bodies::file;
use crate::stages::sound_models::ModelOptions;

/// Changes when the same recipe makes other strikes.
const FORMAT: &str = "clangor data set 1";

/// 32 hexadecimal digits.
pub(super) fn of(
    text: &str,
    recipe: &StrikeRecipe,
    table: Option<&Path>,
    folder: &Path,
    models: &ModelOptions,
) -> Result<String, DatasetError> {
    let mut hasher = Hasher::new();
    // Lengths keep parts apart.
    let mut put = |part: &[u8]| {
        hasher.write(&(part.len() as u64).to_le_bytes());
        hasher.write(part);
    };
    put(FORMAT.as_bytes());
    put(env!("CARGO_PKG_VERSION").as_bytes());
    put(text.as_bytes());
    put(&recipe.seed.to_le_bytes());
    let ModelOptions { quality, accuracy, max_frequency, method, device: _, patience: _ } = models;
    put(format!("{quality:?} {accuracy:?} {max_frequency:?} {method:?}").as_bytes());
    let files = recipe.objects.iter().filter_map(|object| file(object, folder));
    for path in table.map(Path::to_path_buf).into_iter().chain(files) {
        put(&fs::read(&path).map_err(|source| DatasetError::Read { path, source })?);
    }
    Ok(format!("{:032x}", hasher.finish_128()))
}
