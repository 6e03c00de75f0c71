//! The Python module `clangor._clangor`: sessions, strikes, modes, timelines and the
//! real-time engine, with NumPy arrays.
//!
//! It converts values and errors, and has no physics of its own. Long work runs without the interpreter's
//! lock; Ctrl-C stops it.

mod dataset;
mod engine;
mod errors;
mod modes;
mod progress;
mod session;
mod settings;
mod sound;
mod strike;
mod timeline;

use pyo3::prelude::*;

/// The system's allocator obeys the environment. Dask sets `MALLOC_TRIM_THRESHOLD_`, with which large blocks
/// are given back at once and faulted in again: 1.36 times the CPU time of bakes.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// Physically based sound for rigid bodies.
#[pymodule]
fn _clangor(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("ClangorError", module.py().get_type::<errors::ClangorError>())?;
    module.add_class::<session::Session>()?;
    module.add_class::<session::Body>()?;
    module.add_class::<engine::Engine>()?;
    module.add_class::<sound::Sound>()?;
    module.add_class::<strike::StruckSound>()?;
    module.add_class::<dataset::Strikes>()?;
    module.add_class::<modes::Modes>()?;
    module.add_class::<timeline::Timeline>()?;
    module.add_function(wrap_pyfunction!(strike::strike, module)?)?;
    module.add_function(wrap_pyfunction!(dataset::usual_shards, module)?)?;
    module.add_function(wrap_pyfunction!(modes::modes, module)?)?;
    module.add_function(wrap_pyfunction!(settings::materials, module)?)?;
    Ok(())
}
