//! The stages with their files: scene and meshes in, timeline and WAV out.

pub mod analysis;
pub mod dataset;
pub mod formats;
pub mod interchange;
pub mod motion;
pub mod plots;
pub mod session;
pub mod stages;
pub mod validate;

/// Runs `work` on a pool of `threads` threads; 0 means one per core. The result of no stage depends on it.
pub fn with_threads<R: Send>(threads: usize, work: impl FnOnce() -> R + Send) -> R {
    match rayon::ThreadPoolBuilder::new().num_threads(threads).build() {
        Ok(pool) => pool.install(work),
        // Without threads of its own the work runs on the global pool, more slowly at worst.
        Err(_) => work(),
    }
}
