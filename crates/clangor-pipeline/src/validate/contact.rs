//! Hertz contact: the printed time scale of \[PAN\] Table 1, and Hertz's equation of motion integrated
//! numerically.

use clangor_core::contact::hertz::HertzContact;
use clangor_core::material::presets;

use super::{Check, Extent, Outcome, Validation};

const SECTION: &str = "Contact";

pub(super) fn run(_extent: Extent, table: &mut Validation) -> Outcome {
    let material = presets::preset("pan-steel").ok_or("there is no preset pan-steel")?;
    // A ball of 7.5 mm against a rigid plane at 5 m/s.
    let radius: f64 = 0.0075;
    let mass = material.density * 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
    let contact = HertzContact {
        inverse_mass: 1.0 / mass,
        relative_radii: [radius; 2],
        compliance: material.contact_compliance(),
        speed: 5.0,
    };
    let duration = contact.duration();
    table.checks.push(Check {
        section: SECTION,
        quantity: "pulse time scale h = τ/5 of the 7.5 mm `pan-steel` ball at 5 m/s".into(),
        reference: "7.34 µs, PAN Table 1 with its radius formula mended and its factor 2.87 for 2.8683",
        error: (duration / 5.0 * 1e6 - 7.34).abs(),
        bar: 0.01,
        unit: "µs",
    });
    let stiffness = 4.0 / 3.0 * radius.sqrt() / contact.compliance;
    let integrated = collision_time(mass, stiffness, contact.speed);
    table.checks.push(Check {
        section: SECTION,
        quantity: "contact duration τ of the same collision".into(),
        reference: "m d̈ = −(4/3) √r E* d^1.5 integrated by Runge–Kutta",
        error: (duration / integrated - 1.0).abs(),
        bar: 1e-6,
        unit: "",
    });
    Ok(())
}

/// Time from touch to release of a mass on a Hertzian spring [s], by the classical Runge–Kutta method.
fn collision_time(mass: f64, stiffness: f64, speed: f64) -> f64 {
    let depth_scale = (mass * speed * speed / stiffness).powf(0.4);
    let step = 1e-4 * depth_scale / speed;
    let slope = |(d, v): (f64, f64)| (v, -stiffness / mass * d.max(0.0).powf(1.5));
    let along = |(d, v): (f64, f64), (dd, dv): (f64, f64), h: f64| (d + h * dd, v + h * dv);
    let (mut state, mut time) = ((0.0, speed), 0.0);
    loop {
        let k1 = slope(state);
        let k2 = slope(along(state, k1, 0.5 * step));
        let k3 = slope(along(state, k2, 0.5 * step));
        let k4 = slope(along(state, k3, step));
        let mean =
            ((k1.0 + 2.0 * k2.0 + 2.0 * k3.0 + k4.0) / 6.0, (k1.1 + 2.0 * k2.1 + 2.0 * k3.1 + k4.1) / 6.0);
        let next = along(state, mean, step);
        if next.0 <= 0.0 {
            return time + step * state.0 / (state.0 - next.0);
        }
        state = next;
        time += step;
    }
}
