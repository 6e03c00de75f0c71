//! Solves over a fixed time, and the levels of what rings afterwards.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use clangor_core::contact::compliant::{
    ContactSolution, ContactSystem, Member, MemberContact, SolverMemory, StepSettings,
};
use num_complex::Complex64;

/// Steps over a fixed time.
pub(crate) fn solve(
    members: &[Member],
    contacts: &[MemberContact],
    per_duration: f64,
    time: f64,
) -> ContactSolution {
    let system = ContactSystem::new(members, contacts).unwrap();
    let steps = (time / system.first_duration().unwrap() * per_duration).ceil();
    let settings = StepSettings {
        step: Some(time / steps),
        max_steps: steps as usize,
        end_when_parted: false,
        ..StepSettings::default()
    };
    system.solve(&settings, &mut SolverMemory::default()).unwrap().clone()
}

/// Energies by third octaves, of those within 30 dB of the greatest.
fn third_octaves(poles: &[Complex64], energies: &[f64]) -> Vec<(i32, f64)> {
    let mut bands = BTreeMap::new();
    for (pole, energy) in poles.iter().zip(energies) {
        let band = (10.0 * (pole.norm() / TAU).log10()).round() as i32;
        *bands.entry(band).or_insert(0.0) += energy;
    }
    let greatest = bands.values().copied().fold(0.0, f64::max);
    bands.into_iter().filter(|(_, energy)| *energy > 1e-3 * greatest).collect()
}

pub(crate) fn mode_energies(state: &[Complex64]) -> Vec<f64> {
    state.iter().map(|w| 0.5 * w.norm_sqr()).collect()
}

/// Differences of third-octave levels [dB] in the bands of `exact`.
pub(crate) fn level_errors(poles: &[Complex64], state: &[Complex64], exact: &[f64]) -> Vec<f64> {
    let found = mode_energies(state);
    let all: Vec<(i32, f64)> = third_octaves(poles, exact);
    let own = |band: i32| -> f64 {
        let of_band = |pole: &Complex64| (10.0 * (pole.norm() / TAU).log10()).round() as i32 == band;
        poles.iter().zip(&found).filter(|(pole, _)| of_band(pole)).map(|(_, e)| e).sum()
    };
    all.iter().map(|(band, energy)| 10.0 * (own(*band) / energy).log10()).collect()
}

pub(crate) fn worst_level(member: &Member, state: &[Complex64], exact: &[f64]) -> f64 {
    level_errors(&member.poles, state, exact).iter().fold(0.0, |a: f64, b| a.max(b.abs()))
}
