//! A soundbank comes back from its file within 16 bits; a file that was cut, damaged or edited is rejected,
//! never a panic.

use crate::damage::{TENSOR_WORDS, all_is_noticed, forged, forged_damage};
use crate::fuzzing::{Target, fuzz};
use clangor_core::glam::DVec3;
use clangor_core::sound_model::acceleration::field::{AccelerationField, Node, RIGID_DOFS, Term};
use clangor_core::sound_model::files::ellipsoid_bank_file::{BankFile, BankOrigin};
use clangor_core::sound_model::files::model_file::ModelFile;
use clangor_core::sound_model::files::tensor_file::TensorFileError;
use clangor_core::sound_model::soundbank::ellipsoid_bank::{BankEntry, EllipsoidBank};
use num_complex::Complex64;
use proptest::prelude::*;

/// A field of a few orders that fall off, the faster the lower the frequency.
fn field(seed: usize, order: u8) -> AccelerationField {
    let mut terms = Vec::new();
    for n in 0..=order {
        for m in -(n as i8)..=n as i8 {
            let degree = (m.unsigned_abs() + n) % RIGID_DOFS as u8;
            terms.push(Term { n, m, degree });
        }
    }
    let nodes: Vec<Node> = (1..=5 + seed)
        .map(|j| Node {
            s: Complex64::new(0.0, 0.7 * j as f64),
            weight: Complex64::from_polar(1.0, j as f64),
        })
        .collect();
    let wave = |phase: f32| {
        let count = nodes.len();
        let value = |(row, t): (usize, &Term)| -> Vec<f32> {
            let falls = |j: usize| (0.2 * (j + 1) as f32).powi(i32::from(t.n)).min(1.0);
            (0..count).map(|j| falls(j) * ((row * 3 + j) as f32 + phase + seed as f32).sin()).collect()
        };
        terms.iter().enumerate().flat_map(value).collect::<Vec<f32>>()
    };
    AccelerationField {
        max_wavenumber: 4.0,
        ring_time: 6.0,
        real: wave(0.1),
        imaginary: wave(0.7),
        nodes: nodes.clone(),
        terms: terms.clone(),
    }
}

fn bank() -> BankFile {
    let entries = [(0.3, 0.2), (1.0, 0.05), (1.0, 1.0)];
    let entries =
        entries.iter().enumerate().map(|(i, &(b, c))| BankEntry { b, c, field: field(i, 5) }).collect();
    BankFile {
        bank: EllipsoidBank::try_new(entries).unwrap(),
        origin: BankOrigin {
            program: "clangor 0.1.0".into(),
            asked_accuracy: 1e-3,
            method: "by hand".into(),
            solves: 66,
            held_out_error: 3e-4,
        },
    }
}

#[test]
fn fields_come_back_within_their_sixteen_bits() {
    let before = bank();
    let after = BankFile::decode(&before.encode(0.0).unwrap()).unwrap();
    assert_eq!(after.origin, before.origin);
    for (old, new) in before.bank.entries().iter().zip(after.bank.entries()) {
        assert_eq!((old.b, old.c), (new.b, new.c));
        assert_eq!((&old.field.nodes, &old.field.terms), (&new.field.nodes, &new.field.terms));
        let count = old.field.nodes.len();
        for row in 0..old.field.terms.len() {
            let at = row * count..(row + 1) * count;
            let pairs = |f: &AccelerationField| [&f.real[at.clone()], &f.imaginary[at.clone()]].concat();
            let (old, new) = (pairs(&old.field), pairs(&new.field));
            let largest = old.iter().fold(0.0f32, |m, q| m.max(q.abs()));
            for (q, r) in old.iter().zip(&new) {
                // Half a step of 1/32767, and the rounding of f32.
                assert!((q - r).abs() <= largest * (0.5 / 32767.0 + 1e-6), "{q} {r}");
            }
        }
    }
    // Written again, it does not change any more.
    let again = BankFile::decode(&after.encode(0.0).unwrap()).unwrap();
    let difference = |a: &BankFile, b: &BankFile| {
        let pairs = a.bank.entries().iter().zip(b.bank.entries());
        let apart = |(p, q): (&BankEntry, &BankEntry)| {
            p.field.real.iter().zip(&q.field.real).map(|(x, y)| (x - y).abs()).fold(0.0, f32::max)
        };
        pairs.map(apart).fold(0.0, f32::max)
    };
    // Residual seen: 0.
    assert!(difference(&after, &again) < 1e-7);
}

#[test]
fn a_tolerance_makes_it_smaller_and_costs_no_more_than_it_says() {
    let before = bank();
    let (whole, small) = (before.encode(0.0).unwrap(), before.encode(1e-2).unwrap());
    assert!(small.len() + 300 < whole.len(), "{} {}", small.len(), whole.len());
    let after = BankFile::decode(&small).unwrap();
    for (old, new) in before.bank.entries().iter().zip(after.bank.entries()) {
        for (j, node) in old.field.nodes.iter().enumerate() {
            let sum = |pick: &dyn Fn(usize) -> Complex64| -> f64 {
                let mut squares = [0.0; RIGID_DOFS];
                for (row, t) in old.field.terms.iter().enumerate() {
                    let factor = if t.n == 0 { node.s.norm_sqr() } else { 1.0 };
                    squares[usize::from(t.degree)] +=
                        (factor * pick(row * old.field.nodes.len() + j)).norm_sqr();
                }
                squares.iter().fold(0.0f64, |m, s| m.max(*s)).sqrt()
            };
            let value = |f: &AccelerationField, i: usize| {
                Complex64::new(f64::from(f.real[i]), f64::from(f.imaginary[i]))
            };
            let error = sum(&|i| value(&old.field, i) - value(&new.field, i));
            // Residual seen: 0.95e-2 of the loudest.
            assert!(error <= 1.02e-2 * sum(&|i| value(&old.field, i)), "{error}");
        }
    }
}

#[test]
fn every_truncation_and_every_flipped_byte_is_noticed() {
    all_is_noticed(&bank().encode(1e-3).unwrap(), BankFile::decode);
}

#[test]
fn a_bank_is_no_model_and_an_empty_one_is_nothing() {
    let bytes = bank().encode(1e-3).unwrap();
    assert!(matches!(ModelFile::decode(&bytes), Err(TensorFileError::Kind { .. })));
    let empty = BankFile { bank: EllipsoidBank::default(), ..bank() };
    assert!(BankFile::decode(&empty.encode(1e-3).unwrap()).is_err());
}

proptest! {
    #[test]
    fn forged_damage_is_an_error_or_a_playable_bank(
        flips in proptest::collection::vec((any::<prop::sample::Index>(), 0..8u8), 1..4),
    ) {
        let bytes = bank().encode(1e-3).unwrap();
        if let Some(bytes) = forged_damage(bytes, &flips)
            && let Ok(file) = BankFile::decode(&bytes)
        {
            for entry in file.bank.entries() {
                let _ = entry.field.pressure(&[1.0; RIGID_DOFS], DVec3::new(1.0, 2.0, 0.5), 1.3);
            }
        }
    }
}

#[test]
fn fuzz_banks() {
    let mut target =
        Target::parser("banks", "safetensors", vec![bank().encode(1e-3).unwrap()], &TENSOR_WORDS);
    target.mend = &forged;
    fuzz(&target, &|_, bytes| match BankFile::decode(bytes) {
        Err(error) => error.to_string(),
        Ok(file) => {
            for entry in file.bank.entries() {
                let at = DVec3::new(1.0, 2.0, 0.5);
                let pressure = entry.field.pressure(&[1.0; RIGID_DOFS], at, 1.3);
                assert!(pressure.is_finite(), "{pressure}");
            }
            format!("a bank of {}", file.bank.entries().len())
        }
    });
}
