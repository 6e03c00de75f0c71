//! The meridian solver converges: sharp edges, thin walls, cavities, and a loop off the axis.

use std::f64::consts::TAU;

use clangor_bake::bem::axisymmetric::{AxisymmetricOptions, AxisymmetricSolver};
use clangor_bake::radiation::{RadiationSample, RadiationSolver};
use clangor_core::geometry::meridian::{Meridian, Piece};
use clangor_core::medium::Medium;
use clangor_core::shape::Shape;
use glam::{DVec2, DVec3};

/// Largest level error: of each motion relative to the strongest, rotations at equal surface speed.
fn level_error(found: &[RadiationSample], exact: &[RadiationSample], radius: f64) -> f64 {
    let unit = |degree: usize| if degree < 3 { 1.0 } else { radius };
    let mut worst = 0.0_f64;
    for (a, b) in found.iter().zip(exact) {
        let size = |d: usize| b.coefficients[d].iter().map(|c| c.norm_sqr()).sum::<f64>().sqrt() / unit(d);
        let loudest = (0..6).map(size).fold(0.0, f64::max);
        for d in 0..6 {
            let gap = a.coefficients[d].iter().zip(&b.coefficients[d]).map(|(a, b)| (a - b).norm_sqr());
            worst = worst.max(gap.sum::<f64>().sqrt() / unit(d) / loudest);
        }
    }
    worst
}

#[test]
fn finer_panels_agree_with_the_default_ones() {
    // Highest frequency [Hz] and bound; the plate and the bowl have kR = 48 and 29 there.
    for (name, frequency, bound) in
        [("coin", 20e3, 1e-4), ("plate", 20e3, 1e-5), ("bowl", 20e3, 1e-4), ("torus:0.03x0.01", 8e3, 1e-6)]
    {
        let shape = Shape::parse(name).expect("a shape");
        let meridian = shape.meridian().expect("an axisymmetric body").about_centre_of_mass();
        let highest = TAU * frequency / 343.0;
        let order = (highest * meridian.bounding_radius()) as usize + 8;
        let wavenumbers = [0.4 * highest, highest];
        let default = AxisymmetricOptions::new(highest);
        let finer = AxisymmetricOptions { nodes_per_wavelength: 14.0, edge_levels: 7, ..default };
        let [coarse, fine] = [default, finer].map(|options| {
            let solver = AxisymmetricSolver::new(&meridian, DVec3::Y, options);
            solver.solve(&wavenumbers, order).expect("fields")
        });
        let error = level_error(&coarse, &fine, meridian.bounding_radius());
        println!("{name}: {error:.1e}");
        assert!(error < bound, "{name}: {error:e}");
    }
}

/// A ball of lines with joints of an angle \[rad\], each line cut in halves `levels` times towards its ends.
fn ball_of_lines(angle: f64, levels: i32) -> Meridian {
    let count = (std::f64::consts::PI / angle).round() as usize;
    let corner = |k: usize| {
        let (sin, cos) = (std::f64::consts::PI * k as f64 / count as f64).sin_cos();
        DVec2::new(if k == count { 0.0 } else { 0.02 * sin }, -0.02 * cos)
    };
    let mut cuts: Vec<f64> = (0..=levels).map(|k| 0.5_f64.powi(k + 1)).collect();
    cuts.extend((0..=levels).map(|k| 1.0 - 0.5_f64.powi(k + 1)));
    cuts.extend([0.0, 1.0]);
    cuts.sort_by(f64::total_cmp);
    cuts.dedup();
    let line = |k: usize| {
        let (from, to) = (corner(k), corner(k + 1));
        let piece = move |w: &[f64]| Piece::Line { from: from.lerp(to, w[0]), to: from.lerp(to, w[1]) };
        if levels == 0 { vec![Piece::Line { from, to }] } else { cuts.windows(2).map(piece).collect() }
    };
    Meridian::try_new((0..count).flat_map(line).collect()).expect("a ball")
}

/// Joints of sections that are fitted to meshes. Seen: 8e-8.
#[test]
fn converge_small_joints_need_no_grading() {
    let highest = TAU * 20e3 / Medium::AIR.sound_speed;
    let order = 16;
    let [whole, graded] = [0, 2].map(|levels| {
        let meridian = ball_of_lines(0.098, levels);
        let solver = AxisymmetricSolver::new(&meridian, DVec3::Y, AxisymmetricOptions::new(highest));
        println!("{} unknowns", solver.unknowns());
        solver.solve(&[0.4 * highest, highest], order).expect("fields")
    });
    let error = level_error(&whole, &graded, 0.02);
    println!("{error:.1e}");
    assert!(error < 1e-6, "{error:e}");
}
