//! \[FRAC\] Fig. 4: a lower fracture energy gives more and smaller pieces.

#![cfg(feature = "fracture")]

use std::thread;

use clangor_core::scene::breaking::Breaking;

use crate::brittle::{run, tile};

#[test]
fn lower_toughness_gives_more_and_smaller_pieces() {
    let medians = |toughness: f64| {
        let mut outcomes: Vec<(usize, f64)> = (0..10)
            .map(|seed| {
                let (world, breakables) = tile(toughness, (0.03, 4.0), 12.0, Breaking::default(), seed);
                let masses = run(&world, breakables, 1e-4, 0.06).masses(world.bodies[0].mass);
                (masses.len(), masses[masses.len() / 2])
            })
            .collect();
        outcomes.sort_by_key(|(count, _)| *count);
        let count = outcomes[5].0;
        outcomes.sort_by(|a, b| a.1.total_cmp(&b.1));
        println!("{toughness} J/m²: {count} pieces, of {:.2} g in the middle", 1e3 * outcomes[5].1);
        (count, outcomes[5].1)
    };
    let found = thread::scope(|scope| {
        [80.0, 120.0, 200.0].map(|g| scope.spawn(move || medians(g))).map(|run| run.join().unwrap())
    });
    for pair in found.windows(2) {
        assert!(pair[0].0 > pair[1].0 && pair[0].1 < pair[1].1, "{found:?}");
    }
}
