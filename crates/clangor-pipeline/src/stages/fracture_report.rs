//! What broke, what became of the energy, and as what the pieces ring: a JSON file beside a simulation or a
//! sound.
//!
//! Of each fracture
//!
//! ```text
//! impact  ½ m V²  ≥  strain  E_S  ≥  cracks  G_c A_F  +  motion of the pieces  ΔE_K
//! ```
//!
//! Source: \[FRAC\] Table 3 and Fig. 9, which counts how often each ellipsoid of the bank is used.

use std::collections::BTreeMap;

use clangor_core::body::{Body, BodyId};
use clangor_core::synthesis::{BodyModes, NoModes};
use clangor_core::timeline::FractureRow;
use clangor_sim::BreakingReport;
use serde::{Deserialize, Serialize};

use crate::stages::sound_models::SoundModels;

/// See the module. Energies are in joules.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FractureReport {
    /// In order of time.
    pub fractures: Vec<Fracture>,
    /// Of all.
    pub totals: Totals,
    /// What became of the impacts; only of a simulation.
    #[serde(default, skip_serializing_if = "Option::is_none", alias = "blows")]
    pub impacts: Option<ImpactCounts>,
    /// As what the pieces ring; only of a sound.
    #[serde(rename = "modal", alias = "ringing", default, skip_serializing_if = "Option::is_none")]
    pub ringing: Option<PiecesRinging>,
}

/// A body that broke.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fracture {
    /// When \[s\].
    #[serde(rename = "time_s")]
    pub time: f64,
    /// Its name.
    pub body: String,
    /// Its mass \[kg\].
    #[serde(rename = "mass_kg")]
    pub mass: f64,
    /// Into how many it broke.
    pub pieces: u32,
    /// ½ m V² of the impacts.
    #[serde(rename = "impact_energy_j", alias = "blow_energy_j")]
    pub impact_energy: f64,
    /// E_S.
    #[serde(rename = "strain_energy_j")]
    pub strain_energy: f64,
    /// A_F G_c.
    #[serde(rename = "fracture_energy_j")]
    pub fracture_energy: f64,
    /// What the impulses of the cracks gave to the motion of the pieces.
    #[serde(rename = "crack_impulse_energy_j")]
    pub crack_impulse_energy: f64,
    /// A_F \[m²\].
    #[serde(rename = "crack_area_m2")]
    pub crack_area: f64,
    /// τ of the impulses of the cracks \[s\].
    #[serde(rename = "crack_duration_s")]
    pub crack_duration: f64,
    /// Of the pattern.
    pub seed: u64,
}

/// Sums over all fractures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Totals {
    /// Bodies that broke.
    pub fractures: usize,
    /// Pieces that are whole at the end.
    pub pieces: usize,
    /// ½ m V².
    #[serde(rename = "impact_energy_j", alias = "blow_energy_j")]
    pub impact_energy: f64,
    /// E_S.
    #[serde(rename = "strain_energy_j")]
    pub strain_energy: f64,
    /// A_F G_c.
    #[serde(rename = "fracture_energy_j")]
    pub fracture_energy: f64,
    /// What the impulses of the cracks gave.
    #[serde(rename = "crack_impulse_energy_j")]
    pub crack_impulse_energy: f64,
    /// A_F \[m²\].
    #[serde(rename = "crack_area_m2")]
    pub crack_area: f64,
}

/// What became of the impacts on bodies that may break.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ImpactCounts {
    /// Too weak for any stress to reach the strength.
    pub screened: u64,
    /// Those for which stress was computed.
    pub solved: u64,
    /// Impacts whose force over time could not be solved.
    #[serde(default)]
    pub unsolved: u64,
    /// Beyond the strength, but they paid for no crack.
    pub withstood: u64,
    /// Beyond the strength, when there were as many pieces as are allowed.
    pub capped: u64,
    /// Bodies that should have broken and could not, and why.
    pub refused: BTreeMap<String, String>,
}

/// As what pieces ring.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PiecesRinging {
    /// Pieces with modes of their own.
    pub own_pieces: usize,
    /// Their modes.
    pub own_modes: usize,
    /// Pieces that ring as ellipsoids.
    pub proxy_pieces: usize,
    /// The modes of these in the band.
    pub proxy_modes: usize,
    /// Pieces that are struck and do not ring: their modes lie above the band, or cannot be found.
    pub silent_pieces: usize,
    /// The ellipsoids that were used.
    pub ellipsoids: Vec<EllipsoidUse>,
}

/// An ellipsoid of a bank, and what it stands for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EllipsoidUse {
    /// Its number in the bank.
    pub entry: usize,
    /// a ≤ b ≤ c, a² + b² + c² = 1.
    pub semi_axes: [f64; 3],
    /// Masses of the pieces that ring as it \[kg\].
    #[serde(rename = "masses_kg")]
    pub masses: Vec<f64>,
}

impl FractureReport {
    /// What is known of fractures; `bodies` are all that ever were.
    pub fn new(bodies: &[Body], fractures: &[FractureRow]) -> Self {
        let fracture = |row: &FractureRow| {
            let parent = bodies.get(row.parent.index());
            Fracture {
                time: row.time,
                body: parent.map_or_else(String::new, |body| body.name.clone()),
                mass: parent.map_or(0.0, |body| body.mass),
                pieces: row.children,
                impact_energy: row.impact_energy,
                strain_energy: row.strain_energy,
                fracture_energy: row.fracture_energy,
                crack_impulse_energy: row.kinetic_energy_gain,
                crack_area: row.crack_area,
                crack_duration: row.duration,
                seed: row.seed,
            }
        };
        let sum = |of: fn(&FractureRow) -> f64| fractures.iter().map(of).sum();
        let whole = |body: &&Body| body.life.parent.is_some() && body.life.death == f64::INFINITY;
        FractureReport {
            fractures: fractures.iter().map(fracture).collect(),
            totals: Totals {
                fractures: fractures.len(),
                pieces: bodies.iter().filter(whole).count(),
                impact_energy: sum(|row| row.impact_energy),
                strain_energy: sum(|row| row.strain_energy),
                fracture_energy: sum(|row| row.fracture_energy),
                crack_impulse_energy: sum(|row| row.kinetic_energy_gain),
                crack_area: sum(|row| row.crack_area),
            },
            ..FractureReport::default()
        }
    }

    /// With what a simulation says of impacts.
    #[must_use]
    pub fn with_impacts(self, report: &BreakingReport) -> Self {
        let BreakingReport { screened, solved, unsolved, withstood, capped, refused } = report.clone();
        FractureReport {
            impacts: Some(ImpactCounts { screened, solved, unsolved, withstood, capped, refused }),
            ..self
        }
    }

    /// With how the pieces among `bodies` ring.
    #[must_use]
    pub fn with_ringing(self, bodies: &[Body], models: &SoundModels) -> Self {
        let mut ringing = PiecesRinging::default();
        let mut used: BTreeMap<(usize, [u64; 3]), EllipsoidUse> = BTreeMap::new();
        for (index, body) in bodies.iter().enumerate().filter(|(_, body)| body.life.parent.is_some()) {
            let modes = models.mode_count(BodyId(index as u32));
            match models.bodies.get(index).map(|model| &model.modal) {
                Some(BodyModes::Own(_)) => {
                    ringing.own_pieces += 1;
                    ringing.own_modes += modes;
                }
                Some(BodyModes::Proxy(proxy)) => {
                    ringing.proxy_pieces += 1;
                    ringing.proxy_modes += modes;
                    let semi_axes = (proxy.semi_axes() / proxy.scale()).to_array();
                    // Ellipsoids of two banks may have the same number; dividing by the scale rounds.
                    let key = (proxy.entry(), semi_axes.map(|a| (a * 1e9).round() as u64));
                    let entry = proxy.entry();
                    let ellipsoid =
                        used.entry(key).or_insert(EllipsoidUse { entry, semi_axes, masses: Vec::new() });
                    ellipsoid.masses.push(body.mass);
                }
                Some(BodyModes::None(NoModes::Unwanted | NoModes::Unstruck)) | None => {}
                Some(BodyModes::None(_)) => ringing.silent_pieces += 1,
            }
        }
        ringing.ellipsoids = used.into_values().collect();
        FractureReport { ringing: Some(ringing), ..self }
    }
}

impl PiecesRinging {
    /// How many of all modes of pieces are those of ellipsoids.
    pub fn modes_by_proxies(&self) -> f64 {
        let all = self.own_modes + self.proxy_modes;
        if all == 0 { 0.0 } else { self.proxy_modes as f64 / all as f64 }
    }
}
