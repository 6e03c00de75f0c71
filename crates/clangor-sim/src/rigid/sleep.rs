//! Sleep: bodies that have been at rest together are not simulated until something touches them.
//!
//! Bodies that touch form an island. An island falls asleep when all its bodies have been slower than
//! [`SLEEP_SPEED`] for [`SLEEP_TIME`]. Their remaining momentum is removed and logged, so that the balance
//! holds. Contact with one body of an island wakes the whole island.

use clangor_core::body::BodyId;
use clangor_core::math::disjoint_sets::DisjointSets;
use clangor_core::timeline::{ContactKind, ContactRow};
use glam::DVec3;

use super::broad_phase::Neighbours;
use super::pair::{Pair, SLOP, Step};
use super::state::BodyState;
use super::step_log::{Impulse, StepLog};

/// Surface speed below which a body counts as at rest \[m/s\].
const SLEEP_SPEED: f64 = 3e-3;
/// Time at rest after which an island falls asleep \[s\].
const SLEEP_TIME: f64 = 0.1;

/// Updates how long each body has been at rest.
pub(super) fn update_quiet(bodies: &mut [BodyState], step: f64) {
    for body in bodies.iter_mut().filter(|b| b.is_awake()) {
        if body.surface_speed() < SLEEP_SPEED { body.quiet += step } else { body.quiet = 0.0 }
    }
}

/// Puts islands to sleep that have been at rest long enough; `restless` bodies keep their island awake.
pub(super) fn fall_asleep(
    bodies: &mut [BodyState],
    pairs: &[Pair],
    restless: &[bool],
    step: &Step,
    log: &mut StepLog,
) {
    // Twice the distance at which slow bodies wake each other, so that two islands cannot wake each other in
    // turns.
    let fall = step.gravity.length() * step.length * step.length;
    let near = 2.0 * (SLOP + 2.0 * SLEEP_SPEED * step.length + fall);
    let mut islands = DisjointSets::new(bodies.len());
    for pair in pairs.iter().filter(|p| p.live) {
        let (a, b) = (pair.key.a as usize, pair.key.b as usize);
        let both_free = bodies[a].is_free() && bodies[b].is_free();
        if both_free && pair.points.iter().any(|p| p.impulse_n > 0.0 || p.gap < near) {
            islands.join(a, b);
        }
    }
    let mut shortest = vec![f64::INFINITY; bodies.len()];
    for i in (0..bodies.len()).filter(|&i| bodies[i].is_free()) {
        let island = islands.root(i);
        let quiet = if restless[i] || bodies[i].grip().is_some() { 0.0 } else { bodies[i].quiet };
        shortest[island] = shortest[island].min(quiet);
    }
    for (i, body) in bodies.iter_mut().enumerate() {
        let island = islands.root(i);
        if !body.is_awake() || shortest[island] <= SLEEP_TIME {
            continue;
        }
        body.asleep = true;
        body.island = island;
        let row = ContactRow {
            time: step.time,
            body_a: BodyId(i as u32),
            body_b: BodyId::WORLD,
            kind: ContactKind::Sleep,
            point: body.position,
            normal: DVec3::Y,
            impulse_n: 0.0,
            impulse_t: body.velocity * -body.mass,
            couple: -body.momentum,
            velocity: body.velocity,
            depth: 0.0,
            impact_id: 0,
            effective_mass: None,
        };
        log.begin(ContactKind::Sleep);
        log.impulse(Impulse { row, arm_a: DVec3::ZERO, arm_b: DVec3::ZERO });
        log.end();
        body.stop();
    }
}

/// Wakes the sleeping bodies that moving bodies are about to touch in this step.
pub(super) fn wake_touched(
    bodies: &mut [BodyState],
    pairs: &mut [Pair],
    neighbours: &Neighbours,
    step: &Step,
) {
    loop {
        let touched = pairs.iter().find_map(|pair| {
            let (a, b) = pair.bodies(bodies);
            let sleeper = match (a.asleep && b.is_moving(), b.asleep && a.is_moving()) {
                (true, _) => pair.key.a,
                (_, true) => pair.key.b,
                _ => return None,
            };
            (pair.live && meets(pair, a, b, step)).then_some(sleeper as usize)
        });
        match touched {
            Some(body) => wake(bodies, body, pairs, neighbours, step),
            None => return,
        }
    }
}

/// Whether some point of the pair closes within the step.
fn meets(pair: &Pair, a: &BodyState, b: &BodyState, step: &Step) -> bool {
    let fall = step.gravity.length() * step.length * step.length;
    pair.points.iter().any(|point| {
        let speed = (a.velocity + a.angular_velocity.cross(point.arm_a)
            - b.velocity
            - b.angular_velocity.cross(point.arm_b))
        .dot(pair.normal);
        point.gap + speed.min(0.0) * step.length - fall < SLOP
    })
}

/// Wakes a body and its island, and measures their contacts in the present step.
pub(super) fn wake(
    bodies: &mut [BodyState],
    body: usize,
    pairs: &mut [Pair],
    neighbours: &Neighbours,
    step: &Step,
) {
    let island = bodies[body].island;
    let members: Vec<usize> =
        (0..bodies.len()).filter(|&i| bodies[i].asleep && bodies[i].island == island).collect();
    for &i in &members {
        bodies[i].asleep = false;
        bodies[i].quiet = 0.0;
        bodies[i].last_hit = 0.0;
    }
    for &i in &members {
        for &index in neighbours.of(i) {
            let pair = &mut pairs[index as usize];
            if pair.live {
                pair.hits = 0;
                pair.measure(bodies, step, 0.5 * step.length);
            }
        }
    }
}
