//! A part of a data set: the strikes of one file.
//!
//! Part k of n has the strikes from ⌊(k − 1) N/n⌋ to ⌊k N/n⌋, so that parts follow each other and differ in
//! size by one at most.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use super::error::DatasetError;

/// Strikes of a file where no number of files is asked for: 200 MB of sounds of one second.
const USUAL_ROWS: u64 = 1000;
/// Most files of a data set; their names have five digits.
const MOST_SHARDS: u32 = 99_999;
/// How the names of files begin.
const PREFIX: &str = "strikes-";

/// Part `number`, from 1, of `of` parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    number: u32,
    of: u32,
}

impl Shard {
    /// Part `number` of `of`, from 1.
    ///
    /// # Errors
    /// [`DatasetError::Shard`].
    pub fn new(number: u32, of: u32) -> Result<Self, DatasetError> {
        match (1..=of).contains(&number) && of <= MOST_SHARDS {
            true => Ok(Shard { number, of }),
            false => Err(DatasetError::Shard { text: format!("{number}/{of}"), most: MOST_SHARDS }),
        }
    }

    /// All parts of a data set of so many.
    ///
    /// # Errors
    /// [`DatasetError::Shard`].
    pub fn all(of: u32) -> Result<Vec<Self>, DatasetError> {
        (1..=of.max(1)).map(|number| Shard::new(number, of)).collect()
    }

    /// Number of files of `count` strikes where none is asked for.
    pub fn usual_number(count: u64) -> u32 {
        count.div_ceil(USUAL_ROWS).clamp(1, u64::from(MOST_SHARDS)) as u32
    }

    /// Its number, from 1.
    pub fn number(self) -> u32 {
        self.number
    }

    /// Number of parts.
    pub fn of(self) -> u32 {
        self.of
    }

    /// Its share of `count` things.
    pub fn range(self, count: u64) -> Range<u64> {
        let from = |number: u32| (u128::from(count) * u128::from(number) / u128::from(self.of)) as u64;
        from(self.number - 1)..from(self.number)
    }

    /// Name of its file without ending.
    pub(super) fn stem(self) -> String {
        format!("{PREFIX}{:05}-of-{:05}", self.number, self.of)
    }

    /// Its file in a folder.
    pub fn file(self, folder: &Path) -> PathBuf {
        folder.join(format!("{}.parquet", self.stem()))
    }

    /// The part that a file name stands for.
    pub(super) fn of_file_name(name: &str) -> Option<Self> {
        let (number, of) = name.strip_prefix(PREFIX)?.strip_suffix(".parquet")?.split_once("-of-")?;
        Shard::new(number.parse().ok()?, of.parse().ok()?).ok()
    }
}

impl FromStr for Shard {
    type Err = DatasetError;

    /// `3/16`.
    fn from_str(text: &str) -> Result<Self, DatasetError> {
        let wrong = || DatasetError::Shard { text: text.into(), most: MOST_SHARDS };
        let (number, of) = text.split_once('/').ok_or_else(wrong)?;
        let (number, of) = number.parse().ok().zip(of.parse().ok()).ok_or_else(wrong)?;
        Shard::new(number, of)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn property_parts_cover_everything_once() {
        for (count, of) in [(10_000, 16), (3, 16), (17, 16), (1, 1), (u64::MAX, 99_999)] {
            let parts = Shard::all(of).unwrap();
            let mut next = 0;
            for part in &parts {
                let range = part.range(count);
                assert_eq!(range.start, next);
                assert!(range.end - range.start <= count / u64::from(of) + 1);
                next = range.end;
            }
            assert_eq!(next, count);
        }
    }

    #[test]
    fn property_impossible_parts_are_refused() {
        for text in ["17/16", "0/16", "1/0", "3", "a/b", "-1/4", "1/100000", "1/2/3"] {
            let error = text.parse::<Shard>().unwrap_err().to_string();
            assert!(error.contains(text), "{error}");
        }
        let third: Shard = "3/16".parse().unwrap();
        assert_eq!(Shard::of_file_name("strikes-00003-of-00016.parquet"), Some(third));
        assert_eq!(Shard::of_file_name("strikes-00017-of-00016.parquet"), None);
    }
}
