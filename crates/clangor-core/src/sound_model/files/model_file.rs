//! A baked sound model as bytes: what `NAME.safetensors` holds; docs/format/model.md describes it for other
//! programs.
//!
//! The file carries the model, the solid that it was baked from (so that it can be struck without its mesh),
//! and how good it is and how that is known. The click depends on the shape alone: not on a material, and on
//! the medium only through κ = ωR/c, so that one file serves every material and every gas. Ringing, which
//! does depend on both, is a part that may be there ([`modal_file`](crate::sound_model::files::modal_file));
//! older programs read the file without it.
//!
//! Reading never trusts: shapes, order and range of every number are checked, after the hash of the whole.

use glam::{DMat3, DVec3};
use num_complex::Complex64;
use serde::{Deserialize, Serialize};

use crate::geometry::mass_properties::MassProperties;
use crate::geometry::tri_mesh::TriMesh;
use crate::sound_model::acceleration::field::{AccelerationField, Node, RIGID_DOFS, Term};
use crate::sound_model::acceleration::model::AccelerationModel;
use crate::sound_model::acceleration::near_field::NearField;
use crate::sound_model::files::modal_file::{ModalDescription, ModalPart};
use crate::sound_model::files::tensor_file::{TensorFileError, TensorReader, TensorWriter, check_finite};

/// Version of the format.
pub const VERSION: u32 = 2;
/// What the description calls the file.
pub const KIND: &str = "sound model";

/// Most nodes in frequency that a file may have.
const MOST_NODES: usize = 1024;
/// Highest n that a file may have: m must fit.
const HIGHEST_ORDER: u8 = 127;
/// Least and greatest bounding radius \[m\].
pub(crate) const RADII: std::ops::RangeInclusive<f64> = 1e-7..=1e4;

/// A sound model with its origin.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelFile {
    /// What the body sounds like when it is accelerated.
    pub acceleration: AccelerationModel,
    /// How it rings, of one material in one medium.
    pub modal: Option<ModalPart>,
    /// What it was baked from.
    pub solid: Solid,
    /// How it was baked, and how good it is.
    pub origin: Origin,
}

/// The solid that a model was baked from.
#[derive(Clone, Debug, PartialEq)]
pub struct Solid {
    /// What was baked, as the person named it: a shape or a mesh file.
    pub name: String,
    /// Volume, centre of mass in the frame of the file, and inertia, all of unit density.
    pub mass: MassProperties,
    /// The surface, centre of mass at the origin; `None` for a sphere of the model's radius.
    pub surface: Option<TriMesh>,
}

/// How a model was baked, and how good it is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Origin {
    /// Program and version.
    pub program: String,
    /// Hash of geometry and options.
    pub inputs: String,
    /// Level error that was asked for.
    pub asked_accuracy: f64,
    /// Solver, in words.
    pub method: String,
    /// Unknowns of the largest system, or cells.
    pub unknowns: u64,
    /// Frequencies solved.
    pub solves: u64,
    /// Largest level error of the rational fit at frequencies that it had not seen.
    pub held_out_error: f64,
    /// What a user should know.
    pub warnings: Vec<String>,
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

#[derive(Serialize, Deserialize)]
pub(crate) struct SolidDescription {
    name: String,
    volume_m3: f64,
    centre_of_mass_m: [f64; 3],
    /// Rows of the inertia tensor.
    inertia_per_density_m5: [[f64; 3]; 3],
}

const UNITS: &str = "lengths over the bounding radius R = radius_m about the centre of mass, s = i k R, pressures over \
(density R) for accelerations (a, R alpha); solid.* in metres; no material and no medium is in it";

impl ModelFile {
    /// The bytes of the file. The same model gives the same bytes.
    ///
    /// # Errors
    /// [`TensorFileError`] for a model that [`decode`](Self::decode) would refuse.
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

    /// Whether every number can be; shapes are right by construction once a file has been read.
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

impl Solid {
    /// Adds the surface to a file, and describes the rest.
    pub(crate) fn put(&self, file: &mut TensorWriter) -> SolidDescription {
        if let Some(surface) = &self.surface {
            put_mesh(file, "solid", surface);
        }
        SolidDescription {
            name: self.name.clone(),
            volume_m3: self.mass.volume,
            centre_of_mass_m: self.mass.centre_of_mass.to_array(),
            inertia_per_density_m5: self.mass.inertia.transpose().to_cols_array_2d(),
        }
    }

    /// Takes it out of a file.
    pub(crate) fn take(file: &TensorReader<'_>, solid: SolidDescription) -> Result<Self, TensorFileError> {
        let mass = MassProperties {
            volume: solid.volume_m3,
            centre_of_mass: DVec3::from_array(solid.centre_of_mass_m),
            inertia: DMat3::from_cols_array_2d(&solid.inertia_per_density_m5).transpose(),
        };
        Ok(Solid { name: solid.name, mass, surface: take_mesh(file, "solid")? })
    }

    /// Refuses what no solid of this bounding radius \[m\] is.
    pub(crate) fn check(&self, radius: f64) -> Result<(), TensorFileError> {
        if let Some(surface) = &self.surface {
            check_mesh("solid", surface, radius)?;
        }
        let mass = &self.mass;
        positive("the volume", mass.volume)?;
        if !mass.centre_of_mass.is_finite() {
            return Err(TensorFileError::value("the centre of mass", "is not finite"));
        }
        let symmetric = mass.inertia.abs_diff_eq(mass.inertia.transpose(), 1e-9 * mass.inertia.x_axis.x);
        if !(symmetric && mass.inertia.determinant() > 0.0 && mass.inertia.is_finite()) {
            return Err(TensorFileError::value("the inertia tensor", "is not that of a solid"));
        }
        Ok(())
    }
}

/// Refuses evidence that is none.
pub(crate) fn check_origin(origin: &Origin) -> Result<(), TensorFileError> {
    positive("the accuracy asked for", origin.asked_accuracy)?;
    if !(origin.held_out_error >= 0.0 && origin.held_out_error.is_finite()) {
        return Err(TensorFileError::value("the held-out error", "is not a finite number from 0"));
    }
    Ok(())
}

/// Refuses a near field that names spectra that are not there.
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

/// Refuses a field that could not be played.
pub(crate) fn check_field(field: &AccelerationField) -> Result<(), TensorFileError> {
    positive("the highest wavenumber", field.max_wavenumber)?;
    if !(field.ring_time >= 0.0 && field.ring_time.is_finite()) {
        return Err(TensorFileError::value("the ring time", "is not a finite number from 0"));
    }
    let nodes = field.nodes.len();
    if !(1..=MOST_NODES).contains(&nodes) {
        return Err(TensorFileError::value(
            "the array \"acceleration.nodes\"",
            format!("has {nodes} rows, not 1 to {MOST_NODES}"),
        ));
    }
    for (at, node) in field.nodes.iter().enumerate() {
        if !(node.s.is_finite() && node.weight.is_finite()) {
            return Err(TensorFileError::value(format!("node {at}"), "is not finite"));
        }
        if field.nodes[..at].iter().any(|other| other.s == node.s) {
            return Err(TensorFileError::value(format!("node {at}"), "repeats an earlier one"));
        }
    }
    if field.nodes.iter().all(|n| n.weight == Complex64::ZERO) {
        return Err(TensorFileError::value("every weight", "is zero"));
    }
    if let Some(at) = field.terms.iter().position(|t| !clamped(t)) {
        return Err(TensorFileError::value(format!("term {at}"), "is no multipole of a rigid motion"));
    }
    if let Some(at) = field.terms.windows(2).position(|pair| pair[0] >= pair[1]) {
        return Err(TensorFileError::value(format!("term {}", at + 1), "is not after the one before it"));
    }
    check_count("acceleration.real", &field.real, field.terms.len() * nodes)?;
    check_count("acceleration.imaginary", &field.imaginary, field.terms.len() * nodes)
}

/// Whether n, m and the degree of freedom go together.
fn clamped(term: &Term) -> bool {
    term.n <= HIGHEST_ORDER && term.m.unsigned_abs() <= term.n && usize::from(term.degree) < RIGID_DOFS
}

pub(crate) fn term(numbers: &[i16]) -> Result<Term, TensorFileError> {
    let impossible =
        |_| TensorFileError::value(format!("the term {numbers:?}"), "is no multipole of a rigid motion");
    Ok(Term {
        n: numbers[0].try_into().map_err(impossible)?,
        m: numbers[1].try_into().map_err(impossible)?,
        degree: numbers[2].try_into().map_err(impossible)?,
    })
}

pub(crate) fn positive(what: &str, number: f64) -> Result<(), TensorFileError> {
    if number > 0.0 && number.is_finite() {
        return Ok(());
    }
    Err(TensorFileError::value(what, format!("is {number}, not a finite number above 0")))
}

fn check_count(name: &str, numbers: &[f32], count: usize) -> Result<(), TensorFileError> {
    if numbers.len() != count {
        return Err(TensorFileError::Shape {
            name: name.into(),
            found: format!("of {} numbers", numbers.len()),
            expected: format!("of {count}"),
        });
    }
    check_finite(name, numbers)
}

fn put_mesh(file: &mut TensorWriter, name: &str, mesh: &TriMesh) {
    file.add(
        &format!("{name}.vertices"),
        &[mesh.vertices.len(), 3],
        mesh.vertices.iter().flat_map(|v| v.to_array()),
    );
    file.add(
        &format!("{name}.triangles"),
        &[mesh.triangles.len(), 3],
        mesh.triangles.iter().flatten().copied(),
    );
}

fn take_mesh(file: &TensorReader<'_>, name: &str) -> Result<Option<TriMesh>, TensorFileError> {
    let (vertices, triangles) = (format!("{name}.vertices"), format!("{name}.triangles"));
    if !file.has(&vertices) && !file.has(&triangles) {
        return Ok(None);
    }
    let (_, positions) = file.rows::<f64>(&vertices, &[3])?;
    let (_, corners) = file.rows::<u32>(&triangles, &[3])?;
    Ok(Some(TriMesh {
        vertices: positions.chunks_exact(3).map(DVec3::from_slice).collect(),
        triangles: corners.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect(),
    }))
}

/// Refuses a mesh that names vertices that are not there, or that leaves the ball of this radius.
fn check_mesh(name: &str, mesh: &TriMesh, radius: f64) -> Result<(), TensorFileError> {
    let count = mesh.vertices.len();
    if mesh.triangles.is_empty() {
        return Err(TensorFileError::value(format!("the array \"{name}.triangles\""), "is empty"));
    }
    if let Some(at) = mesh.triangles.iter().position(|t| t.iter().any(|i| *i as usize >= count)) {
        return Err(TensorFileError::value(
            format!("row {at} of the array \"{name}.triangles\""),
            format!("names a vertex that is not among the {count}"),
        ));
    }
    // A remeshed or curved surface and the one that gave the radius are not quite the same.
    if let Some(at) = mesh.vertices.iter().position(|v| !v.is_finite() || v.length() > OUTSIDE * radius) {
        return Err(TensorFileError::value(
            format!("row {at} of the array \"{name}.vertices\""),
            "is outside the bounding sphere",
        ));
    }
    Ok(())
}

/// How far outside the bounding sphere a vertex may be.
const OUTSIDE: f64 = 1.1;
