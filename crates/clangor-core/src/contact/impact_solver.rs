//! The forces of one impact from a solve of the contact: both bodies give way, move and vibrate.
//!
//! ```text
//! sides, points, velocities ─► members, contacts ─► solve ─► F_c(t) of every point ─► shapes of the pulses
//! modes, their ringing      ─►
//! ```
//!
//! The members are the two bodies of the impact, with their modes and, per contact, a tail of modes above the
//! last known one ([`compliant`](super::compliant)). Every point has the Hertz stiffness of the impact and
//! loses energy by the restitution of the pair; a half-space also takes waves away.
//!
//! A solver is used for all impacts of a timeline in order of time. It keeps the vibration of each body from
//! impact to impact. A body that rings meets the next impact with its surface where the vibration has brought
//! it, so the gap of the rigid surfaces there is
//!
//! ```text
//! g = −Σ φ_i q_i
//! ```
//!
//! with φ > 0 for a displacement that opens the contact.
//!
//! The motion of a timeline is given: its impulses are those of rigid bodies. The forces of the solve keep
//! their shape and are scaled to the sum of the normal impulses, by s = (1 + e recorded)/(1 + e solved)
//! where the solve has the restitution e, but at most by 2 (6 dB). What is left of the impulse acts slowly
//! and with no greater force, over up to 50 ms: a thin body gives way at once, and what its waves bring back
//! stops it. Several points share the sum as the solve has it: which of them touches first, and what each
//! gets, is an accident of rigid bodies that land almost flat. Velocities of points that are no rigid motion
//! are replaced by the nearest one (`relative_motion`). The recorded friction keeps its impulse; an impact
//! without any has none in the solve.
//!
//! Not covered: more than two bodies, loads of standing contacts, gravity during the impact.

use std::sync::Arc;

use glam::DVec3;

use super::compliant::{
    ContactLaw, ContactSystem, HertzLaw, MemberContact, SolverMemory, StepSettings, restitution_damping,
};
use super::force_history::ForceHistory;
use super::hertz::HertzContact;
use super::impact::{ContactPoint, Impact};
use super::impact_pulse::ImpactPulse;
use super::modal_energy::ModesAtContact;
use super::relative_motion::rigid_velocities;
use super::slow_rest::slow_rest;
use super::vibrating_member::{RingingBodies, VibratingMember, modal_poles};

/// Factor from a solved to a recorded impulse above which the contact of the solve hardly closed: there is no
/// force whose shape could be taken.
const MOST_MISSED: f64 = 100.0;
/// Largest factor by which a solved force is raised to a recorded impulse: 6 dB.
pub const MOST_SCALE: f64 = 2.0;
/// Share of the energy of the approach in the modes above which a contact at one point is solved.
pub(super) const LEAST_MODAL_SHARE: f64 = 0.003;
/// Share below which an impact does not count for the ringing of its bodies.
const AUDIBLE_SHARE: f64 = 1e-8;
/// Time without a force after which another hit is another impact \[s\]: timelines merge what is nearer.
const LONGEST_FLIGHT: f64 = 0.5e-3;
/// Most steps of a solve.
const MAX_STEPS: usize = 16_384;

/// Counts of impacts by how their forces came about.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SolveReport {
    /// Impacts whose contact was solved.
    pub solved: u64,
    /// Impacts at one point that hardly excite modes: Hertz's pulse in closed form.
    pub closed: u64,
    /// Impacts that could not be solved: Hertz's pulse, with the modes bounded by the energy.
    pub fallen_back: u64,
    /// Impacts whose forces the timeline holds.
    pub recorded: u64,
    /// Largest factor s from a solved impulse to the recorded one; 0 without solves.
    pub largest_scale: f64,
    /// Solved impacts whose s is above 2: the rest of their impulse acts slowly.
    pub over_scaled: u64,
    /// Steps of all solves.
    pub steps: u64,
}

/// Solves the impacts of a timeline: see the module.
#[derive(Default)]
pub struct ImpactSolver {
    memory: SolverMemory,
    system: ContactSystem,
    ringing: RingingBodies,
    report: SolveReport,
}

/// The shape of the force of one contact point along one direction.
#[derive(Clone, Debug)]
pub(super) struct SolvedForce {
    /// Index among the points of the impact.
    pub(super) point: usize,
    /// Impulse [N s] and couple impulse [N m s] on A that have this shape.
    pub(super) impulse: DVec3,
    pub(super) couple: DVec3,
    pub(super) history: Arc<ForceHistory>,
    /// End of the force after the onset \[s\].
    pub(super) end: f64,
    /// Factor from the impulse to that on the modes, at most 1: 0 of the part that acts slowly.
    pub(super) modal_gain: f64,
}

/// What a solve needs besides the impact.
#[derive(Clone, Copy)]
pub(super) struct SolveInput<'a> {
    pub(super) impact: &'a Impact,
    pub(super) contact: &'a HertzContact,
    /// Modes of A and B at the points, for bodies that move.
    pub(super) modes: [Option<&'a ModesAtContact>; 2],
    /// Steps per first duration.
    pub(super) steps: f64,
    /// Highest frequency that the forces keep \[Hz\].
    pub(super) band: f64,
}

impl SolveInput<'_> {
    /// Whether the closed form of Hertz's pulse is enough: one point, and `share` of the energy of the
    /// approach in the modes, with that in an endless plate, below 0.003.
    pub(super) fn is_closed(&self, share: f64) -> bool {
        let lost = share + self.contact.plate_share(&self.impact.sides);
        self.impact.points.len() == 1 && lost < LEAST_MODAL_SHARE
    }
}

impl ImpactSolver {
    /// Counts so far.
    pub fn report(&self) -> SolveReport {
        self.report
    }

    /// Counts an impact that could not be solved.
    pub(super) fn count_fallback(&mut self) {
        self.report.fallen_back += 1;
    }

    /// Counts an impact in closed form, and adds what its modes take over from it to their ringing.
    pub(super) fn ring_closed(&mut self, input: &SolveInput<'_>, pulse: &ImpactPulse, share: f64) {
        self.report.closed += 1;
        if share < AUDIBLE_SHARE {
            return;
        }
        for (index, modes) in input.modes.iter().enumerate() {
            let (Some(modes), Some(body)) = (modes, pulse.bodies[index]) else { continue };
            let sign = if index == 0 { 1.0 } else { -1.0 };
            let points = body.local(&pulse.points, sign);
            let poles = modal_poles(modes);
            let end = pulse.time + pulse.duration;
            let mut state = self.ringing.state_at(body.body, &poles, end);
            for (i, (w, pole)) in state.iter_mut().zip(&poles).enumerate() {
                let along: f64 = points.iter().zip(&modes.motions).map(|((_, j), u)| u[i].dot(*j)).sum();
                let ring = pulse.shape.at_pole(*pole, pulse.duration) * (*pole * pulse.duration).exp();
                *w += along * body.modal_gain * ring;
            }
            self.ringing.set(body.body, end, &poles, state);
        }
    }

    /// Counts an impact with these recorded forces, and adds what they leave in the modes to their ringing.
    pub(super) fn ring_recorded(&mut self, input: &SolveInput<'_>, forces: &[SolvedForce]) {
        self.report.recorded += 1;
        let length = forces.iter().map(|force| force.end).fold(0.0, f64::max);
        let end = input.impact.time + length;
        for (index, (modes, sign)) in input.modes.iter().zip([1.0, -1.0]).enumerate() {
            let Some(modes) = modes else { continue };
            let side = &input.impact.sides[index];
            let to_body = side.pose.orientation.inverse();
            let poles = modal_poles(modes);
            let mut state = self.ringing.state_at(side.body, &poles, end);
            for force in forces {
                let impulse = to_body * force.impulse * (sign * force.modal_gain);
                let motions = &modes.motions[force.point];
                for ((w, pole), motion) in state.iter_mut().zip(&poles).zip(motions) {
                    let ring = force.history.at_pole(*pole) * (*pole * length).exp();
                    // A mode that dies out within the contact has no number here, and no part in the ringing.
                    if ring.is_finite() {
                        *w += motion.dot(impulse) * ring;
                    }
                }
            }
            self.ringing.set(side.body, end, &poles, state);
        }
    }

    /// The forces of an impact; `None` if its contact cannot be solved.
    pub(super) fn solve(&mut self, input: &SolveInput<'_>) -> Option<Vec<SolvedForce>> {
        let SolveInput { impact, steps, band, .. } = *input;
        // Members: the two bodies, with the vibration that they bring along.
        let normals: Vec<(DVec3, f64)> =
            impact.points.iter().map(|point| (point.normal, input.contact.duration())).collect();
        let bodies = [0, 1].map(|side| {
            let ringing = (&self.ringing, impact.time);
            VibratingMember::new(&impact.sides[side], input.modes[side], &normals, ringing)
        });
        let members = bodies.each_ref().map(|body| body.member.clone());
        let velocities = rigid_velocities(&impact.points);
        let at_velocity = |(at, velocity): (usize, &DVec3)| member_contact(input, (at, *velocity), &bodies);
        let contacts: Vec<MemberContact> = velocities.iter().enumerate().map(at_velocity).collect();
        self.system.replace(&members, &contacts).ok()?;
        // Steps: a part of the first duration, and short enough for the band.
        let first = self.system.first_duration()?;
        let step = (first / steps).min(0.25 / band);
        let settings = StepSettings {
            steps_per_duration: steps,
            step: Some(step),
            max_steps: MAX_STEPS,
            longest_flight: LONGEST_FLIGHT,
            ..StepSettings::default()
        };
        let solution = self.system.solve(&settings, &mut self.memory).ok()?;
        self.report.solved += 1;
        self.report.steps += solution.steps as u64;
        // Shapes of the forces, scaled to the recorded impulses.
        let courses: Vec<[Vec<f64>; 3]> = (0..contacts.len())
            .map(|c| [0, 1, 2].map(|axis| (0..solution.steps).map(|n| solution.force(n, c)[axis]).collect()))
            .collect();
        let (forces, scale) = scaled_forces(impact, &courses, &solution.axes, (solution.step, band))?;
        // What the bodies ring with afterwards: their own vibration and the scaled part of the force.
        let duration = solution.duration();
        let modal_scale = scale.min(MOST_SCALE);
        for (side, body) in bodies.iter().enumerate().filter(|(_, body)| !body.poles.is_empty()) {
            let after = solution.modal_state(side);
            let own = body.known_state().iter().zip(&body.poles).map(|(w, pole)| w * (pole * duration).exp());
            let state = own.zip(after).map(|(own, after)| own + modal_scale * (after - own)).collect();
            self.ringing.set(impact.sides[side].body, impact.time + duration, &body.poles, state);
        }
        self.report.largest_scale = self.report.largest_scale.max(scale);
        self.report.over_scaled += u64::from(scale > MOST_SCALE);
        Some(forces)
    }
}

/// Whether the recorded impulses of an impact have a tangential part.
fn rubs(impact: &Impact) -> bool {
    let total: f64 = impact.points.iter().map(|point| point.impulse.length()).sum();
    let across = |point: &ContactPoint| point.impulse.reject_from_normalized(point.normal).length();
    impact.points.iter().map(across).sum::<f64>() > LEAST_FRICTION * total
}

/// Share of the tangential impulses in all below which an impact counts as free of friction.
const LEAST_FRICTION: f64 = 1e-6;

/// A contact point of the impact with a velocity of A against B, and the modes of both bodies there.
fn member_contact(
    input: &SolveInput<'_>,
    (at, velocity): (usize, DVec3),
    bodies: &[VibratingMember; 2],
) -> MemberContact {
    let impact = input.impact;
    let point = &impact.points[at];
    // The surfaces touch where the vibration has brought them: A moves along +n, B along −n opens it.
    let gap = point.gap - bodies[0].opening(at, point.normal) - bodies[1].opening(at, -point.normal);
    let radiation: f64 = impact.sides.iter().map(|side| side.radiation).sum();
    MemberContact {
        members: [Some(0), Some(1)],
        point: point.place,
        normal: point.normal,
        velocity,
        law: ContactLaw::Hertz(HertzLaw {
            stiffness: input.contact.stiffness(),
            restitution_damping: restitution_damping(impact.restitution),
            radiation,
            plate_mobility: impact.sides.iter().map(|side| side.plate_mobility).sum(),
            viscosity: 0.0,
        }),
        gap,
        friction: if rubs(impact) { impact.friction } else { 0.0 },
        standing: false,
        shapes: bodies.each_ref().map(|body| body.shapes[at].clone()),
    }
}

/// Deviation of shapes below which two forces share one.
const LEAST_DEVIATION: f64 = 5e-3;

/// ∫ |S − S₀| dt of the shapes of two forces, each of unit impulse.
fn deviation(force: &[f64], reference: &[f64]) -> f64 {
    let [own, other] = [force, reference].map(|force| force.iter().sum::<f64>().recip());
    force.iter().zip(reference).map(|(a, b)| (a * own - b * other).abs()).sum()
}

/// The shape of forces, each constant over a `step` \[s\], up to a `band` \[Hz\], and its end \[s\].
fn shape_of_steps(forces: &[f64], step: f64, band: f64) -> Option<(Arc<ForceHistory>, f64)> {
    let end = forces.iter().rposition(|force| *force != 0.0).map_or(0, |last| last + 1);
    let (history, _) = ForceHistory::of_steps(&forces[..end], step, band)?;
    Some((Arc::new(history), end as f64 * step))
}

/// The shapes of the forces with their impulses, and the factor s from the solved to the recorded normal
/// impulse of the impact.
fn scaled_forces(
    impact: &Impact,
    courses: &[[Vec<f64>; 3]],
    axes: &[[DVec3; 3]],
    (step, band): (f64, f64),
) -> Option<(Vec<SolvedForce>, f64)> {
    let recorded: f64 = impact.points.iter().map(|point| point.impulse.dot(point.normal)).sum();
    let solved: f64 = courses.iter().map(|course| step * course[0].iter().sum::<f64>()).sum();
    if !(solved > 0.0 && recorded > 0.0) {
        return None;
    }
    let scale = recorded / solved;
    if scale > MOST_MISSED {
        return None;
    }
    let shown = scale.min(MOST_SCALE);
    let gain = shown / scale;
    let of_steps = |forces: &[f64]| shape_of_steps(forces, step, band);
    // Points whose force has the shape of the sum share it.
    let mut sum = vec![0.0; courses.first()?[0].len()];
    for course in courses {
        sum.iter_mut().zip(&course[0]).for_each(|(sum, force)| *sum += force);
    }
    let common = of_steps(&sum)?;
    // What is left of the impulse at twice the solved force.
    let greatest = shown * sum.iter().copied().fold(0.0, f64::max);
    let left = recorded - shown * solved;
    let rest = (scale > MOST_SCALE).then(|| slow_rest(left, (greatest, common.1), band)).flatten();
    let (part, gain) = if rest.is_some() { (gain, 1.0) } else { (1.0, gain) };
    let single = courses.len() == 1;
    let mut forces = Vec::with_capacity(courses.len());
    for (at, (course, point)) in courses.iter().zip(&impact.points).enumerate() {
        let own = point.impulse.dot(point.normal) * point.normal;
        let across = point.impulse - own;
        let normal = step * course[0].iter().sum::<f64>() * point.normal;
        let along = if single { own } else { scale * normal };
        if along == DVec3::ZERO && across == DVec3::ZERO && point.couple == DVec3::ZERO {
            continue;
        }
        let differs = normal != DVec3::ZERO && deviation(&course[0], &sum) > LEAST_DEVIATION;
        let shape = differs.then(|| of_steps(&course[0])).flatten().unwrap_or_else(|| common.clone());
        // Friction has its own shape where it pushes one way for most of the time.
        let own = across.try_normalize().and_then(|direction| {
            let [_, first, second] = axes[at];
            let turned = [first.dot(direction), second.dot(direction)];
            let force: Vec<f64> =
                course[1].iter().zip(&course[2]).map(|(a, b)| turned[0] * a + turned[1] * b).collect();
            let (pushed, total) =
                force.iter().fold((0.0, 0.0), |(sum, size), f| (sum + f, size + f64::abs(*f)));
            let differs = pushed > 0.0 && deviation(&force, &course[0]) > LEAST_DEVIATION;
            (differs && pushed > 0.5 * total).then(|| of_steps(&force)).flatten()
        });
        let with = |impulse: DVec3, couple: DVec3, (history, end): (Arc<ForceHistory>, f64)| SolvedForce {
            point: at,
            impulse: part * impulse,
            couple: part * couple,
            history,
            end,
            modal_gain: gain,
        };
        match own {
            Some(own) => {
                forces.push(with(along, point.couple, shape));
                forces.push(with(across, DVec3::ZERO, own));
            }
            None => forces.push(with(along + across, point.couple, shape)),
        }
        // The modes have all that they get.
        forces.extend(rest.clone().map(|(history, end)| SolvedForce {
            point: at,
            impulse: (1.0 - part) * (along + across),
            couple: (1.0 - part) * point.couple,
            history,
            end,
            modal_gain: 0.0,
        }));
    }
    Some((forces, scale))
}
