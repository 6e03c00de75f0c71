//! A ball with a weight inside rocks on a floor with the period of its closed form.
//!
//! It rolls without slip. With the centre of mass a distance d below its middle, radius R, mass m and
//! inertia I about the centre of mass, small rocking has T = 2π √((I + m (R − d)²)/(m g d)).

use std::f64::consts::TAU;

use clangor_core::body::BodyId;
use clangor_core::glam::DVec3;
use clangor_core::scene::instantiate::load_shape;
use clangor_core::scene::{Scene, instantiate};
use clangor_sim::rigid::{RigidWorld, StepLog};

const STEP: f64 = 2e-4;

/// Period of the rocking of a ball of 5 cm and 1 kg, turned by `angle` at the start; the weight is `depth`
/// below its middle.
fn period(depth: f64, inertia: f64, angle: f64) -> f64 {
    // The middle of the ball is at the height of its radius.
    let place = [depth * angle.sin(), 0.05 - depth * angle.cos(), 0.0];
    let text = format!(
        "version = 1\n[material.hard]\nbase = \"steel\"\nrolling_loss = 0\nfriction = 0.8\n\
         [[plane]]\nmaterial = \"hard\"\n\
         [[body]]\nshape = \"sphere:0.05\"\nmaterial = \"hard\"\nmass = 1\n\
         centre_of_mass = [0, {}, 0]\n\
         inertia = [[{inertia}, 0, 0], [0, {inertia}, 0], [0, 0, {inertia}]]\n\
         position = {place:?}\norientation = {{ axis = [0, 0, 1], degrees = {} }}\n",
        -depth,
        angle.to_degrees()
    );
    let scene = Scene::from_toml(&text).unwrap_or_else(|e| panic!("{text}\n{e}"));
    let world = instantiate(&scene, &mut load_shape).unwrap().world;
    let ball = world.bodies.iter().position(|body| body.mass == 1.0).unwrap();
    let mut rigid = RigidWorld::try_new(&world, STEP, false).unwrap();
    let (mut log, mut times, mut last) = (StepLog::new(), Vec::new(), f64::NAN);
    while rigid.time() < 5.0 {
        rigid.step(&mut log).unwrap();
        let up = rigid.pose(BodyId(ball as u32)).orientation * DVec3::Y;
        let now = -up.x;
        if last < 0.0 && now >= 0.0 {
            times.push(rigid.time() - STEP * now / (now - last));
        }
        last = now;
    }
    assert!(times.len() > 3, "{} swings", times.len());
    (times[times.len() - 1] - times[0]) / (times.len() - 1) as f64
}

#[test]
fn analytic_a_loaded_ball_rocks_with_its_period() {
    for (depth, inertia) in [(0.02, 8e-4), (0.04, 2e-4), (0.01, 9e-4)] {
        let found = period(depth, inertia, 0.01);
        let expected = TAU * ((inertia + (0.05 - depth).powi(2)) / (9.81 * depth)).sqrt();
        let error = found / expected - 1.0;
        println!("depth {depth}: {found:.5} s, {error:.1e}");
        // Residuals seen: 1.9e-4, 3.3e-4, 1.8e-4; of the amplitude and of the steps.
        assert!(error.abs() < 2e-3, "{depth}: {error:.1e}");
    }
}
