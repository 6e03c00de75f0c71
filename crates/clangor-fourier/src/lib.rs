//! Discrete Fourier transforms of real signals, by the library `realfft`.
//!
//! The forward transform of x₀ … x₍N₋₁₎ is X_m = Σ_ℓ x_ℓ e^(−2πi mℓ/N) for m = 0 … N/2. The inverse is the
//! same sum with the other sign. Neither divides by N.
//!
//! The library is generic, and whatever crate asks it for a plan compiles all of its algorithms, 400 000
//! lines of the compiler's own language. Here they are compiled once, in double precision, and the plans are
//! trait objects.

use std::fmt;
use std::sync::Arc;

use realfft::RealFftPlanner;
pub use realfft::{ComplexToReal, RealToComplex};

/// Makes plans of transforms, and keeps those that it has made.
pub struct Planner(RealFftPlanner<f64>);

impl Planner {
    /// A planner that has made no plan yet.
    pub fn new() -> Self {
        Planner(RealFftPlanner::new())
    }

    /// The transform of `length` real samples into `length`/2 + 1 complex amplitudes.
    pub fn forward(&mut self, length: usize) -> Arc<dyn RealToComplex<f64>> {
        self.0.plan_fft_forward(length)
    }

    /// The transform of `length`/2 + 1 complex amplitudes into `length` real samples.
    pub fn inverse(&mut self, length: usize) -> Arc<dyn ComplexToReal<f64>> {
        self.0.plan_fft_inverse(length)
    }
}

impl Default for Planner {
    fn default() -> Self {
        Planner::new()
    }
}

impl fmt::Debug for Planner {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.debug_struct("Planner").finish_non_exhaustive()
    }
}
