//! What may be done to pressure on its way to a file. Files themselves, levels and loudness are
//! `clangor-pipeline`.

pub mod compressor;
