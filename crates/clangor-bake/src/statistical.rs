//! Statistical ringing: what a body sounds like above the modes that can be found.
//!
//! Where modes are too many, only their mean matters: an impact gives them energy by the mobility of the
//! surface, they lose it by the material and by radiation, and they radiate by their efficiency (statistical
//! energy analysis, \[LyonDeJong1995\]).
//!
//! ```text
//! E_Δω = (1/π) ∫_Δω |F(ω)|² Re Y dω      P = η_rad ω E      η_rad = ρ c A σ ⟨U_n²⟩/ω
//! ```
//!
//! The mean is realised by synthetic modes, so that everything that plays modes plays them: resonators,
//! contacts, files, the live engine.
//!
//! ```text
//! modes of the last octave ─► level of Re Y, of ⟨U_n²⟩, of σ, shapes         (anchor)
//! wall, volume, surface    ─► how these change with the frequency            (mean_vibration)
//!                          ─► frequencies and shapes (synthetic_modes), transfers (diffuse_transfer)
//! ```
//!
//! A level is that of the last octave at its end, and follows theory from there. What σ has of its own there
//! goes as waves become faster than sound:
//!
//! ```text
//! σ(f) = σ_th(f) r^w     r = σ/σ_th of the anchor
//! w = ln σ_th(f)/ln σ_th(anchor), 0 to 1, while σ_th(anchor) < 0.7, else 1;  (f_c/f)² at most, if k_s < k
//! ```
//!
//! Single modes of the anchor lie above and below r; synthetic ones draw from them.
//!
//! Differs from statistical energy analysis: bands have single modes where they are fewer than
//! [`PER_THIRD_OCTAVE`] in a third of an octave.
//!
//! What it is not: pitch. Levels are means over places, listeners and bands.

mod diffuse_transfer;
mod edge_radiation;
mod layer_waves;
mod mean_table;
mod mean_vibration;
mod random_numbers;
mod surface_motion;
mod synthetic_modes;

use std::f64::consts::TAU;

use clangor_core::geometry::surface_tree::SurfaceTree;
use clangor_core::material::Material;
use clangor_core::math::random::SplitMix;
use clangor_core::sound_model::files::modal_file::round_shape;
use clangor_core::sound_model::modal::model::ModalModel;

use crate::geometry_class::outside::outer_surface;
use crate::mesh::tetrahedra::isosurface_stuffing::wall_quantile;
use diffuse_transfer::HeardDirections;
use mean_table::MeanTable;
use mean_vibration::MeanVibration;
use surface_motion::NormalMotion;
use synthetic_modes::{Anchor, synthetic_modes};

pub use synthetic_modes::PER_THIRD_OCTAVE;

/// Expected error of a third of an octave \[dB\], in the mean over places and listeners
/// (tests/cross/statistical.rs).
pub const SPREAD_DB: f64 = 2.0;
/// σ from which a body counts as radiating like a large one.
const LARGE: f64 = 0.7;

/// Ratio of frequencies within which sound leaves in the same directions.
const SAME_DIRECTIONS: f64 = 1.1;

/// What was added to a model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StatisticalBand {
    /// Frequency from which ringing is statistical \[Hz\].
    pub from: f64,
    /// Synthetic modes.
    pub modes: usize,
    /// Modes of the body for which they stand, estimated.
    pub stands_for: f64,
}

/// Adds synthetic modes, without transfers, from the end of the band of a model to `highest` \[Hz\]. Returns
/// `None` where there is no such band, or no mode below.
///
/// `volume` \[m³\] of the body, of `material`.
pub fn add_synthetic_modes(
    model: &mut ModalModel,
    volume: f64,
    material: &Material,
    highest: f64,
) -> Option<StatisticalBand> {
    let from = model.max_frequency;
    if from >= highest || model.statistical_above.is_some() {
        return None;
    }
    let anchor = Anchor::of(&model.modes, from)?;
    let mean = mean_vibration(model, volume, material);
    let mut random = SplitMix::new(seed(model));
    let (mut modes, stands_for) = synthetic_modes(model, &anchor, &mean, highest, &mut random);
    modes.iter_mut().for_each(|mode| round_shape(&mut mode.shape));
    let band = StatisticalBand { from, modes: modes.len(), stands_for };
    model.modes.extend(modes);
    model.max_frequency = highest;
    model.statistical_above = Some(from);
    Some(band)
}

/// Computes the transfers of the synthetic modes from those of the known ones.
///
/// `volume` \[m³\] of the body, of `material`.
pub fn radiate_synthetic_modes(model: &mut ModalModel, volume: f64, material: &Material) {
    let Some(from) = model.statistical_above else { return };
    let known = model.known_modes().len();
    let Some(anchor) = Anchor::of(model.known_modes(), from) else { return };
    let mean = mean_vibration(model, volume, material);
    let (radius, medium) = (model.radius, model.medium);
    let band = [anchor.band[0], model.max_frequency];
    let table = MeanTable::new(band, |f| {
        [mean.normal_motion(f), mean.efficiency(f, &medium), mean.slowness(f, &medium)]
    });
    let Some(radiation) = Radiation::of(model, &anchor, &table) else { return };
    let mut random = SplitMix::new(seed(model).wrapping_add(1));
    let heard = HeardDirections::new(&outer_surface(&model.surface));
    // P of a mode, over ρR⁴/c.
    let unit = medium.density * radius.powi(4) / medium.sound_speed;
    let (mut amplitudes, mut amplitudes_to) = (Vec::new(), 0.0);
    for mode in &mut model.modes[known..] {
        let wavenumber = TAU * mode.frequency / medium.sound_speed;
        // Directions change slowly.
        if mode.frequency >= amplitudes_to {
            amplitudes = heard.amplitudes(mean.slowness(mode.frequency, &medium), wavenumber);
            amplitudes_to = SAME_DIRECTIONS * mode.frequency;
        }
        let power = radiation.power(mode.frequency, &table, random.uniform(0.0, 1.0)) / unit;
        mode.transfer = Some(heard.transfer(wavenumber * radius, power, &amplitudes, &mut random));
    }
}

/// How the modes of the anchor radiate.
struct Radiation {
    /// ½ ρ c A ⟨U_n²⟩, over the theory's ⟨U_n²⟩.
    scale: f64,
    /// f_c \[Hz\].
    from: f64,
    /// σ_th of the anchor.
    efficiency: f64,
    /// σ/σ_th of its modes, and the sum of their weights up to each; the last is 1.
    ratios: Vec<[f64; 2]>,
}

impl Radiation {
    /// `None` if no mode of the anchor moves along the normal.
    fn of(model: &ModalModel, anchor: &Anchor, table: &MeanTable<3>) -> Option<Self> {
        let motion = NormalMotion::new(&outer_surface(&model.surface));
        let medium = &model.medium;
        let surface = 0.5 * medium.density * medium.sound_speed * motion.area;
        let unit = medium.density * model.radius.powi(4) / medium.sound_speed;
        // Weights by the energy that a normal force gives, and by the power at equal σ.
        let (mut squares, mut fourths, mut efficiency) = (0.0, 0.0, 0.0);
        let mut ratios = Vec::new();
        for mode in &model.modes[anchor.modes.clone()] {
            let square = motion.mean_square(&mode.shape);
            let weight = square * square;
            let [_, theory, _] = table.at(mode.frequency);
            squares += square;
            fourths += weight;
            efficiency += weight * theory;
            if let Some(transfer) = mode.transfer.as_ref().filter(|_| weight > 0.0) {
                let omega = TAU * mode.frequency;
                let power = unit * transfer.power(omega * model.radius / medium.sound_speed);
                ratios.push([power * omega * omega / (surface * square * theory), weight * theory]);
            }
        }
        let total: f64 = ratios.iter().map(|ratio| ratio[1]).sum();
        let mut sum = 0.0;
        for ratio in &mut ratios {
            sum += ratio[1] / total;
            ratio[1] = sum;
        }
        let [motion_below, ..] = table.mean(anchor.band);
        let efficiency = efficiency / fourths;
        let scale = surface * fourths / (squares * motion_below);
        (fourths > 0.0).then_some(Radiation { scale, from: anchor.band[1], efficiency, ratios })
    }

    /// P of a synthetic mode of unit acceleration [W s⁴/(kg m²)]; `place` from 0 to 1 draws a mode of the
    /// anchor.
    fn power(&self, frequency: f64, table: &MeanTable<3>, place: f64) -> f64 {
        let [motion, efficiency, slowness] = table.at(frequency);
        let drawn = self.ratios.partition_point(|ratio| ratio[1] < place).min(self.ratios.len().max(1) - 1);
        let ratio = self.ratios.get(drawn).map_or(1.0, |ratio| ratio[0]);
        let mut weight = 1.0;
        if self.efficiency < LARGE {
            weight = (efficiency.ln() / self.efficiency.ln()).clamp(0.0, 1.0);
        }
        if slowness < 1.0 {
            weight = (self.from / frequency).powi(2).min(weight);
        }
        self.scale * motion * efficiency * ratio.powf(weight) / (TAU * frequency).powi(2)
    }
}

/// The body as a wall of its median thickness.
fn mean_vibration(model: &ModalModel, volume: f64, material: &Material) -> MeanVibration {
    let surface = model.surface.quarters();
    let thickest = 2.0 * model.radius;
    let wall = wall_quantile(&surface, &SurfaceTree::new(&surface), 0.5).min(thickest);
    MeanVibration::new(material, volume, surface.area(), wall)
}

/// A seed from the known modes: the same body has the same synthetic modes.
fn seed(model: &ModalModel) -> u64 {
    let known = model.known_modes().iter().map(|mode| mode.frequency);
    let numbers = known.chain([model.radius, model.density]);
    // FNV-1a over 64-bit words.
    numbers.fold(0xcbf2_9ce4_8422_2325, |hash, x| (hash ^ x.to_bits()).wrapping_mul(0x0000_0100_0000_01b3))
}
