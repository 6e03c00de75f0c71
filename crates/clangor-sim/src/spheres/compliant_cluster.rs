//! Balls that press on each other: Hertz's forces in space, through the time of the contacts.
//!
//! ```text
//! m ẍ = m g + Σ n F + t      F = max(0, k d^{3/2} + γ(d) ḋ)      γ = α √(k m_r) d^{1/4}
//! ```
//!
//! d is the overlap along the line n between the centres, which turns as the balls move; m_r is the reduced
//! mass of the pair, α the damping that gives its restitution. Friction t is Coulomb's, at the point between
//! the surfaces: it stops the slip, within μ F. A plane that supports a ball is rigid: the ball stays at its
//! height as long as it is pressed down. Rods take up the impulse along them.
//!
//! One step changes velocities by impulses J and positions by the mean of the velocities at its two ends:
//!
//! ```text
//! v₁ = v₀ + h g + Σ J/m         x₁ = x₀ + h (v₀ + v₁)/2
//! J = h F (r₀ + r₁)/(|r₀| + |r₁|)      F = (Φ(d₁) − Φ(d₀))/(d₁ − d₀) + γ (d₁ − d₀)/h      Φ = 2/5 k d^{5/2}
//! ```
//!
//! with r₀, r₁ the offset of the centres at the two ends. The work of the elastic part is exactly the change
//! of Φ, and J acts along the mean offset: energy, momentum and angular momentum are kept to the tolerance of
//! the iteration whatever h. Friction opposes the mean slip, so it takes energy.
//!
//! Source: the discrete gradient of central forces is that of LaBudde and Greenspan (1974).
//!
//! Not covered: vibration of the balls, and their tangential compliance.

use glam::DVec3;

/// Sweeps over the contacts of one step at most; 6 to 8 are usual.
const MAX_SWEEPS: usize = 60;
/// Change of an impulse, over the largest of the step, at which the sweeps end.
const CONVERGED: f64 = 1e-11;

/// A ball, at the end of the last step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Mover {
    /// Centre \[m\].
    pub(super) position: DVec3,
    /// \[m/s\]
    pub(super) velocity: DVec3,
    /// Angular velocity \[rad/s\].
    pub(super) omega: DVec3,
    /// 1/m \[1/kg\]; 0 for a ball that nothing moves.
    pub(super) inverse_mass: f64,
    /// 1/I \[1/(kg m²)\].
    pub(super) inverse_inertia: f64,
    /// \[m\]
    pub(super) radius: f64,
    /// Orthonormal directions in which rods hold it; zero where there is none.
    pub(super) held: [DVec3; 2],
}

/// What a ball presses on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Partner {
    /// Another ball of the cluster.
    Ball(usize),
    /// Another ball, along a unit normal that does not turn.
    Along(usize, DVec3),
    /// A plane with this unit normal and offset n·x \[m\], which gives way.
    Plane(DVec3, f64),
    /// A rigid plane with this unit normal, on which the ball lies.
    Support(DVec3),
}

/// Law of a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PressLaw {
    /// k [N/m^{3/2}].
    pub(super) stiffness: f64,
    /// α √(k m_r) of the loss [N s/m^{5/4}].
    pub(super) damping: f64,
    /// μ.
    pub(super) friction: f64,
    /// Distance of the centres, or height over the plane, at which the surfaces meet \[m\].
    pub(super) reach: f64,
}

/// A contact, or a pair that may come into contact.
#[derive(Clone, Copy, Debug)]
pub(super) struct Press {
    /// The first ball.
    pub(super) ball: usize,
    /// What it presses on.
    pub(super) partner: Partner,
    /// Its law.
    pub(super) law: PressLaw,
    /// Impulse on the ball in the last step \[N s\].
    pub(super) impulse: DVec3,
    /// Its part along the normal \[N s\].
    pub(super) normal_impulse: f64,
    /// Unit normal towards the ball, and point, in the middle of the last step \[m\].
    pub(super) normal: DVec3,
    pub(super) point: DVec3,
    /// Mean overlap in the last step \[m\].
    pub(super) depth: f64,
    /// Overlap at the end of the last step \[m\]; negative for a gap.
    pub(super) overlap: f64,
    /// Rate of the overlap in the last step \[m/s\].
    pub(super) closing: f64,
    /// Angular impulses on the ball and on its partner in the last step \[N m s\].
    turns: [DVec3; 2],
}

impl Partner {
    /// The other ball.
    pub(super) fn ball(&self) -> Option<usize> {
        match *self {
            Partner::Ball(other) | Partner::Along(other, _) => Some(other),
            Partner::Plane(..) | Partner::Support(_) => None,
        }
    }
}

impl Mover {
    /// Change of velocity by an impulse, of which rods take their part.
    fn given(&self, impulse: DVec3) -> DVec3 {
        let along = self.held[0] * self.held[0].dot(impulse) + self.held[1] * self.held[1].dot(impulse);
        (impulse - along) * self.inverse_mass
    }
}

impl Press {
    pub(super) fn new(ball: usize, partner: Partner, law: PressLaw, overlap: f64) -> Self {
        Press {
            ball,
            partner,
            law,
            impulse: DVec3::ZERO,
            normal_impulse: 0.0,
            normal: DVec3::ZERO,
            point: DVec3::ZERO,
            depth: 0.0,
            overlap,
            closing: 0.0,
            turns: [DVec3::ZERO; 2],
        }
    }
}

/// A pair in the middle of a step.
struct Middle {
    /// Unit normal, towards the ball.
    normal: DVec3,
    /// Normal impulse \[N s\], and factor of the unit normal.
    pressure: f64,
    along: f64,
    /// From the centres to the common point \[m\].
    arms: [DVec3; 2],
    overlap: f64,
    closing: f64,
}

/// Balls and their contacts: see the module.
#[derive(Clone, Debug, Default)]
pub(super) struct CompliantCluster {
    pub(super) balls: Vec<Mover>,
    pub(super) presses: Vec<Press>,
    /// The balls at the start of the step.
    start: Vec<Mover>,
}

impl CompliantCluster {
    /// Advances by a step `h` \[s\] under gravity [m/s²].
    pub(super) fn step(&mut self, h: f64, gravity: DVec3) {
        self.start.clone_from(&self.balls);
        // First guess: the impulses of the last step.
        for ball in self.balls.iter_mut().filter(|ball| ball.inverse_mass > 0.0) {
            ball.velocity += gravity * h;
        }
        for k in 0..self.presses.len() {
            let Press { impulse, turns, .. } = self.presses[k];
            if impulse != DVec3::ZERO {
                self.push(k, impulse, turns);
            }
        }
        self.place(h);
        // Impulses by Gauss–Seidel, until none changes.
        for _ in 0..MAX_SWEEPS {
            let (mut change, mut size) = (0.0_f64, 0.0_f64);
            for k in 0..self.presses.len() {
                if self.stays_apart(&self.presses[k]) {
                    continue;
                }
                let (old, turns) = (self.presses[k].impulse, self.presses[k].turns);
                let (new, new_turns) = self.press(k, h);
                if new != old || new_turns != turns {
                    self.push(k, new - old, [new_turns[0] - turns[0], new_turns[1] - turns[1]]);
                    self.place_partners(k, h);
                }
                change = change.max((new - old).length());
                size = size.max(new.length());
            }
            if change <= CONVERGED * size {
                break;
            }
        }
        // Gaps of the pairs that the sweeps passed over.
        for k in 0..self.presses.len() {
            if self.stays_apart(&self.presses[k]) {
                self.press(k, h);
            }
        }
    }

    /// Whether two balls without an impulse between them are apart at both ends of the step: most pairs of a
    /// cluster, in most steps.
    fn stays_apart(&self, press: &Press) -> bool {
        let Partner::Ball(other) = press.partner else { return false };
        let squared = |balls: &[Mover]| balls[press.ball].position.distance_squared(balls[other].position);
        let touching = press.law.reach * press.law.reach;
        press.impulse == DVec3::ZERO && squared(&self.start) > touching && squared(&self.balls) > touching
    }

    /// Adds impulses to the ball of a contact, and their opposites to its partner.
    fn push(&mut self, k: usize, impulse: DVec3, turns: [DVec3; 2]) {
        let Press { ball, partner, .. } = self.presses[k];
        let a = &mut self.balls[ball];
        a.velocity += a.given(impulse);
        a.omega += turns[0] * a.inverse_inertia;
        if let Some(other) = partner.ball() {
            let b = &mut self.balls[other];
            b.velocity -= b.given(impulse);
            b.omega += turns[1] * b.inverse_inertia;
        }
    }

    /// Positions at the end of the step, by the mean of the velocities.
    fn place(&mut self, h: f64) {
        for (ball, start) in self.balls.iter_mut().zip(&self.start) {
            ball.position = start.position + (start.velocity + ball.velocity) * (0.5 * h);
        }
    }

    fn place_partners(&mut self, k: usize, h: f64) {
        let Press { ball, partner, .. } = self.presses[k];
        let mut place = |at: usize| {
            let start = &self.start[at];
            self.balls[at].position = start.position + (start.velocity + self.balls[at].velocity) * (0.5 * h);
        };
        place(ball);
        if let Some(other) = partner.ball() {
            place(other);
        }
    }

    /// The impulse of a contact and its angular impulses on both balls, as the step now ends.
    fn press(&mut self, k: usize, h: f64) -> (DVec3, [DVec3; 2]) {
        let press = self.presses[k];
        let middle = self.middle(&press, h);
        let Middle { normal, pressure, along, arms: [arm, far_arm], overlap, closing } = middle;
        let far_radius = press.partner.ball().map_or(0.0, |other| self.balls[other].radius);
        let depth = self.balls[press.ball].radius + far_radius - arm.length() - far_arm.length();
        let mut tangential = DVec3::ZERO;
        // Surfaces that are apart in the mean, in the first and last step of a contact, do not rub.
        let apart = matches!(press.partner, Partner::Ball(_)) && depth < 0.0;
        let limit = if apart { 0.0 } else { press.law.friction * pressure };
        if limit > 0.0 {
            // The tangential impulse that stops the mean slip, within Coulomb's cone.
            let (slip, response) = self.slip(&press, arm, far_arm);
            let slip = slip - normal * normal.dot(slip);
            let known = press.impulse - normal * normal.dot(press.impulse);
            tangential = (known - slip * (2.0 / response)).clamp_length_max(limit);
        }
        let press = &mut self.presses[k];
        press.depth = depth;
        press.impulse = normal * (along * pressure) + tangential;
        press.turns = [arm.cross(tangential), -far_arm.cross(tangential)];
        (press.normal, press.normal_impulse) = (normal, pressure);
        press.point = 0.5 * (self.start[press.ball].position + self.balls[press.ball].position) + arm;
        (press.overlap, press.closing) = (overlap, closing);
        (press.impulse, press.turns)
    }

    /// Normal impulse and geometry of a contact in the middle of the step.
    fn middle(&self, press: &Press, h: f64) -> Middle {
        let (start, end) = (&self.start[press.ball], &self.balls[press.ball]);
        let PressLaw { reach, .. } = press.law;
        match press.partner {
            Partner::Ball(other) => {
                let (from, to) = (&self.start[other], &self.balls[other]);
                let (before, after) = (start.position - from.position, end.position - to.position);
                let (r0, r1) = (before.length(), after.length());
                let mean = 0.5 * (before + after);
                let length = mean.length();
                let share = start.radius / (start.radius + from.radius);
                let normal = mean / length.max(f64::MIN_POSITIVE);
                let (pressure, closing) = pressure(&press.law, [reach - r0, reach - r1], h);
                let along = 2.0 * length / (r0 + r1);
                let arms = [mean * -share, mean * (1.0 - share)];
                Middle { normal, pressure, along, arms, overlap: reach - r1, closing }
            }
            Partner::Along(other, normal) => {
                let (from, to) = (&self.start[other], &self.balls[other]);
                let distances = [(start, from), (end, to)].map(|(a, b)| normal.dot(a.position - b.position));
                let (pressure, closing) = pressure(&press.law, distances.map(|r| reach - r), h);
                let arms = [normal * -start.radius, normal * from.radius];
                Middle { normal, pressure, along: 1.0, arms, overlap: reach - distances[1], closing }
            }
            Partner::Plane(normal, offset) => {
                let [r0, r1] = [start, end].map(|ball| normal.dot(ball.position) - offset);
                let (pressure, closing) = pressure(&press.law, [reach - r0, reach - r1], h);
                let arms = [normal * -start.radius, DVec3::ZERO];
                Middle { normal, pressure, along: 1.0, arms, overlap: reach - r1, closing }
            }
            Partner::Support(normal) => {
                // The impulse that leaves the ball at its height.
                let pressure = press.normal_impulse - normal.dot(end.velocity) / end.inverse_mass;
                let arms = [normal * -start.radius, DVec3::ZERO];
                let pressure = pressure.max(0.0);
                Middle { normal, pressure, along: 1.0, arms, overlap: 0.0, closing: 0.0 }
            }
        }
    }

    /// Mean slip of the surfaces at the common point \[m/s\], and its change per unit impulse [1/kg].
    fn slip(&self, press: &Press, arm: DVec3, far_arm: DVec3) -> (DVec3, f64) {
        let motion = |at: usize, arm: DVec3| {
            let (from, to) = (&self.start[at], &self.balls[at]);
            let turn = 0.5 * (from.omega + to.omega);
            let response = to.inverse_mass + to.inverse_inertia * arm.length_squared();
            (0.5 * (from.velocity + to.velocity) + turn.cross(arm), response)
        };
        let (velocity, response) = motion(press.ball, arm);
        match press.partner.ball() {
            Some(other) => {
                let (far, far_response) = motion(other, far_arm);
                (velocity - far, response + far_response)
            }
            None => (velocity, response),
        }
    }
}

/// Normal impulse \[N s\] of overlaps before and after a step, and the rate of the overlap \[m/s\].
fn pressure(law: &PressLaw, [before, after]: [f64; 2], h: f64) -> (f64, f64) {
    let closing = (after - before) / h;
    if before <= 0.0 && after <= 0.0 {
        return (0.0, closing);
    }
    // 2/5 k (b⁵ − a⁵)/(b² − a²) with a, b the roots of the overlaps, without cancellation.
    let elastic = if before > 0.0 && after > 0.0 {
        let (a, b) = (before.sqrt(), after.sqrt());
        let (a2, b2) = (before, after);
        0.4 * (a2 * a2 + a2 * a * b + a2 * b2 + a * b * b2 + b2 * b2) / (a + b)
    } else {
        let deep = before.max(after);
        0.4 * deep * deep * deep.sqrt() / (after - before).abs()
    };
    let mean = 0.5 * (before.max(0.0) + after.max(0.0));
    let damped = law.damping * mean.sqrt().sqrt() * closing;
    ((law.stiffness * elastic + damped).max(0.0) * h, closing)
}
