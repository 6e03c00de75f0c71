//! All coordinates of an impact by an independent integrator: Dormand and Prince's pair of orders 5 and 4.

use clangor_core::contact::compliant::{ContactLaw, Member, MemberContact};
use clangor_core::glam::DVec3;

/// Row s: a_{s1} … of stage s + 1; the last row gives the solution of order 5.
const STAGES: [[f64; 6]; 6] = [
    [1.0 / 5.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
    [19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0, 0.0, 0.0],
    [9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0, 0.0],
    [35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
];
/// Order 5 less order 4.
const ERROR: [f64; 7] =
    [71.0 / 57600.0, 0.0, -71.0 / 16695.0, 71.0 / 1920.0, -17253.0 / 339200.0, 22.0 / 525.0, -1.0 / 40.0];

/// Integrates ẏ = f(y) over a time; `scales` are the sizes of which errors are `tolerance`.
pub(crate) fn integrate(
    rate: impl Fn(&[f64], &mut [f64]),
    state: &mut Vec<f64>,
    time: f64,
    scales: &[f64],
    tolerance: f64,
) {
    let count = state.len();
    let mut slopes = vec![vec![0.0; count]; 7];
    let mut trial = vec![0.0; count];
    let (mut now, mut step) = (0.0, time / 1e4);
    rate(state, &mut slopes[0]);
    while now < time {
        step = step.min(time - now);
        for (stage, row) in STAGES.iter().enumerate() {
            for i in 0..count {
                let sum: f64 = row.iter().zip(&slopes).map(|(a, slope)| a * slope[i]).sum();
                trial[i] = state[i] + step * sum;
            }
            rate(&trial, &mut slopes[stage + 1]);
        }
        let mut worst = 0.0_f64;
        for i in 0..count {
            let error: f64 = ERROR.iter().zip(&slopes).map(|(e, slope)| e * slope[i]).sum();
            worst = worst.max((step * error).abs() / scales[i]);
        }
        let ratio = worst / tolerance;
        if ratio <= 1.0 {
            now += step;
            std::mem::swap(state, &mut trial);
            slopes.swap(0, 6);
        }
        step *= (0.9 * ratio.max(1e-10).powf(-0.2)).clamp(0.2, 4.0);
    }
}

/// State after a time: velocities, spins, and energy ½|w|² of each mode, and impulses of the contacts.
pub(crate) struct Integrated {
    pub(crate) velocities: Vec<DVec3>,
    pub(crate) energies: Vec<Vec<f64>>,
    pub(crate) impulses: Vec<f64>,
}

fn vector(state: &[f64], at: usize) -> DVec3 {
    DVec3::from_slice(&state[at..at + 3])
}

/// Where a member's coordinates begin: displacement, rotation, velocity, spin, q, q̇.
fn offsets(members: &[Member]) -> Vec<usize> {
    let sizes = members.iter().map(|m| 12 + 2 * m.poles.len());
    let begin = sizes.scan(0, |sum, size| Some(std::mem::replace(sum, *sum + size)));
    begin.collect()
}

/// Separation of a contact and its rate, apart from the gap.
fn separation(members: &[Member], contact: &MemberContact, at: &[usize], state: &[f64]) -> [f64; 2] {
    let mut sums = [0.0; 2];
    for (side, sign) in [(0, 1.0), (1, -1.0)] {
        let Some(index) = contact.members[side] else { continue };
        let (member, begin) = (&members[index], at[index]);
        let arm = contact.point - member.centre;
        for (part, sum) in sums.iter_mut().enumerate() {
            let mut moved = vector(state, begin + 6 * part) + vector(state, begin + 6 * part + 3).cross(arm);
            let modes = &state[begin + 12 + part * member.poles.len()..];
            moved += contact.shapes[side].iter().zip(modes).map(|(shape, q)| *shape * *q).sum::<DVec3>();
            *sum += sign * moved.dot(contact.normal);
        }
    }
    sums
}

fn force(law: &ContactLaw, approach: f64, rate: f64) -> f64 {
    match law {
        ContactLaw::Spring { stiffness, damping } => stiffness * approach + damping * rate,
        ContactLaw::Hertz(law) => {
            let d = approach.max(0.0);
            (law.stiffness * (d.powf(1.5) + 1.5 * law.viscosity * d.sqrt() * rate)).max(0.0)
        }
    }
}

/// Integrates frictionless contacts without restitution damping over a time.
pub(crate) fn impact(
    members: &[Member],
    contacts: &[MemberContact],
    time: f64,
    tolerance: f64,
) -> Integrated {
    let at = offsets(members);
    let size: usize = members.iter().map(|m| 12 + 2 * m.poles.len()).sum();
    let mut state = vec![0.0; size + contacts.len()];
    let mut scales = vec![1e-6; size + contacts.len()];
    for (member, begin) in members.iter().zip(&at) {
        state[begin + 6..begin + 9].copy_from_slice(&member.velocity.to_array());
        state[begin + 9..begin + 12].copy_from_slice(&member.angular_velocity.to_array());
        scales[begin + 6..begin + 12].fill(1.0);
        scales[begin + 9..begin + 12].fill(100.0);
        let count = member.poles.len();
        for (i, pole) in member.poles.iter().enumerate() {
            scales[begin + 12 + i] = 0.01 / pole.norm();
            scales[begin + 12 + count + i] = 0.01;
            if let Some(w) = member.state.get(i) {
                let q = w.im / pole.im;
                state[begin + 12 + i] = q;
                state[begin + 12 + count + i] = w.re + pole.re * q;
            }
        }
    }
    scales[size..].fill(1e-3);
    let rate = |state: &[f64], slope: &mut [f64]| {
        for (member, begin) in members.iter().zip(&at) {
            let (begin, count) = (*begin, member.poles.len());
            slope[begin..begin + 6].copy_from_slice(&state[begin + 6..begin + 12]);
            slope[begin + 6..begin + 9].copy_from_slice(&member.acceleration.to_array());
            slope[begin + 9..begin + 12].fill(0.0);
            let (q, rates) = (begin + 12, begin + 12 + count);
            for (i, pole) in member.poles.iter().enumerate() {
                slope[q + i] = state[rates + i];
                slope[rates + i] = 2.0 * pole.re * state[rates + i] - pole.norm_sqr() * state[q + i];
            }
        }
        for (index, contact) in contacts.iter().enumerate() {
            let [moved, speed] = separation(members, contact, &at, state);
            let force = force(&contact.law, -contact.gap - moved, -speed);
            slope[size + index] = force;
            for (side, sign) in [(0, 1.0), (1, -1.0)] {
                let Some(member) = contact.members[side] else { continue };
                let (body, begin) = (&members[member], at[member]);
                let push = sign * force * contact.normal;
                let linear = body.inverse_mass * push;
                let turn = body.inverse_inertia * (contact.point - body.centre).cross(push);
                for (i, part) in linear.to_array().into_iter().chain(turn.to_array()).enumerate() {
                    slope[begin + 6 + i] += part;
                }
                let rates = begin + 12 + body.poles.len();
                for (slope, shape) in slope[rates..].iter_mut().zip(&contact.shapes[side]) {
                    *slope += shape.dot(push);
                }
            }
        }
    };
    integrate(rate, &mut state, time, &scales, tolerance);
    let energies = members.iter().zip(&at).map(|(member, begin)| {
        let (q, rates) = (begin + 12, begin + 12 + member.poles.len());
        let energy = |(i, pole): (usize, &num_complex::Complex64)| {
            // |q̇ − λ̄q|².
            let re = state[rates + i] - pole.re * state[q + i];
            0.5 * (re * re + (pole.im * state[q + i]).powi(2))
        };
        member.poles.iter().enumerate().map(energy).collect()
    });
    Integrated {
        energies: energies.collect(),
        velocities: at.iter().map(|begin| vector(&state, begin + 6)).collect(),
        impulses: state[size..].to_vec(),
    }
}
