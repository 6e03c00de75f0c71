//! Random impacts on bodies with baked modes: few steps against many.

use crate::baked_bodies::BakedBody;
use crate::comparison::{level_errors, mode_energies, solve};
use crate::random_impact::{BODIES, RandomImpact};
use clangor_core::math::random::SplitMix;

#[test]
fn eight_steps_are_enough_for_levels() {
    let mut random = SplitMix::new(3);
    let mut errors = [8.0, 16.0].map(|per_duration| (per_duration, Vec::new()));
    for (shape, preset, highest) in BODIES {
        let body = BakedBody::new(shape, preset, highest);
        let before = errors[0].1.len();
        for _ in 0..16 {
            let RandomImpact { members, hit, duration } = RandomImpact::new(&body, &mut random);
            let (time, hits) = ((8.0 * duration).min(3e-3), [hit]);
            let exact = mode_energies(solve(&members, &hits, 128.0, time).modal_state(0));
            for (per_duration, errors) in &mut errors {
                let solution = solve(&members, &hits, *per_duration, time);
                let levels = level_errors(&body.member.poles, solution.modal_state(0), &exact);
                let mean = levels.iter().map(|x| x * x).sum::<f64>() / levels.len() as f64;
                errors.push(mean.sqrt());
            }
        }
        let mut own = errors[0].1[before..].to_vec();
        own.sort_by(f64::total_cmp);
        println!("{shape}, {} modes: median {:.3} dB, worst {:.2}", body.member.poles.len(), own[8], own[15]);
    }
    for (per_duration, errors) in &mut errors {
        errors.sort_by(f64::total_cmp);
        let [median, most] = [40, 72].map(|at| errors[at]);
        println!("{per_duration} steps: median {median:.3} dB, 90 % {most:.3} dB, worst {:.2}", errors[79]);
        // Seen: 0.130 and 0.63 dB at 8 steps, 0.027 and 0.18 dB at 16.
        assert!(median < 0.15 && most < 0.8, "{per_duration} steps: {median} {most}");
    }
}
