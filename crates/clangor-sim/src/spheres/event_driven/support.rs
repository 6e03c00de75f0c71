//! Lasting contact of a ball with planes: sliding, rolling, spinning, rest.
//!
//! On one plane with normal n, N = m g_n, inertia I = β m r² (β = 2/5 when solid), slip u = v + ω × (−r n):
//! * sliding: friction −μ N û, so v̇ = g_t − μ g_n û and u̇ = g_t − μ g_n (1 + 1/β) û. A ball thrown flat at
//!   v₀ slides for u/u̇ = (2/7) v₀/(μ g), then rolls at (5/7) v₀;
//! * rolling: v̇ = (g_t − (ρ g_n/r) v̂)/(1 + β), ω = n × v/r, with the rolling-loss couple ρ N; it stops
//!   after v²·(1 + β) r/(2 ρ g), and stays where |g_t| r ≤ ρ g_n;
//! * spinning about n is slowed by the couple ρ N as well; sliding without friction is not slowed by
//!   anything.
//!
//! These are solved in closed form where force and motion share a line (every horizontal plane, every slope
//! without cross motion). Where the direction of motion changes on a slope, the direction of the loss is held
//! over pieces that end when the speed has changed by [`PIECE`], with the direction of the piece's middle,
//! and the last piece ends exactly at zero. The loss couple is cut to what friction can turn into rolling.
//!
//! A ball pressed against two or three planes (a groove, a corner) has no closed form: it moves with constant
//! forces over steps of [`WEDGE_STEP`], each solved so that the ball enters no plane and the forces stay in
//! their friction cones. Forces are constant within every phase, so the impulses of the log are exact.

use glam::DVec3;

use crate::spheres::tolerances::{QUIET_ACCELERATION, QUIET_SPEED};

/// Relative change of speed over a piece of a turning motion.
const PIECE: f64 = 0.02;
/// A turning motion whose remaining change of direction is below this ends in one last piece \[rad\].
const CLOSING: f64 = 1e-3;
/// A slower slip or speed counts as zero \[m/s\].
const STOPPED: f64 = 1e-13;
/// Step of a ball wedged between planes \[s\].
const WEDGE_STEP: f64 = 1e-4;

/// A plane that a ball touches.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ground {
    /// Which plane.
    pub(super) plane: usize,
    /// Its outward normal.
    pub(super) normal: DVec3,
    /// Friction coefficient μ of the pair.
    pub(super) friction: f64,
    /// Rolling loss length ρ of the pair \[m\].
    pub(super) rolling_loss: f64,
}

/// Force of one plane on a ball, constant over a phase.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reaction {
    /// The plane.
    pub(super) ground: Ground,
    /// Normal force \[N\].
    pub(super) normal: f64,
    /// Friction \[N\].
    pub(super) tangential: DVec3,
    /// Rolling-loss couple \[N m\].
    pub(super) couple: DVec3,
}

/// Quantity that is exactly zero at the end of a phase.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum End {
    /// Nothing in particular.
    Open,
    /// The slip: the ball rolls from then on.
    Slip,
    /// The velocity.
    Speed,
    /// The spin about the normal.
    Spin,
}

/// A phase of lasting contact.
#[derive(Clone, Debug)]
pub(super) struct Phase {
    /// Acceleration of the centre \[m/s²\].
    pub(super) acceleration: DVec3,
    /// Angular acceleration \[rad/s²\].
    pub(super) alpha: DVec3,
    /// Forces; none in flight.
    pub(super) reactions: Vec<Reaction>,
    /// Duration \[s\].
    pub(super) duration: f64,
    /// Condition at its end.
    pub(super) end: End,
}

/// The ball on the ground.
#[derive(Clone, Copy, Debug)]
pub(super) struct State {
    /// Radius \[m\].
    pub(super) radius: f64,
    /// Mass \[kg\].
    pub(super) mass: f64,
    /// Moment of inertia \[kg m²\].
    pub(super) inertia: f64,
    /// Velocity of the centre \[m/s\].
    pub(super) velocity: DVec3,
    /// Angular velocity \[rad/s\].
    pub(super) omega: DVec3,
    /// Gravity \[m/s²\].
    pub(super) gravity: DVec3,
}

/// The phase that starts from a state in contact with `grounds`, with zero normal velocity to each.
///
/// Rounding errors of the state are removed: a slip or speed that should be zero becomes zero.
pub(super) fn phase(state: &mut State, grounds: &[Ground]) -> Phase {
    let pressing: Vec<Ground> =
        grounds.iter().copied().filter(|g| g.normal.dot(state.gravity) < -QUIET_ACCELERATION).collect();
    // The plane that presses hardest is sufficient if it keeps the ball out of the others.
    let hardest =
        pressing.iter().min_by(|a, b| a.normal.dot(state.gravity).total_cmp(&b.normal.dot(state.gravity)));
    let Some(&ground) = hardest else { return flight(state.gravity) };
    let before = *state;
    let alone = on_one(state, ground);
    let enters =
        |g: &Ground| g.plane != ground.plane && alone.acceleration.dot(g.normal) < -QUIET_ACCELERATION;
    if !grounds.iter().any(enters) {
        return alone;
    }
    *state = before;
    wedged(state, grounds)
}

/// The phase of a ball in free flight.
pub(super) fn flight(gravity: DVec3) -> Phase {
    Phase {
        acceleration: gravity,
        alpha: DVec3::ZERO,
        reactions: Vec::new(),
        duration: f64::INFINITY,
        end: End::Open,
    }
}

/// Sets to zero the quantity that a phase has brought to zero up to rounding.
pub(super) fn finish(state: &mut State, ground: &Ground, end: End) {
    let n = ground.normal;
    match end {
        End::Open => {}
        End::Slip => roll(state, n, state.omega.dot(n)),
        End::Speed => {
            state.velocity = DVec3::ZERO;
            state.omega = n * state.omega.dot(n);
        }
        End::Spin => state.omega -= n * state.omega.dot(n),
    }
}

fn roll(state: &mut State, n: DVec3, spin: f64) {
    state.omega = n * spin + n.cross(state.velocity) / state.radius;
}

/// A speed that loses `loss` along its direction while `drive` acts: direction of the loss, duration, whether
/// the speed is zero at the end.
struct Slowing {
    direction: DVec3,
    duration: f64,
    stops: bool,
}

/// The next piece of u̇ = drive − loss û, for u ≠ 0. In the last one the loss may differ from `loss` by
/// rounding.
fn slow_down(u: DVec3, drive: DVec3, loss: f64) -> Slowing {
    let speed = u.length();
    let direction = u / speed;
    let across = drive - direction * drive.dot(direction);
    if across.length() <= 1e-12 * (drive.length() + loss) {
        let rate = loss - drive.dot(direction);
        let duration = if rate > 0.0 { speed / rate } else { f64::INFINITY };
        return Slowing { direction, duration, stops: rate > 0.0 };
    }
    // The direction d of a constant loss that stops it: u + (drive − loss d) τ = 0 with |d| = 1.
    let excess = loss * loss - drive.length_squared();
    if excess > 0.0 {
        let along = u.dot(drive);
        let duration = (along + (along * along + excess * speed * speed).sqrt()) / excess;
        let closing = (u / duration + drive) / loss;
        if closing.angle_between(direction) < CLOSING || speed < 1e-9 {
            return Slowing { direction: closing, duration, stops: true };
        }
    }
    let duration = PIECE * speed / (loss + drive.length());
    let middle = u + (drive - direction * loss) * (0.5 * duration);
    Slowing { direction: middle.normalize_or(direction), duration, stops: false }
}

fn on_one(state: &mut State, ground: Ground) -> Phase {
    let (n, r, m) = (ground.normal, state.radius, state.mass);
    let beta = state.inertia / (m * r * r);
    let g_n = -state.gravity.dot(n);
    let g_t = state.gravity + n * g_n;
    let g_t = if g_t.length() <= 1e-14 * g_n { DVec3::ZERO } else { g_t };
    state.velocity -= n * state.velocity.dot(n);
    // Slip at the contact point, and the largest deceleration by friction.
    let grip = ground.friction * g_n;
    let slip = state.velocity - state.omega.cross(n) * r;
    let reach = state.velocity.length() + state.omega.length() * r;
    let spin = state.omega.dot(n);

    // Without friction, sliding, or rolling and spinning.
    let mut couple = DVec3::ZERO;
    let (acceleration, duration, end);
    if grip == 0.0 {
        (acceleration, duration, end) = (g_t, f64::INFINITY, End::Open);
    } else if slip.length() > STOPPED + 1e-12 * reach {
        let slowing = slow_down(slip, g_t, grip * (1.0 + 1.0 / beta));
        acceleration = g_t - slowing.direction * grip;
        duration = slowing.duration;
        end = if slowing.stops { End::Slip } else { End::Open };
    } else {
        let spin = if spin.abs() * r <= STOPPED + 1e-12 * reach { 0.0 } else { spin };
        roll(state, n, spin);
        let speed = state.velocity.length();
        let longest = ground.friction * r * (1.0 + beta);
        let loss = ground.rolling_loss.min(longest) * g_n / r;
        let (mut pull, mut lasts, mut then) = (DVec3::ZERO, f64::INFINITY, End::Open);
        if speed > STOPPED {
            let slowing = slow_down(state.velocity, g_t / (1.0 + beta), loss / (1.0 + beta));
            pull = (g_t - slowing.direction * loss) / (1.0 + beta);
            lasts = slowing.duration;
            then = if slowing.stops { End::Speed } else { End::Open };
        } else {
            state.velocity = DVec3::ZERO;
            state.omega = n * spin;
            if g_t.length() > loss {
                pull = (g_t - g_t.normalize() * loss) / (1.0 + beta);
            }
        }
        // Rolling needs this friction; if it exceeds the friction cone, the ball slips along the slope.
        if (pull - g_t).length() > grip * (1.0 + 1e-12) {
            let down = (g_t - pull).normalize();
            (acceleration, duration, end) = (g_t - down * grip, f64::INFINITY, End::Open);
        } else {
            let twist = m * ground.rolling_loss * g_n * spin.signum() / state.inertia;
            let mut alpha = n.cross(pull) / r;
            if twist != 0.0 && spin != 0.0 {
                alpha -= n * twist;
                let until = spin / twist;
                if until < lasts {
                    (lasts, then) = (until, End::Spin);
                }
            }
            let friction = (pull - g_t) * m;
            couple = alpha * state.inertia + n.cross(friction) * r;
            (acceleration, duration, end) = (pull, lasts, then);
        }
    }
    // Friction force and angular acceleration that belong to the motion.
    let tangential = (acceleration - g_t) * m;
    let alpha = (couple - n.cross(tangential) * r) / state.inertia;
    let reaction = Reaction { ground, normal: m * g_n, tangential, couple };
    Phase { acceleration, alpha, reactions: vec![reaction], duration, end }
}

/// One step between several planes: normal and friction impulses by Gauss–Seidel, spread evenly over the
/// step.
fn wedged(state: &mut State, grounds: &[Ground]) -> Phase {
    let (r, m, h) = (state.radius, state.mass, WEDGE_STEP);
    let mut velocity = state.velocity + state.gravity * h;
    let mut omega = state.omega;
    let mut reactions: Vec<Reaction> = grounds
        .iter()
        .map(|&ground| Reaction { ground, normal: 0.0, tangential: DVec3::ZERO, couple: DVec3::ZERO })
        .collect();
    let response = 1.0 / m + r * r / state.inertia;
    for _ in 0..200 {
        let mut change = 0.0_f64;
        for reaction in &mut reactions {
            // Normal impulse: no approach.
            let n = reaction.ground.normal;
            let normal = (reaction.normal - m * velocity.dot(n)).max(0.0);
            velocity += n * ((normal - reaction.normal) / m);
            change = change.max((normal - reaction.normal).abs());
            reaction.normal = normal;

            // Friction: no slip, within the cone.
            let slip = velocity - n * velocity.dot(n) - omega.cross(n) * r;
            let limit = reaction.ground.friction * normal;
            let tangential = (reaction.tangential - slip / response).clamp_length_max(limit);
            let step = tangential - reaction.tangential;
            velocity += step / m;
            omega -= n.cross(step) * (r / state.inertia);
            change = change.max(step.length());
            reaction.tangential = tangential;

            // Rolling loss: no rotation, within its bound.
            let limit = reaction.ground.rolling_loss * normal;
            let couple = (reaction.couple - omega * state.inertia).clamp_length_max(limit);
            omega += (couple - reaction.couple) / state.inertia;
            change = change.max((couple - reaction.couple).length() / r);
            reaction.couple = couple;
        }
        if change <= 1e-15 * m * state.gravity.length() * h {
            break;
        }
    }
    // The residual is far below the change of a step. At rest it is set to zero and the largest force takes
    // it up.
    let small = 1e-6 * state.gravity.length() * h;
    let still = |v: DVec3, w: DVec3| v.length() + w.length() * r <= small;
    let rests = still(state.velocity, state.omega) && still(velocity, omega);
    let heaviest = (0..reactions.len()).max_by(|&a, &b| reactions[a].normal.total_cmp(&reactions[b].normal));
    if rests && let Some(heaviest) = heaviest {
        let reaction = &mut reactions[heaviest];
        let n = reaction.ground.normal;
        let push = (state.velocity - velocity) * m;
        reaction.normal += push.dot(n);
        let tangential = push - n * push.dot(n);
        reaction.tangential += tangential;
        reaction.couple += (state.omega - omega) * state.inertia + n.cross(tangential) * r;
        (velocity, omega) = (state.velocity, state.omega);
    }
    // Impulses become constant forces.
    for reaction in &mut reactions {
        reaction.normal /= h;
        reaction.tangential /= h;
        reaction.couple /= h;
    }
    reactions.retain(|r| r.normal > 0.0);
    Phase {
        acceleration: (velocity - state.velocity) / h,
        alpha: (omega - state.omega) / h,
        reactions,
        duration: if rests { f64::INFINITY } else { h },
        end: End::Open,
    }
}

/// Whether a normal speed counts as neither approaching nor leaving a plane.
pub(super) fn in_touch(normal_speed: f64) -> bool {
    normal_speed.abs() <= 10.0 * QUIET_SPEED
}
