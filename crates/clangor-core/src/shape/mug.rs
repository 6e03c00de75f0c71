//! A mug: a cup of revolution with a handle, one surface. It stands on y = 0, the handle towards +x.
//!
//! 84 mm wide, 98 mm high, walls of 5 mm; \[PAN\] prints no size.
//!
//! The outer wall has a grid with two rectangular holes; a tube from the border of one to the border of the
//! other is the handle. It follows half an ellipse, so that it meets the wall at right angles.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DMat3, DVec2, DVec3};

use crate::geometry::convex::ConvexPart;
use crate::geometry::tri_mesh::TriMesh;
use crate::shape::axisymmetric::{Profile, Ring, axisymmetric_hull, balance, lace, wedges};

const RADIUS: f64 = 0.042;
const HEIGHT: f64 = 0.098;
const WALL: f64 = 0.005;
const FLOOR: f64 = 0.007;
/// Heights of the middles of the handle's roots \[m\].
const ROOTS: [f64; 2] = [0.024, 0.074];
/// Half width (along z) and half thickness of the handle \[m\].
const HANDLE: [f64; 2] = [0.006, 0.004];
/// How far the middle of the handle stands out \[m\].
const REACH: f64 = 0.028;

/// The cup without its handle.
fn profile(edge: f64) -> Profile {
    let inside = RADIUS - WALL;
    let top = HEIGHT - 0.5 * WALL;
    let mut profile = Profile::start(DVec2::ZERO, edge, 0.1 * WALL).line_to(RADIUS, 0.0);
    for root in ROOTS {
        profile = profile.line_to(RADIUS, root - HANDLE[1]).line_to(RADIUS, root + HANDLE[1]);
    }
    profile
        .line_to(RADIUS, top)
        .arc_to(DVec2::new(RADIUS - 0.5 * WALL, top), DVec2::new(inside, top), 1.0)
        .line_to(inside, FLOOR)
        .line_to(0.0, FLOOR)
}

pub(super) fn mug_mesh(edge: f64) -> TriMesh {
    let profile = profile(edge);
    let half_turn = (HANDLE[0] / RADIUS).asin() / TAU;
    let across = (2.0 * HANDLE[0] / edge).ceil().max(2.0) as usize;
    let rest = profile.even_turns(RADIUS).len();
    // The wall's angles: first across the handle's root, then around the rest.
    let mut wall: Vec<f64> = (0..across).map(|k| 2.0 * half_turn * k as f64 / across as f64).collect();
    wall.extend((0..rest).map(|k| 2.0 * half_turn + (1.0 - 2.0 * half_turn) * k as f64 / rest as f64));
    let rings: Vec<Ring> = profile
        .points()
        .iter()
        .map(|p| {
            let turns = if p.x == RADIUS { wall.clone() } else { profile.even_turns(p.x) };
            Ring { radius: p.x, y: p.y, turns }
        })
        .collect();
    let first: Vec<u32> = rings
        .iter()
        .scan(0, |next, ring| {
            let start = *next;
            *next += ring.turns.len() as u32;
            Some(start)
        })
        .collect();
    let mut mesh = lace(&rings, false);
    // The root in the middle of +x.
    let turn = DMat3::from_rotation_y(-TAU * half_turn);
    mesh.vertices.iter_mut().for_each(|v| *v = turn * *v);

    let holes = ROOTS.map(|root| Hole::new(&rings, &first, root, across));
    let mut cut = vec![0_u8; mesh.vertices.len()];
    for (hole, mark) in holes.iter().zip([1, 2]) {
        hole.vertices().for_each(|v| cut[v as usize] = mark);
    }
    mesh.triangles.retain(|t| {
        let marks = t.map(|v| cut[v as usize]);
        marks[0] == 0 || marks[0] != marks[1] || marks[1] != marks[2]
    });
    add_handle(&mut mesh, &holes, edge);
    // Points inside the holes have no triangles left.
    mesh.weld(0.0)
}

/// A rectangle of the wall's grid: `rows` + 1 rings of `across` + 1 points.
struct Hole {
    /// First vertex of each ring.
    rings: Vec<u32>,
    across: usize,
}

impl Hole {
    fn new(rings: &[Ring], first: &[u32], root: f64, across: usize) -> Self {
        // Half a thickness of slack: the next ring beyond is farther than that or a root's border itself.
        let within = |ring: &Ring| ring.radius == RADIUS && (ring.y - root).abs() <= HANDLE[1] * (1.0 + 1e-9);
        let rings =
            rings.iter().zip(first).filter(|(ring, _)| within(ring)).map(|(_, start)| *start).collect();
        Hole { rings, across }
    }

    fn rows(&self) -> usize {
        self.rings.len() - 1
    }

    fn vertices(&self) -> impl Iterator<Item = u32> {
        self.rings.iter().flat_map(|start| (0..=self.across as u32).map(move |k| start + k))
    }

    /// The border, counter-clockwise seen from outside, as positions (across, row).
    fn border(&self) -> Vec<(usize, usize)> {
        let (across, rows) = (self.across, self.rows());
        let bottom = (0..across).map(|a| (a, 0));
        let side = (0..rows).map(|b| (across, b));
        let top = (0..across).map(|a| (across - a, rows));
        let back = (0..rows).map(|b| (0, rows - b));
        bottom.chain(side).chain(top).chain(back).collect()
    }
}

/// Centre and inward normal (towards the inside of the handle's bow) at an angle from −π/2 to π/2.
fn bow(angle: f64) -> (DVec3, DVec3) {
    let half = 0.5 * (ROOTS[1] - ROOTS[0]);
    let (sin, cos) = angle.sin_cos();
    let centre = DVec3::new(RADIUS + REACH * cos, 0.5 * (ROOTS[0] + ROOTS[1]) + half * sin, 0.0);
    let tangent = DVec3::new(-REACH * sin, half * cos, 0.0).normalize();
    (centre, DVec3::new(-tangent.y, tangent.x, 0.0))
}

/// 0 where the section is the rectangle of a root, 1 where it is an ellipse.
fn roundness(angle: f64) -> f64 {
    (2.0 * angle.cos()).clamp(0.0, 1.0)
}

/// The tube between the two holes. Its section turns from the rectangle of the root into an ellipse.
fn add_handle(mesh: &mut TriMesh, [lower, upper]: &[Hole; 2], edge: f64) {
    let border = lower.border();
    let steps = (PI * 0.5 * (REACH + 0.5 * (ROOTS[1] - ROOTS[0])) / edge).ceil().max(8.0) as usize;
    let (across, rows) = (lower.across as f64, lower.rows() as f64);
    let mut previous: Vec<u32> = border.iter().map(|(a, b)| lower.rings[*b] + *a as u32).collect();
    for step in 1..=steps {
        let next: Vec<u32> = if step == steps {
            // The inside of the bow is up at the lower root and down at the upper one.
            border.iter().map(|(a, b)| upper.rings[upper.rows() - *b] + *a as u32).collect()
        } else {
            let angle = PI * step as f64 / steps as f64 - FRAC_PI_2;
            let (centre, inward) = bow(angle);
            let roundness = roundness(angle);
            let start = mesh.vertices.len() as u32;
            mesh.vertices.extend(border.iter().map(|(a, b)| {
                let square = DVec2::new(2.0 * *a as f64 / across - 1.0, 2.0 * *b as f64 / rows - 1.0);
                let p = square.lerp(square.normalize(), roundness);
                centre - DVec3::Z * (p.x * HANDLE[0]) + inward * (p.y * HANDLE[1])
            }));
            (start..mesh.vertices.len() as u32).collect()
        };
        for k in 0..border.len() {
            let n = (k + 1) % border.len();
            let (a, b, c, d) = (previous[k], previous[n], next[n], next[k]);
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
        previous = next;
    }
}

/// A floor, 24 pieces of wall, 10 of the handle.
pub(super) fn mug_parts() -> Vec<ConvexPart> {
    const PIECES: usize = 10;
    let inside = RADIUS - WALL;
    let rim = [0.0, PI / 3.0, 2.0 * PI / 3.0]
        .map(|a| DVec2::new(RADIUS - 0.5 * WALL, HEIGHT - 0.5 * WALL) + DVec2::from_angle(a) * 0.5 * WALL);
    let mut far = rim.to_vec();
    far.push(DVec2::new(RADIUS, FLOOR));
    let near = [DVec2::new(inside, FLOOR), DVec2::new(inside, HEIGHT - 0.5 * WALL)];
    let mut parts = wedges(&far, &near, 24);
    parts.push(axisymmetric_hull(&[DVec2::new(RADIUS, 0.0), DVec2::new(RADIUS, FLOOR)]));
    let section = |step: usize| {
        let angle = PI * step as f64 / PIECES as f64 - FRAC_PI_2;
        let (mut centre, inward) = bow(angle);
        if step.is_multiple_of(PIECES) {
            // The root reaches into the wall, which is round.
            centre.x -= 0.5 * WALL;
        }
        (0..8).map(move |k| {
            // Corners and middles of the sides of the root's rectangle, or points of the ellipse.
            let round = DVec2::from_angle(TAU * f64::from(k) / 8.0);
            let square = round / round.abs().max_element();
            let p = square.lerp(round * balance(PI / 8.0), roundness(angle));
            centre - DVec3::Z * (p.x * HANDLE[0]) + inward * (p.y * HANDLE[1])
        })
    };
    parts.extend((0..PIECES).map(|k| ConvexPart::Hull(section(k).chain(section(k + 1)).collect())));
    parts
}
