//! The modes of all members, advanced exactly over steps of constant force.
//!
//! ```text
//! λ = −ξω + iω_d    w = q̇ − λ̄q    w ← E w + B Σ φ f    E = e^{λh}    B = (E − 1)/λ    q = Im w/ω_d
//! ```
//!
//! w is kept divided by ω_d, so that its imaginary part is q. Beside w, E w is kept: what the displacement is
//! after the next step without force. One pass per step and member updates both; another sums that
//! displacement at each contact. The loops use the widest vector instructions of the machine, chosen at run
//! time: along the modes here, along the contacts in [`few_modes`](super::few_modes).

use std::ops::Range;

use num_complex::Complex64;
use pulp::{Arch, Simd, WithSimd};

/// Modes are padded to multiples of two vectors of any machine.
pub(super) const LANES: usize = 16;

/// Modes in arrays side by side, padded per member.
#[derive(Clone, Debug, Default)]
pub(super) struct ModalPropagator {
    /// E and B/ω_d, real and imaginary.
    pub(super) turn: [Vec<f64>; 2],
    pub(super) push: [Vec<f64>; 2],
    /// w/ω_d and E w/ω_d, real and imaginary.
    pub(super) now: [Vec<f64>; 2],
    pub(super) next: [Vec<f64>; 2],
    /// Modal force of a step.
    drive: Vec<f64>,
    /// Poles; and for the damping loss (e^{2σh} − 1)/(2σ), (e^{2λh} − 1)/(2λ).
    poles: Vec<Complex64>,
    squares: Vec<(f64, Complex64)>,
}

/// (e^z − 1)/z·h for z = λh, without cancellation.
fn integral(pole: Complex64, step: f64) -> Complex64 {
    let (growth, angle) = (pole.re * step, pole.im * step);
    let half = (0.5 * angle).sin();
    let re = growth.exp_m1() * angle.cos() - 2.0 * half * half;
    Complex64::new(re, growth.exp() * angle.sin()) / pole
}

fn resize(vectors: &mut [Vec<f64>; 2], count: usize) {
    for vector in vectors {
        vector.clear();
        vector.resize(count, 0.0);
    }
}

impl ModalPropagator {
    /// Prepares for steps of `step` \[s\] from the states w. Modes with a pole of zero are padding.
    pub(super) fn prepare(&mut self, poles: &[Complex64], states: &[Complex64], step: f64, losses: bool) {
        let count = poles.len();
        for pair in [&mut self.turn, &mut self.push, &mut self.now, &mut self.next] {
            resize(pair, count);
        }
        self.drive.clear();
        self.drive.resize(count, 0.0);
        self.poles.clear();
        self.poles.extend_from_slice(poles);
        self.squares.clear();
        for (i, (pole, state)) in poles.iter().zip(states).enumerate() {
            if losses {
                let twice = 2.0 * pole.re;
                let even = if twice == 0.0 { step } else { (twice * step).exp_m1() / twice };
                let square = if pole.im == 0.0 { Complex64::ZERO } else { integral(2.0 * pole, step) };
                self.squares.push((even, square));
            }
            if pole.im == 0.0 {
                continue;
            }
            let turn = Complex64::from_polar((pole.re * step).exp(), pole.im * step);
            let push = integral(*pole, step) / pole.im;
            let now = state / pole.im;
            let next = turn * now;
            for (pair, value) in
                [(&mut self.turn, turn), (&mut self.push, push), (&mut self.now, now), (&mut self.next, next)]
            {
                (pair[0][i], pair[1][i]) = (value.re, value.im);
            }
        }
    }

    /// Displacement after a step by a unit force on two shapes of the modes `own` [m/N].
    pub(super) fn response(&self, own: Range<usize>, shapes: [&[f64]; 2]) -> f64 {
        let push = &self.push[1][own];
        shapes[0].iter().zip(shapes[1]).zip(push).map(|((a, b), push)| a * b * push).sum()
    }

    /// Σ φ q now, and after a step without force \[m\].
    pub(super) fn displacements(&self, own: Range<usize>, shape: &[f64]) -> [f64; 2] {
        [&self.now, &self.next].map(|w| shape.iter().zip(&w[1][own.clone()]).map(|(a, q)| a * q).sum())
    }

    /// The most that Σ φ q can become by free vibration \[m\].
    pub(super) fn reach(&self, own: Range<usize>, shape: &[f64]) -> f64 {
        let (re, im) = (&self.now[0][own.clone()], &self.now[1][own]);
        shape.iter().zip(re.iter().zip(im)).map(|(a, (x, y))| a.abs() * (x * x + y * y).sqrt()).sum()
    }

    /// w of mode `i`.
    pub(super) fn state(&self, i: usize) -> Complex64 {
        Complex64::new(self.now[0][i], self.now[1][i]) * self.poles[i].im
    }

    /// Energy ½(q̇² + ω²q²) of all modes \[J\].
    pub(super) fn energy(&self) -> f64 {
        self.energy_of(0..self.poles.len())
    }

    /// That of the modes `own` \[J\].
    pub(super) fn energy_of(&self, own: Range<usize>) -> f64 {
        let energy = |i: usize| {
            let (pole, q) = (self.poles[i], self.now[1][i]);
            let rate = self.now[0][i] * pole.im + pole.re * q;
            0.5 * (rate * rate + pole.norm_sqr() * q * q)
        };
        own.map(energy).sum()
    }

    /// What damping takes from the modes `own` over the coming step with these forces on these shapes \[J\].
    pub(super) fn loss(&mut self, own: Range<usize>, shapes: &[f64], forces: &[f64]) -> f64 {
        self.fill_drive(own.clone(), shapes, forces);
        // ∫2ξω q̇² with q̇ = Im(z e^{λt}), z = (λw + φf)/ω_d: motion about the deflection by a steady force.
        let loss = |i: usize| {
            let (pole, (even, square)) = (self.poles[i], self.squares[i]);
            if pole.im == 0.0 {
                return 0.0;
            }
            let z = pole * Complex64::new(self.now[0][i], self.now[1][i]) + self.drive[i] / pole.im;
            -pole.re * (z.norm_sqr() * even - (z * z * square).re)
        };
        own.map(loss).sum()
    }

    fn fill_drive(&mut self, own: Range<usize>, shapes: &[f64], forces: &[f64]) {
        let drive = &mut self.drive[own];
        drive.fill(0.0);
        for (shape, force) in shapes.chunks_exact(drive.len().max(1)).zip(forces) {
            if *force != 0.0 {
                for (drive, shape) in drive.iter_mut().zip(shape) {
                    *drive += shape * force;
                }
            }
        }
    }

    /// Advances the modes `own` by a step of these forces on these shapes, one after another in `shapes`;
    /// `sums` become Σ φ q for each shape, after the next step without force.
    pub(super) fn advance(
        &mut self,
        arch: Arch,
        own: Range<usize>,
        shapes: &[f64],
        forces: &[f64],
        sums: &mut [f64],
    ) {
        if own.is_empty() {
            sums.fill(0.0);
            return;
        }
        let [turn_re, turn_im] = self.turn.each_ref().map(|v| &v[own.clone()]);
        let [push_re, push_im] = self.push.each_ref().map(|v| &v[own.clone()]);
        let [now_re, now_im] = self.now.each_mut().map(|v| &mut v[own.clone()]);
        let [next_re, next_im] = self.next.each_mut().map(|v| &mut v[own.clone()]);
        let drive = &mut self.drive[own];
        arch.dispatch(Advance {
            turn: [turn_re, turn_im],
            push: [push_re, push_im],
            now: [now_re, now_im],
            next: [next_re, next_im],
            drive,
            shapes,
            forces,
            sums,
        });
    }
}

/// One step of the modes of a member.
struct Advance<'a> {
    turn: [&'a [f64]; 2],
    push: [&'a [f64]; 2],
    now: [&'a mut [f64]; 2],
    next: [&'a mut [f64]; 2],
    drive: &'a mut [f64],
    shapes: &'a [f64],
    forces: &'a [f64],
    sums: &'a mut [f64],
}

impl WithSimd for Advance<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Advance { turn, push, now, next, drive, shapes, forces, sums } = self;
        let count = drive.len();
        let single = forces.len() == 1;
        if !single {
            fill_drive(simd, drive, shapes, forces);
        }
        let read = |values| S::as_simd_f64s(values).0;
        let ([turn_re, turn_im], [push_re, push_im]) = (turn.map(read), push.map(read));
        let [now_re, now_im] = now.map(|v| S::as_mut_simd_f64s(v).0);
        let [next_re, next_im] = next.map(|v| S::as_mut_simd_f64s(v).0);
        // With one shape, the force on the modes needs no pass of its own.
        let (source, scale) = if single {
            (&shapes[..count], simd.splat_f64s(forces[0]))
        } else {
            (&*drive, simd.splat_f64s(1.0))
        };
        let source = read(source);
        for j in 0..source.len() {
            let q = simd.mul_f64s(source[j], scale);
            let re = simd.mul_add_f64s(push_re[j], q, next_re[j]);
            let im = simd.mul_add_f64s(push_im[j], q, next_im[j]);
            (now_re[j], now_im[j]) = (re, im);
            next_re[j] = simd.sub_f64s(simd.mul_f64s(turn_re[j], re), simd.mul_f64s(turn_im[j], im));
            next_im[j] = simd.mul_add_f64s(turn_re[j], im, simd.mul_f64s(turn_im[j], re));
        }
        for (shape, total) in shapes.chunks_exact(count).zip(sums) {
            // Two sums, which do not wait for each other.
            let (mut even, mut odd) = (simd.splat_f64s(0.0), simd.splat_f64s(0.0));
            for (shape, q) in read(shape).chunks_exact(2).zip(next_im.chunks_exact(2)) {
                even = simd.mul_add_f64s(shape[0], q[0], even);
                odd = simd.mul_add_f64s(shape[1], q[1], odd);
            }
            *total = simd.reduce_sum_f64s(simd.add_f64s(even, odd));
        }
    }
}

/// Modal forces of several shapes.
#[inline(always)]
fn fill_drive<S: Simd>(simd: S, drive: &mut [f64], shapes: &[f64], forces: &[f64]) {
    drive.fill(0.0);
    let count = drive.len();
    let drive = S::as_mut_simd_f64s(drive).0;
    for (shape, force) in shapes.chunks_exact(count).zip(forces) {
        if *force != 0.0 {
            let force = simd.splat_f64s(*force);
            for (drive, shape) in drive.iter_mut().zip(S::as_simd_f64s(shape).0) {
                *drive = simd.mul_add_f64s(*shape, force, *drive);
            }
        }
    }
}
