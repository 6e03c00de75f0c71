//! Spectra of clicks that radiate by a field.
//!
//! The pressure at the receiver, without e^{−s|x|}, is interpolated from the nodes of the field to the bins
//! ([`field_interpolation`](super::field_interpolation)), and multiplied with the spectrum of the force and
//! the delay.
//!
//! Above the highest frequency f_b of the field the interpolation is an extrapolation. It is faded out
//! between f_b and 6/5 f_b, or over 200 Hz where that is more, by the same curve as the band limit of the
//! output. Components of the output above are missing.

use super::field_interpolation::{Interpolation, LEAST_WAVENUMBER};
use super::field_source::FieldSource;
use super::spectrum::{ArrivingForce, Grid, LANES, Rotation, Spectrum};
use crate::contact::ForceShape;
use crate::sound_model::acceleration::field::RIGID_DOFS;
use crate::sound_model::acceleration::field_evaluator::{FieldScratch, GROUP, NodeGroup};
use crate::sound_model::acceleration::near_field::{FAR, NEAR};
use glam::DVec3;
use num_complex::Complex64;
use pulp::Simd;
use std::sync::Arc;

/// A field at a receiver, per unit of force profile.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FieldTransfer {
    /// The field and its size.
    pub(super) source: Arc<FieldSource>,
    /// z = (Δv, R Δω) [m/s] in the axes of the field.
    pub(super) motion: [f64; RIGID_DOFS],
    /// The receiver over R, in the axes of the field; outside the bounding sphere unless there is a near
    /// field.
    pub(super) position: DVec3,
    /// ρ R [kg/m²].
    pub(super) scale: f64,
    /// R/c \[s\].
    pub(super) crossing: f64,
    /// Interpolation from the nodes to the bins of the block, if it is kept.
    pub(super) table: Option<Arc<Interpolation>>,
}

/// Adds clicks that radiate by fields to spectra; holds the working memory.
#[derive(Default)]
pub(crate) struct FieldPlayer {
    scratch: FieldScratch,
    values: Vec<NodeGroup>,
    /// Re(w_j v_j) and Re(w_j v_j conj s_j).
    weighted: Vec<(f64, f64)>,
    near: Vec<NodeGroup>,
    /// The spectrum added last.
    last: Option<(Arc<FieldSource>, f64, Arc<Interpolation>)>,
}

impl FieldPlayer {
    /// Values at the nodes: of the multipoles, of the boundary integral, or blended.
    #[inline(always)]
    fn at_nodes(&mut self, transfer: &FieldTransfer) {
        let FieldTransfer { source, motion, position, .. } = transfer;
        let distance = position.length();
        let near = source.near.as_deref().filter(|_| distance < FAR);
        // 1 where the boundary integral alone counts.
        let share = near.map_or(0.0, |_| ((FAR - distance) / (FAR - NEAR)).min(1.0));
        if share < 1.0 {
            source.field.at_nodes(motion, *position, &mut self.scratch, &mut self.values);
        }
        if let Some(near) = near {
            near.at_nodes(source.field.nodes(), motion, *position, &mut self.near);
            if share == 1.0 {
                self.values.clone_from(&self.near);
                return;
            }
            for (value, near) in self.values.iter_mut().zip(&self.near) {
                for lane in 0..GROUP {
                    value.re[lane] += share * (near.re[lane] - value.re[lane]);
                    value.im[lane] += share * (near.im[lane] - value.im[lane]);
                }
            }
        }
    }

    /// Adds a wave to a spectrum.
    #[inline(always)]
    pub(super) fn add<S: Simd>(
        &mut self,
        simd: S,
        spectrum: &mut Spectrum,
        grid: &Grid,
        force: &ArrivingForce,
        transfer: &FieldTransfer,
    ) {
        let source = &transfer.source;
        let field = &*source.field;
        self.at_nodes(transfer);
        self.weighted.clear();
        for (j, node) in field.nodes().iter().enumerate() {
            let (group, lane) = (j / GROUP, j % GROUP);
            let value = Complex64::new(self.values[group].re[lane], self.values[group].im[lane]);
            let weighted = node.weight * value * transfer.scale;
            self.weighted.push((weighted.re, (weighted * node.s.conj()).re));
        }
        let table = match &transfer.table {
            Some(table) => Arc::clone(table),
            None => Arc::new(Interpolation::of(source, transfer.crossing, grid)),
        };
        let crossing = transfer.crossing;
        let (_, _, table) = self.last.insert((Arc::clone(source), crossing, table));
        add_interpolated(simd, spectrum, grid, force, (&self.weighted, crossing, table));
    }

    /// Estimate of the energy ∫ p² dt [Pa² s] that a click would have had above the band of its field.
    ///
    /// At high frequency a rigid body's pressure follows its velocity, so that pressure per acceleration
    /// falls as 1/ω. The estimate continues it from the mean square of the last tenth of the band, `spectrum`
    /// over that of the force.
    pub(super) fn missing_energy(
        &self,
        grid: &Grid,
        spectrum: &Spectrum,
        (shape, duration): (&ForceShape, f64),
    ) -> f64 {
        let Some((source, crossing, table)) = &self.last else { return 0.0 };
        if table.gains.is_empty() {
            return 0.0;
        }
        let band_end = source.max_frequency(source.radius / crossing);
        let bin = |hz: f64| ((hz / grid.spacing_hz) as usize).min(grid.bins.saturating_sub(1));
        let (first, last) = (bin(0.9 * band_end), bin(band_end));
        let force = |k: usize| shape.centred_spectrum(grid.omega[k], duration).norm_sqr();
        let (mut heard, mut pushed) = (0.0, 0.0);
        for k in first..=last {
            heard += spectrum.re[k].powi(2) + spectrum.im[k].powi(2);
            pushed += force(k);
        }
        let ratio = if pushed > 0.0 { heard / pushed } else { 0.0 };
        let beyond = (last + 1..grid.bins).map(|k| {
            let missing = 1.0 - table.gains.get(k).map_or(0.0, |gain| gain * gain);
            let fall = last.max(1) as f64 / k as f64;
            missing * (fall * grid.gain(k)).powi(2) * force(k)
        });
        2.0 * grid.spacing_hz * ratio * beyond.sum::<f64>()
    }
}

/// Adds the interpolation of weighted values at the nodes.
#[inline(always)]
fn add_interpolated<S: Simd>(
    simd: S,
    spectrum: &mut Spectrum,
    grid: &Grid,
    force: &ArrivingForce,
    (weighted, crossing, table): (&[(f64, f64)], f64, &Interpolation),
) {
    let step = std::f64::consts::TAU * grid.spacing_hz;
    let mut delay = Rotation::<LANES>::new(-step * force.middle);
    let mut half_angle = Rotation::<LANES>::new(0.5 * step * force.duration);
    let pole = std::f64::consts::PI / force.duration;
    let inverse_pole_square = 1.0 / (pole * pole);
    let half_sine = force.is_half_sine();
    // Bins where cos(ωτ/2) / (1 − (ωτ/π)²) is near 0/0 use the formula with the limit.
    let singular = (pole / step).round();

    let groups = grid.omega.as_chunks::<LANES>().0;
    let out = spectrum.re.as_chunks_mut::<LANES>().0.iter_mut().zip(spectrum.im.as_chunks_mut::<LANES>().0);
    for (group, ((omega, (re_out, im_out)), inverse)) in
        groups.iter().zip(out).zip(&table.inverse).enumerate()
    {
        let (slope, level) = table.sums(simd, weighted, group);
        let (mut force_re, mut force_im) = ([0.0; LANES], [0.0; LANES]);
        if half_sine {
            for lane in 0..LANES {
                let w = omega[lane];
                force_re[lane] = half_angle.cos[lane] / (1.0 - w * w * inverse_pole_square);
            }
            let lane = singular - (group * LANES) as f64;
            if lane >= 0.0 && lane < LANES as f64 {
                let lane = lane as usize;
                (force_re[lane], _) = force.at(group * LANES + lane, omega[lane]);
            }
        } else {
            for lane in 0..LANES {
                (force_re[lane], force_im[lane]) = force.at(group * LANES + lane, omega[lane]);
            }
        }
        // Sums first, stores after, so that the compiler can see that the lanes are independent.
        let (mut re_sum, mut im_sum) = (*re_out, *im_out);
        for lane in 0..LANES {
            let k = (omega[lane] * crossing).max(LEAST_WAVENUMBER);
            let above_re = -k * slope.im[lane] - level.re[lane];
            let above_im = k * slope.re[lane] - level.im[lane];
            let turn_re = inverse.re[lane] * delay.cos[lane] - inverse.im[lane] * delay.sin[lane];
            let turn_im = inverse.re[lane] * delay.sin[lane] + inverse.im[lane] * delay.cos[lane];
            let unit_re = above_re * turn_re - above_im * turn_im;
            let unit_im = above_re * turn_im + above_im * turn_re;
            re_sum[lane] += force_re[lane] * unit_re - force_im[lane] * unit_im;
            im_sum[lane] += force_re[lane] * unit_im + force_im[lane] * unit_re;
        }
        (*re_out, *im_out) = (re_sum, im_sum);
        delay.advance();
        half_angle.advance();
    }
}
