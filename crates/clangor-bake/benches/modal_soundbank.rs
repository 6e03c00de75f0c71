//! The modal bank: its samples, an entry, and the modes of an ellipsoid compared with the entry of the same
//! proportions and with the nearest entry of a bank, stage by stage.
//!
//! `cargo bench -p clangor-bake --bench modal_soundbank -- samples [SPACING] [THINNEST]` | `-- entry A B C
//! [ACCURACY]` | `-- build BANK.safetensors` | `-- beside BANK.safetensors A B C [m]`; of fragments: the
//! program `piece_proxies` of `clangor-validation`

use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow;
use std::sync::Arc;

use clangor_bake::geometry_class::bake_geometry::BakeGeometry;
use clangor_bake::modal::{ModalBakeOptions, find_modes, radiate};
use clangor_bake::soundbank::modal::ellipsoid_modes::BallPolynomials;
use clangor_bake::soundbank::modal::{ModalSoundbankOptions, build_bank, ringing_ellipsoid, sampling};
use clangor_core::material::Material;
use clangor_core::material::presets::GLASS;
use clangor_core::math::random::SplitMix;
use clangor_core::medium::Medium;
use clangor_core::sound_model::files::modal_soundbank_file::{ModalSoundbankFile, ModalSoundbankOrigin};
use clangor_core::sound_model::soundbank::modal_soundbank::{
    BankMaterial, ContactMapping, ModalSoundbank, ProxyBody,
};
use clangor_core::synthesis::modal::{ModalSettings, ModalSource, StrikeMemory, TransferMemory};
use glam::{DMat3, DVec3};

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    let number = |i: usize, default: f64| arguments.get(i).and_then(|a| a.parse().ok()).unwrap_or(default);
    let mut options = ModalSoundbankOptions::new(glass());
    match arguments.first().map(String::as_str) {
        Some("samples") => {
            options.spacing = number(1, options.spacing);
            options.thinnest = number(2, options.thinnest);
            samples(&options);
        }
        Some("entry") => {
            let axes = DVec3::new(number(1, 0.1), number(2, 1.0), number(3, 1.0)).normalize();
            options.accuracy = number(4, options.accuracy);
            entry(axes, &options);
        }
        Some("build") => build(&arguments[1], &options),
        Some("beside") => {
            let bytes = std::fs::read(&arguments[1]).expect("a bank");
            let bank = ModalSoundbankFile::decode(&bytes).expect("a bank").bank;
            beside(&bank, DVec3::new(number(2, 0.05), number(3, 0.006), number(4, 0.05)), &options);
        }
        _ => println!("samples | entry | build | beside"),
    }
}

fn glass() -> BankMaterial {
    let Material { youngs_modulus, density, poisson_ratio, .. } = GLASS.material();
    BankMaterial { youngs_modulus, density, poisson_ratio, medium: Medium::AIR }
}

fn samples(options: &ModalSoundbankOptions) {
    let start = seconds();
    let polynomials = BallPolynomials::new(options.degree);
    println!("integrals: {:.2} CPU-s", seconds() - start);
    let samples = sampling::samples(&polynomials, options).expect("samples");
    println!("{} samples, {:.2} CPU-s", samples.len(), seconds() - start);
    for axes in &samples {
        println!("a/c {:.3} b/c {:.3}", axes.x / axes.z, axes.y / axes.z);
    }
}

fn build(path: &str, options: &ModalSoundbankOptions) {
    let start = seconds();
    let mut done = 0;
    let bank = build_bank(options, &mut |part| {
        if (20.0 * part) as u32 > done {
            done = (20.0 * part) as u32;
            eprintln!("{:.0} %, {:.0} CPU-s", 100.0 * part, seconds() - start);
        }
        ControlFlow::Continue(())
    });
    let origin = ModalSoundbankOrigin {
        program: "bench".into(),
        inputs: String::new(),
        material: "glass".into(),
        asked_accuracy: options.accuracy,
        spacing: options.spacing,
        least_first_frequency: options.least_first_frequency,
        largest_size: options.largest_size,
        max_frequency: options.max_frequency,
    };
    let bytes = ModalSoundbankFile { bank: bank.expect("a bank"), origin }.encode().expect("a file");
    std::fs::write(path, &bytes).expect("a folder to write to");
    println!("{:.0} CPU-s, {:.3} MB", seconds() - start, 1e-6 * bytes.len() as f64);
}

fn entry(axes: DVec3, options: &ModalSoundbankOptions) {
    let (polynomials, start) = (BallPolynomials::new(options.degree), seconds());
    let entry = ringing_ellipsoid(&polynomials, axes, options, &mut |_| ControlFlow::Continue(()));
    let entry = entry.expect("an ellipsoid");
    let (count, limit) = (entry.modes.len(), entry.max_frequency);
    println!("{axes}: {count} modes to {limit:.1} Hz, {:.2} CPU-s", seconds() - start);
    for mode in &entry.modes {
        let size = mode.transfer.iter().map(|c| c.norm_sqr()).sum::<f64>().sqrt();
        println!("{:9.2} Hz {:03b} order {} {size:.4e}", mode.frequency, mode.parity, mode.order);
    }
}

/// Third octaves from 2 kHz to 20 kHz.
const BANDS: usize = 11;
/// Lowest centre \[Hz\].
const LOWEST: f64 = 2_000.0;

/// Statistics of modes under impacts at random places of an ellipsoid, along its normal, and random
/// directions: in each third octave their number, Σ (U·n)², Σ |H|² and Σ (ω U·n |H|)²/4ξω.
fn stages(source: &ModalSource, semi_axes: DVec3) -> [[f64; 4]; BANDS] {
    let mut sums = [[0.0; 4]; BANDS];
    let mut random = SplitMix::new(1);
    let (mut amplitudes, mut transfers) = (Vec::new(), Vec::new());
    const IMPACTS: u32 = 60;
    for _ in 0..IMPACTS {
        let direction = random.direction();
        let normal = (direction / semi_axes).normalize();
        source.amplitudes(&[(semi_axes * direction, -normal)], &mut StrikeMemory::default(), &mut amplitudes);
        source.transfers(2.0 * random.direction(), &mut TransferMemory::default(), &mut transfers);
        for ((amplitude, transfer), resonance) in amplitudes.iter().zip(&transfers).zip(source.resonances()) {
            let band = (3.0 * (resonance.frequency / LOWEST).log2() + 0.5).floor();
            if (0.0..BANDS as f64).contains(&band) {
                let omega = TAU * resonance.frequency;
                let heard =
                    (omega * amplitude * transfer.norm()).powi(2) / (4.0 * resonance.damping_ratio * omega);
                let own = [1.0, amplitude.powi(2), transfer.norm_sqr(), heard];
                sums[band as usize].iter_mut().zip(own).for_each(|(s, x)| *s += x / f64::from(IMPACTS));
            }
        }
    }
    sums
}

/// Compares a body's own modes, the entry of the same proportions, and the nearest entry of a bank.
fn beside(bank: &ModalSoundbank, semi_axes: DVec3, options: &ModalSoundbankOptions) {
    let material = GLASS.material();
    let bake = ModalBakeOptions { mesh_error: 0.005, accuracy: 0.03, ..ModalBakeOptions::new(Medium::AIR) };
    let geometry = BakeGeometry::Ellipsoid { semi_axes };
    let (mut model, mut evidence) =
        find_modes(&geometry, &material, &bake, &mut |_| ControlFlow::Continue(())).expect("modes");
    radiate(&geometry, &mut model, &mut evidence, &bake, &mut |_| ControlFlow::Continue(()))
        .expect("transfers");
    let (first, frequencies) =
        (model.modes[0].frequency, model.modes.iter().map(|m| m.frequency).collect::<Vec<_>>());
    let own =
        ModalSource::new(Arc::new(model), &material.damping, &ModalSettings::default()).expect("a source");
    let square = semi_axes * semi_axes;
    let mass = 4.0 / 3.0 * PI * semi_axes.element_product() * material.density;
    let body = ProxyBody {
        inertia: DMat3::from_diagonal((DVec3::splat(square.element_sum()) - square) * mass / 5.0),
        mass,
        first_frequency: first,
        material: *bank.material(),
        max_frequency: 20_000.0,
    };
    let mut sorted = (semi_axes / semi_axes.length()).to_array();
    sorted.sort_by(f64::total_cmp);
    let polynomials = BallPolynomials::new(options.degree);
    let entry = ringing_ellipsoid(&polynomials, DVec3::from_array(sorted), options, &mut |_| {
        ControlFlow::Continue(())
    });
    let alone = ModalSoundbank::try_new(options.material, options.degree, vec![entry.expect("an ellipsoid")]);
    let proxies = [alone.expect("a bank"), bank.clone()].map(|bank| bank.proxy_for(&body).expect("a proxy"));
    for (name, proxy) in ["own proportions", "bank"].iter().zip(&proxies) {
        let mass_ratio = 4.0 / 3.0 * PI * proxy.semi_axes().element_product() * material.density / mass;
        println!(
            "{name}: semi-axes {:.4} m of {:.4}, mass × {mass_ratio:.3}",
            proxy.semi_axes(),
            DVec3::from_array(sorted) * semi_axes.length()
        );
        let modes = proxy.mode_count().min(frequencies.len()).min(12);
        let ratios: Vec<String> =
            (0..modes).map(|k| format!("{:.4}", proxy.frequency(k) / frequencies[k])).collect();
        println!("  frequencies over the body's own: {}", ratios.join(" "));
    }
    let sources = proxies.map(|proxy| {
        let transfers: Vec<_> = (0..proxy.mode_count()).map(|k| proxy.transfer(k)).collect();
        ModalSource::of_proxy(
            proxy,
            ContactMapping::Position,
            &transfers,
            &material.damping,
            &ModalSettings::default(),
        )
        .expect("a source")
    });
    let [own, alone, near] = [&own, &sources[0], &sources[1]].map(|source| stages(source, semi_axes));
    println!(
        "third octave: modes own/entry/bank; entry, bank over own [dB]: drive, transfer, heard; \
         own of the loudest"
    );
    let loudest = own.iter().map(|b| b[3]).fold(0.0, f64::max);
    for band in 0..BANDS {
        let level = |of: &[[f64; 4]; BANDS], k: usize| 10.0 * (of[band][k] / own[band][k]).log10();
        print!(
            "{:6.0} Hz {:3.0}/{:3.0}/{:3.0}",
            LOWEST * 2.0_f64.powf(band as f64 / 3.0),
            own[band][0],
            alone[band][0],
            near[band][0]
        );
        for k in 1..4 {
            print!("  {:+6.2} {:+6.2}", level(&alone, k), level(&near, k));
        }
        println!("  {:6.1}", 10.0 * (own[band][3] / loudest).log10());
    }
    let all = |of: &[[f64; 4]; BANDS]| of.iter().map(|b| b[3]).sum::<f64>();
    println!(
        "all bands: {:+.2} {:+.2} dB",
        10.0 * (all(&alone) / all(&own)).log10(),
        10.0 * (all(&near) / all(&own)).log10()
    );
}

/// Processor time of this process \[s\].
fn seconds() -> f64 {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields: Vec<&str> = text.rsplit(')').next().unwrap_or("").split_whitespace().collect();
    let ticks = |i: usize| fields.get(i).and_then(|t| t.parse::<f64>().ok()).unwrap_or(0.0);
    (ticks(11) + ticks(12)) / 100.0
}
