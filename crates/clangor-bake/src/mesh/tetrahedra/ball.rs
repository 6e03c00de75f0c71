//! Balls and ellipsoids: the twenty tetrahedra between the faces of an icosahedron and its centre, divided
//! evenly and mapped radially to the sphere.

use clangor_core::geometry::icosahedron::icosahedron;
use glam::DVec3;

use super::block::divide_tetrahedron;
use super::{TetMesh, TetMeshError};

/// A ball scaled to the given semi-axes \[m\], with `divisions` elements from the centre to the surface.
///
/// # Errors
/// [`TetMeshError`] for semi-axes that are not positive and finite, or no divisions.
pub fn ellipsoid(semi_axes: DVec3, divisions: usize) -> Result<TetMesh, TetMeshError> {
    if divisions == 0 || !semi_axes.is_finite() || semi_axes.min_element() <= 0.0 {
        return Err(TetMeshError::Empty);
    }
    let (points, tetrahedra) = unit_ball(divisions);
    let stretched: Vec<DVec3> = points.iter().map(|p| *p * semi_axes).collect();
    TetMesh::curved(stretched, &tetrahedra, |middle, _, _| (middle / semi_axes).normalize() * semi_axes)
}

fn unit_ball(divisions: usize) -> (Vec<DVec3>, Vec<[u32; 4]>) {
    let mut soup = Soup::default();
    for face in icosahedron() {
        divide_tetrahedron(divisions, |weights| {
            // The weights of the face alone set the direction, their sum the radius.
            let flat = face[0] * weights[1] + face[1] * weights[2] + face[2] * weights[3];
            flat.normalize_or_zero() * (weights[1] + weights[2] + weights[3])
        })
        .for_each(|t| soup.push(t));
    }
    soup.welded(0.1 / divisions as f64)
}

/// Tetrahedra without connectivity.
#[derive(Default)]
pub(super) struct Soup {
    points: Vec<DVec3>,
}

impl Soup {
    pub(super) fn push(&mut self, corners: [DVec3; 4]) {
        self.points.extend(corners);
    }

    /// Merges points closer than `tolerance`; the first of them remains.
    pub(super) fn welded(self, tolerance: f64) -> (Vec<DVec3>, Vec<[u32; 4]>) {
        let cell = |p: &DVec3| (*p / (2.0 * tolerance)).floor().as_i64vec3().to_array();
        let mut keys: Vec<([i64; 3], u32)> =
            self.points.iter().enumerate().map(|(n, p)| (cell(p), n as u32)).collect();
        keys.sort_unstable();
        let mut merged = vec![u32::MAX; self.points.len()];
        let mut points: Vec<DVec3> = Vec::new();
        for n in 0..self.points.len() {
            let p = self.points[n];
            let [x, y, z] = cell(&p);
            let mut twin = None;
            for (dx, dy) in (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| (dx, dy))) {
                let low = [x + dx, y + dy, z - 1];
                let start = keys.partition_point(|(key, _)| *key < low);
                let column = keys[start..].iter().take_while(|(key, _)| *key <= [x + dx, y + dy, z + 1]);
                for (_, other) in column {
                    let other = *other as usize;
                    if other < n && merged[other] != u32::MAX && self.points[other].distance(p) <= tolerance {
                        twin = Some(twin.map_or(merged[other], |t: u32| t.min(merged[other])));
                    }
                }
            }
            merged[n] = twin.unwrap_or_else(|| {
                points.push(p);
                points.len() as u32 - 1
            });
        }
        let tetrahedra = merged.chunks_exact(4).map(|t| [t[0], t[1], t[2], t[3]]).collect();
        (points, tetrahedra)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn balls_have_their_volume() {
        for divisions in [1, 2, 4] {
            let ball = ellipsoid(DVec3::new(1.0, 2.0, 0.5), divisions).expect("a ball");
            let quality = ball.quality();
            let error = quality.volume / (4.0 / 3.0 * PI) - 1.0;
            // Seen: −3.0e-2, −2.2e-3, −1.4e-4.
            assert!(error.abs() < 0.05 * (divisions as f64).powi(-4), "{divisions}: {error:.2e}");
            assert!(quality.least_jacobian > 0.3, "{quality:?}");
            assert_eq!(ball.elements.len(), 20 * divisions.pow(3));
            assert_eq!(ball.surface().len(), 20 * divisions.pow(2));
        }
    }
}
