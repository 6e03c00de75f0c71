//! Numbers of Python for the real-time engine, within the limits of its events. Errors name the argument.

use clangor::glam::{DQuat, DVec3};
use clangor::realtime::event::LARGEST;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::settings::{Vector, keyword, named};

/// The number of a slot.
#[derive(Clone, Copy)]
pub(crate) struct Slot(pub(crate) usize);

impl FromPyObject<'_, '_> for Slot {
    type Error = PyErr;

    fn extract(value: Borrowed<'_, '_, PyAny>) -> PyResult<Self> {
        value.extract().map(Slot).map_err(|error: PyErr| named("slot", error))
    }
}

/// A finite number.
pub(crate) fn number(options: &Bound<'_, PyDict>, name: &str) -> PyResult<Option<f64>> {
    let value: Option<f64> = keyword(options, name)?;
    match value {
        Some(value) if !value.is_finite() => {
            Err(PyValueError::new_err(format!("{name} is {value}; it must be finite")))
        }
        value => Ok(value),
    }
}

/// A point or vector of three numbers in SI units.
pub(crate) fn point(name: &str, value: &Bound<'_, PyAny>) -> PyResult<DVec3> {
    let vector: Vector = value.extract().map_err(|error| named(name, error))?;
    match vector.iter().all(|component| component.abs() < LARGEST) {
        true => Ok(DVec3::from_array(vector)),
        false => Err(PyValueError::new_err(format!(
            "{name} is {vector:?}; its components must be finite and below {LARGEST:e}"
        ))),
    }
}

/// The same, if it is given.
pub(crate) fn optional_point(options: &Bound<'_, PyDict>, name: &str) -> PyResult<Option<DVec3>> {
    let value = options.get_item(name)?.filter(|value| !value.is_none());
    value.map(|value| point(name, &value)).transpose()
}

/// Several points.
pub(crate) fn points(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<DVec3>> {
    let rows: Vec<Bound<'_, PyAny>> = value.extract().map_err(|error| named(name, error))?;
    rows.iter().enumerate().map(|(index, row)| point(&format!("{name}[{index}]"), row)).collect()
}

/// A rotation as a unit quaternion (x, y, z, w), if it is given.
pub(crate) fn rotation(options: &Bound<'_, PyDict>, name: &str) -> PyResult<Option<DQuat>> {
    let Some(parts): Option<[f64; 4]> = keyword(options, name)? else { return Ok(None) };
    let rotation = DQuat::from_array(parts);
    // As close to 1 as quaternions of single precision are.
    match (rotation.length_squared() - 1.0).abs() < 1e-6 {
        true => Ok(Some(rotation.normalize())),
        false => Err(PyValueError::new_err(format!(
            "{name} is {parts:?}, of length {}; it must be a unit quaternion (x, y, z, w)",
            rotation.length()
        ))),
    }
}
