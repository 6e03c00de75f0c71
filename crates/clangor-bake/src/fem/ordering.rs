//! Elimination order of the unknowns.
//!
//! Two orders are computed on the graph of the nodes, whose three unknowns stay together: approximate minimum
//! degree, and nested dissection. The cheaper factor, counted from the elimination tree, decides: minimum
//! degree on thin shells, dissection on solids.
//!
//! Dissection uses the positions of the nodes. A set of nodes is cut across its longest extent, near the
//! median and where the fewest nodes have neighbours beyond. The smallest set of nodes that touches all edges
//! across the cut separates the halves ([`vertex_cover`](super::vertex_cover)).

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::amd;
use glam::DVec3;

use super::ElasticSystem;
use super::out_of_memory::OutOfMemory;
use super::vertex_cover::{Across, VertexCovers};

/// Largest set of nodes that is not cut further.
const LEAF: usize = 12;
/// The smaller part of a cut set is at least this part of it.
const LEAST_PART: f64 = 0.4;
const NONE: u32 = u32::MAX;

/// A permutation of the unknowns and its inverse.
pub(super) struct Ordering {
    pub(super) forward: Vec<u32>,
    pub(super) inverse: Vec<u32>,
    /// Of the factor.
    pub(super) fill: Fill,
}

/// Size of a factor, and the work to compute it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Fill {
    /// Numbers below the diagonal and on it.
    pub(crate) numbers: f64,
    /// Multiplications.
    pub(crate) multiplications: f64,
}

pub(super) fn best_ordering(system: &ElasticSystem) -> Result<Ordering, OutOfMemory> {
    let graph = Graph::of(system);
    let degree = minimum_degree(system)?;
    let dissection = dissect(&graph, system.nodes());
    let fills = [graph.fill(&dissection), graph.fill(&degree)];
    let is_better = fills[0].multiplications < fills[1].multiplications;
    let (best, fill) = if is_better { (dissection, fills[0]) } else { (degree, fills[1]) };
    let forward: Vec<u32> = best.iter().flat_map(|n| [0, 1, 2].map(|axis| 3 * n + axis)).collect();
    let mut inverse = vec![0; forward.len()];
    forward.iter().enumerate().for_each(|(k, n)| inverse[*n as usize] = k as u32);
    Ok(Ordering { forward, inverse, fill })
}

fn minimum_degree(system: &ElasticSystem) -> Result<Vec<u32>, OutOfMemory> {
    let count = system.node_count();
    let (starts, rows) = system.pattern();
    let rows: Vec<usize> = rows.iter().map(|r| *r as usize).collect();
    let graph = SymbolicSparseColMatRef::new_checked(count, count, starts, None, &rows);
    let memory = || OutOfMemory { unknowns: 3 * count };
    let (mut forward, mut inverse) = (vec![0; count], vec![0; count]);
    let scratch = amd::order_maybe_unsorted_scratch::<usize>(count, rows.len());
    let mut buffer = MemBuffer::try_new(scratch).map_err(|_| memory())?;
    let stack = MemStack::new(&mut buffer);
    amd::order_maybe_unsorted(&mut forward, &mut inverse, graph, amd::Control::default(), stack)
        .map_err(|_| memory())?;
    Ok(forward.iter().map(|n| *n as u32).collect())
}

/// Neighbours of every node.
struct Graph {
    starts: Vec<usize>,
    neighbours: Vec<u32>,
}

impl Graph {
    fn of(system: &ElasticSystem) -> Self {
        let (columns, rows) = system.pattern();
        let count = system.node_count();
        let pairs = || {
            (0..count).flat_map(|n| rows[columns[n]..columns[n + 1]].iter().map(move |r| (n, *r as usize)))
        };
        let mut starts = vec![0; count + 1];
        for (a, b) in pairs().filter(|(a, b)| a != b) {
            starts[a + 1] += 1;
            starts[b + 1] += 1;
        }
        for n in 0..count {
            starts[n + 1] += starts[n];
        }
        let mut next = starts.clone();
        let mut neighbours = vec![0; starts[count]];
        for (a, b) in pairs().filter(|(a, b)| a != b) {
            neighbours[next[a]] = b as u32;
            neighbours[next[b]] = a as u32;
            next[a] += 1;
            next[b] += 1;
        }
        Graph { starts, neighbours }
    }

    fn of_node(&self, node: u32) -> &[u32] {
        &self.neighbours[self.starts[node as usize]..self.starts[node as usize + 1]]
    }

    /// The factor in this order, with three unknowns to a node. The multiplications are half the sum of the
    /// squares of the column counts.
    ///
    /// Source: Liu (1990), "The role of elimination trees in sparse factorization": row k of the factor is a
    /// subtree of the elimination tree, whose nodes are met by climbing from the neighbours of k.
    fn fill(&self, order: &[u32]) -> Fill {
        let count = order.len();
        let mut place = vec![0_u32; count];
        order.iter().enumerate().for_each(|(k, n)| place[*n as usize] = k as u32);
        // Elimination tree by path compression.
        let (mut parent, mut ancestor) = (vec![NONE; count], vec![NONE; count]);
        for (k, node) in order.iter().enumerate() {
            let k = k as u32;
            for neighbour in self.of_node(*node) {
                let mut climb = place[*neighbour as usize];
                // Climb to the root, which becomes a child of k; compress the path on the way.
                while climb < k {
                    let above = std::mem::replace(&mut ancestor[climb as usize], k);
                    if above == NONE {
                        parent[climb as usize] = k;
                        break;
                    }
                    climb = above;
                }
            }
        }
        // Column counts: climb the row subtree of each k.
        let (mut counts, mut seen) = (vec![1_u32; count], vec![NONE; count]);
        for (k, node) in order.iter().enumerate() {
            let k = k as u32;
            seen[k as usize] = k;
            for neighbour in self.of_node(*node) {
                let mut climb = place[*neighbour as usize];
                while climb < k && seen[climb as usize] != k {
                    seen[climb as usize] = k;
                    counts[climb as usize] += 1;
                    climb = parent[climb as usize];
                }
            }
        }
        let sum = |power: i32| counts.iter().map(|c| (3.0 * f64::from(*c)).powi(power)).sum::<f64>();
        Fill { numbers: 3.0 * sum(1), multiplications: 1.5 * sum(2) }
    }
}

/// Nested dissection.
fn dissect(graph: &Graph, positions: &[DVec3]) -> Vec<u32> {
    let count = positions.len();
    let mut order = vec![0_u32; count];
    let mut side = vec![0_u32; count];
    let mut covers = VertexCovers::new(count);
    let mut rank = vec![NONE; count];
    let mut mark = 0;
    // Stack of node sets with the end of their range in the order: separators come last.
    let mut stack = vec![((0..count as u32).collect::<Vec<u32>>(), count)];
    while let Some((mut set, end)) = stack.pop() {
        if set.len() <= LEAF {
            order[end - set.len()..end].copy_from_slice(&set);
            continue;
        }
        // Cut across the longest extent.
        let (low, high) = set.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), n| {
            let p = positions[*n as usize];
            (low.min(p), high.max(p))
        });
        let axis = (high - low).max_position();
        set.sort_unstable_by(|a, b| {
            let key = |n: &u32| positions[*n as usize][axis];
            key(a).total_cmp(&key(b)).then(a.cmp(b))
        });
        // Vertex separator: minimum cover of the edges across the cut.
        let (left, right) = set.split_at(narrowest(graph, &set, &mut rank));
        mark += 2;
        left.iter().for_each(|n| side[*n as usize] = mark);
        right.iter().for_each(|n| side[*n as usize] = mark + 1);
        let edges = Across { neighbours: |n: u32| graph.of_node(n), side: &side, right: mark + 1 };
        let cover = covers.cover(left, &edges);
        cover.iter().for_each(|n| side[*n as usize] = 0);
        let rest =
            |half: &[u32]| -> Vec<u32> { half.iter().copied().filter(|n| side[*n as usize] != 0).collect() };
        let (left, right) = (rest(left), rest(right));
        // The separator takes the last places; recurse into both halves.
        let end = end - cover.len();
        order[end..end + cover.len()].copy_from_slice(&cover);
        let before = end - right.len();
        stack.push((left, before));
        stack.push((right, end));
    }
    order
}

/// Cut position in a sorted set: the number of nodes before the cut with the smallest border.
///
/// `rank` is all [`NONE`] before and after.
fn narrowest(graph: &Graph, set: &[u32], rank: &mut [u32]) -> usize {
    let count = set.len();
    set.iter().enumerate().for_each(|(k, n)| rank[*n as usize] = k as u32);
    // By cuts: change of the number of nodes with a neighbour beyond, from the left and from the right.
    let mut more = vec![[0_i32; 2]; count + 1];
    for (k, n) in set.iter().enumerate() {
        let ranks = || graph.of_node(*n).iter().map(|m| rank[*m as usize]).filter(|r| *r != NONE);
        let (near, far) = ranks().fold((k, k), |(near, far), r| (near.min(r as usize), far.max(r as usize)));
        more[k + 1][0] += 1;
        more[far + 1][0] -= 1;
        more[near + 1][1] += 1;
        more[k + 1][1] -= 1;
    }
    set.iter().for_each(|n| rank[*n as usize] = NONE);
    let least = ((LEAST_PART * count as f64) as usize).max(1);
    let (mut touched, mut best) = ([0_i32; 2], (f64::INFINITY, count / 2));
    for (cut, more) in more.iter().enumerate().take(count - least + 1) {
        touched = [touched[0] + more[0], touched[1] + more[1]];
        let cost = f64::from(touched[0].min(touched[1])) * cut.max(count - cut) as f64;
        if cut >= least && cost < best.0 {
            best = (cost, cut);
        }
    }
    best.1
}
