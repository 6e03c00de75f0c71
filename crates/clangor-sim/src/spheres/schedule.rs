//! The next event of every ball, and which of them is first: a winner tree.
//!
//! A static binary tree over the balls whose inner nodes hold the earlier of their two children. Changing one time
//! costs at most log₂ N comparisons along one path and nothing is ever searched for or thrown away, so a ball has
//! one entry however often it is predicted anew. Equal times are won by the lower index.

/// Winner tree over event times [s].
pub(super) struct Schedule {
    leaves: usize,
    nodes: Vec<Node>,
}

#[derive(Clone, Copy)]
struct Node {
    time: f64,
    ball: u32,
}

impl Schedule {
    /// A tree for `count` balls, none of which has an event.
    pub(super) fn new(count: usize) -> Self {
        let leaves = count.next_power_of_two().max(2);
        let mut nodes = vec![Node { time: f64::INFINITY, ball: 0 }; 2 * leaves];
        for ball in 0..leaves {
            nodes[leaves + ball].ball = ball as u32;
        }
        for at in (1..leaves).rev() {
            nodes[at] = nodes[2 * at];
        }
        Schedule { leaves, nodes }
    }

    /// Sets the time of a ball's next event; infinity for none.
    pub(super) fn set(&mut self, ball: usize, time: f64) {
        let mut at = self.leaves + ball;
        self.nodes[at].time = time;
        while at > 1 {
            let (left, right) = (self.nodes[at & !1], self.nodes[at | 1]);
            let winner = if right.time < left.time { right } else { left };
            at /= 2;
            let held = self.nodes[at];
            if held.ball == winner.ball && held.time == winner.time {
                return;
            }
            self.nodes[at] = winner;
        }
    }

    /// The first event: its time and ball.
    pub(super) fn first(&self) -> (f64, usize) {
        (self.nodes[1].time, self.nodes[1].ball as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_earliest_ball_wins_and_ties_go_to_the_lower_index() {
        let mut schedule = Schedule::new(5);
        assert_eq!(schedule.first().0, f64::INFINITY);
        for (ball, time) in [(3, 2.0), (1, 4.0), (4, 2.0), (0, 3.0)] {
            schedule.set(ball, time);
        }
        assert_eq!(schedule.first(), (2.0, 3));
        schedule.set(3, f64::INFINITY);
        assert_eq!(schedule.first(), (2.0, 4));
        schedule.set(4, 3.0);
        assert_eq!(schedule.first(), (3.0, 0));
    }
}
