//! The modal bank: its samples, an entry, and pieces of a broken plate, rung by themselves and through the bank.
//!
//! `cargo bench -p clangor-bake --bench modal_bank -- samples [SPACING] [THINNEST]` | `-- entry A B C [ACCURACY]` |
//! `-- build BANK.safetensors` | `-- pieces BANK.safetensors [COUNT] [SIZE in mm] [THICKNESS in mm]`

use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow;
use std::sync::Arc;

use clangor::geometry::mass_properties::MassProperties;
use clangor::geometry::tri_mesh::TriMesh;
use clangor::material::Material;
use clangor::material::presets::GLASS;
use clangor::medium::Medium;
use clangor::model::modal_bank::{BankMaterial, ContactMapping, ModalSoundbank, ProxyBody};
use clangor::model::modal_bank_file::{ModalBankFile, ModalBankOrigin};
use clangor::synthesis::modal::{ModalSettings, ModalSource, TransferMemory};
use clangor_bake::acceleration_noise::BakeGeometry;
use clangor_bake::elasticity::ElasticConstants;
use clangor_bake::modal::{ModalBakeOptions, find_modes, radiate};
use clangor_bake::modal_bank::ellipsoid_vibration::BallPolynomials;
use clangor_bake::modal_bank::{BankOptions, build_bank, first_frequency, ringing_ellipsoid, sampling};
use clangor_bake::tetrahedra::stuffing::stuff;
use glam::{DVec2, DVec3};

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    let number = |i: usize, default: f64| arguments.get(i).and_then(|a| a.parse().ok()).unwrap_or(default);
    let mut options = BankOptions::new(glass());
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
        Some("pieces") => {
            let bytes = std::fs::read(&arguments[1]).expect("a bank");
            let bank = ModalBankFile::decode(&bytes).expect("a bank").bank;
            pieces(&bank, number(2, 12.0) as usize, 1e-3 * number(3, 150.0), 1e-3 * number(4, 5.0));
        }
        _ => println!("samples | entry | pieces"),
    }
}

fn glass() -> BankMaterial {
    let Material { youngs_modulus, density, poisson_ratio, .. } = GLASS.material();
    BankMaterial { youngs_modulus, density, poisson_ratio, medium: Medium::AIR }
}

fn samples(options: &BankOptions) {
    let start = seconds();
    let polynomials = BallPolynomials::new(options.degree);
    println!("integrals: {:.2} CPU-s", seconds() - start);
    let samples = sampling::samples(&polynomials, options).expect("samples");
    println!("{} samples, {:.2} CPU-s", samples.len(), seconds() - start);
    for axes in &samples {
        println!("a/c {:.3} b/c {:.3}", axes.x / axes.z, axes.y / axes.z);
    }
}

fn build(path: &str, options: &BankOptions) {
    let start = seconds();
    let mut done = 0;
    let bank = build_bank(options, &mut |part| {
        if (20.0 * part) as u32 > done {
            done = (20.0 * part) as u32;
            eprintln!("{:.0} %, {:.0} CPU-s", 100.0 * part, seconds() - start);
        }
        ControlFlow::Continue(())
    });
    let origin = ModalBankOrigin {
        program: "bench".into(),
        inputs: String::new(),
        material: "glass".into(),
        asked_accuracy: options.accuracy,
        spacing: options.spacing,
        least_first_frequency: options.least_first_frequency,
        largest_size: options.largest_size,
        max_frequency: options.max_frequency,
    };
    let bytes = ModalBankFile { bank: bank.expect("a bank"), origin }.encode().expect("a file");
    std::fs::write(path, &bytes).expect("a folder to write to");
    println!("{:.0} CPU-s, {:.3} MB", seconds() - start, 1e-6 * bytes.len() as f64);
}

fn entry(axes: DVec3, options: &BankOptions) {
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

/// Third octaves from 500 Hz to 20 kHz.
const BANDS: usize = 17;

/// ∫ p² dt by third octaves, of blows at random places heard from random directions two metres away.
fn spectrum(source: &ModalSource, surface: &TriMesh, seed: u64) -> [f64; BANDS] {
    let mut sums = [0.0; BANDS];
    let mut random = Random(seed);
    let (mut amplitudes, mut transfers) = (Vec::new(), Vec::new());
    for _ in 0..24 {
        let triangle = (random.next() * surface.triangles.len() as f64) as usize;
        let (u, v) = (random.next(), random.next());
        let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
        let [a, b, c] = surface.corners(triangle);
        let place = a + u * (b - a) + v * (c - a);
        let impulse = -1e-3 * surface.area_vector(triangle).normalize();
        source.amplitudes(&[(place, impulse)], &mut amplitudes);
        let listener = 2.0 * random.direction();
        source.transfers(listener, &mut TransferMemory::default(), &mut transfers);
        for ((amplitude, transfer), resonance) in amplitudes.iter().zip(&transfers).zip(source.resonances()) {
            let band = (3.0 * (resonance.frequency / 500.0).log2() + 0.5).floor();
            if (0.0..BANDS as f64).contains(&band) {
                // Acceleration ω Q e^{−ξωt}, whose square lasts 1/(4ξω).
                let omega = TAU * resonance.frequency;
                let square = (omega * amplitude * transfer.norm()).powi(2);
                sums[band as usize] += square / (4.0 * resonance.damping_ratio * omega);
            }
        }
    }
    sums
}

/// Root mean square of the differences [dB] of third octaves within 40 dB of the loudest, and the mean difference.
fn distance(own: &[f64; BANDS], proxy: &[f64; BANDS]) -> (f64, f64) {
    let level = |sums: &[f64; BANDS]| -> Vec<f64> {
        // The envelope: over three third octaves.
        let at = |k: usize| sums[k.saturating_sub(1)..(k + 2).min(BANDS)].iter().sum::<f64>();
        (0..BANDS).map(|k| 10.0 * at(k).max(1e-300).log10()).collect()
    };
    let (own, proxy) = (level(own), level(proxy));
    let loudest = own.iter().copied().fold(f64::MIN, f64::max);
    let loudest_proxy = proxy.iter().copied().fold(f64::MIN, f64::max);
    let pairs: Vec<f64> = own
        .iter()
        .zip(&proxy)
        .filter(|(o, p)| **o > loudest - 40.0 || **p > loudest_proxy - 40.0)
        .map(|(o, p)| p.max(loudest_proxy - 60.0) - o.max(loudest - 60.0))
        .collect();
    let mean = pairs.iter().sum::<f64>() / pairs.len() as f64;
    ((pairs.iter().map(|d| d * d).sum::<f64>() / pairs.len() as f64).sqrt(), mean)
}

fn pieces(bank: &ModalSoundbank, count: usize, size: f64, thickness: f64) {
    let material = GLASS.material();
    let constants = ElasticConstants::of(&material).expect("an elastic material");
    let options = ModalBakeOptions { mesh_error: 0.02, accuracy: 0.03, ..ModalBakeOptions::new(Medium::AIR) };
    let mut all: Vec<(f64, [[f64; BANDS]; 3])> = Vec::new();
    let (mut proxy_time, mut own_time) = (0.0, 0.0);
    println!(
        "piece  f0 Hz (own)  nodes  mesh ms  f0 ms  proxy ms  own CPU-s  modes  entry  distance dB: by place, by normal"
    );
    for (at, surface) in broken_plate(count, size, thickness).into_iter().enumerate() {
        let mass = MassProperties::of(&surface).expect("a solid");
        let surface = surface.relative_to(mass.centre_of_mass);
        let (low, high) = surface.bounds();
        let start = wall();
        let (mesh, _) = stuff(&surface, (high - low).max_element() / 6.0).expect("tetrahedra");
        let meshed = wall();
        let first = first_frequency(&mesh, &constants).expect("a frequency");
        let found = wall();
        let body = ProxyBody {
            inertia: mass.inertia,
            mass: mass.volume * material.density,
            first_frequency: first,
            material: *bank.material(),
            max_frequency: 20_000.0,
        };
        let source = |mapping| {
            let proxy = bank.proxy_for(&body).expect("a proxy");
            let transfers: Vec<_> = (0..proxy.mode_count()).map(|k| proxy.transfer(k)).collect();
            ModalSource::of_proxy(proxy, mapping, &transfers, &material.damping, &ModalSettings::default())
                .expect("a source")
        };
        let by_place = source(ContactMapping::Position);
        let ready = wall();
        let by_normal = source(ContactMapping::Normal);
        let proxy = bank.proxy_for(&body).expect("a proxy");
        let (nodes, begun) = (mesh.nodes.len(), seconds());
        let geometry = BakeGeometry::Mesh(surface.clone());
        let (mut model, mut evidence) =
            find_modes(&geometry, &material, &options, &mut |_| ControlFlow::Continue(())).expect("modes");
        let own_first = model.modes.first().map(|m| m.frequency).or(evidence.first_frequency).unwrap_or(0.0);
        radiate(&geometry, &mut model, &mut evidence, &options, &mut |_| ControlFlow::Continue(()))
            .expect("transfers");
        let own_seconds = seconds() - begun;
        proxy_time += ready - meshed;
        own_time += own_seconds;
        print!(
            "{at:3} {first:8.0} ({own_first:8.0}) {nodes:5} {:7.1} {:7.1} {:6.2} {own_seconds:8.1} {:3}/{:3} {:3}",
            1e3 * (meshed - start),
            1e3 * (found - meshed),
            1e3 * (ready - found),
            proxy.mode_count(),
            model.modes.len(),
            proxy.entry(),
        );
        if model.modes.is_empty() {
            println!("  silent");
            continue;
        }
        let own = ModalSource::new(Arc::new(model), &material.damping, &ModalSettings::default())
            .expect("a source");
        let spectra = [&own, &by_place, &by_normal].map(|source| spectrum(source, &surface, 1 + at as u64));
        let [(place, bias), (normal, _)] = [1, 2].map(|k| distance(&spectra[0], &spectra[k]));
        println!("  {place:5.1} ({bias:+5.1})  {normal:5.1}");
        all.push((first, spectra));
    }
    for threshold in [0.0, 600.0, 2000.0, 3400.0, 4000.0] {
        let replaced = |first: f64| first > threshold;
        let mut sums = [[0.0; BANDS]; 3];
        let (mut single, mut single_normal, mut number) = (0.0, 0.0, 0);
        for (first, spectra) in &all {
            let played = [0, if replaced(*first) { 1 } else { 0 }, if replaced(*first) { 2 } else { 0 }];
            for (sum, k) in sums.iter_mut().zip(played) {
                sum.iter_mut().zip(spectra[k]).for_each(|(s, e)| *s += e);
            }
            if replaced(*first) {
                single += distance(&spectra[0], &spectra[1]).0;
                single_normal += distance(&spectra[0], &spectra[2]).0;
                number += 1;
            }
        }
        let ([place, bias], [normal, _]) =
            (<[f64; 2]>::from(distance(&sums[0], &sums[1])), <[f64; 2]>::from(distance(&sums[0], &sums[2])));
        println!(
            "above {threshold:.0} Hz: {number} of {} replaced; all together {place:.1} dB ({bias:+.1}), by normal {normal:.1} dB; \
             each by itself {:.1} dB, by normal {:.1} dB",
            all.len(),
            single / f64::from(number.max(1)),
            single_normal / f64::from(number.max(1)),
        );
    }
    println!("proxies {:.1} ms, own {own_time:.1} s: ratio {:.0}", 1e3 * proxy_time, own_time / proxy_time);
}

/// Voronoi cells of random points in a square plate.
fn broken_plate(count: usize, size: f64, thickness: f64) -> Vec<TriMesh> {
    let mut random = Random(11);
    let seeds: Vec<DVec2> = (0..count).map(|_| size * DVec2::new(random.next(), random.next())).collect();
    let cell = |seed: &DVec2| {
        let mut polygon =
            [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|p| size * DVec2::from_array(p)).to_vec();
        for other in seeds.iter().filter(|other| *other != seed) {
            let (middle, away) = (0.5 * (*other + *seed), *other - *seed);
            let side = |p: DVec2| (p - middle).dot(away);
            let mut cut = Vec::new();
            for k in 0..polygon.len() {
                let (p, q) = (polygon[k], polygon[(k + 1) % polygon.len()]);
                if side(p) <= 0.0 {
                    cut.push(p);
                }
                if (side(p) <= 0.0) != (side(q) <= 0.0) {
                    cut.push(p + (q - p) * (side(p) / (side(p) - side(q))));
                }
            }
            polygon = cut;
        }
        // Corners that nearly coincide make needles.
        let far = |k: &usize| polygon[*k].distance(polygon[(k + 1) % polygon.len()]) > 0.002 * size;
        prism(&(0..polygon.len()).filter(far).map(|k| polygon[k]).collect::<Vec<_>>(), thickness)
    };
    seeds.iter().map(cell).collect()
}

fn prism(polygon: &[DVec2], thickness: f64) -> TriMesh {
    let count = polygon.len() as u32;
    let at = |z: f64| polygon.iter().map(move |p| DVec3::new(p.x, p.y, z));
    let vertices: Vec<DVec3> = at(0.0).chain(at(thickness)).collect();
    let mut triangles = Vec::new();
    for k in 1..count - 1 {
        triangles.push([0, k + 1, k]);
        triangles.push([count, count + k, count + k + 1]);
    }
    for k in 0..count {
        let next = (k + 1) % count;
        triangles.push([k, next, count + next]);
        triangles.push([k, count + next, count + k]);
    }
    TriMesh { vertices, triangles }
}

/// SplitMix64.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn direction(&mut self) -> DVec3 {
        let (z, turn) = (2.0 * self.next() - 1.0, 2.0 * PI * self.next());
        let across = (1.0 - z * z).sqrt();
        DVec3::new(across * turn.cos(), across * turn.sin(), z)
    }
}

fn wall() -> f64 {
    static START: std::sync::OnceLock<std::time::Instant> = std::sync::OnceLock::new();
    START.get_or_init(std::time::Instant::now).elapsed().as_secs_f64()
}

/// Processor time of this process \[s\].
fn seconds() -> f64 {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields: Vec<&str> = text.rsplit(')').next().unwrap_or("").split_whitespace().collect();
    let ticks = |i: usize| fields.get(i).and_then(|t| t.parse::<f64>().ok()).unwrap_or(0.0);
    (ticks(11) + ticks(12)) / 100.0
}
