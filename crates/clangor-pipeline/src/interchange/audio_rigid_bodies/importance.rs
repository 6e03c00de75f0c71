//! The order of modes in a file: a player that stops after some should have those that matter.
//!
//! The energy of the sound of an impact at a random place in a random direction, over what all modes have in
//! common:
//!
//! ```text
//! E ∝ ⟨|U|²⟩ ∫ (U·n)² dA σ / d,  σ = (ka)²/(1 + (ka)²),  π a² = A
//! ```
//!
//! The velocity of a unit impact is U, it radiates σ ρ c ∫ U_n² dA, for a time 1/d. σ is that of a compact
//! source, which the draft names; a transfer would be better by little. Loudness of frequencies does not
//! enter.

use clangor_core::medium::Medium;
use clangor_core::sound_model::modal::surface::ModalSurface;
use glam::DVec3;

use super::RingingMode;

/// Least decay [1/s]: what lasts longer than ten seconds is not more important for it.
const LEAST_DECAY: f64 = 0.1;

/// Indices of modes, the most important first.
pub(super) fn by_importance(surface: &ModalSurface, modes: &[RingingMode]) -> Vec<usize> {
    let quarters = surface.quarters();
    let areas: Vec<DVec3> = (0..quarters.triangles.len()).map(|t| quarters.area_vector(t)).collect();
    let area: f64 = areas.iter().map(|a| a.length()).sum();
    let energies: Vec<f64> = modes
        .iter()
        .map(|mode| {
            let (mut square, mut flow) = (0.0, 0.0);
            for (corners, area) in quarters.triangles.iter().zip(&areas) {
                let size = area.length();
                for node in corners {
                    let shape = mode.shape[*node as usize];
                    square += size * shape.length_squared();
                    flow += shape.dot(*area).powi(2) / size.max(f64::MIN_POSITIVE);
                }
            }
            let wavenumber = std::f64::consts::TAU * mode.frequency / Medium::AIR.sound_speed;
            let size = wavenumber * wavenumber * area / std::f64::consts::PI;
            square * flow * size / (1.0 + size) / mode.decay_rate.max(LEAST_DECAY)
        })
        .collect();
    let mut order: Vec<usize> = (0..modes.len()).collect();
    // Of equals the lower comes first.
    order.sort_by(|a, b| energies[*b].total_cmp(&energies[*a]));
    order
}
