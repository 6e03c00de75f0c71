//! An ellipsoid between those of the bank: the mean of those around it against its own field, and against the
//! nearest.

use std::f64::consts::PI;
use std::ops::ControlFlow;

use clangor_bake::fitting::comparison::directions;
use clangor_bake::soundbank::acceleration::bank_entry;
use clangor_core::glam::{DMat3, DVec3};
use clangor_core::sound_model::acceleration::field::{AccelerationField, RIGID_DOFS};
use clangor_core::sound_model::acceleration::proxy_field::mean_field;
use clangor_pipeline::formats::soundbank::default_bank;

/// Highest kA of the comparison.
const HIGHEST: f64 = 8.0;

/// Relative L2 error of a motion at twice the longest semi-axis.
fn error(field: &AccelerationField, exact: &AccelerationField, degree: usize) -> f64 {
    let mut z = [0.0; RIGID_DOFS];
    z[degree] = 1.0;
    let (mut difference, mut size) = (0.0, 0.0);
    for direction in directions(20) {
        for step in 1..=16 {
            let kappa = HIGHEST * f64::from(step) / 16.0;
            let p = exact.pressure(&z, 2.0 * direction, kappa);
            difference += (field.pressure(&z, 2.0 * direction, kappa) - p).norm_sqr();
            size += p.norm_sqr();
        }
    }
    (difference / size).sqrt()
}

#[test]
fn between_four_ellipsoids_their_mean_is_better_than_the_nearest() {
    let bank = default_bank().expect("the bank of the program");
    let bank = bank.bank();
    // The middle of a cell, and a place in a cell on the diagonal B = C.
    for (b, c) in [(0.8575, 0.5725), (0.4775, 0.449)] {
        let axes = DVec3::new(1.0, b, c);
        let square = axes * axes;
        let inertia = DMat3::from_diagonal(DVec3::splat(square.element_sum()) - square);
        let proxy = bank.proxy_for(inertia, 4.0 / 3.0 * PI * axes.element_product()).expect("a proxy");
        assert!(proxy.mean.iter().filter(|(_, weight)| *weight > 0.0).count() > 2);
        let mean = mean_field(bank, &proxy, 11);
        let nearest = mean_field(bank, &proxy.of_nearest(), 11);
        let own = bank_entry(b, c, HIGHEST, 3e-3, &mut |_| ControlFlow::Continue(())).unwrap().0.field;
        for degree in 0..RIGID_DOFS {
            let (of_mean, of_nearest) = (error(&mean, &own, degree), error(&nearest, &own, degree));
            println!("1 : {b} : {c}, motion {degree}: mean {of_mean:.4}, nearest {of_nearest:.4}");
            // Seen: 0.01 to 0.03 against 0.11 to 0.23; 0.08 for the rotation about x of the second, whose B
            // and C differ by 6 %: it is nearly silent, and that of the nearest, with B = C, is.
            let most = if (b, degree) == (0.4775, 3) { 0.12 } else { 0.05 };
            assert!(of_mean < most && of_mean < of_nearest, "{b} {c} {degree}: {of_mean} {of_nearest}");
        }
    }
}
