//! The lowest frequency of a body, found alone, against all modes of the same mesh and of finer ones.

use clangor::material::presets::{GLASS, STEEL};
use clangor_bake::elasticity::{ElasticConstants, ElasticSystem};
use clangor_bake::modal_bank::{first_frequency, first_frequency_of_surface};
use clangor_bake::modes::solve;
use clangor_bake::tetrahedra::TetMesh;
use clangor_bake::tetrahedra::ball::ellipsoid;
use clangor_bake::tetrahedra::block::block;
use glam::DVec3;

#[test]
fn it_is_the_first_of_all() {
    let meshes: [(TetMesh, f64); 4] = [
        (block(DVec3::new(0.06, 0.05, 0.005), [6, 5, 1]).expect("a plate"), 9000.0),
        (block(DVec3::new(0.2, 0.01, 0.01), [12, 1, 1]).expect("a bar"), 3000.0),
        (block(DVec3::splat(0.05), [3, 3, 3]).expect("a cube"), 45_000.0),
        (ellipsoid(DVec3::new(0.01, 0.03, 0.04), 3).expect("an ellipsoid"), 40_000.0),
    ];
    let constants = ElasticConstants::of(&GLASS.material()).expect("an elastic material");
    for (mesh, limit) in &meshes {
        let found = first_frequency(mesh, &constants).expect("a frequency");
        let all = solve(&ElasticSystem::new(mesh, &constants), *limit).expect("modes").modes;
        let error = found / all[0].frequency - 1.0;
        println!("{found:.1} Hz, {:.1}: {error:.1e}", all[0].frequency);
        // From above; residual seen: 2e-4.
        assert!((-1e-9..2e-3).contains(&error), "{error:e}");
    }
}

#[test]
fn coarse_meshes_are_within_two_per_cent() {
    // Of a free plate and a free bar, on fine meshes: tests/converge_modes.rs.
    let glass = ElasticConstants::of(&GLASS.material()).expect("an elastic material");
    let plate = block(DVec3::new(0.25, 0.25, 0.01), [8, 8, 1]).expect("a plate");
    let found = first_frequency(&plate, &glass).expect("a frequency");
    println!("plate of {} nodes: {:.1e}", plate.nodes.len(), found / 516.129 - 1.0);
    assert!((found / 516.129 - 1.0).abs() < 0.02, "{found}");
    let steel = ElasticConstants::of(&STEEL.material()).expect("an elastic material");
    let bar = block(DVec3::new(0.3, 0.03, 0.01), [10, 1, 1]).expect("a bar");
    let found = first_frequency(&bar, &steel).expect("a frequency");
    println!("bar of {} nodes: {:.1e}", bar.nodes.len(), found / 574.401 - 1.0);
    assert!((found / 574.401 - 1.0).abs() < 0.02, "{found}");
    // The same plate by its surface alone.
    let surface = clangor::shape::Shape::parse("box:0.25x0.01x0.25").expect("a box").mesh();
    let found = first_frequency_of_surface(&surface, &glass).expect("a frequency");
    println!("plate by its surface: {:.1e}", found / 516.129 - 1.0);
    assert!((found / 516.129 - 1.0).abs() < 0.03, "{found}");
}

#[test]
fn what_has_no_lowest_mode_is_refused() {
    let one = block(DVec3::splat(0.01), [1, 1, 1]).expect("a cube");
    let mut nodes = one.nodes.clone();
    nodes.extend(one.nodes.iter().map(|x| *x + DVec3::splat(0.1)));
    let shift = one.nodes.len() as u32;
    let mut elements = one.elements.clone();
    elements.extend(one.elements.iter().map(|e| e.map(|n| n + shift)));
    let two = TetMesh { nodes, corners: 0, elements };
    let constants = ElasticConstants::of(&GLASS.material()).expect("an elastic material");
    // Two bodies have six motions without energy more than one: nothing finite comes out, or a frequency next to 0.
    match first_frequency(&two, &constants) {
        Ok(found) => assert!(found < 100.0, "{found}"),
        Err(error) => println!("{error}"),
    }
}
