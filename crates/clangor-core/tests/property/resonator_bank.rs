//! The modal soundbank of ellipsoids: choice of the proxy of a body, its scale and rotation, contact points,
//! and its file.

use std::f64::consts::{PI, TAU};

use crate::damage::{TENSOR_WORDS, forged};
use crate::fuzzing::{Target, fuzz};
use clangor_core::math::spherical_harmonics::{index, solid_harmonics};
use clangor_core::medium::Medium;
use clangor_core::sound_model::files::modal_soundbank_file::{ModalSoundbankFile, ModalSoundbankOrigin};
use clangor_core::sound_model::files::tensor_file::TensorFileError;
use clangor_core::sound_model::soundbank::modal_soundbank::{
    BankMaterial, ContactMapping, EllipsoidMode, ModalProxyError, ModalSoundbank, ModalSoundbankError,
    ProxyBody, RingingEllipsoid, normalised_ellipsoid, parity_harmonics,
};
use glam::{DMat3, DQuat, DVec3, Vec3Swizzles};
use num_complex::Complex64;

const DEGREE: usize = 3;

const GLASS: BankMaterial =
    BankMaterial { youngs_modulus: 6.2e10, density: 2600.0, poisson_ratio: 0.2, medium: Medium::AIR };

/// A mode of any numbers.
fn mode(frequency: f64, parity: u8, order: usize) -> EllipsoidMode {
    let number = |i: usize, seed: f64| (1.7 * i as f64 + seed + frequency).sin();
    let shape = [0, 1, 2].map(|axis| {
        let length = parity_harmonics(parity ^ (1 << axis), DEGREE).len();
        (0..length).map(|i| number(i, axis as f64)).collect()
    });
    let length = parity_harmonics(parity, order).len();
    let transfer = (0..length).map(|i| Complex64::new(number(i, 0.4), number(i, 2.1))).collect();
    EllipsoidMode { frequency, parity, shape, order, transfer }
}

fn entry(a: f64, b: f64, c: f64) -> RingingEllipsoid {
    let semi_axes = DVec3::new(a, b, c).normalize();
    let modes = (0..8).map(|k| mode(1000.0 * a * f64::from(k + 2), k as u8, 5 + k as usize)).collect();
    RingingEllipsoid { semi_axes, max_frequency: 9500.0 * a, modes }
}

fn bank() -> ModalSoundbank {
    let entries = vec![
        entry(0.05, 1.0, 1.0),
        entry(0.1, 0.1, 1.0),
        entry(0.2, 0.6, 1.0),
        entry(0.5, 0.7, 1.0),
        entry(1.0, 1.0, 1.0),
    ];
    ModalSoundbank::try_new(GLASS, DEGREE, entries).expect("a bank")
}

/// Of a solid ellipsoid of mass 1.
fn inertia(axes: DVec3) -> DMat3 {
    let square = axes * axes;
    DMat3::from_diagonal((DVec3::splat(square.element_sum()) - square) / 5.0)
}

fn volume(axes: DVec3) -> f64 {
    4.0 / 3.0 * PI * axes.element_product()
}

fn body(axes: DVec3, turn: DMat3) -> ProxyBody {
    ProxyBody {
        inertia: turn * inertia(axes) * turn.transpose(),
        mass: 0.1,
        first_frequency: 3000.0,
        material: GLASS,
        max_frequency: 20_000.0,
    }
}

#[test]
fn an_ellipsoid_finds_itself_however_it_is_turned() {
    let bank = bank();
    let turn = DMat3::from_quat(DQuat::from_scaled_axis(DVec3::new(0.4, -1.3, 0.8)));
    for (at, entry) in bank.entries().iter().enumerate() {
        for axes in [entry.semi_axes, entry.semi_axes.yzx(), entry.semi_axes.zxy()] {
            let body = body(0.013 * axes, turn);
            let (found, rotation) = normalised_ellipsoid(body.inertia).expect("an ellipsoid");
            // Residual seen: 3e-16; 2e-8 for equal axes, where the moments are close to each other.
            assert!((found - entry.semi_axes).length() < 1e-7, "{found} {}", entry.semi_axes);
            assert!((rotation.determinant() - 1.0).abs() < 1e-12);
            let proxy = bank.proxy_for(&body).expect("a proxy");
            assert_eq!(proxy.entry(), at);
            // In its frame the inertia is diagonal, and the least moment is about z.
            let turned = rotation * body.inertia * rotation.transpose();
            let moments = DVec3::new(turned.x_axis.x, turned.y_axis.y, turned.z_axis.z);
            assert!(moments.x >= moments.y - 1e-15 && moments.y >= moments.z - 1e-15, "{moments}");
            assert!((turned - DMat3::from_diagonal(moments)).to_cols_array().iter().all(|x| x.abs() < 1e-15));
        }
    }
}

#[test]
fn base_frequencies_agree_and_the_rest_follows_eq_9() {
    let bank = bank();
    let axes = bank.entries()[2].semi_axes;
    let proxy = bank.proxy_for(&body(axes, DMat3::IDENTITY)).expect("a proxy");
    let own = &bank.entries()[2];
    let gamma = own.modes[0].frequency / 3000.0;
    // Residuals seen: 2e-16.
    assert!((proxy.frequency(0) / 3000.0 - 1.0).abs() < 1e-14);
    assert!((proxy.scale() / gamma - 1.0).abs() < 1e-14);
    assert!((proxy.radius() / (gamma * axes.z) - 1.0).abs() < 1e-14);
    assert!(proxy.mode_count() == 8 && (proxy.complete_below() / (9500.0 * 0.2 / gamma) - 1.0).abs() < 1e-14);
    let (mut harmonics, mut motions) = (Vec::new(), Vec::new());
    proxy.motions(DVec3::new(0.3, -0.5, 0.8).normalize(), &mut harmonics, &mut motions);
    for (k, mode) in own.modes.iter().enumerate() {
        assert!((proxy.frequency(k) / (mode.frequency / gamma) - 1.0).abs() < 1e-14);
        let transfer = proxy.transfer(k);
        let sum: f64 = transfer.coefficients.iter().map(|c| c.norm_sqr()).sum();
        let before: f64 = mode.transfer.iter().map(|c| c.norm_sqr()).sum();
        assert!(((sum / before).sqrt() / gamma.powf(-1.5) - 1.0).abs() < 1e-13);
        let bare = DVec3::from_array([0, 1, 2].map(|axis| {
            let list = parity_harmonics(mode.parity ^ (1 << axis), DEGREE);
            list.iter().zip(&mode.shape[axis]).map(|(y, u)| harmonics[*y as usize] * u).sum()
        }));
        let of_mass = (GLASS.density * volume(axes) / 0.1).sqrt();
        assert!((motions[k] - of_mass * bare).length() < 1e-12 * bare.length());
    }
    // The entry itself at another size: γ^−3/2 for both.
    let mass = GLASS.density * gamma.powi(3) * volume(axes);
    let scaled = bank.proxy_for(&ProxyBody { mass, ..body(axes, DMat3::IDENTITY) }).expect("a proxy");
    let mut of_scaled = Vec::new();
    scaled.motions(DVec3::new(0.3, -0.5, 0.8).normalize(), &mut harmonics, &mut of_scaled);
    for (own, scaled) in motions.iter().zip(&of_scaled) {
        let factor = gamma.powf(-1.5) / (GLASS.density * volume(axes) / 0.1).sqrt();
        assert!((*scaled - factor * *own).length() < 1e-12 * scaled.length());
    }
    // A narrower band has fewer modes.
    let narrow = ProxyBody { max_frequency: 5000.0, ..body(axes, DMat3::IDENTITY) };
    assert_eq!(bank.proxy_for(&narrow).expect("a proxy").mode_count(), 2);
}

#[test]
fn another_material_is_scaled_by_its_speed_and_density() {
    let bank = bank();
    let mut ceramic = body(bank.entries()[3].semi_axes, DMat3::IDENTITY);
    ceramic.material = BankMaterial { youngs_modulus: 7.2e10, density: 2700.0, poisson_ratio: 0.19, ..GLASS };
    let proxy = bank.proxy_for(&ceramic).expect("a proxy");
    let speed = ceramic.material.speed() / GLASS.speed();
    let gamma = speed * bank.entries()[3].modes[0].frequency / 3000.0;
    assert!((proxy.frequency(0) / 3000.0 - 1.0).abs() < 1e-14 && (proxy.scale() / gamma - 1.0).abs() < 1e-14);
    // ∫ ρ U² dV = 1: the mass of the proxy is that of its own material.
    let before: f64 = bank.entries()[3].modes[1].transfer.iter().map(|c| c.norm_sqr()).sum();
    let sum: f64 = proxy.transfer(1).coefficients.iter().map(|c| c.norm_sqr()).sum();
    let factor = gamma.powf(-1.5) * (2600.0_f64 / 2700.0).sqrt();
    assert!(((sum / before).sqrt() / factor - 1.0).abs() < 1e-13);
    for material in [
        BankMaterial { youngs_modulus: 3.0e9, density: 1200.0, ..GLASS },
        BankMaterial { poisson_ratio: 0.35, ..GLASS },
        BankMaterial { medium: Medium { sound_speed: 1480.0, density: 1000.0 }, ..GLASS },
    ] {
        let other = ProxyBody { material, ..ceramic };
        assert!(matches!(bank.proxy_for(&other), Err(ModalProxyError::Material { .. })), "{material:?}");
    }
}

#[test]
fn a_contact_is_where_the_normal_is_the_same() {
    let bank = bank();
    let turn = DMat3::from_quat(DQuat::from_scaled_axis(DVec3::new(-0.7, 0.2, 1.1)));
    let axes = 0.05 * bank.entries()[2].semi_axes;
    let proxy = bank.proxy_for(&body(axes, turn)).expect("a proxy");
    for normal in [DVec3::new(0.3, -0.5, 0.81), DVec3::new(-1.0, 0.01, 0.2), DVec3::new(0.0, 0.0, 2.5)] {
        let direction = proxy.contact(DVec3::ZERO, normal, ContactMapping::Normal);
        let point = proxy.surface_point(direction);
        let semi = proxy.semi_axes();
        // On the surface, and ∇g along R n.
        assert!(((point / semi).length() - 1.0).abs() < 1e-14);
        let gradient = (point / (semi * semi)).normalize();
        assert!((gradient - proxy.rotation() * normal.normalize()).length() < 1e-12);
        // [FRAC] eq. (24).
        let n = proxy.rotation() * normal.normalize();
        let square = (semi * semi * n * n).element_sum().sqrt();
        assert!((point - semi * semi * n / square).length() < 1e-15);
    }
    // A point of the surface of the ellipsoid that the body is goes to itself, by either.
    let own = proxy.scale() / 0.05;
    for xi in [DVec3::new(0.6, 0.0, 0.8), DVec3::new(-0.36, 0.48, -0.8)] {
        let place = proxy.rotation().transpose() * (axes * xi);
        let normal = proxy.rotation().transpose() * (xi / axes);
        for mapping in [ContactMapping::Normal, ContactMapping::Position] {
            let direction = proxy.contact(place, normal, mapping);
            let point = proxy.surface_point(direction);
            assert!((direction - xi).length() < 1e-12, "{mapping:?} {direction} {xi}");
            assert!((point - own * axes * xi).length() < 1e-14);
        }
    }
    // A ball: along the normal.
    let ball = bank.proxy_for(&body(DVec3::splat(0.02), DMat3::IDENTITY)).expect("a proxy");
    let normal = DVec3::new(0.48, 0.6, -0.64);
    let direction = ball.rotation().transpose() * ball.contact(DVec3::ZERO, normal, ContactMapping::Normal);
    assert!((direction - normal).length() < 1e-12);
}

#[test]
fn motions_have_the_parities_of_their_modes() {
    let bank = bank();
    let proxy = bank.proxy_for(&body(bank.entries()[1].semi_axes, DMat3::IDENTITY)).expect("a proxy");
    let at = |direction: DVec3| {
        let (mut harmonics, mut motions) = (Vec::new(), Vec::new());
        proxy.motions(direction, &mut harmonics, &mut motions);
        motions
    };
    let xi = DVec3::new(0.48, -0.6, 0.64);
    for axis in 0..3 {
        let mut mirror = DVec3::ONE;
        mirror[axis] = -1.0;
        for (k, (there, here)) in at(mirror * xi).into_iter().zip(at(xi)).enumerate() {
            let odd = bank.entries()[1].modes[k].parity >> axis & 1 == 1;
            // A reflection takes the motion to plus or minus its mirror image.
            let image = if odd { -mirror * here } else { mirror * here };
            assert!((there - image).length() < 1e-12 * here.length(), "mode {k}, axis {axis}");
        }
    }
    // And every harmonic is in one list.
    let mut all: Vec<u32> = (0..8).flat_map(|parity| parity_harmonics(parity, 6)).collect();
    all.sort_unstable();
    assert_eq!(all, (0..49).collect::<Vec<u32>>());
    let mut values = Vec::new();
    solid_harmonics(xi, 6, &mut values);
    let mut mirrored = Vec::new();
    solid_harmonics(DVec3::new(-1.0, 1.0, 1.0) * xi, 6, &mut mirrored);
    for (n, m) in [(3, -2), (4, 1), (6, -5), (2, 0)] {
        let at = index(n, m) as u32;
        let odd = (0..8).find(|p| parity_harmonics(*p, 6).contains(&at)).is_some_and(|p| p & 1 == 1);
        let sign = if odd { -1.0 } else { 1.0 };
        assert!((mirrored[at as usize] - sign * values[at as usize]).abs() < 1e-14);
    }
}

#[test]
fn what_no_body_has_is_refused_and_a_flat_one_is_clamped() {
    let bank = bank();
    let good = body(DVec3::new(0.01, 0.02, 0.03), DMat3::IDENTITY);
    assert!(bank.proxy_for(&good).is_ok());
    for bad in [
        ProxyBody { first_frequency: 0.0, ..good },
        ProxyBody { first_frequency: f64::NAN, ..good },
        ProxyBody { mass: -1.0, ..good },
        ProxyBody { max_frequency: f64::INFINITY, ..good },
    ] {
        assert!(matches!(bank.proxy_for(&bad), Err(ModalProxyError::Body { .. })), "{bad:?}");
    }
    for inertia in [DMat3::ZERO, f64::NAN * good.inertia] {
        let bad = ProxyBody { inertia, ..good };
        assert!(matches!(bank.proxy_for(&bad), Err(ModalProxyError::Inertia)));
    }
    let flat = DMat3::from_diagonal(DVec3::new(1.0, 1.0, 2.5));
    let (axes, _) = normalised_ellipsoid(flat).expect("a disc");
    assert!(axes.is_finite() && axes.x > 0.0 && (axes.y - axes.z).abs() < 1e-9, "{axes}");
    assert!(matches!(ModalSoundbank::try_new(GLASS, DEGREE, Vec::new()), Err(ModalSoundbankError::Empty)));
    let mut wrong = entry(0.2, 0.6, 1.0);
    wrong.semi_axes = DVec3::new(0.6, 0.0, 0.8);
    let made = ModalSoundbank::try_new(GLASS, DEGREE, vec![entry(1.0, 1.0, 1.0), wrong]);
    assert!(matches!(made, Err(ModalSoundbankError::Axes { index: 1, .. })));
    let mut wrong = entry(0.2, 0.6, 1.0);
    wrong.modes[2].shape[1].pop();
    let made = ModalSoundbank::try_new(GLASS, DEGREE, vec![wrong]);
    assert!(matches!(made, Err(ModalSoundbankError::Mode { index: 0, mode: 2, .. })));
}

fn file() -> ModalSoundbankFile {
    let origin = ModalSoundbankOrigin {
        program: "clangor".into(),
        inputs: "00".into(),
        material: "glass".into(),
        asked_accuracy: 0.03,
        spacing: 0.6,
        least_first_frequency: 1000.0,
        largest_size: 0.12,
        max_frequency: 20_000.0,
    };
    ModalSoundbankFile { bank: bank(), origin }
}

#[test]
fn a_file_holds_what_it_was_given() {
    let bytes = file().encode().expect("bytes");
    let read = ModalSoundbankFile::decode(&bytes).expect("a bank");
    assert_eq!((read.bank.material(), read.bank.degree()), (&GLASS, DEGREE));
    assert_eq!(read.origin, file().origin);
    for (read, given) in read.bank.entries().iter().zip(bank().entries()) {
        assert_eq!((read.semi_axes, read.max_frequency), (given.semi_axes, given.max_frequency));
        for (read, given) in read.modes.iter().zip(&given.modes) {
            assert_eq!(
                (read.frequency, read.parity, read.order),
                (given.frequency, given.parity, given.order)
            );
            let pairs = read.shape.iter().flatten().zip(given.shape.iter().flatten());
            // Half of a step, with numbers up to 1.
            assert!(pairs.into_iter().all(|(r, g)| (r - g).abs() <= 0.51 / 32767.0));
            let pairs = read.transfer.iter().zip(&given.transfer);
            assert!(pairs.into_iter().all(|(r, g)| (r - g).norm() <= 0.73 / 32767.0));
        }
    }
    // A file that was read is written with the same bytes.
    assert_eq!(read.encode().expect("bytes"), bytes);
}

#[test]
fn a_damaged_file_is_refused() {
    let bytes = file().encode().expect("bytes");
    for at in [10, bytes.len() / 2, bytes.len() - 1] {
        let mut damaged = bytes.clone();
        damaged[at] ^= 4;
        assert!(ModalSoundbankFile::decode(&damaged).is_err(), "byte {at}");
    }
    assert!(ModalSoundbankFile::decode(&bytes[..bytes.len() - 7]).is_err());
    assert!(ModalSoundbankFile::decode(b"").is_err());
    let other = clangor_core::sound_model::files::ellipsoid_bank_file::BankFile::decode(&bytes);
    assert!(matches!(other, Err(TensorFileError::Kind { .. })), "{other:?}");
}

/// A proxy is played through a source: an impact, a direction, and what the model defines.
#[test]
fn a_source_plays_the_proxy_in_the_frame_of_the_body() {
    use clangor_core::material::Damping;
    use clangor_core::synthesis::modal::{ModalSettings, ModalSource, StrikeMemory, TransferMemory};

    let bank = bank();
    let turn = DMat3::from_quat(DQuat::from_scaled_axis(DVec3::new(0.9, 0.1, -0.4)));
    let proxy = bank.proxy_for(&body(0.03 * bank.entries()[2].semi_axes, turn)).expect("a proxy");
    let transfers: Vec<_> = (0..proxy.mode_count()).map(|k| proxy.transfer(k)).collect();
    let source = |mapping| {
        let damping = Damping::LossFactor(1e-3);
        ModalSource::of_proxy(proxy.clone(), mapping, &transfers, &damping, &ModalSettings::default())
            .expect("a source")
    };
    let source = source(ContactMapping::Normal);
    let (impulse, listener) = (DVec3::new(0.01, -0.02, 0.005), DVec3::new(0.4, 1.0, -0.3));
    let mut amplitudes = Vec::new();
    source.amplitudes(
        &[(DVec3::new(0.01, 0.0, 0.0), impulse)],
        &mut StrikeMemory::default(),
        &mut amplitudes,
    );
    let (mut harmonics, mut motions) = (Vec::new(), Vec::new());
    let place = proxy.contact(DVec3::ZERO, -impulse, ContactMapping::Normal);
    proxy.motions(place, &mut harmonics, &mut motions);
    let mut values = Vec::new();
    source.transfers(listener, &mut TransferMemory::default(), &mut values);
    for (k, motion) in motions.iter().enumerate() {
        let expected = motion.dot(proxy.rotation() * impulse);
        assert!((amplitudes[k] - expected).abs() <= 1e-12 * motion.length() * impulse.length());
        let kappa = TAU * proxy.frequency(k) * proxy.radius() / GLASS.medium.sound_speed;
        let at = proxy.rotation() * listener / proxy.radius();
        let expected = GLASS.medium.density * proxy.radius() * transfers[k].undelayed(at, kappa);
        // Residual seen: 3e-14.
        assert!((values[k] - expected).norm() < 1e-11 * expected.norm(), "{} {expected}", values[k]);
    }
    assert!(source.resonances().iter().all(|r| r.damping_ratio > 0.5e-3));
}

#[test]
fn fuzz_modal_banks() {
    let mut target =
        Target::parser("modal-banks", "safetensors", vec![file().encode().unwrap()], &TENSOR_WORDS);
    target.mend = &forged;
    fuzz(&target, &|_, bytes| match ModalSoundbankFile::decode(bytes) {
        Err(error) => error.to_string(),
        Ok(file) => format!("a bank of {}", file.bank.entries().len()),
    });
}
