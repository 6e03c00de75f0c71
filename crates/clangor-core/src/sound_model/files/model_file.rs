//! A baked sound model as bytes: the content of `NAME.safetensors`; docs/format/model.md describes it for
//! other programs.
//!
//! The file carries the model, the solid that was baked (so that it can be struck without its mesh), and the
//! accuracy of the model with its evidence. The acceleration model depends on the shape alone: not on a
//! material, and on the medium only through κ = ωR/c. One file serves every material and every gas. The modal
//! model depends on both and is an optional part ([`modal_file`](crate::sound_model::files::modal_file));
//! older programs read the file without it.
//!
//! Reading validates everything: the hash of the whole file, then shapes, order and range of every number.

use num_complex::Complex64;
use serde::{Deserialize, Serialize};

use crate::sound_model::acceleration::field::{AccelerationField, Node, RIGID_DOFS, Term};
use crate::sound_model::acceleration::model::AccelerationModel;
use crate::sound_model::acceleration::near_field::NearField;
use crate::sound_model::files::field_checks::{check_field, term};
use crate::sound_model::files::modal_file::{ModalDescription, ModalPart};
use crate::sound_model::files::number_checks::{RADII, check_count};
pub use crate::sound_model::files::origin::Origin;
use crate::sound_model::files::origin::check_origin;
pub use crate::sound_model::files::solid::Solid;
use crate::sound_model::files::solid::SolidDescription;
use crate::sound_model::files::surface_mesh::{check_mesh, put_mesh, take_mesh};
use crate::sound_model::files::tensor_file::{TensorFileError, TensorReader, TensorWriter, check_finite};

/// Version of the format.
pub const VERSION: u32 = 2;
/// Kind of the file in its description.
pub const KIND: &str = "sound model";

/// A sound model with its origin.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelFile {
    /// Acceleration model of the body.
    pub acceleration: AccelerationModel,
    /// Modal model, for one material in one medium.
    pub modal: Option<ModalPart>,
    /// The solid that was baked.
    pub solid: Solid,
    /// Origin and accuracy.
    pub origin: Origin,
}

/// The description in the header.
#[derive(Serialize, Deserialize)]
struct Description {
    kind: String,
    version: u32,
    units: String,
    acceleration: AccelerationDescription,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    modal: Option<ModalDescription>,
    solid: SolidDescription,
    origin: Origin,
}

#[derive(Serialize, Deserialize)]
struct AccelerationDescription {
    radius_m: f64,
    max_wavenumber: f64,
    ring_time: f64,
}

const UNITS: &str = "lengths over the bounding radius R = radius_m about the centre of mass, s = i k R, \
pressures over (density R) for accelerations (a, R alpha); solid.* in metres; no material and no medium is \
in it";

impl ModelFile {
    /// The bytes of the file. The same model gives the same bytes.
    ///
    /// # Errors
    /// [`TensorFileError`] for a model that [`decode`](Self::decode) would reject.
    pub fn encode(&self) -> Result<Vec<u8>, TensorFileError> {
        self.check()?;
        let AccelerationModel { radius, field, near } = &self.acceleration;
        let (terms, nodes) = (field.terms.len(), field.nodes.len());
        let mut file = TensorWriter::default();
        file.add(
            "acceleration.nodes",
            &[nodes, 4],
            field.nodes.iter().flat_map(|n| [n.s.re, n.s.im, n.weight.re, n.weight.im]),
        );
        file.add(
            "acceleration.terms",
            &[terms, 3],
            field.terms.iter().flat_map(|t| [i16::from(t.n), i16::from(t.m), i16::from(t.degree)]),
        );
        file.add("acceleration.real", &[terms, nodes], field.real.iter().copied());
        file.add("acceleration.imaginary", &[terms, nodes], field.imaginary.iter().copied());
        if let Some(near) = near {
            put_mesh(&mut file, "near", &near.surface);
            let rows = [near.surface.vertices.len(), RIGID_DOFS];
            let spectra = near.scales.len();
            file.add("near.spectra", &[spectra, nodes, 2], near.spectra.iter().flatten().copied());
            file.add("near.scales", &[spectra], near.scales.iter().copied());
            file.add("near.which", &rows, near.which.iter().copied());
            file.add("near.factors", &rows, near.factors.iter().copied());
        }
        let modal = self.modal.as_ref().map(|modal| modal.put(&mut file));
        let solid = self.solid.put(&mut file);
        file.finish(&Description {
            kind: KIND.into(),
            version: VERSION,
            units: UNITS.into(),
            acceleration: AccelerationDescription {
                radius_m: *radius,
                max_wavenumber: field.max_wavenumber,
                ring_time: field.ring_time,
            },
            modal,
            solid,
            origin: self.origin.clone(),
        })
    }

    /// Reads a file.
    ///
    /// # Errors
    /// [`TensorFileError`] for anything that [`encode`](Self::encode) does not write.
    pub fn decode(bytes: &[u8]) -> Result<Self, TensorFileError> {
        let file = TensorReader::open(bytes, KIND, VERSION)?;
        let Description { acceleration, modal, solid, origin, .. } = file.describe()?;
        let (count, numbers) = file.rows::<f64>("acceleration.nodes", &[4])?;
        let nodes = numbers
            .chunks_exact(4)
            .map(|n| Node { s: Complex64::new(n[0], n[1]), weight: Complex64::new(n[2], n[3]) })
            .collect();
        let (rows, numbers) = file.rows::<i16>("acceleration.terms", &[3])?;
        let terms = numbers.chunks_exact(3).map(term).collect::<Result<Vec<Term>, _>>()?;
        let field = AccelerationField {
            max_wavenumber: acceleration.max_wavenumber,
            ring_time: acceleration.ring_time,
            nodes,
            terms,
            real: file.array("acceleration.real", &[rows, count])?,
            imaginary: file.array("acceleration.imaginary", &[rows, count])?,
        };
        let near = match take_mesh(&file, "near")? {
            Some(surface) => {
                let (spectra, values) = file.rows::<i16>("near.spectra", &[count, 2])?;
                let rows = [surface.vertices.len(), RIGID_DOFS];
                Some(NearField {
                    spectra: values.as_chunks::<2>().0.to_vec(),
                    scales: file.array("near.scales", &[spectra])?,
                    which: file.array("near.which", &rows)?,
                    factors: file.array("near.factors", &rows)?,
                    surface,
                })
            }
            None => None,
        };
        let model = ModelFile {
            acceleration: AccelerationModel { radius: acceleration.radius_m, field, near },
            modal: modal.map(|modal| ModalPart::take(&file, modal)).transpose()?,
            solid: Solid::take(&file, solid)?,
            origin,
        };
        model.check()?;
        Ok(model)
    }

    /// Whether every number is valid; reading a file has already validated the shapes.
    fn check(&self) -> Result<(), TensorFileError> {
        let AccelerationModel { radius, field, near } = &self.acceleration;
        if !RADII.contains(radius) {
            return Err(TensorFileError::value(
                "the bounding radius",
                format!("is {radius:e} m, outside {:e} m to {:e} m", RADII.start(), RADII.end()),
            ));
        }
        check_field(field)?;
        if let Some(near) = near {
            check_mesh("near", &near.surface, 1.0)?;
            check_spectra(near, field.nodes.len())?;
        }
        self.modal.as_ref().map_or(Ok(()), ModalPart::check)?;
        self.solid.check(*radius)?;
        check_origin(&self.origin)
    }
}

/// Rejects a near field that refers to missing spectra.
fn check_spectra(near: &NearField, nodes: usize) -> Result<(), TensorFileError> {
    let NearField { surface, spectra, scales, which, factors } = near;
    let lengths = [
        ("near.spectra", spectra.len(), scales.len() * nodes),
        ("near.which", which.len(), surface.vertices.len() * RIGID_DOFS),
    ];
    if let Some((name, found, expected)) = lengths.into_iter().find(|(_, found, expected)| found != expected)
    {
        return Err(TensorFileError::Shape {
            name: name.into(),
            found: format!("of {found} rows"),
            expected: format!("of {expected}"),
        });
    }
    check_finite("near.scales", scales)?;
    check_count("near.factors", factors, which.len())?;
    let missing = |at: &usize| factors[*at] != 0.0 && which[*at] as usize >= scales.len();
    match (0..which.len()).find(missing) {
        Some(at) => Err(TensorFileError::value(
            format!("number {at} of the array \"near.which\""),
            format!("names a spectrum that is not among the {}", scales.len()),
        )),
        None => Ok(()),
    }
}
