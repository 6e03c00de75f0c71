//! The file of a [`PanModel`]: its signals, the solid and the origin, as `docs/format/model.md` specifies.
//!
//! Its kind differs from that of a [sound model](crate::sound_model::files::model_file), which rendering uses
//! by default.

use serde::{Deserialize, Serialize};

use crate::reference::pan_representation::directions::Directions;
use crate::reference::pan_representation::signals::{Signals, SparseCoefficients};
use crate::reference::pan_representation::{PanField, PanModel};
use crate::sound_model::files::origin::{Origin, check_origin};
use crate::sound_model::files::solid::{Solid, SolidDescription};
use crate::sound_model::files::tensor_file::{TensorFileError, TensorReader, TensorWriter};

/// Version of the format.
pub const VERSION: u32 = 2;
/// Kind of the file in its description.
pub const KIND: &str = "PAN sound model";

/// Kind, version and prefix of the names of arrays.
struct Names {
    kind: &'static str,
    version: u32,
    prefix: &'static str,
}

const NAMES: Names = Names { kind: KIND, version: VERSION, prefix: "pan" };
/// Names of version 1, which is still read.
const FORMER_NAMES: Names = Names { kind: "published sound model", version: 1, prefix: "published" };

/// Whether a file of this kind holds a PAN model, of this version or the one before.
pub fn is_kind(kind: &str) -> bool {
    [NAMES.kind, FORMER_NAMES.kind].contains(&kind)
}

/// Largest number of fields, one for each pulse.
const MOST_FIELDS: usize = 16;

/// A PAN model with its origin.
#[derive(Clone, Debug, PartialEq)]
pub struct PanFile {
    /// The signals.
    pub model: PanModel,
    /// The solid that was baked.
    pub solid: Solid,
    /// Origin and accuracy of the underlying field.
    pub origin: Origin,
}

#[derive(Serialize, Deserialize)]
struct Description {
    kind: String,
    version: u32,
    units: String,
    radius_m: f64,
    fields: Vec<FieldDescription>,
    solid: SolidDescription,
    origin: Origin,
}

#[derive(Serialize, Deserialize)]
struct FieldDescription {
    pulse: f64,
    step: f64,
    start: f64,
    length: usize,
    terms: usize,
    directions: DirectionsDescription,
}

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum DirectionsDescription {
    Angles { rows: usize, columns: usize },
    Octant { divisions: usize },
}

const UNITS: &str = "lengths over the bounding radius R = radius_m about the centre of mass, times over \
R/c, pressures over (density R) for accelerations (a, R alpha); solid.* in metres; no material and no \
medium is in it";

/// Largest number of divisions of an angle or an edge.
const MOST_DIVISIONS: usize = 4096;

impl PanFile {
    /// The bytes of the file. The same model gives the same bytes.
    ///
    /// # Errors
    /// [`TensorFileError`] for a model that [`decode`](Self::decode) would reject.
    pub fn encode(&self) -> Result<Vec<u8>, TensorFileError> {
        self.encode_as(&NAMES)
    }

    fn encode_as(&self, names: &Names) -> Result<Vec<u8>, TensorFileError> {
        let PanFile { model, solid, origin } = self;
        solid.check(model.radius())?;
        check_origin(origin)?;
        let mut file = TensorWriter::default();
        for (index, field) in model.fields().iter().enumerate() {
            let name = |what: &str| format!("{}.{index}.{what}", names.prefix);
            match &field.signals {
                Signals::Samples(samples) => {
                    file.add(&name("samples"), &[samples.len()], samples.iter().copied());
                }
                Signals::Wavelets(sparse) => {
                    file.add(&name("first"), &[sparse.first.len()], sparse.first.iter().copied());
                    file.add(&name("places"), &[sparse.places.len()], sparse.places.iter().copied());
                    file.add(&name("values"), &[sparse.values.len()], sparse.values.iter().copied());
                }
            }
        }
        let fields = model.fields().iter().map(|field| FieldDescription {
            pulse: field.pulse,
            step: field.step,
            start: field.start,
            length: field.length,
            terms: field.terms,
            directions: match field.directions {
                Directions::Angles { rows, columns } => DirectionsDescription::Angles { rows, columns },
                Directions::Octant { divisions } => DirectionsDescription::Octant { divisions },
            },
        });
        let description = Description {
            kind: names.kind.into(),
            version: names.version,
            units: UNITS.into(),
            radius_m: model.radius(),
            fields: fields.collect(),
            solid: solid.put(&mut file),
            origin: origin.clone(),
        };
        file.finish(&description)
    }

    /// Reads a file of this version or of version 1.
    ///
    /// # Errors
    /// [`TensorFileError`] for anything that [`encode`](Self::encode) does not write.
    pub fn decode(bytes: &[u8]) -> Result<Self, TensorFileError> {
        match TensorReader::open(bytes, KIND, VERSION) {
            Err(TensorFileError::Kind { found, .. }) if found == FORMER_NAMES.kind => {
                let file = TensorReader::open(bytes, FORMER_NAMES.kind, FORMER_NAMES.version)?;
                Self::read(&file, &FORMER_NAMES)
            }
            file => Self::read(&file?, &NAMES),
        }
    }

    fn read(file: &TensorReader<'_>, names: &Names) -> Result<Self, TensorFileError> {
        let Description { radius_m, fields, solid, origin, .. } = file.describe()?;
        if fields.len() > MOST_FIELDS {
            return Err(TensorFileError::value(
                "the description",
                format!("has more than {MOST_FIELDS} fields"),
            ));
        }
        let fields = fields
            .into_iter()
            .enumerate()
            .map(|(index, field)| read_field(file, index, field, names))
            .collect::<Result<_, _>>()?;
        let model = PanModel::new(radius_m, fields)
            .map_err(|e| TensorFileError::value("the model", format!("cannot be played: {e}")))?;
        let solid = Solid::take(file, solid)?;
        solid.check(model.radius())?;
        check_origin(&origin)?;
        Ok(PanFile { model, solid, origin })
    }
}

fn read_field(
    file: &TensorReader<'_>,
    index: usize,
    field: FieldDescription,
    names: &Names,
) -> Result<PanField, TensorFileError> {
    let FieldDescription { pulse, step, start, length, terms, directions } = field;
    let directions = match directions {
        DirectionsDescription::Angles { rows, columns } => Directions::Angles { rows, columns },
        DirectionsDescription::Octant { divisions } => Directions::Octant { divisions },
    };
    let few = match directions {
        Directions::Angles { rows, columns } => rows.max(columns) <= MOST_DIVISIONS,
        Directions::Octant { divisions } => divisions <= MOST_DIVISIONS,
    };
    // Products of these must not overflow.
    if !few || length > 1 << 24 || terms > 64 {
        return Err(TensorFileError::value(format!("field {index}"), "is larger than any that is written"));
    }
    let name = |what: &str| format!("{}.{index}.{what}", names.prefix);
    let signals = if file.has(&name("samples")) {
        Signals::Samples(file.rows(&name("samples"), &[])?.1)
    } else {
        Signals::Wavelets(SparseCoefficients {
            first: file.rows(&name("first"), &[])?.1,
            places: file.rows(&name("places"), &[])?.1,
            values: file.rows(&name("values"), &[])?.1,
        })
    };
    Ok(PanField { pulse, step, start, length, terms, directions, signals })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::mass_properties::MassProperties;
    use crate::sound_model::acceleration::field::RIGID_DOFS;

    #[test]
    fn a_file_of_version_1_is_read() {
        let directions = Directions::Angles { rows: 1, columns: 2 };
        let samples = (0..2 * RIGID_DOFS * 2 * 8).map(|i| (0.7 * i as f32).sin()).collect();
        let signals = Signals::Samples(samples);
        let field =
            PanField { pulse: 0.5, step: 0.1, start: -1.25, length: 8, terms: 2, directions, signals };
        let file = PanFile {
            model: PanModel::new(0.01, vec![field]).unwrap(),
            solid: Solid { name: "ball".into(), mass: MassProperties::of_sphere(0.01), surface: None },
            origin: Origin {
                program: "clangor".into(),
                inputs: "0123456789abcdef0123456789abcdef".into(),
                asked_accuracy: 1e-3,
                method: "by hand".into(),
                unknowns: 12,
                solves: 3,
                held_out_error: 4.5e-4,
                warnings: Vec::new(),
            },
        };
        let former = file.encode_as(&FORMER_NAMES).unwrap();
        assert_eq!(PanFile::decode(&former).unwrap(), file);
        assert_ne!(former, file.encode().unwrap());
        assert!(is_kind("published sound model") && is_kind(KIND) && !is_kind("sound model"));
    }
}
