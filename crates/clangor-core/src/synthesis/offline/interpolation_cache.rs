//! Cache of the interpolations of fields, reused from click to click.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::synthesis::field_interpolation::Interpolation;
use crate::synthesis::field_source::FieldSource;
use crate::synthesis::spectrum::Grid;

/// Largest memory of the cache; beyond it, interpolations are computed for each click.
const MAX_INTERPOLATION_BYTES: usize = 256 << 20;

/// Address of a field, bits of R/c, and length of the block.
type InterpolationKey = (usize, u64, usize);

/// An interpolation for later clicks of the body.
struct KeptInterpolation {
    table: Arc<Interpolation>,
    /// Holds the field, so that its address stays unique.
    _source: Arc<FieldSource>,
}

/// See the module.
#[derive(Default)]
pub(super) struct InterpolationCache {
    kept: BTreeMap<InterpolationKey, KeptInterpolation>,
    bytes: usize,
}

impl InterpolationCache {
    /// The interpolation of a field with this R/c \[s\] on the grid of blocks of this length; `None` once the
    /// cache is full.
    pub(super) fn get(
        &mut self,
        source: &Arc<FieldSource>,
        crossing: f64,
        (length, grid): (usize, &Grid),
    ) -> Option<Arc<Interpolation>> {
        let key = (Arc::as_ptr(&source.field) as usize, crossing.to_bits(), length);
        if let Some(kept) = self.kept.get(&key) {
            return Some(Arc::clone(&kept.table));
        }
        if self.bytes > MAX_INTERPOLATION_BYTES {
            return None;
        }
        let table = Arc::new(Interpolation::of(source, crossing, grid));
        self.bytes += table.size();
        let kept = KeptInterpolation { table: Arc::clone(&table), _source: Arc::clone(source) };
        self.kept.insert(key, kept);
        Some(table)
    }
}
