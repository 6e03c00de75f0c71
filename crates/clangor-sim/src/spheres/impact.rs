//! Simultaneous impacts of everything that touches at one instant, by generalized reflections (Smith,
//! Kaufman, Vouga, Tamstorf and Grinspun 2012, "Reflections on simultaneous impact").
//!
//! Of all contacts of a touching cluster only the approaching ones are solved together: λ ≥ 0 is the
//! inelastic impulse of least kinetic energy, M Δv = Nᵀλ with 0 ≤ λ ⊥ N v ≥ 0, and each contact gets (1 + e)
//! λ. Other contacts may then approach; rounds are repeated until none does. A single problem for the whole
//! cluster would spread the energy over a Newton's cradle. Solved pair by pair, the result of a symmetric
//! billiard break would depend on the order.
//!
//! Friction follows in each round: the tangential impulse that would stop the slip (2/7 of the momentum of a
//! sliding solid ball), limited to the Coulomb cone μ (1 + e) λ. Impulses act on hung balls through the
//! mobility (1 − Σ d dᵀ)/m, with d the directions of their rods; the rods take up the rest.

use clangor_core::material::PairCoefficients;
use glam::DVec3;

use super::tolerances::QUIET_SPEED;

/// Rounds of reflections after which the cluster is stopped without restitution.
const MAX_ROUNDS: usize = 500;
/// Approach, relative to that of the first round, that is stopped without restitution. It ends an infinite
/// sequence of ever weaker rounds, as for three touching balls with e < 1 in a row.
const FADED: f64 = 1e-8;
/// Sweeps of the iterations inside a round.
const MAX_SWEEPS: usize = 200;
/// Sweeps for a cluster that is brought to a stop; the remaining velocities are stopped at the next impact.
const STOP_SWEEPS: usize = 30;
/// Relative change at which the sweeps end.
const CONVERGED: f64 = 1e-14;

/// A ball (or plane) of a cluster.
#[derive(Clone, Debug)]
pub(super) struct Member {
    /// Velocity of the centre \[m/s\].
    pub(super) velocity: DVec3,
    /// Angular velocity \[rad/s\].
    pub(super) omega: DVec3,
    /// 1/m \[1/kg\]; 0 for bodies that contacts do not move.
    pub(super) inverse_mass: f64,
    /// 1/I \[1/(kg m²)\].
    pub(super) inverse_inertia: f64,
    /// Orthonormal directions in which rods hold it; zero where there is none.
    pub(super) held: [DVec3; 2],
    /// Reaction impulse of the rods \[N s\].
    pub(super) rod_impulse: DVec3,
    /// Whether an impulse has acted on it.
    pub(super) moved: bool,
}

/// Two members in touch.
#[derive(Clone, Debug)]
pub(super) struct Touch {
    /// First member.
    pub(super) a: usize,
    /// Second member.
    pub(super) b: usize,
    /// From b to a.
    pub(super) normal: DVec3,
    /// From the centre of a to the point \[m\].
    pub(super) arm_a: DVec3,
    /// From the centre of b to the point \[m\]; unused if b does not move.
    pub(super) arm_b: DVec3,
    /// e, μ of the pair.
    pub(super) coefficients: PairCoefficients,
    /// Rebounds slower than this \[m/s\] are lasting contact.
    pub(super) slow: f64,
    /// Treatment of a slow rebound.
    pub(super) when_slow: Slow,
    /// Least separation speed \[m/s\]; it corrects the overlap of a lasting contact.
    pub(super) lift: f64,
}

/// How an inelastic sequence of bounces ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Slow {
    /// The normal velocity becomes zero; a plane then supports the ball.
    Stay,
    /// The rebound has the speed `slow`, if the approach was as fast: impacts without a support then follow
    /// each other at intervals of CONTACT_TIME, not ever faster.
    Hop,
}

/// Impulse of one touch in one round, on a, and its opposite on b.
#[derive(Clone, Copy, Debug)]
pub(super) struct ImpulsePair {
    /// Index of the touch.
    pub(super) touch: usize,
    /// Normal impulse on a \[N s\].
    pub(super) normal: f64,
    /// Tangential impulse on a \[N s\].
    pub(super) tangential: DVec3,
    /// Velocity of a relative to b at the point before the round \[m/s\].
    pub(super) velocity: DVec3,
}

impl Member {
    /// A body at rest that contacts do not move.
    pub(super) const IMMOVABLE: Member = Member {
        velocity: DVec3::ZERO,
        omega: DVec3::ZERO,
        inverse_mass: 0.0,
        inverse_inertia: 0.0,
        held: [DVec3::ZERO; 2],
        rod_impulse: DVec3::ZERO,
        moved: false,
    };

    fn mobility(&self, impulse: DVec3) -> DVec3 {
        (impulse - self.along_rods(impulse)) * self.inverse_mass
    }

    fn along_rods(&self, impulse: DVec3) -> DVec3 {
        self.held[0] * self.held[0].dot(impulse) + self.held[1] * self.held[1].dot(impulse)
    }

    fn push(&mut self, impulse: DVec3, arm: DVec3) {
        self.velocity += self.mobility(impulse);
        self.omega += arm.cross(impulse) * self.inverse_inertia;
    }
}

impl Touch {
    pub(super) fn velocity(&self, members: &[Member]) -> DVec3 {
        let (a, b) = (&members[self.a], &members[self.b]);
        a.velocity + a.omega.cross(self.arm_a) - b.velocity - b.omega.cross(self.arm_b)
    }

    pub(super) fn normal_speed(&self, members: &[Member]) -> f64 {
        self.normal.dot(members[self.a].velocity - members[self.b].velocity)
    }

    fn push(&self, members: &mut [Member], impulse: DVec3) {
        members[self.a].push(impulse, self.arm_a);
        members[self.b].push(-impulse, self.arm_b);
    }

    /// Change of normal speed of this touch per unit impulse of another.
    fn coupling(&self, other: &Touch, members: &[Member]) -> f64 {
        let mut sum = 0.0;
        for (mine, sign) in [(self.a, 1.0), (self.b, -1.0)] {
            for (theirs, other_sign) in [(other.a, 1.0), (other.b, -1.0)] {
                if mine == theirs {
                    sum += sign * other_sign * self.normal.dot(members[mine].mobility(other.normal));
                }
            }
        }
        sum
    }

    fn restitution(&self, approach: f64) -> f64 {
        let e = self.coefficients.restitution.at(approach);
        if e * approach >= self.slow {
            return e;
        }
        match self.when_slow {
            Slow::Stay => 0.0,
            Slow::Hop => (self.slow / approach).clamp(e, 1.0),
        }
    }
}

/// Resolves a cluster: changes the velocities of the members and appends the impulses in the order in which
/// they act.
///
/// If no contact approaches faster than `stop_below` \[m/s\], the cluster is stopped without restitution.
pub(super) fn reflect(
    members: &mut [Member],
    touches: &[Touch],
    stop_below: f64,
    impulse_pairs: &mut Vec<ImpulsePair>,
) {
    match touches {
        [touch] if touch.lift == 0.0 => bounce(members, touch, impulse_pairs),
        _ => reflect_cluster(members, touches, stop_below, impulse_pairs),
    }
    note_rods(members, touches, impulse_pairs);
}

/// Notes which members the impulses have moved, and what their rods took up.
pub(super) fn note_rods(members: &mut [Member], touches: &[Touch], impulse_pairs: &[ImpulsePair]) {
    for impulse_pair in impulse_pairs {
        let touch = &touches[impulse_pair.touch];
        let impulse = touch.normal * impulse_pair.normal + impulse_pair.tangential;
        for (member, impulse) in [(touch.a, impulse), (touch.b, -impulse)] {
            let member = &mut members[member];
            member.moved |= member.inverse_mass > 0.0;
            member.rod_impulse -= member.along_rods(impulse);
        }
    }
}

/// Two bodies alone: one round, in closed form.
fn bounce(members: &mut [Member], touch: &Touch, impulse_pairs: &mut Vec<ImpulsePair>) {
    let speed = touch.normal_speed(members);
    let response = touch.coupling(touch, members);
    if speed >= -0.5 * QUIET_SPEED || response <= 0.0 {
        return;
    }
    let velocity = touch.velocity(members);
    let normal = (1.0 + touch.restitution(-speed)) * -speed / response;
    touch.push(members, touch.normal * normal);
    impulse_pairs.push(ImpulsePair { touch: 0, normal, tangential: DVec3::ZERO, velocity });
    apply_friction(impulse_pairs, std::slice::from_ref(touch), members);
}

fn reflect_cluster(
    members: &mut [Member],
    touches: &[Touch],
    stop_below: f64,
    impulse_pairs: &mut Vec<ImpulsePair>,
) {
    let (mut last, mut first_speed) = (false, 0.0);
    for round in 0..=MAX_ROUNDS {
        // Active contacts: those that approach.
        let mut active: Vec<usize> = (0..touches.len())
            .filter(|&k| touches[k].normal_speed(members) < -0.5 * QUIET_SPEED)
            .filter(|&k| touches[k].coupling(&touches[k], members) > 0.0)
            .collect();
        if active.is_empty() {
            break;
        }
        let fastest = active.iter().map(|&k| -touches[k].normal_speed(members)).fold(0.0, f64::max);
        if round == 0 {
            first_speed = fastest;
        }
        // The last round stops all contacts without restitution.
        last |= round == MAX_ROUNDS || fastest <= FADED * first_speed || fastest <= stop_below;
        if last {
            active =
                (0..touches.len()).filter(|&k| touches[k].coupling(&touches[k], members) > 0.0).collect();
        }
        // Inelastic impulses, then restitution.
        let speeds: Vec<f64> = active.iter().map(|&k| touches[k].normal_speed(members)).collect();
        let sweeps = if last { STOP_SWEEPS } else { MAX_SWEEPS };
        let lambda = least_energy(&active, &speeds, touches, members, sweeps);
        let mut restitution: Vec<f64> = active
            .iter()
            .zip(&speeds)
            .map(|(&k, v)| if last { 0.0 } else { touches[k].restitution(v.abs()) })
            .collect();
        // Unequal e may increase the energy; the smallest e never does.
        let least = restitution.iter().copied().fold(1.0, f64::min);
        if restitution.iter().any(|&e| e != least)
            && gains_energy(&active, &lambda, &restitution, touches, members)
        {
            restitution.fill(least);
        }
        // Apply normal impulses, then friction.
        let first = impulse_pairs.len();
        for (k, &touch) in active.iter().enumerate() {
            let normal = lambda[k] * (1.0 + restitution[k]);
            let velocity = touches[touch].velocity(members);
            impulse_pairs.push(ImpulsePair { touch, normal, tangential: DVec3::ZERO, velocity });
        }
        for impulse_pair in &impulse_pairs[first..] {
            let touch = &touches[impulse_pair.touch];
            touch.push(members, touch.normal * impulse_pair.normal);
        }
        apply_friction(&mut impulse_pairs[first..], touches, members);
        let settled = impulse_pairs[first..].iter().all(|pair| pair.normal == 0.0);
        impulse_pairs.retain(|pair| pair.normal > 0.0);
        if settled || last {
            break;
        }
    }
    if touches.iter().any(|t| t.lift > 0.0) {
        lift(members, touches, impulse_pairs);
    }
}

/// Separates overlapping members at the speeds `lift`; no other contact may approach as a result.
fn lift(members: &mut [Member], touches: &[Touch], impulse_pairs: &mut Vec<ImpulsePair>) {
    let active: Vec<usize> =
        (0..touches.len()).filter(|&k| touches[k].coupling(&touches[k], members) > 0.0).collect();
    let speeds: Vec<f64> =
        active.iter().map(|&k| touches[k].normal_speed(members) - touches[k].lift).collect();
    if speeds.iter().all(|&v| v >= 0.0) {
        return;
    }
    let lambda = least_energy(&active, &speeds, touches, members, STOP_SWEEPS);
    let first = impulse_pairs.len();
    for (&touch, &normal) in active.iter().zip(&lambda).filter(|(_, l)| **l > 0.0) {
        let velocity = touches[touch].velocity(members);
        impulse_pairs.push(ImpulsePair { touch, normal, tangential: DVec3::ZERO, velocity });
    }
    for impulse_pair in &impulse_pairs[first..] {
        let touch = &touches[impulse_pair.touch];
        touch.push(members, touch.normal * impulse_pair.normal);
    }
}

/// λ ≥ 0 with 0 ≤ λ ⊥ v + A λ ≥ 0. Gauss–Seidel finds the active contacts; elimination then gives their exact
/// impulses.
fn least_energy(
    active: &[usize],
    speeds: &[f64],
    touches: &[Touch],
    members: &[Member],
    sweeps: usize,
) -> Vec<f64> {
    let n = active.len();
    let matrix: Vec<f64> =
        (0..n * n).map(|at| touches[active[at / n]].coupling(&touches[active[at % n]], members)).collect();
    if n == 1 {
        return vec![(-speeds[0] / matrix[0]).max(0.0)];
    }
    let mut lambda = vec![0.0_f64; n];
    for _ in 0..sweeps {
        let (mut change, mut size) = (0.0_f64, 0.0_f64);
        for k in 0..n {
            let row = &matrix[k * n..(k + 1) * n];
            let speed = speeds[k] + row.iter().zip(&lambda).map(|(a, l)| a * l).sum::<f64>();
            let next = (lambda[k] - speed / row[k]).max(0.0);
            change = change.max((next - lambda[k]).abs());
            size = size.max(next);
            lambda[k] = next;
        }
        if change <= CONVERGED * size {
            break;
        }
    }
    polish(&matrix, speeds, &lambda).unwrap_or(lambda)
}

/// Solves the equations of the active contacts directly; `None` if they are redundant or the active set was
/// wrong.
fn polish(matrix: &[f64], speeds: &[f64], guess: &[f64]) -> Option<Vec<f64>> {
    let n = speeds.len();
    let acting: Vec<usize> = (0..n).filter(|&k| guess[k] > 0.0).collect();
    let m = acting.len();
    // [A | −v], eliminated without pivoting: A is symmetric and positive definite unless contacts are
    // redundant.
    let mut rows: Vec<Vec<f64>> = acting
        .iter()
        .map(|&k| acting.iter().map(|&l| matrix[k * n + l]).chain([-speeds[k]]).collect())
        .collect();
    for k in 0..m {
        if rows[k][k] <= 1e-10 * matrix[acting[k] * n + acting[k]] {
            return None;
        }
        let pivot = rows[k].clone();
        for row in rows.iter_mut().skip(k + 1) {
            let factor = row[k] / pivot[k];
            for (x, p) in row.iter_mut().zip(&pivot).skip(k) {
                *x -= factor * p;
            }
        }
    }
    let mut exact = vec![0.0; n];
    for k in (0..m).rev() {
        let known: f64 = (k + 1..m).map(|l| rows[k][l] * exact[acting[l]]).sum();
        exact[acting[k]] = (rows[k][m] - known) / rows[k][k];
    }
    let scale = speeds.iter().fold(0.0_f64, |s, v| s.max(v.abs()));
    let parting = (0..n).all(|k| {
        let speed = speeds[k] + (0..n).map(|l| matrix[k * n + l] * exact[l]).sum::<f64>();
        speed >= -1e-9 * scale
    });
    (parting && exact.iter().all(|&l| l >= 0.0)).then_some(exact)
}

fn gains_energy(active: &[usize], lambda: &[f64], e: &[f64], touches: &[Touch], members: &[Member]) -> bool {
    let mut gain = 0.0;
    for (k, &touch) in active.iter().enumerate() {
        let change: f64 = (0..active.len())
            .map(|l| touches[touch].coupling(&touches[active[l]], members) * lambda[l] * (1.0 + e[l]))
            .sum();
        gain += lambda[k] * (1.0 + e[k]) * (touches[touch].normal_speed(members) + 0.5 * change);
    }
    gain > 0.0
}

/// Friction of one round: least kinetic energy within the Coulomb cones of the normal impulses, by
/// Gauss–Seidel.
fn apply_friction(impulse_pairs: &mut [ImpulsePair], touches: &[Touch], members: &mut [Member]) {
    for _ in 0..MAX_SWEEPS {
        let (mut change, mut size) = (0.0_f64, 0.0_f64);
        for impulse_pair in impulse_pairs.iter_mut() {
            let touch = &touches[impulse_pair.touch];
            let limit = touch.coefficients.friction * impulse_pair.normal;
            if limit == 0.0 {
                continue;
            }
            let (a, b) = (&members[touch.a], &members[touch.b]);
            let response = a.inverse_mass
                + b.inverse_mass
                + a.inverse_inertia * touch.arm_a.length_squared()
                + b.inverse_inertia * touch.arm_b.length_squared();
            let velocity = touch.velocity(members);
            let slip = velocity - touch.normal * touch.normal.dot(velocity);
            let wanted = impulse_pair.tangential - slip / response;
            let next = wanted.clamp_length_max(limit);
            let step = next - impulse_pair.tangential;
            touch.push(members, step);
            impulse_pair.tangential = next;
            change = change.max(step.length());
            // The accuracy of impulses is limited by that of the velocities.
            size = size.max(limit).max(0.1 * velocity.length() / response);
        }
        if change <= CONVERGED * size || impulse_pairs.len() == 1 {
            break;
        }
    }
}
