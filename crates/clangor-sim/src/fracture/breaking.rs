//! Which bodies break under the impacts of a step, and into which pieces.
//!
//! ```text
//! impacts ─► contact_loads: F(t), U(t) ─► breaking_instant: stress, energy ─► shatter ─► pieces
//! ```
//!
//! All impacts that still act load a body together. When it breaks, and with which energy, decides
//! `breaking_instant`. Cracks and the motion of the pieces use only energy that motion lost in the impacts,
//! so that the mechanical energy of all bodies never grows; the rest was returned as rebound.
//!
//! Nothing is solved if no stress can reach the strength σ_c, because even a single element that held all the
//! energy would stay below it:
//!
//! ```text
//! Σ ½ m V² < V_least σ_c² (1 − 2ν²/(1 − ν))/(2 E)
//! ```
//!
//! Source: \[FRAC\] §3. Differs: its load is j/Δt (`Load::Step`, which takes any energy), and its E_S has no
//! bound.

use std::collections::{BTreeMap, BTreeSet};

use clangor_bake::mesh::tetrahedra::TetMesh;
use clangor_bake::stress::{Deformation, StressBody, StressOptions};
use clangor_core::body::{Body, BodyId, World};
use clangor_core::contact::{GroupSolver, LoadHistory};
use clangor_core::scene::breaking::{Breaking, Load};
use clangor_core::timeline::ContactKind;
use glam::DVec3;

use super::breaking_instant::{BreakingSearch, Strained, instants, most_stored};
use super::contact_loads::{ContactLoad, PairImpact, half_sine_peak};
use super::error::FractureError;
use super::family::Family;
use super::fragments::{Broken, Fragments, Parent, fragments};
use super::pair_history::pair_histories;
use super::pattern::PatternSettings;
use super::piece::Piece;
use super::shatter::{Shatter, shatter, shatter_along};
use super::spent_energy::SpentEnergy;
use crate::rigid::{CutShort, PairImpulses, Replacement, RigidWorld, StepLog};
use crate::{BreakingReport, ContactModel, SimulationError, SimulationSettings};

/// Growth of the energy after which cracks that were too dear are tried again.
const MORE_ENERGY: f64 = 1.05;

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
    /// Impacts so far, and what cracks took of their energy.
    impacts: u64,
    spent: SpentEnergy,
    solver: GroupSolver,
    report: BreakingReport,
}

/// A body that may break.
struct Fragile {
    family: usize,
    piece: Piece,
    /// Its centre of mass in the frame of `piece` \[m\].
    centre: DVec3,
    least_volume: f64,
    /// Largest extent about its centre of mass \[m\].
    extent: f64,
    stress: Option<StressBody>,
    contact_loads: Vec<ContactLoad>,
    /// Onset of the first load since its stress was looked at \[s\].
    fresh: f64,
    seed: u64,
}

impl BreakingBodies {
    /// Prepares the breakable bodies of a world. Impacts slower than the `v_min` of the record are ignored;
    /// if bodies do not give way in impacts, `Load::History` is the peak of a half-sine.
    ///
    /// # Errors
    /// [`SimulationError::Fracture`] for a body that cannot break: its material has no strength or toughness,
    /// or its tetrahedra are not a valid body.
    pub fn new(
        world: &World,
        breakables: Vec<Breakable>,
        settings: &SimulationSettings,
    ) -> Result<Self, SimulationError> {
        let mut all = BreakingBodies {
            bodies: world.bodies.clone(),
            fragile: BTreeMap::new(),
            families: Vec::new(),
            v_min: settings.record.v_min,
            time_step: settings.time_step,
            impacts: 0,
            spent: SpentEnergy::default(),
            solver: GroupSolver::default(),
            report: BreakingReport::default(),
        };
        for breakable in breakables {
            let Some(body) = world.bodies.get(breakable.body.index()) else { continue };
            let refuse = |source| SimulationError::Fracture { body: body.name.clone(), source };
            let mut breaking = breakable.breaking;
            if settings.contact == ContactModel::Rigid && breaking.load == Load::History {
                breaking.load = Load::HalfSinePeak;
            }
            let family = Family::of(body, breaking).map_err(refuse)?;
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

    /// Inspects a completed step. Returns the bodies that break, and their pieces, and takes back what acts
    /// on bodies after they have broken.
    ///
    /// # Errors
    /// [`SimulationError::Fracture`] for numbers that are not finite.
    pub fn look(
        &mut self,
        rigid: &mut RigidWorld,
        log: &mut StepLog,
    ) -> Result<Vec<Replacement>, SimulationError> {
        let loaded = self.take_contact_loads(log)?;
        let mut replacements = Vec::new();
        for id in loaded {
            let next = BodyId((rigid.count() + self.pending(&replacements)) as u32);
            if let Some(replacement) = self.fracture_of(id, next, (rigid, log)) {
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
        let first = self.impacts;
        for load in log.loads() {
            self.impacts = self.impacts.max(first + load.solve as u64 + 1);
            let id = load.state.body;
            if self.load_of(id) == Some(Load::History) {
                self.add_load(id, ContactLoad::of_solved(load, first + load.solve as u64), &mut loaded);
            }
        }
        for PairImpulses { kind, rows, poses, solved } in log.groups() {
            let Some(row) = rows.first() else { continue };
            let ids = [row.body_a, row.body_b];
            // What solved impacts do over time is known already.
            let felt = |id: &BodyId| self.load_of(*id).is_some_and(|load| !solved || load != Load::History);
            if !matches!(kind, ContactKind::Impact | ContactKind::Contact)
                || !ids.iter().any(felt)
                || rows.iter().all(|r| r.approach_speed() < self.v_min)
            {
                continue;
            }
            let number = self.impacts;
            self.impacts += 1;
            let loads = self.pair_loads(PairImpulses { kind, rows, poses, solved }, number)?;
            for (id, load) in loads {
                self.add_load(id, load, &mut loaded);
            }
        }
        Ok(loaded)
    }

    /// How impacts load a body that may break.
    fn load_of(&self, id: BodyId) -> Option<Load> {
        self.fragile.get(&id).map(|fragile| self.families[fragile.family].breaking.load)
    }

    /// The loads of an impact on those of its two bodies that may break.
    fn pair_loads(
        &mut self,
        impulses: PairImpulses<'_>,
        number: u64,
    ) -> Result<Vec<(BodyId, ContactLoad)>, SimulationError> {
        let PairImpulses { rows, poses, solved, .. } = impulses;
        let ids = [rows[0].body_a, rows[0].body_b];
        let bodies = ids.map(|id| self.bodies.get(id.index()));
        let impact = PairImpact { bodies, rows, poses, number };
        let refuse = |source| SimulationError::Fracture {
            body: bodies.iter().flatten().next().map_or_else(String::new, |body| body.name.clone()),
            source: FractureError::ContactLoad(source),
        };
        let Some(pulse) = impact.pulse(self.v_min).map_err(refuse)? else { return Ok(Vec::new()) };
        let models = ids.map(|id| self.load_of(id).filter(|load| !solved || *load != Load::History));
        let mut histories: [Option<LoadHistory>; 2] = [None, None];
        if models.contains(&Some(Load::History)) {
            match pair_histories(&impact, &pulse, &mut self.solver) {
                Some(both) => histories = both.map(Some),
                None => self.report.unsolved += 1,
            }
        }
        let mut loads = Vec::new();
        for ((id, model), history) in ids.into_iter().zip(models).zip(histories) {
            let (history, per_impulse) = match model {
                Some(Load::History) => (history, half_sine_peak(&pulse)),
                Some(Load::HalfSinePeak) => (None, half_sine_peak(&pulse)),
                Some(Load::Step) => (None, 1.0 / self.time_step),
                None => continue,
            };
            loads.extend(impact.load_on(id, &pulse, history, per_impulse).map(|load| (id, load)));
        }
        Ok(loads)
    }

    /// Adds a load to a body that may break.
    fn add_load(&mut self, id: BodyId, load: ContactLoad, loaded: &mut BTreeSet<BodyId>) {
        let Some(fragile) = self.fragile.get_mut(&id) else { return };
        let onset = load.onset;
        fragile.fresh = if loaded.insert(id) { onset } else { fragile.fresh.min(onset) };
        // Removes the loads that ended before this impact began.
        fragile.contact_loads.retain(|earlier| earlier.end > onset);
        fragile.contact_loads.push(load);
    }

    /// The pieces of a body if its loads break it; pieces get ids from `next` on.
    fn fracture_of(
        &mut self,
        id: BodyId,
        next: BodyId,
        (rigid, log): (&mut RigidWorld, &mut StepLog),
    ) -> Option<Replacement> {
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
        self.spent.forget_before(fragile.fresh);
        let step = LoadedStep { body: id, rigid, log };
        let outcome = fragile.break_up(family, (&step, &self.spent), &mut self.report).and_then(|found| {
            let Some((broken, cut)) = found else { return Ok(None) };
            let lost = cut.short.lost_motion(rigid, log);
            cut.short.apply(rigid, log);
            let parent = Parent { body, state: rigid.pose(id), centre: fragile.centre };
            let name = |k| format!("{}-piece-{}", family.name, family.born + k + 1);
            let fragments = fragments(&parent, broken, family.breaking.crack_impulses, name)?;
            Ok(Some((fragments, cut.time, lost)))
        });
        let (Fragments { replacement, pieces }, cut_time, lost) = match outcome {
            Ok(Some(found)) => found,
            Ok(None) => return None,
            Err(error) => {
                self.report.refused.entry(body.name.clone()).or_insert_with(|| error.to_string());
                return None;
            }
        };
        if family.breaking.load == Load::History {
            self.spent.take(replacement.row.strain_energy - lost, &fragile.contact_loads);
        }
        let ended: BTreeSet<u64> = fragile.contact_loads.iter().map(|load| load.impact).collect();
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
        // The others feel nothing more of its impacts either.
        let others = self.fragile.values_mut().flat_map(|fragile| &mut fragile.contact_loads);
        others.filter(|load| ended.contains(&load.impact)).for_each(|load| load.end_at(cut_time));
        // A scored body has broken along all its scores at once; its pieces have none.
        let again = self.families[number].breaking.scores.is_empty();
        for (k, piece) in fragile_pieces.into_iter().enumerate().filter(|_| again) {
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
        let reach = piece.mesh.nodes.iter().map(|node| node.distance(centre)).fold(0.0, f64::max);
        Ok(Fragile {
            family,
            piece,
            centre,
            least_volume,
            extent: 2.0 * reach,
            stress: None,
            contact_loads: Vec::new(),
            fresh: 0.0,
            seed,
        })
    }

    /// The pieces of this body under its loads; `None` if it stays whole.
    fn break_up(
        &mut self,
        family: &Family,
        (step, spent): (&LoadedStep<'_>, &SpentEnergy),
        report: &mut BreakingReport,
    ) -> Result<Option<(Broken, Cut)>, FractureError> {
        let stress = match &mut self.stress {
            Some(stress) => stress,
            empty => {
                let options =
                    StressOptions { reaction: family.breaking.reaction, ..StressOptions::default() };
                empty.insert(StressBody::new(self.piece.mesh.clone(), &family.constants, &options)?)
            }
        };
        let loads = &self.contact_loads;
        let energy = Energy {
            model: family.breaking.load,
            lost: loads.iter().map(|load| load.heat).sum(),
            available: spent.available(loads),
            crack_time: self.extent / family.crack_speed,
        };
        let room = family.breaking.most_pieces.saturating_sub(family.pieces - 1);
        let settings = PatternSettings {
            most_pieces: room,
            smallest_piece: family.smallest_piece,
            ..PatternSettings::new(family.fracture_energy, 0.0, self.seed)
        };
        let mut search = BreakingSearch::new(stress, family, loads, (self.centre, self.least_volume));
        let (mut before, mut tried) = (None, None);
        for time in instants(loads, self.fresh) {
            let earlier = before.replace(time);
            let Some(strained) = search.reached(time, earlier)? else { continue };
            if room < 2 {
                report.capped += 1;
                return Ok(None);
            }
            let enough = |energy: f64| tried.is_none_or(|tried| energy > MORE_ENERGY * tried);
            let (time, most) = energy.most_at(loads, &strained);
            if !enough(most) {
                continue;
            }
            let (cut, strain) = energy.for_cracks(loads, (time, most), step);
            if !enough(strain) {
                continue;
            }
            tried = Some(strain);
            let Some(deformation) = search.deformation(&strained)? else { continue };
            let Some(shatter) = pieces(&self.piece, family, &deformation, strain, &settings)? else {
                continue;
            };
            let impact_energy = loads.iter().map(|load| load.energy).sum();
            let stress = deformation.element_stress;
            return Ok(Some((Broken { shatter, stress, impact_energy, seed: self.seed }, cut)));
        }
        report.withstood += u64::from(tried.is_some());
        Ok(None)
    }
}

/// Energies of the loads of a body, and how long cracks take.
struct Energy {
    model: Load,
    /// What motion lost in contacts \[J\].
    lost: f64,
    /// What is left for cracks of that and of the vibration \[J\].
    available: f64,
    /// Time in which a crack crosses the body \[s\].
    crack_time: f64,
}

/// A step in which a body is loaded.
struct LoadedStep<'a> {
    body: BodyId,
    rigid: &'a RigidWorld,
    log: &'a StepLog,
}

/// When a body falls apart \[s\], and what it does not feel after that.
struct Cut {
    time: f64,
    short: CutShort,
}

impl Energy {
    /// When a body that breaks at an instant falls apart \[s\], and the most energy that is left for cracks
    /// and the motion of the pieces \[J\].
    fn most_at(&self, loads: &[ContactLoad], strained: &Strained) -> (f64, f64) {
        match self.model {
            Load::History => most_stored(loads, strained.time, self.crack_time),
            Load::HalfSinePeak => (strained.time, strained.strain_energy.min(self.lost)),
            Load::Step => (strained.time, strained.strain_energy),
        }
    }

    /// What a body that falls apart at a time \[s\] does not feel after it, and the energy for cracks and the
    /// motion of the pieces: at most `most` \[J\].
    fn for_cracks(
        &self,
        loads: &[ContactLoad],
        (time, most): (f64, f64),
        step: &LoadedStep<'_>,
    ) -> (Cut, f64) {
        if self.model != Load::History {
            return (Cut { time, short: CutShort::default() }, most);
        }
        let shares = loads.iter().flat_map(|load| load.cut_at(time, step.body, step.log));
        let short = CutShort { shares: shares.collect() };
        let lost = (self.available + short.lost_motion(step.rigid, step.log)).max(0.0);
        (Cut { time, short }, most.min(lost))
    }
}

/// The pieces of a body that breaks with an energy \[J\]; `None` if it is too small.
fn pieces(
    piece: &Piece,
    family: &Family,
    deformation: &Deformation,
    energy: f64,
    settings: &PatternSettings,
) -> Result<Option<Shatter>, FractureError> {
    match family.breaking.scores.is_empty() {
        true => shatter(piece, &deformation.corner_energy_density, energy, settings),
        false => shatter_along(piece, &family.breaking.scores, energy, settings),
    }
}

/// Seed of a piece.
fn child_seed(parent: u64, piece: usize) -> u64 {
    (parent ^ (piece as u64 + 1)).wrapping_mul(0x9E37_79B9_7F4A_7C15).rotate_left(31)
}
