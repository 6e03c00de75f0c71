//! Reports of a bake about walls thinner than its triangles resolve, and bands that are too wide for a body.

use std::f64::consts::TAU;
use std::ops::ControlFlow;

use clangor_bake::acceleration::{BakeError, BakeOptions, Evidence, Method, bake, planned_cost};
use clangor_bake::cost::PER_SECOND;
use clangor_bake::geometry_class::bake_geometry::BakeGeometry;
use clangor_bake::modal::{ModalBakeError, ModalBakeOptions, find_modes};
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::material::presets;
use clangor_core::medium::Medium;
use clangor_core::shape::Shape;
use glam::DVec3;

fn wavenumber(frequency: f64) -> f64 {
    TAU * frequency / 343.0
}

fn evidence(
    geometry: &BakeGeometry,
    frequency: f64,
    accuracy: f64,
    method: Method,
) -> Result<Evidence, BakeError> {
    let options = BakeOptions { method, ..BakeOptions::new(wavenumber(frequency), accuracy) };
    bake(geometry, &options, &mut |_| ControlFlow::Continue(())).map(|(_, evidence)| evidence)
}

fn mesh(shape: &str) -> BakeGeometry {
    let mesh = Shape::parse(shape).unwrap().mesh();
    let centre = MassProperties::of(&mesh).unwrap().centre_of_mass;
    BakeGeometry::Mesh(mesh.relative_to(centre))
}

#[test]
fn thin_walls_are_warned_of_with_their_place() {
    let key = mesh("key");
    let coarse = evidence(&key, 3000.0, 0.02, Method::Bem).unwrap();
    let [warning] = &coarse.warnings[..] else { panic!("{:?}", coarse.warnings) };
    assert!(warning.starts_with("walls of 1.80e-3 m, thinnest at ("), "{warning}");
    assert!(warning.ends_with("ask for a finer accuracy"), "{warning}");
    let place = &warning[warning.find('(').unwrap() + 1..warning.find(')').unwrap()];
    let place: Vec<f64> = place.split(", ").map(|x| x.parse().unwrap()).collect();
    // On a face of the key, 0.9 mm from its middle plane, within the digits printed.
    assert!((place[1].abs() - 9e-4).abs() < 1e-4 && place[0].abs() < 0.035, "{place:?}");
    let fine = evidence(&key, 3000.0, 0.008, Method::Bem).unwrap();
    assert_eq!(fine.warnings, [""; 0]);
    // A wire has no walls.
    let wire = evidence(&mesh("torus:0.02x0.002"), 5000.0, 0.01, Method::Bem).unwrap();
    assert_eq!(wire.warnings, [""; 0]);
}

#[test]
fn a_body_too_large_for_the_band_has_a_narrower_one() {
    let door = BakeGeometry::RoundedBox { edges: DVec3::new(2.0, 0.8, 0.04), round: 0.0 };
    for (geometry, frequency) in [(mesh("mug"), 150e3), (door, 20e3)] {
        let options = BakeOptions::new(wavenumber(frequency), 0.02);
        let operations = planned_cost(&geometry, &options).unwrap().operations;
        println!("{operations:.1e}");
        assert!(operations > 0.0 && operations < 2e13, "{operations:e}");
    }
}

#[test]
fn a_bake_that_needs_more_than_its_patience_says_how_much() {
    // The wire needs shorter edges than were planned.
    let wire = mesh("torus:0.03x0.0015");
    let options = BakeOptions { method: Method::Bem, ..BakeOptions::new(wavenumber(20e3), 0.01) };
    let planned = planned_cost(&wire, &options).unwrap().operations / PER_SECOND;
    for patience in [0.5 * planned, 1.2 * planned] {
        let options = BakeOptions { patience, ..options };
        match bake(&wire, &options, &mut |_| ControlFlow::Continue(())) {
            Err(BakeError::TooLong { seconds, patience: allowed }) => {
                println!("{planned:.2} s planned, {seconds:.2} s");
                assert!(allowed == patience && seconds > patience, "{seconds} {patience}");
            }
            other => panic!("{:?}", other.map(|(_, evidence)| evidence)),
        }
    }
}

#[test]
fn modes_that_need_more_than_their_patience_end_before_it() {
    let glass = presets::GLASS.material();
    let key = mesh("key");
    let modes = |patience: f64| {
        let options = ModalBakeOptions { patience, ..ModalBakeOptions::new(Medium::AIR) };
        find_modes(&key, &glass, &options, &mut |_| ControlFlow::Continue(()))
    };
    let (all, _) = modes(f64::INFINITY).unwrap();
    // The first mesh takes some hundredths of a second, the last some tenths.
    for patience in [0.01, 0.2] {
        let Err(ModalBakeError::ModalAnalysis(error)) = modes(patience) else { panic!("{patience}") };
        let least = error.too_long().unwrap();
        println!("{least:.3} s at least, {patience} s allowed");
        assert!(least > patience, "{least}");
    }
    // What ends in time does not depend on the patience.
    assert_eq!(modes(100.0).unwrap().0, all);
}

#[test]
fn a_beam_whose_patches_take_minutes_has_triangles() {
    let beam = BakeGeometry::RoundedBox { edges: DVec3::new(0.3, 0.02, 0.01), round: 0.0 };
    let cost = |method, accuracy| {
        let options = BakeOptions { method, ..BakeOptions::new(wavenumber(20e3), accuracy) };
        planned_cost(&beam, &options).unwrap()
    };
    let [auto, patches] = [Method::Auto, Method::Bem].map(|method| cost(method, 0.01));
    println!("{auto:?} {patches:?}");
    // Where the method is named, patches come first whatever they cost.
    assert!(4.0 * auto.operations < patches.operations && patches.operations > 1e12);
    // So they do for an accuracy that triangles reach less well.
    assert_eq!(cost(Method::Auto, 0.005), cost(Method::Bem, 0.005));
}

#[test]
fn a_block_too_large_for_patches_has_triangles() {
    let block = BakeGeometry::RoundedBox { edges: DVec3::new(0.12, 0.3, 0.12), round: 0.0 };
    let operations = |method| {
        let options = BakeOptions { method, ..BakeOptions::new(wavenumber(20e3), 0.01) };
        planned_cost(&block, &options).unwrap().operations
    };
    // The named method takes the whole band whatever the work is; without a name, so does the same one.
    let [auto, elements] = [Method::Auto, Method::Bem].map(operations);
    println!("{auto:.2e} {elements:.2e}");
    assert_eq!(auto, elements);
}
