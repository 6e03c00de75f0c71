//! Files of objects to be struck: a ball and a cube about the origin, with modes of uniform motion, so that
//! every point moves alike.

use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::glam::DVec3;
use clangor_core::material::presets;
use clangor_core::medium::Medium;
use clangor_core::sound_model::files::modal_file::{ModalFile, ModalOrigin, ModalPart};
use clangor_core::sound_model::files::model_file::Solid;
use clangor_core::sound_model::modal::model::{ModalMode, ModalModel};
use clangor_core::sound_model::modal::surface::ModalSurface;
use clangor_web::wasm_buffer::write;

/// Radius of the ball, half the edge of the cube \[m\].
pub(crate) const SIZE: f64 = 0.02;
/// Frequencies of the modes \[Hz\].
pub(crate) const FREQUENCIES: [f64; 2] = [700.0, 9000.0];

/// A solid ball whose modes move along y by `motion` [kg^−½], a number that 32 bits hold.
pub(crate) fn ball(material: &str, motion: f64) -> Vec<u8> {
    let solid = Solid { name: "ball".into(), mass: MassProperties::of_sphere(SIZE), surface: None };
    file(solid, material, motion)
}

/// A solid cube with the same modes.
pub(crate) fn cube(material: &str, motion: f64) -> Vec<u8> {
    let corner = |i: u32| {
        let side = |bit: u32| if i >> bit & 1 == 1 { SIZE } else { -SIZE };
        DVec3::new(side(0), side(1), side(2))
    };
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    let mesh = TriMesh { vertices: (0..8).map(corner).collect(), triangles };
    let mass = MassProperties::of(&mesh).unwrap();
    file(Solid { name: "cube".into(), mass, surface: Some(mesh) }, material, motion)
}

fn file(solid: Solid, material: &str, motion: f64) -> Vec<u8> {
    let elastic = presets::preset(material).unwrap_or(presets::CERAMIC.material());
    let corners = [DVec3::X, DVec3::Y, DVec3::Z].map(|x| SIZE * x);
    let middles = [(0, 1), (1, 2), (2, 0)].map(|(a, b)| 0.5 * (corners[a] + corners[b]));
    let nodes: Vec<DVec3> = corners.into_iter().chain(middles).collect();
    let mode = |frequency| ModalMode {
        frequency,
        mesh_error: 0.0,
        support_damping: 0.0,
        shape: vec![motion * DVec3::Y; nodes.len()],
        transfer: None,
    };
    let radius = solid.surface.as_ref().map_or(SIZE, |_| 3f64.sqrt() * SIZE);
    let model = ModalModel {
        radius,
        medium: Medium::AIR,
        density: elastic.density,
        max_frequency: 20_000.0,
        statistical_above: None,
        modes: FREQUENCIES.map(mode).to_vec(),
        surface: ModalSurface { nodes, triangles: vec![[0, 1, 2, 3, 4, 5]] },
    };
    let origin = ModalOrigin {
        program: "test".into(),
        inputs: "0123456789abcdef0123456789abcdef".into(),
        material: material.into(),
        youngs_modulus: elastic.youngs_modulus,
        poisson_ratio: elastic.poisson_ratio,
        asked_mesh_error: 1e-2,
        asked_accuracy: 1e-2,
        mesh: "one triangle".into(),
        nodes: 6,
        residual: 0.0,
        first_frequency: None,
        method: String::new(),
        warnings: Vec::new(),
    };
    ModalFile { modal: ModalPart { model, origin }, solid }.encode().unwrap()
}

/// Puts numbers into the buffer, as the page does.
pub(crate) fn write_numbers(numbers: &[f64]) {
    let bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
    write(&bytes);
}
