//! Bodies that a recording moves into each other, as far and as long as no contact does.
//!
//! ```text
//! d = max over points x in both of dist(x, ∂A) + dist(x, ∂B)
//! ```
//!
//! A ball of each of the two radii about x lies in its body, so that one of the bodies would have to move
//! by d to part the balls: d is never more than the depth of the overlap. The points are some vertices of
//! each body, those halfway to its centre, and the centre.
//!
//! Looks at some instants of each part of a recording, with a bounded number of searches in near pairs;
//! an overlap counts where neighbouring frames have it too. Not for planes
//! ([`sunk_bodies`](super::sunk_bodies)), bodies on one link, and parts of one thing.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::ops::ControlFlow;
use std::sync::Arc;

use clangor_core::body::{Body, BodyId, Link, LinkEnd, Surface, World};
use clangor_core::pose::Pose;
use glam::DVec3;

use super::ball_pairs::{Ball, overlapping};
use super::recording::{Frame, RecordedBody};

/// Depth that is reported: share of the thinner body's 2 V/A, and at least \[m\].
const DEEP: (f64, f64) = (0.25, 1e-3);
/// Instants of a part.
const INSTANTS: usize = 32;
/// Frames before and after an instant that must be as deep.
const NEIGHBOURS: usize = 2;
/// Vertices of a body that are looked at.
const POINTS: usize = 24;
/// Most searches of a nearest point in a part.
const SEARCHES: usize = 100_000;
/// Most pairs of bodies whose depth is measured in a part.
const PAIRS: usize = 1_000_000;
/// Notices; more are counted.
const MOST_NOTICES: usize = 10;

/// The bodies that lie too deep in each other: depth \[m\] and frame of the deepest overlap of each pair.
#[derive(Clone, Debug, Default)]
pub(crate) struct NestedBodies(BTreeMap<[BodyId; 2], (f64, Frame)>);

/// Two bodies in each other, for people.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct NestedNotice {
    bodies: [String; 2],
    depth: f64,
    time: f64,
    row: u64,
    others: usize,
}

/// What the search needs of a body.
struct Solid<'a> {
    id: BodyId,
    body: &'a Body,
    shape: Arc<Shape>,
    recorded: Option<&'a RecordedBody>,
}

/// What the search needs of a surface.
struct Shape {
    radius: f64,
    /// 2 V/A \[m\].
    thickness: f64,
    /// Body frame \[m\].
    points: Vec<DVec3>,
}

/// What the search may still do in a part.
struct Left {
    pairs: usize,
    searches: usize,
}

impl NestedBodies {
    /// Looks at some frames; of each pair the deepest overlap is kept.
    pub(crate) fn look(&mut self, world: &World, recorded: &[RecordedBody]) {
        let moved: BTreeMap<BodyId, &RecordedBody> = recorded.iter().map(|body| (body.body, body)).collect();
        let mut shapes: BTreeMap<*const Surface, Option<Arc<Shape>>> = BTreeMap::new();
        let solids = world.bodies.iter().enumerate().filter_map(|(index, body)| {
            let shape = shapes.entry(Arc::as_ptr(&body.surface));
            let shape = shape.or_insert_with(|| Shape::of(&body.surface).map(Arc::new)).clone()?;
            let id = BodyId(index as u32);
            Some(Solid { id, body, shape, recorded: moved.get(&id).copied() })
        });
        let solids: Vec<Solid<'_>> = solids.collect();
        let linked = linked_pairs(world);
        let mut left = Left { pairs: PAIRS, searches: SEARCHES };
        let longest = recorded.iter().map(|body| body.frames.as_slice()).max_by_key(|frames| frames.len());
        for frame in longest.map(spread).unwrap_or_default() {
            self.look_at(&linked, &solids, frame.time, &mut left);
        }
    }

    fn look_at(&mut self, linked: &BTreeSet<[BodyId; 2]>, solids: &[Solid<'_>], time: f64, left: &mut Left) {
        let placed: Vec<(&Solid<'_>, Pose)> =
            solids.iter().filter_map(|solid| Some((solid, solid.pose(time)?))).collect();
        let ball =
            |(solid, pose): &(&Solid<'_>, Pose)| Ball { centre: pose.position, radius: solid.shape.radius };
        let balls: Vec<Ball> = placed.iter().map(ball).collect();
        overlapping(&balls, &mut |pair| {
            let [(a, pose), (b, other)] = pair.map(|place| placed[place]);
            let within = a.shape.radius + b.shape.radius - a.least(b);
            let is_near = pose.position.distance_squared(other.position) < within * within;
            if !is_near || !a.may_meet(b) || linked.contains(&[a.id, b.id]) {
                return ControlFlow::Continue(());
            }
            if left.pairs == 0 || left.searches == 0 {
                return ControlFlow::Break(());
            }
            left.pairs -= 1;
            let deep = depth((a, pose), (b, other), left);
            if deep > a.least(b) && self.is_new([a.id, b.id], deep) && stays(a, b, time, left) {
                let moved = [a, b].into_iter().find_map(|solid| solid.frame(time));
                self.0.extend(moved.map(|frame| ([a.id, b.id], (deep, frame))));
            }
            ControlFlow::Continue(())
        });
    }

    fn is_new(&self, bodies: [BodyId; 2], depth: f64) -> bool {
        self.0.get(&bodies).is_none_or(|(known, _)| *known < depth)
    }

    /// What should be known, the deepest first.
    pub(crate) fn notices(&self, world: &World) -> Vec<NestedNotice> {
        let name = |id: BodyId| world.bodies.get(id.index()).map_or_else(String::new, |b| b.name.clone());
        let mut found: Vec<([BodyId; 2], (f64, Frame))> =
            self.0.iter().map(|(pair, deepest)| (*pair, *deepest)).collect();
        found.sort_by(|(_, (a, _)), (_, (b, _))| b.total_cmp(a));
        let others = found.len().saturating_sub(MOST_NOTICES);
        let shown = found.into_iter().take(MOST_NOTICES).enumerate();
        let notice = |(place, (bodies, (depth, frame))): (usize, ([BodyId; 2], (f64, Frame)))| NestedNotice {
            bodies: bodies.map(name),
            depth,
            time: frame.time,
            row: frame.row,
            others: if place + 1 == MOST_NOTICES { others } else { 0 },
        };
        shown.map(notice).collect()
    }
}

impl fmt::Display for NestedNotice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let NestedNotice { bodies: [a, b], depth, time, row, others } = self;
        write!(
            f,
            "{a} and {b} lie {:.1} mm deep in each other over several frames (row {row}, t = {time:.4} s): \
             their impacts may be missing; check their sizes and places, and whether they are parts of one \
             thing",
            1e3 * depth
        )?;
        match others {
            0 => Ok(()),
            1 => write!(f, "; 1 more pair of bodies lies so"),
            more => write!(f, "; {more} more pairs of bodies lie so"),
        }
    }
}

impl Shape {
    /// `None` for planes.
    fn of(surface: &Surface) -> Option<Self> {
        let radius = surface.bounding_radius();
        let (thickness, points) = match surface {
            Surface::HalfSpace | Surface::Plate { .. } => return None,
            Surface::Sphere { .. } => (2.0 * radius / 3.0, vec![DVec3::ZERO]),
            Surface::Mesh(surface) => {
                let mesh = &surface.mesh;
                let step = mesh.vertices.len().div_ceil(POINTS).max(1);
                let corners = mesh.vertices.iter().copied().step_by(step);
                let points = corners.flat_map(|corner| [corner, 0.5 * corner]).chain([DVec3::ZERO]).collect();
                (2.0 * surface.volume / mesh.area(), points)
            }
        };
        Some(Shape { radius, thickness, points })
    }
}

impl Solid<'_> {
    /// Smallest depth in another body that is reported \[m\].
    fn least(&self, other: &Solid<'_>) -> f64 {
        (DEEP.0 * self.shape.thickness.min(other.shape.thickness)).max(DEEP.1)
    }

    /// Whether one of the two moves, and they are no parts of one thing.
    fn may_meet(&self, other: &Solid<'_>) -> bool {
        match [self.recorded, other.recorded] {
            [None, None] => false,
            [Some(a), Some(b)] => a.group.is_none() || a.group != b.group,
            _ => true,
        }
    }

    /// The last frame up to a time, while there are frames.
    fn frame(&self, time: f64) -> Option<Frame> {
        let frames = &self.recorded?.frames;
        let next = frames.partition_point(|frame| frame.time <= time);
        let is_over = frames.last().is_none_or(|last| last.time < time);
        next.checked_sub(1).filter(|_| !is_over).map(|place| frames[place])
    }

    fn pose(&self, time: f64) -> Option<Pose> {
        let life = self.body.life;
        match self.recorded {
            Some(_) => self.frame(time).map(|frame| frame.pose),
            None if time < life.birth || time > life.death => None,
            None => Some(self.body.motion.track().map_or(self.body.pose, |track| track.sample(time).0)),
        }
    }

    /// How deep a point lies in the body \[m\]; `None` outside.
    fn depth_of(&self, pose: Pose, point: DVec3, left: &mut Left) -> Option<f64> {
        let local = pose.body_from_world(point);
        let radius = self.shape.radius;
        if local.length_squared() >= radius * radius {
            return None;
        }
        let Surface::Mesh(mesh) = &*self.body.surface else { return Some(radius - local.length()) };
        left.searches = left.searches.checked_sub(1)?;
        let nearest = mesh.nearest(local)?;
        let is_inside = (local - nearest.position).dot(mesh.normal_at(local)?) <= 0.0;
        is_inside.then_some(nearest.distance)
    }
}

/// How deep two bodies lie in each other, at least \[m\].
fn depth((a, pose): (&Solid<'_>, Pose), (b, other): (&Solid<'_>, Pose), left: &mut Left) -> f64 {
    let mut deepest = 0.0_f64;
    let (of_a, of_b) =
        (a.shape.points.iter().map(|point| pose.world_from_body(*point)), b.shape.points.iter());
    for point in of_a.chain(of_b.map(|point| other.world_from_body(*point))) {
        let Some(in_a) = a.depth_of(pose, point, left) else { continue };
        let Some(in_b) = b.depth_of(other, point, left) else { continue };
        deepest = deepest.max(in_a + in_b);
    }
    deepest
}

/// Whether two bodies lie in each other in the frames around a time as well.
fn stays(a: &Solid<'_>, b: &Solid<'_>, time: f64, left: &mut Left) -> bool {
    let Some(moved) = a.recorded.or(b.recorded) else { return false };
    let at = moved.frames.partition_point(|frame| frame.time < time);
    let last = moved.frames.len().saturating_sub(1);
    let (from, to) = (at.saturating_sub(NEIGHBOURS), (at + NEIGHBOURS).min(last));
    let is_deep = |frame: &Frame| {
        let poses = a.pose(frame.time).zip(b.pose(frame.time));
        poses.is_some_and(|(pose, other)| depth((a, pose), (b, other), left) > a.least(b))
    };
    to > from + NEIGHBOURS && moved.frames[from..=to].iter().all(is_deep)
}

/// Frames that are spread over all, those in the middle of the largest gaps first.
fn spread(frames: &[Frame]) -> Vec<Frame> {
    let mut places: Vec<usize> = (0..INSTANTS)
        .map(|k| {
            // Radical inverse: ½, ¼, ¾, ⅛, …
            let share = f64::from((k as u32 + 1).reverse_bits()) / 2.0_f64.powi(32);
            ((share * frames.len() as f64) as usize).min(frames.len().saturating_sub(1))
        })
        .collect();
    let mut known = std::collections::BTreeSet::new();
    places.retain(|place| known.insert(*place));
    places.into_iter().filter_map(|place| frames.get(place).copied()).collect()
}

/// The pairs of bodies that a link holds to each other, the smaller number first.
fn linked_pairs(world: &World) -> BTreeSet<[BodyId; 2]> {
    let ends = |link: &Link| match link {
        Link::Spring { body, to: LinkEnd::Body { body: other, .. }, .. }
        | Link::Joint { body, to: LinkEnd::Body { body: other, .. }, .. } => {
            Some([*body.min(other), *body.max(other)])
        }
        _ => None,
    };
    world.links.iter().filter_map(ends).collect()
}

#[cfg(test)]
mod tests {
    use std::time::Instant;

    use clangor_core::material::presets::preset;

    use super::*;

    #[test]
    fn only_bodies_in_each_other_are_noticed_among_ten_thousand() {
        let steel = preset("steel").unwrap();
        let place = |k: u32| DVec3::new(f64::from(k % 100), 0.5, f64::from(k / 100)) * 0.03;
        let bodies = (0..10_000).map(|k| Body::sphere(format!("ball-{k}"), steel.clone(), 0.01)).collect();
        let world = World { bodies, links: Vec::new(), gravity: DVec3::NEG_Y };
        let frame = |k: u32, number: u32| {
            // Ball 77 lies in ball 4321.
            let pose = Pose::at(place(if k == 77 { 4321 } else { k }));
            Frame { time: f64::from(number) / 60.0, pose, row: u64::from(number) }
        };
        let body = |k: u32| RecordedBody {
            body: BodyId(k),
            frames: (0..60).map(|number| frame(k, number)).collect(),
            group: None,
        };
        let recorded: Vec<RecordedBody> = (0..10_000).map(body).collect();
        let mut nested = NestedBodies::default();
        let start = Instant::now();
        nested.look(&world, &recorded);
        println!("32 instants of 10 000 balls take {:.1} ms", 1e3 * start.elapsed().as_secs_f64());
        let [notice] = &nested.notices(&world)[..] else { panic!("{nested:?}") };
        assert!(notice.to_string().starts_with("ball-77 and ball-4321 lie 20.0 mm deep"), "{notice}");
    }
}
