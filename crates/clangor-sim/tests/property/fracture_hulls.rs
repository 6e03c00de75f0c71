//! Hulls of pieces: added and missing volume, distance from the surface, and overlap of siblings.

use clangor_bake::mesh::tetrahedra::TetMesh;
use clangor_bake::mesh::tetrahedra::ball::ellipsoid;
use clangor_bake::mesh::tetrahedra::block::block;
use clangor_bake::mesh::tetrahedra::cylinder::torus;
use clangor_core::geometry::convex::ConvexPart;
use clangor_core::geometry::hull::convex_hull;
use clangor_core::geometry::parts_fit::measure_parts;
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::glam::DVec3;
use clangor_core::math::random::SplitMix;
use clangor_sim::fracture::hulls::{HullSettings, PieceHulls, piece_hulls};
use clangor_sim::fracture::pattern::PatternSettings;
use clangor_sim::fracture::piece::Piece;
use clangor_sim::fracture::{FractureError, Shatter, shatter};

fn broken(mesh: &TetMesh, pieces: usize) -> (Shatter, Vec<PieceHulls>) {
    let body = Piece::whole(mesh).unwrap();
    let volume = body.mass_properties().unwrap().volume;
    let nodes = &body.mesh.nodes[..body.mesh.corners];
    let size = body.surface().diagonal();
    let impact = nodes[nodes.len() / 3];
    let energy: Vec<f64> = nodes.iter().map(|p| 1.0 / (0.05 + (p.distance(impact) / size).powi(2))).collect();
    let settings = PatternSettings {
        most_pieces: pieces,
        smallest_piece: 1e-3 * volume,
        ..PatternSettings::new(1.0, volume, 3)
    };
    let broken = shatter(&body, &energy, 1e9, &settings).unwrap().unwrap();
    let hulls = piece_hulls(&broken.pieces, &broken.crack_faces, HullSettings::default()).unwrap();
    assert_eq!(hulls.len(), broken.pieces.len());
    (broken, hulls)
}

/// Normals and offsets of the faces of each part.
fn solids(hulls: &PieceHulls) -> Vec<Vec<(DVec3, f64)>> {
    let planes = |part: &ConvexPart| {
        let ConvexPart::Hull(points) = part else { panic!("not a hull") };
        let hull: TriMesh = convex_hull(points).unwrap();
        let plane = |t: usize| {
            let normal = hull.area_vector(t).normalize();
            (normal, normal.dot(hull.corners(t)[0]))
        };
        (0..hull.triangles.len()).map(plane).collect()
    };
    hulls.parts.iter().map(planes).collect()
}

/// The share of the union of all hulls that is covered by more than one piece, from random points.
fn overlap(broken: &Shatter, hulls: &[PieceHulls]) -> f64 {
    let solids: Vec<_> = hulls.iter().map(solids).collect();
    let bounds = broken.pieces.iter().map(|p| p.surface().bounds());
    let (low, high) = bounds.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))).unwrap();
    let mut random = SplitMix::new(1);
    let (mut claimed, mut contested) = (0.0, 0.0);
    for _ in 0..20_000 {
        let unit = DVec3::from_array([0; 3].map(|_| random.uniform(0.0, 1.0)));
        let point = low + unit * (high - low);
        let holds = |parts: &&Vec<Vec<(DVec3, f64)>>| {
            parts.iter().any(|planes| planes.iter().all(|(normal, offset)| normal.dot(point) <= *offset))
        };
        let owners = solids.iter().filter(holds).count();
        claimed += f64::from(owners > 0);
        contested += f64::from(owners > 1);
    }
    contested / claimed
}

#[test]
fn hulls_stand_for_their_pieces() {
    let bodies: [(&str, TetMesh, usize); 5] = [
        ("block", block(DVec3::new(0.1, 0.08, 0.06), [10, 8, 6]).unwrap(), 10),
        ("plate", block(DVec3::new(0.2, 0.2, 0.004), [30, 30, 1]).unwrap(), 16),
        ("ball", ellipsoid(DVec3::splat(0.05), 5).unwrap(), 6),
        ("ring in four", torus(0.05, 0.012, 2, 36).unwrap(), 4),
        ("ring in two", torus(0.05, 0.012, 2, 36).unwrap(), 2),
    ];
    for (name, mesh, count) in bodies {
        let (broken, hulls) = broken(&mesh, count);
        let mut volumes: Vec<f64> = hulls.iter().map(|h| h.volume_error).collect();
        volumes.sort_by(f64::total_cmp);
        let contested = overlap(&broken, &hulls);
        let mut distances = Vec::new();
        for (piece, hulls) in broken.pieces.iter().zip(&hulls) {
            assert!(!hulls.parts.is_empty() && hulls.parts.len() <= 8);
            let surface = piece.surface();
            let fit = measure_parts(&surface, &hulls.parts, surface.diagonal() / 25.0).unwrap();
            let element = piece.element_size.iter().sum::<f64>() / piece.element_size.len() as f64;
            distances.push(fit.worst() / element);
        }
        let middle = hulls.len() / 2;
        // Seen: 0.033 at most; medians within 0.02, rings 0.1; all within −0.12 and +0.16; 1.4 elements at
        // most, which is a fifth of the smallest piece.
        assert!(contested < 0.05, "{name}: {contested}");
        assert!(volumes[middle].abs() < 0.12, "{name}: {volumes:?}");
        assert!(volumes[0] > -0.15 && volumes[hulls.len() - 1] < 0.2, "{name}: {volumes:?}");
        assert!(distances.iter().all(|d| *d < 1.6), "{name}: {distances:?}");
    }
}

/// An unbroken convex body is its own hull.
#[test]
fn a_whole_box_is_one_exact_part() {
    let body = Piece::whole(&block(DVec3::new(0.1, 0.08, 0.06), [3, 3, 3]).unwrap()).unwrap();
    let hulls = piece_hulls(&[body], &[], HullSettings::default()).unwrap();
    let [PieceHulls { parts, volume_error, filled, missing }] = &hulls[..] else { panic!("one piece") };
    assert!(matches!(&parts[..], [ConvexPart::Hull(points)] if points.len() == 8));
    // Seen: 2e-16.
    assert!(volume_error.abs() < 1e-12 && *filled < 1e-15 && *missing < 1e-15);
}

#[test]
fn wrong_settings_are_refused() {
    let wrong = [
        HullSettings { tolerance: f64::NAN, ..HullSettings::default() },
        HullSettings { roughness: -1.0, ..HullSettings::default() },
        HullSettings { most_parts: 0, ..HullSettings::default() },
        HullSettings { most_points: 3, ..HullSettings::default() },
    ];
    for settings in wrong {
        assert!(matches!(piece_hulls(&[], &[], settings), Err(FractureError::Setting { .. })));
    }
}
