//! Smallest set of nodes that touches all edges across a cut of a graph.
//!
//! The edges across are a bipartite graph. By König's theorem (1931) its minimum vertex cover is as large as
//! a maximum matching: the left nodes that no alternating path from a free left node reaches, and the right
//! nodes that one does.
//!
//! Source of the matching: Pothen and Fan (1990), "Computing the block triangular form of a sparse matrix",
//! ACM Trans. Math. Softw. 16(4). Depth-first searches from all free left nodes share what they have seen, in
//! phases until one finds no path. Before a search goes deeper at a node, it looks for a free neighbour.

/// No node.
const NONE: u32 = u32::MAX;

/// Scratch for the covers of parts of one graph.
pub(super) struct VertexCovers {
    /// The other end of the matched edge of a node; all [`NONE`] between two covers.
    matched: Vec<u32>,
    /// Phase in which a right node was seen last.
    seen: Vec<u32>,
    phase: u32,
    /// First neighbour of a left node that may be free.
    ahead: Vec<u32>,
}

/// The edges from left nodes to right ones.
pub(super) struct Across<'a, N> {
    /// Neighbours of a node, on any side.
    pub(super) neighbours: N,
    /// Side of each node, of which `right` is that of the right nodes.
    pub(super) side: &'a [u32],
    pub(super) right: u32,
}

impl<'g, N: Fn(u32) -> &'g [u32]> Across<'_, N> {
    fn leads_to(&self, node: u32) -> bool {
        self.side[node as usize] == self.right
    }
}

impl VertexCovers {
    /// Scratch for a graph of `count` nodes.
    pub(super) fn new(count: usize) -> Self {
        VertexCovers { matched: vec![NONE; count], seen: vec![0; count], phase: 0, ahead: vec![0; count] }
    }

    /// The smallest set of nodes that touches every edge from `left` across.
    pub(super) fn cover<'g, N: Fn(u32) -> &'g [u32]>(
        &mut self,
        left: &[u32],
        edges: &Across<'_, N>,
    ) -> Vec<u32> {
        let borders = |n: &u32| (edges.neighbours)(*n).iter().any(|m| edges.leads_to(*m));
        let border: Vec<u32> = left.iter().copied().filter(borders).collect();
        border.iter().for_each(|n| self.ahead[*n as usize] = 0);
        let mut visited: Vec<u32> = Vec::new();
        loop {
            self.phase += 1;
            visited.clear();
            let mut found = false;
            for n in &border {
                if self.matched[*n as usize] == NONE {
                    found |= self.augment(*n, edges, &mut visited);
                }
            }
            if !found {
                break;
            }
        }
        // The last phase has met all right nodes that free left nodes reach, and the left nodes matched to
        // them.
        let is_reached = |n: &u32| {
            let other = self.matched[*n as usize];
            other == NONE || self.seen[other as usize] == self.phase
        };
        let mut cover: Vec<u32> = border.iter().copied().filter(|n| !is_reached(n)).collect();
        cover.extend(&visited);
        for n in &border {
            let other = std::mem::replace(&mut self.matched[*n as usize], NONE);
            if other != NONE {
                self.matched[other as usize] = NONE;
            }
        }
        cover
    }

    /// Searches for a path from a free left node to a free right one over nodes not seen in this phase, and
    /// flips it. Right nodes that are met are added to `visited`.
    fn augment<'g, N: Fn(u32) -> &'g [u32]>(
        &mut self,
        start: u32,
        edges: &Across<'_, N>,
        visited: &mut Vec<u32>,
    ) -> bool {
        // Each level: a left node, its first neighbour that is untried, and the right node taken.
        let mut path: Vec<(u32, usize, u32)> = vec![(start, 0, NONE)];
        while let Some((node, next, taken)) = path.last_mut() {
            let neighbours = (edges.neighbours)(*node);
            if let Some(free) = self.free_neighbour(*node, neighbours, edges) {
                *taken = free;
                for (n, _, m) in path {
                    (self.matched[n as usize], self.matched[m as usize]) = (m, n);
                }
                return true;
            }
            let unseen = |m: &u32| edges.leads_to(*m) && self.seen[*m as usize] != self.phase;
            let Some(at) = neighbours[*next..].iter().position(unseen) else {
                path.pop();
                continue;
            };
            let other = neighbours[*next + at];
            (*next, *taken) = (*next + at + 1, other);
            self.seen[other as usize] = self.phase;
            visited.push(other);
            path.push((self.matched[other as usize], 0, NONE));
        }
        false
    }

    /// A free right node beside a left node. One that is matched stays so, and is not tried again.
    fn free_neighbour<'g, N: Fn(u32) -> &'g [u32]>(
        &mut self,
        node: u32,
        neighbours: &[u32],
        edges: &Across<'_, N>,
    ) -> Option<u32> {
        let ahead = &mut self.ahead[node as usize];
        let is_free = |m: &u32| edges.leads_to(*m) && self.matched[*m as usize] == NONE;
        let untried = &neighbours[*ahead as usize..];
        let at = untried.iter().position(is_free);
        *ahead += at.map_or(untried.len(), |at| at + 1) as u32;
        at.map(|at| untried[at])
    }
}

#[cfg(test)]
mod tests {
    use clangor_core::math::random::SplitMix;

    use super::*;

    /// Nodes 0 to `LEFT` are on the left, the rest on the right.
    const LEFT: u32 = 9;
    const COUNT: u32 = 18;

    #[test]
    fn property_covers_are_the_smallest() {
        let mut random = SplitMix::new(5);
        let mut covers = VertexCovers::new(COUNT as usize);
        let side: Vec<u32> = (0..COUNT).map(|n| if n < LEFT { 1 } else { 2 }).collect();
        let mut sizes = [0; LEFT as usize + 1];
        for round in 0..300 {
            let density = 0.05 + 0.4 * f64::from(round) / 300.0;
            let mut neighbours = vec![Vec::new(); COUNT as usize];
            // Edges on the left alone must not matter.
            for (a, b) in (0..COUNT).flat_map(|a| (a + 1..COUNT).map(move |b| (a, b))) {
                if a < LEFT && random.uniform(0.0, 1.0) < density {
                    neighbours[a as usize].push(b);
                    neighbours[b as usize].push(a);
                }
            }
            let left: Vec<u32> = (0..LEFT).collect();
            let edges =
                Across { neighbours: |n: u32| neighbours[n as usize].as_slice(), side: &side, right: 2 };
            let cover = covers.cover(&left, &edges);
            let touched = |a: u32, b: u32| b < LEFT || cover.contains(&a) || cover.contains(&b);
            assert!(
                left.iter().all(|a| neighbours[*a as usize].iter().all(|b| touched(*a, *b))),
                "round {round}"
            );
            // Every choice of left nodes needs the right nodes beside the others.
            let smallest = (0..1_u32 << LEFT).map(|bits| {
                let beside = |b: u32| neighbours[b as usize].iter().any(|a| *a < LEFT && bits >> a & 1 == 0);
                bits.count_ones() as usize + (LEFT..COUNT).filter(|b| beside(*b)).count()
            });
            assert_eq!(cover.len(), smallest.min().unwrap(), "round {round}");
            sizes[cover.len()] += 1;
        }
        // Graphs of many kinds were tried.
        assert!(sizes.iter().filter(|count| **count > 0).count() >= 8, "{sizes:?}");
    }
}
