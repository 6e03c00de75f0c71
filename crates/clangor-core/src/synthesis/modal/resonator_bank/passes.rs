//! The loops over modes and samples, with the vector instructions of the machine.
//!
//! Two vectors of modes at a time run through up to [`PASS`] samples: first the driving forces, then the
//! rotation, then the sum for each path. Intermediate values stay in the cache, and the two rotations hide
//! each other's latency.

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
                rotate(simd, run, state, step, driven, own.clone());
                for (path, sums) in paths.iter_mut().zip(sums.chunks_exact_mut(PASS)) {
                    listen(simd, run, path, &mut sums[..samples], own.clone());
                }
            }
        }
        for (sums, outputs) in sums.chunks_exact(PASS).zip(outputs.chunks_exact_mut(PASS)) {
            for (sum, output) in sums.iter().zip(outputs) {
                *output = simd.reduce_sum_f64s(*sum);
            }
        }
    }
}

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

/// Rotates two vectors of modes through all samples; w_k replaces b_k.
#[inline(always)]
fn rotate<S: Simd>(
    simd: S,
    run: &mut [[S::f64s; 4]],
    state: &mut Planes,
    step: &Planes,
    driven: bool,
    own: Range<usize>,
) {
    // e^{λT} and the states.
    let (step_re, step_im) = (two::<S>(&step.re[own.clone()]), two::<S>(&step.im[own.clone()]));
    let minus_im = step_im.map(|x| simd.neg_f64s(x));
    let (mut re, mut im) = (two::<S>(&state.re[own.clone()]), two::<S>(&state.im[own.clone()]));
    if driven {
        // With forces: w_{k+1} = e^{λT} w_k + b_k.
        for sample in run {
            let forced = *sample;
            *sample = [re[0], re[1], im[0], im[1]];
            for v in 0..2 {
                let across = simd.mul_add_e_f64s(minus_im[v], im[v], forced[v]);
                let along = simd.mul_add_e_f64s(step_im[v], re[v], forced[2 + v]);
                re[v] = simd.mul_add_e_f64s(step_re[v], re[v], across);
                im[v] = simd.mul_add_e_f64s(step_re[v], im[v], along);
            }
        }
    } else {
        // Free ringing: w_{k+1} = e^{λT} w_k.
        for sample in run {
            *sample = [re[0], re[1], im[0], im[1]];
            for v in 0..2 {
                let across = simd.mul_f64s(minus_im[v], im[v]);
                let along = simd.mul_f64s(step_im[v], re[v]);
                re[v] = simd.mul_add_e_f64s(step_re[v], re[v], across);
                im[v] = simd.mul_add_e_f64s(step_re[v], im[v], along);
            }
        }
    }
    // The states after the run.
    S::as_mut_simd_f64s(&mut state.re[own.clone()]).0.copy_from_slice(&re);
    S::as_mut_simd_f64s(&mut state.im[own]).0.copy_from_slice(&im);
}

/// Adds Re{G w} of two vectors of modes to the samples of a path.
#[inline(always)]
fn listen<S: Simd>(simd: S, run: &[[S::f64s; 4]], path: &mut Path, sums: &mut [S::f64s], own: Range<usize>) {
    let (mut re, mut im) = (two::<S>(&path.now.re[own.clone()]), two::<S>(&path.now.im[own.clone()]));
    let slopes = [&path.slope.re[own.clone()], &path.slope.im[own.clone()]];
    if slopes.iter().all(|slope| slope.iter().all(|change| *change == 0.0)) {
        for (sample, sum) in run.iter().zip(sums) {
            for v in 0..2 {
                *sum = simd.mul_add_e_f64s(re[v], sample[v], *sum);
                *sum = simd.mul_add_e_f64s(im[v], sample[2 + v], *sum);
            }
        }
        return;
    }
    let [slope_re, slope_im] = slopes.map(|slope| two::<S>(slope));
    for (sample, sum) in run.iter().zip(sums) {
        for v in 0..2 {
            *sum = simd.mul_add_e_f64s(re[v], sample[v], *sum);
            *sum = simd.mul_add_e_f64s(im[v], sample[2 + v], *sum);
            re[v] = simd.add_f64s(re[v], slope_re[v]);
            im[v] = simd.add_f64s(im[v], slope_im[v]);
        }
    }
    S::as_mut_simd_f64s(&mut path.now.re[own.clone()]).0.copy_from_slice(&re);
    S::as_mut_simd_f64s(&mut path.now.im[own]).0.copy_from_slice(&im);
}
