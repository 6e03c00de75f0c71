//! The energy balance of linkages with stiff springs: what their links and brakes may add to the motion.
//!
//! In one step, links and brakes push the bodies of a linkage with impulses λ_i along rates s_i, and the
//! springs go from the stored energy V to V⁺, while velocities go from u to u⁺. They add
//!
//! `Σ λ_i (s_i + s_i⁺) / 2 + V⁺ − V` or `Σ λ_i s_i⁺ − ½ (u⁺ − u)ᵀ M (u⁺ − u) + V⁺ − V`
//!
//! to the energy. The first counts other impulses q of the pose as work `q · (u + u⁺) / 2`, the second as
//! `q · u⁺`; they differ by a bounded sum, and the lesser counts. Springs and joints at rest or in motion add
//! nothing; backward Euler takes energy. But an impulse along the line of a spring before a step does not
//! follow the line as it
//! turns, and what is left of a stretch becomes a velocity: light bodies that turn about their springs by
//! large angles in a step would gain energy, without bound. Therefore the sum of these gains since the last
//! loss is kept below [`SHARE`] of the energy of the linkage. Where it would be more,
//!
//! 1. a linkage of springs alone takes the velocities of `strained_net`, which minimize energy;
//! 2. where those add energy still, its velocities u relative to a motion r that strains nothing become
//!    `r + s (u − r)` before, with the largest s of [`ROUNDS`] bisections that keeps the balance.
//!
//! r is the motion of what the linkage is anchored to. For a free linkage it is the rigid motion with its
//! momentum and angular momentum; where no s suffices, that of its centre of mass. Momentum is always kept.
//! The impulses of both are in the log, as impulses of the world on each body that cancel in a free linkage.
//! Reactions of springs to impacts are part of the balance (`Reactions::works`), and so is what contacts do
//! because the bodies move otherwise than when they were solved.
//!
//! What it is not: a friction of springs. Linkages whose motion is resolved are never braked, and linkages
//! without stiff springs have no balance. A brake does not keep the angular momentum of a free linkage. At
//! the start bodies fly for half a step before springs act; what that stores is not given back.

use clangor_core::pose::Pose;
use glam::{DMat3, DVec3};

use super::closing::Next;
use super::linkage::Linkages;
use super::mover::Mover;
use super::pair::Step;
use super::reactions::Reactions;
use super::state::BodyState;
use super::step_log::StepLog;
use super::strained_net::{Motion, StrainedNet};

/// Part of the energy of a linkage that its links may add to it before they take some.
const SHARE: f64 = 1e-3;
/// Bisections for the brake.
const ROUNDS: u32 = 8;
/// Nets of more bodies have fewer bisections.
const MANY: usize = 30;
const FEW_ROUNDS: u32 = 2;
/// Links are closed to this error \[m\]: the work of a force over it is not counted.
const CLOSED: f64 = 1e-13;

/// What a step of the contact phase works on.
pub(super) struct Flight<'a> {
    pub(super) linkages: &'a Linkages,
    pub(super) bodies: &'a [BodyState],
    pub(super) step: &'a Step,
}

impl Flight<'_> {
    /// The pose of a body at the middle of the next step.
    fn next(&self, body: usize, mover: &Mover) -> Pose {
        self.bodies[body].next_middle(mover, self.step.time, self.step.length)
    }
}

/// What the impulses of contacts add to the energy \[J\], because these velocities differ from those for
/// which they were found.
pub(super) type Pressed<'a> = dyn Fn(&[Mover]) -> f64 + 'a;

/// Linkages and their bodies.
type Held<'a> = (&'a Linkages, &'a [BodyState]);

/// The balance of one linkage.
#[derive(Clone, Copy, Default)]
struct Account {
    /// Energy of the springs where the last step left them, or at the start \[J\].
    stored: Option<f64>,
    /// Work of reactions to the impacts of this step \[J\].
    impacts: f64,
    /// Sums of the gains since the last loss \[J\].
    excess: [f64; 2],
    /// Gains of this step so far \[J\], by the two ways to count.
    gains: [f64; 2],
    /// Most excess that is allowed in this step, without rounding \[J\].
    allowed: f64,
    /// Energy of the springs at the middle of the next step \[J\].
    next: f64,
    /// That energy, and the one of motion \[J\].
    energy: f64,
}

impl Account {
    /// Sums of the gains with those of this step \[J\].
    fn excesses(&self) -> [f64; 2] {
        [self.excess[0] + self.gains[0], self.excess[1] + self.gains[1]]
    }
}

/// The balances of all linkages.
#[derive(Default)]
pub(super) struct SpringBalance {
    accounts: Vec<Account>,
    /// Bodies before links and contacts act.
    before: Vec<Mover>,
    /// Changes of velocity and spin by brakes in this step, by body.
    brakes: Vec<Motion>,
    braked: bool,
}

impl SpringBalance {
    /// Adds the work \[J\] of reactions to an impact.
    pub(super) fn add_impact(&mut self, linkage: usize, work: f64) {
        if self.accounts.len() <= linkage {
            self.accounts.resize(linkage + 1, Account::default());
        }
        self.accounts[linkage].impacts += work;
    }

    /// Begins a step with the bodies as they are before links and contacts act.
    pub(super) fn begin(&mut self, bodies: &[BodyState], linkages: &Linkages) {
        self.braked = false;
        if !(0..linkages.count()).any(|linkage| linkages.has_springs(linkage)) {
            return;
        }
        self.before.clear();
        self.before.extend(bodies.iter().map(BodyState::mover));
        self.brakes.clear();
        self.brakes.resize(bodies.len(), (DVec3::ZERO, DVec3::ZERO));
        self.accounts.resize(linkages.count(), Account::default());
        for linkage in (0..linkages.count()).filter(|linkage| linkages.has_springs(*linkage)) {
            let now = || linkages.stored(linkage, &|body| bodies[body].start_pose());
            let stored = self.accounts[linkage].stored.unwrap_or_else(now);
            let flight = &(linkages, bodies);
            let still = Carrier::of(linkage, &self.before, flight, true);
            let energy = |&body: &usize| still.energy(body, &self.before, bodies);
            let moving: f64 = moving(linkage, &self.before, linkages).iter().map(energy).sum();
            let account = &mut self.accounts[linkage];
            account.stored = Some(stored);
            account.gains = [0.0; 2];
            account.next = stored;
            account.allowed = SHARE * (moving + stored - account.excess[0].min(account.excess[1])).max(0.0);
        }
    }

    /// Closes the links of a linkage, and brakes its bodies where that would add energy. `Err` has a link
    /// that cannot be closed, and by how much it is open \[m, or rad\].
    pub(super) fn close(
        &mut self,
        linkage: usize,
        reactions: &mut Reactions,
        movers: &mut [Mover],
        (flight, pressed): (&Flight<'_>, &Pressed<'_>),
    ) -> Result<(), (usize, f64)> {
        let next = |body: usize, mover: &Mover| flight.next(body, mover);
        let ahead: (f64, &Next<'_>) = (flight.step.length, &next);
        if !flight.linkages.has_springs(linkage) {
            return reactions.settle(flight.linkages, movers, linkage, ahead);
        }
        let mut free = movers.to_vec();
        reactions.take_back(linkage, &mut free);
        let closed = reactions.settle(flight.linkages, movers, linkage, ahead);
        if closed.is_ok() && self.keeps(linkage, reactions, movers, (flight, pressed)) {
            return Ok(());
        }
        let bodies = moving(linkage, movers, flight.linkages);
        let now = |body: usize| flight.bodies[body].middle_pose();
        let net = StrainedNet::of((flight.linkages, linkage), bodies.clone(), &now, ahead);
        let earlier = bodies.iter().map(|&body| self.brakes[body]).collect();
        let starts = self.starts(linkage, movers, flight);
        let attempt = Attempt { linkage, bodies, free, earlier, starts, net, flight, pressed };
        self.braked = true;
        for turns in [true, false] {
            let held = (flight.linkages, flight.bodies);
            let carrier = Carrier::of(linkage, &attempt.free, &held, turns);
            if self.slow_down(&attempt, &carrier, reactions, movers) {
                return Ok(());
            }
        }
        if attempt.net.is_some() {
            return Ok(());
        }
        // Nothing better than without brakes.
        attempt.put(movers, |body| (attempt.free[body].velocity, attempt.free[body].spin));
        attempt.bodies.iter().zip(&attempt.earlier).for_each(|(&body, brake)| self.brakes[body] = *brake);
        reactions.restart_slot(linkage);
        reactions.settle(flight.linkages, movers, linkage, ahead)
    }

    /// Slows the bodies relative to a motion as little as the balance needs. Returns whether it is kept.
    fn slow_down(
        &mut self,
        attempt: &Attempt<'_>,
        carrier: &Carrier,
        reactions: &mut Reactions,
        movers: &mut [Mover],
    ) -> bool {
        if attempt.net.is_some() && self.slowed(attempt, (carrier, 1.0), reactions, movers) {
            return true;
        }
        if !self.slowed(attempt, (carrier, 0.0), reactions, movers) {
            return false;
        }
        let rounds = if attempt.bodies.len() > MANY { FEW_ROUNDS } else { ROUNDS };
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..rounds {
            let share = 0.5 * (low + high);
            if self.slowed(attempt, (carrier, share), reactions, movers) { low = share } else { high = share }
        }
        self.slowed(attempt, (carrier, low), reactions, movers)
    }

    /// Slows the bodies to a share of their motion relative to another one and closes the links. Returns
    /// whether the balance is kept.
    fn slowed(
        &mut self,
        attempt: &Attempt<'_>,
        (carrier, share): (&Carrier, f64),
        reactions: &mut Reactions,
        movers: &mut [Mover],
    ) -> bool {
        let Attempt { linkage, free, flight, net, .. } = attempt;
        reactions.restart_slot(*linkage);
        attempt.put(movers, |body| carrier.slowed(body, free, flight.bodies, share));
        if let Some(net) = net {
            net.relax(movers, &attempt.starts);
        }
        for (&body, earlier) in attempt.bodies.iter().zip(&attempt.earlier) {
            let (velocity, spin) = (movers[body].velocity, movers[body].spin);
            self.brakes[body] =
                (earlier.0 + velocity - free[body].velocity, earlier.1 + spin - free[body].spin);
        }
        let next = |body: usize, mover: &Mover| flight.next(body, mover);
        let ahead: (f64, &Next<'_>) = (flight.step.length, &next);
        let closes = net.is_some() || reactions.settle(flight.linkages, movers, *linkage, ahead).is_ok();
        closes && self.keeps(*linkage, reactions, movers, (flight, attempt.pressed))
    }

    /// Velocities from which the search for a step begins: parts of those before, back to where the bodies
    /// were too, and those that close the links.
    fn starts(&self, linkage: usize, movers: &[Mover], flight: &Flight<'_>) -> Vec<Vec<Motion>> {
        let held = (flight.linkages, flight.bodies);
        let carrier = Carrier::of(linkage, &self.before, &held, false);
        let bodies = moving(linkage, movers, flight.linkages);
        let of = |share: f64| {
            let slowed = |&body: &usize| carrier.slowed(body, &self.before, flight.bodies, share);
            bodies.iter().map(slowed).collect()
        };
        let closed = bodies.iter().map(|&body| (movers[body].velocity, movers[body].spin)).collect();
        [-1.0, -0.5, 0.0, 0.5, 1.0].map(of).into_iter().chain([closed]).collect()
    }

    /// Whether a linkage keeps its balance with these velocities.
    fn keeps(
        &mut self,
        linkage: usize,
        reactions: &mut Reactions,
        movers: &[Mover],
        (flight, pressed): (&Flight<'_>, &Pressed<'_>),
    ) -> bool {
        let next = flight.linkages.stored(linkage, &|body| flight.next(body, &movers[body]));
        let (work, rounding) = reactions.power(linkage, movers);
        let anchor =
            Carrier::of_anchor(linkage, movers, &(flight.linkages, flight.bodies)).unwrap_or_default();
        let bodies = moving(linkage, movers, flight.linkages);
        let earlier = reactions.power(linkage, &self.before).0;
        // As if other impulses acted before and after, and as if they were those of a lasting load.
        let (mut alike, mut loaded) = (0.5 * (earlier + work), work);
        for &body in &bodies {
            let (velocity, spin) = self.brakes[body];
            let carried = anchor.motion(flight.bodies[body].mid_position);
            let (a, b) = (&self.before[body], &movers[body]);
            let (mass, inertia) = (b.mass(), b.inertia());
            let (faster, turned) = (b.velocity - a.velocity, b.spin - a.spin);
            let braked =
                |v: DVec3, w: DVec3| mass * velocity.dot(v - carried.0) + (inertia * spin).dot(w - carried.1);
            alike += braked(0.5 * (a.velocity + b.velocity), 0.5 * (a.spin + b.spin));
            loaded += braked(b.velocity, b.spin)
                - 0.5 * (mass * faster.length_squared() + (inertia * turned).dot(turned));
        }
        let account = &mut self.accounts[linkage];
        account.next = next;
        let other = account.impacts + next - account.stored.unwrap_or(next) + pressed(movers).max(0.0);
        account.gains = [alike + other, loaded + other];
        let rounding = rounding * CLOSED / flight.step.length;
        let carrier = Carrier::of(linkage, movers, &(flight.linkages, flight.bodies), true);
        let moving: f64 = bodies.iter().map(|&body| carrier.energy(body, movers, flight.bodies)).sum();
        account.energy = moving + next;
        let excess = account.excesses()[0].min(account.excesses()[1]);
        excess <= account.allowed.max(SHARE * (moving + next - excess)) + rounding
    }

    /// Ends the step.
    pub(super) fn end(&mut self) {
        for account in &mut self.accounts {
            let most = account.energy.max(0.0);
            account.excess = account.excesses().map(|excess| excess.clamp(0.0, most));
            account.stored = account.stored.map(|_| account.next);
            account.impacts = 0.0;
        }
    }

    /// Applies the brakes to the bodies and logs them.
    pub(super) fn apply(&self, bodies: &mut [BodyState], step: &Step, log: &mut StepLog) {
        if !self.braked {
            return;
        }
        for (index, (velocity, spin)) in self.brakes.iter().enumerate() {
            if *velocity == DVec3::ZERO && *spin == DVec3::ZERO {
                continue;
            }
            let (impulse, couple) =
                (*velocity * self.before[index].mass(), self.before[index].inertia() * *spin);
            bodies[index].kick(impulse, couple);
            if log.skips_slower().is_none() {
                let body = &bodies[index];
                let ends = [(Some(index), DVec3::ZERO), (None, DVec3::ZERO)];
                let place = (body.mid_position, self.before[index].velocity);
                log.link(step.time + 0.5 * step.length, ends, place, (impulse, couple));
            }
        }
    }
}

/// Bodies of a linkage that forces move at present.
fn moving(linkage: usize, movers: &[Mover], linkages: &Linkages) -> Vec<usize> {
    linkages.bodies_of(linkage).iter().copied().filter(|&body| movers[body].inverse_mass > 0.0).collect()
}

/// A linkage that is to be braked.
struct Attempt<'a> {
    linkage: usize,
    bodies: Vec<usize>,
    /// Bodies without the impulses of its links in this step.
    free: Vec<Mover>,
    /// Changes by earlier brakes of this step.
    earlier: Vec<Motion>,
    starts: Vec<Vec<Motion>>,
    /// The linkage, if it has springs alone.
    net: Option<StrainedNet<'a>>,
    flight: &'a Flight<'a>,
    pressed: &'a Pressed<'a>,
}

impl Attempt<'_> {
    /// Gives the bodies these velocities.
    fn put(&self, movers: &mut [Mover], motion: impl Fn(usize) -> Motion) {
        for &body in &self.bodies {
            let (velocity, spin) = motion(body);
            movers[body] = Mover { velocity, spin, ..self.free[body] };
        }
    }
}

/// A rigid motion that strains nothing.
#[derive(Clone, Copy, Default)]
struct Carrier {
    place: DVec3,
    velocity: DVec3,
    spin: DVec3,
}

impl Carrier {
    /// The motion of what a linkage is anchored to, if it is.
    fn of_anchor(linkage: usize, movers: &[Mover], (linkages, bodies): &Held<'_>) -> Option<Self> {
        let joints = linkages.joints_of(linkage).iter().map(|&at| &linkages.joints[at]);
        let mut anchored = None;
        for end in joints.flat_map(|joint| joint.ends) {
            match end.body {
                None => return Some(Carrier::default()),
                Some(body) if movers[body].inverse_mass == 0.0 => {
                    let Mover { velocity, spin, .. } = movers[body];
                    anchored.get_or_insert(Carrier { place: bodies[body].mid_position, velocity, spin });
                }
                Some(_) => {}
            }
        }
        anchored
    }

    /// The motion of its anchor, or that of a free linkage as a whole, which turns or does not.
    fn of(linkage: usize, movers: &[Mover], held: &Held<'_>, turns: bool) -> Self {
        if let Some(anchor) = Carrier::of_anchor(linkage, movers, held) {
            return anchor;
        }
        let (linkages, states) = held;
        let bodies = moving(linkage, movers, linkages);
        let (mut mass, mut place, mut momentum) = (0.0, DVec3::ZERO, DVec3::ZERO);
        for &body in &bodies {
            let own = movers[body].mass();
            mass += own;
            place += own * states[body].mid_position;
            momentum += own * movers[body].velocity;
        }
        let (place, velocity) = (place / mass, momentum / mass);
        let (mut angular, mut inertia) = (DVec3::ZERO, DMat3::ZERO);
        for &body in bodies.iter().filter(|_| turns) {
            let (own, arm) = (movers[body].mass(), states[body].mid_position - place);
            let outer = DMat3::from_cols(arm * arm.x, arm * arm.y, arm * arm.z);
            let turning = movers[body].inertia();
            inertia += turning + (DMat3::from_diagonal(DVec3::splat(arm.length_squared())) - outer) * own;
            angular += turning * movers[body].spin + own * arm.cross(movers[body].velocity - velocity);
        }
        let spin = if turns { inertia.inverse() * angular } else { DVec3::ZERO };
        Carrier { place, velocity, spin: if spin.is_finite() { spin } else { DVec3::ZERO } }
    }

    /// Velocity and spin of a body carried at a place.
    fn motion(&self, place: DVec3) -> Motion {
        (self.velocity + self.spin.cross(place - self.place), self.spin)
    }

    /// Velocity and spin of a body whose motion relative to this one is slowed to a share.
    fn slowed(&self, body: usize, movers: &[Mover], bodies: &[BodyState], share: f64) -> Motion {
        let (velocity, spin) = self.motion(bodies[body].mid_position);
        let own = &movers[body];
        (velocity + share * (own.velocity - velocity), spin + share * (own.spin - spin))
    }

    /// Kinetic energy of a body relative to this motion \[J\].
    fn energy(&self, body: usize, movers: &[Mover], bodies: &[BodyState]) -> f64 {
        let (velocity, spin) = self.motion(bodies[body].mid_position);
        let own = &movers[body];
        let turning = own.spin - spin;
        0.5 * own.mass() * (own.velocity - velocity).length_squared()
            + 0.5 * turning.dot(own.inertia() * turning)
    }
}
