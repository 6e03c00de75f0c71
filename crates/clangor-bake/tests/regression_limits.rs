//! Reports of a bake about walls thinner than its triangles resolve and bodies too large for the band.

use std::f64::consts::TAU;
use std::ops::ControlFlow;

use clangor_bake::acceleration::{BakeError, BakeOptions, Evidence, Method, bake};
use clangor_bake::fdtd::WaveError;
use clangor_bake::geometry_class::bake_geometry::BakeGeometry;
use clangor_bake::radiation::RadiationError;
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::geometry::meridian::Meridian;
use clangor_core::shape::Shape;

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
}

#[test]
fn a_body_too_large_for_the_band_is_refused_before_the_work() {
    let mug = mesh("mug");
    let refused = evidence(&mug, 150e3, 0.02, Method::Bem);
    let Err(BakeError::Radiation(RadiationError::TooLarge { unknowns, most, wavenumber: k })) = refused
    else {
        panic!("{refused:?}")
    };
    assert!(unknowns > 10 * most && k == wavenumber(150e3), "{unknowns} {most} {k}");
    let refused = evidence(&mug, 400e3, 0.02, Method::Auto);
    let Err(BakeError::Wave(WaveError::TooLarge { cells, most, .. })) = refused else {
        panic!("{refused:?}")
    };
    assert!(cells > most, "{cells} {most}");
    let ball = BakeGeometry::axisymmetric(Meridian::spheroid(10.0, 10.0).unwrap());
    let refused = evidence(&ball, 20e3, 0.01, Method::Auto);
    assert!(matches!(refused, Err(BakeError::Multipoles { order: 3667, most: 150, .. })), "{refused:?}");
}
