//! What a thread has used of the processor.

use std::sync::LazyLock;
use std::time::Instant;

/// Time that this thread has had \[s\], or else that on the wall; in Linux counted in steps of some
/// milliseconds.
pub(crate) fn thread_time() -> f64 {
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    let statistics = std::fs::read_to_string("/proc/self/schedstat").ok();
    let nanoseconds = statistics.and_then(|s| s.split(' ').next()?.parse::<f64>().ok());
    nanoseconds.map_or_else(|| START.elapsed().as_secs_f64(), |ns| 1e-9 * ns)
}
