//! A model comes back from its file bit by bit; a file that was cut, damaged or edited is refused, and never a panic.

use clangor::geometry::mass_properties::MassProperties;
use clangor::geometry::tri_mesh::TriMesh;
use clangor::glam::DVec3;
use clangor::model::acceleration_field::{AccelerationField, DEGREES, Node, Term};
use clangor::model::acceleration_model::AccelerationModel;
use clangor::model::model_file::{ModelFile, Origin, Solid};
use clangor::model::near_field::NearField;
use clangor::model::tensor_file::TensorFileError;
use num_complex::{Complex32, Complex64};
use proptest::prelude::*;
use safetensors::SafeTensors;
use twox_hash::xxhash3_128::Hasher;

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
    let near = surface.vertices.len() * DEGREES * field.nodes.len();
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

/// Where the hash is, found with the container's own reader.
fn hash_place(bytes: &[u8]) -> usize {
    let (header, metadata) = SafeTensors::read_metadata(bytes).unwrap();
    8 + header + metadata.info("content_hash").unwrap().data_offsets.0
}

/// Gives an edited file the hash of its new content.
fn forge(mut bytes: Vec<u8>) -> Vec<u8> {
    let place = hash_place(&bytes);
    bytes[place..place + 16].fill(0);
    let hash = Hasher::oneshot(&bytes);
    bytes[place..place + 16].copy_from_slice(&hash.to_be_bytes());
    bytes
}

/// Replaces text in the header without moving anything.
fn edit(bytes: &[u8], from: &str, to: &str) -> Vec<u8> {
    assert_eq!(from.len(), to.len());
    let at = bytes.windows(from.len()).position(|w| w == from.as_bytes()).expect("the text is there");
    let mut edited = bytes.to_vec();
    edited[at..at + to.len()].copy_from_slice(to.as_bytes());
    forge(edited)
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
    let bytes = model().encode().unwrap();
    for length in 0..bytes.len() {
        assert!(ModelFile::decode(&bytes[..length]).is_err(), "{length}");
    }
    let mut longer = bytes.clone();
    longer.push(0);
    assert!(ModelFile::decode(&longer).is_err());
    for at in 0..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[at] ^= 1 << (at % 8);
        assert!(ModelFile::decode(&damaged).is_err(), "{at}");
    }
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
        let mut bytes = model().encode().unwrap();
        for (at, bit) in flips {
            let at = at.index(bytes.len());
            bytes[at] ^= 1 << bit;
        }
        let whole = |t: SafeTensors<'_>| t.tensor("content_hash").is_ok_and(|h| h.data().len() == 16);
        if SafeTensors::deserialize(&bytes).is_ok_and(whole)
            && let Ok(model) = ModelFile::decode(&forge(bytes))
        {
            let field = &model.acceleration.field;
            let _ = field.pressure(&[1.0; DEGREES], DVec3::new(1.0, 2.0, 0.5), 1.3);
            let _ = model.acceleration.max_frequency(343.2);
        }
    }
}
