//! Which of some things belong together, from pairs that do (union–find with path halving).
//!
//! Source: Tarjan, van Leeuwen (1984), "Worst-case analysis of set union algorithms", JACM 31.

/// Sets of the numbers from 0 that share none. Each is named by its least member.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DisjointSets(Vec<u32>);

impl DisjointSets {
    /// Each of `count` numbers, up to 2³², in a set of its own.
    pub fn new(count: usize) -> Self {
        DisjointSets((0..count).map(|k| k as u32).collect())
    }

    /// How many numbers there are.
    pub fn count(&self) -> usize {
        self.0.len()
    }

    /// The least member of the set of a number.
    pub fn root(&mut self, mut of: usize) -> usize {
        while self.0[of] as usize != of {
            let above = self.0[self.0[of] as usize];
            self.0[of] = above;
            of = above as usize;
        }
        of
    }

    /// Makes one set of those of two numbers.
    pub fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b)] = a.min(b) as u32;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joined_numbers_have_the_least_one_as_root() {
        let mut sets = DisjointSets::new(6);
        for [a, b] in [[4, 5], [1, 2], [5, 2], [4, 1]] {
            sets.join(a, b);
        }
        let roots: Vec<usize> = (0..sets.count()).map(|k| sets.root(k)).collect();
        assert_eq!(roots, [0, 1, 1, 3, 1, 1]);
    }
}
