//! Which bodies may come near each other in a recording, or in a part of it.
//!
//! ```text
//! c: middle of the box of all frames      R = |half diagonal of the box| + 8 h (v + 2 g h) + 2 r + 1 mm
//! ```
//!
//! with the longest frame h, the largest speed v and the bounding radius r of a body. The ball (c, R) holds
//! the body in all states in which it is searched, which are continued past a frame by four at most, and half
//! of the widest gap that counts as a touch. Two bodies whose balls do not overlap are never compared, so
//! that the search grows with the number of neighbours and not with that of all pairs.
//!
//! No saving where bodies fly through each other's space: their balls are large, and all may be neighbours.

use std::ops::ControlFlow;

use clangor_core::body::{Body, BodyId};
use glam::DVec3;

use super::ball_pairs::{Ball, overlapping};
use super::kinematics::Kinematics;

/// Frames that a state may be continued past those that are there, twice.
const FRAMES: f64 = 8.0;
/// Factor on the bounding radius.
const RADII: f64 = 2.0;
/// Smallest gap on each side \[m\].
const GAP: f64 = 1e-3;
/// Most pairs that are kept: 8 bytes for each.
const MOST_PAIRS: usize = 5_000_000;

/// The neighbours of each body.
pub(super) struct Neighbours {
    /// In order of their numbers; `None` if there are too many to be kept.
    of_body: Option<Vec<Vec<u32>>>,
    bodies: u32,
}

impl Neighbours {
    /// Of bodies with these radii \[m\]; those without kinematics stand still or are led by keyframes.
    pub(super) fn of(bodies: &[Body], radii: &[f64], kinematics: &[Option<Kinematics<'_>>]) -> Self {
        let balls = bodies.iter().zip(radii).zip(kinematics).map(|((body, radius), kinematics)| {
            let reach = RADII * radius + GAP;
            match kinematics {
                Some(kinematics) => ball_of(kinematics, reach),
                None if body.motion.track().is_some() => {
                    Ball { centre: body.pose.position, radius: f64::INFINITY }
                }
                None => Ball { centre: body.pose.position, radius: reach },
            }
        });
        let balls: Vec<Ball> = balls.collect();
        let mut of_body = vec![Vec::new(); balls.len()];
        let mut count = 0;
        overlapping(&balls, &mut |[a, b]| {
            of_body[a].push(b as u32);
            of_body[b].push(a as u32);
            count += 1;
            if count > MOST_PAIRS { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        of_body.iter_mut().for_each(|own| own.sort_unstable());
        Neighbours { of_body: Some(of_body).filter(|_| count <= MOST_PAIRS), bodies: balls.len() as u32 }
    }

    /// Those of a body, in order of their numbers.
    pub(super) fn of_body(&self, body: usize) -> impl Iterator<Item = BodyId> {
        let known = self.of_body.as_ref().map(|known| known[body].iter().copied());
        let all = if known.is_none() { 0..self.bodies } else { 0..0 };
        let others = all.filter(move |other| *other as usize != body);
        known.into_iter().flatten().chain(others).map(BodyId)
    }
}

/// The ball around all frames of a body.
fn ball_of(kinematics: &Kinematics<'_>, reach: f64) -> Ball {
    let places = || kinematics.frames.iter().map(|frame| frame.pose.position);
    let low = places().fold(DVec3::INFINITY, DVec3::min);
    let high = places().fold(DVec3::NEG_INFINITY, DVec3::max);
    let speed = kinematics.intervals.iter().map(|interval| interval.velocity.length()).fold(0.0, f64::max);
    let span = kinematics.intervals.iter().map(|interval| interval.length).fold(0.0, f64::max);
    let fall = kinematics.inertia.gravity.length() * span;
    let radius = 0.5 * low.distance(high) + FRAMES * span * (speed + 2.0 * fall) + reach;
    Ball { centre: 0.5 * (low + high), radius }
}

#[cfg(test)]
mod tests {
    use std::time::Instant;

    use clangor_core::body::World;
    use clangor_core::material::presets::preset;
    use clangor_core::pose::Pose;
    use clangor_core::timeline::ContactRow;

    use super::*;
    use crate::motion::impacts::find_impacts;
    use crate::motion::recording::{Frame, RecordedBody};

    const G: f64 = 9.806_65;

    /// Impacts of balls 4 cm apart on a floor that bounce once, each at its own time.
    fn impacts(count: u32) -> Vec<ContactRow> {
        let steel = preset("steel").unwrap();
        let ball = |k: u32| Body::sphere(format!("ball-{k}"), steel.clone(), 0.01);
        let mut bodies: Vec<Body> = (0..count).map(ball).collect();
        bodies.push(Body::plane("floor", preset("granite").unwrap(), DVec3::ZERO, DVec3::Y));
        let recorded = (0..count).map(|k| {
            let hit = 0.03 + 0.05 * (f64::from(k) * 0.618_034).fract();
            let frame = |number: u32| {
                let t = f64::from(number) / 240.0 - hit;
                let speed = if t < 0.0 { -1.0 } else { 0.5 };
                let place = DVec3::new(f64::from(k % 100), 0.0, f64::from(k / 100)) * 0.04;
                let height = 0.01 + speed * t - 0.5 * G * t * t;
                Frame {
                    time: f64::from(number) / 240.0,
                    pose: Pose::at(place.with_y(height)),
                    row: number.into(),
                }
            };
            RecordedBody { body: BodyId(k), frames: (0..30).map(frame).collect(), group: None }
        });
        let recorded: Vec<RecordedBody> = recorded.collect();
        let world = World { bodies, links: Vec::new(), gravity: DVec3::NEG_Y * G };
        let start = Instant::now();
        let found = find_impacts(&world, &recorded, 0.05).contacts;
        println!("impacts of {count} balls take {:.0} ms", 1e3 * start.elapsed().as_secs_f64());
        found
    }

    #[test]
    fn balls_side_by_side_have_few_neighbours_and_each_its_impact() {
        let found = impacts(2000);
        assert_eq!(found.len(), 2000);
        let mut bodies: Vec<u32> = found.iter().map(|row| row.body_a.0.min(row.body_b.0)).collect();
        bodies.sort_unstable();
        assert_eq!(bodies, (0..2000).collect::<Vec<u32>>());
        let mass = Body::sphere("ball", preset("steel").unwrap(), 0.01).mass;
        let off = |row: &ContactRow| (row.impulse_n / (1.5 * mass) - 1.0).abs();
        let largest = found.iter().map(off).fold(0.0, f64::max);
        println!("impulses differ from 1.5 m/s m by {largest:.1e}");
        assert!(largest < 1e-6, "{largest}");
    }

    #[test]
    fn neighbours_are_those_that_come_near_and_what_moves_elsewhere() {
        let steel = preset("steel").unwrap();
        let at = |x: f64| Body::sphere("ball", steel.clone(), 0.01).at(DVec3::new(x, 0.0, 0.0));
        let bodies = [at(0.0), at(0.03), at(1.0), Body::plane("floor", steel.clone(), DVec3::ZERO, DVec3::Y)];
        let radii = [0.01, 0.01, 0.01, f64::INFINITY];
        let frames = |speed: f64| -> Vec<Frame> {
            let frame = |k: u32| {
                let time = f64::from(k) / 100.0;
                Frame { time, pose: Pose::at(DVec3::new(1.0 - speed * time, 0.0, 0.0)), row: 0 }
            };
            (0..100).map(frame).collect()
        };
        let of = |speed: f64, body: usize| -> Vec<u32> {
            let frames = frames(speed);
            let inertia = crate::motion::kinematics::Inertia::new(1.0, glam::DMat3::IDENTITY, DVec3::ZERO);
            let kinematics = [None, None, Some(Kinematics::new(&frames, inertia)), None];
            Neighbours::of(&bodies, &radii, &kinematics).of_body(body).map(|id| id.0).collect()
        };
        assert_eq!([of(0.0, 0), of(0.0, 2), of(0.0, 3)], [vec![1, 3], vec![3], vec![0, 1, 2]]);
        assert_eq!([of(1.0, 0), of(1.0, 2)], [vec![1, 2, 3], vec![0, 1, 3]]);
    }
}
