//! Cost of the break of a rack of 15 balls: the whole event-driven run of 8 ms, with the solves of the
//! contacts.
//!
//! `cargo bench -p clangor-sim --bench rack`: milliseconds of CPU time, the median of 21 runs, and impacts;
//! the cue ball at 6.79 m/s, 3 mm off the centre and centred, gaps of 50 µm. One thread, so that CPU time
//! equals elapsed time.

#[path = "../tests/sphere_worlds/mod.rs"]
mod sphere_worlds;

use std::ops::ControlFlow;
use std::time::Instant;

use clangor_core::timeline::Timeline;
use clangor_sim::{ContactModel, SimulationSettings, simulate};
use sphere_worlds::{rack, settings};

fn main() {
    for aside in [0.003, 0.0] {
        let world = rack(aside);
        let settings =
            SimulationSettings { contact: ContactModel::Compliant, ..settings(2f64.powi(-7), false, 1.0) };
        let mut impacts = 0;
        let mut times: Vec<f64> = (0..21)
            .map(|_| {
                let mut timeline = Timeline::default();
                let begin = Instant::now();
                let report = simulate(&world, &settings, &mut timeline, &mut |_| ControlFlow::Continue(()));
                impacts = report.map_or(0, |report| report.impacts);
                1e3 * begin.elapsed().as_secs_f64()
            })
            .collect();
        times.sort_by(f64::total_cmp);
        println!("{aside} m aside: {:.3} ms, {impacts} impacts", times[10]);
    }
}
