//! tmp
mod lanes;
mod ring;
