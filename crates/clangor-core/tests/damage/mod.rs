//! Damage to files of tensors: cuts and flips that must be detected, and edits with a valid hash.

use safetensors::SafeTensors;
use twox_hash::xxhash3_128::Hasher;

/// Gives an edited file the hash of its new content.
pub(crate) fn forge(mut bytes: Vec<u8>) -> Vec<u8> {
    let (header, metadata) = SafeTensors::read_metadata(&bytes).unwrap();
    let place = 8 + header + metadata.info("content_hash").unwrap().data_offsets.0;
    bytes[place..place + 16].fill(0);
    let hash = Hasher::oneshot(&bytes);
    bytes[place..place + 16].copy_from_slice(&hash.to_be_bytes());
    bytes
}

/// Replaces text in the header without moving anything.
pub(crate) fn edit(bytes: &[u8], from: &str, to: &str) -> Vec<u8> {
    assert_eq!(from.len(), to.len());
    let at = bytes.windows(from.len()).position(|w| w == from.as_bytes()).expect("the text is there");
    let mut edited = bytes.to_vec();
    edited[at..at + to.len()].copy_from_slice(to.as_bytes());
    forge(edited)
}

/// The file with these bits flipped and a valid hash; `None` if no reader would find a hash in it.
pub(crate) fn forged_damage(mut bytes: Vec<u8>, flips: &[(proptest::sample::Index, u8)]) -> Option<Vec<u8>> {
    for (at, bit) in flips {
        let at = at.index(bytes.len());
        bytes[at] ^= 1 << bit;
    }
    let whole = |t: SafeTensors<'_>| t.tensor("content_hash").is_ok_and(|h| h.data().len() == 16);
    SafeTensors::deserialize(&bytes).is_ok_and(whole).then(|| forge(bytes))
}

/// Cuts the file at every length and flips a bit in every byte: a reader must detect each.
pub(crate) fn all_is_noticed<T, E>(bytes: &[u8], read: impl Fn(&[u8]) -> Result<T, E>) {
    for length in 0..bytes.len() {
        assert!(read(&bytes[..length]).is_err(), "{length}");
    }
    let mut longer = bytes.to_vec();
    longer.push(0);
    assert!(read(&longer).is_err());
    let mut damaged = bytes.to_vec();
    for at in 0..bytes.len() {
        damaged[at] ^= 1 << (at % 8);
        assert!(read(&damaged).is_err(), "{at}");
        damaged[at] = bytes[at];
    }
}

/// Words of the header of a file of tensors.
pub(crate) const TENSOR_WORDS: [&str; 12] = [
    "\"shape\":[",
    "\"dtype\":\"F64\"",
    "\"F32\"",
    "\"U32\"",
    "\"data_offsets\":[0,8]",
    "\\\"version\\\":",
    "\\\"radius_m\\\":",
    "null",
    "[]",
    "{}",
    "1e308",
    "-1",
];

/// The file with the length of its header and its hash corrected; `None` if no reader would find a hash.
pub(crate) fn forged(mut bytes: Vec<u8>) -> Option<Vec<u8>> {
    // The header is JSON in spaces; data begin after the last brace that ends its level.
    let mut depth = 0_i64;
    let end = bytes.iter().skip(8).position(|byte| {
        depth += match byte {
            b'{' => 1,
            b'}' => -1,
            _ => 0,
        };
        depth == 0
    })?;
    let mut length = (end + 1) as u64;
    while bytes.get(8 + length as usize) == Some(&b' ') {
        length += 1;
    }
    bytes.get_mut(..8)?.copy_from_slice(&length.to_le_bytes());
    forged_damage(bytes, &[])
}
