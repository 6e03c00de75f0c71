//! Multipole order of a mode.
//!
//! The truncated part is negligible in the radiated power and in the square pressure at one and a half
//! bounding radii, where a mode of short waves that hardly radiates may still be audible.

use clangor_core::math::radial::outgoing;
use clangor_core::sound_model::modal::model::ModalTransfer;
use num_complex::Complex64;

/// Fraction of the power, and of the square pressure at [`NEAR`] bounding radii, that the truncated orders
/// may have.
const DROPPED: f64 = 1e-6;
const NEAR: f64 = 1.5;

/// The lowest sufficient multipole order of some modes of one frequency κ = kR, summed over the modes. Modes
/// may lack some orders.
pub(super) fn last_order(modes: &[&[Complex64]], kappa: f64) -> usize {
    let order = modes.iter().map(|c| c.len().isqrt().saturating_sub(1)).max().unwrap_or(0);
    let own = |c: &[Complex64], n: usize| -> Vec<Complex64> {
        c.get(n * n..(n + 1) * (n + 1)).unwrap_or_default().to_vec()
    };
    // Radiated power by order.
    let power = |n: usize| -> f64 {
        let of_mode = |c: &&[Complex64]| {
            let mut alone = vec![Complex64::ZERO; n * n];
            alone.extend(own(c, n));
            alone.resize((n + 1) * (n + 1), Complex64::ZERO);
            ModalTransfer { order: n, coefficients: alone }.power(kappa)
        };
        modes.iter().map(of_mode).sum()
    };
    let mut waves = Vec::new();
    outgoing(Complex64::new(0.0, kappa), NEAR, order, &mut waves);
    // Square pressure at the near distance, by order.
    let near = |n: usize| -> f64 {
        let squares = modes.iter().flat_map(|c| own(c, n)).map(|c| c.norm_sqr()).sum::<f64>();
        squares * waves[n].norm_sqr()
    };
    // Truncate from the top while the sum stays below the threshold.
    let least = |value: &dyn Fn(usize) -> f64| {
        let values: Vec<f64> = (0..=order).map(value).collect();
        let all: f64 = values.iter().sum();
        let mut left_out = 0.0;
        (1..=order)
            .rev()
            .find(|n| {
                left_out += values[*n];
                left_out > DROPPED * all
            })
            .unwrap_or(0)
    };
    least(&power).max(least(&near))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_counts_far_or_near_is_kept() {
        let one = |n: usize, size: f64| {
            let mut c = vec![Complex64::ZERO; 121];
            c[0] = Complex64::ONE;
            c[n * n] = Complex64::new(size, 0.0);
            c
        };
        assert_eq!(last_order(&[&one(0, 1.0)], 5.0), 0);
        // Radiates, since κ = 9 is above n = 8.
        assert_eq!(last_order(&[&one(8, 0.01)], 9.0), 8);
        // Does not radiate, but its near pressure is 0.03 of the monopole's.
        assert_eq!(last_order(&[&one(8, 1.0)], 0.3), 8);
        assert_eq!(last_order(&[&one(8, 1e-3)], 0.3), 0);
        let (loud, faint) = (one(2, 1.0), one(9, 1e-2));
        assert_eq!(last_order(&[&loud[..9], &faint], 9.0), 9);
        assert_eq!(last_order(&[&[Complex64::ZERO]], 1.0), 0);
    }
}
