//! Patterns: their cost does not exceed the energy, seeds follow the energy density, regions are connected,
//! and the same seed gives the same pattern.

use clangor_bake::mesh::tetrahedra::block::block;
use clangor_core::glam::DVec3;
use clangor_sim::fracture::FractureError;
use clangor_sim::fracture::pattern::{PatternSettings, draw_pattern};
use clangor_sim::fracture::piece::Piece;
use clangor_sim::fracture::split::{Score, split_by_regions};
use clangor_sim::fracture::{shatter, shatter_along};

fn plate() -> (Piece, f64) {
    let plate = Piece::whole(&block(DVec3::new(0.2, 0.004, 0.2), [20, 1, 20]).unwrap()).unwrap();
    let volume = plate.mass_properties().unwrap().volume;
    (plate, volume)
}

/// Energy density that falls off around an impact at one corner, ten times the mean there.
fn impact(plate: &Piece) -> Vec<f64> {
    let near = |p: &DVec3| 1.0 / (0.05 + (p.distance(DVec3::new(-0.1, 0.0, -0.1)) / 0.1).powi(2));
    plate.mesh.nodes[..plate.mesh.corners].iter().map(near).collect()
}

#[test]
fn cracks_cost_at_most_their_share_of_the_energy() {
    let (plate, volume) = plate();
    let energy = impact(&plate);
    for seed in 0..10 {
        for strain_energy in [0.01, 0.05, 0.2] {
            let settings = PatternSettings::new(50.0, volume, seed);
            let Some(broken) = shatter(&plate, &energy, strain_energy, &settings).unwrap() else {
                // 0.8 × 0.01 J pay for 1.6 cm² of crack, a fifth of the plate's section.
                assert!(strain_energy < 0.02, "{strain_energy} J break nothing");
                continue;
            };
            assert!(broken.fracture_energy <= 0.8 * strain_energy);
            let area: f64 = broken.crack_faces.iter().map(|f| f.area_vector().length()).sum();
            assert!((broken.fracture_energy / (50.0 * area) - 1.0).abs() < 1e-12);
            assert!((broken.surplus() + broken.fracture_energy - strain_energy).abs() < 1e-15);
            let smallest = broken.pieces.iter().map(|p| p.mass_properties().unwrap().volume);
            // Smoothing the crack changes the volumes of the pattern slightly.
            assert!(smallest.fold(f64::INFINITY, f64::min) > 0.5 * settings.smallest_piece);
        }
    }
}

/// The cut gives the predicted volumes to rounding, before small elements are merged, and at least the
/// predicted area.
#[test]
fn area_and_volumes_are_those_of_the_pieces() {
    let (plate, volume) = plate();
    let settings = PatternSettings { most_pieces: 6, ..PatternSettings::new(1.0, volume, 3) };
    let pattern = draw_pattern(&plate.mesh, &impact(&plate), 1e3, &settings).unwrap().unwrap();
    assert_eq!(pattern.seeds.len(), 6);
    assert!((pattern.volumes.iter().sum::<f64>() / volume - 1.0).abs() < 1e-12);
    let split = split_by_regions(&plate, &pattern.region).unwrap().unwrap();
    assert_eq!(split.pieces.len(), 6);
    assert!(split.crack_area() <= pattern.area * (1.0 + 1e-12));
    assert!(split.crack_area() > 0.8 * pattern.area);
    // Pieces come in the order of their first element, regions in that of their seeds.
    let mut volumes: Vec<f64> = split.pieces.iter().map(|p| p.mass_properties().unwrap().volume).collect();
    let mut predicted = pattern.volumes;
    volumes.sort_by(f64::total_cmp);
    predicted.sort_by(f64::total_cmp);
    for (found, expected) in volumes.iter().zip(&predicted) {
        assert!((found - expected).abs() < 0.02 * volume);
    }
}

/// Of 400 first seeds, the share within 5 cm of the impact is that of the energy there.
#[test]
fn seeds_fall_where_the_energy_is() {
    let (plate, volume) = plate();
    let energy = impact(&plate);
    let close = |p: DVec3| p.distance(DVec3::new(-0.1, 0.0, -0.1)) < 0.05;
    let (mut near, mut all) = (0.0, 0.0);
    for element in &plate.mesh.elements {
        for node in &element[..4] {
            // All elements have the same volume.
            let here = energy[*node as usize];
            all += here;
            near += if close(plate.mesh.nodes[*node as usize]) { here } else { 0.0 };
        }
    }
    let share = near / all;
    let draws = 400;
    let mut hits = 0;
    for seed in 0..draws {
        let settings = PatternSettings {
            most_pieces: 2,
            smallest_piece: 0.0,
            ..PatternSettings::new(1.0, volume, seed)
        };
        let pattern = draw_pattern(&plate.mesh, &energy, 1e3, &settings).unwrap().unwrap();
        hits += usize::from(close(plate.mesh.nodes[pattern.seeds[0] as usize]));
    }
    let deviation = (share * (1.0 - share) / draws as f64).sqrt();
    let found = hits as f64 / draws as f64;
    assert!(share > 0.3 && (found - share).abs() < 3.0 * deviation, "{found} against {share} ± {deviation}");
}

#[test]
fn tougher_bodies_break_into_fewer_pieces() {
    let (plate, volume) = plate();
    let energy = impact(&plate);
    let median = |fracture_energy: f64| {
        let mut counts: Vec<usize> = (0..7)
            .map(|seed| {
                let settings = PatternSettings::new(fracture_energy, volume, seed);
                shatter(&plate, &energy, 0.3, &settings).unwrap().map_or(1, |b| b.pieces.len())
            })
            .collect();
        counts.sort_unstable();
        counts[3]
    };
    let counts = [20.0, 50.0, 120.0].map(median);
    assert!(counts[0] > counts[1] && counts[1] > counts[2], "{counts:?}");
}

#[test]
fn the_same_seed_gives_the_same_pieces() {
    let (plate, volume) = plate();
    let energy = impact(&plate);
    let with =
        |seed| shatter(&plate, &energy, 0.1, &PatternSettings::new(50.0, volume, seed)).unwrap().unwrap();
    assert_eq!(with(1), with(1));
    assert_ne!(with(1), with(2));
}

/// A tile scored along both middles breaks into four quarters, whose crack is flat.
#[test]
fn a_scored_tile_breaks_along_its_scores() {
    let (tile, volume) = plate();
    let settings = PatternSettings::new(50.0, volume, 0);
    let scores = [DVec3::X, DVec3::Z].map(|normal| Score {
        point: DVec3::new(0.0003, 0.0, 0.0003),
        normal,
        depth: 0.0,
    });
    let broken = shatter_along(&tile, &scores, 0.2, &settings).unwrap().unwrap();
    assert_eq!(broken.pieces.len(), 4);
    for face in &broken.crack_faces {
        for corner in face.corners {
            let off = scores.map(|s| (corner - s.point).dot(s.normal).abs());
            // Seen: 1e-18 m.
            assert!(off[0].min(off[1]) < 1e-12, "{off:?}");
        }
    }
    // Two sections of 0.2 m × 4 mm.
    assert!((broken.fracture_energy / (50.0 * 2.0 * 0.2 * 0.004) - 1.0).abs() < 1e-9);
    assert_eq!(shatter_along(&tile, &scores, 0.05, &settings).unwrap(), None);
    let beside = Score { point: DVec3::new(1.0, 0.0, 0.0), normal: DVec3::X, depth: 0.0 };
    assert_eq!(shatter_along(&tile, &[beside], 1.0, &settings).unwrap(), None);
}

#[test]
fn wrong_numbers_are_refused() {
    let (plate, volume) = plate();
    let energy = impact(&plate);
    let good = PatternSettings::new(50.0, volume, 0);
    let refused = |settings: PatternSettings, energy: &[f64], strain: f64| {
        shatter(&plate, energy, strain, &settings).unwrap_err()
    };
    for fracture_energy in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = refused(PatternSettings { fracture_energy, ..good }, &energy, 1.0);
        assert!(matches!(error, FractureError::Setting { setting: "fracture_energy", .. }));
    }
    assert!(matches!(refused(good, &energy[1..], 1.0), FractureError::Counts { .. }));
    assert!(matches!(refused(good, &energy, f64::NAN), FractureError::Setting { .. }));
    let flat = Score { point: DVec3::ZERO, normal: DVec3::ZERO, depth: 0.0 };
    assert!(matches!(shatter_along(&plate, &[flat], 1.0, &good), Err(FractureError::Setting { .. })));
    let still = vec![0.0; energy.len()];
    assert_eq!(shatter(&plate, &still, 1.0, &good).unwrap(), None);
}
