//! Lasting contacts of a step: impulses that prevent overlap, with friction and rolling loss.
//!
//! Unknown are the velocities v′ at the end of the step. With λ the impulse along the normal n of a contact
//! and g h what gravity adds, M v′ = M (v + g h) + Σ impulses, where
//! * λ ≥ 0 and n·(v′ₐ − v′ᵦ) ≥ −gap/h: at the end of the step they may just touch;
//! * friction of at most μ λ opposes the slip, a couple of at most ρ λ the relative rotation (rolling and
//!   spinning).
//!
//! Projected Gauss-Seidel finds them (sequential impulses: Moreau 1988, Catto 2005), from the impulses of the
//! step before with pairs ordered bottom-up, until no velocity changes by more than [`TOLERANCE`] g h. Each
//! sweep lowers the kinetic energy, whose minimum under these bounds is the solution. If the impulses of the
//! step before raise it, they are discarded.
//!
//! Remaining overlap is corrected in position only: most of the part beyond [`SLOP`] in each step.

use clangor_core::timeline::{ContactKind, ContactRow};
use glam::DVec3;

use super::neighbours::Hold;
use super::{PLANE, Stepped};
use crate::SimulationError;
use crate::record::Recorder;

/// Change of a velocity, relative to g h, at which the sweeps end.
const TOLERANCE: f64 = 0.02;
/// Fewest and most sweeps.
const SWEEPS: [u64; 2] = [2, 12];
/// Overlap that is not corrected, in units of g h².
const SLOP: f64 = 0.1;
/// Part of the overlap beyond it that one pass corrects, and number of passes in a step.
const CORRECTION: f64 = 0.5;
const CORRECTION_PASSES: usize = 3;

/// Velocities of a ball during the sweeps.
#[derive(Clone, Copy, Default)]
struct Mover {
    velocity: DVec3,
    omega: DVec3,
}

/// A lasting contact.
pub(super) struct Contact {
    pair: u32,
    /// Places among the movers; a plane has the last one.
    a: usize,
    b: usize,
    normal: DVec3,
    /// Least normal velocity after the step \[m/s\].
    target: f64,
    friction: f64,
    rolling_loss: f64,
    inverse_mass: [f64; 2],
    inverse_inertia: [f64; 2],
    radius: [f64; 2],
    /// Mass that resists along the normal and along the surface \[kg\], and moment of inertia that resists a
    /// couple.
    resists: [f64; 3],
    hold: Hold,
}

/// Buffers.
#[derive(Default)]
pub(super) struct Resting {
    pub(super) contacts: Vec<Contact>,
    movers: Vec<Mover>,
}

/// 1/x, and 0 for 0.
fn inverse(x: f64) -> f64 {
    if x > 0.0 { 1.0 / x } else { 0.0 }
}

impl Contact {
    /// Impulse and couple on A, and their opposites on B.
    fn push(&self, movers: &mut [Mover], impulse: DVec3, couple: DVec3) {
        // The arms are along the normal: r n × j is the same for both.
        let turn = self.normal.cross(impulse);
        let a = &mut movers[self.a];
        a.velocity += impulse * self.inverse_mass[0];
        a.omega += (couple - turn * self.radius[0]) * self.inverse_inertia[0];
        let b = &mut movers[self.b];
        b.velocity -= impulse * self.inverse_mass[1];
        b.omega -= (couple + turn * self.radius[1]) * self.inverse_inertia[1];
    }

    /// One round. Returns the largest change of a velocity \[m/s\].
    fn relax(&mut self, movers: &mut [Mover]) -> f64 {
        let (a, b) = (movers[self.a], movers[self.b]);
        let approach = self.normal.dot(a.velocity - b.velocity);
        let normal = (self.hold.normal + (self.target - approach) * self.resists[0]).max(0.0);
        let step = normal - self.hold.normal;
        self.hold.normal = normal;
        if normal == 0.0 && self.hold.tangential == DVec3::ZERO && self.hold.couple == DVec3::ZERO {
            if step != 0.0 {
                self.push(movers, self.normal * step, DVec3::ZERO);
            }
            return step.abs() * inverse(self.resists[0]);
        }
        let spin = a.omega * self.radius[0] + b.omega * self.radius[1];
        let slip = a.velocity - b.velocity - self.normal * approach - spin.cross(self.normal);
        let wanted = self.hold.tangential - slip * self.resists[1];
        let tangential = clamped(wanted, self.friction * normal);
        let along = tangential - self.hold.tangential;
        self.hold.tangential = tangential;
        // The rotation that friction adds here is corrected in the next sweep.
        let wanted = self.hold.couple - (a.omega - b.omega) * self.resists[2];
        let couple = clamped(wanted, self.rolling_loss * normal);
        let twist = couple - self.hold.couple;
        self.hold.couple = couple;
        self.push(movers, self.normal * step + along, twist);
        step.abs().max(along.length()) * inverse(self.resists[0])
    }
}

fn clamped(vector: DVec3, most: f64) -> DVec3 {
    let square = vector.length_squared();
    if square <= most * most { vector } else { vector * (most / square.sqrt()) }
}

impl Stepped {
    /// Solves the lasting contacts and sets the paths of all balls. Returns the number of sweeps.
    pub(super) fn solve_resting(&mut self, recorder: &mut Recorder<'_>) -> Result<u64, SimulationError> {
        let fall = self.gravity * self.step;
        self.collect_contacts();
        let mut resting = std::mem::take(&mut self.resting);
        let Resting { contacts, movers } = &mut resting;
        movers.clear();
        movers.extend(self.balls.iter().map(|ball| {
            let moves = ball.moves();
            let still = Mover::default();
            if moves { Mover { velocity: ball.velocity + fall, omega: ball.omega } } else { still }
        }));
        movers.push(Mover::default());
        // Warm start with the impulses of the step before.
        let before = self.energy_of(contacts, movers);
        for contact in contacts.iter() {
            contact.push(
                movers,
                contact.normal * contact.hold.normal + contact.hold.tangential,
                contact.hold.couple,
            );
        }
        let slow = TOLERANCE * self.impact_speed();
        let mut sweeps = 0;
        let mut solve = |contacts: &mut [Contact], movers: &mut [Mover]| {
            for sweep in 1..=SWEEPS[1] {
                sweeps += 1;
                let change = contacts.iter_mut().map(|contact| contact.relax(movers)).fold(0.0, f64::max);
                if sweep >= SWEEPS[0] && change <= slow {
                    break;
                }
            }
        };
        // Solve; without warm start if it raised the energy.
        if !contacts.is_empty() {
            solve(contacts, movers);
            if self.energy_of(contacts, movers) > before {
                for (mover, ball) in movers.iter_mut().zip(&self.balls).filter(|(_, ball)| ball.moves()) {
                    *mover = Mover { velocity: ball.velocity + fall, omega: ball.omega };
                }
                contacts.iter_mut().for_each(|contact| contact.hold = Hold::default());
                solve(contacts, movers);
            }
        }
        // Balls without a loaded contact fly; the others move at their final velocities.
        for ball in self.balls.iter_mut().filter(|ball| ball.moves()) {
            ball.acceleration = self.gravity;
        }
        if !recorder.ignores_slow_contacts() {
            self.log(contacts, recorder)?;
        }
        for contact in contacts.iter() {
            self.neighbours.pairs[contact.pair as usize].hold = contact.hold;
            for at in [contact.a, contact.b] {
                if contact.hold.normal > 0.0
                    && let Some(ball) = self.balls.get_mut(at)
                    && ball.moves()
                {
                    (ball.velocity, ball.omega) = (movers[at].velocity, movers[at].omega);
                    ball.acceleration = DVec3::ZERO;
                }
            }
        }
        self.resting = resting;
        Ok(sweeps)
    }

    /// Collects the contacts: pairs that touch or nearly touch and approach more slowly than an impact.
    fn collect_contacts(&mut self) {
        let slowest = self.impact_speed();
        let near = slowest * self.step;
        let mut contacts = std::mem::take(&mut self.resting.contacts);
        contacts.clear();
        let plane_mover = self.balls.len();
        for index in 0..self.neighbours.pairs.len() {
            let pair = &self.neighbours.pairs[index];
            let (a, partner) = (pair.a as usize, pair.b);
            let one = &self.balls[a];
            let two = self.balls.get(partner as usize);
            if !one.moves() && !two.is_some_and(super::Ball::moves) {
                continue;
            }
            let hold = std::mem::take(&mut self.neighbours.pairs[index].hold);
            let two = self.balls.get(partner as usize);
            if let Some(two) = two {
                let reach = one.radius + two.radius + near;
                if one.position.distance_squared(two.position) > reach * reach {
                    continue;
                }
            }
            let (normal, depth) = self.normal(a, partner);
            if depth < -near {
                continue;
            }
            let moving = |ball: &super::Ball| if ball.moves() { ball.velocity } else { DVec3::ZERO };
            let approach = -normal.dot(moving(one) - two.map_or(DVec3::ZERO, moving));
            if approach >= slowest {
                continue;
            }
            let of = |ball: Option<&super::Ball>| match ball.filter(|ball| ball.moves()) {
                Some(ball) => [ball.inverse_mass, ball.inverse_inertia],
                None => [0.0; 2],
            };
            let ([ma, ia], [mb, ib]) = (of(Some(one)), of(two));
            let (ra, rb) = (one.radius, two.map_or(0.0, |ball| ball.radius));
            let coefficients = self.neighbours.pairs[index].coefficients;
            contacts.push(Contact {
                pair: index as u32,
                a,
                b: if partner & PLANE == 0 { partner as usize } else { plane_mover },
                normal,
                target: (depth / self.step).min(0.0),
                friction: coefficients.friction,
                rolling_loss: coefficients.rolling_loss,
                inverse_mass: [ma, mb],
                inverse_inertia: [ia, ib],
                radius: [ra, rb],
                resists: [inverse(ma + mb), inverse(ma + mb + ra * ra * ia + rb * rb * ib), inverse(ia + ib)],
                hold: Hold { tangential: hold.tangential - normal * normal.dot(hold.tangential), ..hold },
            });
        }
        self.resting.contacts = contacts;
    }

    /// Kinetic energy of the balls in contact \[J\].
    fn energy_of(&self, contacts: &[Contact], movers: &[Mover]) -> f64 {
        if contacts.is_empty() {
            return 0.0;
        }
        let moving = self.balls.iter().zip(movers).filter(|(ball, _)| ball.moves());
        moving
            .map(|(ball, mover)| {
                let spin = mover.omega.length_squared() / ball.inverse_inertia;
                0.5 * (ball.mass * mover.velocity.length_squared() + spin)
            })
            .sum()
    }

    /// Writes the impulses of the lasting contacts, before they have acted.
    fn log(&self, contacts: &[Contact], recorder: &mut Recorder<'_>) -> Result<(), SimulationError> {
        for contact in contacts.iter().filter(|contact| contact.hold.normal > 0.0) {
            let pair = &self.neighbours.pairs[contact.pair as usize];
            let one = &self.balls[contact.a];
            let (velocity, omega) = self
                .balls
                .get(contact.b)
                .map_or((DVec3::ZERO, DVec3::ZERO), |ball| (ball.velocity, ball.omega));
            let spin = one.omega * contact.radius[0] + omega * contact.radius[1];
            let row = ContactRow {
                time: self.now + self.step,
                body_a: self.body_of(pair.a),
                body_b: self.body_of(pair.b),
                kind: ContactKind::Contact,
                point: one.position - contact.normal * one.radius,
                normal: contact.normal,
                impulse_n: contact.hold.normal,
                impulse_t: contact.hold.tangential,
                couple: contact.hold.couple,
                velocity: one.velocity - velocity - spin.cross(contact.normal),
                depth: self.normal(contact.a, pair.b).1,
                impact_id: 0,
                effective_mass: None,
            };
            recorder.contact(&[row], &[])?;
        }
        Ok(())
    }

    /// Corrects the overlaps at the end of a step.
    pub(super) fn correct_overlaps(&mut self) {
        let slop = SLOP * self.impact_speed() * self.step;
        let count = self.resting.contacts.len();
        for index in (0..CORRECTION_PASSES).flat_map(|_| 0..count) {
            let contact = &self.resting.contacts[index];
            let pair = &self.neighbours.pairs[contact.pair as usize];
            let (normal, depth) = self.normal(contact.a, pair.b);
            if depth <= slop {
                continue;
            }
            let push = normal * (CORRECTION * (depth - slop) * contact.resists[0]);
            let (a, b, [ma, mb]) = (contact.a, contact.b, contact.inverse_mass);
            self.balls[a].position += push * ma;
            if let Some(ball) = self.balls.get_mut(b) {
                ball.position -= push * mb;
            }
        }
    }
}
