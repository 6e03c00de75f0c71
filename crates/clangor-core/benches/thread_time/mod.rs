//! Processor time of a thread.

use std::sync::LazyLock;
use std::time::Instant;

/// Processor time of this thread \[s\]; in Linux in steps of some milliseconds, elsewhere wall time.
pub(crate) fn thread_time() -> f64 {
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    let statistics = std::fs::read_to_string("/proc/self/schedstat").ok();
    let nanoseconds = statistics.and_then(|s| s.split(' ').next()?.parse::<f64>().ok());
    nanoseconds.map_or_else(|| START.elapsed().as_secs_f64(), |ns| 1e-9 * ns)
}
