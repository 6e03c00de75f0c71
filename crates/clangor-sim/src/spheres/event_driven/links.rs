//! Rods and springs of a world: the islands of linked balls.

use clangor_core::body::{BodyId, Link, LinkEnd, World};
use glam::DVec3;

use super::ball::Traits;
use super::island::{Far, Island, Rod, Spring};
use super::track::Track;
use crate::SimulationError;
use crate::spheres::spring_pace;

/// Anchors nearer than this, relative to the rods, are one.
const SAME_ANCHOR: f64 = 1e-9;

/// Least radius of the circle on which two rods leave a ball, relative to their lengths.
const LEAST_CIRCLE: f64 = 1e-6;

/// Island of a ball and its place there; `None` for a ball without links.
type IslandPlace = Option<(usize, usize)>;

/// Gathers linked balls into islands: the connected components of the graph of springs, and single balls on
/// rods. Returns the islands, and the island of each ball with its place there.
///
/// # Errors
/// [`SimulationError::NotASphere`] for a link that cannot be simulated.
pub(super) fn link_islands(
    world: &World,
    traits: &[Traits],
) -> Result<(Vec<Island>, Vec<IslandPlace>), SimulationError> {
    let mut ball_of = vec![None; world.bodies.len()];
    for (ball, traits) in traits.iter().enumerate().filter(|(_, t)| t.free) {
        ball_of[traits.body as usize] = Some(ball);
    }
    let mut linked = Linked { world, ball_of, islands: Vec::new(), island_places: vec![None; traits.len()] };
    linked.find_islands(traits);
    for link in &world.links {
        match link {
            Link::Hang { body, anchor } => linked.add_rod(*body, *anchor)?,
            Link::Spring { .. } if link.joins_centres() => linked.add_spring(link)?,
            Link::Spring { body, .. } => return linked.refuse(*body, "a spring holds it off its centre"),
            Link::Joint { body, .. } => return linked.refuse(*body, "it has a joint, a rod or a rope"),
            Link::Load { body, .. } => return linked.refuse(*body, "a force acts on it over time"),
        }
    }
    if let Some(island) = linked.islands.iter().find(|island| island.spring_rate() > spring_pace::FASTEST) {
        let body = island.balls.first().map_or(0, |&ball| traits[ball].body);
        return linked
            .refuse(BodyId(body), "a spring moves it faster than every oscillation can be followed");
    }
    Ok((linked.islands, linked.island_places))
}

/// The linked balls of a world.
struct Linked<'a> {
    world: &'a World,
    /// Free ball of each body.
    ball_of: Vec<Option<usize>>,
    islands: Vec<Island>,
    island_places: Vec<IslandPlace>,
}

impl Linked<'_> {
    /// Finds the connected components; the lowest ball represents its island.
    fn find_islands(&mut self, traits: &[Traits]) {
        let mut root: Vec<usize> = (0..traits.len()).collect();
        let mut linked = vec![false; traits.len()];
        for link in &self.world.links {
            let balls: Vec<usize> = link.bodies().filter_map(|b| self.ball_of[b.index()]).collect();
            for &ball in &balls {
                linked[ball] = true;
            }
            if let [one, two] = balls[..] {
                let (one, two) = (root_of(&root, one), root_of(&root, two));
                root[one.max(two)] = one.min(two);
            }
        }
        for ball in (0..traits.len()).filter(|&b| linked[b]) {
            let island = match self.island_places[root_of(&root, ball)] {
                Some((island, _)) => island,
                None => {
                    self.islands.push(Island::new(Vec::new(), Vec::new(), self.world.gravity));
                    self.islands.len() - 1
                }
            };
            let members = &mut self.islands[island];
            self.island_places[ball] = Some((island, members.balls.len()));
            members.balls.push(ball);
            members.masses.push(traits[ball].mass);
        }
    }

    fn island_place(&self, body: BodyId) -> IslandPlace {
        self.ball_of[body.index()].and_then(|ball| self.island_places[ball])
    }

    fn position(&self, body: BodyId) -> DVec3 {
        self.world.bodies[body.index()].pose.position
    }

    fn refuse<T>(&self, body: BodyId, reason: &'static str) -> Result<T, SimulationError> {
        let body = self.world.bodies[body.index()].name.clone();
        Err(SimulationError::NotASphere { body, reason })
    }

    fn add_rod(&mut self, body: BodyId, anchor: DVec3) -> Result<(), SimulationError> {
        let Some((place, ball)) = self.island_place(body) else {
            return self.refuse(body, "it hangs, but it is not a free sphere");
        };
        let length = self.position(body).distance(anchor);
        if !(length > 0.0 && length.is_finite()) {
            return self.refuse(body, "the rod on which it hangs has no length");
        }
        let centre = self.position(body);
        let island = &self.islands[place];
        let others: Vec<&Rod> = island.rods.iter().filter(|r| r.ball == ball).collect();
        if others.iter().any(|r| r.anchor.distance(anchor) <= SAME_ANCHOR * length) {
            // The same rod again.
            return Ok(());
        }
        let track = match others[..] {
            [] => Track { ball, centre: anchor, axis: DVec3::ZERO, radius: length },
            [first] => {
                let axis = (anchor - first.anchor).normalize();
                let foot = anchor + axis * axis.dot(centre - anchor);
                Track { ball, centre: foot, axis, radius: centre.distance(foot) }
            }
            _ => return self.refuse(body, "it hangs on more than two rods"),
        };
        if track.radius <= LEAST_CIRCLE * length {
            return self.refuse(body, "its two rods are in one line, so it cannot move");
        }
        let island = &mut self.islands[place];
        island.rods.push(Rod { ball, anchor });
        island.tracks.retain(|t| t.ball != ball);
        island.tracks.push(track);
        Ok(())
    }

    /// Adds a spring to the island of its free ends; a spring between two fixed bodies has no effect.
    fn add_spring(&mut self, link: &Link) -> Result<(), SimulationError> {
        let Link::Spring { body, to, rest_length, stiffness, damping, .. } = *link else { return Ok(()) };
        if ![rest_length, stiffness, damping].iter().all(|x| *x >= 0.0 && x.is_finite()) {
            return self.refuse(body, "its spring has a negative or infinite coefficient");
        }
        let (far_place, far_point, far_id) = match to {
            LinkEnd::Point(point) => (None, point, BodyId::WORLD),
            LinkEnd::Body { body: other, .. } => (self.island_place(other), self.position(other), other),
        };
        let (island, ball, to, far_body) = match (self.island_place(body), far_place) {
            (Some((island, ball)), Some((_, other))) => (island, ball, Far::Ball(other), BodyId::WORLD),
            (Some((island, ball)), None) => (island, ball, Far::Point(far_point), far_id),
            // The free ball is at the far end.
            (None, Some((island, ball))) => (island, ball, Far::Point(self.position(body)), body),
            (None, None) => return Ok(()),
        };
        let spring = Spring { ball, to, far_body, rest_length, stiffness, damping };
        self.islands[island].springs.push(spring);
        Ok(())
    }
}

/// Representative of the component that holds a ball.
fn root_of(root: &[usize], mut ball: usize) -> usize {
    while root[ball] != ball {
        ball = root[ball];
    }
    ball
}
