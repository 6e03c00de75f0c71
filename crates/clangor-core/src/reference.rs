//! Published representations of the papers, for comparison with the main path.
//!
//! * [`pan_representation`]: acceleration noise of a body as a series in 1/r along directions, \[PAN\] eqs.
//!   (18)–(22), \[PROXY\] eqs. (8), (10), (15) and algorithm 1; [`pan_file`]: the same as bytes;
//!   [`PanSource`]: the same as the source of a body's clicks, \[PAN\] §4.2–4.3;
//! * [`slab`]: the ground as a ringing slab of concrete, \[FRAC\] §6 with eq. (8);
//! * [`frac_transfer`]: modal pressure from magnitudes, transfers of reduced order and unit transfers,
//!   \[FRAC\] eq. (8), §4 and §6.
//!
//! The main path reaches them through the re-exports of this module only, at one variant each:
//! `SoundSource::Reference`, `Ground::Reference`, `ModalPressure::Reference`, `TransferOrder::Reference`. The
//! fields and transfers of the main path are smaller, faster and accurate at every distance and frequency.

pub mod frac_transfer;
pub mod pan_file;
pub mod pan_representation;
mod pan_sound;
mod pan_source;
pub mod slab;

pub(crate) use frac_transfer::{frac_coupling, frac_order};
pub use pan_representation::{PanError, PanModel};
pub use pan_source::PanSource;
pub use slab::SlabSource;
pub(crate) use slab::SlabTransfer;
