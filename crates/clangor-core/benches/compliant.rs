//! Processor time of the solve of an impact between bodies that give way, on one core:
//! `cargo bench --profile release -p clangor-core --bench compliant`.
//!
//! A steel ball on a plate of 50 and of 108 modes, at points and speeds of all kinds, eight steps per first
//! duration: median and 90 % over 80 impacts, with the number of steps. Then a plate of 108 modes that lands
//! flat on four points, over 867 steps.

mod thread_time;

use std::hint::black_box;

use clangor_core::contact::compliant::{
    ContactLaw, ContactSystem, HertzLaw, Member, MemberContact, SolverMemory, StepSettings,
};
use clangor_core::glam::{DMat3, DVec3};
use clangor_core::math::random::SplitMix;
use num_complex::Complex64;
use thread_time::thread_time;

fn contact(members: [Option<usize>; 2], point: DVec3, radius: f64) -> MemberContact {
    let stiffness = 4.0 / 3.0 * 5e10 * radius.sqrt();
    MemberContact {
        members,
        point,
        normal: DVec3::Y,
        velocity: DVec3::ZERO,
        law: ContactLaw::Hertz(HertzLaw { stiffness, restitution_damping: 0.037, ..HertzLaw::default() }),
        gap: 0.0,
        friction: 0.0,
        standing: false,
        shapes: [Vec::new(), Vec::new()],
    }
}

fn rigid(mass: f64, inertia: f64, velocity: DVec3) -> Member {
    Member {
        inverse_mass: 1.0 / mass,
        inverse_inertia: DMat3::from_diagonal(DVec3::splat(1.0 / inertia)),
        centre: DVec3::ZERO,
        velocity,
        angular_velocity: DVec3::ZERO,
        acceleration: DVec3::ZERO,
        poles: Vec::new(),
        state: Vec::new(),
    }
}

/// A dinner plate of 540 g with this number of modes up to 20 kHz, and shapes at a point.
fn plate(random: &mut SplitMix, modes: usize) -> Member {
    let mut member = rigid(0.54, 0.002, DVec3::ZERO);
    let pole = |i: usize| {
        let omega = std::f64::consts::TAU * 20e3 * (i as f64 + random.uniform(0.6, 1.0)) / modes as f64;
        Complex64::new(-0.001 * omega, omega)
    };
    member.poles = (0..modes).map(pole).collect();
    member
}

fn shapes(random: &mut SplitMix, modes: usize) -> Vec<DVec3> {
    (0..modes).map(|_| random.uniform(-3.3, 3.3) * DVec3::Y).collect()
}

/// Least processor time [s] of several solves, preparation included, and the steps.
fn best(members: &[Member], contacts: &[MemberContact], settings: &StepSettings) -> (f64, usize) {
    let mut system = ContactSystem::default();
    let mut memory = SolverMemory::default();
    let (mut least, mut steps) = (f64::INFINITY, 0);
    for _ in 0..5 {
        let begin = thread_time();
        let mut repeats = 0;
        while thread_time() - begin < 0.01 {
            for _ in 0..8 {
                system.replace(members, contacts).expect("sound data");
                let solution = system.solve(settings, &mut memory).expect("an impact");
                steps = black_box(solution).steps;
            }
            repeats += 8;
        }
        least = f64::min(least, (thread_time() - begin) / f64::from(repeats));
    }
    (least, steps)
}

fn main() {
    let mut random = SplitMix::new(1);
    let settings = StepSettings { steps_per_duration: 8.0, ..StepSettings::default() };
    for modes in [50, 108] {
        let target = plate(&mut random, modes);
        let mut times: Vec<(f64, usize)> = (0..80)
            .map(|_| {
                let radius = 10f64.powf(random.uniform(-2.7, -1.8));
                let speed = 10f64.powf(random.uniform(-1.0, 0.5));
                let mass = 7850.0 * 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
                let ball = rigid(mass, 0.4 * mass * radius * radius, -speed * DVec3::Y);
                let mut hit = contact([Some(0), Some(1)], DVec3::ZERO, radius);
                hit.shapes[1] = shapes(&mut random, modes);
                best(&[ball, target.clone()], &[hit], &settings)
            })
            .collect();
        times.sort_by(|a, b| a.0.total_cmp(&b.0));
        let [(median, steps), (most, more)] = [times[40], times[72]];
        println!("{modes} modes: {:.1} µs ({steps} steps), 90 % {:.1} µs ({more})", 1e6 * median, 1e6 * most);
    }
    let mut target = plate(&mut random, 108);
    target.velocity = -DVec3::Y;
    let landing: Vec<MemberContact> = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)]
        .map(|(x, z)| {
            let mut foot = contact([Some(0), None], 0.05 * DVec3::new(x, 0.0, z), 0.003);
            foot.shapes[0] = shapes(&mut random, 108);
            foot
        })
        .to_vec();
    for friction in [0.0, 0.3] {
        let mut landing = landing.clone();
        landing.iter_mut().for_each(|foot| foot.friction = friction);
        let settings = StepSettings { max_steps: 867, end_when_parted: false, ..settings };
        let (time, steps) = best(std::slice::from_ref(&target), &landing, &settings);
        println!("4 points × 108 modes, friction {friction}: {:.3} ms ({steps} steps)", 1e3 * time);
    }
}
