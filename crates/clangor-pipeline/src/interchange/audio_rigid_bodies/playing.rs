//! From a body of a file to what the rest of the program plays: a material with its damping, and a modal
//! model about the centre of mass, without transfers.

use std::f64::consts::LN_10;

use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::material::{Damping, Material, presets};
use clangor_core::medium::Medium;
use clangor_core::sound_model::modal::model::{ModalMode, ModalModel};
use clangor_core::sound_model::modal::surface::ModalSurface;

use super::{AudioBody, AudioMaterial, Ringing};

/// Longest T60 \[s\]: what does not decay at all gets this one.
const LONGEST_DECAY: f64 = 1e6;
/// Loss factor where nothing says how a material damps.
const UNKNOWN_LOSS: f64 = 1e-3;
/// Part by which the mass of a body may differ from that of its mesh in its material, before it is told.
const SAME_MASS: f64 = 0.03;
/// How far a centre of mass may be from that of the mesh, over its radius, before it is told.
const SAME_CENTRE: f64 = 0.02;

/// Why a body cannot be played.
#[derive(Debug, thiserror::Error)]
pub enum AudioUseError {
    /// The file has several, and none was named.
    #[error("there are several bodies, {names}; choose one, as in {file}#{first}")]
    Several {
        /// The file.
        file: String,
        /// All names.
        names: String,
        /// One of them.
        first: String,
    },
    /// The name is none, or one of several.
    #[error("{count} bodies in {file} are named \"{name}\"; there are {names}")]
    Name {
        /// The file.
        file: String,
        /// What was asked for.
        name: String,
        /// How many have it.
        count: usize,
        /// All names.
        names: String,
    },
    /// A number that the file does not have.
    #[error("the file does not tell the {what} of \"{body}\"; add --material NAME")]
    Unknown {
        /// The body.
        body: String,
        /// What is missing.
        what: &'static str,
    },
}

/// What a body of a file is to the rest of the program.
#[derive(Clone, Debug, PartialEq)]
pub struct Played {
    /// Its material, which has the mass and the decays of the file.
    pub material: Material,
    /// How it rings, if the file tells.
    pub modal: Option<ModalModel>,
    /// What a user should know.
    pub remarks: Vec<String>,
}

/// The body of this name, or the only one, or the only one that rings; `None` if there are none.
///
/// # Errors
/// [`AudioUseError`]; `file` is for its message.
pub fn choose_body(
    bodies: Vec<AudioBody>,
    name: Option<&str>,
    file: &str,
) -> Result<Option<AudioBody>, AudioUseError> {
    let names = || bodies.iter().map(|b| format!("\"{}\"", b.name)).collect::<Vec<_>>().join(", ");
    let chosen: Vec<usize> = match name {
        Some(name) => (0..bodies.len()).filter(|i| bodies[*i].name == name).collect(),
        None if bodies.len() == 1 => vec![0],
        None => (0..bodies.len()).filter(|i| bodies[*i].ringing.is_some()).collect(),
    };
    match (name, chosen[..].len()) {
        _ if bodies.is_empty() => Ok(None),
        (_, 1) => Ok(bodies.into_iter().nth(chosen[0])),
        (None, _) => Err(AudioUseError::Several {
            file: file.into(),
            names: names(),
            first: bodies.first().map(|b| b.name.clone()).unwrap_or_default(),
        }),
        (Some(name), count) => {
            Err(AudioUseError::Name { file: file.into(), name: name.into(), count, names: names() })
        }
    }
}

impl AudioBody {
    /// The same body `factor` times as large.
    #[must_use]
    pub fn scaled(mut self, factor: f64) -> Self {
        self.mesh.vertices.iter_mut().for_each(|x| *x *= factor);
        if let Some(mass) = &mut self.mass {
            mass.mass *= factor.powi(3);
            mass.centre_of_mass *= factor;
            mass.inertia *= factor.powi(5);
        }
        if let Some(ringing) = &mut self.ringing {
            ringing.resize(factor, &self.material);
            ringing.surface.nodes.iter_mut().for_each(|x| *x *= factor);
        }
        self
    }

    /// What the body is to the rest of the program. `solid` are the mass properties of its mesh, of unit
    /// density; `otherwise` has what the file does not tell of the material, before a preset of the
    /// material's name.
    ///
    /// The body is taken as uniform: its density is the mass of the file over the volume of the mesh.
    ///
    /// # Errors
    /// [`AudioUseError::Unknown`].
    pub fn played(
        &self,
        solid: &MassProperties,
        otherwise: Option<&Material>,
    ) -> Result<Played, AudioUseError> {
        let mut remarks = self.remarks.clone();
        let name = self.material.name.clone();
        let preset = name.as_deref().and_then(|name| presets::preset(&name.to_lowercase()));
        let base = otherwise.or(preset.as_ref());
        let unknown = |what| AudioUseError::Unknown { body: self.name.clone(), what };
        let AudioMaterial { density, youngs_modulus, poisson_ratio, alpha, beta, .. } = self.material;
        let density = density.or(base.map(|b| b.density));
        let density = match &self.mass {
            Some(mass) => {
                let of_mass = mass.mass / solid.volume;
                if let Some(density) = density.filter(|d| (of_mass / d - 1.0).abs() > SAME_MASS) {
                    remarks.push(format!(
                        "{} kg make {of_mass:.0} kg/m³ of the mesh, not {density:.0} as the material: the \
                         mass holds",
                        mass.mass
                    ));
                }
                let apart = mass.centre_of_mass.distance(solid.centre_of_mass);
                if apart > SAME_CENTRE * self.mesh.bounding_radius(solid.centre_of_mass) {
                    remarks.push(format!(
                        "the centre of mass is {apart:.2e} m from that of the mesh: the body is taken as \
                         uniform"
                    ));
                }
                of_mass
            }
            None => density.ok_or_else(|| unknown("density"))?,
        };
        let damping = match &self.ringing {
            Some(ringing) => ringing.damping(),
            None if alpha.or(beta).is_some() => {
                Damping::Rayleigh { alpha: alpha.unwrap_or(0.0), beta: beta.unwrap_or(0.0), g: 0.0 }
            }
            None => base.map(|b| b.damping.clone()).unwrap_or_else(|| {
                remarks.push(format!("nothing tells the damping: a loss factor of {UNKNOWN_LOSS} is taken"));
                Damping::LossFactor(UNKNOWN_LOSS)
            }),
        };
        let youngs_modulus = youngs_modulus.or(base.map(|b| b.youngs_modulus));
        let poisson_ratio = poisson_ratio.or(base.map(|b| b.poisson_ratio));
        let material = Material {
            name: name.or(base.map(|b| b.name.clone())).unwrap_or_else(|| self.name.clone()),
            density,
            youngs_modulus: youngs_modulus.ok_or_else(|| unknown("Young's modulus"))?,
            poisson_ratio: poisson_ratio.ok_or_else(|| unknown("Poisson's ratio"))?,
            damping,
            source: format!("{}, and presets", super::EXTENSION),
            ..base.cloned().unwrap_or_else(|| presets::STEEL.material())
        };
        let modal = self.ringing.as_ref().map(|ringing| ringing.model(solid, density));
        Ok(Played { material, modal, remarks })
    }
}

impl Ringing {
    /// The decays of the modes, as damping against frequency.
    pub fn damping(&self) -> Damping {
        let mut rows: Vec<[f64; 2]> = Vec::with_capacity(self.modes.len());
        for mode in &self.modes {
            let t60 = (3.0 * LN_10 / mode.decay_rate).min(LONGEST_DECAY);
            match rows.last_mut() {
                // Of modes of one frequency the one that lasts decides.
                Some(row) if row[0] == mode.frequency => row[1] = row[1].max(t60),
                _ => rows.push([mode.frequency, t60]),
            }
        }
        Damping::T60Table(rows)
    }

    /// The model about the centre of mass, in air.
    fn model(&self, solid: &MassProperties, density: f64) -> ModalModel {
        let surface = ModalSurface {
            nodes: self.surface.nodes.iter().map(|x| *x - solid.centre_of_mass).collect(),
            triangles: self.surface.triangles.clone(),
        };
        let highest = self.modes.last().map_or(0.0, |mode| mode.frequency);
        let mode = |mode: &super::RingingMode| ModalMode {
            frequency: mode.frequency,
            mesh_error: f64::NAN,
            support_damping: 0.0,
            shape: mode.shape.clone(),
            transfer: None,
        };
        ModalModel {
            radius: surface.radius(),
            medium: Medium::AIR,
            density,
            max_frequency: self.max_frequency.unwrap_or(highest),
            statistical_above: None,
            surface,
            modes: self.modes.iter().map(mode).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::interchange::audio_rigid_bodies::RingingMode;

    #[test]
    fn decays_come_back_from_the_damping() {
        let mode = |frequency: f64, decay_rate: f64| RingingMode { frequency, decay_rate, shape: Vec::new() };
        let modes =
            vec![mode(440.0, 3.0), mode(500.0, 0.0), mode(700.0, 9.0), mode(700.0, 7.0), mode(9e3, 800.0)];
        let ringing = Ringing { surface: ModalSurface::default(), modes, max_frequency: None };
        let damping = ringing.damping();
        damping.check().unwrap();
        for (frequency, rate) in [(440.0, 3.0), (500.0, 7e-6), (700.0, 7.0), (9e3, 800.0)] {
            let found = damping.damping_ratio(frequency) * TAU * frequency;
            // Residual seen: 0, and 9e-8 for what hardly decays.
            assert!((found - rate).abs() < 1e-13 * rate + 1e-7, "{frequency} Hz: {found}");
        }
    }
}
