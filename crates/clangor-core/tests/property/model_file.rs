//! A model comes back from its file bit by bit; a file that was cut, damaged or edited is rejected, and never
//! a panic.

use crate::damage::{TENSOR_WORDS, all_is_noticed, edit, forge, forged, forged_damage};
use crate::fuzzing::{Target, fuzz};
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::glam::DVec3;
use clangor_core::medium::Medium;
use clangor_core::sound_model::acceleration::field::{AccelerationField, Node, RIGID_DOFS, Term};
use clangor_core::sound_model::acceleration::model::AccelerationModel;
use clangor_core::sound_model::acceleration::model_evaluator::ModelEvaluator;
use clangor_core::sound_model::acceleration::near_field::NearField;
use clangor_core::sound_model::files::model_file::{ModelFile, Origin, Solid};
use clangor_core::sound_model::files::tensor_file::TensorFileError;
use num_complex::{Complex32, Complex64};
use proptest::prelude::*;

fn tetrahedron() -> TriMesh {
    let corner = |x, y, z| DVec3::new(x, y, z) * 0.57;
    TriMesh {
        vertices: vec![
            corner(1.0, 1.0, 1.0),
            corner(1.0, -1.0, -1.0),
            corner(-1.0, 1.0, -1.0),
            corner(-1.0, -1.0, 1.0),
        ],
        triangles: vec![[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]],
    }
}

/// A small model in which nothing is zero by accident.
fn model() -> ModelFile {
    let terms: Vec<Term> = [(1, -1, 1), (1, 0, 2), (1, 1, 0), (2, -2, 5), (3, 3, 4)]
        .map(|(n, m, degree)| Term { n, m, degree })
        .to_vec();
    let node = |k: f64| Node { s: Complex64::new(0.01 * k, k), weight: Complex64::new(1.0 / k, -k) };
    let nodes: Vec<Node> = [0.3, 1.1, 2.7].map(node).to_vec();
    let wave = |count: usize, phase: f32| (0..count).map(|i| (i as f32 * 0.7 + phase).sin()).collect();
    let count = terms.len() * nodes.len();
    let radius = 0.0123;
    let field = AccelerationField {
        max_wavenumber: 4.5,
        ring_time: 9.25,
        real: wave(count, 0.1),
        imaginary: wave(count, 0.2),
        terms,
        nodes,
    };
    let surface = tetrahedron();
    let near = surface.vertices.len() * RIGID_DOFS * field.nodes.len();
    let pressures: Vec<Complex32> = (0..near).map(|i| Complex32::cis(0.7 * i as f32)).collect();
    let near = NearField::from_pressures(surface.clone(), field.nodes.len(), &pressures);
    let mut solid = surface;
    solid.vertices.iter_mut().for_each(|v| *v *= radius);
    ModelFile {
        acceleration: AccelerationModel { radius, field, near: Some(near) },
        modal: None,
        solid: Solid {
            name: "tetra.obj".into(),
            mass: MassProperties {
                centre_of_mass: DVec3::new(0.1, -0.2, 1.0 / 3.0),
                ..MassProperties::of_sphere(0.01)
            },
            surface: Some(solid),
        },
        origin: Origin {
            program: "clangor 0.1.0".into(),
            inputs: "0123456789abcdef0123456789abcdef".into(),
            asked_accuracy: 1e-3,
            method: "by hand".into(),
            unknowns: 12,
            solves: 3,
            held_out_error: 4.5e-4,
            warnings: vec!["thin wall near [0, 0, 1] m".into()],
        },
    }
}

#[test]
fn models_come_back_bit_by_bit() {
    let mut with_all = model();
    let bytes = with_all.encode().unwrap();
    assert_eq!(ModelFile::decode(&bytes).unwrap(), with_all);
    assert_eq!(bytes, with_all.encode().unwrap());
    assert_eq!(forge(bytes.clone()), bytes);
    with_all.acceleration.near = None;
    with_all.solid.surface = None;
    let bytes = with_all.encode().unwrap();
    assert_eq!(ModelFile::decode(&bytes).unwrap(), with_all);
}

#[test]
fn every_truncation_and_every_flipped_byte_is_noticed() {
    all_is_noticed(&model().encode().unwrap(), ModelFile::decode);
}

#[test]
fn what_cannot_be_is_refused_even_with_the_right_hash() {
    let bytes = model().encode().unwrap();
    let refused = |edited: Vec<u8>| ModelFile::decode(&edited).unwrap_err();
    let quoted = |key: &str, value: &str| format!("\\\"{key}\\\":{value}");
    assert!(matches!(
        refused(edit(&bytes, &quoted("version", "2"), &quoted("version", "3"))),
        TensorFileError::Version { found: 3, known: 2 }
    ));
    assert!(matches!(refused(edit(&bytes, "sound model", "sound mould")), TensorFileError::Kind { .. }));
    assert!(matches!(refused(edit(&bytes, "near.which", "near.witch")), TensorFileError::Missing { .. }));
    assert!(matches!(refused(edit(&bytes, "[5,3]", "[3,5]")), TensorFileError::Shape { .. }));
    assert!(matches!(
        refused(edit(&bytes, &quoted("radius_m", "0.0123"), &quoted("radius_m", "-0.123"))),
        TensorFileError::Value { .. }
    ));
    assert!(matches!(
        refused(edit(&bytes, "\\\"origin\\\"", "\\\"oregon\\\"")),
        TensorFileError::Description { .. }
    ));
    let foreign =
        safetensors::serialize(Vec::<(&str, safetensors::tensor::TensorView<'_>)>::new(), None).unwrap();
    assert!(matches!(refused(foreign), TensorFileError::Foreign { .. }));
    assert!(matches!(refused(b"RIFF....WAVEfmt ".to_vec()), TensorFileError::Container { .. }));
}

#[test]
fn models_that_could_not_be_read_are_not_written() {
    let spoil = |change: &dyn Fn(&mut ModelFile)| {
        let mut bad = model();
        change(&mut bad);
        bad.encode().expect_err("spoilt").to_string()
    };
    type Case<'a> = (&'a str, &'a dyn Fn(&mut ModelFile));
    let cases: &[Case<'_>] = &[
        ("not finite", &|m| m.acceleration.field.real[3] = f32::NAN),
        ("repeats", &|m| m.acceleration.field.nodes[1].s = m.acceleration.field.nodes[0].s),
        ("every weight", &|m| m.acceleration.field.nodes.iter_mut().for_each(|n| n.weight = Complex64::ZERO)),
        ("not after", &|m| m.acceleration.field.terms.swap(0, 1)),
        ("no multipole", &|m| m.acceleration.field.terms[4].degree = 6),
        ("no multipole", &|m| m.acceleration.field.terms[0].m = -2),
        ("14 numbers", &|m| m.acceleration.field.imaginary.truncate(14)),
        ("vertex", &|m| m.solid.surface.as_mut().unwrap().triangles[0][0] = 4),
        ("outside", &|m| m.acceleration.near.as_mut().unwrap().surface.vertices[2] *= 2.0),
        ("spectrum", &|m| m.acceleration.near.as_mut().unwrap().which[7] = 1 << 20),
        ("near.factors", &|m| m.acceleration.near.as_mut().unwrap().factors[7] = f32::INFINITY),
        ("inertia", &|m| m.solid.mass.inertia.x_axis.x = -1.0),
        ("volume", &|m| m.solid.mass.volume = 0.0),
        ("ring time", &|m| m.acceleration.field.ring_time = f64::INFINITY),
        ("wavenumber", &|m| m.acceleration.field.max_wavenumber = 0.0),
        ("0 rows", &|m| m.acceleration.field.nodes.clear()),
        ("held-out", &|m| m.origin.held_out_error = f64::NAN),
        // Finite, but the sums and quotients of the field are not.
        ("node 0", &|m| m.acceleration.field.nodes[0].s = Complex64::new(-1e200, 1.0)),
        ("the weight of node 1", &|m| m.acceleration.field.nodes[1].weight = Complex64::new(1e300, 0.0)),
        ("acceleration.real", &|m| m.acceleration.field.real[3] = 3e38),
        ("ring time", &|m| m.acceleration.field.ring_time = 1e300),
    ];
    for (wanted, change) in cases {
        let message = spoil(change);
        assert!(message.contains(wanted), "{wanted}: {message}");
    }
}

proptest! {
    #[test]
    fn forged_damage_is_an_error_or_a_playable_model(
        flips in proptest::collection::vec((any::<prop::sample::Index>(), 0..8u8), 1..4),
    ) {
        let bytes = model().encode().unwrap();
        if let Some(bytes) = forged_damage(bytes, &flips)
            && let Ok(model) = ModelFile::decode(&bytes)
        {
            let field = &model.acceleration.field;
            let _ = field.pressure(&[1.0; RIGID_DOFS], DVec3::new(1.0, 2.0, 0.5), 1.3);
            let _ = model.acceleration.max_frequency(Medium::AIR.sound_speed);
        }
    }
}

#[test]
fn fuzz_models() {
    let mut target = Target::parser("models", "safetensors", vec![model().encode().unwrap()], &TENSOR_WORDS);
    target.mend = &forged;
    fuzz(&target, &|_, bytes| match ModelFile::decode(bytes) {
        Err(error) => error.to_string(),
        Ok(file) => {
            let field = &file.acceleration.field;
            let pressure = field.pressure(&[1.0; RIGID_DOFS], DVec3::new(1.0, 2.0, 0.5), 1.3);
            assert!(pressure.is_finite(), "{pressure}");
            let made = ModelEvaluator::try_new(&file.acceleration).map(|_| "a model");
            made.map_or_else(|error| error.to_string(), str::to_owned)
        }
    });
}
