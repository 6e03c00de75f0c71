//! A modal soundbank of ellipsoids as bytes; docs/format/model.md describes it.
//!
//! Only harmonics of the parity of a mode are stored, an eighth of all, as 16-bit integers with one scale for
//! the shape and one for the multipoles of each mode: off by at most 1/65534 of the largest.

use glam::DVec3;
use num_complex::Complex64;
use serde::{Deserialize, Serialize};

use crate::medium::Medium;
use crate::sound_model::files::tensor_file::{TensorFileError, TensorReader, TensorWriter, check_finite};
use crate::sound_model::soundbank::modal_soundbank::{
    BankMaterial, EllipsoidMode, ModalSoundbank, RingingEllipsoid, parity_harmonics,
};

/// Version of the format.
pub const VERSION: u32 = 1;
/// Kind of the file in its description.
pub const KIND: &str = "modal ellipsoid soundbank";

/// Limits of a file: number of ellipsoids, highest degree, highest order.
const MOST_ELLIPSOIDS: usize = 10_000;
const HIGHEST_DEGREE: usize = 64;
const HIGHEST_ORDER: i16 = 255;

/// A bank with its origin.
#[derive(Clone, Debug, PartialEq)]
pub struct ModalSoundbankFile {
    /// The ellipsoids.
    pub bank: ModalSoundbank,
    /// Its origin and accuracy.
    pub origin: ModalSoundbankOrigin,
}

/// Origin and accuracy of a bank.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModalSoundbankOrigin {
    /// Program and version.
    pub program: String,
    /// Hash of material, medium and options.
    pub inputs: String,
    /// The material, as given by the user.
    pub material: String,
    /// Level error of the transfers that was requested.
    pub asked_accuracy: f64,
    /// Largest difference of the logarithms of frequencies between neighbours.
    pub spacing: f64,
    /// Lowest frequency of a body \[Hz\] from which on it has all modes below the highest frequency.
    #[serde(rename = "least_first_frequency_hz")]
    pub least_first_frequency: f64,
    /// Largest size ‖(a, b, c)‖ of a body for which that holds \[m\].
    #[serde(rename = "largest_size_m")]
    pub largest_size: f64,
    /// The highest frequency \[Hz\].
    #[serde(rename = "max_frequency_hz")]
    pub max_frequency: f64,
}

#[derive(Serialize, Deserialize)]
struct Description {
    kind: String,
    version: u32,
    units: String,
    youngs_modulus_pa: f64,
    density_kg_m3: f64,
    poisson_ratio: f64,
    medium_density_kg_m3: f64,
    sound_speed_m_s: f64,
    degree: usize,
    origin: ModalSoundbankOrigin,
}

const UNITS: &str = "SI; ellipsoids of a^2 + b^2 + c^2 = 1 m^2 along x, y, z; shapes and transfers in \
kg^-1/2, by real harmonics of the parity of each mode; transfers are pressure over (density of the medium, \
longest semi-axis, modal \
acceleration), each wave made 1 on the bounding sphere";

impl ModalSoundbankFile {
    /// The bytes of the file. The same bank gives the same bytes.
    ///
    /// # Errors
    /// [`TensorFileError`] for numbers outside the range of the file.
    pub fn encode(&self) -> Result<Vec<u8>, TensorFileError> {
        let entries = self.bank.entries();
        let modes: Vec<&EllipsoidMode> = entries.iter().flat_map(|entry| &entry.modes).collect();
        let (mut shapes, mut shape_scales) = (Vec::new(), Vec::new());
        let (mut transfers, mut transfer_scales) = (Vec::new(), Vec::new());
        for mode in &modes {
            shape_scales.push(put(mode.shape.iter().flatten().copied(), &mut shapes));
            transfer_scales.push(put(mode.transfer.iter().flat_map(|c| [c.re, c.im]), &mut transfers));
        }
        check_finite("shape_scales", &shape_scales)?;
        check_finite("transfer_scales", &transfer_scales)?;
        let mut file = TensorWriter::default();
        let numbers = entries.iter().flat_map(|e| {
            let DVec3 { x, y, z } = e.semi_axes;
            [x, y, z, e.max_frequency]
        });
        file.add("ellipsoids", &[entries.len(), 4], numbers);
        file.add("counts", &[entries.len()], entries.iter().map(|e| e.modes.len() as u32));
        file.add("frequencies", &[modes.len()], modes.iter().map(|m| m.frequency));
        file.add("parities", &[modes.len()], modes.iter().map(|m| i16::from(m.parity)));
        file.add("orders", &[modes.len()], modes.iter().map(|m| m.order as i16));
        file.add("shape_scales", &[modes.len()], shape_scales);
        file.add("shapes", &[shapes.len()], shapes);
        file.add("transfer_scales", &[modes.len()], transfer_scales);
        file.add("transfers", &[transfers.len()], transfers);
        let material = self.bank.material();
        file.finish(&Description {
            kind: KIND.into(),
            version: VERSION,
            units: UNITS.into(),
            youngs_modulus_pa: material.youngs_modulus,
            density_kg_m3: material.density,
            poisson_ratio: material.poisson_ratio,
            medium_density_kg_m3: material.medium.density,
            sound_speed_m_s: material.medium.sound_speed,
            degree: self.bank.degree(),
            origin: self.origin.clone(),
        })
    }

    /// Reads a file.
    ///
    /// # Errors
    /// [`TensorFileError`] for anything that [`encode`](Self::encode) does not write.
    pub fn decode(bytes: &[u8]) -> Result<Self, TensorFileError> {
        let file = TensorReader::open(bytes, KIND, VERSION)?;
        let description: Description = file.describe()?;
        let degree = description.degree;
        if degree > HIGHEST_DEGREE {
            return Err(TensorFileError::value("the degree of shapes", format!("is above {HIGHEST_DEGREE}")));
        }
        let (count, ellipsoids) = file.rows::<f64>("ellipsoids", &[4])?;
        if count > MOST_ELLIPSOIDS {
            return Err(TensorFileError::value(
                "the array \"ellipsoids\"",
                format!("has {count} rows, more than {MOST_ELLIPSOIDS}"),
            ));
        }
        let counts = file.array::<u32>("counts", &[count])?;
        let (all, frequencies) = file.rows::<f64>("frequencies", &[])?;
        let parities = file.array::<i16>("parities", &[all])?;
        let orders = file.array::<i16>("orders", &[all])?;
        let scales = [file.array::<f32>("shape_scales", &[all])?, file.array("transfer_scales", &[all])?];
        let (shapes, transfers) = (file.rows::<i16>("shapes", &[])?.1, file.rows::<i16>("transfers", &[])?.1);
        let (mut shapes, mut transfers) = (shapes.as_slice(), transfers.as_slice());
        let mut modes = Vec::with_capacity(all);
        for at in 0..all {
            let (parity, order) = (parities[at], orders[at]);
            if !(0..8).contains(&parity) || !(0..=HIGHEST_ORDER).contains(&order) {
                return Err(TensorFileError::value(
                    format!("mode {at}"),
                    format!("has the parity {parity} and the order {order}"),
                ));
            }
            let (parity, order) = (parity as u8, order as usize);
            let mut shape: [Vec<f64>; 3] = Default::default();
            for (axis, component) in shape.iter_mut().enumerate() {
                let length = parity_harmonics(parity ^ (1 << axis), degree).len();
                *component = take(&mut shapes, "shapes", length, scales[0][at])?;
            }
            let length = 2 * parity_harmonics(parity, order).len();
            let numbers = take(&mut transfers, "transfers", length, scales[1][at])?;
            let transfer = numbers.chunks_exact(2).map(|c| Complex64::new(c[0], c[1])).collect();
            modes.push(EllipsoidMode { frequency: frequencies[at], parity, shape, order, transfer });
        }
        let mut modes = modes.into_iter();
        let mut entries = Vec::with_capacity(count);
        for (numbers, count) in ellipsoids.chunks_exact(4).zip(counts) {
            entries.push(RingingEllipsoid {
                semi_axes: DVec3::from_slice(numbers),
                max_frequency: numbers[3],
                modes: modes.by_ref().take(count as usize).collect(),
            });
        }
        if modes.next().is_some() || !shapes.is_empty() || !transfers.is_empty() {
            return Err(TensorFileError::value("an array", "is longer than \"counts\" says"));
        }
        let material = BankMaterial {
            youngs_modulus: description.youngs_modulus_pa,
            density: description.density_kg_m3,
            poisson_ratio: description.poisson_ratio,
            medium: Medium {
                density: description.medium_density_kg_m3,
                sound_speed: description.sound_speed_m_s,
            },
        };
        let bank = ModalSoundbank::try_new(material, degree, entries)
            .map_err(|error| TensorFileError::value("the bank", format!("is wrong: {error}")))?;
        Ok(ModalSoundbankFile { bank, origin: description.origin })
    }
}

/// Adds numbers as 16-bit multiples of 1/32767 of the largest of them.
fn put(numbers: impl Iterator<Item = f64> + Clone, all: &mut Vec<i16>) -> f32 {
    let largest = numbers.clone().fold(0.0, |m: f64, x| m.max(x.abs()));
    let scale = (largest / f64::from(i16::MAX)) as f32;
    let part = |x: f64| if scale > 0.0 { (x / f64::from(scale)).round() as i16 } else { 0 };
    all.extend(numbers.map(part));
    scale
}

/// The next numbers of an array.
fn take(array: &mut &[i16], name: &str, count: usize, scale: f32) -> Result<Vec<f64>, TensorFileError> {
    let (taken, rest) = array.split_at_checked(count).ok_or_else(|| {
        TensorFileError::value(format!("the array \"{name}\""), "is shorter than \"counts\" says")
    })?;
    *array = rest;
    Ok(taken.iter().map(|x| f64::from(*x) * f64::from(scale)).collect())
}
