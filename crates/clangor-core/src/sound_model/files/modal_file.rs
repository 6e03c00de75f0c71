//! Modal models as bytes: a file of its own, or a part of a sound model; docs/format/model.md describes both.
//!
//! Unlike an acceleration model, a modal model belongs to one material and one medium. The stiffness
//! determines the modes, and a transfer holds only at the frequency of its mode. The damping of the material
//! is not stored: it may change without another bake. That by supports is, for a body that has any.
//!
//! Frequencies are stored in 64 bits, shapes and transfers in 32, whose 24 significant bits exceed the
//! accuracy of any mesh. Computed models are rounded in the same way ([`ModalPart::rounded`]), so that they
//! give the same samples as the file, bit by bit.

use glam::DVec3;
use num_complex::Complex64;
use serde::{Deserialize, Serialize};

use crate::medium::Medium;
use crate::quantity;
use crate::sound_model::files::number_checks::{RADII, all_within, within};
use crate::sound_model::files::solid::{Solid, SolidDescription};
use crate::sound_model::files::tensor_file::{TensorFileError, TensorReader, TensorWriter};
use crate::sound_model::modal::model::{ModalMode, ModalModel, ModalTransfer};
use crate::sound_model::modal::surface::ModalSurface;

/// Version of the format of a file with a modal model only.
pub const VERSION: u32 = 1;
/// Kind of such a file in its description.
pub const KIND: &str = "modal model";

/// Largest n in a file.
const HIGHEST_ORDER: usize = 255;
/// How far outside the bounding sphere a node may be, over the radius.
const OUTSIDE: f64 = 1e-6;

/// A modal model only.
#[derive(Clone, Debug, PartialEq)]
pub struct ModalFile {
    /// The modal model.
    pub modal: ModalPart,
    /// The solid that was baked.
    pub solid: Solid,
}

/// A modal model with its origin.
#[derive(Clone, Debug, PartialEq)]
pub struct ModalPart {
    /// The modes.
    pub model: ModalModel,
    /// Its origin and accuracy.
    pub origin: ModalOrigin,
}

/// Origin and accuracy of modes and transfers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModalOrigin {
    /// Program and version.
    pub program: String,
    /// Hash of geometry, elasticity, medium and options.
    pub inputs: String,
    /// The material, as given by the user.
    pub material: String,
    /// Young's modulus \[Pa\].
    #[serde(rename = "youngs_modulus_pa")]
    pub youngs_modulus: f64,
    /// Poisson's ratio \[-\].
    pub poisson_ratio: f64,
    /// Relative change of a frequency by a finer mesh that was requested as tolerance.
    pub asked_mesh_error: f64,
    /// Level error of the transfers that was requested.
    pub asked_accuracy: f64,
    /// The volume mesh, as text.
    pub mesh: String,
    /// Nodes of the volume mesh.
    pub nodes: u64,
    /// Largest ‖K u − ω² M u‖ / ‖ω² M u‖ \[-\].
    pub residual: f64,
    /// Lowest mode \[Hz\] of a body without modes below the highest frequency; absent for all others.
    #[serde(rename = "first_frequency_hz", default, skip_serializing_if = "Option::is_none")]
    pub first_frequency: Option<f64>,
    /// Solver of the transfers, as text; empty without transfers.
    pub method: String,
    /// Notes for the user.
    pub warnings: Vec<String>,
}

/// The description of a file of its own.
#[derive(Serialize, Deserialize)]
struct Description {
    kind: String,
    version: u32,
    units: String,
    modal: ModalDescription,
    solid: SolidDescription,
}

/// The description of the modal part of any file.
#[derive(Serialize, Deserialize)]
pub(super) struct ModalDescription {
    radius_m: f64,
    medium_density_kg_m3: f64,
    sound_speed_m_s: f64,
    density_kg_m3: f64,
    max_frequency_hz: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    statistical_above_hz: Option<f64>,
    origin: ModalOrigin,
}

const UNITS: &str = "SI; shapes in kg^-1/2 (integral of density U^2 = 1), transfers in kg^-1/2: pressure \
over (density of the medium, radius_m, modal acceleration), each wave made 1 on the sphere of radius_m about \
the centre of mass";

impl ModalFile {
    /// The bytes of the file. The same model gives the same bytes.
    ///
    /// # Errors
    /// [`TensorFileError`] for a model that [`decode`](Self::decode) would reject.
    pub fn encode(&self) -> Result<Vec<u8>, TensorFileError> {
        self.check()?;
        let mut file = TensorWriter::default();
        let modal = self.modal.put(&mut file);
        let solid = self.solid.put(&mut file);
        file.finish(&Description { kind: KIND.into(), version: VERSION, units: UNITS.into(), modal, solid })
    }

    /// Reads a file.
    ///
    /// # Errors
    /// [`TensorFileError`] for anything that [`encode`](Self::encode) does not write.
    pub fn decode(bytes: &[u8]) -> Result<Self, TensorFileError> {
        let file = TensorReader::open(bytes, KIND, VERSION)?;
        let Description { modal, solid, .. } = file.describe()?;
        let model = ModalFile { modal: ModalPart::take(&file, modal)?, solid: Solid::take(&file, solid)? };
        model.check()?;
        Ok(model)
    }

    fn check(&self) -> Result<(), TensorFileError> {
        self.modal.check()?;
        self.solid.check(self.modal.model.radius)
    }
}

impl ModalPart {
    /// The same with shapes and transfers in the precision of the file.
    #[must_use]
    pub fn rounded(mut self) -> Self {
        for mode in &mut self.model.modes {
            round_shape(&mut mode.shape);
            let transfer = mode.transfer.iter_mut().flat_map(|t| &mut t.coefficients);
            transfer.for_each(|c| *c = Complex64::new(single(c.re), single(c.im)));
        }
        self
    }

    /// Adds the arrays to a file, and returns the description of the rest.
    pub(super) fn put(&self, file: &mut TensorWriter) -> ModalDescription {
        let ModalModel { radius, medium, density, max_frequency, statistical_above, surface, modes } =
            &self.model;
        let nodes = surface.nodes.len();
        file.add("modal.nodes", &[nodes, 3], surface.nodes.iter().flat_map(|x| x.to_array()));
        file.add(
            "modal.triangles",
            &[surface.triangles.len(), 6],
            surface.triangles.iter().flatten().copied(),
        );
        file.add("modal.modes", &[modes.len(), 2], modes.iter().flat_map(|m| [m.frequency, m.mesh_error]));
        file.add(
            "modal.shapes",
            &[modes.len(), nodes, 3],
            modes.iter().flat_map(|m| &m.shape).flat_map(|u| u.to_array()).map(|u| u as f32),
        );
        if modes.iter().any(|m| m.support_damping != 0.0) {
            file.add("modal.support_damping", &[modes.len()], modes.iter().map(|m| m.support_damping));
        }
        let order = |m: &ModalMode| m.transfer.as_ref().map_or(-1, |t| t.order as i16);
        file.add("modal.orders", &[modes.len()], modes.iter().map(order));
        let transfers = || modes.iter().filter_map(|m| m.transfer.as_ref()).flat_map(|t| &t.coefficients);
        let count = transfers().count();
        file.add("modal.real", &[count], transfers().map(|c| c.re as f32));
        file.add("modal.imaginary", &[count], transfers().map(|c| c.im as f32));
        ModalDescription {
            radius_m: *radius,
            medium_density_kg_m3: medium.density,
            sound_speed_m_s: medium.sound_speed,
            density_kg_m3: *density,
            max_frequency_hz: *max_frequency,
            statistical_above_hz: *statistical_above,
            origin: self.origin.clone(),
        }
    }

    /// Reads it from a file.
    pub(super) fn take(
        file: &TensorReader<'_>,
        modal: ModalDescription,
    ) -> Result<ModalPart, TensorFileError> {
        let (nodes, positions) = file.rows::<f64>("modal.nodes", &[3])?;
        let (_, triangles) = file.rows::<u32>("modal.triangles", &[6])?;
        let surface = ModalSurface {
            nodes: positions.chunks_exact(3).map(DVec3::from_slice).collect(),
            triangles: triangles.as_chunks::<6>().0.to_vec(),
        };
        let (count, numbers) = file.rows::<f64>("modal.modes", &[2])?;
        let damping = match file.has("modal.support_damping") {
            true => file.array::<f64>("modal.support_damping", &[count])?,
            false => vec![0.0; count],
        };
        let shapes = file.array::<f32>("modal.shapes", &[count, nodes, 3])?;
        let orders = file.array::<i16>("modal.orders", &[count])?;
        let (total, real) = file.rows::<f32>("modal.real", &[])?;
        let imaginary = file.array::<f32>("modal.imaginary", &[total])?;
        let transfers = take_transfers(&orders, &real, &imaginary)?;
        let modes = numbers
            .chunks_exact(2)
            .zip(transfers)
            .enumerate()
            .map(|(at, (number, transfer))| ModalMode {
                frequency: number[0],
                mesh_error: number[1],
                support_damping: damping[at],
                shape: shapes[3 * at * nodes..3 * (at + 1) * nodes]
                    .chunks_exact(3)
                    .map(|u| DVec3::new(u[0].into(), u[1].into(), u[2].into()))
                    .collect(),
                transfer,
            })
            .collect();
        let model = ModalModel {
            radius: modal.radius_m,
            medium: Medium { density: modal.medium_density_kg_m3, sound_speed: modal.sound_speed_m_s },
            density: modal.density_kg_m3,
            max_frequency: modal.max_frequency_hz,
            statistical_above: modal.statistical_above_hz,
            surface,
            modes,
        };
        Ok(ModalPart { model, origin: modal.origin })
    }

    /// Rejects a model that could not be played.
    pub(super) fn check(&self) -> Result<(), TensorFileError> {
        let ModalModel { radius, medium, density, max_frequency, statistical_above, surface, modes } =
            &self.model;
        if !RADII.contains(radius) {
            return Err(TensorFileError::value(
                "the bounding radius",
                format!("is {radius:e} m, outside {:e} m to {:e} m", RADII.start(), RADII.end()),
            ));
        }
        within("the density of the medium", medium.density, &quantity::MEDIUM_DENSITY)?;
        within("the speed of sound", medium.sound_speed, &quantity::SOUND_SPEED)?;
        within("the density of the body", *density, &quantity::DENSITY)?;
        within("the highest frequency", *max_frequency, &quantity::FREQUENCY)?;
        if let Some(from) = *statistical_above {
            within("the frequency above which modes are statistical", from, &quantity::FREQUENCY)?;
        }
        within("Young's modulus", self.origin.youngs_modulus, &quantity::MODULUS)?;
        within("Poisson's ratio", self.origin.poisson_ratio, &quantity::POISSON)?;
        // Without modes there are no shapes, and no surface is needed.
        if !modes.is_empty() {
            check_surface(surface, *radius)?;
        }
        let mut last = 0.0;
        for (at, mode) in modes.iter().enumerate() {
            let what = || format!("mode {at}");
            within(&what(), mode.frequency, &quantity::FREQUENCY)?;
            if mode.frequency < last {
                return Err(TensorFileError::value(what(), "is below the one before it"));
            }
            last = mode.frequency;
            // An error without estimate is NaN.
            if mode.mesh_error < 0.0 || mode.mesh_error.is_infinite() {
                return Err(TensorFileError::value(
                    format!("the mesh error of mode {at}"),
                    "is not a finite number from 0",
                ));
            }
            let what = format!("the damping of mode {at} by supports");
            within(&what, mode.support_damping, &quantity::DAMPING_RATE)?;
            check_shape(at, mode, surface.nodes.len())?;
            mode.transfer.as_ref().map_or(Ok(()), |transfer| check_transfer(at, transfer))?;
        }
        Ok(())
    }
}

/// Rounds a shape to 32 bits.
pub fn round_shape(shape: &mut [DVec3]) {
    shape.iter_mut().for_each(|u| *u = u.map(single));
}

/// Rounds to 32 bits.
fn single(x: f64) -> f64 {
    f64::from(x as f32)
}

/// The transfers of the modes, concatenated; −1 is the order of a mode without transfer.
fn take_transfers(
    orders: &[i16],
    real: &[f32],
    imaginary: &[f32],
) -> Result<Vec<Option<ModalTransfer>>, TensorFileError> {
    let mut numbers = real.iter().zip(imaginary).map(|(re, im)| Complex64::new((*re).into(), (*im).into()));
    let mut transfers = Vec::with_capacity(orders.len());
    let mut needed = 0;
    for (at, order) in orders.iter().enumerate() {
        let transfer = match usize::try_from(*order) {
            Ok(order) if order <= HIGHEST_ORDER => {
                let count = (order + 1) * (order + 1);
                needed += count;
                Some(ModalTransfer { order, coefficients: numbers.by_ref().take(count).collect() })
            }
            Err(_) if *order == -1 => None,
            _ => {
                return Err(TensorFileError::value(
                    format!("the order of mode {at}"),
                    format!("is {order}, not -1 to {HIGHEST_ORDER}"),
                ));
            }
        };
        transfers.push(transfer);
    }
    if needed != real.len() {
        return Err(TensorFileError::Shape {
            name: "modal.real".into(),
            found: format!("of {} numbers", real.len()),
            expected: format!("of {needed}"),
        });
    }
    Ok(transfers)
}

fn check_surface(surface: &ModalSurface, radius: f64) -> Result<(), TensorFileError> {
    let count = surface.nodes.len();
    if surface.triangles.is_empty() {
        return Err(TensorFileError::value("the array \"modal.triangles\"", "is empty"));
    }
    if let Some(at) = surface.triangles.iter().position(|t| t.iter().any(|i| *i as usize >= count)) {
        return Err(TensorFileError::value(
            format!("row {at} of the array \"modal.triangles\""),
            format!("names a node that is not among the {count}"),
        ));
    }
    let outside = |x: &DVec3| !x.is_finite() || x.length() > (1.0 + OUTSIDE) * radius;
    match surface.nodes.iter().position(outside) {
        Some(at) => Err(TensorFileError::value(
            format!("row {at} of the array \"modal.nodes\""),
            "is outside the bounding sphere",
        )),
        None => Ok(()),
    }
}

fn check_shape(at: usize, mode: &ModalMode, nodes: usize) -> Result<(), TensorFileError> {
    if mode.shape.len() != nodes {
        return Err(TensorFileError::Shape {
            name: "modal.shapes".into(),
            found: format!("of {} nodes for mode {at}", mode.shape.len()),
            expected: format!("of {nodes}"),
        });
    }
    // In the precision of the file, whose range may be too small for a number.
    let large = |u: &DVec3| u.as_vec3().to_array().iter().any(|x| !quantity::COMPONENT.admits((*x).into()));
    match mode.shape.iter().position(large) {
        Some(node) => Err(TensorFileError::value(
            format!("node {node} of the shape of mode {at}"),
            "is not finite, or too large",
        )),
        None => Ok(()),
    }
}

fn check_transfer(at: usize, transfer: &ModalTransfer) -> Result<(), TensorFileError> {
    let count = (transfer.order + 1) * (transfer.order + 1);
    if transfer.order > HIGHEST_ORDER || transfer.coefficients.len() != count {
        return Err(TensorFileError::Shape {
            name: "modal.real".into(),
            found: format!(
                "of {} numbers for mode {at} of order {}",
                transfer.coefficients.len(),
                transfer.order
            ),
            expected: format!("of {count}, of order {HIGHEST_ORDER} at most"),
        });
    }
    let rounded: Vec<f32> = transfer.coefficients.iter().flat_map(|c| [c.re as f32, c.im as f32]).collect();
    all_within(&format!("modal.real or modal.imaginary of mode {at}"), &rounded, &quantity::COMPONENT)
}
