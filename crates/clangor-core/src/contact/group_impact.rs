//! The impulses of all contacts of one instant, from a solve of the contacts: for dynamics.
//!
//! ```text
//! bodies, their motion, modes, ringing ─► members  ─► solve ─► ∫F of every contact ─► momenta
//! places, normals, gaps, stiffnesses   ─► contacts          ─► states of the modes, kept for the next one
//! ```
//!
//! Restitution and friction of bodies that vibrate are results: the restitution of a contact is the loss of
//! the contact alone ([`compliant`](super::compliant)). Motion and modes together never have more energy
//! than before. What the tails of modes above the band take is heat.
//!
//! A group that is followed also says what each body feels over time
//! ([`load_history`](mod@super::load_history)).
//!
//! Not covered: gravity during the contact, whose impulse m g T belongs to the caller's step; bodies that no
//! contact of the group touches yet.

use std::collections::BTreeMap;

use glam::DVec3;

use super::compliant::{
    ContactEnd, ContactLaw, ContactSystem, HertzLaw, MemberContact, SolverMemory, StepSettings,
    restitution_damping,
};
use super::contact_side::{ContactSide, inverse_effective_mass};
use super::hertz::HertzContact;
use super::hertz_pulse::centred_spectrum;
use super::impact_solver::LEAST_MODAL_SHARE;
use super::load_history::LoadHistory;
use super::modal_energy::{ModesAtContact, ModesOf};
use super::relative_curvature::RelativeCurvature;
use super::vibrating_member::{RingingBodies, VibratingMember};
use crate::body::BodyId;

/// Steps per first duration: the momenta are within 1e-3 of those of many steps.
const STEPS: f64 = 24.0;
/// The same where no body vibrates: within 5e-4 through a row of five balls.
const RIGID_STEPS: f64 = 64.0;

/// Most steps of a solve: a pane that a stiff face presses vibrates for thousands of first durations.
const MOST_STEPS: usize = 65_536;

/// Time without a force, in first durations, after which another hit is another impact.
const FLIGHT: f64 = 4.0;

/// A body of a group and its motion before the impact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GroupMember {
    /// The body at its pose; the curvature of its surface is that of [`GroupContact::sides`].
    pub side: ContactSide,
    /// Velocity of the centre of mass [m/s].
    pub velocity: DVec3,
    /// Angular velocity [rad/s].
    pub angular_velocity: DVec3,
}

/// A contact of a group.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GroupContact {
    /// Indices of the bodies A and B among the members.
    pub members: [usize; 2],
    /// A and B with the curvature of their surfaces here.
    pub sides: [ContactSide; 2],
    /// Place [m, world].
    pub place: DVec3,
    /// Unit normal, from B to A.
    pub normal: DVec3,
    /// Gap between the surfaces \[m\].
    pub gap: f64,
    /// Approach speed −n·(v_A − v_B) there [m/s].
    pub approach: f64,
    /// Loss of the contact itself, as a restitution.
    pub restitution: f64,
    /// Coefficient of friction.
    pub friction: f64,
}

/// The bodies and contacts of one instant.
#[derive(Clone, Copy, Debug)]
pub struct GroupImpact<'a> {
    /// Time \[s\].
    pub time: f64,
    /// Bodies.
    pub members: &'a [GroupMember],
    /// Contacts between them.
    pub contacts: &'a [GroupContact],
    /// Whether the energy that contacts and modes store is kept for [`GroupSolver::load_history`].
    pub followed: bool,
}

/// Solves groups in order of time, and keeps the vibration of the bodies between them.
#[derive(Default)]
pub struct GroupSolver {
    memory: SolverMemory,
    system: ContactSystem,
    ringing: RingingBodies,
    /// Until when forces of solved contacts act on each vibrating body \[s\].
    pressed_until: BTreeMap<BodyId, f64>,
    solved: u64,
    fallen_back: u64,
}

impl GroupContact {
    /// Hertz's contact of the rigid bodies.
    fn hertz(&self) -> HertzContact {
        HertzContact {
            inverse_mass: inverse_effective_mass(&self.sides, self.place, self.normal),
            relative_radii: RelativeCurvature::between(&self.sides, self.normal).radii,
            compliance: self.sides.iter().map(|side| side.compliance).sum(),
            speed: self.approach,
        }
    }

    /// Hertz's duration of the contact of rigid bodies \[s\].
    pub fn duration(&self) -> f64 {
        self.hertz().duration()
    }

    /// Place \[m\] and unit push on a body, in its frame, as [`ModesOf`] takes them.
    fn local(&self, at: usize) -> (DVec3, DVec3) {
        let (pose, sign) = (&self.sides[at].pose, if at == 0 { 1.0 } else { -1.0 });
        (pose.body_from_world(self.place), pose.orientation.inverse() * self.normal * sign)
    }

    /// Energy of the modes after Hertz's pulse of rigid bodies with j = (1 + e) m V, and of the waves in an
    /// endless plate, over that of the approach; 0 for bodies without modes.
    fn modal_share(&self, modes: ModesOf<'_>) -> f64 {
        let hertz = self.hertz();
        let impulse = (1.0 + self.restitution) * self.approach / hertz.inverse_mass;
        let duration = hertz.duration();
        let energy = |at: usize| {
            let (side, point) = (&self.sides[at], self.local(at));
            modes(side.body, &[point]).map_or(0.0, |modes| match modes.covers(1) {
                true => modes.energy(&[impulse * point.1], |omega| centred_spectrum(0.5 * omega * duration)),
                false => f64::NAN,
            })
        };
        let modal = (energy(0) + energy(1)) * 2.0 * hertz.inverse_mass / (self.approach * self.approach);
        modal + hertz.plate_share(&self.sides)
    }
}

impl ModesAtContact {
    /// Whether every mode has finite numbers at each of so many points.
    fn covers(&self, points: usize) -> bool {
        let count = self.frequencies.len();
        self.damping_ratios.len() == count
            && self.motions.len() == points
            && self.motions.iter().all(|at| at.len() == count && at.iter().all(|u| u.is_finite()))
            && self.frequencies.iter().chain(&self.damping_ratios).all(|x| x.is_finite())
    }
}

impl GroupSolver {
    /// Groups that were solved.
    pub fn solved(&self) -> u64 {
        self.solved
    }

    /// Groups that could not be solved.
    pub fn fallen_back(&self) -> u64 {
        self.fallen_back
    }

    /// Energy of all vibration that is left of solved groups, each body's when it was last solved \[J\].
    pub fn modal_energy(&self) -> f64 {
        self.ringing.energy()
    }

    /// Forgets the vibration of a body.
    pub fn remove(&mut self, body: BodyId) {
        self.ringing.remove(body);
        self.pressed_until.remove(&body);
    }

    /// Whether forces of solved contacts still act on a body at a time \[s\]: what meets it meanwhile is no
    /// impact of its own.
    pub fn is_pressed(&self, body: BodyId, time: f64) -> bool {
        self.pressed_until.get(&body).is_some_and(|until| time < *until)
    }

    /// Whether the modes of the bodies matter to a contact: their share of the energy of the approach is
    /// above 0.003 with the pulse of rigid bodies, or is no number.
    pub fn matters(&self, contact: &GroupContact, modes: ModesOf<'_>) -> bool {
        let share = contact.modal_share(modes);
        share > LEAST_MODAL_SHARE || !share.is_finite()
    }

    /// Impulses on A of each contact [N s, world]; `None`, counted, if the group cannot be solved.
    pub fn solve(&mut self, group: &GroupImpact<'_>, modes: ModesOf<'_>) -> Option<Vec<DVec3>> {
        let impulses = self.try_solve(group, modes);
        match impulses {
            Some(_) => self.solved += 1,
            None => self.fallen_back += 1,
        }
        impulses
    }

    /// What the group solved last did to one of its members over time; `None` if it was not followed.
    pub fn load_history(&self, group: &GroupImpact<'_>, member: usize) -> Option<LoadHistory> {
        let contacts: Vec<(usize, f64)> = group
            .ends_of(member)
            .map(|(contact, end)| (contact, if end == 0 { 1.0 } else { -1.0 }))
            .collect();
        let points = contacts.iter().map(|(contact, _)| group.contacts[*contact].place).collect();
        LoadHistory::of_solution(self.memory.solution(), member, &contacts, points)
    }

    fn try_solve(&mut self, group: &GroupImpact<'_>, modes: ModesOf<'_>) -> Option<Vec<DVec3>> {
        let hertz: Vec<HertzContact> = group.contacts.iter().map(GroupContact::hertz).collect();
        let fastest = group.contacts.iter().map(|contact| contact.approach).fold(0.0, f64::max);
        // Members: motion, and modes at the points of each body.
        let mut bodies = Vec::with_capacity(group.members.len());
        for (index, member) in group.members.iter().enumerate() {
            let own: Vec<(usize, usize)> = group.ends_of(index).collect();
            let points: Vec<(DVec3, DVec3)> =
                own.iter().map(|(contact, at)| group.contacts[*contact].local(*at)).collect();
            let own_modes = modes(member.side.body, &points);
            if own_modes.as_ref().is_some_and(|modes| !modes.covers(points.len())) {
                return None;
            }
            let ends = own.iter().map(|(contact, _)| {
                let hertz = HertzContact { speed: fastest, ..hertz[*contact] };
                (group.contacts[*contact].normal, hertz.duration())
            });
            let ends: Vec<(DVec3, f64)> = ends.collect();
            let ringing = (&self.ringing, group.time);
            let mut body = VibratingMember::new(&member.side, own_modes.as_ref(), &ends, ringing);
            body.member.velocity = member.velocity;
            body.member.angular_velocity = member.angular_velocity;
            bodies.push(body);
        }
        // Contacts, in the same order.
        let mut seen = vec![0; bodies.len()];
        let contacts: Vec<MemberContact> = group
            .contacts
            .iter()
            .zip(&hertz)
            .map(|(contact, hertz)| {
                let at = contact.members.map(|member| {
                    seen[member] += 1;
                    (member, seen[member] - 1)
                });
                member_contact(contact, hertz.stiffness(), at, &bodies)
            })
            .collect();
        let members: Vec<_> = bodies.iter().map(|body| body.member.clone()).collect();
        self.system.replace(&members, &contacts).ok()?;
        let vibrates = members.iter().any(|member| !member.poles.is_empty());
        let steps_per_duration = if vibrates { STEPS } else { RIGID_STEPS };
        let first = self.system.first_duration()?;
        let settings = StepSettings {
            steps_per_duration,
            max_steps: MOST_STEPS,
            longest_flight: FLIGHT * first,
            stored_energy: group.followed,
            ..StepSettings::default()
        };
        let solution = self.system.solve(&settings, &mut self.memory).ok()?;
        // A force that still acts has not given its impulse.
        if solution.end == ContactEnd::StillTouching {
            return None;
        }
        let (end, step) = (group.time + solution.duration(), solution.step);
        for (index, body) in bodies.iter().enumerate().filter(|(_, body)| !body.poles.is_empty()) {
            let pressed = |step: &usize| group.ends_of(index).any(|(c, _)| solution.force(*step, c)[0] > 0.0);
            let last = (0..solution.steps).rev().find(pressed).map_or(0, |step| step + 1);
            self.pressed_until.insert(group.members[index].side.body, group.time + last as f64 * step);
            let state = solution.modal_state(index)[..body.poles.len()].to_vec();
            self.ringing.set(group.members[index].side.body, end, &body.poles, state);
        }
        Some((0..contacts.len()).map(|contact| solution.impulse(contact)).collect())
    }
}

impl GroupImpact<'_> {
    /// Contacts of a member, and which of their ends it is.
    fn ends_of(&self, member: usize) -> impl Iterator<Item = (usize, usize)> {
        self.contacts.iter().enumerate().filter_map(move |(index, contact)| {
            contact.members.iter().position(|m| *m == member).map(|at| (index, at))
        })
    }
}

/// A contact with the modes of both bodies; `at` has the member of each end, and which of its points this
/// is.
fn member_contact(
    contact: &GroupContact,
    stiffness: f64,
    at: [(usize, usize); 2],
    bodies: &[VibratingMember],
) -> MemberContact {
    let opening = |end: usize, direction: DVec3| bodies[at[end].0].opening(at[end].1, direction);
    MemberContact {
        members: at.map(|(member, _)| Some(member)),
        point: contact.place,
        normal: contact.normal,
        velocity: DVec3::ZERO,
        law: ContactLaw::Hertz(HertzLaw {
            stiffness,
            restitution_damping: restitution_damping(contact.restitution),
            radiation: contact.sides.iter().map(|side| side.radiation).sum(),
            plate_mobility: contact.sides.iter().map(|side| side.plate_mobility).sum(),
            viscosity: 0.0,
        }),
        // The surfaces touch where the vibration has brought them.
        gap: contact.gap.max(0.0) - opening(0, contact.normal) - opening(1, -contact.normal),
        friction: contact.friction,
        standing: false,
        shapes: at.map(|(member, point)| bodies[member].shapes[point].clone()),
    }
}
