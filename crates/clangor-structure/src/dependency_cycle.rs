//! Describes a dependency cycle between files, and which of its edges to cut at the least cost.
//!
//! An order of the files makes every edge against the order a cut. A table over all subsets of files gives
//! the best order exactly (the recursion of Held and Karp): the best order of a subset ends with the file
//! that costs least. The cost is the number of used items.

use std::collections::BTreeMap;
use std::fmt;

/// The uses of one file by another: each item with the first line that names it.
pub type Uses = BTreeMap<String, usize>;

/// Files that all depend on each other.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Cycle {
    /// Paths of the files.
    pub files: Vec<String>,
    /// Edges between them.
    pub edges: Vec<CycleEdge>,
}

/// An edge inside a [`Cycle`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CycleEdge {
    /// The file that uses, as an index into [`Cycle::files`].
    pub from: usize,
    /// The file that defines, as an index into [`Cycle::files`].
    pub to: usize,
    /// What is used, and on which line.
    pub uses: Uses,
}

impl fmt::Display for Cycle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{} files depend on each other:", self.files.len())?;
        self.files.iter().try_for_each(|path| writeln!(f, "    {path}"))?;
        let cut = cheapest_cut(self);
        for (index, edge) in self.edges.iter().enumerate() {
            let note = if cut.contains(&index) { "  <- to cut" } else { "" };
            writeln!(f, "  {} -> {}{note}", self.files[edge.from], self.files[edge.to])?;
            for (item, line) in &edge.uses {
                writeln!(f, "      {}:{line}: {item}", self.files[edge.from])?;
            }
        }
        Ok(())
    }
}

/// Above this number of files the table would be too large, and no cut is suggested.
const MOST_FILES: usize = 16;

/// Returns indices into `cycle.edges`; empty if the cycle has too many files.
pub fn cheapest_cut(cycle: &Cycle) -> Vec<usize> {
    let count = cycle.files.len();
    if count > MOST_FILES {
        return Vec::new();
    }
    // Dependencies come first: an edge is cut if the file that uses comes before the file that defines.
    let cost_last = |set: usize, last: usize| -> usize {
        let against = cycle.edges.iter().filter(|edge| edge.to == last && set & (1 << edge.from) != 0);
        against.map(|edge| edge.uses.len()).sum()
    };
    let mut best = vec![(0, 0); 1 << count];
    for set in 1..best.len() {
        let members = (0..count).filter(|file| set & (1 << file) != 0);
        let costs = members.map(|last| {
            let before = set & !(1 << last);
            (best[before].0 + cost_last(before, last), last)
        });
        best[set] = costs.min().expect("the set has members");
    }
    let mut place = vec![0; count];
    let mut set = best.len() - 1;
    for position in (0..count).rev() {
        let last = best[set].1;
        place[last] = position;
        set &= !(1 << last);
    }
    let is_cut = |index: &usize| place[cycle.edges[*index].from] < place[cycle.edges[*index].to];
    (0..cycle.edges.len()).filter(is_cut).collect()
}
