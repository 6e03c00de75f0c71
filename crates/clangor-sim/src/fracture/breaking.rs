//! Which bodies break under the impacts of a step, and into which pieces.
//!
//! ```text
//! K u = F − reaction,    E_S = ½ uᵀF ≤ Σ ½ m V²,    largest σ₁ ≥ strength: it breaks
//! ```
//!
//! All impacts that still act load the body together. The strain energy is limited to the energy of the
//! impacts: if the static solution exceeds it, forces, stress and energy are scaled down. Cracks and the
//! motion of the pieces use only the energy that the impacts dissipated, so that the mechanical energy of all
//! bodies never grows; the rest was returned as rebound.
//!
//! Nothing is solved if no stress can reach the strength σ_c, because even a single element that held all the
//! energy would stay below it:
//!
//! ```text
//! Σ ½ m V² < V_least σ_c² (1 − 2ν²/(1 − ν))/(2 E)
//! ```
//!
//! A scratch of depth d weakens a scored body there to K/(1.12 √(π d)), K = √(E G_c/(1 − ν²)) (Griffith,
//! Irwin).
//!
//! Source: \[FRAC\] §3. Differs: its load is j/Δt (`Load::Step`, which takes any energy), and its E_S has no
//! bound.

use std::collections::{BTreeMap, BTreeSet};

use clangor_bake::mesh::tetrahedra::TetMesh;
use clangor_bake::stress::{PointLoad, StressBody, StressOptions, SymmetricTensor};
use clangor_core::body::{Body, BodyId, World};
use clangor_core::scene::breaking::{Breaking, Load, Score};
use clangor_core::timeline::ContactKind;
use glam::DVec3;

use super::contact_loads::{ContactLoad, contact_load_on, pair_pulse};
use super::error::FractureError;
use super::family::Family;
use super::fragments::{Broken, Fragments, Parent, fragments};
use super::pattern::PatternSettings;
use super::piece::Piece;
use super::shatter::{shatter, shatter_along};
use crate::rigid::{Replacement, RigidWorld, StepLog};
use crate::{BreakingReport, SimulationError};

/// A body that may break.
#[derive(Clone, Debug)]
pub struct Breakable {
    /// The body.
    pub body: BodyId,
    /// Its tetrahedra, about its centre of mass, in its axes.
    pub mesh: TetMesh,
    /// Settings of the scene.
    pub breaking: Breaking,
    /// Seed of its cracks.
    pub seed: u64,
}

/// The bodies of a world that may break, and their pieces.
pub struct BreakingBodies {
    /// All bodies in the order of their ids, in their initial states.
    bodies: Vec<Body>,
    fragile: BTreeMap<BodyId, Fragile>,
    families: Vec<Family>,
    v_min: f64,
    time_step: f64,
    report: BreakingReport,
}

/// A body that may break.
struct Fragile {
    family: usize,
    piece: Piece,
    /// Its centre of mass in the frame of `piece` \[m\].
    centre: DVec3,
    least_volume: f64,
    stress: Option<StressBody>,
    contact_loads: Vec<ContactLoad>,
    seed: u64,
}

impl BreakingBodies {
    /// Prepares the breakable bodies of a world; impacts slower than `v_min` \[m/s\] are ignored.
    ///
    /// # Errors
    /// [`SimulationError::Fracture`] for a body that cannot break: its material has no strength or toughness,
    /// or its tetrahedra are not a valid body.
    pub fn new(
        world: &World,
        breakables: Vec<Breakable>,
        v_min: f64,
        time_step: f64,
    ) -> Result<Self, SimulationError> {
        let mut all = BreakingBodies {
            bodies: world.bodies.clone(),
            fragile: BTreeMap::new(),
            families: Vec::new(),
            v_min,
            time_step,
            report: BreakingReport::default(),
        };
        for breakable in breakables {
            let Some(body) = world.bodies.get(breakable.body.index()) else { continue };
            let refuse = |source| SimulationError::Fracture { body: body.name.clone(), source };
            let family = Family::of(body, breakable.breaking).map_err(refuse)?;
            let piece = Piece::whole(&breakable.mesh).map_err(refuse)?;
            let fragile = Fragile::new(all.families.len(), piece, breakable.seed).map_err(refuse)?;
            all.families.push(family);
            all.fragile.insert(breakable.body, fragile);
        }
        Ok(all)
    }

    /// Outcomes of the impacts so far.
    pub fn report(&self) -> &BreakingReport {
        &self.report
    }

    /// Inspects a completed step. Returns the bodies that break, and their pieces.
    ///
    /// # Errors
    /// [`SimulationError::Fracture`] for numbers that are not finite.
    pub fn look(&mut self, rigid: &RigidWorld, log: &StepLog) -> Result<Vec<Replacement>, SimulationError> {
        let loaded = self.take_contact_loads(log)?;
        let mut replacements = Vec::new();
        for id in loaded {
            let next = BodyId((rigid.count() + self.pending(&replacements)) as u32);
            if let Some(replacement) = self.fracture_of(id, next, rigid) {
                replacements.push(replacement);
            }
        }
        Ok(replacements)
    }

    /// Number of pieces that are not in the world yet.
    fn pending(&self, replacements: &[Replacement]) -> usize {
        replacements.iter().map(|r| r.pieces.len()).sum()
    }

    /// Adds the loads of a step's impacts to the breakable bodies. Returns the loaded bodies.
    fn take_contact_loads(&mut self, log: &StepLog) -> Result<BTreeSet<BodyId>, SimulationError> {
        let mut loaded = BTreeSet::new();
        for (kind, rows, poses) in log.groups() {
            let Some(first) = rows.first() else { continue };
            let ids = [first.body_a, first.body_b];
            let felt = matches!(kind, ContactKind::Impact | ContactKind::Contact)
                && ids.iter().any(|id| self.fragile.contains_key(id));
            if !felt || rows.iter().all(|r| r.approach_speed() < self.v_min) {
                continue;
            }
            let pair = ids.map(|id| self.bodies.get(id.index()));
            let name = || pair.iter().flatten().next().map_or_else(String::new, |load| load.name.clone());
            let refuse = |source| SimulationError::Fracture {
                body: name(),
                source: FractureError::ContactLoad(source),
            };
            let Some(pulse) = pair_pulse(pair, rows, poses, self.v_min).map_err(refuse)? else { continue };
            for id in ids {
                let Some(fragile) = self.fragile.get_mut(&id) else { continue };
                let model = self.families[fragile.family].breaking.load;
                if let Some(load) = contact_load_on(id, &pulse, rows, pair, model, self.time_step) {
                    // Removes the loads that ended before this impact began.
                    fragile.contact_loads.retain(|earlier| earlier.end > pulse.time);
                    fragile.contact_loads.push(load);
                    loaded.insert(id);
                }
            }
        }
        Ok(loaded)
    }

    /// The pieces of a body if its loads break it; pieces get ids from `next` on.
    fn fracture_of(&mut self, id: BodyId, next: BodyId, rigid: &RigidWorld) -> Option<Replacement> {
        let fragile = self.fragile.get_mut(&id)?;
        let family = &mut self.families[fragile.family];
        let body = &self.bodies[id.index()];
        let energy: f64 = fragile.contact_loads.iter().map(|load| load.energy).sum();
        let unbounded = family.breaking.load == Load::Step;
        if !unbounded && energy < fragile.least_volume * family.critical_density {
            self.report.screened += 1;
            return None;
        }
        self.report.solved += 1;
        let outcome = fragile.break_up(family, energy, &mut self.report).and_then(|broken| {
            let Some(broken) = broken else { return Ok(None) };
            let parent = Parent { body, state: rigid.pose(id), centre: fragile.centre };
            let name = |k| format!("{}-piece-{}", family.name, family.born + k + 1);
            fragments(&parent, broken, family.breaking.crack_impulses, name).map(Some)
        });
        let Fragments { replacement, pieces } = match outcome {
            Ok(Some(found)) => found,
            Ok(None) => return None,
            Err(error) => {
                self.report.refused.entry(body.name.clone()).or_insert_with(|| error.to_string());
                return None;
            }
        };
        let count = pieces.len();
        let (number, seed) = (fragile.family, fragile.seed);
        let mut fragile_pieces = Vec::with_capacity(count);
        for (k, piece) in pieces.into_iter().enumerate() {
            match Fragile::new(number, piece, child_seed(seed, k)) {
                Ok(piece) => fragile_pieces.push(piece),
                Err(error) => {
                    self.report.refused.entry(body.name.clone()).or_insert_with(|| error.to_string());
                    return None;
                }
            }
        }
        family.pieces += count - 1;
        family.born += count;
        self.fragile.remove(&id);
        for (k, piece) in fragile_pieces.into_iter().enumerate() {
            self.fragile.insert(BodyId(next.0 + k as u32), piece);
        }
        // Ids and this list both follow the order of births.
        self.bodies.extend(replacement.pieces.iter().cloned());
        Some(replacement)
    }
}

impl Fragile {
    fn new(family: usize, piece: Piece, seed: u64) -> Result<Self, FractureError> {
        let volume = |e: usize| {
            let [a, b, c, d, ..] = piece.mesh.positions(e);
            (b - a).cross(c - a).dot(d - a) / 6.0
        };
        let least_volume = (0..piece.mesh.elements.len()).map(volume).fold(f64::INFINITY, f64::min);
        let centre = piece.mass_properties()?.centre_of_mass;
        Ok(Fragile { family, piece, centre, least_volume, stress: None, contact_loads: Vec::new(), seed })
    }

    /// The pieces of this body under its loads, whose impacts carry `energy` \[J\]; `None` if it stays whole.
    fn break_up(
        &mut self,
        family: &Family,
        energy: f64,
        report: &mut BreakingReport,
    ) -> Result<Option<Broken>, FractureError> {
        let stress = match &mut self.stress {
            Some(stress) => stress,
            empty => {
                let options =
                    StressOptions { reaction: family.breaking.reaction, ..StressOptions::default() };
                empty.insert(StressBody::new(self.piece.mesh.clone(), &family.constants, &options)?)
            }
        };
        // Elastostatic solution under all present loads, limited to the energy of the impacts.
        let forces = self.contact_loads.iter().flat_map(|load| &load.forces);
        let loads: Vec<PointLoad> =
            forces.map(|(point, force)| PointLoad { point: *point + self.centre, force: *force }).collect();
        // The energy limit can only reduce forces and stress, so a body that withstands the full loads stays
        // whole.
        if stress.tension_above(&loads, family.least_strength())?.is_none() {
            return Ok(None);
        }
        let mut deformation = stress.solve(&loads)?;
        if family.breaking.load == Load::HalfSinePeak && deformation.strain_energy > energy {
            let factor = (energy / deformation.strain_energy).sqrt();
            deformation = deformation.scaled(factor);
        }
        // Largest ratio of stress to strength.
        let scores = &family.breaking.scores;
        let utilisation = match scores.is_empty() {
            true => deformation.maximum_tension().stress / family.strength,
            false => across_scores(&self.piece.mesh, &deformation.element_stress, scores, family),
        };
        if utilisation < 1.0 {
            return Ok(None);
        }
        let room = family.breaking.most_pieces.saturating_sub(family.pieces - 1);
        if room < 2 {
            report.capped += 1;
            return Ok(None);
        }
        // Cracks may use the dissipated energy only.
        let lost: f64 = self.contact_loads.iter().map(|load| load.loss).sum();
        let strain = match family.breaking.load {
            Load::HalfSinePeak => deformation.strain_energy.min(lost),
            Load::Step => deformation.strain_energy,
        };
        let settings = PatternSettings {
            most_pieces: room,
            smallest_piece: family.smallest_piece,
            ..PatternSettings::new(family.fracture_energy, 0.0, self.seed)
        };
        let shatter = match scores.is_empty() {
            true => shatter(&self.piece, &deformation.corner_energy_density, strain, &settings)?,
            false => shatter_along(&self.piece, scores, strain, &settings)?,
        };
        if shatter.is_none() {
            report.withstood += 1;
        }
        Ok(shatter.map(|shatter| Broken {
            shatter,
            stress: deformation.element_stress,
            impact_energy: energy,
            seed: self.seed,
        }))
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

/// Seed of a piece.
fn child_seed(parent: u64, piece: usize) -> u64 {
    (parent ^ (piece as u64 + 1)).wrapping_mul(0x9E37_79B9_7F4A_7C15).rotate_left(31)
}
