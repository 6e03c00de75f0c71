//! Processor time of solved impacts on bodies with baked modes and a tail, on one core, preparation included:
//! `cargo bench --profile release -p clangor-bake --bench baked_impacts`.
//!
//! Eight steps per first duration: median and 90 % of 48 impacts of each body.

#[path = "../tests/baked_bodies/mod.rs"]
#[expect(dead_code, reason = "parts of it are for tests")]
mod baked_bodies;
#[path = "../../clangor-core/tests/compliant_bodies/mod.rs"]
#[expect(dead_code, reason = "parts of it are for tests")]
mod compliant_bodies;
#[path = "../tests/baked_bodies/random_impact.rs"]
mod random_impact;
#[path = "../../clangor-core/benches/thread_time/mod.rs"]
mod thread_time;

use std::hint::black_box;

use baked_bodies::BakedBody;
use clangor_core::contact::compliant::{ContactSystem, SolverMemory, StepSettings, modal_tail};
use clangor_core::math::random::SplitMix;
use random_impact::{BODIES, RandomImpact};
use thread_time::thread_time;

fn main() {
    let mut random = SplitMix::new(5);
    let settings = StepSettings { steps_per_duration: 8.0, ..StepSettings::default() };
    let (mut system, mut memory) = (ContactSystem::default(), SolverMemory::default());
    for (shape, preset, highest) in BODIES {
        let body = BakedBody::new(shape, preset, highest);
        let mut times: Vec<(f64, usize)> = (0..48)
            .map(|_| {
                let RandomImpact { mut members, mut hit, duration } = RandomImpact::new(&body, &mut random);
                let along = hit.shapes[1].iter().map(|shape| shape.dot(hit.normal));
                let modes = body.member.poles.iter().map(|pole| pole.norm()).zip(along);
                let tail = modal_tail(modes, body.highest, duration);
                members[0].poles.extend(&tail.poles);
                hit.shapes[1].extend(tail.poles.iter().map(|_| tail.shape * hit.normal));
                let hits = [hit];
                // The clock is coarse: many solves, preparation included.
                let (begin, mut solves, mut steps) = (thread_time(), 0, 0);
                while thread_time() - begin < 0.04 {
                    for _ in 0..8 {
                        system.replace(&members, &hits).expect("sound data");
                        steps = black_box(system.solve(&settings, &mut memory).expect("sound data")).steps;
                    }
                    solves += 8;
                }
                let cost = (thread_time() - begin) / f64::from(solves);
                (1e6 * cost, steps)
            })
            .collect();
        times.sort_by(|a, b| a.0.total_cmp(&b.0));
        let [(median, steps), (most, more)] = [times[24], times[43]];
        let modes = body.member.poles.len();
        println!("{shape}, {modes} modes: {median:.0} µs ({steps} steps), 90 % {most:.0} µs ({more})");
    }
}
