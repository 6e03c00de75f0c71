//! When a body breaks under its loads, and with which stress and energy.
//!
//! ```text
//! K u = F(t) − reaction,    E_S = ½ uᵀF ≤ U(t)        at the instants of the loads, one after another
//! largest σ₁ ≥ strength     and     G_c A ≤ η E       it breaks
//! ```
//!
//! Stress follows the force of the instant, quasi-statically. All impacts that act at that instant load the
//! body together. The strain energy cannot exceed the energy U that contacts and modes store then: a
//! body that gives way would meet less force. If the static solution exceeds it, forces, stress and energy
//! are scaled down. The first instant at which the strength is reached is found within the step.
//!
//! Strength and energy are both necessary \[Leguillon2002\]. If the energy of the instant is too small for any
//! crack, the impact goes on loading the body.
//!
//! The impulse of the impact has moved the body as a whole, so that cracks and pieces can use only what motion
//! lost in it: E = min(U, heat and vibration).
//!
//! A load of one instant (`Load::HalfSinePeak`, `Load::Step`) is the same with that instant only; then
//! E = min(E_S, ΔE), or E_S whatever it is.

use clangor_bake::mesh::tetrahedra::TetMesh;
use clangor_bake::stress::{Deformation, PointLoad, StressBody, SymmetricTensor};
use clangor_core::scene::breaking::{Load, Score};
use glam::DVec3;

use super::contact_loads::{ContactLoad, Felt};
use super::error::FractureError;
use super::family::Family;

/// Most instants of one load that are looked at.
const MOST_INSTANTS: usize = 256;
/// Relative difference of two sets of forces that count as proportional.
const PROPORTIONAL: f64 = 1e-3;
/// Rounds in which the instant of breaking is found within a step.
const ROUNDS: usize = 3;

/// The instants \[s\] of loads at which stress is looked at, from `fresh` on.
pub(super) fn instants(loads: &[ContactLoad], fresh: f64) -> Vec<f64> {
    let mut times = Vec::new();
    for load in loads {
        match &load.felt {
            Felt::Once(_) => times.push(fresh),
            Felt::OverTime(history) => {
                let count = history.stored.len();
                let ends = (0..count).step_by(count.div_ceil(MOST_INSTANTS).max(1));
                times.extend(ends.map(|n| load.onset + n as f64 * history.step));
            }
        }
    }
    times.retain(|time| *time >= fresh);
    times.sort_by(f64::total_cmp);
    times.dedup();
    times
}

/// Forces at an instant and the energy behind them.
struct LoadsNow {
    loads: Vec<PointLoad>,
    stored: f64,
}

/// What acts on a body whose centre of mass is at `centre` \[m\] in the frame of its mesh.
fn felt(loads: &[ContactLoad], centre: DVec3, time: f64) -> LoadsNow {
    let mut all = LoadsNow { loads: Vec::new(), stored: 0.0 };
    let place = |point: DVec3, force: DVec3| PointLoad { point: point + centre, force };
    for load in loads {
        match &load.felt {
            Felt::Once(forces) => {
                all.loads.extend(forces.iter().map(|(point, force)| place(*point, *force)));
                all.stored += load.energy;
            }
            Felt::OverTime(history) => {
                let (forces, stored) = history.at(time - load.onset);
                all.loads.extend(history.points.iter().zip(forces).map(|(point, force)| place(*point, force)));
                all.stored += stored;
            }
        }
    }
    all
}

/// The body at an instant.
#[derive(Clone, Copy, Debug)]
pub(super) struct Strained {
    /// Largest ratio of stress to strength.
    pub(super) utilisation: f64,
    /// Energy that contacts and modes store \[J\].
    pub(super) stored: f64,
    /// Factor of the last static solution.
    factor: f64,
}

/// Forces whose static solution is known.
struct Solved {
    loads: Vec<PointLoad>,
    deformation: Deformation,
    utilisation: f64,
}

/// Looks for the instant at which a body breaks.
pub(super) struct BreakingSearch<'a> {
    stress: &'a mut StressBody,
    family: &'a Family,
    loads: &'a [ContactLoad],
    centre: DVec3,
    last: Option<Solved>,
}

impl<'a> BreakingSearch<'a> {
    /// For a body with its centre of mass at `centre` \[m\] in the frame of its mesh.
    pub(super) fn new(
        stress: &'a mut StressBody,
        family: &'a Family,
        loads: &'a [ContactLoad],
        centre: DVec3,
    ) -> Self {
        BreakingSearch { stress, family, loads, centre, last: None }
    }

    /// The body at the instant at which stress reaches the strength: at `time`, or since `before`, the instant
    /// before it \[s\]. `None` if stress stays below.
    ///
    /// # Errors
    /// [`FractureError`].
    pub(super) fn reached(
        &mut self,
        time: f64,
        before: Option<f64>,
    ) -> Result<Option<Strained>, FractureError> {
        let Some(mut found) = self.at(time)?.filter(|found| found.utilisation >= 1.0) else {
            return Ok(None);
        };
        let Some(mut from) = before else { return Ok(Some(found)) };
        let mut low = self.at(from)?.map_or(0.0, |strained| strained.utilisation);
        let (mut till, mut place) = (time, time);
        for _ in 0..ROUNDS {
            if low >= 1.0 {
                break;
            }
            place = from + (till - from) * (1.0 - low) / (found.utilisation - low);
            match self.at(place)? {
                Some(here) if here.utilisation >= 1.0 => (till, found) = (place, here),
                other => (from, low) = (place, other.map_or(0.0, |strained| strained.utilisation)),
            }
        }
        // The factor is that of the solution made last.
        self.at(place)
    }

    /// The body at an instant; `None` if its stress is known to stay below the strength.
    fn at(&mut self, time: f64) -> Result<Option<Strained>, FractureError> {
        let LoadsNow { loads, stored } = felt(self.loads, self.centre, time);
        let known = self.last.as_ref().and_then(|last| proportion(&loads, &last.loads));
        let part = match known {
            Some(part) => part,
            None => {
                // The bound of the energy can only reduce forces and stress, so a body that withstands the
                // full loads stays whole.
                if self.stress.tension_above(&loads, self.family.least_strength())?.is_none() {
                    return Ok(None);
                }
                let deformation = self.stress.solve(&loads)?;
                let utilisation = utilisation(self.stress.mesh(), &deformation, self.family);
                self.last = Some(Solved { loads, deformation, utilisation });
                1.0
            }
        };
        let Some(last) = &self.last else { return Ok(None) };
        let strain = last.deformation.strain_energy * (part * part);
        let bounded = self.family.breaking.load != Load::Step && strain > stored;
        let factor = if bounded { part * (stored / strain).sqrt() } else { part };
        Ok(Some(Strained { utilisation: last.utilisation * factor, stored, factor }))
    }

    /// Deformation of the body at an instant, the last that was looked at.
    pub(super) fn deformation(&self, strained: &Strained) -> Option<Deformation> {
        self.last.as_ref().map(|last| last.deformation.clone().scaled(strained.factor))
    }
}

/// The factor between two sets of forces at the same points; `None` if they are not proportional.
fn proportion(loads: &[PointLoad], reference: &[PointLoad]) -> Option<f64> {
    if loads.len() != reference.len() {
        return None;
    }
    let sums = loads.iter().zip(reference).fold([0.0; 3], |[a, b, c], (load, other)| {
        let (f, g) = (load.force, other.force);
        [a + f.dot(g), b + g.length_squared(), c + f.length_squared()]
    });
    let [product, reference_square, square] = sums;
    let factor = product / reference_square;
    let rest = square - factor * product;
    (factor >= 0.0 && rest <= PROPORTIONAL * PROPORTIONAL * square).then_some(factor)
}

/// Largest ratio of stress to strength.
fn utilisation(mesh: &TetMesh, deformation: &Deformation, family: &Family) -> f64 {
    let scores = &family.breaking.scores;
    match scores.is_empty() {
        true => deformation.maximum_tension().stress / family.strength,
        false => across_scores(mesh, &deformation.element_stress, scores, family),
    }
}

/// The largest ratio of the tension across a scored plane to the strength there.
fn across_scores(mesh: &TetMesh, stress: &[SymmetricTensor], scores: &[Score], family: &Family) -> f64 {
    let across = |score: &Score| {
        let normal = score.normal.normalize_or_zero();
        let height = |n: &u32| (mesh.nodes[*n as usize] - score.point).dot(normal);
        let reaches = |(element, stress): (&[u32; 10], &SymmetricTensor)| {
            let heights = || element[..4].iter().map(height);
            let (low, high) =
                (heights().fold(f64::INFINITY, f64::min), heights().fold(f64::NEG_INFINITY, f64::max));
            (low <= 0.0 && high >= 0.0).then(|| normal.dot(stress.on(normal)))
        };
        mesh.elements.iter().zip(stress).filter_map(reaches).fold(f64::NEG_INFINITY, f64::max)
            / family.strength_at(score)
    };
    scores.iter().map(across).fold(f64::NEG_INFINITY, f64::max)
}
