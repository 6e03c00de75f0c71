//! The lowest frequency of a body, by elements or by polynomials alone, against the full spectrum of the same
//! mesh and of finer ones.

use clangor_bake::fem::{ElasticConstants, ElasticSystem};
use clangor_bake::mesh::tetrahedra::TetMesh;
use clangor_bake::mesh::tetrahedra::ball::ellipsoid;
use clangor_bake::mesh::tetrahedra::block::block;
use clangor_bake::modal_analysis::eigensolver::solve;
use clangor_bake::soundbank::modal::solid_polynomials::lowest_by_polynomials;
use clangor_bake::soundbank::modal::{first_frequency, first_frequency_of_surface};
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::material::presets::{GLASS, STEEL};
use glam::{DVec2, DVec3};

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
    // Of a free plate and a free bar, on fine meshes: tests/converge/modes.rs.
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
    let surface = clangor_core::shape::Shape::parse("box:0.25x0.01x0.25").expect("a box").mesh();
    let found = first_frequency_of_surface(&surface, &glass).expect("a frequency");
    println!("plate by its surface: {:.1e}", found / 516.129 - 1.0);
    assert!((found / 516.129 - 1.0).abs() < 0.03, "{found}");
}

/// Polynomials need no volume mesh: plate and bar as above, and splinters of a plate with six corners, one of
/// them notched.
#[test]
fn polynomials_are_as_good_as_elements() {
    let glass = ElasticConstants::of(&GLASS.material()).expect("an elastic material");
    let steel = ElasticConstants::of(&STEEL.material()).expect("an elastic material");
    let of = |text: &str, constants, degree| {
        let surface = clangor_core::shape::Shape::parse(text).expect("a box").mesh();
        lowest_by_polynomials(&surface, constants, degree).expect("a frequency")
    };
    // Residuals seen: 2.8 %, 0.8 % and 0.4 % for the plate.
    for (degree, most) in [(4, 0.03), (6, 0.01), (8, 0.005)] {
        let plate = of("box:0.25x0.01x0.25", &glass, degree) / 516.129 - 1.0;
        let bar = of("box:0.3x0.03x0.01", &steel, degree) / 574.401 - 1.0;
        println!("degree {degree}: plate {plate:.1e}, bar {bar:.1e}");
        assert!((-1e-3..most).contains(&plate) && (-1e-3..most).contains(&bar), "{plate} {bar}");
    }
    let corners = [[0.0, 0.0], [40.0, -6.0], [52.0, 20.0], [34.0, 45.0], [9.0, 38.0]].map(DVec2::from_array);
    for (name, dent) in [("convex", DVec2::new(-5.0, 20.0)), ("notched", DVec2::new(15.0, 20.0))] {
        let polygon: Vec<DVec2> = corners.into_iter().chain([dent]).map(|p| 1e-3 * p).collect();
        let surface = prism(&polygon, 0.005);
        let elements = first_frequency_of_surface(&surface, &glass).expect("a frequency");
        let ratios = [4, 6, 8]
            .map(|degree| lowest_by_polynomials(&surface, &glass, degree).expect("a frequency") / elements);
        println!("{name}: {elements:.0} Hz by elements, polynomials over it {ratios:.3?}");
        // Elements on a grid of a sixth of the length are no more accurate than this.
        assert!((0.985..1.015).contains(&ratios[2]) && ratios[0] < 1.07, "{ratios:?}");
        assert!(ratios[1] < ratios[0] && ratios[2] < ratios[1], "{ratios:?}");
    }
}

/// A prism whose base is star-shaped about its last corner.
fn prism(polygon: &[DVec2], thickness: f64) -> TriMesh {
    let count = polygon.len() as u32;
    let at = |z: f64| polygon.iter().map(move |p| DVec3::new(p.x, p.y, z));
    let (last, mut triangles) = (count - 1, Vec::new());
    for k in 0..count - 2 {
        triangles.push([last, k + 1, k]);
        triangles.push([count + last, count + k, count + k + 1]);
    }
    for k in 0..count {
        let next = (k + 1) % count;
        triangles.push([k, next, count + next]);
        triangles.push([k, count + next, count + k]);
    }
    TriMesh { vertices: at(0.0).chain(at(thickness)).collect(), triangles }
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
    // Two bodies have additional zero-energy motions: the result is not finite, or a frequency near 0.
    match first_frequency(&two, &constants) {
        Ok(found) => assert!(found < 100.0, "{found}"),
        Err(error) => println!("{error}"),
    }
}
