//! Meshes that bound no solid are rejected, each for its own reason and at its place.

use clangor_core::geometry::solid::{MeshError, check_solid};
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::glam::DVec3;
use clangor_core::shape::Shape;

fn cube() -> TriMesh {
    Shape::parse("box:0.1x0.1x0.1@0.05").unwrap().mesh()
}

/// Both meshes side by side in one.
fn joined(a: &TriMesh, b: &TriMesh) -> TriMesh {
    let start = a.vertices.len() as u32;
    let mut both = a.clone();
    both.vertices.extend(&b.vertices);
    both.triangles.extend(b.triangles.iter().map(|t| t.map(|i| i + start)));
    both
}

fn shifted(mesh: &TriMesh, by: DVec3) -> TriMesh {
    mesh.relative_to(-by)
}

fn scaled(mesh: &TriMesh, factor: f64) -> TriMesh {
    TriMesh {
        vertices: mesh.vertices.iter().map(|v| *v * factor).collect(),
        triangles: mesh.triangles.clone(),
    }
}

fn inverted(mesh: &TriMesh) -> TriMesh {
    let triangles = mesh.triangles.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
    TriMesh { vertices: mesh.vertices.clone(), triangles }
}

fn refused(mesh: &TriMesh) -> MeshError {
    check_solid(mesh).unwrap_err()
}

#[test]
fn numbers_that_make_no_mesh() {
    assert_eq!(refused(&TriMesh::default()), MeshError::Empty);
    let mut mesh = cube();
    let vertices = mesh.vertices.len();
    mesh.triangles[7][1] = 999;
    assert_eq!(refused(&mesh), MeshError::IndexOutOfRange { triangle: 7, index: 999, vertices });
    for bad in [f64::NAN, f64::INFINITY] {
        let mut mesh = cube();
        mesh.vertices[3].y = bad;
        assert_eq!(refused(&mesh), MeshError::NotFinite { vertex: 3 });
    }
}

#[test]
fn triangles_without_area() {
    let mut mesh = cube();
    let [a, b, _] = mesh.triangles[5];
    mesh.triangles[5] = [a, b, b];
    assert!(matches!(refused(&mesh), MeshError::Degenerate { count: 1, triangle: 5, .. }));
}

#[test]
fn vertices_that_coincide() {
    let mesh = cube();
    let mut soup = TriMesh::default();
    for t in 0..mesh.triangles.len() {
        let start = soup.vertices.len() as u32;
        soup.vertices.extend(mesh.corners(t));
        soup.triangles.push([start, start + 1, start + 2]);
    }
    let count = 3 * mesh.triangles.len() - mesh.vertices.len();
    assert!(matches!(refused(&soup), MeshError::Duplicate { count: c, .. } if c == count));
    let welded = soup.weld(1e-9);
    assert_eq!(welded.vertices.len(), mesh.vertices.len());
    assert_eq!(check_solid(&welded).unwrap().mass.volume, check_solid(&mesh).unwrap().mass.volume);
}

#[test]
fn edges_without_two_sides() {
    let mut open = cube();
    let gone = open.triangles.pop().unwrap();
    let corners = gone.map(|i| open.vertices[i as usize]);
    match refused(&open) {
        MeshError::Open { edges: 3, position } => {
            assert!(corners.iter().any(|c| c.distance(position) < 0.05), "{position}");
        }
        other => panic!("{other}"),
    }
    // Two tetrahedra that share an edge: four triangles meet there.
    let vertices = [[0., 0., 0.], [0., 0., 1.], [1., 0., 0.], [0., 1., 0.], [-1., 0., 0.], [0., -1., 0.]];
    let tetrahedron = |c: u32, d: u32| [[0, 1, d], [0, c, 1], [1, c, d], [0, d, c]];
    let triangles = tetrahedron(2, 3).into_iter().chain(tetrahedron(4, 5)).collect();
    let shared = TriMesh { vertices: vertices.map(DVec3::from_array).to_vec(), triangles };
    assert_eq!(refused(&shared), MeshError::NonManifold { edges: 1, position: DVec3::Z * 0.5 });
}

#[test]
fn winding_and_orientation() {
    let mut twisted = cube();
    twisted.triangles[0].swap(0, 1);
    assert!(matches!(refused(&twisted), MeshError::Winding { edges: 3, .. }));
    match refused(&inverted(&cube())) {
        MeshError::Inverted { volume, .. } => assert!((volume + 1e-3).abs() < 1e-15),
        other => panic!("{other}"),
    }
    // A square folded onto itself.
    let vertices = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]].map(DVec3::from_array).to_vec();
    let flat = TriMesh { vertices, triangles: vec![[0, 1, 2], [0, 2, 3], [0, 2, 1], [0, 3, 2]] };
    assert!(check_solid(&flat).is_err());
    // The same with corners of its own on the back, so that every edge is good.
    let vertices =
        [[0., 0., 0.], [1., 0., 0.], [0.5, 1., 0.], [0.5, 0.3, 0.]].map(DVec3::from_array).to_vec();
    let pillow = TriMesh { vertices, triangles: vec![[0, 1, 2], [0, 2, 3], [2, 1, 3], [1, 0, 3]] };
    assert!(matches!(refused(&pillow), MeshError::NoVolume { .. }));
}

#[test]
fn components_and_cavities() {
    let cube = cube();
    let apart = joined(&cube, &shifted(&cube, DVec3::X * 0.2));
    assert_eq!(check_solid(&apart).unwrap().components, 2);
    let inner = scaled(&cube, 0.5);
    let nested = joined(&cube, &inner);
    match refused(&nested) {
        MeshError::Nested { position } => assert!(position.abs().max_element() <= 0.025),
        other => panic!("{other}"),
    }
    let hollow = check_solid(&joined(&cube, &inverted(&inner))).unwrap();
    // Residual seen: 2e-19 m³.
    assert!((hollow.mass.volume - 0.875e-3).abs() < 1e-17);
    // A ball in the cavity is solid again; an inverted one beside the cube is not.
    let matryoshka = joined(&joined(&cube, &inverted(&inner)), &scaled(&cube, 0.2));
    assert_eq!(check_solid(&matryoshka).unwrap().components, 3);
    let beside = joined(&cube, &inverted(&shifted(&inner, DVec3::X * 0.3)));
    assert!(matches!(refused(&beside), MeshError::Inverted { .. }));
}

#[test]
fn surfaces_that_cross() {
    let cube = cube();
    for shift in [DVec3::new(0.03, 0.02, 0.01), DVec3::new(0.037, 0.041, 0.029), DVec3::new(0.03, 0.0, 0.0)] {
        let crossing = joined(&cube, &shifted(&cube, shift));
        match refused(&crossing) {
            MeshError::SelfIntersection { first, second, position } => {
                assert!(first < cube.triangles.len() && second >= cube.triangles.len());
                assert!(position.abs().max_element() < 0.1 + 1e-9);
            }
            other => panic!("{shift}: {other}"),
        }
    }
    // One surface: a vertex of a sphere pulled through the far side.
    let mut ball = Shape::parse("sphere:0.01").unwrap().mesh();
    ball.vertices[100] *= -1.2;
    assert!(matches!(refused(&ball), MeshError::SelfIntersection { .. }));
    // Boxes that share a face overlap in its plane; boxes a hair apart do not.
    let touching = joined(&cube, &shifted(&cube, DVec3::new(0.1, 0.03, 0.02)));
    assert!(matches!(refused(&touching), MeshError::SelfIntersection { .. }));
    assert!(check_solid(&joined(&cube, &shifted(&cube, DVec3::new(0.1 + 1e-9, 0.03, 0.02)))).is_ok());
}
