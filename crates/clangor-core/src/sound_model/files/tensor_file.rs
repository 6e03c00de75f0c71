//! Named arrays with a description, as bytes: the container of sound models and soundbanks.
//!
//! The container is safetensors: a JSON header with type, shape and place of each array, then the arrays,
//! little endian. The header holds the description as one JSON text under the key `clangor`. The array
//! `content_hash` holds the XXH3-128 of all bytes of the file, with its own 16 taken as zero. The hash
//! detects truncated, damaged and edited files. It does not protect against forgery, so readers validate
//! every number too.
//!
//! This module does no input or output: it converts from and to bytes.

use std::borrow::Cow;

use safetensors::tensor::Metadata;
use safetensors::{Dtype, SafeTensors, View};
use serde::Serialize;
use serde::de::DeserializeOwned;
use twox_hash::xxhash3_128::Hasher;

/// Error in the bytes of a sound model or soundbank.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TensorFileError {
    /// Not safetensors, or truncated.
    #[error("it is not a whole safetensors file: {reason}")]
    Container {
        /// Message of the reader of the container.
        reason: String,
    },
    /// A file of another program.
    #[error("it was not written by Clangor: {what} is missing")]
    Foreign {
        /// Content that all files of this program have.
        what: &'static str,
    },
    /// Damaged or edited.
    #[error("its content was changed since it was written: its hash is {found}, not {expected}")]
    Changed {
        /// Hash of the content.
        found: String,
        /// Hash that the file names.
        expected: String,
    },
    /// Another kind of file, such as a soundbank in place of a model.
    #[error("it is a {found}, not a {expected}")]
    Kind {
        /// Kind of the file.
        found: String,
        /// Kind expected.
        expected: &'static str,
    },
    /// Written by a newer program, or by one that is too old.
    #[error("it has format version {found}, and this program reads version {known}; bake it again")]
    Version {
        /// Version of the file.
        found: u32,
        /// Version of the program.
        known: u32,
    },
    /// An invalid description.
    #[error("its description is wrong: {reason}")]
    Description {
        /// Reason.
        reason: String,
    },
    /// A missing array.
    #[error("the array \"{name}\" is missing")]
    Missing {
        /// The array.
        name: String,
    },
    /// An array of another type or shape.
    #[error("the array \"{name}\" is {found}, and must be {expected}")]
    Shape {
        /// The array.
        name: String,
        /// Its type and shape.
        found: String,
        /// Expected type and shape.
        expected: String,
    },
    /// An invalid number.
    #[error("{what} {reason}")]
    Value {
        /// Quantity.
        what: String,
        /// Reason.
        reason: String,
    },
}

impl TensorFileError {
    /// An invalid number.
    pub(crate) fn value(what: impl Into<String>, reason: impl Into<String>) -> Self {
        TensorFileError::Value { what: what.into(), reason: reason.into() }
    }
}

/// Key of the description in the header.
const DESCRIPTION: &str = "clangor";
/// Name of the array that holds the hash.
const HASH: &str = "content_hash";
/// Bytes of the hash.
const HASH_LENGTH: usize = 16;

/// An array to be written.
struct Array {
    dtype: Dtype,
    shape: Vec<usize>,
    bytes: Vec<u8>,
}

impl View for &Array {
    fn dtype(&self) -> Dtype {
        self.dtype
    }

    fn shape(&self) -> &[usize] {
        &self.shape
    }

    fn data(&self) -> Cow<'_, [u8]> {
        Cow::Borrowed(&self.bytes)
    }

    fn data_len(&self) -> usize {
        self.bytes.len()
    }
}

/// An element type of arrays.
pub(crate) trait Element: Copy {
    /// Its type in the file.
    const DTYPE: Dtype;
    /// Its length in bytes.
    const LENGTH: usize;

    /// Appends its bytes.
    fn put(self, bytes: &mut Vec<u8>);
    /// Reads it from [`LENGTH`](Self::LENGTH) bytes.
    fn take(bytes: &[u8]) -> Self;
}

macro_rules! element {
    ($number:ty, $dtype:ident) => {
        impl Element for $number {
            const DTYPE: Dtype = Dtype::$dtype;
            const LENGTH: usize = size_of::<$number>();

            fn put(self, bytes: &mut Vec<u8>) {
                bytes.extend(self.to_le_bytes());
            }

            fn take(bytes: &[u8]) -> Self {
                let mut own = [0; size_of::<$number>()];
                own.copy_from_slice(bytes);
                Self::from_le_bytes(own)
            }
        }
    };
}

element!(f64, F64);
element!(f32, F32);
element!(u32, U32);
element!(i16, I16);
element!(u16, U16);

/// Builder of a file.
#[derive(Default)]
pub(crate) struct TensorWriter {
    arrays: Vec<(String, Array)>,
}

impl TensorWriter {
    /// Adds an array; the product of `shape` is the number of `numbers`.
    pub(crate) fn add<T: Element>(
        &mut self,
        name: &str,
        shape: &[usize],
        numbers: impl IntoIterator<Item = T>,
    ) {
        let mut bytes = Vec::with_capacity(shape.iter().product::<usize>() * T::LENGTH);
        numbers.into_iter().for_each(|n| n.put(&mut bytes));
        self.arrays.push((name.into(), Array { dtype: T::DTYPE, shape: shape.into(), bytes }));
    }

    /// The bytes of the file.
    ///
    /// # Errors
    /// [`TensorFileError`] for arrays whose shape does not fit their numbers, and for numbers in the
    /// description that are not finite.
    pub(crate) fn finish(mut self, description: &impl Serialize) -> Result<Vec<u8>, TensorFileError> {
        let text = serde_json::to_string(description)
            .map_err(|e| TensorFileError::Description { reason: e.to_string() })?;
        self.arrays.push((
            HASH.into(),
            Array { dtype: Dtype::U8, shape: vec![HASH_LENGTH], bytes: vec![0; HASH_LENGTH] },
        ));
        // One entry only: the order of several would vary from run to run.
        let header = [(DESCRIPTION.to_string(), text)].into_iter().collect();
        let arrays = self.arrays.iter().map(|(name, array)| (name.as_str(), array));
        let mut bytes = safetensors::serialize(arrays, Some(header)).map_err(container)?;
        let (header_length, metadata) = SafeTensors::read_metadata(&bytes).map_err(container)?;
        let place = hash_place(header_length, &metadata)?;
        let hash = hash_around(&bytes, place);
        bytes[place..place + HASH_LENGTH].copy_from_slice(&hash.to_be_bytes());
        Ok(bytes)
    }
}

/// Arrays of a file with a valid hash.
pub(crate) struct TensorReader<'a> {
    tensors: SafeTensors<'a>,
    description: String,
}

/// The part of a description with the kind of the file.
#[derive(serde::Deserialize)]
struct Kind {
    kind: String,
    version: u32,
}

impl<'a> TensorReader<'a> {
    /// Checks that the bytes are a whole file of this kind and version.
    pub(crate) fn open(bytes: &'a [u8], kind: &'static str, version: u32) -> Result<Self, TensorFileError> {
        let (header_length, metadata) = SafeTensors::read_metadata(bytes).map_err(container)?;
        let description = metadata
            .metadata()
            .as_ref()
            .and_then(|entries| entries.get(DESCRIPTION))
            .ok_or(TensorFileError::Foreign { what: "the description" })?
            .clone();
        let place = hash_place(header_length, &metadata)?;
        let expected = bytes
            .get(place..place + HASH_LENGTH)
            .and_then(|hash| hash.try_into().ok())
            .map(u128::from_be_bytes)
            .ok_or(TensorFileError::Foreign { what: "the content's hash" })?;
        let found = hash_around(bytes, place);
        if found != expected {
            let digits = |hash: u128| format!("{hash:032x}");
            return Err(TensorFileError::Changed { found: digits(found), expected: digits(expected) });
        }
        let tensors = SafeTensors::deserialize(bytes).map_err(container)?;
        let reader = TensorReader { tensors, description };
        let is: Kind = reader.describe()?;
        if is.kind != kind {
            return Err(TensorFileError::Kind { found: is.kind, expected: kind });
        }
        if is.version != version {
            return Err(TensorFileError::Version { found: is.version, known: version });
        }
        Ok(reader)
    }

    /// The description.
    pub(crate) fn describe<D: DeserializeOwned>(&self) -> Result<D, TensorFileError> {
        serde_json::from_str(&self.description)
            .map_err(|e| TensorFileError::Description { reason: e.to_string() })
    }

    /// Whether an array is present.
    pub(crate) fn has(&self, name: &str) -> bool {
        self.tensors.tensor(name).is_ok()
    }

    /// An array of two or more axes, the first of any length; returns that length too.
    pub(crate) fn rows<T: Element>(
        &self,
        name: &str,
        row: &[usize],
    ) -> Result<(usize, Vec<T>), TensorFileError> {
        let tensor = self.tensors.tensor(name).map_err(|_| TensorFileError::Missing { name: name.into() })?;
        let found = tensor.shape();
        if tensor.dtype() != T::DTYPE || found.len() != row.len() + 1 || found[1..] != *row {
            let rest: String = row.iter().map(|n| format!(", {n}")).collect();
            return Err(TensorFileError::Shape {
                name: name.into(),
                found: format!("{:?} {found:?}", tensor.dtype()),
                expected: format!("{:?} [any{rest}]", T::DTYPE),
            });
        }
        Ok((found[0], tensor.data().chunks_exact(T::LENGTH).map(T::take).collect()))
    }

    /// An array of exactly this shape.
    pub(crate) fn array<T: Element>(&self, name: &str, shape: &[usize]) -> Result<Vec<T>, TensorFileError> {
        let (first, rest) = shape.split_first().unwrap_or((&0, &[]));
        let (count, numbers) = self.rows(name, rest)?;
        if count != *first {
            return Err(TensorFileError::Shape {
                name: name.into(),
                found: format!("of {count} rows"),
                expected: format!("of {first}"),
            });
        }
        Ok(numbers)
    }
}

/// Rejects an array with NaN or infinite numbers.
pub(crate) fn check_finite<T: Copy + Into<f64>>(name: &str, numbers: &[T]) -> Result<(), TensorFileError> {
    match numbers.iter().position(|n| !(*n).into().is_finite()) {
        Some(at) => {
            Err(TensorFileError::value(format!("number {at} of the array \"{name}\""), "is not finite"))
        }
        None => Ok(()),
    }
}

fn container(error: safetensors::SafeTensorError) -> TensorFileError {
    TensorFileError::Container { reason: error.to_string() }
}

/// Place of the hash in the file.
fn hash_place(header_length: usize, metadata: &Metadata) -> Result<usize, TensorFileError> {
    let info = metadata.info(HASH).ok_or(TensorFileError::Foreign { what: "the content's hash" })?;
    if info.dtype != Dtype::U8 || info.shape != [HASH_LENGTH] {
        return Err(TensorFileError::Foreign { what: "the content's hash" });
    }
    // Eight bytes give the length of the header.
    Ok(8 + header_length + info.data_offsets.0)
}

/// The hash of all bytes, the 16 at `place` taken as zero.
fn hash_around(bytes: &[u8], place: usize) -> u128 {
    let mut hasher = Hasher::new();
    hasher.write(&bytes[..place]);
    hasher.write(&[0; HASH_LENGTH]);
    hasher.write(&bytes[place + HASH_LENGTH..]);
    hasher.finish_128()
}
