//! The stages with their files: scene and meshes in, timeline and WAV out.

pub mod atomic_file;
pub mod audio_rigid_bodies;
pub mod bank_use_plot;
mod breakables;
pub mod contact_list;
pub mod exchange;
pub mod field_plot;
pub mod fracture_report;
pub mod glb;
pub mod levels;
pub mod live_score;
pub mod load;
pub mod mesh_reader;
pub mod modal_soundbank;
pub mod mode_plot;
pub mod model_cache;
pub mod picture;
pub mod render;
pub mod simulate;
pub mod sound_models;
pub mod soundbank;
pub mod spectrogram;
pub mod spectrogram_plot;
pub mod spectrum;
pub mod spectrum_plot;
pub mod timeline_file;
pub mod validate;
pub mod wav;
pub mod web_replay;

/// Runs `work` on a pool of `threads` threads; 0 means one per core. The result of no stage depends on it.
pub fn with_threads<R: Send>(threads: usize, work: impl FnOnce() -> R + Send) -> R {
    match rayon::ThreadPoolBuilder::new().num_threads(threads).build() {
        Ok(pool) => pool.install(work),
        // Without threads of its own the work runs on the global pool, more slowly at worst.
        Err(_) => work(),
    }
}
