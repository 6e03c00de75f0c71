//! The loops over modes and samples, with the vector instructions of the machine.
//!
//! Two vectors of modes at a time run through up to [`PASS`] samples: first the driving forces, then the
//! rotation together with the sums of two paths, then the sums of two more paths at a time. A rotation waits
//! for the one before it, and the sums fill that time: a second receiver costs little. Intermediate values
//! stay in the cache.

use std::ops::Range;

use pulp::{Simd, WithSimd};

use super::{CHUNK, Memory, PASS, Path, Planes, Pulse, ResonatorBank};
use crate::synthesis::modal::drive::TERMS;

/// Advances all modes by some samples, with the vector instructions of the machine.
pub(super) struct Passing<'a> {
    pub(super) bank: &'a mut ResonatorBank,
    pub(super) samples: usize,
}

impl WithSimd for Passing<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Passing { bank, samples } = self;
        let ResonatorBank { state, step, weights, awake, paths, pulses, next, memory, .. } = bank;
        let Memory { run, sums, samples: outputs } = memory;
        let run = &mut S::as_mut_simd_f64s(run).0.as_chunks_mut::<4>().0[..samples];
        // Narrow vectors fill all of it, wide ones a part.
        let sums = &mut S::as_mut_simd_f64s(sums).0[..PASS * paths.len()];
        sums.fill(simd.splat_f64s(0.0));
        let width = 2 * S::F64_LANES;
        for chunk in (0..awake.len()).filter(|chunk| awake[*chunk]) {
            for at in (chunk * CHUNK..(chunk + 1) * CHUNK).step_by(width) {
                let own = at..at + width;
                let driven = drive(simd, run, weights, pulses, *next, own.clone());
                let mut modes = Modes::<S>::load(simd, state, step, own.clone());
                let kept = paths.len() > PAIR;
                let mut pairs = paths.chunks_mut(PAIR).zip(sums.chunks_mut(PAIR * PASS));
                match pairs.next() {
                    Some((paths, sums)) => modes.ring(simd, run, [driven, kept], paths, sums, own.clone()),
                    None => run.iter().for_each(|sample| modes.rotate(simd, sample, driven)),
                }
                for (paths, sums) in pairs {
                    listen(simd, run, paths, sums, own.clone());
                }
                modes.store(state, own);
            }
        }
        for (sums, outputs) in sums.chunks(PAIR * PASS).zip(outputs.chunks_mut(PAIR * PASS)) {
            let count = sums.len() / PASS;
            for (p, outputs) in outputs.chunks_exact_mut(PASS).enumerate() {
                for (sums, output) in sums.chunks_exact(count).zip(outputs) {
                    *output = simd.reduce_sum_f64s(sums[p]);
                }
            }
        }
    }
}

/// Paths that are summed together. The sums of a pair alternate.
const PAIR: usize = 2;

/// Two vectors.
type Two<S> = [<S as Simd>::f64s; 2];

#[inline(always)]
fn two<S: Simd>(values: &[f64]) -> Two<S> {
    let vectors = S::as_simd_f64s(values).0;
    [vectors[0], vectors[1]]
}

/// b_k of the forces in progress, as (re, re, im, im) for each sample; whether there are any.
#[inline(always)]
fn drive<S: Simd>(
    simd: S,
    run: &mut [[S::f64s; 4]],
    weights: &[Planes; TERMS],
    pulses: &[Pulse],
    next: i64,
    own: Range<usize>,
) -> bool {
    let mut driven = false;
    for pulse in pulses {
        // Samples of the run at which the force acts.
        let begin = pulse.first.max(next);
        let end = pulse.end().min(next + run.len() as i64);
        if begin >= end {
            continue;
        }
        if !driven {
            run.fill([simd.splat_f64s(0.0); 4]);
            driven = true;
        }
        // Weights φ_l of the modes times their modal impulse.
        let amplitude = two::<S>(&pulse.amplitudes[own.clone()]);
        let mut scaled = [[simd.splat_f64s(0.0); 4]; TERMS];
        for (scaled, weights) in scaled.iter_mut().zip(weights) {
            let (re, im) = (two::<S>(&weights.re[own.clone()]), two::<S>(&weights.im[own.clone()]));
            for v in 0..2 {
                scaled[v] = simd.mul_f64s(re[v], amplitude[v]);
                scaled[2 + v] = simd.mul_f64s(im[v], amplitude[v]);
            }
        }
        // b_k = Σ_l γ_l φ_l, summed over the forces.
        let terms = &pulse.force.terms[(begin - pulse.first) as usize..(end - pulse.first) as usize];
        let run = &mut run[(begin - next) as usize..(end - next) as usize];
        for (sums, terms) in run.iter_mut().zip(terms) {
            for (term, scaled) in terms.iter().zip(&scaled) {
                let term = simd.splat_f64s(*term);
                for v in 0..4 {
                    sums[v] = simd.mul_add_e_f64s(term, scaled[v], sums[v]);
                }
            }
        }
    }
    driven
}

/// Two vectors of modes in registers: states and e^{λT}.
struct Modes<S: Simd> {
    re: Two<S>,
    im: Two<S>,
    step_re: Two<S>,
    step_im: Two<S>,
    minus_im: Two<S>,
}

impl<S: Simd> Modes<S> {
    #[inline(always)]
    fn load(simd: S, state: &Planes, step: &Planes, own: Range<usize>) -> Self {
        let step_im = two::<S>(&step.im[own.clone()]);
        Modes {
            re: two::<S>(&state.re[own.clone()]),
            im: two::<S>(&state.im[own.clone()]),
            step_re: two::<S>(&step.re[own]),
            step_im,
            minus_im: [simd.neg_f64s(step_im[0]), simd.neg_f64s(step_im[1])],
        }
    }

    #[inline(always)]
    fn store(self, state: &mut Planes, own: Range<usize>) {
        S::as_mut_simd_f64s(&mut state.re[own.clone()]).0.copy_from_slice(&self.re);
        S::as_mut_simd_f64s(&mut state.im[own]).0.copy_from_slice(&self.im);
    }

    /// w_k as (re, re, im, im).
    #[inline(always)]
    fn sample(&self) -> [S::f64s; 4] {
        [self.re[0], self.re[1], self.im[0], self.im[1]]
    }

    /// w_{k+1} = e^{λT} w_k + b_k; without a force b_k is not read.
    #[inline(always)]
    fn rotate(&mut self, simd: S, forced: &[S::f64s; 4], driven: bool) {
        for v in 0..2 {
            let (across, along) = if driven {
                (
                    simd.mul_add_e_f64s(self.minus_im[v], self.im[v], forced[v]),
                    simd.mul_add_e_f64s(self.step_im[v], self.re[v], forced[2 + v]),
                )
            } else {
                (simd.mul_f64s(self.minus_im[v], self.im[v]), simd.mul_f64s(self.step_im[v], self.re[v]))
            };
            self.re[v] = simd.mul_add_e_f64s(self.step_re[v], self.re[v], across);
            self.im[v] = simd.mul_add_e_f64s(self.step_re[v], self.im[v], along);
        }
    }

    /// Rotates through all samples and adds what one or two paths receive; if `kept`, w_k replaces b_k.
    #[inline(always)]
    fn ring(
        &mut self,
        simd: S,
        run: &mut [[S::f64s; 4]],
        how: [bool; 2],
        paths: &mut [Path],
        sums: &mut [S::f64s],
        own: Range<usize>,
    ) {
        let moving = paths.iter().any(|path| path.is_moving(own.clone()));
        match (paths, moving) {
            ([a, b], true) => self.ring_into::<2, true>(simd, run, how, [a, b], sums, own),
            ([a, b], false) => self.ring_into::<2, false>(simd, run, how, [a, b], sums, own),
            ([a, ..], true) => self.ring_into::<1, true>(simd, run, how, [a], sums, own),
            ([a, ..], false) => self.ring_into::<1, false>(simd, run, how, [a], sums, own),
            ([], _) => {}
        }
    }

    #[inline(always)]
    fn ring_into<const N: usize, const MOVING: bool>(
        &mut self,
        simd: S,
        run: &mut [[S::f64s; 4]],
        [driven, kept]: [bool; 2],
        paths: [&mut Path; N],
        sums: &mut [S::f64s],
        own: Range<usize>,
    ) {
        let mut heard = paths.each_ref().map(|path| Transfers::<S>::load(path, own.clone()));
        for (sample, sums) in run.iter_mut().zip(sums.as_chunks_mut::<N>().0) {
            let now = self.sample();
            for (heard, sum) in heard.iter_mut().zip(sums) {
                heard.add::<MOVING>(simd, &now, sum);
            }
            self.rotate(simd, sample, driven);
            if kept {
                *sample = now;
            }
        }
        if MOVING {
            heard.iter().zip(paths).for_each(|(heard, path)| heard.store(path, own.clone()));
        }
    }
}

/// G of two vectors of modes along a path, in registers.
struct Transfers<S: Simd> {
    re: Two<S>,
    im: Two<S>,
    slope_re: Two<S>,
    slope_im: Two<S>,
}

impl<S: Simd> Transfers<S> {
    #[inline(always)]
    fn load(path: &Path, own: Range<usize>) -> Self {
        Transfers {
            re: two::<S>(&path.now.re[own.clone()]),
            im: two::<S>(&path.now.im[own.clone()]),
            slope_re: two::<S>(&path.slope.re[own.clone()]),
            slope_im: two::<S>(&path.slope.im[own]),
        }
    }

    #[inline(always)]
    fn store(&self, path: &mut Path, own: Range<usize>) {
        S::as_mut_simd_f64s(&mut path.now.re[own.clone()]).0.copy_from_slice(&self.re);
        S::as_mut_simd_f64s(&mut path.now.im[own]).0.copy_from_slice(&self.im);
    }

    /// Adds Re{G w} of a sample, and goes on to the next.
    #[inline(always)]
    fn add<const MOVING: bool>(&mut self, simd: S, sample: &[S::f64s; 4], sum: &mut S::f64s) {
        for v in 0..2 {
            *sum = simd.mul_add_e_f64s(self.re[v], sample[v], *sum);
            *sum = simd.mul_add_e_f64s(self.im[v], sample[2 + v], *sum);
            if MOVING {
                self.re[v] = simd.add_f64s(self.re[v], self.slope_re[v]);
                self.im[v] = simd.add_f64s(self.im[v], self.slope_im[v]);
            }
        }
    }
}

impl Path {
    /// Whether the transfers of some modes change.
    #[inline(always)]
    fn is_moving(&self, own: Range<usize>) -> bool {
        let changes = |slope: &[f64]| slope.iter().any(|change| *change != 0.0);
        changes(&self.slope.re[own.clone()]) || changes(&self.slope.im[own])
    }
}

/// Adds Re{G w} of two vectors of modes, which [`Modes::ring`] has kept, to the samples of one or two paths.
#[inline(always)]
fn listen<S: Simd>(
    simd: S,
    run: &[[S::f64s; 4]],
    paths: &mut [Path],
    sums: &mut [S::f64s],
    own: Range<usize>,
) {
    let moving = paths.iter().any(|path| path.is_moving(own.clone()));
    match (paths, moving) {
        ([a, b], true) => listen_along::<S, 2, true>(simd, run, [a, b], sums, own),
        ([a, b], false) => listen_along::<S, 2, false>(simd, run, [a, b], sums, own),
        ([a, ..], true) => listen_along::<S, 1, true>(simd, run, [a], sums, own),
        ([a, ..], false) => listen_along::<S, 1, false>(simd, run, [a], sums, own),
        ([], _) => {}
    }
}

#[inline(always)]
fn listen_along<S: Simd, const N: usize, const MOVING: bool>(
    simd: S,
    run: &[[S::f64s; 4]],
    paths: [&mut Path; N],
    sums: &mut [S::f64s],
    own: Range<usize>,
) {
    let mut heard = paths.each_ref().map(|path| Transfers::<S>::load(path, own.clone()));
    for (sample, sums) in run.iter().zip(sums.as_chunks_mut::<N>().0) {
        for (heard, sum) in heard.iter_mut().zip(sums) {
            heard.add::<MOVING>(simd, sample, sum);
        }
    }
    if MOVING {
        heard.iter().zip(paths).for_each(|(heard, path)| heard.store(path, own.clone()));
    }
}
