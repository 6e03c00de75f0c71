//! Evaluates the transfers of all modes of a body at one place.
//!
//! With κ = kR and tₙ = θₙ(iκ)/θₙ₋₁(iκ) the radial part vₙ = x^{−(n+1)} θₙ(iκx)/θₙ(iκ) of
//! [`radial::outgoing`](crate::math::radial::outgoing) obeys
//!
//! ```text
//! vₙ = αₙ vₙ₋₁/x + βₙ vₙ₋₂,   αₙ = (2n−1)/tₙ,   βₙ = −κ²/(tₙ tₙ₋₁),   v₀ = 1/x
//! ```
//!
//! where α and β depend on the mode only: a new place needs no division. The harmonics are computed once for
//! all modes. The coefficients of each mode are rows of a multiple of eight numbers, which vector
//! instructions sum up.

use glam::DVec3;
use num_complex::Complex64;
use pulp::{Arch, Simd, WithSimd};

use super::modal_settings::TransferOrder;
use crate::math::spherical_harmonics::HarmonicTable;
use crate::reference::frac_order;
use crate::sound_model::modal::model::ModalTransfer;

/// Rows of coefficients are padded to a multiple of this length.
const LANES: usize = 8;

/// The transfers of some modes.
#[derive(Clone, Debug)]
pub struct TransferEvaluator {
    harmonics: HarmonicTable,
    max_order: usize,
    modes: Vec<ModeRows>,
    re: Vec<f64>,
    im: Vec<f64>,
    /// (αₙ, βₙ), n = 1 … of each mode.
    steps: Vec<(Complex64, Complex64)>,
}

#[derive(Clone, Copy, Debug)]
struct ModeRows {
    /// Orders that are evaluated; `None` for a mode without transfer.
    order: Option<usize>,
    coefficients: usize,
    steps: usize,
}

/// Reusable memory for the evaluation.
#[derive(Clone, Debug, Default)]
pub struct TransferMemory {
    harmonics: Vec<f64>,
    rows: Vec<f64>,
}

/// Length of row n.
const fn row_length(n: usize) -> usize {
    (2 * n + 1).next_multiple_of(LANES)
}

impl TransferEvaluator {
    /// For transfers with κ = kR of their modes; a mode without one has the transfer 0.
    pub fn new<'a>(
        transfers: impl IntoIterator<Item = (Option<&'a ModalTransfer>, f64)>,
        orders: TransferOrder,
    ) -> Self {
        let (mut modes, mut re, mut im, mut steps) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let mut max_order = 0;
        for (transfer, wavenumber) in transfers {
            let mut mode = ModeRows { order: None, coefficients: re.len(), steps: steps.len() };
            if let Some(transfer) = transfer {
                let order = match orders {
                    TransferOrder::Baked => transfer.order,
                    TransferOrder::Reference => transfer.order.min(frac_order(wavenumber)),
                };
                mode.order = Some(order);
                max_order = max_order.max(order);
                for n in 0..=order {
                    let own = &transfer.coefficients[n * n..(n + 1) * (n + 1)];
                    let end = re.len() + row_length(n);
                    re.extend(own.iter().map(|c| c.re));
                    im.extend(own.iter().map(|c| c.im));
                    re.resize(end, 0.0);
                    im.resize(end, 0.0);
                }
                let mut before = Complex64::ONE;
                for n in 1..=order {
                    let odd = (2 * n - 1) as f64;
                    let square = -wavenumber * wavenumber;
                    // t₁ = θ₁ = 1 + iκ has no term of θ₋₁.
                    let ratio = if n == 1 { Complex64::new(1.0, wavenumber) } else { odd + square / before };
                    let beta = if n == 1 {
                        // v₁ = (1 + iκx)/(x² t₁) = α₁ v₀/x + iκ/t₁ v₀: taken as v₋₁ = v₀.
                        Complex64::new(0.0, wavenumber) / ratio
                    } else {
                        square / (ratio * before)
                    };
                    steps.push((odd / ratio, beta));
                    before = ratio;
                }
            }
            modes.push(mode);
        }
        TransferEvaluator { harmonics: HarmonicTable::new(max_order), max_order, modes, re, im, steps }
    }

    /// Number of coefficients that are evaluated.
    pub fn coefficients(&self) -> usize {
        self.modes.iter().filter_map(|mode| mode.order).map(|order| (order + 1).pow(2)).sum()
    }

    /// Highest order that is evaluated.
    pub fn max_order(&self) -> usize {
        self.max_order
    }

    /// [`ModalTransfer::undelayed`] of every mode at `x`, in units of R; inside the sphere of radius R, the
    /// value on it.
    pub fn evaluate(&self, x: DVec3, memory: &mut TransferMemory, values: &mut Vec<Complex64>) {
        self.evaluate_some(x, |_| true, memory, values);
    }

    /// The same for the modes that are `wanted`; 0 for the others.
    pub(super) fn evaluate_some(
        &self,
        x: DVec3,
        wanted: impl Fn(usize) -> bool,
        memory: &mut TransferMemory,
        values: &mut Vec<Complex64>,
    ) {
        let distance = x.length();
        let direction = if distance > 0.0 { x / distance } else { DVec3::Z };
        self.harmonics.evaluate(direction, &mut memory.harmonics);
        memory.rows.clear();
        for n in 0..=self.max_order {
            let end = memory.rows.len() + row_length(n);
            memory.rows.extend_from_slice(&memory.harmonics[n * n..(n + 1) * (n + 1)]);
            memory.rows.resize(end, 0.0);
        }
        values.clear();
        Arch::new().dispatch(Summing {
            evaluator: self,
            rows: &memory.rows,
            inverse: 1.0 / distance.max(1.0),
            wanted,
            values,
        });
    }
}

/// Sums up all modes, with the vector instructions of the machine.
struct Summing<'a, W> {
    evaluator: &'a TransferEvaluator,
    rows: &'a [f64],
    inverse: f64,
    wanted: W,
    values: &'a mut Vec<Complex64>,
}

impl<W: Fn(usize) -> bool> WithSimd for Summing<'_, W> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Summing { evaluator, rows, inverse, wanted, values } = self;
        let rows = S::as_simd_f64s(rows).0;
        for (index, mode) in evaluator.modes.iter().enumerate() {
            let Some(order) = mode.order.filter(|_| wanted(index)) else {
                values.push(Complex64::ZERO);
                continue;
            };
            let mut re = S::as_simd_f64s(&evaluator.re[mode.coefficients..]).0;
            let mut im = S::as_simd_f64s(&evaluator.im[mode.coefficients..]).0;
            let mut harmonics = rows;
            let zero = simd.splat_f64s(0.0);
            let (mut sum_re, mut sum_im) = (zero, zero);
            let (mut before, mut wave) = (Complex64::new(inverse, 0.0), Complex64::new(inverse, 0.0));
            for n in 0..=order {
                if n > 0 {
                    let (alpha, beta) = evaluator.steps[mode.steps + n - 1];
                    (before, wave) = (wave, alpha * wave * inverse + beta * before);
                }
                let length = row_length(n) / S::F64_LANES;
                let (own_re, rest_re) = re.split_at(length);
                let (own_im, rest_im) = im.split_at(length);
                let (own, rest) = harmonics.split_at(length);
                (re, im, harmonics) = (rest_re, rest_im, rest);
                let (mut row_re, mut row_im) = (zero, zero);
                for ((re, im), y) in own_re.iter().zip(own_im).zip(own) {
                    row_re = simd.mul_add_e_f64s(*re, *y, row_re);
                    row_im = simd.mul_add_e_f64s(*im, *y, row_im);
                }
                let (wave_re, wave_im) = (simd.splat_f64s(wave.re), simd.splat_f64s(wave.im));
                sum_re = simd.mul_add_e_f64s(wave_re, row_re, sum_re);
                sum_re = simd.mul_add_e_f64s(simd.neg_f64s(wave_im), row_im, sum_re);
                sum_im = simd.mul_add_e_f64s(wave_re, row_im, sum_im);
                sum_im = simd.mul_add_e_f64s(wave_im, row_re, sum_im);
            }
            values.push(Complex64::new(simd.reduce_sum_f64s(sum_re), simd.reduce_sum_f64s(sum_im)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gives_what_the_model_defines() {
        let transfer = |order: usize| {
            let value = |i: usize| Complex64::new((1.3 * i as f64).sin(), (0.7 * i as f64).cos());
            ModalTransfer { order, coefficients: (0..(order + 1).pow(2)).map(value).collect() }
        };
        let modes = [(transfer(0), 0.3), (transfer(1), 0.01), (transfer(7), 4.0), (transfer(40), 33.0)];
        let given = modes.iter().map(|(t, k)| (Some(t), *k)).chain([(None, 1.0)]);
        let evaluator = TransferEvaluator::new(given, TransferOrder::Baked);
        let (mut memory, mut values) = (TransferMemory::default(), Vec::new());
        for x in [DVec3::new(0.3, -1.1, 0.4), DVec3::new(0.0, 0.0, 1.0), DVec3::new(30.0, 4.0, -9.0)] {
            evaluator.evaluate(x, &mut memory, &mut values);
            for ((transfer, wavenumber), value) in modes.iter().zip(&values) {
                let exact = transfer.undelayed(x, *wavenumber);
                // Residual seen: 2e-14.
                assert!((value - exact).norm() < 1e-11 * exact.norm(), "{x} {wavenumber}: {value} {exact}");
            }
            assert_eq!(values[4], Complex64::ZERO);
        }
        let given = modes.iter().map(|(t, k)| (Some(t), *k));
        // max(κ/2, 4) of 0, 1, 7, 40: orders 0, 1, 4, 17.
        let coarse = TransferEvaluator::new(given, TransferOrder::Reference);
        assert_eq!(coarse.coefficients(), 1 + 4 + 25 + 18 * 18);
    }
}
