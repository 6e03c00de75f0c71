//! Bodies with closed cavities against solid ones of the same outer surface: what the air outside hears of
//! both is the same, clicks and modes alike.

use std::collections::BTreeMap;
use std::ops::ControlFlow;

use clangor_bake::acceleration::{BakeOptions, bake};
use clangor_bake::fitting::comparison::six_pressures;
use clangor_bake::geometry_class::bake_geometry::BakeGeometry;
use clangor_bake::modal::{ModalBakeOptions, ModalEvidence, radiate};
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::glam::DVec3;
use clangor_core::material::presets::STEEL;
use clangor_core::medium::Medium;
use clangor_core::shape::Shape;
use clangor_core::sound_model::modal::model::{ModalMode, ModalModel, ModalTransfer};
use clangor_core::sound_model::modal::surface::ModalSurface;

fn shape(text: &str) -> TriMesh {
    Shape::parse(text).expect("a shape").mesh()
}

/// A body with a cavity of its own form, smaller and beside the middle \[m\].
fn hollow(outer: &TriMesh, smaller: f64, at: DVec3) -> TriMesh {
    let start = outer.vertices.len() as u32;
    let inner = outer.vertices.iter().map(|v| at + smaller * *v);
    let inward = outer.triangles.iter().map(|[a, b, c]| [a + start, c + start, b + start]);
    TriMesh {
        vertices: outer.vertices.iter().copied().chain(inner).collect(),
        triangles: outer.triangles.iter().copied().chain(inward).collect(),
    }
}

/// Length \[m\] at which a rotation counts as much as an acceleration.
const ARM: f64 = 0.02;

/// Pressures of the six motions about a point `centre` \[m\] of a solid body.
fn click(mesh: &TriMesh, centre: DVec3) -> impl Fn(DVec3, f64) -> [num_complex::Complex64; 6] {
    let geometry = BakeGeometry::of_mesh(&mesh.relative_to(centre));
    let options = BakeOptions::new(180.0, 0.01);
    let (model, evidence) = bake(&geometry, &options, &mut |_| ControlFlow::Continue(())).expect("a model");
    println!("{}, {} unknowns", evidence.method, evidence.unknowns);
    move |x, k| six_pressures(&model, x - centre, k, ARM)
}

#[test]
fn hollow_bodies_click_as_solid_ones() {
    // A cavity beside the middle moves the centre of mass, about which the motions are.
    for (form, beside) in [
        ("sphere:0.03", DVec3::ZERO),
        ("cylinder:0.02x0.05", DVec3::ZERO),
        ("box:0.05x0.02x0.03", DVec3::new(0.001, 0.0, 0.002)),
    ] {
        let solid = shape(form);
        let shell = hollow(&solid, 0.8, beside);
        let centre = MassProperties::of(&shell).expect("a solid").centre_of_mass;
        assert!(BakeGeometry::of_mesh(&shell.relative_to(centre)).encloses_air(), "{form}");
        let (solid, shell) = (click(&solid, centre), click(&shell, centre));
        let (mut error, mut size) = (0.0, 0.0);
        // To well above the resonances of the cavities.
        for k in [5.0, 40.0, 93.5, 120.0, 180.0] {
            for direction in [DVec3::X, DVec3::new(-1.0, 2.0, 0.5), DVec3::new(0.3, -1.0, 1.0), DVec3::Z] {
                let x = 0.15 * direction.normalize();
                for (a, b) in shell(x, k).iter().zip(solid(x, k)) {
                    error += (a - b).norm_sqr();
                    size += b.norm_sqr();
                }
            }
        }
        let apart: f64 = (error / size).sqrt();
        println!("{form}: {apart:.1e}");
        // Seen: 0, 0 and 3.9e-8.
        assert!(apart < 1e-6, "{form}: {apart:.1e}");
    }
}

/// Every triangle with the middles of its sides.
fn six_nodes(mesh: &TriMesh) -> ModalSurface {
    let mut nodes = mesh.vertices.clone();
    let mut middles = BTreeMap::new();
    let mut middle = |a: u32, b: u32| {
        *middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
            nodes.push(0.5 * (mesh.vertices[a as usize] + mesh.vertices[b as usize]));
            nodes.len() as u32 - 1
        })
    };
    let with_middles = |[a, b, c]: &[u32; 3]| [*a, *b, *c, middle(*a, *b), middle(*b, *c), middle(*c, *a)];
    let triangles = mesh.triangles.iter().map(with_middles).collect();
    ModalSurface { nodes, triangles }
}

/// The transfer of a mode that breathes and bends, of a mesh.
fn transfer(mesh: &TriMesh) -> ModalTransfer {
    let surface = six_nodes(mesh);
    let motion = |x: &DVec3| *x * (20.0 + 3e4 * x.x * x.z) + 0.2 * x.y * DVec3::Y;
    let mode = ModalMode {
        frequency: 6000.0,
        mesh_error: 0.0,
        support_damping: 0.0,
        shape: surface.nodes.iter().map(motion).collect(),
        transfer: None,
    };
    let (density, max_frequency, medium) = (STEEL.density, 7000.0, Medium::AIR);
    let (radius, statistical_above) = (surface.radius(), None);
    let modes = vec![mode];
    let mut model = ModalModel { radius, medium, density, max_frequency, statistical_above, surface, modes };
    let geometry = BakeGeometry::Mesh(mesh.clone());
    let options = ModalBakeOptions::new(medium);
    let go_on = &mut |_: &_| ControlFlow::Continue(());
    radiate(&geometry, &mut model, &mut ModalEvidence::default(), &options, go_on).expect("transfers");
    model.modes.remove(0).transfer.expect("a transfer")
}

#[test]
fn modes_of_a_hollow_body_are_heard_as_those_of_its_outer_surface() {
    // An egg of three different axes.
    let solid = shape("ellipsoid:0.03x0.02x0.015");
    let (hollow, solid) = (transfer(&hollow(&solid, 0.8, DVec3::ZERO)), transfer(&solid));
    let apart = |a: &ModalTransfer, b: &ModalTransfer| {
        let pairs = a.coefficients.iter().zip(&b.coefficients);
        let size: f64 = b.coefficients.iter().map(|c| c.norm_sqr()).sum();
        (pairs.map(|(a, b)| (a - b).norm_sqr()).sum::<f64>() / size).sqrt()
    };
    assert_eq!(hollow.order, solid.order);
    let error = apart(&hollow, &solid);
    println!("{error:.1e}");
    // Seen: 5.0e-4, of other triangles.
    assert!(error < 1e-3, "{error:.1e}");
}
