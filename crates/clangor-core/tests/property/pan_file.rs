//! A published model comes back from its file bit by bit; a file that was cut, damaged or edited is rejected.

use crate::damage::all_is_noticed;
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::reference::pan_file::PanFile;
use clangor_core::reference::pan_representation::directions::Directions;
use clangor_core::reference::pan_representation::signals::{Signals, SparseCoefficients};
use clangor_core::reference::pan_representation::{PanField, PanModel};
use clangor_core::sound_model::acceleration::field::RIGID_DOFS;
use clangor_core::sound_model::files::model_file::{ModelFile, Origin, Solid};
use clangor_core::sound_model::files::tensor_file::TensorFileError;

fn field(directions: Directions, pulse: f64, signals: Signals) -> PanField {
    PanField { pulse, step: 0.1, start: -1.25, length: 8, terms: 2, directions, signals }
}

/// A small model of both kinds of signals.
fn file() -> PanFile {
    let angles = Directions::Angles { rows: 1, columns: 2 };
    let samples = (0..2 * RIGID_DOFS * 2 * 8).map(|i| (0.7 * i as f32).sin()).collect();
    let octant = Directions::Octant { divisions: 1 };
    let pairs = 3 * RIGID_DOFS;
    let sparse = SparseCoefficients {
        first: (0..=pairs as u32).collect(),
        places: (0..pairs as u16).map(|i| i % 8).collect(),
        values: (0..2 * pairs).map(|i| (0.3 * i as f32).cos()).collect(),
    };
    let fields =
        vec![field(angles, 0.5, Signals::Samples(samples)), field(octant, 1.0, Signals::Wavelets(sparse))];
    PanFile {
        model: PanModel::new(0.01, fields).unwrap(),
        solid: Solid { name: "ball".into(), mass: MassProperties::of_sphere(0.01), surface: None },
        origin: Origin {
            program: "clangor".into(),
            inputs: "0123456789abcdef0123456789abcdef".into(),
            asked_accuracy: 1e-3,
            method: "by hand".into(),
            unknowns: 12,
            solves: 3,
            held_out_error: 4.5e-4,
            warnings: vec!["to be compared with".into()],
        },
    }
}

#[test]
fn models_come_back_bit_by_bit() {
    let file = file();
    let bytes = file.encode().unwrap();
    assert_eq!(PanFile::decode(&bytes).unwrap(), file);
    assert_eq!(bytes, file.encode().unwrap());
    assert!(matches!(ModelFile::decode(&bytes), Err(TensorFileError::Kind { .. })));
}

#[test]
fn every_truncation_and_every_flipped_byte_is_noticed() {
    all_is_noticed(&file().encode().unwrap(), PanFile::decode);
}
