//! File formats of sound models and soundbanks: tensors in safetensors with typed metadata.

pub mod ellipsoid_bank_file;
mod field_checks;
pub mod modal_file;
pub mod modal_soundbank_file;
pub mod model_file;
mod number_checks;
pub mod origin;
pub mod solid;
mod surface_mesh;
pub mod tensor_file;
