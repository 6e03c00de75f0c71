//! One impact on one body.

use std::path::PathBuf;

use clangor::glam::DVec3;
use clangor::pipeline::session::StruckBody;
use clangor::synthesis::strike::Striker;
use clangor::{Progress, Strike};
use numpy::PyArray1;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::errors::raised;
use crate::progress::Watch;
use crate::settings::{MaterialOrName, Vector, model_options};

/// The sound of one impact.
#[pyclass(frozen, get_all, module = "clangor")]
pub(crate) struct StruckSound {
    /// Pressure at the listener [Pa].
    pressure: Py<PyArray1<f64>>,
    /// Time of each sample after the beginning of the contact [s].
    times: Py<PyArray1<f64>>,
    /// Samples per second [Hz].
    sample_rate: u32,
    /// Duration of the contact [s].
    contact_duration: f64,
    /// Impulse on the body [N s].
    impulse: Vector,
    /// Change in velocity of the centre of mass [m/s].
    velocity_change: Vector,
    /// Number of modes that are heard.
    modes: usize,
    /// Defects of the sound models.
    remarks: Vec<String>,
}

/// Strikes a body at rest: a shape of the library, a mesh file, or a sound model, by an impulse [N s] or by a
/// ball (`striker`: material, radius [m], speed [m/s]).
#[pyfunction]
#[pyo3(signature = (
    object, material, *, scale=1.0, impulse=None, striker=None, point=None,
    listener=None, seconds=None, sample_rate=48_000, quality="normal", max_frequency=None, cache=None,
    progress=None
))]
#[allow(clippy::too_many_arguments, reason = "keywords of Python")]
pub(crate) fn strike(
    py: Python<'_>,
    object: &str,
    material: MaterialOrName,
    scale: f64,
    impulse: Option<Vector>,
    striker: Option<(MaterialOrName, f64, f64)>,
    point: Option<Vector>,
    listener: Option<Vector>,
    seconds: Option<f64>,
    sample_rate: u32,
    quality: &str,
    max_frequency: Option<f64>,
    cache: Option<PathBuf>,
    progress: Option<Py<PyAny>>,
) -> PyResult<StruckSound> {
    let watch = Watch::new(progress);
    let options = model_options(quality, max_frequency)?;
    let material = material.material()?;
    let striker = match striker {
        Some((material, radius, speed)) => {
            let possible = [("radius", radius), ("speed", speed)];
            if let Some((what, value)) = possible.iter().find(|(_, x)| !(*x > 0.0 && x.is_finite())) {
                return Err(PyValueError::new_err(format!("striker: {what} is {value}, not positive")));
            }
            Some(Striker::new(material.material()?, radius, speed))
        }
        None => None,
    };
    if impulse.is_some() && striker.is_some() {
        return Err(PyValueError::new_err("give either `impulse` or `striker`"));
    }
    let sound = py.detach(|| {
        let body = StruckBody::open(object, scale, Some(material)).map_err(raised)?;
        let mut strike = Strike::new(body).sample_rate(sample_rate).models(options);
        if let Some(point) = point {
            strike = strike.at(DVec3::from_array(point));
        }
        if let Some(impulse) = impulse {
            strike = strike.impulse(DVec3::from_array(impulse));
        }
        if let Some(striker) = striker {
            strike = strike.striker(striker);
        }
        if let Some(listener) = listener {
            strike = strike.listener(DVec3::from_array(listener));
        }
        if let Some(seconds) = seconds {
            strike = strike.seconds(seconds);
        }
        if let Some(folder) = cache {
            strike = strike.cache(folder);
        }
        let mut reached = |progress: &Progress<'_>| watch.reached(progress);
        strike.render_with_progress(&mut reached).map_err(|error| watch.cause(raised(error)))
    })?;
    Ok(StruckSound {
        pressure: PyArray1::from_vec(py, sound.pressures).unbind(),
        times: PyArray1::from_vec(py, sound.times).unbind(),
        sample_rate: sound.sample_rate.hz(),
        contact_duration: sound.contact_duration,
        impulse: sound.impulse.to_array(),
        velocity_change: sound.velocity_change.to_array(),
        modes: sound.modes,
        remarks: sound.remarks.iter().map(ToString::to_string).collect(),
    })
}
