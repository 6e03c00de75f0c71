//! From the recorded multipole signals to the field at any wavenumber of the band.

use clangor::geometry::tri_mesh::TriMesh;
use clangor::model::radial::reverse_bessel;
use clangor::model::spherical_harmonics::count;
use num_complex::Complex64;

use super::RECORDING;
use super::grid::phase_per_step;
use super::pulse::Pulse;
use crate::radiation::{RadiationError, RadiationSample, RadiationSolver};

/// What a run has recorded.
#[derive(Clone, Debug)]
pub struct WaveField {
    /// h \[m\].
    pub(super) spacing: f64,
    /// R \[m\].
    pub(super) radius: f64,
    /// Highest degree recorded.
    pub(super) order: usize,
    /// Steps between samples.
    pub(super) stride: usize,
    pub(super) pulse: Pulse,
    /// Cells times steps, all motions together.
    pub(super) updates: f64,
    /// For each motion its samples, each with all harmonics.
    pub(super) signals: Vec<Vec<f64>>,
}

impl WaveField {
    /// The six fields at real wavenumbers k [1/m], up to degree `order`; beyond the degree of the run they are zero.
    pub fn samples(&self, wavenumbers: &[f64], order: usize) -> Vec<RadiationSample> {
        wavenumbers.iter().map(|k| self.sample(*k, order)).collect()
    }

    /// Cell updates of the run, all motions together.
    pub fn updates(&self) -> f64 {
        self.updates
    }

    /// For each motion the multipoles on r = 1.5 R as they were recorded, up to the degree of the run: all of one moment,
    /// then all of the next. In units of the grid.
    pub fn signals(&self) -> &[Vec<f64>] {
        &self.signals
    }

    fn sample(&self, wavenumber: f64, order: usize) -> RadiationSample {
        let phase = phase_per_step(wavenumber * self.spacing);
        let recorded = count(self.order);
        let kept = count(order.min(self.order));
        let half = 0.5 * wavenumber * self.spacing;
        let scale = self.stride as f64 * half.sin() / half / self.pulse.spectrum(phase);
        let kr = wavenumber * self.radius;
        let s = Complex64::new(0.0, kr);
        let (mut here, mut there) = (Vec::new(), Vec::new());
        reverse_bessel(s, self.order, &mut here);
        reverse_bessel(s * RECORDING, self.order, &mut there);
        let coefficients = std::array::from_fn(|motion| {
            let mut sums = vec![Complex64::ZERO; count(order)];
            for (n, sample) in self.signals[motion].chunks_exact(recorded).enumerate() {
                let turn = Complex64::from_polar(1.0, -phase * (n * self.stride) as f64);
                for (sum, value) in sums[..kept].iter_mut().zip(sample) {
                    *sum += *value * turn;
                }
            }
            // Lengths were cells: an acceleration is one, an angular acceleration two lengths away from a pressure.
            let length = if motion < 3 { self.spacing } else { self.spacing * self.spacing };
            let advance = (s * RECORDING).exp();
            for n in 0..=order.min(self.order) {
                let radial = here[n] / there[n] * RECORDING.powi(n as i32 + 1);
                for sum in &mut sums[n * n..(n + 1) * (n + 1)] {
                    *sum *= scale * length * advance * radial;
                }
            }
            sums
        });
        RadiationSample {
            wavenumber: Complex64::new(wavenumber, 0.0),
            coefficients,
            surface_pressure: Vec::new(),
        }
    }
}

impl RadiationSolver for WaveField {
    fn solve(&self, wavenumbers: &[f64], order: usize) -> Result<Vec<RadiationSample>, RadiationError> {
        let samples = self.samples(wavenumbers, order);
        for (sample, wavenumber) in samples.iter().zip(wavenumbers) {
            if !sample.coefficients.iter().flatten().all(|c| c.is_finite()) {
                return Err(RadiationError::NotFinite { wavenumber: *wavenumber });
            }
        }
        Ok(samples)
    }

    fn reference_radius(&self) -> f64 {
        self.radius
    }

    fn surface(&self) -> Option<&TriMesh> {
        None
    }
}
