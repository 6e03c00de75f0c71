//! The frequencies that a bake has solved, as bytes: so that one that is killed goes on where it was.
//!
//! Only the same version of the program reads them: numbers one after the other, little endian, and at
//! the end the XXH3-128 of all of them. What is not whole, or belongs to another bake, counts as nothing.

use clangor_bake::acceleration::SolvedFrequency;
use clangor_bake::radiation::RadiationSample;
use clangor_core::sound_model::acceleration::field::RIGID_DOFS;
use num_complex::Complex64;
use twox_hash::xxhash3_128::Hasher;

const HEAD: &[u8] = b"clangor partial bake 1\n";
const HASH_LENGTH: usize = 16;

/// The bytes of what is solved of the model with this key.
pub(super) fn encode(key: &str, solved: &[SolvedFrequency]) -> Vec<u8> {
    let mut bytes = HEAD.to_vec();
    bytes.extend(key.as_bytes());
    let whole = |bytes: &mut Vec<u8>, number: usize| bytes.extend((number as u64).to_le_bytes());
    let complex = |bytes: &mut Vec<u8>, number: Complex64| {
        bytes.extend(number.re.to_le_bytes());
        bytes.extend(number.im.to_le_bytes());
    };
    whole(&mut bytes, solved.len());
    for SolvedFrequency { asked, sample } in solved {
        bytes.extend(asked.to_le_bytes());
        complex(&mut bytes, sample.wavenumber);
        whole(&mut bytes, sample.coefficients[0].len());
        sample.coefficients.iter().flatten().for_each(|c| complex(&mut bytes, *c));
        whole(&mut bytes, sample.surface_pressure.len());
        sample.surface_pressure.iter().flatten().for_each(|p| complex(&mut bytes, *p));
    }
    let hash = Hasher::oneshot(&bytes);
    bytes.extend(hash.to_le_bytes());
    bytes
}

/// What is solved of the model with this key; `None` for bytes that do not say.
pub(super) fn decode(key: &str, bytes: &[u8]) -> Option<Vec<SolvedFrequency>> {
    let (content, hash) = bytes.split_at_checked(bytes.len().checked_sub(HASH_LENGTH)?)?;
    if Hasher::oneshot(content).to_le_bytes() != *hash {
        return None;
    }
    let mut rest = Numbers(content.strip_prefix(HEAD)?.strip_prefix(key.as_bytes())?);
    let mut solved = Vec::new();
    for _ in 0..rest.whole()? {
        let asked = rest.real()?;
        let wavenumber = rest.complex()?;
        let count = rest.whole()?;
        let mut coefficients: [Vec<Complex64>; RIGID_DOFS] = Default::default();
        for row in &mut coefficients {
            *row = (0..count).map(|_| rest.complex()).collect::<Option<_>>()?;
        }
        let mut surface_pressure = Vec::new();
        for _ in 0..rest.whole()? {
            let mut pressures = [Complex64::ZERO; RIGID_DOFS];
            for pressure in &mut pressures {
                *pressure = rest.complex()?;
            }
            surface_pressure.push(pressures);
        }
        let sample = RadiationSample { wavenumber, coefficients, surface_pressure };
        solved.push(SolvedFrequency { asked, sample });
    }
    rest.0.is_empty().then_some(solved)
}

/// What has not been read.
pub(super) struct Numbers<'a>(pub(super) &'a [u8]);

impl Numbers<'_> {
    fn eight(&mut self) -> Option<[u8; 8]> {
        let (number, rest) = self.0.split_first_chunk::<8>()?;
        self.0 = rest;
        Some(*number)
    }

    pub(super) fn whole(&mut self) -> Option<u64> {
        self.eight().map(u64::from_le_bytes)
    }

    pub(super) fn real(&mut self) -> Option<f64> {
        self.eight().map(f64::from_le_bytes)
    }

    fn complex(&mut self) -> Option<Complex64> {
        Some(Complex64::new(self.real()?, self.real()?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_solved_comes_back_whole_or_not_at_all() {
        let number = |i: usize| Complex64::cis(i as f64) / 3.0;
        let frequency = |k: usize| SolvedFrequency {
            asked: 0.1 * k as f64,
            sample: RadiationSample {
                wavenumber: number(k),
                coefficients: std::array::from_fn(|d| (0..4).map(|i| number(7 * k + d + i)).collect()),
                surface_pressure: (0..k).map(|v| std::array::from_fn(|d| number(v + d))).collect(),
            },
        };
        let solved: Vec<SolvedFrequency> = (0..3).map(frequency).collect();
        let key = "00112233445566778899aabbccddeeff";
        let bytes = encode(key, &solved);
        assert_eq!(decode(key, &bytes).as_deref(), Some(&solved[..]));
        assert_eq!(decode("10112233445566778899aabbccddeeff", &bytes), None);
        for length in 0..bytes.len() {
            assert_eq!(decode(key, &bytes[..length]), None, "{length}");
        }
        for at in 0..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[at] ^= 1 << (at % 8);
            assert_eq!(decode(key, &damaged), None, "{at}");
        }
    }
}
