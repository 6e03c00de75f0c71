//! Bodies of an event that a hand or a joint leads: infinitely heavy where they recoil less than free ones.
//!
//! ```text
//! J of the other bodies' jumps alone        if  m Δv·J/|J| < |J| + ½ m p h        for all that are led
//! ```
//!
//! with the jump Δv of the led body beyond its push p ([`led_bodies`](crate::motion)). A hand holds a body
//! back, so that it recoils by less than the impulse would make it; it does not say by how much. The impulse
//! is then that of the bodies which it meets, if these have jumps. If not, as with an anvil, or if they show
//! less, as a block on a table whose jump is that of the impact and of the table, the jump of the led body is
//! all there is. Of two that are led, one that does not jump is infinitely heavy, and two that do are as
//! heavy as they are.
//!
//! A floor close to a led body could hold it too. Where free bodies leave a share r of an event unexplained,
//! and infinitely heavy ones in the place of those that do not jump leave less than r², these are led.

use glam::DVec3;

use super::reach::Nearness;
use super::{Member, POOR, Scene, Search, fit_bodies};
use crate::motion::impulse_fit::{Fit, FitBody, FitContact, fit_impulses};
use crate::motion::kinematics::Kinematics;
use crate::motion::led_bodies::{Pushes, Reach};
use crate::motion::touch::Touch;

/// Normal speed of surfaces that stay together: this, and what gravity does in a frame [m/s].
const TOGETHER: f64 = 0.02;
/// Factor on the gaps that count as touching, within which a body may carry another one: what rests in a pile
/// touches by a part of its surface at a time.
const NEAR: f64 = 16.0;
/// Part of what a hand gives in the frames of an impact that is uncertain.
const UNCERTAIN: f64 = 0.5;
/// Unexplained share of an event of free bodies alone: more than a row of balls leaves.
const LITTLE: f64 = 0.02;

/// Impulses on a led body [N s]: those that the others' jumps say, and those of its own beyond the hand's.
struct Recoil {
    given: DVec3,
    own: DVec3,
    uncertain: f64,
}

impl Scene<'_> {
    /// The impulses at the contacts of members, of which those that are led become infinitely heavy; `None`
    /// if the only body that has one impact alone is led, and its jump is not that of the impulse.
    pub(super) fn fitted(
        &self,
        members: &mut [Member],
        contacts: &[FitContact],
        (search, span): (Search, f64),
    ) -> Option<Fit> {
        let led: Vec<usize> = (0..members.len()).filter(|place| self.is_led(*place, members, span)).collect();
        let still: Vec<usize> =
            led.iter().copied().filter(|place| members[*place].window.is_none()).collect();
        for set in [led, still] {
            let mut trial = members.to_vec();
            for place in &set {
                trial[*place] = Member { fit: immovable(&trial[*place]), is_led: true, ..trial[*place] };
            }
            let jumps = |member: &&Member| member.fit.inverse_mass > 0.0 && member.window.is_some();
            if set.is_empty() || !trial.iter().any(|member| jumps(&member)) {
                continue;
            }
            if search == Search::Clean && trial.iter().filter(jumps).all(Member::is_mixed) {
                return None;
            }
            let fit = fit_impulses(&fit_bodies(&trial, search), contacts);
            let holds_back = |place: &usize| {
                self.recoil(*place, &members[*place], (contacts, &fit)).is_none_or(|recoil| {
                    recoil.own.dot(recoil.given.normalize_or_zero())
                        <= recoil.given.length() + recoil.uncertain
                })
            };
            if set.iter().all(holds_back) {
                members.copy_from_slice(&trial);
                return Some(fit);
            }
        }
        let free = fit_impulses(&fit_bodies(members, search), contacts);
        let unmoved = self.fitted_to_unmoved(members, contacts, (search, free.residual));
        Some(unmoved.unwrap_or(free))
    }

    /// The impulses with all recorded members infinitely heavy that do not jump, if these explain the jumps
    /// of the others so much better than free bodies, which leave a part `free`, that they must be led: a
    /// pusher on a floor, which seems to hold it, goes on as if it had hit nothing.
    fn fitted_to_unmoved(
        &self,
        members: &mut [Member],
        contacts: &[FitContact],
        (search, free): (Search, f64),
    ) -> Option<Fit> {
        if free < LITTLE {
            return None;
        }
        let mut trial = members.to_vec();
        let is_unmoved = |member: &&mut Member| member.fit.inverse_mass > 0.0 && member.window.is_none();
        let mut unmoved = 0;
        for member in trial.iter_mut().filter(is_unmoved) {
            (member.fit, member.is_led) = (immovable(member), true);
            unmoved += 1;
        }
        let jumps = |member: &&Member| member.fit.inverse_mass > 0.0;
        if unmoved == 0 || !trial.iter().any(|member| jumps(&member)) {
            return None;
        }
        let fit = fit_impulses(&fit_bodies(&trial, search), contacts);
        (fit.residual < POOR.min(free * free)).then(|| {
            members.copy_from_slice(&trial);
            fit
        })
    }

    /// Whether something else than the bodies near a member leads it before and after the event.
    fn is_led(&self, place: usize, members: &[Member], span: f64) -> bool {
        let one = &members[place];
        let Some(kinematics) = &self.kinematics[one.body.index()] else { return false };
        let Some([first, last]) = frames_of(kinematics, one) else { return false };
        let pushes = Pushes::around(kinematics, first, last);
        if !pushes.are_steady() {
            return false;
        }
        // What meets or parts in the event has not held the body before it or does not after it.
        let slow = self.world.gravity.length() * span + TOGETHER;
        let (mut before, mut after) = (Vec::new(), Vec::new());
        for other in self.neighbours.of_body(one.body.index()) {
            if self.move_as_one(one.body, other) || !self.may_meet(one, other, one.time) {
                continue;
            }
            let known = members.iter().find(|member| member.body == other).copied();
            let Some(other) = known.or_else(|| self.member(other, None, one.time)) else { continue };
            let friction = self.friction(one.body, other.body);
            let nearness = Nearness { span, factor: NEAR, impact: 0.0 };
            for Touch { point, normal, .. } in self.touches(one, &other, &nearness) {
                let speed = (one.state.velocity_at(point) - other.state.velocity_at(point)).dot(normal);
                let change = (jump_at(one, point) - jump_at(&other, point)).dot(normal);
                let reach = Reach { normal, friction };
                if speed.abs() < slow {
                    before.push(reach);
                }
                if (speed + change).abs() < slow {
                    after.push(reach);
                }
            }
        }
        pushes.are_led(&before, &after)
    }

    /// What a fit gives to a led member, and what its own jump says.
    fn recoil(
        &self,
        place: usize,
        member: &Member,
        (contacts, fit): (&[FitContact], &Fit),
    ) -> Option<Recoil> {
        let kinematics = self.kinematics[member.body.index()].as_ref()?;
        let [first, last] = frames_of(kinematics, member)?;
        let signed = contacts.iter().zip(&fit.impulses).map(|(contact, impulse)| {
            let [of_a, of_b] = contact.bodies.map(|body| f64::from(u8::from(body == place)));
            *impulse * (of_a - of_b)
        });
        let push = Pushes::around(kinematics, first, last).mean();
        let between = first.max(1)..=last.min(kinematics.frames.len().saturating_sub(2));
        let (mut jump, mut hand) = (DVec3::ZERO, DVec3::ZERO);
        for left in between.map(|k| kinematics.left[k]) {
            jump += left.velocity;
            hand += push * left.span;
        }
        let mass = kinematics.inertia.mass;
        let uncertain = UNCERTAIN * mass * hand.length();
        Some(Recoil { given: signed.sum(), own: (jump - hand) * mass, uncertain })
    }
}

/// The effective mass of two members along a normal at a point, if one is led [kg]; otherwise it is that of
/// the bodies alone.
pub(super) fn mass_beside_led(pair: [&Member; 2], point: DVec3, normal: DVec3) -> Option<f64> {
    let inverse: f64 = pair.iter().map(|member| member.inverse_mass_along(point, normal)).sum();
    (inverse > 0.0 && pair.iter().any(|member| member.is_led)).then(|| inverse.recip())
}

/// A member that no impulse moves.
fn immovable(member: &Member) -> FitBody {
    FitBody { centre: member.fit.centre, ..FitBody::IMMOVABLE }
}

impl Member {
    /// Velocity along a direction that a unit of impulse at a point gives that point [1/kg].
    pub(super) fn inverse_mass_along(&self, point: DVec3, direction: DVec3) -> f64 {
        let FitBody { inverse_mass, inverse_inertia, centre, .. } = self.fit;
        let turning = (point - centre).cross(direction);
        if inverse_mass > 0.0 { inverse_mass + turning.dot(inverse_inertia * turning) } else { 0.0 }
    }
}

/// Jump of a point of a member [m/s].
pub(super) fn jump_at(member: &Member, point: DVec3) -> DVec3 {
    let FitBody { velocity, angular_velocity, centre, .. } = member.fit;
    match member.window {
        Some(_) => velocity + angular_velocity.cross(point - centre),
        None => DVec3::ZERO,
    }
}

/// The frames that the event of a member may change.
fn frames_of(kinematics: &Kinematics<'_>, member: &Member) -> Option<[usize; 2]> {
    let index = kinematics.interval_at(member.time).filter(|_| kinematics.is_recorded_at(member.time))?;
    Some(match member.window {
        Some(window) => [window.first.min(index), window.last.max(index + 1)],
        None => [index, index + 1],
    })
}
