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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cosine_is_one_amplitude_and_comes_back() {
        let (length, harmonic) = (12, 3);
        let angle = |l: usize| std::f64::consts::TAU * (harmonic * l) as f64 / length as f64;
        let signal: Vec<f64> = (0..length).map(|l| angle(l).cos()).collect();
        let mut planner = Planner::new();
        let (forward, inverse) = (planner.forward(length), planner.inverse(length));
        let (mut spectrum, mut back) = (forward.make_output_vec(), inverse.make_output_vec());
        forward.process(&mut signal.clone(), &mut spectrum).unwrap();
        for (m, amplitude) in spectrum.iter().enumerate() {
            let expected = if m == harmonic { length as f64 / 2.0 } else { 0.0 };
            // Seen: 2.7e-15.
            assert!((amplitude.re - expected).hypot(amplitude.im) < 1e-14, "{m}: {amplitude}");
        }
        inverse.process(&mut spectrum, &mut back).unwrap();
        for (x, y) in signal.iter().zip(back) {
            assert!((x - y / length as f64).abs() < 1e-15, "{x} {y}");
        }
    }
}
