//! Words and tuples of Python as settings.

use clangor::material::{Material, presets};
use clangor::pipeline::session::named_body::preset;
use clangor::pipeline::stages::sound_models::{ModelOptions, Quality};
use clangor::synthesis::strike::Striker;
use pyo3::conversion::FromPyObjectOwned;
use pyo3::exceptions::{PyOverflowError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors::raised;

/// A point or vector: three numbers.
pub(crate) type Vector = [f64; 3];

/// `"draft"`, `"normal"` or `"high"`, and the highest frequency of models \[Hz\].
pub(crate) fn model_options(quality: &str, max_frequency: Option<f64>) -> PyResult<ModelOptions> {
    let quality = match quality {
        "draft" => Quality::Draft,
        "normal" => Quality::Normal,
        "high" => Quality::High,
        other => {
            let message = format!("quality is \"{other}\"; it can be \"draft\", \"normal\" or \"high\"");
            return Err(PyValueError::new_err(message));
        }
    };
    Ok(ModelOptions { quality, max_frequency, ..ModelOptions::default() })
}

/// The name of a preset, or a mapping with its changes: `{"base": "steel", "density": 7900.0}`.
#[derive(FromPyObject)]
pub(crate) enum MaterialOrName {
    /// A preset.
    Name(String),
    /// Changes of a preset.
    Changed(std::collections::BTreeMap<String, MaterialValue>),
}

/// A value of a material.
#[derive(FromPyObject)]
pub(crate) enum MaterialValue {
    /// A property.
    Number(f64),
    /// The name of the base.
    Text(String),
}

impl MaterialOrName {
    /// The material.
    pub(crate) fn material(&self) -> PyResult<Material> {
        let changes = match self {
            MaterialOrName::Name(name) => return preset(name).map_err(raised),
            MaterialOrName::Changed(changes) => changes,
        };
        let Some(MaterialValue::Text(base)) = changes.get("base") else {
            return Err(PyValueError::new_err(
                "a material as a mapping needs \"base\", the name of a preset",
            ));
        };
        let mut material = preset(base).map_err(raised)?;
        for (key, value) in changes.iter().filter(|(key, _)| *key != "base") {
            let MaterialValue::Number(value) = value else {
                return Err(PyValueError::new_err(format!("material: \"{key}\" is not a number")));
            };
            let field = match key.as_str() {
                "density" => &mut material.density,
                "youngs_modulus" => &mut material.youngs_modulus,
                "poisson_ratio" => &mut material.poisson_ratio,
                "restitution" => &mut material.restitution,
                "friction" => &mut material.friction,
                other => {
                    let known =
                        "base, density, youngs_modulus, poisson_ratio, restitution, friction, loss_factor";
                    if other == "loss_factor" {
                        material.damping = clangor::material::Damping::LossFactor(*value);
                        continue;
                    }
                    return Err(PyValueError::new_err(format!("material: no \"{other}\"; known: {known}")));
                }
            };
            *field = *value;
        }
        let usual = [
            ("density", material.density > 0.0),
            ("youngs_modulus", material.youngs_modulus > 0.0),
            ("poisson_ratio", material.poisson_ratio > -1.0 && material.poisson_ratio < 0.5),
            ("restitution", (0.0..=1.0).contains(&material.restitution)),
            ("friction", material.friction >= 0.0),
            ("loss_factor", material.damping.check().is_ok()),
        ];
        match usual.iter().find(|(_, is_possible)| !is_possible) {
            Some((key, _)) => Err(PyValueError::new_err(format!("material: {key} is not possible"))),
            None => Ok(material),
        }
    }
}

/// Names of the material presets.
#[pyfunction]
pub(crate) fn materials() -> Vec<String> {
    presets::names().map(str::to_owned).collect()
}

/// Refuses keywords that a function does not have.
pub(crate) fn check_keywords(options: &Bound<'_, PyDict>, known: &[&str]) -> PyResult<()> {
    for key in options.keys() {
        let key: String = key.extract()?;
        if !known.contains(&key.as_str()) {
            let message = format!("no keyword \"{key}\"; known: {}", known.join(", "));
            return Err(PyTypeError::new_err(message));
        }
    }
    Ok(())
}

/// The value of a keyword, if it is given and not `None`; an error names the keyword.
pub(crate) fn keyword<'py, T: FromPyObjectOwned<'py>>(
    options: &Bound<'py, PyDict>,
    key: &str,
) -> PyResult<Option<T>> {
    let Some(value) = options.get_item(key)?.filter(|value| !value.is_none()) else { return Ok(None) };
    value.extract::<T>().map(Some).map_err(|error| named(key, error))
}

/// The error of an argument, with its name. Numbers beyond those of the machine are wrong values.
pub(crate) fn named(name: &str, error: impl Into<PyErr>) -> PyErr {
    let error: PyErr = error.into();
    Python::attach(|py| {
        let kind = match error.is_instance_of::<PyOverflowError>(py) {
            true => py.get_type::<PyValueError>(),
            false => error.get_type(py),
        };
        PyErr::from_type(kind, format!("{name}: {}", error.value(py)))
    })
}

/// A ball that strikes: material, radius [m], speed [m/s].
pub(crate) fn striker((material, radius, speed): &(MaterialOrName, f64, f64)) -> PyResult<Striker> {
    let possible = [("radius", *radius), ("speed", *speed)];
    if let Some((what, value)) = possible.iter().find(|(_, x)| !(*x > 0.0 && x.is_finite())) {
        return Err(PyValueError::new_err(format!("striker: {what} is {value}, not positive")));
    }
    Ok(Striker::new(material.material()?, *radius, *speed))
}
