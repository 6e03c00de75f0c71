//! Random placement: copies of bodies in a box, none touching another or what stands there already.
//!
//! Random sequential addition: a centre is drawn uniformly in the region and kept if the copy's bounding ball is clear
//! of everything placed before it. Bounding balls are enough because the copies fall and mix anyway; they jam at
//! about 38 % of the volume, so a region should be several times larger than its balls.
//! What stands there is taken as a ball, a half-space, or the box around its mesh, turned with it.

use std::collections::HashMap;

use glam::{DQuat, DVec3};

use crate::body::{Body, Surface};
use crate::pose::Pose;

/// Draws per copy before the region counts as full.
const MAX_DRAWS: usize = 2000;

/// Gap kept between bounding balls, as a fraction of the copy's radius.
const CLEARANCE: f64 = 1e-3;

/// SplitMix64 (Steele, Lea and Flood 2014): a 64-bit generator with a period of 2⁶⁴ whose every seed is good.
pub(super) struct SplitMix64 {
    state: u64,
}

impl SplitMix64 {
    pub(super) fn new(seed: u64) -> Self {
        SplitMix64 { state: seed }
    }

    fn next(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Uniform in [0, 1).
    fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform between two numbers.
    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Uniform in a box.
    fn in_box(&mut self, [low, high]: [DVec3; 2]) -> DVec3 {
        let x = self.between(low.x, high.x);
        let y = self.between(low.y, high.y);
        let z = self.between(low.z, high.z);
        DVec3::new(x, y, z)
    }

    /// Uniform in the unit ball, by rejection.
    pub(super) fn in_ball(&mut self) -> DVec3 {
        loop {
            let point = self.in_box([DVec3::NEG_ONE, DVec3::ONE]);
            if point.length_squared() <= 1.0 {
                return point;
            }
        }
    }

    /// A point of the unit disc other than its centre, and its squared radius.
    fn in_disc(&mut self) -> (f64, f64, f64) {
        loop {
            let (x, y) = (self.between(-1.0, 1.0), self.between(-1.0, 1.0));
            let squared = x * x + y * y;
            if squared > 0.0 && squared <= 1.0 {
                return (x, y, squared);
            }
        }
    }

    /// Uniform over all rotations (Marsaglia 1972), without trigonometry, so that every machine draws the same bits.
    pub(super) fn rotation(&mut self) -> DQuat {
        let (x, y, s) = self.in_disc();
        let (z, w, t) = self.in_disc();
        let root = ((1.0 - s) / t).sqrt();
        DQuat::from_xyzw(x, y, z * root, w * root).normalize()
    }
}

/// Something that copies must not touch.
pub(super) enum Obstacle {
    /// A ball: centre, radius [m].
    Ball(DVec3, f64),
    /// A half-space: point, unit normal out of the solid.
    HalfSpace(DVec3, DVec3),
    /// A box in a body frame: pose, least and greatest corner [m].
    Box(Pose, DVec3, DVec3),
}

impl Obstacle {
    /// What a placed body occupies.
    pub(super) fn of(body: &Body) -> Self {
        match &*body.surface {
            Surface::Sphere { radius } => Obstacle::Ball(body.pose.position, *radius),
            Surface::HalfSpace => Obstacle::HalfSpace(body.pose.position, body.pose.orientation * DVec3::Y),
            Surface::Mesh(surface) => {
                let vertices = &surface.mesh.vertices;
                let low = vertices.iter().fold(DVec3::INFINITY, |low, v| low.min(*v));
                let high = vertices.iter().fold(DVec3::NEG_INFINITY, |high, v| high.max(*v));
                Obstacle::Box(body.pose, low, high)
            }
        }
    }

    /// Distance from a point to the surface [m], negative inside a ball or half-space, 0 in a box.
    fn distance(&self, point: DVec3) -> f64 {
        match self {
            Obstacle::Ball(centre, radius) => (point - *centre).length() - radius,
            Obstacle::HalfSpace(on_plane, normal) => (point - *on_plane).dot(*normal),
            Obstacle::Box(pose, low, high) => {
                let local = pose.body_from_world(point);
                (local - local.clamp(*low, *high)).length()
            }
        }
    }
}

/// Copies placed so far, and what stood there before them.
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
    pub(super) fn place(
        &mut self,
        region: [DVec3; 2],
        radius: f64,
        random: &mut SplitMix64,
    ) -> Option<DVec3> {
        for _ in 0..MAX_DRAWS {
            let centre = random.in_box(region);
            if self.is_free(centre, radius) {
                self.cells.entry(self.cell_of(centre)).or_default().push((centre, radius));
                return Some(centre);
            }
        }
        None
    }

    fn is_free(&self, centre: DVec3, radius: f64) -> bool {
        let reach = radius * (1.0 + CLEARANCE);
        if self.obstacles.iter().any(|o| o.distance(centre) < reach) {
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
        let floor = Obstacle::HalfSpace(DVec3::ZERO, DVec3::Y);
        let mut packing = Packing::new(vec![floor, Obstacle::Ball(DVec3::ZERO, 0.3)], 0.05);
        let mut random = SplitMix64::new(7);
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
        let mut random = SplitMix64::new(1);
        let mean = (0..20_000).map(|_| random.rotation() * DVec3::X).sum::<DVec3>() / 20_000.0;
        // Standard deviation of each component: 1/√(3·20000) = 0.0041. Seen: 0.005.
        assert!(mean.length() < 0.02, "{mean}");
    }
}
