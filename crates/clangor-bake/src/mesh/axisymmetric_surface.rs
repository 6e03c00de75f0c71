//! The surface of a body of revolution as triangles, for what breaks its symmetry.
//!
//! Rings of vertices about y, as far apart as they are apart along a ring of the largest radius. Radii are
//! those of the polygon with the area of the circle, so that the volume is that of the body.

use std::f64::consts::TAU;

use clangor_core::geometry::meridian::{Meridian, Piece};
use clangor_core::geometry::tri_mesh::TriMesh;
use glam::{DQuat, DVec2, DVec3};

/// Vertices of a ring.
const SECTORS: usize = 96;
/// Least number of chords of a half-circle.
const CHORDS: f64 = 24.0;
/// Radius over the largest that counts as the axis.
const ON_AXIS: f64 = 1e-9;

/// The surface of a meridian about y, rotated.
pub(crate) fn axisymmetric_surface(meridian: &Meridian, rotation: DQuat) -> TriMesh {
    let widest = meridian.pieces().iter().flat_map(|p| [p.point(0.0).x, p.point(0.5).x, p.point(1.0).x]);
    let widest = widest.fold(0.0, f64::max);
    let step = widest * TAU / SECTORS as f64;
    // Points of the meridian, each once.
    let mut points: Vec<DVec2> = Vec::new();
    for piece in meridian.pieces() {
        let along = piece.length(0.0, 1.0) / step;
        let turn = match piece {
            Piece::Line { .. } => 1.0,
            Piece::Arc { from, to, .. } => CHORDS * (to - from).abs() / (0.5 * TAU),
        };
        let chords = along.max(turn).ceil().max(1.0) as usize;
        points.extend((0..chords).map(|k| piece.point(k as f64 / chords as f64)));
    }
    if let (false, Some(last)) = (meridian.is_loop(), meridian.pieces().last()) {
        points.push(last.point(1.0));
    }
    let sector = TAU / SECTORS as f64;
    let swell = (sector / sector.sin()).sqrt();
    let mut vertices = Vec::new();
    let rings: Vec<Vec<u32>> = points
        .iter()
        .map(|point| {
            let first = vertices.len() as u32;
            if point.x <= ON_AXIS * widest {
                vertices.push(rotation * DVec3::new(0.0, point.y, 0.0));
                return vec![first; SECTORS];
            }
            vertices.extend((0..SECTORS).map(|k| {
                let (sin, cos) = (sector * k as f64).sin_cos();
                rotation * DVec3::new(swell * point.x * cos, point.y, -swell * point.x * sin)
            }));
            (first..first + SECTORS as u32).collect()
        })
        .collect();
    let count = rings.len();
    let bands = if meridian.is_loop() { count } else { count - 1 };
    let mut triangles = Vec::new();
    for band in 0..bands {
        let (low, high) = (&rings[band], &rings[(band + 1) % count]);
        for k in 0..SECTORS {
            let next = (k + 1) % SECTORS;
            let [a, b, c, d] = [low[k], low[next], high[next], high[k]];
            triangles
                .extend([[a, b, c], [a, c, d]].into_iter().filter(|[a, b, c]| a != b && b != c && c != a));
        }
    }
    TriMesh { vertices, triangles }
}

#[cfg(test)]
mod tests {
    use clangor_core::geometry::mass_properties::MassProperties;

    use super::*;

    #[test]
    fn it_has_the_volume_and_the_moments_of_the_body() {
        let line = |a: [f64; 2], b: [f64; 2]| Piece::Line { from: a.into(), to: b.into() };
        let disc = vec![
            line([0.0, -0.01], [0.3, -0.01]),
            line([0.3, -0.01], [0.3, 0.01]),
            line([0.3, 0.01], [0.0, 0.01]),
        ];
        let torus = vec![Piece::Arc { centre: DVec2::X, semi_axes: DVec2::splat(0.2), from: 0.0, to: TAU }];
        let ball = Meridian::spheroid(1.0, 0.5).expect("a spheroid");
        let solids =
            [Meridian::try_new(disc).expect("a disc"), Meridian::try_new(torus).expect("a torus"), ball];
        for meridian in solids {
            let exact = meridian.mass_properties();
            let found = MassProperties::of(&axisymmetric_surface(&meridian, DQuat::IDENTITY)).expect("solid");
            // Residuals seen: 1e-15 of the disc, 5e-3 of the others, by the chords of their meridians.
            assert!((found.volume / exact.volume - 1.0).abs() < 8e-3, "{} {}", found.volume, exact.volume);
            assert!((found.inertia.y_axis.y / exact.inertia.y_axis.y - 1.0).abs() < 2e-2);
        }
    }
}
