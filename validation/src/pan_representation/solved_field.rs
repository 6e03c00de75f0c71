//! A field at every wavenumber of a Fourier grid, from solves on a coarser one.
//!
//! The response to an acceleration ends after a time T: solves Δκ = 2π/T apart capture all of it. Solvers may
//! shift the wavenumbers by a constant, k = κ − iσ; they then give the spectrum of the response times
//! e^{−σu}.

use clangor_bake::radiation::{RadiationError, RadiationSolver};
use clangor_bake::reference::{PanOptions, synthesize};
use clangor_core::glam::DVec3;
use clangor_core::math::radial::outgoing;
use clangor_core::math::spherical_harmonics::{index, solid_harmonics};
use clangor_core::sound_model::acceleration::field::RIGID_DOFS;
use clangor_fourier::Planner;
use num_complex::Complex64;

/// Multipoles of a body of bounding radius 1 at κ = mΔκ − iσ.
pub struct SolvedField {
    /// For each degree: n, m and the values.
    terms: Vec<Vec<(usize, isize, Vec<Complex64>)>>,
    /// ik.
    s: Vec<Complex64>,
    /// Gain at each solve: 1, faded out over the last eighth of the band.
    gains: Vec<f64>,
    order: usize,
    step: f64,
    start: f64,
    length: usize,
    solved_length: usize,
}

impl SolvedField {
    /// Solves for the wavenumbers of `options`, up to `highest` κ. The response must decay within the time of
    /// the signals over `ratio`.
    pub fn new(
        solver: &dyn RadiationSolver,
        options: &PanOptions,
        highest: f64,
        ratio: usize,
    ) -> Result<Self, RadiationError> {
        let radius = solver.reference_radius();
        let solved_length = options.length / ratio;
        let spacing = std::f64::consts::TAU / (solved_length as f64 * options.step);
        let count = ((highest / spacing) as usize).min(solved_length / 2);
        // Solvers may not support zero.
        let kappas: Vec<f64> = (0..=count).map(|m| if m == 0 { 1e-3 } else { m as f64 * spacing }).collect();
        let wavenumbers: Vec<f64> = kappas.iter().map(|k| k / radius).collect();
        let order = highest.ceil() as usize + 6;
        let samples = solver.solve(&wavenumbers, order)?;
        // Keep terms above rounding.
        let mut terms = vec![Vec::new(); RIGID_DOFS];
        for (degree, terms) in terms.iter_mut().enumerate() {
            let unit = if degree < 3 { radius } else { radius * radius };
            let size = |i: usize| {
                samples.iter().map(|s| s.coefficients[degree][i].norm()).fold(0.0, f64::max) / unit
            };
            for n in 0..=order {
                for m in -(n as isize)..=n as isize {
                    if size(index(n, m)) > 1e-9 {
                        let values = samples.iter().map(|s| s.coefficients[degree][index(n, m)] / unit);
                        terms.push((n, m, values.collect()));
                    }
                }
            }
        }
        Ok(SolvedField {
            terms,
            s: samples.iter().map(|s| Complex64::I * s.wavenumber * radius).collect(),
            gains: kappas
                .iter()
                .map(|k| (8.0 * (1.0 - k / highest)).clamp(0.0, 1.0))
                .map(|x| (std::f64::consts::FRAC_PI_2 * x).sin().powi(2))
                .collect(),
            order,
            step: options.step,
            start: options.start(),
            length: options.length,
            solved_length,
        })
    }

    /// Number of solves.
    pub fn solves(&self) -> usize {
        self.s.len()
    }

    /// p e^{iκ|x|}/(ρR) of the six motions at the wavenumbers of the options.
    pub fn spectra(&self, x: DVec3) -> [Vec<Complex64>; RIGID_DOFS] {
        let distance = x.length();
        let mut harmonics = Vec::new();
        solid_harmonics(x / distance, self.order, &mut harmonics);
        // Radial factors at each wavenumber.
        let mut radial = Vec::new();
        let mut all = Vec::with_capacity(self.s.len() * (self.order + 1));
        for s in &self.s {
            outgoing(*s, distance, self.order, &mut radial);
            all.extend_from_slice(&radial);
        }
        let growth = self.s[self.s.len() - 1].re;
        let mut planner = Planner::new();
        let plan = planner.forward(self.length);
        std::array::from_fn(|degree| {
            // Spectrum on the coarse grid.
            let mut spectrum = vec![Complex64::ZERO; self.solved_length / 2 + 1];
            for (n, m, values) in &self.terms[degree] {
                let y = harmonics[index(*n, *m)];
                for (j, value) in values.iter().enumerate() {
                    spectrum[j] += self.gains[j] * y * value * all[j * (self.order + 1) + n];
                }
            }
            // To the time domain, where the damping is undone.
            let ones = vec![1.0; spectrum.len()];
            let damped = synthesize(&spectrum, &ones, self.step, self.start);
            let mut signal = plan.make_input_vec();
            for (l, (x, y)) in signal.iter_mut().zip(damped).enumerate() {
                *x = y * (growth * (self.start + l as f64 * self.step)).exp();
            }
            // Spectrum on the fine grid.
            let mut spectrum = plan.make_output_vec();
            plan.process(&mut signal, &mut spectrum).expect("buffers of the plan's own lengths");
            let spacing = std::f64::consts::TAU / (self.length as f64 * self.step);
            for (m, value) in spectrum.iter_mut().enumerate() {
                *value *= Complex64::from_polar(self.step, -spacing * m as f64 * self.start);
            }
            spectrum
        })
    }
}
