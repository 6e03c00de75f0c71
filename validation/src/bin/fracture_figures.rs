//! \[FRAC\] Figs. 4 and 5 for a tile of 12 × 12 × 0.6 cm that hits stone at 4 m/s, with ten crack patterns
//! each.
//!
//! `cargo run --release -p clangor-validation --bin fracture_figures -- toughness FILE.svg|FILE.png`
//! draws number, mass and pitch of the fragments against the toughness, `-- onset FILE.svg|FILE.png` the
//! level with and without the impulses of cracks.

#[path = "../../../crates/clangor-pipeline/tests/broken_tile/mod.rs"]
mod broken_tile;

use clangor_core::glam::DVec2;
use clangor_core::scene::render_description::Parts;
use clangor_pipeline::plots::picture::{Align, Canvas, Colour, Raster, Svg, TextStyle};
use clangor_validation::panel::Panel;

use broken_tile::{DURATION, Tile, median, onset_energy, onset_sample};

const SEEDS: u64 = 10;
/// G_c [J/m²].
const TOUGHNESSES: [f64; 4] = [50.0, 80.0, 120.0, 200.0];
/// Toughness of the tile whose onset is compared [J/m²].
const ONSET_TOUGHNESS: f64 = 150.0;
/// Length of a step of the envelope, and of the onset \[ms\].
const STEP: f64 = 1.0;
const ONSET: f64 = 5.0;
const SINGLE: Colour = [150, 175, 215];
const MEDIAN: Colour = [30, 70, 190];
const WITH: Colour = [200, 40, 30];

/// Number, median mass \[kg\] and median pitch \[Hz\] of the pieces.
fn pieces(toughness: f64, seed: u64) -> [f64; 3] {
    let fallen = Tile { toughness, crack_impulses: true, seed }.fall();
    let masses: Vec<f64> = fallen.pieces().map(|piece| piece.mass).collect();
    [masses.len() as f64, median(masses), median(fallen.pitches())]
}

fn toughness(canvas: &mut dyn Canvas) {
    // Simulate all patterns.
    let found: Vec<Vec<[f64; 3]>> =
        TOUGHNESSES.iter().map(|g| (0..SEEDS).map(|seed| pieces(*g, seed)).collect()).collect();
    let title =
        "Pieces of a ceramic tile against its toughness: ten patterns (dots) and their medians (lines)";
    canvas.text(DVec2::new(0.5 * WIDTH as f64, 24.0), Align::Middle, TextStyle::Title, title);
    println!("{:>10} {:>8} {:>12} {:>12}", "G_c [J/m²]", "pieces", "mass [g]", "pitch [kHz]");
    let panels = [("pieces", 1.0), ("median mass [g]", 1e3), ("median lowest frequency [kHz]", 1e-3)];
    let mut medians = vec![[0.0; 3]; TOUGHNESSES.len()];
    // One panel per quantity: frame, ticks, points and medians.
    for (k, (name, unit)) in panels.into_iter().enumerate() {
        let values: Vec<Vec<f64>> = found.iter().map(|of| of.iter().map(|v| unit * v[k]).collect()).collect();
        let all = || values.iter().flatten().copied();
        let (low, high) = (all().fold(f64::INFINITY, f64::min), all().fold(0.0, f64::max));
        let up = [(0.85 * low).log10(), (1.18 * high).log10()];
        let across = [1.55, 2.45];
        let corner = DVec2::new(70.0 + 410.0 * k as f64, 80.0);
        let panel = Panel { corner, extent: DVec2::new(330.0, 300.0), across, up };
        panel.frame(name, canvas);
        for g in TOUGHNESSES {
            panel.tick_below(g.log10(), &format!("{g:.0}"), canvas);
        }
        for decade in -3..4 {
            for digit in [1.0, 2.0, 5.0] {
                let value: f64 = digit * 10_f64.powi(decade);
                if (up[0]..=up[1]).contains(&value.log10()) {
                    panel.tick_left(value.log10(), &format!("{value}"), canvas);
                }
            }
        }
        let mut line = Vec::new();
        for (at, (g, values)) in TOUGHNESSES.iter().zip(&values).enumerate() {
            values.iter().for_each(|v| panel.dot(g.log10(), v.log10(), SINGLE, canvas));
            medians[at][k] = median(values.clone());
            line.push(panel.place(g.log10(), medians[at][k].log10()));
        }
        canvas.line(&line, 2.0, MEDIAN);
        let below = corner + DVec2::new(165.0, 340.0);
        canvas.text(below, Align::Middle, TextStyle::Label, "toughness [J/m²]");
    }
    for (g, [count, mass, pitch]) in TOUGHNESSES.iter().zip(&medians) {
        println!("{g:>10} {count:>8.1} {mass:>12.2} {pitch:>12.2}");
    }
}

/// Acceleration noise, modal sound, and both.
const PARTS: [(bool, bool); 3] = [(true, false), (false, true), (true, true)];

/// The levels of a sound in steps from its onset \[dB re 20 µPa\].
fn envelope(samples: &[f64]) -> Vec<f64> {
    let step = (1e-3 * STEP * 48_000.0) as usize;
    let rest = &samples[onset_sample(samples)..];
    let square = |part: &[f64]| part.iter().map(|p| p * p).sum::<f64>() / part.len() as f64;
    rest.chunks_exact(step).map(|part| 10.0 * (square(part) / 4e-10).max(1e-12).log10()).collect()
}

fn onset(canvas: &mut dyn Canvas) {
    let mut rises = vec![Vec::new(); PARTS.len()];
    let mut envelopes = [Vec::new(), Vec::new()];
    // Simulate each pattern with and without crack impulses; onset energies and envelopes.
    for seed in 0..SEEDS {
        let mut energies = [[0.0; 2]; 3];
        for (which, crack_impulses) in [false, true].into_iter().enumerate() {
            let fallen = Tile { toughness: ONSET_TOUGHNESS, crack_impulses, seed }.fall();
            let models = fallen.models();
            for (k, (acceleration, modal)) in PARTS.into_iter().enumerate() {
                let samples = fallen.heard(&models, Parts { acceleration, modal, ground: false });
                energies[k][which] = onset_energy(&samples, ONSET);
                if k == 2 {
                    envelopes[which].push(envelope(&samples));
                }
            }
        }
        for (rises, [without, with]) in rises.iter_mut().zip(energies) {
            rises.push(10.0 * (with / without).log10());
        }
    }
    let title = "A breaking tile with (red) and without (blue) the impulses of its cracks";
    canvas.text(DVec2::new(0.5 * WIDTH as f64, 24.0), Align::Middle, TextStyle::Title, title);
    let end = 1e3 * DURATION - 20.0;
    // Left panel: envelopes and their medians.
    let left = Panel {
        corner: DVec2::new(70.0, 80.0),
        extent: DVec2::new(700.0, 300.0),
        across: [0.0, end],
        up: [40.0, 130.0],
    };
    left.frame("level in steps of 1 ms [dB re 20 µPa]: ten patterns, and their median", canvas);
    (0..=8).for_each(|k| left.tick_below(5.0 * f64::from(k), &(5 * k).to_string(), canvas));
    (4..=13).for_each(|k| left.tick_left(10.0 * f64::from(k), &(10 * k).to_string(), canvas));
    canvas.text(DVec2::new(420.0, 420.0), Align::Middle, TextStyle::Label, "time after the first sound [ms]");
    for (of, single, middle) in [(&envelopes[0], SINGLE, MEDIAN), (&envelopes[1], [235, 180, 170], WITH)] {
        let point = |k: usize, level: f64| left.place((k as f64 + 0.5) * STEP, level.max(40.0));
        let count = (of.iter().map(Vec::len).min().unwrap_or(0)).min((end / STEP) as usize);
        for levels in of {
            let line: Vec<DVec2> = levels[..count].iter().enumerate().map(|(k, l)| point(k, *l)).collect();
            canvas.line(&line, 0.7, single);
        }
        let medians = |k: usize| median(of.iter().map(|levels| levels[k]).collect());
        let line: Vec<DVec2> = (0..count).map(|k| point(k, medians(k))).collect();
        canvas.line(&line, 2.5, middle);
    }
    // Right panel: level difference at the onset.
    let right = Panel {
        corner: DVec2::new(850.0, 80.0),
        extent: DVec2::new(360.0, 300.0),
        across: [-0.5, 2.5],
        up: [-10.0, 20.0],
    };
    right.frame("what cracks add to the first 5 ms [dB]", canvas);
    (-2..=4).for_each(|k| right.tick_left(5.0 * f64::from(k), &(5 * k).to_string(), canvas));
    for (k, (name, rises)) in ["clicks", "ringing", "both"].into_iter().zip(&rises).enumerate() {
        right.tick_below(k as f64, name, canvas);
        rises.iter().for_each(|rise| right.dot(k as f64, rise.clamp(-10.0, 20.0), SINGLE, canvas));
        let (at, middle) = (k as f64, median(rises.clone()));
        canvas.line(&[right.place(at - 0.25, middle), right.place(at + 0.25, middle)], 2.5, WITH);
        println!("{name}: cracks add {middle:.2} dB to the first {ONSET} ms (median of {SEEDS})");
    }
}

/// Width of a picture in pixels.
const WIDTH: usize = 1280;
/// Height of a picture in pixels.
const HEIGHT: usize = 450;

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [what, path] = &words[..] else {
        println!("fracture_figures -- toughness|onset FILE.svg|FILE.png");
        return;
    };
    let mut svg = Svg::new(WIDTH, HEIGHT);
    let mut raster = Raster::new(WIDTH, HEIGHT);
    let canvas: &mut dyn Canvas = if path.ends_with(".png") { &mut raster } else { &mut svg };
    match what.as_str() {
        "toughness" => toughness(canvas),
        "onset" => onset(canvas),
        other => return println!("there is no figure {other}"),
    }
    std::fs::write(path, canvas.encode().expect("a picture")).expect("written");
}
