//! Processing of pressure before it is written to a file. Files, levels and loudness are in
//! `clangor-pipeline`.

pub mod compressor;
