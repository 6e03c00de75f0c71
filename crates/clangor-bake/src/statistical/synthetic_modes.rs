//! Frequencies and shapes of synthetic modes above the last known one.
//!
//! N modes are known below f_c. What they have more than the mean N_th of the wall belongs to edges, and
//! grows as k_s, the number of waves along them (free plates: about 1.7 Π k/4π). The mean mobility grows with
//! the number of modes:
//!
//! ```text
//! n = n_th + e dk_s/df     e = (N − N_th(f_c))/k_s(f_c)     Y = Y_th n/n_th
//! ```
//!
//! n_s synthetic modes per hertz stand for n, at most [`PER_THIRD_OCTAVE`] in a third of an octave. Their
//! shapes are random combinations of those of the anchor, the K known modes of the last octave, at most 64,
//! with means Ȳ and n̄:
//!
//! ```text
//! U_s = √(Y/Ȳ · n̄/n_s) Σ_m Q_sm U_m       Q: a random orthogonal matrix for each block of K modes
//! ```
//!
//! Σ over a block of U_s² is that of the anchor, at every place and in every direction: edges, corners, thin
//! and thick parts give way as they do in the last octave, and in the mean over frequencies as
//! `mean_vibration` has it. A combination of modes of mass 1 has mass 1; one that stands for several has
//! their number.
//!
//! The k-th frequency is at a random place of the k-th interval of equal expected number: it keeps its
//! distance from the next as the modes of a body without symmetries do (variance 1/6 of the mean distance
//! squared; random matrices 0.27).
//!
//! What it is not: the waves are as long as in the last octave, so that places nearer than that move alike.

use std::ops::Range;

use clangor_core::math::random::SplitMix;
use clangor_core::sound_model::modal::model::{ModalMode, ModalModel};
use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use glam::DVec3;

use super::mean_table::MeanTable;
use super::mean_vibration::MeanVibration;
use super::random_numbers::orthogonal;

/// Most synthetic modes in a third of an octave, and fewest where shapes take much memory.
pub const PER_THIRD_OCTAVE: f64 = 48.0;
const FEWEST_PER_THIRD_OCTAVE: f64 = 12.0;
/// Most numbers of all shapes.
const MOST_VALUES: f64 = 1.2e7;
/// Width of a third of an octave over its middle.
const THIRD_OCTAVE: f64 = 0.231_56;
/// Most and fewest modes of the anchor.
const MOST_ANCHORS: usize = 64;
const FEWEST_ANCHORS: usize = 8;
/// Most modes of edges, over those of the wall, and least density over that of the wall.
const MOST_EXCESS: f64 = 0.7;
const LEAST_DENSITY: f64 = 0.3;
/// Least d ln N/d ln f.
const LEAST_GROWTH: f64 = 0.1;
/// Steps of the integral of the density per octave.
const STEPS: f64 = 48.0;

/// The known modes from which the others are extrapolated.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Anchor {
    /// Their indices.
    pub(super) modes: Range<usize>,
    /// The band \[Hz\] that they fill.
    pub(super) band: [f64; 2],
}

impl Anchor {
    /// The last octave of modes that are complete below `highest` \[Hz\]; `None` without modes.
    pub(super) fn of(known: &[ModalMode], highest: f64) -> Option<Self> {
        let end = known.len();
        let octave = known.partition_point(|mode| mode.frequency < 0.5 * highest);
        let first = octave.max(end.saturating_sub(MOST_ANCHORS)).min(end.saturating_sub(FEWEST_ANCHORS));
        let low = if first == octave {
            0.5 * highest
        } else if first == 0 {
            0.5 * known.first()?.frequency
        } else {
            0.5 * (known[first - 1].frequency + known[first].frequency)
        };
        (end > first && low < highest).then_some(Anchor { modes: first..end, band: [low, highest] })
    }
}

/// Synthetic modes of a model whose known modes are the anchor, from there to `highest` \[Hz\], and for how
/// many modes they stand.
pub(super) fn synthetic_modes(
    model: &ModalModel,
    anchor: &Anchor,
    mean: &MeanVibration,
    highest: f64,
    random: &mut SplitMix,
) -> (Vec<ModalMode>, f64) {
    let [low, from] = anchor.band;
    let wall = mean.modes_below(from);
    let excess = (anchor.modes.end as f64 - wall).clamp(-MOST_EXCESS * wall, MOST_EXCESS * wall);
    let at_edges = excess / mean.surface_wavenumber(from);
    let table = MeanTable::new([low, highest], |f| {
        let without = mean.density(f).max(LEAST_GROWTH * mean.modes_below(f) / f);
        let density = (without + at_edges * mean.wavenumber_slope(f)).max(LEAST_DENSITY * without);
        [mean.mobility(f) * density / without, density]
    });
    let [mobility_below, density_below] = table.mean(anchor.band);
    let natural = |f: f64| table.at(f)[1];
    let nodes = model.surface.nodes.len() as f64;
    let thirds = 3.0 * (highest / from).log2();
    let most = (MOST_VALUES / (3.0 * nodes * thirds)).clamp(FEWEST_PER_THIRD_OCTAVE, PER_THIRD_OCTAVE);
    let synthetic = |f: f64| natural(f).min(most / (THIRD_OCTAVE * f));
    let frequencies = frequencies([from, highest], synthetic, random);
    let stands_for = integral([from, highest], natural).last().map_or(0.0, |row| row[1]);
    let anchors = &model.modes[anchor.modes.clone()];
    // Coordinates of all nodes, mode by mode.
    let coordinates = 3 * model.surface.nodes.len();
    let known: Vec<f64> =
        anchors.iter().flat_map(|mode| mode.shape.iter().flat_map(|u| u.to_array())).collect();
    let known = MatRef::from_column_major_slice(&known, coordinates, anchors.len());
    let mut modes = Vec::with_capacity(frequencies.len());
    for block in frequencies.chunks(anchors.len()) {
        // Shares of the anchor in each mode of the block.
        let mut shares = Vec::with_capacity(block.len() * anchors.len());
        for (frequency, row) in block.iter().zip(orthogonal(anchors.len(), random)) {
            let mobility = table.at(*frequency)[0] / mobility_below;
            let scale = (mobility * density_below / synthetic(*frequency)).sqrt();
            shares.extend(row.into_iter().map(|share| scale * share));
        }
        let mut shapes = vec![0.0; coordinates * block.len()];
        matmul(
            MatMut::from_column_major_slice_mut(&mut shapes, coordinates, block.len()),
            Accum::Replace,
            known,
            MatRef::from_column_major_slice(&shares, anchors.len(), block.len()),
            1.0,
            Par::Seq,
        );
        for (k, frequency) in block.iter().enumerate() {
            let own = &shares[k * anchors.len()..][..anchors.len()];
            let shape = &shapes[k * coordinates..][..coordinates];
            // Dampers of supports take from a mode as its square at them, in the mean.
            let damping = own.iter().zip(anchors).map(|(share, known)| share * share * known.support_damping);
            modes.push(ModalMode {
                frequency: *frequency,
                mesh_error: f64::NAN,
                support_damping: damping.sum(),
                shape: shape.chunks_exact(3).map(DVec3::from_slice).collect(),
                transfer: None,
            });
        }
    }
    (modes, stands_for)
}

/// Frequencies and the integral of a density up to each, over a band \[Hz\].
fn integral([from, to]: [f64; 2], density: impl Fn(f64) -> f64) -> Vec<[f64; 2]> {
    let steps = (STEPS * (to / from).log2()).ceil().max(1.0) as usize;
    let at = |i: usize| from * (to / from).powf(i as f64 / steps as f64);
    let mut rows = vec![[from, 0.0]];
    let mut sum = 0.0;
    for i in 0..steps {
        let [a, b] = [at(i), at(i + 1)];
        sum += 0.5 * (b - a) * (density(a) + density(b));
        rows.push([b, sum]);
    }
    rows
}

/// Ascending frequencies of this density over a band \[Hz\]: one in each interval of expected number 1.
fn frequencies(band: [f64; 2], density: impl Fn(f64) -> f64, random: &mut SplitMix) -> Vec<f64> {
    let rows = integral(band, density);
    let total = rows.last().map_or(0.0, |row| row[1]);
    let mut found = Vec::with_capacity(total as usize + 1);
    let mut row = 0;
    for k in 0..total.ceil() as usize {
        let wanted = k as f64 + random.uniform(0.0, 1.0);
        if wanted >= total {
            break;
        }
        while rows[row + 1][1] < wanted {
            row += 1;
        }
        let ([a, before], [b, after]) = (rows[row], rows[row + 1]);
        found.push(a + (b - a) * (wanted - before) / (after - before));
    }
    found
}
