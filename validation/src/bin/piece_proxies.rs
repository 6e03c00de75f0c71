//! Fragments with individual modes compared with ellipsoid proxies of the bank: lowest frequencies, time, and
//! differences of their spectra.
//!
//! `cargo run --release -p clangor-validation --bin piece_proxies -- timeline FOLDER [COUNT]` for pieces of a
//! simulation with lowest frequencies below 20 kHz, evenly chosen | `-- prisms [COUNT] [SIZE in mm]
//! [THICKNESS in mm]` for the cells of random points in a square plate of glass | `-- frequencies FOLDER
//! [COUNT]` for the lowest frequencies alone

#[path = "../../../crates/clangor-core/benches/thread_time/mod.rs"]
mod thread_time;

use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;

use clangor_bake::fem::ElasticConstants;
use clangor_bake::geometry_class::bake_geometry::BakeGeometry;
use clangor_bake::modal::{ModalBakeOptions, find_modes, radiate};
use clangor_bake::soundbank::modal::solid_polynomials::lowest_by_polynomials;
use clangor_core::body::Surface;
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::glam::{DVec2, DVec3};
use clangor_core::material::Material;
use clangor_core::material::presets::GLASS;
use clangor_core::math::random::SplitMix;
use clangor_core::medium::Medium;
use clangor_core::sound_model::soundbank::modal_soundbank::{
    ContactMapping, ModalProxy, ModalSoundbank, ProxyBody,
};
use clangor_core::synthesis::modal::{ModalSettings, ModalSource, StrikeMemory, TransferMemory};
use clangor_pipeline::formats::modal_soundbank::{bank_material, default_modal_soundbank};
use clangor_pipeline::formats::timeline_file::TimelineReader;

use clangor_validation::cpu_time::cpu_time;
use thread_time::thread_time;

/// Polynomial degrees compared; fragments are rendered with the last.
const POLYNOMIAL_DEGREES: [usize; 3] = [4, 6, 8];
/// Thresholds of \[FRAC\] Table 2, and one below all.
const THRESHOLDS: [f64; 5] = [0.0, 600.0, 2000.0, 3400.0, 4000.0];

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |i: usize, default: f64| arguments.get(i).and_then(|a| a.parse().ok()).unwrap_or(default);
    match arguments.first().map(String::as_str) {
        Some("timeline") => compare(&chosen(of_timeline(&arguments[1]), number(2, 8.0) as usize)),
        Some("frequencies") => frequencies(&chosen(of_timeline(&arguments[1]), number(2, 8.0) as usize)),
        Some("prisms") => {
            let cells =
                broken_plate(number(1, 12.0) as usize, 1e-3 * number(2, 150.0), 1e-3 * number(3, 5.0));
            compare(&cells.into_iter().map(|cell| Piece::new(&cell, GLASS.material())).collect::<Vec<_>>());
        }
        _ => println!("timeline | frequencies | prisms"),
    }
}

/// A fragment.
struct Piece {
    /// About its centre of mass.
    surface: TriMesh,
    mass: MassProperties,
    material: Material,
    constants: ElasticConstants,
}

impl Piece {
    fn new(surface: &TriMesh, material: Material) -> Self {
        let mass = MassProperties::of(surface).expect("a solid");
        let constants = ElasticConstants::of(&material).expect("an elastic material");
        Piece { surface: surface.relative_to(mass.centre_of_mass), mass, material, constants }
    }

    fn first(&self, degree: usize) -> f64 {
        lowest_by_polynomials(&self.surface, &self.constants, degree).expect("a frequency")
    }
}

/// All fragments of the simulation.
fn of_timeline(folder: &str) -> Vec<Piece> {
    let reader = TimelineReader::open(Path::new(folder)).expect("a timeline");
    let of_body = |body: &clangor_core::body::Body| match &*body.surface {
        Surface::Mesh(surface) => Some(Piece::new(&surface.mesh, body.material.clone())),
        _ => None,
    };
    reader.births().iter().filter_map(of_body).collect()
}

/// A number of them, evenly by lowest frequency, within the band.
fn chosen(pieces: Vec<Piece>, count: usize) -> Vec<Piece> {
    let triangles = pieces.iter().map(|piece| piece.surface.triangles.len());
    let (all, most) = (pieces.len(), triangles.max().unwrap_or(0));
    let mut sorted: Vec<(f64, Piece)> = pieces.into_iter().map(|piece| (piece.first(4), piece)).collect();
    sorted.retain(|(first, _)| *first < 20_000.0);
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    println!("{all} pieces of at most {most} triangles, {} with modes in the band", sorted.len());
    let step = (sorted.len() as f64 / count as f64).max(1.0);
    let at = |k: usize| (k as f64 * step) as usize;
    let wanted: Vec<usize> = (0..count).map(at).collect();
    sorted.into_iter().enumerate().filter(|(k, _)| wanted.contains(k)).map(|(_, (_, piece))| piece).collect()
}

/// Prints lowest frequencies and their computation times.
fn frequencies(pieces: &[Piece]) {
    let options = ModalBakeOptions { mesh_error: 0.01, ..ModalBakeOptions::new(Medium::AIR) };
    println!("triangles  extents mm  [Hz (over own), ms] by degree {POLYNOMIAL_DEGREES:?}  own Hz, CPU-s");
    for piece in pieces {
        let (low, high) = piece.surface.bounds();
        print!("{:5} {:.0}", piece.surface.triangles.len(), 1e3 * (high - low));
        let begun = cpu_time();
        let geometry = BakeGeometry::Mesh(piece.surface.clone());
        let found = find_modes(&geometry, &piece.material, &options, &mut |_| ControlFlow::Continue(()));
        let (model, evidence) = found.expect("modes");
        let own = model.modes.first().map(|m| m.frequency).or(evidence.first_frequency).unwrap_or(f64::NAN);
        let taken = cpu_time() - begun;
        for degree in POLYNOMIAL_DEGREES {
            let start = thread_time();
            let first = piece.first(degree);
            print!("  {first:6.0} ({:.3}) {:5.1}", first / own, 1e3 * (thread_time() - start));
        }
        println!("  {own:6.0} {taken:.1}");
    }
}

/// Third octaves from 500 Hz to 20 kHz.
const BANDS: usize = 17;

/// ∫ p² dt by third octaves, of impacts at random places heard from random directions two metres away.
fn spectrum(source: &ModalSource, surface: &TriMesh, seed: u64) -> [f64; BANDS] {
    let mut sums = [0.0; BANDS];
    let mut random = SplitMix::new(seed);
    let (mut amplitudes, mut transfers) = (Vec::new(), Vec::new());
    for _ in 0..24 {
        let triangle = (random.uniform(0.0, 1.0) * surface.triangles.len() as f64) as usize;
        let (u, v) = (random.uniform(0.0, 1.0), random.uniform(0.0, 1.0));
        let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
        let [a, b, c] = surface.corners(triangle);
        let place = a + u * (b - a) + v * (c - a);
        let impulse = -1e-3 * surface.area_vector(triangle).normalize();
        source.amplitudes(&[(place, impulse)], &mut StrikeMemory::default(), &mut amplitudes);
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

/// Root mean square of the differences \[dB\] of the envelopes, octaves around each third octave within 20 dB
/// of the strongest of either, with a floor 30 dB below; and the total level difference of the proxy.
fn distance(own: &[f64; BANDS], proxy: &[f64; BANDS]) -> (f64, f64) {
    let level = |sums: &[f64; BANDS]| -> Vec<f64> {
        // The envelope: mean over three third octaves.
        let at = |k: usize| sums[k.saturating_sub(1)..(k + 2).min(BANDS)].iter().sum::<f64>();
        (0..BANDS).map(|k| 10.0 * at(k).max(1e-300).log10()).collect()
    };
    let louder = 10.0 * (proxy.iter().sum::<f64>() / own.iter().sum::<f64>()).log10();
    let (own, proxy) = (level(own), level(proxy));
    let [loudest, loudest_proxy] =
        [&own, &proxy].map(|levels| levels.iter().copied().fold(f64::MIN, f64::max));
    let squares: Vec<f64> = own
        .iter()
        .zip(&proxy)
        .filter(|(o, p)| **o > loudest - 20.0 || **p > loudest_proxy - 20.0)
        .map(|(o, p)| (p.max(loudest_proxy - 30.0) - o.max(loudest - 30.0)).powi(2))
        .collect();
    ((squares.iter().sum::<f64>() / squares.len() as f64).sqrt(), louder)
}

/// The proxy of a piece.
fn proxy(bank: &ModalSoundbank, piece: &Piece, first_frequency: f64) -> ModalProxy {
    let body = ProxyBody {
        inertia: piece.mass.inertia,
        mass: piece.mass.volume * piece.material.density,
        first_frequency,
        material: bank_material(&piece.material, Medium::AIR),
        max_frequency: 20_000.0,
    };
    bank.proxy_for(&body).expect("a proxy")
}

fn played(proxy: ModalProxy, mapping: ContactMapping, material: &Material) -> ModalSource {
    let transfers: Vec<_> = (0..proxy.mode_count()).map(|k| proxy.transfer(k)).collect();
    ModalSource::of_proxy(proxy, mapping, &transfers, &material.damping, &ModalSettings::default())
        .expect("a source")
}

fn compare(pieces: &[Piece]) {
    let bank = default_modal_soundbank().expect("a bank");
    let options = ModalBakeOptions { mesh_error: 0.02, accuracy: 0.03, ..ModalBakeOptions::new(Medium::AIR) };
    let mut all: Vec<(f64, [[f64; BANDS]; 3])> = Vec::new();
    let (mut proxy_time, mut own_time, mut longest) = (0.0, 0.0, 0.0_f64);
    println!(
        "piece triangles  f0 Hz (over own)  proxy ms  own CPU-s  modes proxy/own  entry  mass ×  \
         dB: by place (louder), by normal"
    );
    for (at, piece) in pieces.iter().enumerate() {
        // Proxy: lowest frequency and lookup, timed.
        let start = thread_time();
        let first = piece.first(POLYNOMIAL_DEGREES[2]);
        let ready = proxy(&bank, piece, first);
        let by_place = played(ready.clone(), ContactMapping::Position, &piece.material);
        let taken = thread_time() - start;
        let by_normal = played(ready.clone(), ContactMapping::Normal, &piece.material);
        // Reference: modal analysis and radiation, timed.
        let begun = cpu_time();
        let geometry = BakeGeometry::Mesh(piece.surface.clone());
        let found = find_modes(&geometry, &piece.material, &options, &mut |_| ControlFlow::Continue(()));
        let (mut model, mut evidence) = match found {
            Ok(found) => found,
            Err(error) => {
                println!("{at:3}: {error}");
                continue;
            }
        };
        // Print frequencies, times and mode counts.
        let own_first =
            model.modes.first().map(|m| m.frequency).or(evidence.first_frequency).unwrap_or(f64::NAN);
        radiate(&geometry, &mut model, &mut evidence, &options, &mut |_| ControlFlow::Continue(()))
            .expect("transfers");
        let own_seconds = cpu_time() - begun;
        proxy_time += taken;
        longest = longest.max(taken);
        own_time += own_seconds;
        let ellipsoid = 4.0 / 3.0 * PI * ready.semi_axes().element_product();
        print!(
            "{at:3} {:5}  {first:8.0} ({:.3})  {:6.1}  {own_seconds:7.1}  {:3}/{:3}  {:3}  {:5.2}",
            piece.surface.triangles.len(),
            first / own_first,
            1e3 * taken,
            ready.mode_count(),
            model.modes.len(),
            ready.entry(),
            ellipsoid / piece.mass.volume,
        );
        if model.modes.is_empty() {
            println!("  silent");
            continue;
        }
        // Spectra of random impacts, and their differences.
        let own = ModalSource::new(Arc::new(model), &piece.material.damping, &ModalSettings::default())
            .expect("a source");
        let spectra =
            [&own, &by_place, &by_normal].map(|source| spectrum(source, &piece.surface, 1 + at as u64));
        let [(place, bias), (normal, _)] = [1, 2].map(|k| distance(&spectra[0], &spectra[k]));
        println!("  {place:5.1} ({bias:+5.1})  {normal:5.1}");
        all.push((first, spectra));
    }
    print_thresholds(&all);
    println!(
        "proxies {:.1} ms, the longest {:.1} ms; own {own_time:.1} s: ratio {:.0}",
        1e3 * proxy_time,
        1e3 * longest,
        own_time / proxy_time
    );
}

/// Prints the error of the sum of all fragments when those above each threshold are proxies. Each fragment
/// has its first frequency \[Hz\] and the spectra of its own modes and of both proxies.
fn print_thresholds(all: &[(f64, [[f64; BANDS]; 3])]) {
    for threshold in THRESHOLDS {
        let replaced = |first: f64| first > threshold;
        let mut sums = [[0.0; BANDS]; 3];
        let (mut single, mut single_normal, mut number) = (0.0, 0.0, 0);
        for (first, spectra) in all {
            let played = if replaced(*first) { [0, 1, 2] } else { [0; 3] };
            for (sum, k) in sums.iter_mut().zip(played) {
                sum.iter_mut().zip(spectra[k]).for_each(|(s, e)| *s += e);
            }
            if replaced(*first) {
                single += distance(&spectra[0], &spectra[1]).0;
                single_normal += distance(&spectra[0], &spectra[2]).0;
                number += 1;
            }
        }
        let ((place, bias), (normal, _)) = (distance(&sums[0], &sums[1]), distance(&sums[0], &sums[2]));
        println!(
            "above {threshold:.0} Hz: {number} of {} replaced; all together {place:.1} dB ({bias:+.1}), \
             by normal {normal:.1} dB; each by itself {:.1} dB, by normal {:.1} dB",
            all.len(),
            single / f64::from(number.max(1)),
            single_normal / f64::from(number.max(1)),
        );
    }
}

/// Voronoi cells of random points in a square plate.
fn broken_plate(count: usize, size: f64, thickness: f64) -> Vec<TriMesh> {
    let mut random = SplitMix::new(11);
    let seeds: Vec<DVec2> =
        (0..count).map(|_| size * DVec2::new(random.uniform(0.0, 1.0), random.uniform(0.0, 1.0))).collect();
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
        // Nearly coincident corners would make slivers.
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
