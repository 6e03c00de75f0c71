//! Error of replacing a stone by an ellipsoid, the mean of those of the bank around it or the nearest, or by
//! a sphere: third-octave levels of twenty stones.
//!
//! `cargo run --release -p clangor-validation --bin rock_proxies [-- ROCKS]`
//!
//! Each stone receives impacts at random points of its surface along the inward normal; listeners are in
//! random directions at 1 m. The levels of the third-octave bands from 500 Hz to 16 kHz are compared with
//! those of its individual field.

use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow;

use clangor_bake::acceleration::BakeOptions;
use clangor_bake::fitting::comparison::directions;
use clangor_core::body::Surface;
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::glam::{DMat3, DVec3};
use clangor_core::medium::Medium;
use clangor_core::shape::Shape;
use clangor_core::sound_model::acceleration::field::AccelerationField;
use clangor_core::sound_model::acceleration::proxy_field::mean_field;
use clangor_pipeline::formats::soundbank::default_bank;
use clangor_pipeline::stages::sound_models::{AccelerationBake, SoundModelRequest, bake_model};

const AIR: Medium = Medium::AIR;
/// Impacts and listeners of each stone.
const IMPACTS: usize = 12;
/// Frequencies in a band.
const LINES: usize = 5;

/// A field, its radius \[m\], and the rotation from its frame to that of the body.
struct Heard<'a>(&'a AccelerationField, f64, DMat3);

impl Heard<'_> {
    /// Mean square pressure of a unit impulse in a band about `centre` \[Hz\].
    fn band(&self, (a, alpha): (DVec3, DVec3), x: DVec3, centre: f64) -> f64 {
        let Heard(field, radius, rotation) = self;
        let to_field = rotation.transpose();
        let (a, alpha) = (to_field * a, to_field * alpha * *radius);
        let z = [a.x, a.y, a.z, alpha.x, alpha.y, alpha.z];
        (0..LINES)
            .map(|line| {
                let f = centre * 2.0_f64.powf((line as f64 - 2.0) / 15.0);
                let k = TAU * f / AIR.sound_speed;
                (*radius * field.pressure(&z, to_field * x / *radius, k * radius)).norm_sqr()
            })
            .sum()
    }
}

/// The squared pressure of a sphere with this acceleration, summed over a band.
fn sphere_band(radius: f64, a: DVec3, x: DVec3, centre: f64) -> f64 {
    use clangor_core::sound_model::acceleration::sphere_radiation::{SphereModel, SphereTransfer};
    let unit = Medium { density: 1.0, sound_speed: 1.0 };
    let transfer = SphereTransfer::new(SphereModel::Exact, &unit, radius, x.length(), a.dot(x) / x.length());
    (0..LINES)
        .map(|line| {
            let f = centre * 2.0_f64.powf((line as f64 - 2.0) / 15.0);
            let (re, im) = transfer.at(TAU * f / AIR.sound_speed);
            re * re + im * im
        })
        .sum()
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn main() {
    let rocks: usize = std::env::args().skip(1).find_map(|a| a.parse().ok()).unwrap_or(20);
    let bank = default_bank().expect("the bank of the program");
    let bands: Vec<f64> = (0..16).map(|k| 500.0 * 2.0_f64.powf(k as f64 / 3.0)).collect();
    let (mut ellipsoid, mut nearest, mut ball) = (Vec::new(), Vec::new(), Vec::new());
    for seed in 1..=rocks {
        let (surface, mass) =
            Shape::parse(&format!("rock:{seed}x0.015")).expect("a rock").surface().expect("a solid");
        let Surface::Mesh(mesh) = &surface else { panic!("a mesh") };
        let MassProperties { volume, inertia, .. } = mass;
        // Reference: individual field. Proxies: mean and nearest ellipsoid, sphere.
        let options = BakeOptions::new(TAU * 20_000.0 / AIR.sound_speed, 1e-2);
        let request =
            SoundModelRequest::new("rock", &surface, mass, AccelerationBake(options)).expect("a body");
        let own = bake_model(&request, &mut |_| ControlFlow::Continue(())).expect("a field").acceleration;
        let proxy = bank.bank().proxy_for(inertia, volume).expect("a proxy");
        let heard_own = Heard(&own.field, own.radius, DMat3::IDENTITY);
        let mean = mean_field(bank.bank(), &proxy, usize::MAX);
        let heard_proxy = Heard(&mean, proxy.radius, proxy.rotation);
        let entry = &bank.bank().entries()[proxy.entry].field;
        let heard_nearest = Heard(entry, proxy.radius, proxy.rotation);
        let radius = (0.75 * volume / PI).cbrt();
        let triangles = mesh.mesh.triangles.len();
        // Third-octave levels of random impacts.
        for (impact, direction) in directions(IMPACTS).enumerate() {
            let t = (impact * 7919 + seed * 104_729) % triangles;
            let impulse = -mesh.mesh.area_vector(t).normalize();
            let motion = (impulse / volume, inertia.inverse() * mesh.mesh.centroid(t).cross(impulse));
            for &centre in &bands {
                let level = |energy: f64| 10.0 * energy.log10();
                let reference = level(heard_own.band(motion, direction, centre));
                ellipsoid.push((level(heard_proxy.band(motion, direction, centre)) - reference).abs());
                nearest.push((level(heard_nearest.band(motion, direction, centre)) - reference).abs());
                ball.push((level(sphere_band(radius, motion.0, direction, centre)) - reference).abs());
            }
        }
    }
    println!("{rocks} rocks, {IMPACTS} impacts each, {} bands:", bands.len());
    println!(
        "median difference of third-octave levels: ellipsoid {:.2} dB, nearest ellipsoid {:.2} dB, \
         sphere {:.2} dB",
        median(ellipsoid),
        median(nearest),
        median(ball)
    );
}
