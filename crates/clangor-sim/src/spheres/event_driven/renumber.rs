//! Renumbers the balls in the order of their cells from time to time, so that neighbours in space stay
//! neighbours in memory.
//!
//! A search reads the balls of 27 cells. In an order mixed by collisions each of them is a cache miss once
//! the balls exceed the cache; in Z-order most of them share pages and lines.

use super::engine::{Engine, PLANE};
use super::grid::NOWHERE;
use crate::spheres::cells::interleave;

/// Fewer balls than this fit into the cache in any order.
const FEW: usize = 2000;
/// Impacts per ball after which the balls are renumbered.
const MIXED: usize = 4;

impl Engine {
    /// Renumbers the balls if there have been enough impacts since the last time.
    pub(crate) fn renumber_if_mixed(&mut self) {
        let count = self.balls.len();
        if count < FEW || self.impacts < MIXED * count {
            return;
        }
        self.impacts = 0;
        let mut low = [i32::MAX; 3];
        for ball in self.balls.iter().filter(|b| b.bucket != NOWHERE) {
            for (low, cell) in low.iter_mut().zip(ball.cell) {
                *low = (*low).min(cell);
            }
        }
        let key = |cell: [i32; 3]| interleave(std::array::from_fn(|k| cell[k].saturating_sub(low[k])));
        let mut order: Vec<(u64, u32)> =
            self.balls.iter().enumerate().map(|(old, ball)| (key(ball.cell), old as u32)).collect();
        order.sort_unstable();
        let mut new_of = vec![0_u32; count];
        for (new, &(_, old)) in order.iter().enumerate() {
            new_of[old as usize] = new as u32;
        }

        permute(&mut self.balls, &order);
        permute(&mut self.spins, &order);
        permute(&mut self.traits, &order);
        permute(&mut self.compliances, &order);
        permute(&mut self.phases, &order);
        permute(&mut self.island_places, &order);
        permute(&mut self.next, &order);
        if let Some(pending) = &mut self.pending {
            permute(pending, &order);
        }
        for next in &mut self.next {
            // The marks of planes, searches and no partner all contain the plane bit.
            if next.partner & PLANE == 0 {
                next.partner = new_of[next.partner as usize];
            }
        }
        self.pressed.renumber(&new_of);
        for ball in self.by_body.iter_mut().chain(&mut self.wide) {
            *ball = new_of[*ball as usize];
        }
        for ball in self.islands.iter_mut().flat_map(|island| &mut island.balls) {
            *ball = new_of[*ball] as usize;
        }
        self.grid.clear();
        for ball in 0..count {
            if self.balls[ball].bucket != NOWHERE {
                self.grid.insert(&mut self.balls, ball);
            }
            let next = self.next[ball];
            self.schedule.set(ball, next.contact.min(next.crossing).min(next.phase_end));
        }
    }
}

fn permute<T>(items: &mut Vec<T>, order: &[(u64, u32)]) {
    let mut old: Vec<Option<T>> = std::mem::take(items).into_iter().map(Some).collect();
    items.extend(order.iter().filter_map(|&(_, from)| old[from as usize].take()));
}
