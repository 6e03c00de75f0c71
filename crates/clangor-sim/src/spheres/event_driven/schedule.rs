//! Schedule of the next events of all balls: a tournament (winner) tree over groups.
//!
//! The times of eight balls share a cache line. A static binary tree over these lines holds in each inner
//! node the earlier of its two children, so that changing one time costs one line and at most log₂ N/8
//! comparisons along one path. A ball has a single entry, however often it is predicted anew, so there are no
//! stale entries. Among equal times the lower index wins.

/// Balls whose times share a cache line.
const GROUP: usize = 8;

/// Winner tree over event times \[s\].
pub(super) struct Schedule {
    times: Vec<Group>,
    leaves: usize,
    /// Siblings; the first pair is the root alone.
    nodes: Vec<Siblings>,
}

#[derive(Clone)]
#[repr(align(64))]
struct Group([f64; GROUP]);

#[derive(Clone, Copy)]
struct Node {
    time: f64,
    ball: u32,
}

#[derive(Clone)]
#[repr(align(32))]
struct Siblings([Node; 2]);

impl Siblings {
    /// The earlier of the two.
    #[inline]
    fn winner(&self) -> Node {
        let [left, right] = self.0;
        if right.time < left.time { right } else { left }
    }
}

impl Schedule {
    /// A tree for `count` balls, none of which has an event.
    pub(super) fn new(count: usize) -> Self {
        let leaves = count.div_ceil(GROUP).next_power_of_two().max(2);
        let mut nodes = vec![Siblings([Node { time: f64::INFINITY, ball: 0 }; 2]); leaves];
        for (leaf, node) in nodes[leaves / 2..].iter_mut().flat_map(|pair| &mut pair.0).enumerate() {
            node.ball = (GROUP * leaf) as u32;
        }
        for at in (1..leaves).rev() {
            nodes[at / 2].0[at % 2] = nodes[at].winner();
        }
        Schedule { times: vec![Group([f64::INFINITY; GROUP]); leaves], leaves, nodes }
    }

    /// Sets the time of a ball's next event; infinity for none.
    pub(super) fn set(&mut self, ball: usize, time: f64) {
        let group = ball / GROUP;
        let mut at = self.leaves + group;
        let (held, times) = (self.nodes[at / 2].0[at % 2], &mut self.times[group].0);
        times[ball % GROUP] = time;
        let mut winner = Node { time, ball: ball as u32 };
        if held.ball == winner.ball {
            // The first of the group has changed, so another may now be first.
            for (place, &time) in times.iter().enumerate() {
                let rival = (GROUP * group + place) as u32;
                if time < winner.time || time == winner.time && rival < winner.ball {
                    winner = Node { time, ball: rival };
                }
            }
        } else if time > held.time || time == held.time && held.ball < winner.ball {
            return;
        }
        self.nodes[at / 2].0[at % 2] = winner;
        while at > 1 {
            at /= 2;
            let winner = self.nodes[at].winner();
            let held = &mut self.nodes[at / 2].0[at % 2];
            if held.ball == winner.ball && held.time == winner.time {
                return;
            }
            *held = winner;
        }
    }

    /// The first event: its time and ball.
    pub(super) fn first(&self) -> (f64, usize) {
        let Node { time, ball } = self.nodes[0].0[1];
        (time, ball as usize)
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

    #[test]
    fn the_first_of_many_is_the_least_at_every_change() {
        let mut schedule = Schedule::new(300);
        let mut times = vec![f64::INFINITY; 300];
        for k in 0..5000_usize {
            // Few distinct times, so that ties are common.
            let (ball, time) = (k * k * 31 % 300, ((k * 7919) % 101) as f64);
            times[ball] = time;
            schedule.set(ball, time);
            let least = times.iter().copied().fold(f64::INFINITY, f64::min);
            let first = times.iter().position(|&t| t == least);
            assert_eq!(schedule.first(), (least, first.unwrap()));
        }
    }
}
