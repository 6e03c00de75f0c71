//! Bodies that a recording moves into half-spaces, as far as no solid could.
//!
//! ```text
//! d = max over frames and points x of the surface of −(x − o)·n,    plane through o with normal n
//! ```
//!
//! Impacts are found on surfaces that overlap a little; those of a body that lies deep in a floor, as by a
//! mesh or a floor in the wrong place, may be missing or at the wrong time. Soft contacts
//! ([`soft_contacts`](super)) overlap for a short time.
//!
//! Not for bodies inside of each other.

use std::collections::BTreeMap;
use std::fmt;

use clangor_core::body::{BodyId, Surface, World};
use glam::DVec3;

use super::recording::{Frame, RecordedBody};
use super::soft_contacts::SoftPush;

/// Depth that is reported: share of the bounding radius, and at least \[m\].
const DEEP: (f64, f64) = (0.1, 1e-3);
/// Time from the beginning of a soft push until a body lies on the surface, over that of the push.
const RISES: f64 = 4.0;
/// Most vertices of a surface that are looked at.
const MOST_POINTS: usize = 500;

/// The bodies that lie too deep: body and plane, and depth \[m\] and frame of the deepest place.
#[derive(Clone, Debug, Default)]
pub(crate) struct SunkBodies(BTreeMap<[BodyId; 2], (f64, Frame)>);

/// A body in a plane, for people.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SunkNotice {
    body: String,
    plane: String,
    depth: f64,
    time: f64,
    row: u64,
}

impl SunkBodies {
    /// Looks at some frames, but for those of soft pushes; of each body and plane the deepest is kept.
    pub(crate) fn look(&mut self, world: &World, recorded: &[RecordedBody], soft: &[SoftPush]) {
        let half_spaces = |surface: &Surface| matches!(surface, Surface::HalfSpace);
        let planes: Vec<usize> =
            (0..world.bodies.len()).filter(|k| half_spaces(&world.bodies[*k].surface)).collect();
        for RecordedBody { body, frames, .. } in recorded {
            let Some(surface) = world.bodies.get(body.index()).map(|body| &*body.surface) else { continue };
            let radius = surface.bounding_radius();
            let own: Vec<&SoftPush> = soft.iter().filter(|push| push.body == *body).collect();
            let is_pushed = |frame: &Frame| {
                own.iter().any(|push| {
                    let since = frame.time - push.time;
                    (0.0..RISES * push.length).contains(&since)
                })
            };
            for plane in &planes {
                let pose = world.bodies[*plane].pose;
                let (normal, least) = (pose.orientation * DVec3::Y, (DEEP.0 * radius).max(DEEP.1));
                let mut last = Reach { direction: DVec3::ZERO, length: radius };
                for frame in frames {
                    let height = (frame.pose.position - pose.position).dot(normal);
                    if radius - height <= least {
                        continue;
                    }
                    // A body turns little from frame to frame, and at rest not at all.
                    let direction = frame.pose.orientation.inverse() * -normal;
                    if last.most_along(direction, radius) - height <= least {
                        continue;
                    }
                    last = Reach { direction, length: reach(surface, direction) };
                    let depth = last.length - height;
                    if depth > least && !is_pushed(frame) {
                        self.note([*body, BodyId(*plane as u32)], depth, frame);
                    }
                }
            }
        }
    }

    fn note(&mut self, pair: [BodyId; 2], depth: f64, frame: &Frame) {
        let deepest = self.0.entry(pair).or_insert((depth, *frame));
        if depth > deepest.0 {
            *deepest = (depth, *frame);
        }
    }

    /// What should be known, body by body.
    pub(crate) fn notices(&self, world: &World) -> Vec<SunkNotice> {
        let name = |id: BodyId| world.bodies.get(id.index()).map_or_else(String::new, |b| b.name.clone());
        let notice = |([body, plane], (depth, frame)): (&[BodyId; 2], &(f64, Frame))| SunkNotice {
            body: name(*body),
            plane: name(*plane),
            depth: *depth,
            time: frame.time,
            row: frame.row,
        };
        self.0.iter().map(notice).collect()
    }
}

impl fmt::Display for SunkNotice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let SunkNotice { body, plane, depth, time, row } = self;
        write!(
            f,
            "{body} lies up to {:.1} mm deep in the plane {plane} (row {row}, t = {time:.4} s): its impacts \
             there may be missing; move the plane, or check the size of the body",
            1e3 * depth
        )
    }
}

/// How far a surface reaches along one unit direction \[m\].
struct Reach {
    direction: DVec3,
    length: f64,
}

impl Reach {
    /// The farthest that a surface of this bounding radius can reach along another direction \[m\].
    fn most_along(&self, direction: DVec3, radius: f64) -> f64 {
        self.length + radius * self.direction.distance(direction)
    }
}

/// The farthest that a surface reaches along a unit direction from the centre of mass \[m\].
fn reach(surface: &Surface, direction: DVec3) -> f64 {
    let Surface::Mesh(mesh) = surface else { return surface.bounding_radius() };
    let vertices = &mesh.mesh.vertices;
    let step = vertices.len().div_ceil(MOST_POINTS).max(1);
    vertices.iter().step_by(step).map(|vertex| vertex.dot(direction)).fold(0.0, f64::max)
}
