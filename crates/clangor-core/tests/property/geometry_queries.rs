//! Nearest points, inside and outside, hulls and refinement: against brute force and against exact shapes.

use clangor_core::body::{MeshSurface, Surface};
use clangor_core::geometry::hull::{concavity, convex_hull};
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::geometry::refine::refine_to_edge;
use clangor_core::geometry::solid::{MeshError, check_solid};
use clangor_core::geometry::surface_tree::SurfaceTree;
use clangor_core::glam::DVec3;
use clangor_core::shape::Shape;
use proptest::prelude::*;

fn surface(text: &str) -> MeshSurface {
    match Shape::parse(text).unwrap().surface().unwrap().0 {
        Surface::Mesh(surface) => surface,
        other => panic!("{other:?}"),
    }
}

/// Points spread evenly over the unit cube around the origin.
fn scatter(count: usize) -> impl Iterator<Item = DVec3> {
    let step = DVec3::new(0.8191725134, 0.6710436067, 0.5497004779);
    (1..=count).map(move |k| (step * k as f64).fract() - 0.5)
}

#[test]
fn the_tree_finds_what_brute_force_finds() {
    let mesh = Shape::parse("mug@0.008").unwrap().mesh();
    let tree = SurfaceTree::new(&mesh);
    for point in scatter(300).map(|p| p * 0.3) {
        let found = tree.nearest(&mesh, point).unwrap();
        let rebuilt = (0..3).map(|k| mesh.corners(found.triangle)[k] * found.weights[k]).sum::<DVec3>();
        assert!(rebuilt.distance(found.position) < 1e-15);
        // A tree of one triangle is brute force.
        let least = (0..mesh.triangles.len())
            .map(|t| {
                let one = clangor_core::geometry::tri_mesh::TriMesh {
                    vertices: mesh.corners(t).to_vec(),
                    triangles: vec![[0, 1, 2]],
                };
                SurfaceTree::new(&one).nearest(&one, point).unwrap().distance
            })
            .fold(f64::INFINITY, f64::min);
        assert_eq!(found.distance, least);
    }
}

#[test]
fn signed_distance_of_a_box_is_exact() {
    let surface = surface("box:0.1x0.05x0.2");
    let half = DVec3::new(0.05, 0.025, 0.1);
    for point in scatter(3000).map(|p| p * 0.3) {
        let beyond = point.abs() - half;
        let exact = beyond.max(DVec3::ZERO).length() + beyond.max_element().min(0.0);
        // Residual seen: 3e-17.
        assert!((surface.signed_distance(point) - exact).abs() < 1e-15, "{point}");
        assert_eq!(surface.contains(point), exact < 0.0);
    }
}

#[test]
fn the_sign_is_right_beyond_sharp_edges() {
    // Beyond an edge of 60° the normal of one face alone points away from half of the points outside.
    for text in ["prism:3x0.01x0.03", "prism:3x0.01x0.001", "shard:2x0.04"] {
        let surface = surface(text);
        let mesh = &surface.mesh;
        for point in scatter(2000).map(|p| p * 0.06) {
            let height = (0..mesh.triangles.len())
                .map(|t| mesh.area_vector(t).normalize().dot(point - mesh.corners(t)[0]))
                .fold(f64::NEG_INFINITY, f64::max);
            assert_eq!(surface.contains(point), height < 0.0, "{text}: {point}");
        }
    }
}

#[test]
fn inside_a_bowl_is_outside_its_wall() {
    let surface = surface("bowl");
    let (_, mass) = Shape::parse("bowl").unwrap().surface().unwrap();
    let at = |x: f64, y: f64| DVec3::new(x, y, 0.0) - mass.centre_of_mass;
    assert!(!surface.contains(at(0.0, 0.04)));
    assert!(!surface.contains(at(0.03, 0.055)));
    assert!(surface.contains(at(0.0, 0.005)));
    // The middle of the wall, halfway up: 2.75 mm deep.
    let (sin, cos) = 0.9_f64.sin_cos();
    let depth = surface.signed_distance(at(0.07075 * sin, 0.0735 - 0.07075 * cos));
    assert!((depth + 0.00275).abs() < 5e-5, "{depth}");
}

#[test]
fn curvature_at_a_point_is_that_of_the_nearest_surface() {
    let ellipsoid = surface("ellipsoid:0.02x0.01x0.01@0.0005");
    // At the tip of a prolate spheroid both curvatures are a/b², at the waist 1/b and b/a².
    let (a, b): (f64, f64) = (0.02, 0.01);
    let tip = ellipsoid.mean_curvature_at(DVec3::X * 0.0202);
    let waist = ellipsoid.mean_curvature_at(DVec3::new(0.0, 0.008, 0.007));
    println!(
        "tip {:.2e}, waist {:.2e}",
        tip * b * b / a - 1.0,
        waist / (0.5 * (1.0 / b + b / (a * a))) - 1.0
    );
    // Residuals seen: 1.0e-3 and 8e-6.
    assert!((tip * b * b / a - 1.0).abs() < 3e-3);
    assert!((waist / (0.5 * (1.0 / b + b / (a * a))) - 1.0).abs() < 1e-4);
}

#[test]
fn refinement_keeps_the_solid_and_shortens_its_edges() {
    let rock = Shape::parse("rock:5x0.02@0.03").unwrap().mesh();
    let fine = refine_to_edge(&rock, 0.002);
    let (a, b) = (check_solid(&rock).unwrap().mass, check_solid(&fine).unwrap().mass);
    // Residual seen: 1e-15.
    assert!((a.volume / b.volume - 1.0).abs() < 1e-13);
    for t in 0..fine.triangles.len() {
        let [a, b, c] = fine.corners(t);
        assert!(a.distance(b).max(b.distance(c)).max(c.distance(a)) <= 0.002);
    }
}

#[test]
fn convex_and_concave_are_distinguished() {
    for text in ["box:0.1x0.05x0.2", "rock:9x0.03", "prism:5x0.02x0.01", "sphere:0.01"] {
        let mesh = Shape::parse(text).unwrap().mesh();
        assert!(concavity(&mesh).unwrap() < 1e-12, "{text}");
    }
    for text in ["mug", "torus:0.03x0.01", "key"] {
        assert!(concavity(&Shape::parse(text).unwrap().mesh()).unwrap() > 1e-5, "{text}");
    }
}

#[test]
fn flat_points_have_no_hull() {
    let flat: Vec<DVec3> = scatter(20).map(|p| DVec3::new(p.x, p.y, 1.0)).collect();
    assert!(matches!(convex_hull(&flat), Err(MeshError::NoVolume { .. })));
    assert!(matches!(convex_hull(&[]), Err(MeshError::NoVolume { .. })));
    assert!(matches!(convex_hull(&[DVec3::NAN; 5]), Err(MeshError::NotFinite { vertex: 0 })));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 100, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_hull_holds_its_points_and_is_convex(
        points in prop::collection::vec(prop::array::uniform3(-1.0_f64..1.0), 4..60),
        lattice in any::<bool>(),
    ) {
        // Points of a coarse lattice lie in common planes, which is the hard case.
        let snap = |x: f64| if lattice { (2.0 * x).round() / 2.0 } else { x };
        let points: Vec<DVec3> = points.into_iter().map(|p| DVec3::from_array(p.map(snap))).collect();
        let Ok(hull) = convex_hull(&points) else { return Ok(()) };
        let mass = MassProperties::of(&hull);
        prop_assert!(mass.is_ok());
        prop_assert!(concavity(&hull).unwrap() < 1e-12);
        for t in 0..hull.triangles.len() {
            let normal = hull.area_vector(t).normalize();
            let base = hull.corners(t)[0];
            for p in &points {
                prop_assert!((*p - base).dot(normal) < 1e-11);
            }
        }
    }
}
