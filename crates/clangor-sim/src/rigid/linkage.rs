//! Linkages: bodies that joints, rods, ropes and stiff springs hold together, directly or through others.

use super::joint::Joint;
use super::state::BodyState;
use super::stiff_spring::StiffSpring;
use clangor_core::body::Link;
use clangor_core::pose::Pose;

/// The joints of a world, by linkage.
#[derive(Default)]
pub(super) struct Linkages {
    pub(super) joints: Vec<Joint>,
    /// Joints and bodies of each linkage.
    members: Vec<(Vec<usize>, Vec<usize>)>,
    /// Linkage of each body that can move.
    of_body: Vec<Option<usize>>,
    /// Pairs of bodies that do not touch, in order.
    apart: Vec<(usize, usize)>,
}

impl Linkages {
    /// The linkages of a world at its start, with the laws of its stiff springs; `Err` has the body of a link
    /// to one that does not exist.
    pub(super) fn try_new(
        links: &[Link],
        stiff: &[Option<StiffSpring>],
        bodies: &[BodyState],
    ) -> Result<Self, usize> {
        let poses = |body: usize| bodies[body].start_pose();
        let mut joints = Vec::new();
        for (link, spring) in links.iter().zip(stiff) {
            if let Some(unknown) = link.bodies().find(|body| body.index() >= bodies.len()) {
                return Err(unknown.index());
            }
            joints.extend(Joint::of_link(link, *spring, &poses));
        }
        // Connected components; bodies that forces never move connect nothing.
        let mut root: Vec<usize> = (0..bodies.len()).collect();
        let moved = |joint: &Joint| -> Vec<usize> {
            joint.ends.iter().filter_map(|end| end.body).filter(|&body| bodies[body].is_movable()).collect()
        };
        for joint in &joints {
            if let [a, b] = moved(joint)[..] {
                let (a, b) = (root_of(&root, a), root_of(&root, b));
                root[a.max(b)] = a.min(b);
            }
        }
        let mut linkages = Linkages { of_body: vec![None; bodies.len()], ..Linkages::default() };
        for (index, joint) in joints.iter().enumerate() {
            let bodies = moved(joint);
            let Some(first) = bodies.first() else { continue };
            let first = root_of(&root, *first);
            let group = match linkages.of_body[first] {
                Some(group) => group,
                None => {
                    linkages.members.push((Vec::new(), Vec::new()));
                    linkages.members.len() - 1
                }
            };
            linkages.of_body[first] = Some(group);
            for body in bodies {
                linkages.of_body[body] = Some(group);
            }
            linkages.members[group].0.push(index);
            if let ([Some(a), Some(b)], false) = (joint.ends.map(|end| end.body), joint.collide) {
                linkages.apart.push((a.min(b), a.max(b)));
            }
        }
        for (body, group) in linkages.of_body.iter().enumerate() {
            if let Some(group) = group {
                linkages.members[*group].1.push(body);
            }
        }
        linkages.apart.sort_unstable();
        linkages.joints = joints;
        Ok(linkages)
    }

    /// Number of linkages.
    pub(super) fn count(&self) -> usize {
        self.members.len()
    }

    /// Linkage of a body; pieces of a broken body have none.
    pub(super) fn of(&self, body: usize) -> Option<usize> {
        self.of_body.get(body).copied().flatten()
    }

    /// Joints of a linkage.
    pub(super) fn joints_of(&self, linkage: usize) -> &[usize] {
        &self.members[linkage].0
    }

    /// Whether a linkage has stiff springs.
    pub(super) fn has_springs(&self, linkage: usize) -> bool {
        self.joints_of(linkage).iter().any(|&joint| self.joints[joint].spring.is_some())
    }

    /// Energy \[J\] of the stiff springs of a linkage whose bodies have these poses.
    pub(super) fn stored(&self, linkage: usize, poses: &dyn Fn(usize) -> Pose) -> f64 {
        self.joints_of(linkage).iter().map(|&joint| self.joints[joint].stored(poses)).sum()
    }

    /// Bodies of a linkage.
    pub(super) fn bodies_of(&self, linkage: usize) -> &[usize] {
        &self.members[linkage].1
    }

    /// Bodies at the ends of the joints of a linkage, those that forces never move too.
    pub(super) fn ends_of(&self, linkage: usize) -> Vec<usize> {
        let joints = self.members[linkage].0.iter().map(|&joint| &self.joints[joint]);
        joints.flat_map(|joint| joint.ends).filter_map(|end| end.body).collect()
    }

    /// Whether a joint keeps two bodies from touching.
    pub(super) fn keep_apart(&self, a: usize, b: usize) -> bool {
        self.apart.binary_search(&(a.min(b), a.max(b))).is_ok()
    }
}

/// Representative of the component that holds a body.
fn root_of(root: &[usize], mut body: usize) -> usize {
    while root[body] != body {
        body = root[body];
    }
    body
}
