//! Bodies that break hand their vibration to their pieces:
//! [`clangor_core::synthesis::modal::modal_state_transfer`] for those of a timeline.
//!
//! What the cracks took, and the kick that they gave to the pieces, came from what the breaking impacts took
//! of the motion, E₀ ([`ImpactPulse::energy_lost`]), of which modes have no more than the rest,
//!
//! ```text
//! E_impact ≤ E₀ − G_c A − ΔE_K
//! ```
//!
//! What the body vibrated with before those impacts is not touched.

use std::collections::BTreeMap;

use clangor_core::body::{Body, BodyId, Surface};
use clangor_core::contact::{ImpactPulse, PoseHistory};
use clangor_core::synthesis::modal::ModalState;
use clangor_core::synthesis::modal::modal_state_transfer::{
    Handed, SurfaceSample, bound_energy, handed_over, sample_count,
};
use clangor_core::timeline::FractureRow;
use rayon::prelude::*;

use super::struck_source::StruckSource;

/// Impacts within this time before a body breaks are those that break it \[s\].
const BREAKING: f64 = 1e-3;

/// What became of the vibration of a body that broke.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ModalStateTransfer {
    /// Energy of its modes, less what the cracks took of the breaking impact \[J\].
    pub had: f64,
    /// What its pieces vibrate with \[J\].
    pub handed: f64,
}

/// What breaks, and where everything is.
#[derive(Clone, Copy)]
pub(super) struct Breaking<'a> {
    pub(super) fractures: &'a [FractureRow],
    pub(super) poses: &'a PoseHistory,
}

/// Gives the pieces of all that breaks what they take over.
pub(super) fn transfer_modal_state(
    bodies: &[Body],
    struck: &mut [StruckSource],
    pulses: &[ImpactPulse],
    Breaking { fractures, poses }: Breaking<'_>,
) -> BTreeMap<BodyId, ModalStateTransfer> {
    let mut done = BTreeMap::new();
    for fracture in fractures {
        let place = |id: BodyId| struck.binary_search_by_key(&id, |struck| struck.body).ok();
        let Some(parent) = place(fracture.parent) else { continue };
        let pieces: Vec<usize> = fracture.pieces().filter_map(place).collect();
        let parent = &struck[parent];
        let state = at_death(parent, bodies, pulses, fracture);
        let had = state.energy(&parent.source);
        if !(had > 0.0 && had.is_finite()) || pieces.is_empty() {
            continue;
        }
        let pose = |id: BodyId| poses.at(id, fracture.time);
        let parent_pose = pose(fracture.parent);
        let mut handed: Vec<Handed> = pieces
            .par_iter()
            .map(|&piece| {
                let StruckSource { body, source, .. } = &struck[piece];
                let samples = samples(&bodies[body.index()].surface, sample_count(source.resonances().len()));
                let poses = [&parent_pose, &pose(*body)];
                handed_over((&parent.source, &state), source, &samples, poses, bodies[body.index()].mass)
            })
            .collect();
        let mut bounded: Vec<_> =
            pieces.iter().map(|piece| &*struck[*piece].source).zip(&mut handed).collect();
        let given = bound_energy(&mut bounded, had);
        done.insert(fracture.parent, ModalStateTransfer { had, handed: given });
        for (piece, handed) in pieces.into_iter().zip(handed) {
            struck[piece].handed = Some(handed.state);
        }
    }
    done
}

/// What a body vibrates with when it breaks.
fn at_death(
    vibrating: &StruckSource,
    bodies: &[Body],
    pulses: &[ImpactPulse],
    fracture: &FractureRow,
) -> ModalState {
    let StruckSource { body, source, impacts, handed, .. } = vibrating;
    let death = fracture.time;
    let breaking = |pulse: &ImpactPulse| pulse.time > death - BREAKING && pulse.time <= death;
    let (last, earlier): (Vec<ImpactPulse>, Vec<ImpactPulse>) = impacts.iter().cloned().partition(breaking);
    let mut before = ModalState::after_impacts(source, *body, &earlier, death);
    if let Some(handed) = handed {
        before = before.plus(&handed.later(source, death - bodies[body.index()].life.birth), 1.0);
    }
    let impact = ModalState::after_impacts(source, *body, &last, death);
    let gained = impact.energy(source);
    let struck = |pulse: &&ImpactPulse| pulse.bodies.iter().flatten().any(|share| share.body == *body);
    let lost: f64 =
        pulses.iter().filter(|pulse| breaking(pulse)).filter(struck).map(ImpactPulse::energy_lost).sum();
    let left = lost.max(gained) - fracture.fracture_energy - fracture.kinetic_energy_gain;
    let factor = if gained > left { (left.max(0.0) / gained).sqrt() } else { 1.0 };
    before.plus(&impact, factor)
}

/// Places all over a surface, evenly by area.
fn samples(surface: &Surface, count: usize) -> Vec<SurfaceSample> {
    let Surface::Mesh(surface) = surface else { return Vec::new() };
    let mesh = &surface.mesh;
    let step = mesh.area() / count as f64;
    let (mut samples, mut passed) = (Vec::with_capacity(count), 0.0);
    for triangle in 0..mesh.triangles.len() {
        let normal = mesh.area_vector(triangle);
        let [a, b, c] = mesh.corners(triangle);
        passed += normal.length();
        while samples.len() < count && (samples.len() as f64 + 0.5) * step < passed {
            // A sequence that fills the square evenly, folded into the triangle.
            let k = samples.len() as f64;
            let [u, v] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_3].map(|part| (k * part).fract());
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            samples.push(SurfaceSample { place: a + u * (b - a) + v * (c - a), normal });
        }
    }
    samples
}
