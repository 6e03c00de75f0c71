//! Bodies and shapes for the tests of the time-stepped solver.

use std::f64::consts::TAU;

use clangor_core::body::{Body, MeshSurface, Motion, Surface, World};
use clangor_core::geometry::convex::ConvexPart;
use clangor_core::geometry::hull::convex_hull;
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::glam::{DMat3, DQuat, DVec3};
use clangor_core::material::{Damping, Material};
use clangor_core::pose::Pose;
use clangor_core::shape::Shape;

/// xorshift64: seeded, so that every run sees the same numbers.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    /// Uniform in 0..1.
    pub(crate) fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Uniform in −1..1.
    pub(crate) fn signed(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    /// A uniform direction.
    pub(crate) fn direction(&mut self) -> DVec3 {
        loop {
            let v = DVec3::new(self.signed(), self.signed(), self.signed());
            if (0.01..1.0).contains(&v.length_squared()) {
                return v.normalize();
            }
        }
    }

    /// A random orientation.
    pub(crate) fn orientation(&mut self) -> DQuat {
        let axis = self.direction();
        DQuat::from_axis_angle(axis, self.unit() * TAU)
    }
}

/// A material with these losses.
pub(crate) fn material(density: f64, restitution: f64, friction: f64, rolling_loss: f64) -> Material {
    Material {
        name: "test".into(),
        density,
        youngs_modulus: 2e11,
        poisson_ratio: 0.3,
        restitution,
        restitution_speed: None,
        rigid_restitution: None,
        yield_strength: None,
        friction,
        rolling_loss,
        damping: Damping::T60(1.0),
        tensile_strength: None,
        fracture_energy: None,
        source: "none".into(),
    }
}

/// A body with everything at rest at the origin.
fn body(name: &str, material: &Material, surface: Surface, mass: f64, inertia: DMat3) -> Body {
    Body::new(name, material.clone(), surface, mass, inertia).with_edge_radius(1e-3)
}

/// A fixed plane through `point` with this outward normal.
pub(crate) fn plane(material: &Material, normal: DVec3, point: DVec3) -> Body {
    let mut plane = body("plane", material, Surface::HalfSpace, f64::INFINITY, DMat3::IDENTITY);
    plane.pose = Pose { position: point, orientation: DQuat::from_rotation_arc(DVec3::Y, normal) };
    plane.motion = Motion::Fixed;
    plane
}

/// The floor y = 0.
pub(crate) fn floor(material: &Material) -> Body {
    plane(material, DVec3::Y, DVec3::ZERO)
}

/// A ball.
pub(crate) fn ball(material: &Material, radius: f64) -> Body {
    let mass = material.density * 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
    let inertia = DMat3::from_diagonal(DVec3::splat(0.4 * mass * radius * radius));
    body("ball", material, Surface::Sphere { radius }, mass, inertia)
}

/// A smooth cylinder about y.
pub(crate) fn cylinder(material: &Material, radius: f64, half_height: f64) -> Body {
    let mass = material.density * std::f64::consts::PI * radius * radius * 2.0 * half_height;
    let across = mass * (3.0 * radius * radius + 4.0 * half_height * half_height) / 12.0;
    let inertia = DMat3::from_diagonal(DVec3::new(across, 0.5 * mass * radius * radius, across));
    let part = ConvexPart::Cylinder { centre: DVec3::ZERO, axis: DVec3::Y, radius, half_height };
    let mesh = convex_hull(&prism(24, radius, half_height)).expect("a prism is a solid");
    let (surface, _) = MeshSurface::try_new(mesh, vec![part]).expect("a prism is a solid");
    body("cylinder", material, Surface::Mesh(surface), mass, inertia)
}

/// A body whose solid is the union of convex hulls that do not overlap.
pub(crate) fn solid(name: &str, material: &Material, hulls: &[Vec<DVec3>]) -> Body {
    let meshes: Vec<_> = hulls.iter().map(|h| convex_hull(h).expect("a test hull has volume")).collect();
    let pieces: Vec<_> = meshes.iter().map(|m| MassProperties::of(m).expect("a hull is a solid")).collect();
    let volume: f64 = pieces.iter().map(|p| p.volume).sum();
    let centre = pieces.iter().map(|p| p.centre_of_mass * p.volume).sum::<DVec3>() / volume;
    let mut inertia = DMat3::ZERO;
    for piece in &pieces {
        let d = piece.centre_of_mass - centre;
        let outer = DMat3::from_cols(d * d.x, d * d.y, d * d.z);
        inertia += piece.inertia + (DMat3::IDENTITY * d.length_squared() - outer) * piece.volume;
    }
    let moved: Vec<Vec<DVec3>> = hulls.iter().map(|h| h.iter().map(|p| *p - centre).collect()).collect();
    let all: Vec<DVec3> = moved.iter().flatten().copied().collect();
    let mesh = convex_hull(&all).expect("a test body has volume");
    let parts = moved.into_iter().map(ConvexPart::Hull).collect();
    let (surface, _) = MeshSurface::try_new(mesh, parts).expect("a hull is a solid");
    body(name, material, Surface::Mesh(surface), material.density * volume, inertia * material.density)
}

/// A world with gravity along −y and no links.
pub(crate) fn world(bodies: Vec<Body>) -> World {
    World { bodies, links: Vec::new(), gravity: DVec3::new(0.0, -9.81, 0.0) }
}

/// Prism over a regular polygon, axis y.
pub(crate) fn prism(corners: usize, radius: f64, half_height: f64) -> Vec<DVec3> {
    [-half_height, half_height]
        .into_iter()
        .flat_map(|y| {
            (0..corners).map(move |i| {
                let angle = i as f64 * TAU / corners as f64;
                DVec3::new(radius * angle.cos(), y, radius * angle.sin())
            })
        })
        .collect()
}

/// A cube with bevelled corners.
pub(crate) fn die(half: f64, bevel: f64) -> Vec<DVec3> {
    let mut points = Vec::new();
    for corner in 0..8 {
        let sign = |bit: usize| if corner >> bit & 1 == 1 { 1.0 } else { -1.0 };
        for k in 0..3 {
            let mut p = DVec3::new(sign(0), sign(1), sign(2)) * half;
            p[k] = sign(k) * (half - bevel);
            points.push(p);
        }
    }
    points
}

/// A box.
pub(crate) fn cuboid(half: DVec3) -> Vec<DVec3> {
    (0..8)
        .map(|corner| {
            let sign = |bit: usize| if corner >> bit & 1 == 1 { 1.0 } else { -1.0 };
            DVec3::new(sign(0), sign(1), sign(2)) * half
        })
        .collect()
}

/// An irregular convex stone.
pub(crate) fn rock(seed: u64, points: usize, radius: f64) -> Vec<DVec3> {
    let mut random = Random(seed);
    (0..points)
        .map(|_| {
            let d = random.direction();
            d * DVec3::new(1.0, 0.85, 0.7) * (radius * (0.85 + 0.15 * random.unit()))
        })
        .collect()
}

/// A splinter: the cell of a slab cut by random planes, as a Voronoi fracture makes them.
pub(crate) fn shard(seed: u64, size: f64, half_thickness: f64) -> Vec<DVec3> {
    let mut random = Random(seed);
    let mut planes: Vec<(DVec3, f64)> = [DVec3::X, DVec3::Z]
        .into_iter()
        .flat_map(|n| [(n, size), (-n, size)])
        .chain([(DVec3::Y, half_thickness), (DVec3::NEG_Y, half_thickness)])
        .collect();
    for _ in 0..14 {
        let p = DVec3::new(
            random.signed() * 1.6 * size,
            random.signed() * half_thickness,
            random.signed() * 1.6 * size,
        );
        if p.length() > 0.3 * size {
            planes.push((p.normalize(), 0.5 * p.length()));
        }
    }
    let mut points: Vec<DVec3> = Vec::new();
    for i in 0..planes.len() {
        for j in i + 1..planes.len() {
            for k in j + 1..planes.len() {
                let normals = DMat3::from_cols(planes[i].0, planes[j].0, planes[k].0).transpose();
                if normals.determinant().abs() < 1e-6 {
                    continue;
                }
                let p = normals.inverse() * DVec3::new(planes[i].1, planes[j].1, planes[k].1);
                let inside = planes.iter().all(|(n, d)| n.dot(p) < d + 1e-9);
                if inside && points.iter().all(|q| (*q - p).length() > 1e-6) {
                    points.push(p);
                }
            }
        }
    }
    points
}

/// A torus about y as convex sectors.
pub(crate) fn ring(major: f64, minor: f64, sectors: usize, sides: usize) -> Vec<Vec<DVec3>> {
    (0..sectors)
        .map(|i| {
            (0..2 * sides)
                .map(|k| {
                    let angle = (i + k / sides) as f64 * TAU / sectors as f64;
                    let turn = (k % sides) as f64 * TAU / sides as f64;
                    let r = major + minor * turn.cos();
                    DVec3::new(r * angle.cos(), minor * turn.sin(), r * angle.sin())
                })
                .collect()
        })
        .collect()
}

/// A wall of revolution about y between profile points (radius inside, radius outside, height), as convex
/// sectors.
fn turned(profile: &[(f64, f64, f64)], sectors: usize) -> Vec<Vec<DVec3>> {
    let mut hulls = Vec::new();
    for pair in profile.windows(2) {
        for i in 0..sectors {
            let mut hull = Vec::new();
            for &(inner, outer, y) in pair {
                for angle in [i, i + 1].map(|k| k as f64 * TAU / sectors as f64) {
                    for r in [inner, outer] {
                        hull.push(DVec3::new(r * angle.cos(), y, r * angle.sin()));
                    }
                }
            }
            hulls.push(hull);
        }
    }
    hulls
}

/// A bowl: a floor and a flaring wall.
pub(crate) fn bowl() -> Vec<Vec<DVec3>> {
    let mut hulls = turned(
        &[(0.012, 0.016, 0.002), (0.034, 0.038, 0.014), (0.045, 0.049, 0.032), (0.048, 0.052, 0.045)],
        16,
    );
    hulls.push(prism(16, 0.0159, 0.002));
    hulls
}

/// A mug: a floor, a wall and a handle of three bars.
pub(crate) fn mug() -> Vec<Vec<DVec3>> {
    let mut hulls = turned(&[(0.036, 0.040, 0.004), (0.036, 0.040, 0.095)], 16);
    hulls.push(prism(16, 0.040, 0.004));
    let bar = |low: DVec3, high: DVec3| {
        cuboid((high - low) * 0.5).iter().map(|p| *p + (low + high) * 0.5).collect()
    };
    hulls.push(bar(DVec3::new(0.040, 0.020, -0.005), DVec3::new(0.068, 0.028, 0.005)));
    hulls.push(bar(DVec3::new(0.040, 0.070, -0.005), DVec3::new(0.068, 0.078, 0.005)));
    hulls.push(bar(DVec3::new(0.060, 0.028, -0.005), DVec3::new(0.068, 0.070, 0.005)));
    hulls
}

/// A key: a bow with a hole, a shaft and two teeth.
pub(crate) fn key() -> Vec<Vec<DVec3>> {
    let thin = 0.001;
    let mut hulls: Vec<Vec<DVec3>> = turned(&[(0.004, 0.011, -thin), (0.004, 0.011, thin)], 12);
    let bar = |x0: f64, x1: f64, z0: f64, z1: f64| {
        let (low, high) = (DVec3::new(x0, -thin, z0), DVec3::new(x1, thin, z1));
        cuboid((high - low) * 0.5).iter().map(|p| *p + (low + high) * 0.5).collect()
    };
    hulls.push(bar(0.011, 0.045, -0.003, 0.003));
    hulls.push(bar(0.034, 0.038, 0.003, 0.007));
    hulls.push(bar(0.041, 0.045, 0.003, 0.006));
    hulls
}

/// Rocks on a grid above the floor of a box of planes, spinning; the planes come first.
pub(crate) fn rock_pile(rocks: usize, half: f64, material: &Material, seed: u64) -> World {
    let mut random = Random(seed);
    let mut bodies = vec![floor(material)];
    for normal in [DVec3::X, DVec3::NEG_X, DVec3::Z, DVec3::NEG_Z] {
        bodies.push(plane(material, normal, -normal * half));
    }
    let kinds: Vec<Body> =
        (0..10).map(|k| solid("rock", material, &[rock(seed + k, 16 + k as usize % 3 * 4, 0.015)])).collect();
    let spacing = 0.034;
    let per_row = (2.0 * (half - 0.018) / spacing) as usize + 1;
    for i in 0..rocks {
        let cell =
            DVec3::new((i % per_row) as f64, (i / per_row / per_row) as f64, (i / per_row % per_row) as f64);
        let mut body = kinds[i % kinds.len()].clone();
        body.name = format!("rock {i}");
        body.pose.position = DVec3::new(0.019 - half, 0.03, 0.019 - half) + cell * spacing;
        body.pose.orientation = random.orientation();
        body.velocity = DVec3::new(random.signed(), random.signed(), random.signed()) * 0.1;
        body.angular_velocity = random.direction() * 3.0;
        bodies.push(body);
    }
    world(bodies)
}

/// A named shape, such as `mug` or `rock:3x0.015`.
pub(crate) fn named(text: &str, material: &Material) -> Body {
    let shape = Shape::parse(text).expect("a test names a shape");
    let (surface, solid) = shape.surface().expect("a named shape is a solid");
    body(text, material, surface, material.density * solid.volume, solid.inertia * material.density)
}
