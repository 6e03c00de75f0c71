//! File formats of sound models and soundbanks: tensors in safetensors with typed metadata.

pub mod ellipsoid_bank_file;
pub mod modal_file;
pub mod modal_soundbank_file;
pub mod model_file;
pub mod tensor_file;
