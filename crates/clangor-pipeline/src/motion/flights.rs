//! The motion of free bodies of which only the impulses are listed: flights under gravity between them.
//!
//! ```text
//! between    x(t) = x + v τ + g τ²/2        L constant, ω = R I⁻¹ Rᵀ L
//! at a row   Δv = J / m                     ΔL = (p − x) × J + couple
//! ```
//!
//! A list is more exact than what follows from it over many flights. At an impact a body is therefore shifted
//! until the listed point lies on its surface, and if nothing else touches it then, the approach is that
//! of the list. A notice gives the largest of both corrections. A body whose flight meets a plane or a body
//! that does not move, with no row to turn it back, rests there until its next row.
//!
//! This is no simulation: free bodies pass through each other where the list has no contact, and a body that
//! rests on another free body falls unless the list has the forces that hold it. Links and supports are not
//! known here; the caller leaves out the bodies that have them.

use std::io;
use std::sync::Arc;

use clangor_core::body::{Body, BodyId, Motion, Surface, World};
use clangor_core::pose::Pose;
use clangor_core::timeline::{ContactKind, ContactRow, PoseRow};
use glam::{DMat3, DQuat, DVec3};

use super::contact_checks::surface_tolerance;
use super::kinematics::{Inertia, State};
use super::touch::Touch;
use super::touching::{Placed, SampledSurface, touches};

/// Largest angle of a step of the rotation \[rad\]: the error of the midpoint rule is of its third power.
const STEP_ANGLE: f64 = 0.02;
/// Most steps between two instants, for spins that no impact gives.
const MOST_STEPS: f64 = 10_000.0;
/// A body does not come to rest this short before a row \[s\]: programs write impacts at the end of a step.
const BEFORE_ROW: f64 = 0.005;

/// How far the flights of a body and its list differ.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Disagreement {
    /// Largest distance of a listed impact from the surface of the flying body \[m\], and its place in the
    /// list.
    pub(crate) distance: (f64, usize),
    /// Largest difference of a listed approach from that of the flight [m/s], and its place in the list.
    pub(crate) approach: (f64, usize),
}

/// When poses are written.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PoseClock {
    /// Poses in a second, above 0.
    pub(crate) rate: f64,
    /// Last instant \[s\].
    pub(crate) duration: f64,
}

/// Flies the bodies for which `flies`; gives their poses while they move, and those just before each of their
/// rows, to `sink` in order of time. `rows` come in order of time. The answer has one place for each body.
///
/// # Errors
/// Those of `sink`.
pub(crate) fn fly(
    world: &World,
    rows: &[ContactRow],
    clock: PoseClock,
    flies: &dyn Fn(BodyId) -> bool,
    sink: &mut dyn FnMut(&PoseRow) -> io::Result<()>,
) -> io::Result<Vec<Disagreement>> {
    let mut flyers = Flyers::new(world, rows, flies);
    let mut done = 0;
    let mut sample = 0_u64;
    loop {
        let time = sample as f64 / clock.rate;
        let limit = time.min(clock.duration);
        // Samples come before the rows of the same instant: a pose at an impact is the last before it.
        while let Some(row) = rows.get(done).filter(|row| row.time < limit) {
            let count = rows[done..].iter().take_while(|other| other.time == row.time).count();
            flyers.strike(rows, done..done + count, sink)?;
            done += count;
        }
        if time > clock.duration {
            break;
        }
        flyers.sample(time, sink)?;
        sample += 1;
    }
    if let Some(left) = rows.get(done..).filter(|left| !left.is_empty()) {
        flyers.strike(rows, done..done + left.len(), sink)?;
    }
    Ok(flyers.disagreements)
}

/// A body on its way.
struct Flyer<'a> {
    id: BodyId,
    body: &'a Body,
    sampled: Arc<SampledSurface>,
    inertia: Inertia,
    state: State,
    /// World [kg m²/s].
    angular_momentum: DVec3,
    time: f64,
    is_moving: bool,
    /// Times of its rows, the next one last \[s\].
    rows: Vec<f64>,
}

struct Flyers<'a> {
    world: &'a World,
    /// One place for each body.
    flyers: Vec<Option<Flyer<'a>>>,
    /// What does not move freely.
    obstacles: Vec<(&'a Body, Arc<SampledSurface>)>,
    disagreements: Vec<Disagreement>,
}

impl<'a> Flyers<'a> {
    fn new(world: &'a World, rows: &[ContactRow], flies: &dyn Fn(BodyId) -> bool) -> Self {
        let flyer = |(index, body): (usize, &'a Body)| {
            let id = BodyId(index as u32);
            if !matches!(body.motion, Motion::Free) || !flies(id) {
                return None;
            }
            let own = rows.iter().rev().filter(|row| row.body_a == id || row.body_b == id);
            let state =
                State { pose: body.pose, velocity: body.velocity, angular_velocity: body.angular_velocity };
            let rotation = DMat3::from_quat(body.pose.orientation);
            Some(Flyer {
                id,
                body,
                sampled: Arc::new(SampledSurface::new(&body.surface)),
                inertia: Inertia::new(body.mass, body.inertia, world.gravity),
                state,
                angular_momentum: rotation * body.inertia * rotation.transpose() * body.angular_velocity,
                time: 0.0,
                is_moving: true,
                rows: own.map(|row| row.time).collect(),
            })
        };
        let fixed = world.bodies.iter().filter(|body| !matches!(body.motion, Motion::Free));
        Flyers {
            world,
            flyers: world.bodies.iter().enumerate().map(flyer).collect(),
            obstacles: fixed.map(|body| (body, Arc::new(SampledSurface::new(&body.surface)))).collect(),
            disagreements: vec![Disagreement::default(); world.bodies.len()],
        }
    }

    /// Moves all bodies to an instant and gives the poses of those that move.
    fn sample(&mut self, time: f64, sink: &mut dyn FnMut(&PoseRow) -> io::Result<()>) -> io::Result<()> {
        for flyer in self.flyers.iter_mut().flatten() {
            let was_moving = flyer.is_moving;
            flyer.advance(time);
            if was_moving {
                flyer.rest_on(&self.obstacles);
                sink(&flyer.row())?;
            }
        }
        Ok(())
    }

    /// Applies the rows of one instant.
    fn strike(
        &mut self,
        rows: &[ContactRow],
        instant: std::ops::Range<usize>,
        sink: &mut dyn FnMut(&PoseRow) -> io::Result<()>,
    ) -> io::Result<()> {
        let first = instant.start;
        let mut is_touched = vec![0_usize; self.flyers.len()];
        for (place, row) in rows[instant.clone()].iter().enumerate() {
            for id in [row.body_a, row.body_b] {
                let Some(Some(flyer)) = self.flyers.get_mut(id.index()) else { continue };
                is_touched[id.index()] += 1;
                if is_touched[id.index()] > 1 {
                    continue;
                }
                flyer.advance(row.time);
                while flyer.rows.pop_if(|time| *time <= row.time).is_some() {}
                if row.kind == ContactKind::Impact {
                    let distance = flyer.put_on(row.point);
                    let worst = &mut self.disagreements[id.index()].distance;
                    if distance > worst.0 {
                        *worst = (distance, first + place);
                    }
                }
            }
        }
        for (place, row) in rows[instant.clone()].iter().enumerate() {
            let count = |id: BodyId| is_touched.get(id.index()).copied().unwrap_or(0);
            if row.kind == ContactKind::Impact && count(row.body_a).max(count(row.body_b)) == 1 {
                self.take_approach(row, first + place);
            }
        }
        for flyer in self.flyers.iter().flatten().filter(|flyer| is_touched[flyer.id.index()] > 0) {
            sink(&flyer.row())?;
        }
        for row in &rows[instant] {
            for (id, sign) in [(row.body_a, 1.0), (row.body_b, -1.0)] {
                if let Some(Some(flyer)) = self.flyers.get_mut(id.index()) {
                    flyer.push(row.point, row.impulse() * sign, row.couple * sign);
                }
            }
        }
        Ok(())
    }

    /// Makes the approach of an impact that of the list, by equal and opposite impulses on the centres.
    fn take_approach(&mut self, row: &ContactRow, place: usize) {
        let pair = [row.body_a, row.body_b];
        let flyer = |id: BodyId| self.flyers.get(id.index()).and_then(Option::as_ref);
        // What neither flies nor is known to stand still may move in any way.
        let is_known = |id: BodyId| {
            flyer(id).is_some()
                || self.world.bodies.get(id.index()).is_none_or(|body| matches!(body.motion, Motion::Fixed))
        };
        if !pair.iter().all(|id| is_known(*id)) {
            return;
        }
        let velocity = |id: BodyId| flyer(id).map_or(DVec3::ZERO, |flyer| flyer.state.velocity_at(row.point));
        let flown = (velocity(row.body_a) - velocity(row.body_b)).dot(row.normal);
        let missing = row.velocity.dot(row.normal) - flown;
        let inverse = pair.map(|id| flyer(id).map_or(0.0, |flyer| flyer.inertia.mass.recip()));
        let whole = inverse[0] + inverse[1];
        for ((id, sign), inverse) in pair.into_iter().zip([1.0, -1.0]).zip(inverse) {
            let Some(Some(flyer)) = self.flyers.get_mut(id.index()) else { continue };
            flyer.state.velocity += row.normal * (sign * missing * inverse / whole);
            let worst = &mut self.disagreements[id.index()].approach;
            if missing.abs() > worst.0 {
                *worst = (missing.abs(), place);
            }
        }
    }
}

impl Flyer<'_> {
    fn row(&self) -> PoseRow {
        let State { pose, velocity, angular_velocity } = self.state;
        let Pose { position, orientation } = pose;
        PoseRow { time: self.time, body: self.id, position, orientation, velocity, angular_velocity }
    }

    /// Flies to an instant.
    fn advance(&mut self, to: f64) {
        let tau = to - self.time;
        self.time = to;
        if !self.is_moving || tau <= 0.0 {
            return;
        }
        let gravity = self.inertia.gravity;
        self.state.pose.position += self.state.velocity * tau + gravity * (0.5 * tau * tau);
        self.state.velocity += gravity * tau;
        let angle = self.state.angular_velocity.length() * tau;
        let steps = (angle / STEP_ANGLE).ceil().clamp(1.0, MOST_STEPS);
        let step = tau / steps;
        let spin = |q: DQuat| self.inertia.inverse_at(q) * self.angular_momentum;
        let mut orientation = self.state.pose.orientation;
        for _ in 0..steps as u32 {
            let middle = DQuat::from_scaled_axis(spin(orientation) * (0.5 * step)) * orientation;
            orientation = (DQuat::from_scaled_axis(spin(middle) * step) * orientation).normalize();
        }
        self.state.angular_velocity = spin(orientation);
        self.state.pose.orientation = orientation;
    }

    fn push(&mut self, point: DVec3, impulse: DVec3, couple: DVec3) {
        self.state.velocity += impulse / self.inertia.mass;
        self.angular_momentum += (point - self.state.pose.position).cross(impulse) + couple;
        self.state.angular_velocity =
            self.inertia.inverse_at(self.state.pose.orientation) * self.angular_momentum;
        self.is_moving = true;
    }

    /// Shifts the body until a point lies on its surface; how far \[m\].
    fn put_on(&mut self, point: DVec3) -> f64 {
        let local = self.state.pose.body_from_world(point);
        let place = match &*self.body.surface {
            Surface::Sphere { radius } => local.normalize_or(DVec3::Y) * *radius,
            Surface::Mesh(mesh) => mesh.nearest(local).map_or(local, |nearest| nearest.position),
            Surface::HalfSpace | Surface::Plate { .. } => local,
        };
        let shift = self.state.pose.orientation * (local - place);
        self.state.pose.position += shift;
        shift.length()
    }

    /// Comes to rest where it has sunk into something that does not move, unless a row follows at once.
    fn rest_on(&mut self, obstacles: &[(&Body, Arc<SampledSurface>)]) {
        if self.rows.last().is_some_and(|next| *next < self.time + BEFORE_ROW) {
            return;
        }
        let own = Placed { sampled: &self.sampled, pose: self.state.pose };
        let found = obstacles.iter().flat_map(|(body, sampled)| {
            let pose = body.motion.track().map_or(body.pose, |track| track.sample(self.time).0);
            touches(own, Placed { sampled, pose }, 0.0)
        });
        let deepest = found.min_by(|a, b| a.gap.total_cmp(&b.gap));
        let tolerance = surface_tolerance(self.sampled.radius);
        let Some(Touch { normal, gap, .. }) = deepest.filter(|touch| touch.gap < -tolerance) else { return };
        if self.state.velocity.dot(normal) < 0.0 {
            self.state.pose.position -= normal * gap;
            self.state.velocity = DVec3::ZERO;
            self.state.angular_velocity = DVec3::ZERO;
            self.angular_momentum = DVec3::ZERO;
            self.is_moving = false;
        }
    }
}
