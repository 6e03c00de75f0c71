//! A block whose bodies give way: the impulses of its impacts by a solve of the contacts.
//!
//! Where bodies have modes, and the pulse of rigid bodies would give them more than 0.003 of the energy of
//! the approach, all contacts of the block are solved together
//! ([`group_impact`](mod@clangor_core::contact::group_impact)). The impulses that come out, normal and
//! tangential, replace those of the reflections of \[REFL\]; reflections follow for whatever approaches then.
//! Contacts of the block are all points of its pairs, and of other parts of the same bodies, that are no
//! farther apart than the approach closes in a few durations. Balls that press on others meanwhile are
//! solved too, with those others (`pressed_balls`).
//!
//! Differs: the duration of the contact itself is neglected. The impulses act at its first instant and pose.
//! The bodies would move by V τ meanwhile, 20 to 300 µm at 1 m/s, and gravity would add g τ, below 3 mm/s.
//!
//! Bodies without modes, such as the pieces of a broken one, keep the impulses of rigid bodies. So do
//! impacts of bodies with joints, whose reactions the solve does not know, and impacts that are slow, or
//! that meet a vibrating body while the forces of its last solve act on it, as in a crowd: their
//! restitution is that of whole bodies, in which vibration counts.

use clangor_core::body::BodyId;
use clangor_core::contact::{ContactSide, GroupContact, GroupImpact, GroupMember, Spread, Touch, touching};
use glam::DVec3;

use super::collision_block::{Actor, Block, BlockPoint, ELASTIC_HITS, TOGETHER, TOUCHING};
use super::collision_scene::Scene;
use super::compliance::BodySide;
use super::impact_threshold::rest_speed;
use super::manifold::ManifoldPoint;
use super::pair::Pair;

/// Durations of the rigid contact in which the approach closes the gaps of a block.
const HORIZON: f64 = 4.0;
/// Points nearer than this part of the smaller body, with normals within 11°, are one contact.
const ONE_PLACE: f64 = 1e-3;
const ONE_NORMAL: f64 = 0.98;

/// A point of a pair in a block.
#[derive(Clone, Copy)]
struct PointOfPair<'p> {
    pair: usize,
    point: &'p ManifoldPoint,
    /// The bodies among the actors.
    actors: [usize; 2],
    normal: DVec3,
    place: DVec3,
    velocity: DVec3,
}

impl PointOfPair<'_> {
    fn approach(&self) -> f64 {
        -self.velocity.dot(self.normal)
    }
}

impl Actor {
    /// How it gives way at its pose.
    fn side(&self, sides: &[BodySide]) -> ContactSide {
        let side = ContactSide { pose: self.pose(), ..sides[self.body].side };
        if self.now.inverse_mass > 0.0 { side } else { side.immovable() }
    }
}

impl Block {
    /// Solves the contacts of the group at time `t` of the step, if its bodies vibrate enough; applies and
    /// logs the impulses. The group then also has the other pairs that took part.
    pub(super) fn give_way(&mut self, scene: &mut Scene<'_>, group: &mut Vec<usize>, t: f64) {
        let (own, bodies) = (group.len(), self.actors.len());
        self.vibrates = false;
        let Some(reach) = self.gather_pressed(scene, group, t) else { return };
        let Some(compliance) = &mut scene.compliance else { return };
        let points = self.touching(scene.pairs, group, (reach, compliance.sides));
        let fastest = points.iter().map(PointOfPair::approach).fold(0.0, f64::max);
        let contact = |point: &PointOfPair<'_>| {
            let places = points.iter().filter(|other| other.actors == point.actors).map(|other| other.place);
            let spread = self.spread(point, places, compliance.sides);
            self.contact(point, (fastest, spread), scene.pairs, compliance.sides)
        };
        let contacts: Vec<GroupContact> = points.iter().map(contact).collect();
        let member = |actor: &Actor| GroupMember {
            side: actor.side(compliance.sides),
            velocity: actor.now.velocity,
            angular_velocity: actor.now.angular_velocity,
        };
        let members: Vec<GroupMember> = self.actors.iter().map(member).collect();
        let time = scene.step.time + t;
        let followed = compliance.modes.followed;
        let impact = GroupImpact { time, members: &members, contacts: &contacts, followed };
        let Some(impulses) = compliance.solver.solve(&impact, compliance.modes.modes) else {
            group.truncate(own);
            self.actors.truncate(bodies);
            return;
        };
        let free = self.actors.iter().enumerate().filter(|(_, actor)| actor.now.inverse_mass > 0.0);
        scene.log.solved_loads(free.filter_map(|(index, actor)| {
            let history = compliance.solver.load_history(&impact, index)?;
            Some((actor.now.pose_row(time, actor.body), history))
        }));
        let solved: Vec<BlockPoint> = points
            .iter()
            .zip(impulses)
            .map(|(at, impulse)| {
                let [a, b] = at.actors;
                let along = impulse.dot(at.normal);
                BlockPoint {
                    gap: at.point.gap,
                    before: at.velocity,
                    impulse_n: along,
                    impulse_t: impulse - along * at.normal,
                    ..BlockPoint::at(at.pair, (a, b), (at.normal, at.place), &self.actors)
                }
            })
            .collect();
        self.replace_points(solved);
        self.apply_and_log(scene, time, true);
        group.sort_unstable();
    }

    /// Adds the pairs that take part in the impacts of the group, and returns the distance \[m\] that its
    /// fastest approach closes in the time of the contact; `None` if no contact is to be solved.
    fn gather_pressed(&mut self, scene: &mut Scene<'_>, group: &mut Vec<usize>, t: f64) -> Option<f64> {
        let compliance = scene.compliance.as_ref()?;
        self.vibrates = self.actors.iter().any(|actor| compliance.vibrates(actor.body));
        if self.is_linked() {
            return None;
        }
        if group.iter().any(|pair| scene.pairs[*pair].hits >= ELASTIC_HITS) {
            return None;
        }
        let time = scene.step.time + t;
        if self.actors.iter().any(|actor| compliance.solver.is_pressed(BodyId(actor.body as u32), time)) {
            return None;
        }
        let modes = compliance.modes.modes;
        let (mut met, mut matter) = (false, false);
        let mut vibrates = |pair: &Pair, contact: &GroupContact| {
            let one = pair.ends().iter().any(|body| compliance.gives_way(*body));
            let matters = one && compliance.solver.matters(contact, modes);
            (met, matter) = (met || one, matter || matters);
            matters
        };
        let reach = self.closing_distance(scene, group, &mut vibrates);
        // Modes that do not matter take nothing.
        self.vibrates &= !met || matter;
        if let Some(reach) = reach {
            self.add_other_parts(scene, group, t);
            return Some(reach);
        }
        let mut balls =
            |pair: &Pair, _: &GroupContact| pair.ends().iter().all(|body| scene.is_free_ball(*body));
        let reach = self.closing_distance(scene, group, &mut balls)?;
        self.add_pressed_balls(scene, group, (reach, t)).then_some(reach)
    }

    /// Distance \[m\] that the fastest approach of the group closes in the time of the contact, among the
    /// impacts that are `solved`.
    fn closing_distance(
        &self,
        scene: &Scene<'_>,
        group: &[usize],
        solved: &mut dyn FnMut(&Pair, &GroupContact) -> bool,
    ) -> Option<f64> {
        let compliance = scene.compliance.as_ref()?;
        let mut reach: Option<f64> = None;
        for &index in group {
            let pair = &scene.pairs[index];
            let slowest = compliance.modes.v_min.max(rest_speed(&pair.coefficients.restitution, &scene.step));
            let meeting: Vec<PointOfPair<'_>> = self
                .points_of(index, pair)
                .filter(|at| at.approach() > slowest && at.point.gap <= TOUCHING + TOGETHER * at.approach())
                .collect();
            let fastest = meeting.iter().max_by(|a, b| a.approach().total_cmp(&b.approach()));
            let Some(fastest) = fastest else { continue };
            let spread = self.spread(fastest, meeting.iter().map(|at| at.place), compliance.sides);
            let contact = self.contact(fastest, (fastest.approach(), spread), scene.pairs, compliance.sides);
            if solved(pair, &contact) {
                let closed = HORIZON * contact.duration() * contact.approach;
                reach = Some(reach.map_or(closed, |reach| reach.max(closed)));
            }
        }
        reach
    }

    /// Adds the pairs of other parts of the same bodies. Their predictions are renewed after the impulses.
    fn add_other_parts(&self, scene: &mut Scene<'_>, group: &mut Vec<usize>, t: f64) {
        let takes_part = |body: u32| self.actors.iter().any(|actor| actor.body == body as usize);
        let mut others: Vec<usize> = Vec::new();
        for actor in self.actors.iter().filter(|actor| actor.now.inverse_mass > 0.0) {
            for &index in scene.neighbours.of(actor.body) {
                let (index, pair) = (index as usize, &scene.pairs[index as usize]);
                let meets = takes_part(pair.key.a) && takes_part(pair.key.b);
                if meets && pair.live && !group.contains(&index) && !others.contains(&index) {
                    others.push(index);
                }
            }
        }
        others.sort_unstable();
        for &index in &others {
            scene.pairs[index].find_exactly(scene.bodies, scene.shapes, &scene.step, t, scene.scratch);
        }
        group.extend(others);
    }

    /// Points of a pair at the instant of the block.
    fn points_of<'p>(&self, index: usize, pair: &'p Pair) -> impl Iterator<Item = PointOfPair<'p>> {
        let find = |body: u32| self.actors.iter().position(|actor| actor.body == body as usize);
        let actors = find(pair.key.a).zip(find(pair.key.b));
        actors.into_iter().flat_map(move |(a, b)| {
            let normal = pair.exact.normal;
            let (now_a, now_b) = (self.actors[a].now, self.actors[b].now);
            pair.exact.points.iter().map(move |point| {
                let place = (point.on_a + point.on_b) * 0.5;
                let velocity =
                    now_a.velocity_at(place - now_a.position) - now_b.velocity_at(place - now_b.position);
                PointOfPair { pair: index, point, actors: [a, b], normal, place, velocity }
            })
        })
    }

    /// The contacts of the group whose gaps are within `reach` \[m\], each place once.
    fn touching<'p>(
        &self,
        pairs: &'p [Pair],
        group: &[usize],
        (reach, sides): (f64, &[BodySide]),
    ) -> Vec<PointOfPair<'p>> {
        let radius = |actor: usize| sides[self.actors[actor].body].side.bounding_radius;
        let mut points: Vec<PointOfPair<'p>> = Vec::new();
        for &index in group {
            for at in self.points_of(index, &pairs[index]) {
                let known = points.iter().any(|other| {
                    other.actors == at.actors
                        && other.normal.dot(at.normal) > ONE_NORMAL
                        && other.place.distance(at.place)
                            < ONE_PLACE * radius(at.actors[0]).min(radius(at.actors[1]))
                });
                if at.point.gap <= reach && !known {
                    points.push(at);
                }
            }
        }
        points
    }

    /// How the points of the pair of a point share its contact.
    fn spread(
        &self,
        at: &PointOfPair<'_>,
        places: impl Iterator<Item = DVec3> + Clone,
        sides: &[BodySide],
    ) -> Spread {
        let [a, b] = at.actors.map(|actor| sides[self.actors[actor].body].side.bounding_radius);
        let size = a.min(b);
        Spread::of_places(places, size, ONE_PLACE * size)
    }

    /// A contact of a group whose fastest approach is `fastest` [m/s]: about as fast a contact meets that is
    /// pushed through others.
    fn contact(
        &self,
        at: &PointOfPair<'_>,
        (fastest, spread): (f64, Spread),
        pairs: &[Pair],
        sides: &[BodySide],
    ) -> GroupContact {
        let meeting = if at.approach() > 0.0 { at.approach() } else { fastest };
        let coefficients = &pairs[at.pair].coefficients;
        let touch = Touch {
            surfaces: at.actors.map(|actor| Some(&*sides[self.actors[actor].body].surface)),
            normal: at.normal,
            place: at.place,
            speed: meeting,
            spread,
        };
        GroupContact {
            members: at.actors,
            sides: touching(at.actors.map(|actor| self.actors[actor].side(sides)), &touch),
            place: at.place,
            normal: at.normal,
            gap: at.point.gap,
            approach: at.approach(),
            restitution: coefficients.restitution.at(meeting),
            friction: coefficients.friction,
        }
    }
}
