//! Random placement: copies of bodies in a box, without contact to each other or to other bodies.
//!
//! Random sequential addition: a centre is drawn uniformly in the region and kept if the copy's bounding ball
//! does not touch anything placed before it. Bounding balls are sufficient because the copies fall and mix
//! anyway. They jam at about 38 % of the volume, so a region should be several times larger than its balls.
//! Other bodies keep their true surface, so that coins may start inside a bowl.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DQuat, DVec3};

use crate::body::{Body, Surface};
use crate::math::random::SplitMix;
use crate::pose::Pose;

/// Draws per copy before the region counts as full.
const MAX_DRAWS: usize = 2000;

/// Gap kept between bounding balls, as a fraction of the copy's radius.
const CLEARANCE: f64 = 1e-3;

/// Uniform in a box.
fn in_box(random: &mut SplitMix, [low, high]: [DVec3; 2]) -> DVec3 {
    let x = random.uniform(low.x, high.x);
    let y = random.uniform(low.y, high.y);
    let z = random.uniform(low.z, high.z);
    DVec3::new(x, y, z)
}

/// Uniform in the unit ball, by rejection.
pub(super) fn in_ball(random: &mut SplitMix) -> DVec3 {
    loop {
        let point = in_box(random, [DVec3::NEG_ONE, DVec3::ONE]);
        if point.length_squared() <= 1.0 {
            return point;
        }
    }
}

/// A point of the unit disc other than its centre, and its squared radius.
fn in_disc(random: &mut SplitMix) -> (f64, f64, f64) {
    loop {
        let (x, y) = (random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0));
        let squared = x * x + y * y;
        if squared > 0.0 && squared <= 1.0 {
            return (x, y, squared);
        }
    }
}

/// Uniform over all rotations (Marsaglia 1972), without trigonometry, so that every machine draws the same
/// bits.
pub(super) fn rotation(random: &mut SplitMix) -> DQuat {
    let (x, y, s) = in_disc(random);
    let (z, w, t) = in_disc(random);
    let root = ((1.0 - s) / t).sqrt();
    DQuat::from_xyzw(x, y, z * root, w * root).normalize()
}

/// A body that copies must not touch.
pub(super) struct Obstacle {
    surface: Arc<Surface>,
    pose: Pose,
    bounding_radius: f64,
}

impl Obstacle {
    /// A placed body.
    pub(super) fn of(body: &Body) -> Self {
        Obstacle {
            surface: Arc::clone(&body.surface),
            pose: body.pose,
            bounding_radius: body.surface.bounding_radius(),
        }
    }

    /// Whether a ball is clear of the body.
    fn clears(&self, centre: DVec3, radius: f64) -> bool {
        let local = self.pose.body_from_world(centre);
        if local.length() >= self.bounding_radius + radius {
            return true;
        }
        match &*self.surface {
            Surface::Sphere { .. } => false,
            Surface::HalfSpace | Surface::Plate { .. } => local.y >= radius,
            Surface::Mesh(surface) => surface.signed_distance(local) >= radius,
        }
    }
}

/// Copies placed so far, and the bodies before them.
pub(super) struct Packing {
    obstacles: Vec<Obstacle>,
    cell: f64,
    /// Balls by cell; looked up by key only, never iterated.
    cells: HashMap<[i64; 3], Vec<(DVec3, f64)>>,
}

impl Packing {
    /// A packing for balls of at most `max_radius` [m].
    pub(super) fn new(obstacles: Vec<Obstacle>, max_radius: f64) -> Self {
        Packing { obstacles, cell: 2.0 * max_radius * (1.0 + CLEARANCE), cells: HashMap::new() }
    }

    /// Finds a centre in the region for a ball and takes it; `None` if the region counts as full.
    pub(super) fn place(&mut self, region: [DVec3; 2], radius: f64, random: &mut SplitMix) -> Option<DVec3> {
        for _ in 0..MAX_DRAWS {
            let centre = in_box(random, region);
            if self.is_free(centre, radius) {
                self.cells.entry(self.cell_of(centre)).or_default().push((centre, radius));
                return Some(centre);
            }
        }
        None
    }

    fn is_free(&self, centre: DVec3, radius: f64) -> bool {
        let reach = radius * (1.0 + CLEARANCE);
        if !self.obstacles.iter().all(|o| o.clears(centre, reach)) {
            return false;
        }
        let [x, y, z] = self.cell_of(centre);
        let neighbours = (0..27).map(|i: i64| [x + i % 3 - 1, y + i / 3 % 3 - 1, z + i / 9 - 1]);
        let mut balls = neighbours.filter_map(|cell| self.cells.get(&cell)).flatten();
        balls.all(|(other, other_radius)| (centre - *other).length() >= reach + other_radius)
    }

    fn cell_of(&self, point: DVec3) -> [i64; 3] {
        // Saturating casts: far outside, all points share a cell, which is slow but right.
        let cell = (point / self.cell).floor().clamp(DVec3::splat(-1e15), DVec3::splat(1e15));
        [cell.x as i64, cell.y as i64, cell.z as i64]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn placed_balls_keep_apart_and_a_full_region_is_refused() {
        let obstacle = |surface: Surface| {
            let bounding_radius = surface.bounding_radius();
            Obstacle { surface: Arc::new(surface), pose: Pose::IDENTITY, bounding_radius }
        };
        let obstacles = vec![obstacle(Surface::HalfSpace), obstacle(Surface::Sphere { radius: 0.3 })];
        let mut packing = Packing::new(obstacles, 0.05);
        let mut random = SplitMix::new(7);
        let region = [DVec3::new(-0.5, 0.0, -0.5), DVec3::new(0.5, 0.6, 0.5)];
        let mut placed: Vec<(DVec3, f64)> = Vec::new();
        let mut radii = [0.05, 0.02].into_iter().cycle();
        while let Some((radius, centre)) =
            radii.next().and_then(|radius| Some((radius, packing.place(region, radius, &mut random)?)))
        {
            placed.push((centre, radius));
        }
        // Random sequential addition fills between a tenth and the jamming limit of 38 %.
        let volume: f64 = placed.iter().map(|(_, r)| 4.19 * r.powi(3)).sum();
        assert!(volume > 0.05 && volume < 0.3, "{volume}");
        for (i, (a, ra)) in placed.iter().enumerate() {
            assert!(a.y >= *ra && a.length() >= 0.3 + ra);
            assert!(placed[..i].iter().all(|(b, rb)| (*a - *b).length() >= ra + rb));
        }
    }

    #[test]
    fn rotations_have_no_preferred_direction() {
        let mut random = SplitMix::new(1);
        let mean = (0..20_000).map(|_| rotation(&mut random) * DVec3::X).sum::<DVec3>() / 20_000.0;
        // Standard deviation of each component: 1/√(3·20000) = 0.0041. Seen: length 0.0048.
        assert!(mean.length() < 0.02, "{mean}");
    }
}
