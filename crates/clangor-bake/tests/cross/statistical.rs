//! Statistical ringing beside the modes for which it stands: bodies whose modes to 20 kHz can be found are
//! cut off after some of them, and the rest is made of synthetic modes.
//!
//! Compared is the energy of the sound after an impulse normal to the surface, in third octaves with at least
//! five modes: Σ (U·n)² |H|²/(4ξω) over the modes of a band.

use std::f64::consts::TAU;
use std::ops::ControlFlow;

use clangor_bake::geometry_class::bake_geometry::BakeGeometry;
use clangor_bake::modal::{ModalBakeOptions, ModalEvidence, find_modes, radiate};
use clangor_bake::statistical::{add_synthetic_modes, radiate_synthetic_modes};
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::glam::DVec3;
use clangor_core::material::Material;
use clangor_core::material::presets::{self, Preset};
use clangor_core::medium::Medium;
use clangor_core::shape::Shape;
use clangor_core::sound_model::modal::model::{ModalMode, ModalModel};
use clangor_core::synthesis::modal::source::radiation_ratio;

/// Places that are struck, and listeners at [`DISTANCE`] bounding radii.
const PLACES: usize = 20;
const LISTENERS: usize = 12;
const DISTANCE: f64 = 6.0;

/// A body with all its modes to `highest` \[Hz\] and their transfers.
struct Known {
    model: ModalModel,
    volume: f64,
    material: Material,
}

fn known(name: &str, preset: Preset, highest: f64) -> Known {
    let mesh = Shape::parse(name).expect("a shape").mesh();
    let mass = MassProperties::of(&mesh).expect("a solid");
    let geometry = BakeGeometry::of_mesh(&mesh.relative_to(mass.centre_of_mass));
    let material = preset.material();
    let options = ModalBakeOptions {
        max_frequency: highest,
        mesh_error: 0.05,
        accuracy: 0.05,
        ..ModalBakeOptions::new(Medium::AIR)
    };
    let go_on = &mut |_: &_| ControlFlow::Continue(());
    let (mut model, mut evidence) = find_modes(&geometry, &material, &options, go_on).expect("modes");
    assert_eq!(model.statistical_above, None, "{name}: {:?}", evidence.warnings);
    radiate(&geometry, &mut model, &mut evidence, &options, go_on).expect("transfers");
    let ModalEvidence { mesh, method, .. } = evidence;
    println!("{name}, {}: {} modes, {mesh}, {method}", material.name, model.modes.len());
    Known { model, volume: mass.volume, material }
}

/// The model with synthetic modes above the first `count`.
fn cut(body: &Known, count: usize) -> ModalModel {
    let mut model = body.model.clone();
    let highest = model.max_frequency;
    model.max_frequency = 0.5 * (model.modes[count - 1].frequency + model.modes[count].frequency);
    model.modes.truncate(count);
    let band = add_synthetic_modes(&mut model, body.volume, &body.material, highest).expect("a band");
    radiate_synthetic_modes(&mut model, body.volume, &body.material);
    println!("  cut at {:.0} Hz: {} stand for {:.0}", band.from, band.modes, band.stands_for);
    model
}

/// Triangles struck in their middle: the middles of equal areas, in the order of the triangles.
fn places(model: &ModalModel) -> Vec<([u32; 3], DVec3)> {
    let mesh = model.surface.quarters();
    let total = mesh.area();
    let (mut found, mut sum) = (Vec::new(), 0.0);
    for t in 0..mesh.triangles.len() {
        let vector = mesh.area_vector(t);
        sum += vector.length() / total * PLACES as f64;
        while found.len() as f64 + 0.5 < sum {
            found.push((mesh.triangles[t], vector.normalize()));
        }
    }
    found
}

/// The q-th of the directions of the listeners, spread evenly.
fn listener(q: usize) -> DVec3 {
    let z = 1.0 - (2 * q + 1) as f64 / LISTENERS as f64;
    let turn = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt()) * q as f64;
    let across = (1.0 - z * z).sqrt();
    DVec3::new(across * turn.cos(), z, across * turn.sin())
}

/// ⟨(U·n)²⟩ over a surface.
fn mean_square(mesh: &TriMesh, shape: &[DVec3]) -> f64 {
    let part = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|i| mesh.vertices[i as usize]);
        let area = 0.5 * (b - a).cross(c - a);
        let mean = t.iter().map(|i| shape[*i as usize]).sum::<DVec3>() / 3.0;
        [area.length(), mean.dot(area.normalize_or_zero()).powi(2) * area.length()]
    };
    let [area, sum] = mesh.triangles.iter().map(part).fold([0.0; 2], |s, p| [s[0] + p[0], s[1] + p[1]]);
    sum / area
}

/// Energy of the sound of a mode, in the mean over places and listeners: of its vibration wherever it is
/// struck, heard from some places, and radiated in all directions wherever it is struck.
fn energies(body: &Known, model: &ModalModel, places: &[([u32; 3], DVec3)], mode: &ModalMode) -> [f64; 3] {
    let at = |(nodes, normal): &([u32; 3], DVec3)| {
        let mean = nodes.iter().map(|i| mode.shape[*i as usize]).sum::<DVec3>() / 3.0;
        mean.dot(*normal).powi(2)
    };
    let mean = |places: &[([u32; 3], DVec3)]| places.iter().map(at).sum::<f64>() / places.len() as f64;
    let square = mean(places);
    let everywhere = mean_square(&model.surface.quarters(), &mode.shape);
    let omega = TAU * mode.frequency;
    let wavenumber = omega * model.radius / model.medium.sound_speed;
    let transfer = mode.transfer.as_ref().expect("a transfer");
    let heard = (0..LISTENERS)
        .map(|q| transfer.undelayed(DISTANCE * listener(q), wavenumber).norm_sqr())
        .sum::<f64>()
        / LISTENERS as f64;
    let ratio = body.material.damping.damping_ratio(mode.frequency) + radiation_ratio(model, mode);
    let decay = 4.0 * ratio * omega;
    // In the far field, ½|p|² r² times 4π is the power.
    let all = transfer.power(wavenumber) / (TAU * DISTANCE * DISTANCE);
    [everywhere, square * omega * omega * heard / decay, everywhere * omega * omega * all / decay]
}

/// Middles of the third octaves \[Hz\].
fn thirds(from: f64, to: f64) -> Vec<f64> {
    let band = |n: i32| 1000.0 * (f64::from(n) / 3.0).exp2();
    let edge = 6.0_f64.recip().exp2();
    (-15..30).map(band).filter(|f| f / edge >= from && f * edge <= to).collect()
}

/// Differences of synthetic from known modes in third octaves with at least five of these \[dB\].
fn differences(body: &Known, count: usize) -> Vec<[f64; 3]> {
    let model = cut(body, count);
    let from = model.statistical_above.expect("a cut");
    let places = places(&model);
    let edge = 6.0_f64.recip().exp2();
    let mut found = Vec::new();
    for middle in thirds(from, model.max_frequency) {
        let inside = |mode: &&ModalMode| mode.frequency >= middle / edge && mode.frequency < middle * edge;
        let sums = |of: &ModalModel| {
            of.modes
                .iter()
                .filter(inside)
                .map(|mode| energies(body, of, &places, mode))
                .fold([0.0; 3], |sum, e| std::array::from_fn(|k| sum[k] + e[k]))
        };
        let modes = body.model.modes.iter().filter(inside).count();
        if modes < 5 {
            continue;
        }
        let (exact, statistical) = (sums(&body.model), sums(&model));
        let db: [f64; 3] = std::array::from_fn(|k| 10.0 * (statistical[k] / exact[k]).log10());
        println!(
            "    {middle:7.0} Hz, {modes:3} modes, {:3} synthetic: vibration {:+.2}, heard {:+.2}, \
             radiated {:+.2} dB",
            model.modes.iter().filter(inside).count(),
            db[0],
            db[1],
            db[2]
        );
        found.push(db);
    }
    found
}

/// Differences of some bodies, [vibration, heard, radiated] of all bands; checks their medians and the worst.
fn check(bodies: &[(&str, Preset, &[usize])]) {
    let mut all: Vec<[f64; 3]> = Vec::new();
    for (name, preset, cuts) in bodies {
        let body = known(name, *preset, 20_000.0);
        cuts.iter().for_each(|count| all.extend(differences(&body, *count)));
    }
    // Median and worst that are allowed. Seen, of all bodies here: 0.3 and 1.4 dB, 1.3 and 3.2, 0.6 and 2.6.
    for (k, (what, median, worst)) in
        [("vibration", 0.8, 2.0), ("heard", 2.0, 4.0), ("radiated", 1.2, 3.0)].into_iter().enumerate()
    {
        let mut values: Vec<f64> = all.iter().map(|db| db[k].abs()).collect();
        values.sort_by(f64::total_cmp);
        let [middle, last] = [values[values.len() / 2], values[values.len() - 1]];
        println!("{what}: median {middle:.2}, worst {last:.2} dB in {} bands", values.len());
        assert!(middle < median && last < worst, "{what}: {middle} {last}");
    }
}

#[test]
fn third_octaves_of_thin_plates() {
    check(&[("plate", presets::GLASS, &[30]), ("cylinder:0.1x0.001", presets::STEEL, &[80])]);
}

#[test]
#[ignore = "45 CPU-s"]
fn third_octaves_of_more_bodies() {
    check(&[
        ("cylinder:0.1x0.001", presets::STEEL, &[40]),
        ("cylinder:0.15x0.004", presets::GLASS, &[30, 50]),
        ("cylinder:0.12x0.5", presets::WOOD, &[50]),
        ("cylinder:0.15x0.25", presets::GRANITE, &[30]),
        ("wineglass", presets::GLASS, &[20]),
    ]);
}
