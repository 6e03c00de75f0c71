//! Which cells of a grid are divided into eight smaller ones, and which of those again.
//!
//! Cells that share a face differ by one division at most: a cell that is divided divides larger neighbours
//! first.

use std::collections::BTreeSet;

/// A cell: how often its grid is halved, and its place there.
pub(crate) type LevelPlace = (usize, [usize; 3]);

/// The divided cells of each level, from the largest cells to the smallest.
#[derive(Clone, Debug, Default)]
pub(crate) struct Refinement(Vec<BTreeSet<[usize; 3]>>);

impl Refinement {
    /// Number of grids.
    pub(super) fn levels(&self) -> usize {
        self.0.len() + 1
    }

    fn is_divided(&self, level: usize, place: [usize; 3]) -> bool {
        self.0.get(level).is_some_and(|divided| divided.contains(&place))
    }

    /// Whether a cell of a level is one of the grid: its parent is divided, and it is not.
    pub(super) fn keeps(&self, level: usize, place: [usize; 3]) -> bool {
        let is_there = level == 0 || self.is_divided(level - 1, place.map(|n| n / 2));
        is_there && !self.is_divided(level, place)
    }

    /// Divides a cell.
    pub(crate) fn divide(&mut self, (level, place): LevelPlace) {
        if level > 0 {
            // The neighbours across faces, and the cell itself, are of this level.
            let steps = [[1, 1, 1], [0, 1, 1], [2, 1, 1], [1, 0, 1], [1, 2, 1], [1, 1, 0], [1, 1, 2]];
            for step in steps {
                let beside = [0, 1, 2].map(|a| (place[a] + step[a]).checked_sub(1));
                if let [Some(x), Some(y), Some(z)] = beside
                    && !self.is_divided(level - 1, [x / 2, y / 2, z / 2])
                {
                    self.divide((level - 1, [x / 2, y / 2, z / 2]));
                }
            }
        }
        if self.0.len() <= level {
            self.0.resize(level + 1, BTreeSet::new());
        }
        self.0[level].insert(place);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_differ_by_one_division() {
        let mut refinement = Refinement::default();
        refinement.divide((0, [2, 2, 2]));
        refinement.divide((1, [4, 4, 4]));
        refinement.divide((2, [8, 8, 8]));
        assert_eq!(refinement.levels(), 4);
        assert!(refinement.keeps(3, [17, 17, 16]) && !refinement.keeps(2, [8, 8, 8]));
        for level in 1..4 {
            for k in 0..40_usize.pow(3) {
                let place = [k / 1600, k / 40 % 40, k % 40];
                if !refinement.keeps(level, place) {
                    continue;
                }
                for axis in 0..3 {
                    for step in [usize::MAX, 1] {
                        let mut beside = place;
                        beside[axis] = beside[axis].wrapping_add(step);
                        let up = |place: [usize; 3]| place.map(|n| n / 2);
                        let found = refinement.keeps(level, beside)
                            || refinement.keeps(level - 1, up(beside))
                            || refinement.is_divided(level, beside);
                        assert!(found, "{level} {place:?} {beside:?}");
                    }
                }
            }
        }
    }
}
