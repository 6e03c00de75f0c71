//! A box cut into the Voronoi cells of random seeds, for the tests of births and deaths.

use clangor_core::body::Body;
use clangor_core::geometry::hull::convex_hull;
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::glam::DVec3;
use clangor_core::timeline::PoseRow;

use crate::scenes::{Random, solid};

/// The cells of `count` seeds in a box, in its frame.
pub(crate) fn cells(half: DVec3, count: usize, seed: u64) -> Vec<Vec<DVec3>> {
    let mut random = Random(seed);
    let seeds: Vec<DVec3> =
        (0..count).map(|_| DVec3::new(random.signed(), random.signed(), random.signed()) * half).collect();
    seeds.iter().map(|s| cell(half, *s, &seeds)).collect()
}

/// The part of a box that is nearer to `seed` than to the other seeds.
fn cell(half: DVec3, seed: DVec3, seeds: &[DVec3]) -> Vec<DVec3> {
    let mut planes: Vec<(DVec3, f64)> =
        DVec3::AXES.iter().flat_map(|n| [(*n, half.dot(*n)), (-*n, half.dot(*n))]).collect();
    for other in seeds.iter().filter(|other| **other != seed) {
        let normal = (*other - seed).normalize();
        planes.push((normal, normal.dot((*other + seed) * 0.5)));
    }
    let mut points: Vec<DVec3> = Vec::new();
    for i in 0..planes.len() {
        for j in i + 1..planes.len() {
            for k in j + 1..planes.len() {
                let normals = clangor_core::glam::DMat3::from_cols(planes[i].0, planes[j].0, planes[k].0);
                if normals.determinant().abs() < 1e-6 {
                    continue;
                }
                let p = normals.transpose().inverse() * DVec3::new(planes[i].1, planes[j].1, planes[k].1);
                let inside = planes.iter().all(|(n, d)| n.dot(p) < d + 1e-12);
                if inside && points.iter().all(|q| (*q - p).length() > 1e-9) {
                    points.push(p);
                }
            }
        }
    }
    points
}

/// Pieces of a box in the state `now` that breaks into these cells; they move as the box did.
pub(crate) fn pieces(parent: &Body, now: &PoseRow, cells: &[Vec<DVec3>]) -> Vec<Body> {
    let piece = |(k, points): (usize, &Vec<DVec3>)| {
        let hull = convex_hull(points).expect("a cell has volume");
        let centre = MassProperties::of(&hull).expect("a cell has volume").centre_of_mass;
        let arm = now.orientation * centre;
        let name = format!("{} {k}", parent.name);
        let mut piece = solid(&name, &parent.material, std::slice::from_ref(points));
        piece.pose.position = now.position + arm;
        piece.pose.orientation = now.orientation;
        piece.velocity = now.velocity + now.angular_velocity.cross(arm);
        piece.angular_velocity = now.angular_velocity;
        piece
    };
    cells.iter().enumerate().map(piece).collect()
}
