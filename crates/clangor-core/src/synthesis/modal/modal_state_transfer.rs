//! Transfer of the vibration of a breaking body to its pieces: \[FRAC\] q = UᵀMu, of displacement and
//! velocity.
//!
//! A mode that rings freely has the state w ([`bank`](crate::synthesis::modal::resonator_bank)), from which
//!
//! ```text
//! q = Im w/ω_d,   q̇ = Re w − ξω q,   u(x) = Σ qᵢ Uᵢ(x),   u̇(x) = Σ q̇ᵢ Uᵢ(x)
//! ```
//!
//! On a piece, the motion of the parent is a rigid motion plus vibration of the piece, u ≈ a + b × x + Σ qⱼ
//! Uⱼ(x). Only surface values of the piece's modes are known. Therefore q, a and b are fitted to u by least
//! squares over the surface; a and b become rigid motion. Inner crack faces have the motion of the nearest
//! place of the parent's surface. For a body that stays whole the fit is exact. Modes of an ellipsoid are
//! fitted at the corresponding places of the piece.
//!
//! Differs: \[FRAC\] weights by mass over the volume.
//!
//! Synthetic modes neither give nor take: their shapes are random, and their vibration ends with the body.
//!
//! The fit does not conserve energy; the energy is bounded afterwards. Each piece gets at most its share, by
//! its mass and the amplitude of the parent's modes there. All pieces together get at most the energy of the
//! parent.

use std::f64::consts::TAU;

use glam::DVec3;
use num_complex::Complex64;

use super::source::{ModalSource, StrikeMemory};
use crate::body::BodyId;
use crate::contact::ImpactPulse;
use crate::pose::Pose;
use crate::synthesis::modal::resonator_bank::{MAX_RATIO, Resonance, pole};

/// Relative regularisation of the diagonal, for modes that are indistinguishable on the surface.
const RIDGE: f64 = 1e-9;
/// Fewest and most sampling points of the surface of a piece.
const SAMPLES: [usize; 2] = [120, 1200];

/// Free vibration of a body: w of each mode [kg^½ m/s].
#[derive(Clone, Debug, PartialEq)]
pub struct ModalState(pub Vec<Complex64>);

/// A sampling point of a surface; all represent the same area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceSample {
    /// Place \[m\], frame of the body.
    pub place: DVec3,
    /// Outer normal, of any length.
    pub normal: DVec3,
}

/// Vibration inherited by a piece.
#[derive(Clone, Debug, PartialEq)]
pub struct Handed {
    /// Its vibration.
    pub state: ModalState,
    /// Energy of the parent in the volume of the piece, by its mass \[J\].
    pub share: f64,
}

/// λ of a mode; `None` if its damping is too high to ring.
fn ringing_pole(resonance: &Resonance) -> Option<Complex64> {
    let omega = TAU * resonance.frequency;
    (resonance.damping_ratio < MAX_RATIO).then(|| pole(omega, resonance.damping_ratio * omega))
}

impl ModalState {
    /// At rest.
    pub fn rest(source: &ModalSource) -> Self {
        ModalState(vec![Complex64::ZERO; source.resonances().len()])
    }

    /// Vibration at a time \[s\] after the impacts on a body. Impacts in progress count as complete; later
    /// ones are skipped.
    pub fn after_impacts(source: &ModalSource, body: BodyId, pulses: &[ImpactPulse], time: f64) -> Self {
        let mut state = ModalState::rest(source);
        let (mut amplitudes, mut striking) = (Vec::new(), StrikeMemory::default());
        for pulse in pulses.iter().filter(|pulse| pulse.time <= time) {
            for points in pulse.modal_impulses_on(body) {
                source.amplitudes(&points, &mut striking, &mut amplitudes);
                let modes = state.0.iter_mut().zip(&amplitudes).zip(source.resonances());
                for ((w, amplitude), resonance) in modes {
                    let Some(pole) = ringing_pole(resonance) else { continue };
                    let ring = pulse.shape.at_pole(pole, pulse.duration);
                    *w += *amplitude * (pole * (time - pulse.onset)).exp() * ring;
                }
            }
        }
        state
    }

    /// The vibration after some time \[s\].
    pub fn later(&self, source: &ModalSource, seconds: f64) -> Self {
        let left = |(w, resonance): (&Complex64, &Resonance)| {
            ringing_pole(resonance).map_or(Complex64::ZERO, |pole| w * (pole * seconds).exp())
        };
        ModalState(self.0.iter().zip(source.resonances()).map(left).collect())
    }

    /// The same, also for negative times; modes that change by more than this number of e-folds are left out.
    pub(super) fn later_within(&self, source: &ModalSource, seconds: f64, most: f64) -> Self {
        let mut state = self.later(source, seconds);
        for (w, resonance) in state.0.iter_mut().zip(source.resonances()) {
            let folds = TAU * resonance.frequency * resonance.damping_ratio * seconds.abs();
            if folds > most {
                *w = Complex64::ZERO;
            }
        }
        state
    }

    /// Sum with another vibration times a factor.
    pub fn plus(&self, other: &ModalState, factor: f64) -> Self {
        ModalState(self.0.iter().zip(&other.0).map(|(a, b)| a + b * factor).collect())
    }

    /// q [kg^½ m] and q̇ [kg^½ m/s] of each mode.
    fn motions(&self, source: &ModalSource) -> Vec<[f64; 2]> {
        let motion = |(w, resonance): (&Complex64, &Resonance)| {
            let Some(pole) = ringing_pole(resonance) else { return [0.0; 2] };
            let q = w.im / pole.im;
            [q, w.re + pole.re * q]
        };
        self.0.iter().zip(source.resonances()).map(motion).collect()
    }

    /// ½ (q̇² + ω² q²) of each mode \[J\].
    pub fn energies(&self, source: &ModalSource) -> Vec<f64> {
        let energy = |([q, rate], resonance): ([f64; 2], &Resonance)| {
            0.5 * (rate * rate + (TAU * resonance.frequency * q).powi(2))
        };
        self.motions(source).into_iter().zip(source.resonances()).map(energy).collect()
    }

    /// Sum over all modes \[J\].
    pub fn energy(&self, source: &ModalSource) -> f64 {
        self.energies(source).iter().sum()
    }
}

/// Number of sampling points for a piece with this number of modes.
pub fn sample_count(modes: usize) -> usize {
    (2 * (modes + 6)).clamp(SAMPLES[0], SAMPLES[1])
}

/// Vibration that a piece inherits from its parent, fitted at these places of the piece, with the poses of
/// both \[m\] at the fracture. The energy is not bounded yet.
pub fn handed_over(
    (parent, state): (&ModalSource, &ModalState),
    piece: &ModalSource,
    samples: &[SurfaceSample],
    [parent_pose, piece_pose]: [&Pose; 2],
    mass: f64,
) -> Handed {
    let count = piece.known_modes() + 6;
    let moving = state.motions(parent);
    let energies = state.energies(parent);
    let turn = piece_pose.orientation.inverse() * parent_pose.orientation;
    let size = samples.iter().map(|sample| sample.place.length()).fold(1e-9, f64::max);
    let mut fit = Fit::new(count);
    let mut share = 0.0;
    let (mut own, mut others) = (Vec::new(), Vec::new());
    for sample in samples {
        // Motion of the parent and energy density at the place.
        let place = parent_pose.body_from_world(piece_pose.world_from_body(sample.place));
        parent.motions(place, turn.inverse() * sample.normal, &mut others);
        let (mut displacement, mut velocity) = (DVec3::ZERO, DVec3::ZERO);
        others.truncate(parent.known_modes());
        for ((shape, [q, rate]), energy) in others.iter().zip(&moving).zip(&energies) {
            displacement += *shape * *q;
            velocity += *shape * *rate;
            share += energy * shape.length_squared() * mass / samples.len() as f64;
        }
        // Rigid motions and mode shapes of the piece there.
        piece.motions(sample.place, sample.normal, &mut own);
        own.truncate(piece.known_modes());
        let turns = DVec3::AXES.map(|axis| axis.cross(sample.place) / size);
        let shapes: Vec<DVec3> = DVec3::AXES.into_iter().chain(turns).chain(own.iter().copied()).collect();
        fit.add(&shapes, [turn * displacement, turn * velocity]);
    }
    // Modal amplitudes q and velocities; state w = q̇ + ξω q + iω_d q.
    let mut solved = fit.solve();
    solved.resize(piece.resonances().len() + 6, [0.0; 2]);
    let state = piece.resonances().iter().zip(&solved[6..]).map(|(resonance, [q, rate])| {
        ringing_pole(resonance)
            .map_or(Complex64::ZERO, |pole| Complex64::new(rate - pole.re * q, pole.im * q))
    });
    Handed { state: ModalState(state.collect()), share }
}

/// Scales the vibrations of the pieces of one body so that none exceeds its share of an energy \[J\]; returns
/// their total energy.
pub fn bound_energy(pieces: &mut [(&ModalSource, &mut Handed)], available: f64) -> f64 {
    let shares: f64 = pieces.iter().map(|(_, handed)| handed.share).sum();
    let mut given = 0.0;
    for (source, handed) in pieces {
        let energy = handed.state.energy(source);
        let most = if shares > 0.0 { available * handed.share / shares } else { 0.0 };
        let factor = if energy > most { (most / energy).sqrt() } else { 1.0 };
        handed.state.0.iter_mut().for_each(|w| *w *= factor);
        given += energy.min(most);
    }
    given
}

/// Normal equations of a least-squares fit with two right-hand sides.
struct Fit {
    count: usize,
    /// Lower triangle, row by row.
    products: Vec<f64>,
    sides: Vec<[f64; 2]>,
}

impl Fit {
    fn new(count: usize) -> Self {
        Fit { count, products: vec![0.0; count * (count + 1) / 2], sides: vec![[0.0; 2]; count] }
    }

    /// Adds a sampling point: its derivative by the unknowns, and the values to fit.
    fn add(&mut self, shapes: &[DVec3], wanted: [DVec3; 2]) {
        let mut at = 0;
        for (i, a) in shapes.iter().enumerate() {
            for (product, b) in self.products[at..=at + i].iter_mut().zip(shapes) {
                *product += a.dot(*b);
            }
            at += i + 1;
            self.sides[i] = [0, 1].map(|k| self.sides[i][k] + a.dot(wanted[k]));
        }
    }

    /// The unknowns, by Cholesky decomposition; 0 for unknowns without effect.
    fn solve(mut self) -> Vec<[f64; 2]> {
        let row = |i: usize| i * (i + 1) / 2;
        let scales: Vec<f64> = (0..self.count).map(|i| self.products[row(i) + i].sqrt()).collect();
        let inverse = |i: usize| if scales[i] > 0.0 { 1.0 / scales[i] } else { 0.0 };
        for i in 0..self.count {
            for j in 0..=i {
                let scaled = self.products[row(i) + j] * inverse(i) * inverse(j);
                let mut sum = if i == j { scaled.max(1.0) + RIDGE } else { scaled };
                for k in 0..j {
                    sum -= self.products[row(i) + k] * self.products[row(j) + k];
                }
                self.products[row(i) + j] = match i == j {
                    true => sum.max(RIDGE).sqrt(),
                    false => sum / self.products[row(j) + j],
                };
            }
        }
        let solved = [0, 1].map(|side| {
            let mut x: Vec<f64> = (0..self.count).map(|i| self.sides[i][side] * inverse(i)).collect();
            for i in 0..self.count {
                let known: f64 = (0..i).map(|k| self.products[row(i) + k] * x[k]).sum();
                x[i] = (x[i] - known) / self.products[row(i) + i];
            }
            for i in (0..self.count).rev() {
                let known: f64 = (i + 1..self.count).map(|k| self.products[row(k) + i] * x[k]).sum();
                x[i] = (x[i] - known) / self.products[row(i) + i];
            }
            x
        });
        (0..self.count).map(|i| [0, 1].map(|side| solved[side][i] * inverse(i))).collect()
    }
}
