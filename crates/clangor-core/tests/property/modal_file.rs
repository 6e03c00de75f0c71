//! A modal model comes back from its file bit by bit, alone or as a part of a sound model; a file that was
//! cut, damaged or edited is rejected, and never a panic.

use crate::damage::{TENSOR_WORDS, all_is_noticed, edit, forged};
use crate::fuzzing::{Target, fuzz};
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::glam::DVec3;
use clangor_core::medium::Medium;
use clangor_core::sound_model::acceleration::field::{AccelerationField, Node, Term};
use clangor_core::sound_model::acceleration::model::AccelerationModel;
use clangor_core::sound_model::files::modal_file::{ModalFile, ModalOrigin, ModalPart};
use clangor_core::sound_model::files::model_file::{ModelFile, Origin, Solid};
use clangor_core::sound_model::files::tensor_file::TensorFileError;
use clangor_core::sound_model::modal::model::{ModalMode, ModalModel, ModalTransfer};
use clangor_core::sound_model::modal::surface::ModalSurface;
use num_complex::Complex64;
use proptest::prelude::*;

/// A tetrahedron of six-node triangles, and modes of these orders; `None` without a transfer.
fn part(orders: &[Option<usize>], seed: f64) -> ModalPart {
    let corner = |x, y, z| DVec3::new(x, y, z) * 0.0057;
    let mut nodes = vec![
        corner(1.0, 1.0, 1.0),
        corner(1.0, -1.0, -1.0),
        corner(-1.0, 1.0, -1.0),
        corner(-1.0, -1.0, 1.0),
    ];
    let edges = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];
    nodes.extend(edges.map(|[a, b]: [usize; 2]| 0.5 * (nodes[a] + nodes[b])));
    let middle = |a: u32, b: u32| {
        4 + edges.iter().position(|e| *e == [a.min(b) as usize, a.max(b) as usize]).unwrap() as u32
    };
    let triangles = [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]]
        .map(|[a, b, c]| [a, b, c, middle(a, b), middle(b, c), middle(c, a)]);
    let surface = ModalSurface { nodes, triangles: triangles.to_vec() };
    let wave = |i: usize| (seed + 0.7 * i as f64).sin();
    let mode = |(at, order): (usize, &Option<usize>)| ModalMode {
        frequency: 1234.5 * (1.0 + at as f64) + seed,
        mesh_error: 1e-3 * wave(at).abs(),
        support_damping: 0.0,
        shape: (0..10).map(|i| DVec3::new(wave(i + at), wave(3 * i), -wave(7 * i + at))).collect(),
        transfer: order.map(|order| ModalTransfer {
            order,
            coefficients: (0..(order + 1) * (order + 1))
                .map(|i| Complex64::new(1e-20 * wave(i), 1e9 * wave(5 * i)))
                .collect(),
        }),
    };
    let model = ModalModel {
        radius: surface.radius(),
        medium: Medium::AIR,
        density: 7850.0,
        max_frequency: 20_000.0,
        statistical_above: (seed > 3.0).then_some(1000.0 * seed),
        surface,
        modes: orders.iter().enumerate().map(mode).collect(),
    };
    let origin = ModalOrigin {
        program: "clangor 0.1.0".into(),
        inputs: "0123456789abcdef0123456789abcdef".into(),
        material: "steel".into(),
        youngs_modulus: 2e11,
        poisson_ratio: 0.29,
        asked_mesh_error: 1e-2,
        asked_accuracy: 1e-2,
        mesh: "one tetrahedron".into(),
        nodes: 10,
        residual: 3e-9,
        first_frequency: None,
        method: "by hand".into(),
        warnings: vec!["thin".into()],
    };
    ModalPart { model, origin }.rounded()
}

fn solid() -> Solid {
    Solid { name: "tetra.obj".into(), mass: MassProperties::of_sphere(0.01), surface: None }
}

fn file() -> ModalFile {
    ModalFile { modal: part(&[Some(2), None, Some(0)], 0.3), solid: solid() }
}

/// A click of one term.
fn click() -> AccelerationModel {
    let field = AccelerationField {
        max_wavenumber: 4.5,
        ring_time: 9.25,
        nodes: vec![Node { s: Complex64::I, weight: Complex64::ONE }],
        terms: vec![Term { n: 1, m: 0, degree: 2 }],
        real: vec![0.5],
        imaginary: vec![0.25],
    };
    AccelerationModel { radius: 0.0099, field, near: None }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]
    #[test]
    fn modal_models_come_back_bit_by_bit(
        orders in prop::collection::vec(prop::option::of(0_usize..6), 0..5),
        seed in 0.0..6.0,
    ) {
        let file = ModalFile { modal: part(&orders, seed), solid: solid() };
        let bytes = file.encode().unwrap();
        prop_assert_eq!(&ModalFile::decode(&bytes).unwrap(), &file);
        prop_assert_eq!(bytes, file.encode().unwrap());
        let ModalFile { modal, solid } = file;
        let origin = Origin {
            program: "clangor 0.1.0".into(),
            inputs: "00112233445566778899aabbccddeeff".into(),
            asked_accuracy: 1e-3,
            method: "by hand".into(),
            unknowns: 12,
            solves: 3,
            held_out_error: 4.5e-4,
            warnings: Vec::new(),
        };
        let both = ModelFile { acceleration: click(), modal: Some(modal), solid, origin };
        prop_assert_eq!(&ModelFile::decode(&both.encode().unwrap()).unwrap(), &both);
    }
}

#[test]
fn every_truncation_and_every_flipped_byte_is_noticed() {
    all_is_noticed(&file().encode().unwrap(), ModalFile::decode);
}

#[test]
fn what_cannot_be_is_refused_even_with_the_right_hash() {
    let bytes = file().encode().unwrap();
    let refused = |edited: Vec<u8>| ModalFile::decode(&edited).unwrap_err();
    let quoted = |key: &str, value: &str| format!("\\\"{key}\\\":{value}");
    let version = refused(edit(&bytes, &quoted("version", "1"), &quoted("version", "2")));
    assert!(matches!(version, TensorFileError::Version { found: 2, known: 1 }), "{version}");
    assert!(matches!(refused(edit(&bytes, "modal model", "model modal")), TensorFileError::Kind { .. }));
    assert!(matches!(refused(edit(&bytes, "modal.real", "modal.ream")), TensorFileError::Missing { .. }));
    let poisson = quoted("poisson_ratio", "0.29");
    let refusal = refused(edit(&bytes, &poisson, &quoted("poisson_ratio", "0.59")));
    assert!(refusal.to_string().contains("Poisson's ratio is 0.59"), "{refusal}");
    // A sound model is no modal model, and the other way round.
    assert!(matches!(ModelFile::decode(&bytes).unwrap_err(), TensorFileError::Kind { .. }));
}

#[test]
fn what_could_not_be_read_is_not_written() {
    let refused = |spoil: &dyn Fn(&mut ModalModel)| {
        let mut file = file();
        spoil(&mut file.modal.model);
        file.encode().unwrap_err().to_string()
    };
    type Case<'a> = (&'a str, &'a dyn Fn(&mut ModalModel));
    let cases: &[Case<'_>] = &[
        ("mode 1 is below", &|m| m.modes[1].frequency = 10.0),
        ("mode 0 is NaN", &|m| m.modes[0].frequency = f64::NAN),
        ("node 3 of the shape of mode 2", &|m| m.modes[2].shape[3].y = 1e300),
        ("modal.shapes", &|m| m.modes[0].shape.truncate(4)),
        ("modal.real", &|m| m.modes[0].transfer.as_mut().unwrap().order = 3),
        ("not finite", &|m| {
            m.modes[0].transfer.as_mut().unwrap().coefficients[1].re = f64::INFINITY;
        }),
        ("names a node that is not among the 10", &|m| m.surface.triangles[0][5] = 10),
        ("outside the bounding sphere", &|m| m.surface.nodes[0] *= 1.1),
    ];
    for (expected, spoil) in cases {
        let message = refused(spoil);
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn fuzz_modal_models() {
    let mut target =
        Target::parser("modal-models", "safetensors", vec![file().encode().unwrap()], &TENSOR_WORDS);
    target.mend = &forged;
    fuzz(&target, &|_, bytes| match ModalFile::decode(bytes) {
        Err(error) => error.to_string(),
        Ok(file) => {
            for mode in &file.modal.model.modes {
                if let Some(transfer) = &mode.transfer {
                    let pressure = transfer.undelayed(DVec3::new(1.0, 2.0, 0.5), 1.3);
                    assert!(pressure.is_finite() && transfer.power(1.3) >= 0.0, "{pressure}");
                }
            }
            "modes".into()
        }
    });
}
