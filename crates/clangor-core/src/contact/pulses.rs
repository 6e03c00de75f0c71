//! Converts contact rows of a timeline into force pulses: one per impact, with its action on each body.
//!
//! All points of a merged impact share one duration τ, from the mean point and normal, weighted by normal
//! impulse, the curvatures weighted likewise, and the approach speed before the first instant, the largest of
//! its points. Impulses are summed exactly: Σj and Σ (x − x_com) × j. Rows with an effective mass scale the
//! answer of both bodies to the force ([`contact_side`](super::contact_side)), by the mean of their factors,
//! weighted by normal impulse; a row without one has the factor 1.
//!
//! A body that breaks receives the whole pulse that broke it, including the part after its death. The time of
//! a fracture is known to a time step only, and the impulse has moved the body by then.
//!
//! A body that contacts cannot move (fixed, keyframed, half-space, world) has no acceleration noise, but its
//! stiffness and curvature enter the duration, and a fixed or keyframed one may vibrate. The world has no
//! material and counts as a rigid plane.

use std::collections::BTreeMap;

use glam::DVec3;

use super::ContactError;
use super::chain_onset::delay_chains;
use super::contact_forces::{ForceSettings, contact_forces, recorded_contact_forces};
use super::contact_points::{contact_points, joined, spread};
use super::contact_side::{ContactSide, inverse_effective_mass, inverse_mass};
use super::hertz::HertzRange;
use super::impact::{ContactPoint, Impact};
use super::impact_pulse::ImpactPulse;
use super::impact_solver::{ImpactSolver, SolveReport};
use super::modal_energy::{ModesOf, no_modes};
use super::pose_history::PoseHistory;
use super::recorded_forces::RecordedForces;
use super::row_checks::check_row;
use super::touching::{Spread, Touch, touching};
use crate::body::{Body, BodyId};
use crate::material::PairCoefficients;
use crate::timeline::{ContactKind, ContactRow, ForceRow};

/// Settings of the conversion of impacts into forces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactSettings {
    /// Approach speed below which impacts are silent [m/s]; \[PAN\] §4.3 uses 5 cm/s.
    pub v_min: f64,
    /// How impacts become forces.
    pub forces: ForceSettings,
    /// Whether impacts take time to travel along chains ([`chain_onset`](super::chain_onset)).
    pub chain_onset: bool,
}

impl Default for ContactSettings {
    fn default() -> Self {
        ContactSettings { v_min: 0.05, forces: ForceSettings::default(), chain_onset: true }
    }
}

/// Counts of impacts by outcome.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContactReport {
    /// Impacts converted into pulses.
    pub pulses: u64,
    /// Impacts slower than v_min.
    pub slow: u64,
    /// Impacts without a normal impulse.
    pub without_impulse: u64,
    /// Impacts between bodies that cannot move.
    pub immovable: u64,
    /// Pulses whose contact Hertz's theory does not cover ([`HertzRange`]).
    pub beyond_hertz: u64,
    /// Pulses whose onset a chain delayed.
    pub delayed: u64,
    /// How the forces came about.
    pub solves: SolveReport,
    /// The counts for each body.
    pub bodies: Vec<BodyContacts>,
}

/// Counts of the impacts of one body by outcome.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyContacts {
    /// Impacts converted into pulses.
    pub pulses: u64,
    /// Impacts slower than v_min.
    pub slow: u64,
    /// Impacts without a normal impulse.
    pub without_impulse: u64,
    /// Pulses shorter than the body's elastic transit time.
    pub shorter_than_transit: u64,
    /// Smallest τ c_R / L; infinite without pulses.
    pub smallest_transit_ratio: f64,
}

impl Default for BodyContacts {
    fn default() -> Self {
        BodyContacts {
            pulses: 0,
            slow: 0,
            without_impulse: 0,
            shorter_than_transit: 0,
            smallest_transit_ratio: f64::INFINITY,
        }
    }
}

/// The bodies of a timeline, where they are, and how they vibrate.
#[derive(Clone, Copy)]
pub struct StruckBodies<'a> {
    /// The bodies.
    pub bodies: &'a [Body],
    /// Their poses.
    pub poses: &'a PoseHistory,
    /// Their modes, which bound the forces on them.
    pub modes: ModesOf<'a>,
    /// Forces of impacts that need no solve; rows of unknown impacts are not used.
    pub forces: &'a [ForceRow],
}

impl<'a> StruckBodies<'a> {
    /// Bodies without modes and recorded forces.
    pub fn rigid(bodies: &'a [Body], poses: &'a PoseHistory) -> Self {
        StruckBodies { bodies, poses, modes: &no_modes, forces: &[] }
    }
}

/// Converts the impacts among `rows` into pulses on bodies without modes: see [`impact_pulses_on`].
///
/// # Errors
/// Those of [`impact_pulses_on`].
pub fn impact_pulses(
    bodies: &[Body],
    rows: &[ContactRow],
    poses: &PoseHistory,
    settings: &ContactSettings,
) -> Result<(Vec<ImpactPulse>, ContactReport), ContactError> {
    impact_pulses_on(StruckBodies::rigid(bodies, poses), rows, settings)
}

/// Converts the impacts among `rows` into pulses, in order of time. Rows of other kinds are skipped;
/// [`crack_pulses`](fn@super::crack_pulses::crack_pulses) converts those of cracks.
///
/// `rows` hold whole impacts in order of time: rows with the same impact id, or single rows of kind
/// [`ContactKind::Impact`] with id 0.
///
/// # Errors
/// Unknown bodies, numbers that are not finite, bodies without mass or stiffness, recorded forces that
/// cannot be any.
pub fn impact_pulses_on(
    struck: StruckBodies<'_>,
    rows: &[ContactRow],
    settings: &ContactSettings,
) -> Result<(Vec<ImpactPulse>, ContactReport), ContactError> {
    let bodies = struck.bodies;
    let mut report =
        ContactReport { bodies: vec![BodyContacts::default(); bodies.len()], ..Default::default() };
    let (mut pulses, mut impact_count) = (Vec::new(), 0);
    let mut solver = ImpactSolver::default();
    let recorded = RecordedForces::new(struck.forces)?;
    for impact in whole_impacts(rows) {
        for row in &impact {
            check_row(bodies, row)?;
        }
        let outcome = pulse(struck, &impact, &recorded, settings, &mut solver)?;
        for id in [impact[0].body_a, impact[0].body_b] {
            if let Some(counts) = report.bodies.get_mut(id.index()) {
                count(counts, &outcome, id);
            }
        }
        match outcome {
            Ok(shares) => {
                impact_count += 1;
                pulses.extend(shares);
            }
            Err(Silence::Slow) => report.slow += 1,
            Err(Silence::WithoutImpulse) => report.without_impulse += 1,
            Err(Silence::Immovable) => report.immovable += 1,
        }
    }
    pulses.sort_by(|a, b| a.time.total_cmp(&b.time));
    report.pulses = impact_count;
    report.solves = solver.report();
    report.beyond_hertz = pulses.iter().filter(|pulse| pulse.range != HertzRange::Within).count() as u64;
    if settings.chain_onset {
        report.delayed = delay_chains(&mut pulses);
    }
    Ok((pulses, report))
}

/// Length of the mean normal below which the impulses of an impact cancel.
const LEAST_MEAN_NORMAL: f64 = 1e-3;

/// Reason for which an impact is silent.
#[derive(Clone, Copy, Debug)]
enum Silence {
    Slow,
    WithoutImpulse,
    Immovable,
}

/// Counts an impact for one of its bodies.
fn count(counts: &mut BodyContacts, outcome: &Result<Vec<ImpactPulse>, Silence>, body: BodyId) {
    match outcome {
        Ok(pulses) => {
            counts.pulses += 1;
            let mut shares = pulses.iter().flat_map(|pulse| pulse.bodies.iter().flatten());
            if let Some(share) = shares.find(|share| share.body == body) {
                counts.shorter_than_transit += u64::from(share.transit_ratio < 1.0);
                counts.smallest_transit_ratio = counts.smallest_transit_ratio.min(share.transit_ratio);
            }
        }
        Err(Silence::Slow) => counts.slow += 1,
        Err(Silence::WithoutImpulse) => counts.without_impulse += 1,
        Err(Silence::Immovable) => {}
    }
}

/// Groups rows by impact, in order of each impact's first row.
pub(super) fn whole_impacts(rows: &[ContactRow]) -> Vec<Vec<ContactRow>> {
    let mut impacts: Vec<Vec<ContactRow>> = Vec::new();
    let mut place: BTreeMap<u64, usize> = BTreeMap::new();
    for row in rows {
        match (row.kind, row.impact_id) {
            (ContactKind::Fracture, _) => {}
            (ContactKind::Impact, 0) => impacts.push(vec![*row]),
            (_, 0) => {}
            (_, id) => {
                let index = *place.entry(id).or_insert_with(|| {
                    impacts.push(Vec::new());
                    impacts.len() - 1
                });
                impacts[index].push(*row);
            }
        }
    }
    impacts
}

/// The pulse of the rows of one impact, or the reason why it is silent.
fn pulse(
    struck: StruckBodies<'_>,
    rows: &[ContactRow],
    recorded: &RecordedForces<'_>,
    settings: &ContactSettings,
    solver: &mut ImpactSolver,
) -> Result<Result<Vec<ImpactPulse>, Silence>, ContactError> {
    let StruckBodies { bodies, poses, modes, .. } = struck;
    let ids = [rows[0].body_a, rows[0].body_b];
    let pair = ids.map(|id| (id != BodyId::WORLD).then(|| &bodies[id.index()]));
    // Approach speed at the first instant; silent impacts end here.
    let time = rows.iter().map(|r| r.time).fold(f64::INFINITY, f64::min);
    let first_instant = rows.iter().filter(|r| r.time == time);
    let speed = first_instant.map(ContactRow::approach_speed).fold(0.0, f64::max);
    let is_movable = |body: &Body| inverse_mass(body) > 0.0 && body.motion.is_movable_at(time);
    if !pair.iter().flatten().any(|body| is_movable(body)) {
        return Ok(Err(Silence::Immovable));
    }
    if speed < settings.v_min || speed == 0.0 {
        return Ok(Err(Silence::Slow));
    }
    // Mean normal and mean point, weighted by normal impulse. Of impulses that cancel, as those of a couple,
    // the strongest gives the normal.
    let total: f64 = rows.iter().map(|r| r.impulse_n).sum();
    let strongest = rows.iter().max_by(|a, b| a.impulse_n.total_cmp(&b.impulse_n));
    let Some(strongest) = strongest.filter(|_| total > 0.0) else {
        return Ok(Err(Silence::WithoutImpulse));
    };
    let (point, normal) = mean_place(rows, total, strongest.normal);
    // The two sides.
    let side = |i: usize| match pair[i] {
        Some(body) => {
            let side = ContactSide::of_body(ids[i], body, poses.at(ids[i], time));
            if body.motion.is_movable_at(time) { side } else { side.immovable() }
        }
        None => ContactSide::SURROUNDINGS,
    };
    // Velocities of the contact point before the impact.
    let velocity_of = |i: usize, place: DVec3| match pair[i] {
        Some(body) if inverse_mass(body) > 0.0 || body.motion.track().is_some() => {
            poses.velocity_at(ids[i], place, time)
        }
        _ => Some(DVec3::ZERO),
    };
    let relative = |place: DVec3| velocity_of(0, place).zip(velocity_of(1, place)).map(|(a, b)| a - b);
    let sides = on_joints([0, 1].map(side), rows);
    // Their curvatures at the scale of the contact, at its strongest point.
    let one = Touch {
        surfaces: pair.map(|body| body.map(|body| &*body.surface)),
        normal,
        place: strongest.point,
        speed,
        spread: Spread::single(sides[0].bounding_radius.min(sides[1].bounding_radius)),
    };
    let (points, sides) = touched_points(rows, sides, &one, relative);
    let coefficients = match pair {
        [Some(a), Some(b)] => PairCoefficients::of(&a.material, &b.material),
        [Some(one), None] | [None, Some(one)] => PairCoefficients::of(&one.material, &one.material),
        [None, None] => return Ok(Err(Silence::Immovable)),
    };
    let impact = Impact {
        impact_id: rows[0].impact_id,
        time,
        sides,
        point,
        normal,
        speed,
        restitution: coefficients.restitution.at(speed),
        friction: coefficients.friction,
        points,
    };
    let forces = &settings.forces;
    let own = if forces.allows_histories() { recorded.of(&impact) } else { None };
    let pulses = match own {
        Some(own) => recorded_contact_forces(&impact, own, modes, forces, solver)?,
        None => contact_forces(&impact, modes, forces, solver)?,
    };
    let velocity_before = relative(fastest_place(rows, time).unwrap_or(point));
    Ok(Ok(pulses.into_iter().map(|pulse| ImpactPulse { velocity_before, ..pulse }).collect()))
}

/// Where the surfaces of an impact approach fastest at an instant \[s\]: a body that tips over has points
/// that hardly move.
fn fastest_place(rows: &[ContactRow], time: f64) -> Option<DVec3> {
    let now = rows.iter().filter(|row| row.time == time);
    now.max_by(|a, b| a.approach_speed().total_cmp(&b.approach_speed())).map(|row| row.point)
}

/// The sides with the factor of their joints that the effective masses of the rows give. Some row pushes.
fn on_joints(sides: [ContactSide; 2], rows: &[ContactRow]) -> [ContactSide; 2] {
    if rows.iter().all(|row| row.effective_mass.is_none()) {
        return sides;
    }
    let own = |row: &ContactRow| inverse_effective_mass(&sides, row.point, row.normal);
    let factor = |row: &ContactRow| row.effective_mass.map_or(1.0, |mass| 1.0 / (mass * own(row)));
    let pushes = || rows.iter().filter(|row| row.impulse_n > 0.0);
    let total: f64 = pushes().map(|row| row.impulse_n).sum();
    let joint_factor = pushes().map(|row| row.impulse_n / total * factor(row)).sum();
    sides.map(|side| ContactSide { joint_factor, ..side })
}

/// Mean point and normal of rows with this sum of normal impulses, weighted by them; `strongest` is the
/// normal where they cancel.
fn mean_place(rows: &[ContactRow], total: f64, strongest: DVec3) -> (DVec3, DVec3) {
    let mean = rows.iter().map(|r| r.normal * r.impulse_n).sum::<DVec3>() / total;
    let normal = if mean.length() > LEAST_MEAN_NORMAL { mean.normalize() } else { strongest };
    (rows.iter().map(|r| r.point * (r.impulse_n / total)).sum(), normal)
}

/// The points of an impact whose sides touch at `one` place, each elastic contact once, and the sides with
/// the curvatures that they have there. `velocity_before` is that of [`contact_points`].
fn touched_points(
    rows: &[ContactRow],
    sides: [ContactSide; 2],
    one: &Touch<'_>,
    velocity_before: impl Fn(DVec3) -> Option<DVec3>,
) -> (Vec<ContactPoint>, [ContactSide; 2]) {
    let size = one.spread.reach;
    let mut touched = touching(sides, one);
    let mut points = contact_points(rows, size, velocity_before);
    if let (true, Some(approach)) = (points.len() > 1, one.largest_approach(&touched)) {
        points = joined(points, &touched, approach);
        touched = touching(sides, &Touch { spread: spread(&points, size, approach), ..*one });
    }
    (points.into_iter().map(|placed| placed.point).collect(), touched)
}
