//! Every solver gives the same bits on any number of threads.

use std::ops::ControlFlow;

use clangor_bake::acceleration::{BakeOptions, Evidence, Method, bake};
use clangor_bake::geometry_class::bake_geometry::BakeGeometry;
use clangor_core::body::Surface;
use clangor_core::shape::Shape;
use clangor_core::sound_model::acceleration::model::AccelerationModel;
use glam::DVec3;

fn with_threads(threads: usize, geometry: &BakeGeometry, method: Method) -> (AccelerationModel, Evidence) {
    let options = BakeOptions { method, near_field: true, ..BakeOptions::new(150.0, 0.03) };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    pool.install(|| bake(geometry, &options, &mut |_| ControlFlow::Continue(())).expect("a field"))
}

#[test]
fn one_thread_and_three_give_the_same_bits() {
    let coin = Shape::parse("cylinder:0.01x0.004").unwrap().meridian().unwrap().about_centre_of_mass();
    let (rock, _) = Shape::parse("rock:3x0.008").unwrap().surface().unwrap();
    let Surface::Mesh(rock) = rock else { panic!("a mesh") };
    let rock = BakeGeometry::Mesh(rock.mesh);
    for (name, geometry, method) in [
        ("ellipsoid", BakeGeometry::Ellipsoid { semi_axes: DVec3::new(0.012, 0.009, 0.006) }, Method::Bem),
        ("box", BakeGeometry::RoundedBox { edges: DVec3::splat(0.012), round: 0.002 }, Method::Bem),
        ("revolution", BakeGeometry::axisymmetric(coin), Method::Bem),
        ("mesh", rock.clone(), Method::Bem),
        ("waves", rock, Method::Fdtd),
    ] {
        let one = with_threads(1, &geometry, method);
        assert!(one == with_threads(3, &geometry, method), "{name}: {}", one.1.method);
        assert!(!one.0.field.terms.is_empty(), "{name}");
    }
}
