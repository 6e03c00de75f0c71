//! Links between the bodies of a world, from names and from points at the start.

use std::collections::BTreeMap;

use glam::DVec3;

use super::problems::Problems;
use crate::body::{Body, BodyId, JointKind, Link, LinkEnd, Motion, Surface, World};
use crate::scene::diagnostic::Problem;
use crate::scene::link_description::{
    Anchor, HangDescription, JointDescription, JointForm, LinkTarget, LoadDescription, SpringDescription,
};
use crate::scene::scene_description::Scene;

/// A rope may be shorter than the distance of its ends by this much at the start, for rounding in the text
/// \[m\].
const ROUNDING: f64 = 1e-9;

/// Adds the links of a scene to its world; `names` has the bodies of each name.
pub(super) fn link(
    scene: &Scene,
    names: &BTreeMap<String, Vec<BodyId>>,
    world: &mut World,
    problems: &mut Problems,
) {
    let mut links = Links { names, world, problems };
    scene.hangs.iter().for_each(|hang| links.hang(hang));
    scene.springs.iter().for_each(|spring| links.spring(spring));
    scene.joints.iter().for_each(|joint| links.joint(joint));
    scene.loads.iter().for_each(|load| links.load(load));
}

struct Links<'a> {
    names: &'a BTreeMap<String, Vec<BodyId>>,
    world: &'a mut World,
    problems: &'a mut Problems,
}

/// The two ends of a link at the start.
struct Ends {
    body: BodyId,
    at: DVec3,
    to: LinkEnd,
    /// Distance of the ends \[m\].
    distance: f64,
}

impl Links<'_> {
    fn hang(&mut self, hang: &HangDescription) {
        for id in self.names.get(&hang.body).into_iter().flatten() {
            let body = &self.world.bodies[id.index()];
            let anchor = match hang.anchor {
                Anchor::Point(point) => point,
                Anchor::Offset(offset) => body.pose.position + offset,
            };
            match refuse_hang(body, anchor) {
                Some(problem) => self.problems.error(hang.place.clone(), problem),
                None => self.world.links.push(Link::Hang { body: *id, anchor }),
            }
        }
    }

    fn spring(&mut self, spring: &SpringDescription) {
        let Some(ends) = self.ends(&spring.body, spring.point, &spring.to) else { return };
        // A spring between bodies that do not move has no effect.
        if ends.to.body() == Some(ends.body) {
            let problem = self.one_body(&ends);
            self.problems.error(spring.place.clone(), problem);
            return;
        }
        let Ends { body, at, to, distance } = ends;
        self.world.links.push(Link::Spring {
            body,
            at,
            to,
            rest_length: spring.rest_length.unwrap_or(distance),
            stiffness: spring.stiffness,
            damping: spring.damping,
        });
    }

    fn joint(&mut self, joint: &JointDescription) {
        let Some(ends) = self.ends(&joint.body, joint.point, &joint.to) else { return };
        let body = &self.world.bodies[ends.body.index()];
        let bad = |reason, remedy| Some(bad_link(body, reason, remedy));
        let problem = self.refuse_ends(&ends).or_else(|| match joint.form {
            JointForm::Rod | JointForm::Rope { length: None } if ends.distance == 0.0 => {
                bad("lies at both ends of a link without length", "move `to`, or use [[ball_joint]]")
            }
            JointForm::Rope { length: Some(length) } if length < ends.distance - ROUNDING => {
                bad("is farther from the other end than the rope is long", "lengthen the rope")
            }
            _ => None,
        });
        if let Some(problem) = problem {
            self.problems.error(joint.place.clone(), problem);
            return;
        }
        let pose = body.pose;
        let Ends { body, at, to, distance } = ends;
        let kind = match joint.form {
            JointForm::Ball { damping } => JointKind::Ball { damping },
            JointForm::Hinge { axis, damping } => {
                JointKind::Hinge { axis: pose.orientation.inverse() * axis, damping }
            }
            JointForm::Rod => JointKind::Rod { length: distance },
            JointForm::Rope { length } => JointKind::Rope { length: length.unwrap_or(distance) },
        };
        self.world.links.push(Link::Joint { body, at, to, kind, collide: joint.collide });
    }

    fn load(&mut self, load: &LoadDescription) {
        let Some(body) = self.named(&load.body) else { return };
        let of_world = &self.world.bodies[body.index()];
        if !of_world.motion.is_movable() {
            let problem = bad_link(of_world, "does not move, so that no force moves it", "delete the force");
            self.problems.error(load.place.clone(), problem);
            return;
        }
        let at = load.point.map_or(DVec3::ZERO, |point| of_world.pose.body_from_world(point));
        let (force, torque) = (load.force.clone(), load.torque.clone());
        self.world.links.push(Link::Load { body, at, force, torque });
    }

    fn named(&self, name: &str) -> Option<BodyId> {
        self.names.get(name).and_then(|ids| ids.first()).copied()
    }

    /// Ends by name and point; `None` for a name that was reported already.
    fn ends(&self, body: &str, point: Option<DVec3>, to: &LinkTarget) -> Option<Ends> {
        let place = |body: BodyId, point: Option<DVec3>| {
            let pose = self.world.bodies[body.index()].pose;
            let point = point.unwrap_or(pose.position);
            // The centre of mass exactly, whatever the rotation.
            let at = if point == pose.position { DVec3::ZERO } else { pose.body_from_world(point) };
            (at, point)
        };
        let body = self.named(body)?;
        let (at, near) = place(body, point);
        let (to, far) = match to {
            LinkTarget::Point(point) => (LinkEnd::Point(*point), *point),
            LinkTarget::Body { name, point } => {
                let body = self.named(name)?;
                let (at, far) = place(body, *point);
                (LinkEnd::Body { body, at }, far)
            }
        };
        Some(Ends { body, at, to, distance: far.distance(near) })
    }

    fn one_body(&self, ends: &Ends) -> Problem {
        bad_link(&self.world.bodies[ends.body.index()], "is at both ends of the link", "name two bodies")
    }

    fn refuse_ends(&self, ends: &Ends) -> Option<Problem> {
        let body = &self.world.bodies[ends.body.index()];
        let other = ends.to.body();
        if other == Some(ends.body) {
            return Some(self.one_body(ends));
        }
        let other_moves = other.is_some_and(|other| self.world.bodies[other.index()].motion.is_movable());
        if !body.motion.is_movable() && !other_moves {
            return Some(bad_link(body, "and the other end of its link do not move", "delete the link"));
        }
        None
    }
}

fn refuse_hang(body: &Body, anchor: DVec3) -> Option<Problem> {
    if !matches!(*body.surface, Surface::Sphere { .. }) {
        return Some(bad_link(
            body,
            "is not a sphere, and only spheres hang",
            "use [[rod]] or [[rope]], which hold any body",
        ));
    }
    if body.motion != Motion::Free {
        let remedy = match body.motion {
            Motion::Fixed => "set motion = \"free\"",
            _ => "use [[rod]] or [[rope]], which hold bodies with keyframes too",
        };
        return Some(bad_link(body, "is not free to swing", remedy));
    }
    if (anchor - body.pose.position).length() == 0.0 {
        return Some(bad_link(body, "has its centre at the anchor", "move the anchor away from the centre"));
    }
    None
}

fn bad_link(body: &Body, reason: &'static str, remedy: &'static str) -> Problem {
    Problem::BadLink { body: body.name.clone(), reason, remedy }
}
