//! \[FRAC\] eq. (9) for the bank: an ellipsoid baked at another size against the scaled entry of the bank.

use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow;

use clangor_bake::geometry_class::bake_geometry::BakeGeometry;
use clangor_bake::modal::{ModalBakeOptions, ModalEvidence, find_modes, radiate};
use clangor_bake::soundbank::modal::ellipsoid_modes::BallPolynomials;
use clangor_bake::soundbank::modal::{ModalSoundbankOptions, modal_model, ringing_ellipsoid};
use clangor_core::material::Material;
use clangor_core::material::presets::{CERAMIC, GLASS};
use clangor_core::medium::Medium;
use clangor_core::sound_model::modal::model::ModalModel;
use clangor_core::sound_model::soundbank::modal_soundbank::{
    BankMaterial, ModalProxy, ModalSoundbank, ProxyBody,
};
use glam::{DMat3, DVec3};

const DEGREE: usize = 10;

fn material(of: &Material) -> BankMaterial {
    let Material { youngs_modulus, density, poisson_ratio, .. } = *of;
    BankMaterial { youngs_modulus, density, poisson_ratio, medium: Medium::AIR }
}

/// A bank of one ellipsoid, with its lowest modes.
fn bank(polynomials: &BallPolynomials, axes: DVec3, modes: f64) -> ModalSoundbank {
    let material = material(&GLASS.material());
    let first = polynomials.first(axes, material.poisson_ratio) * material.speed() / TAU;
    let options = ModalSoundbankOptions {
        degree: DEGREE,
        accuracy: 0.05,
        // Band, in multiples of the lowest frequency.
        least_first_frequency: 20_000.0 / modes,
        largest_size: 10.0,
        ..ModalSoundbankOptions::new(material)
    };
    let entry = ringing_ellipsoid(polynomials, axes, &options, &mut |_| ControlFlow::Continue(()));
    let entry = entry.expect("an ellipsoid");
    assert!((entry.max_frequency / (modes * first) - 1.0).abs() < 1e-9);
    ModalSoundbank::try_new(material, DEGREE, vec![entry]).expect("a bank")
}

fn inertia(axes: DVec3) -> DMat3 {
    let square = axes * axes;
    DMat3::from_diagonal((DVec3::splat(square.element_sum()) - square) / 5.0)
}

fn radiated(geometry: &BakeGeometry, model: &mut ModalModel, options: &ModalBakeOptions) {
    let mut evidence = ModalEvidence::default();
    radiate(geometry, model, &mut evidence, options, &mut |_| ControlFlow::Continue(())).expect("transfers");
}

fn scaled_against_baked(axes: DVec3, modes: f64, size: f64) -> Difference {
    let axes = axes.normalize();
    let polynomials = BallPolynomials::new(DEGREE);
    let bank = bank(&polynomials, axes, modes);
    let limit = bank.entries()[0].max_frequency / size;
    // The same at another size, baked directly. Semi-axes differ slightly, so that equal ones are not
    // permuted.
    let named = size * axes * DVec3::new(1.0, 1.0, 1.0 + 1e-7);
    let mut baked = modal_model(&polynomials, size * axes, bank.material(), limit).model;
    let options =
        ModalBakeOptions { max_frequency: limit, accuracy: 0.05, ..ModalBakeOptions::new(Medium::AIR) };
    radiated(&BakeGeometry::Ellipsoid { semi_axes: size * axes }, &mut baked, &options);
    let proxy = bank
        .proxy_for(&ProxyBody {
            inertia: inertia(named),
            mass: bank.material().density * 4.0 / 3.0 * PI * (size * axes).element_product(),
            first_frequency: baked.modes[0].frequency,
            material: *bank.material(),
            max_frequency: 1.0001 * limit,
        })
        .expect("a proxy");
    assert!((proxy.rotation() - DMat3::IDENTITY).to_cols_array().iter().all(|x| x.abs() < 1e-12));
    assert_eq!(proxy.mode_count(), baked.modes.len());
    assert!((proxy.scale() / size - 1.0).abs() < 1e-9);
    let mut worst =
        Difference { frequency: (proxy.radius() / baked.radius - 1.0).abs(), ..Difference::default() };
    for (k, mode) in baked.modes.iter().enumerate() {
        worst.frequency = worst.frequency.max((proxy.frequency(k) / mode.frequency - 1.0).abs());
        worst.shape = worst.shape.max(shape_error(&proxy, k, &baked));
        let (own, scaled) = (mode.transfer.as_ref().expect("a transfer"), proxy.transfer(k));
        let largest = own.coefficients.iter().map(|c| c.norm()).fold(0.0, f64::max);
        for at in 0..own.coefficients.len().max(scaled.coefficients.len()) {
            let of = |c: &[num_complex::Complex64]| c.get(at).copied().unwrap_or_default();
            let apart = (of(&own.coefficients) - of(&scaled.coefficients)).norm();
            worst.transfer = worst.transfer.max(apart / largest);
        }
    }
    worst
}

/// Largest relative differences of all modes.
#[derive(Debug, Default)]
struct Difference {
    frequency: f64,
    shape: f64,
    transfer: f64,
}

/// Largest difference of a shape over its largest motion.
fn shape_error(proxy: &ModalProxy, mode: usize, baked: &ModalModel) -> f64 {
    let (mut harmonics, mut motions) = (Vec::new(), Vec::new());
    let shape = &baked.modes[mode].shape;
    let largest = shape.iter().map(|u| u.length()).fold(0.0, f64::max);
    let error = |(x, u): (&DVec3, &DVec3)| {
        let direction = proxy.contact(
            *x,
            *x,
            clangor_core::sound_model::soundbank::modal_soundbank::ContactMapping::Position,
        );
        proxy.motions(direction, &mut harmonics, &mut motions);
        motions[mode].distance(*u) / largest
    };
    baked.surface.nodes.iter().zip(shape).step_by(7).map(error).fold(0.0, f64::max)
}

/// Modes of a pair of an axisymmetric ellipsoid have different parities, and are sorted by them.
#[test]
fn a_round_ellipsoid_of_another_size_is_the_scaled_one() {
    let worst = scaled_against_baked(DVec3::new(0.25, 1.0, 1.0), 2.5, 0.031);
    println!("round: {worst:?}");
    // 2e-15, 2e-12 and 2e-8 seen.
    assert!(worst.frequency < 1e-4 && worst.shape < 1e-4 && worst.transfer < 1e-4, "{worst:?}");
}

#[test]
fn a_triaxial_ellipsoid_of_another_size_is_the_scaled_one() {
    let worst = scaled_against_baked(DVec3::new(0.35, 0.6, 1.0), 1.5, 0.07);
    println!("triaxial: {worst:?}");
    // 2e-15, 9e-14 and 1e-13 seen; 2e-3 for the last where each size has triangles of its own.
    assert!(worst.frequency < 1e-4 && worst.shape < 1e-4 && worst.transfer < 1e-4, "{worst:?}");
}

/// The bank's ellipsoid, of polynomials and rotated, against an independent method: the section, in the
/// body's own frame.
#[test]
fn a_scaled_ellipsoid_is_the_body_baked_by_itself() {
    let polynomials = BallPolynomials::new(DEGREE);
    let (thin, size) = (0.25, 0.04);
    let bank = bank(&polynomials, DVec3::new(thin, 1.0, 1.0).normalize(), 3.0);
    let glass = GLASS.material();
    let semi_axes = size * DVec3::new(1.0, thin, 1.0);
    let geometry = BakeGeometry::Ellipsoid { semi_axes };
    let norm = semi_axes.length();
    let limit = 0.999 * bank.entries()[0].max_frequency / norm;
    let options = ModalBakeOptions {
        max_frequency: limit,
        mesh_error: 1e-3,
        accuracy: 0.01,
        ..ModalBakeOptions::new(Medium::AIR)
    };
    let (mut own, _) =
        find_modes(&geometry, &glass, &options, &mut |_| ControlFlow::Continue(())).expect("modes");
    radiated(&geometry, &mut own, &options);
    let volume = 4.0 / 3.0 * PI * semi_axes.element_product();
    let proxy = bank
        .proxy_for(&ProxyBody {
            inertia: inertia(semi_axes),
            mass: glass.density * volume,
            first_frequency: own.modes[0].frequency,
            material: *bank.material(),
            max_frequency: limit,
        })
        .expect("a proxy");
    assert_eq!(proxy.mode_count(), own.modes.len());
    // Degenerate pairs have many bases, so the sum over modes of one frequency is compared, at places around
    // the body.
    let mut at = 0;
    while at < own.modes.len() {
        let f = own.modes[at].frequency;
        let end = at + own.modes[at..].iter().take_while(|m| m.frequency < 1.001 * f).count();
        let (mut loud, mut error, mut pushed, mut push_error) = (0.0_f64, 0.0_f64, 0.0_f64, 0.0_f64);
        for x in [DVec3::new(0.3, 0.5, 0.8), DVec3::new(-1.0, 0.1, 0.4), DVec3::new(0.1, -1.3, -0.2)] {
            let x = 1.7 * x.normalize();
            let square = |of: &dyn Fn(usize) -> f64| (at..end).map(of).sum::<f64>();
            let kappa = TAU * f * own.radius / Medium::AIR.sound_speed;
            let by_own =
                square(&|k| own.modes[k].transfer.as_ref().map_or(0.0, |t| t.undelayed(x, kappa).norm_sqr()));
            let rotated = proxy.rotation() * x;
            let by_proxy = square(&|k| proxy.transfer(k).undelayed(rotated, kappa).norm_sqr());
            loud = loud.max(by_own.sqrt());
            error = error.max((by_own.sqrt() - by_proxy.sqrt()).abs());
            // The normal motion at a point of the surface.
            let place = semi_axes * x.normalize();
            let locator = clangor_core::sound_model::modal::surface::SurfaceLocator::new(&own.surface);
            let point = locator.nearest(place).expect("a place");
            let by_own = square(&|k| point.interpolate(&own.modes[k].shape).length_squared());
            let (mut harmonics, mut motions) = (Vec::new(), Vec::new());
            let mapping = clangor_core::sound_model::soundbank::modal_soundbank::ContactMapping::Position;
            proxy.motions(proxy.contact(place, DVec3::ZERO, mapping), &mut harmonics, &mut motions);
            let by_proxy = square(&|k| motions[k].length_squared());
            pushed = pushed.max(by_own.sqrt());
            push_error = push_error.max((by_own.sqrt() - by_proxy.sqrt()).abs());
        }
        let frequency = (proxy.frequency(at) / f - 1.0).abs();
        let (error, push_error) = (error / loud, push_error / pushed);
        println!(
            "{f:.1} Hz, {} modes: frequency {frequency:.1e}, field {error:.1e}, shape {push_error:.1e}",
            end - at
        );
        // Residuals seen: see docs/theory/modal_soundbank.md.
        assert!(frequency < 2e-3 && error < 0.02 && push_error < 0.01, "mode {at}");
        at = end;
    }
}

/// Error for a similar material: ceramic from the bank of glass, whose kR is 5.7 % lower.
#[test]
fn ceramic_by_the_bank_of_glass() {
    let polynomials = BallPolynomials::new(DEGREE);
    let axes = DVec3::new(0.25, 1.0, 1.0).normalize();
    let (bank, ceramic) = (bank(&polynomials, axes, 3.0), material(&CERAMIC.material()));
    let size = 0.05;
    let limit = 0.98 * bank.entries()[0].max_frequency / size * ceramic.speed() / bank.material().speed();
    let mut baked = modal_model(&polynomials, size * axes, &ceramic, limit).model;
    let options =
        ModalBakeOptions { max_frequency: limit, accuracy: 0.05, ..ModalBakeOptions::new(Medium::AIR) };
    radiated(&BakeGeometry::Ellipsoid { semi_axes: size * axes }, &mut baked, &options);
    let proxy = bank
        .proxy_for(&ProxyBody {
            inertia: inertia(axes),
            mass: 1.0,
            first_frequency: baked.modes[0].frequency,
            material: ceramic,
            max_frequency: limit,
        })
        .expect("a proxy");
    let (mut frequency, mut level) = (0.0_f64, 0.0_f64);
    for (k, mode) in baked.modes.iter().enumerate().take(proxy.mode_count()) {
        let kappa = TAU * mode.frequency * baked.radius / Medium::AIR.sound_speed;
        let own = mode.transfer.as_ref().expect("a transfer").power(kappa);
        level = level.max((10.0 * (proxy.transfer(k).power(kappa) / own).log10()).abs());
        frequency = frequency.max((proxy.frequency(k) / mode.frequency - 1.0).abs());
    }
    println!("ceramic by glass: frequencies {frequency:.1e}, power {level:.2} dB");
    assert!(frequency < 0.01 && level < 2.0, "{frequency} {level}");
}
