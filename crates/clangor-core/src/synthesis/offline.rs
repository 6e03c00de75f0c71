//! Offline rendering of clicks: exact below the band limit, on any threads.
//!
//! [`Renderer`] sorts clicks into blocks of time, [`BlockJob`] renders one, [`OverlapAdd`] adds them up.

pub mod block;
pub(super) mod block_length;
mod interpolation_cache;
pub mod overlap_add;
pub mod render_report;
pub mod renderer;

pub use block::{BlockJob, BlockMemory, RenderedBlock};
pub use overlap_add::OverlapAdd;
pub use render_report::RenderReport;
pub use renderer::Renderer;
