//! The convex parts of a mesh as bytes, so that no mesh is decomposed twice.
//!
//! Numbers one after the other, little endian, and at the end the XXH3-128 of all of them. What is not whole,
//! belongs to another mesh or was written by another version counts as nothing.

use clangor_core::geometry::convex::ConvexPart;
use clangor_core::glam::DVec3;
use clangor_sim::decompose::Decomposition;
use twox_hash::xxhash3_128::Hasher;

use super::partial_bake::Numbers;

const HEAD: &[u8] = b"clangor collision parts 1\n";
const HASH_LENGTH: usize = 16;

/// The bytes of the parts of the mesh with this key. Parts of a mesh are hulls; others have no bytes.
pub(super) fn encode(key: &str, found: &Decomposition) -> Vec<u8> {
    let mut bytes = HEAD.to_vec();
    bytes.extend(key.as_bytes());
    let hulls: Vec<&[DVec3]> = found
        .parts
        .iter()
        .filter_map(|part| match part {
            ConvexPart::Hull(points) => Some(&points[..]),
            ConvexPart::Ball { .. } | ConvexPart::Cylinder { .. } => None,
        })
        .collect();
    [found.surface_error, found.volume_error].iter().for_each(|x| bytes.extend(x.to_le_bytes()));
    bytes.extend((hulls.len() as u64).to_le_bytes());
    for points in hulls {
        bytes.extend((points.len() as u64).to_le_bytes());
        points.iter().flat_map(|p| p.to_array()).for_each(|x| bytes.extend(x.to_le_bytes()));
    }
    let hash = Hasher::oneshot(&bytes);
    bytes.extend(hash.to_le_bytes());
    bytes
}

/// The parts of the mesh with this key; `None` for bytes that do not say.
pub(super) fn decode(key: &str, bytes: &[u8]) -> Option<Decomposition> {
    let (content, hash) = bytes.split_at_checked(bytes.len().checked_sub(HASH_LENGTH)?)?;
    if Hasher::oneshot(content).to_le_bytes() != *hash {
        return None;
    }
    let mut rest = Numbers(content.strip_prefix(HEAD)?.strip_prefix(key.as_bytes())?);
    let (surface_error, volume_error) = (rest.real()?, rest.real()?);
    let mut parts = Vec::new();
    for _ in 0..rest.whole()? {
        let points = (0..rest.whole()?)
            .map(|_| Some(DVec3::new(rest.real()?, rest.real()?, rest.real()?)))
            .collect::<Option<_>>()?;
        parts.push(ConvexPart::Hull(points));
    }
    rest.0.is_empty().then_some(Decomposition { parts, surface_error, volume_error })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn property_parts_come_back_whole_or_not_at_all() {
        let point = |i: usize| DVec3::new(i as f64 / 3.0, -0.0, (i as f64).sqrt());
        let hull = |count: usize| ConvexPart::Hull((0..count).map(point).collect());
        let found = Decomposition { parts: vec![hull(4), hull(7)], surface_error: 0.1, volume_error: -0.2 };
        let key = "00112233445566778899aabbccddeeff";
        let bytes = encode(key, &found);
        assert_eq!(decode(key, &bytes).as_ref(), Some(&found));
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
