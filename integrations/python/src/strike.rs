//! One impact on one body.

use std::path::PathBuf;

use clangor::glam::DVec3;
use clangor::pipeline::session::StruckBody;
use clangor::{Progress, Strike};
use numpy::PyArray1;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors::raised;
use crate::progress::Watch;
use crate::settings::{self, MaterialOrName, Vector, check_keywords, keyword, model_options};

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

const KEYWORDS: &[&str] = &[
    "scale",
    "impulse",
    "striker",
    "point",
    "listener",
    "seconds",
    "sample_rate",
    "quality",
    "max_frequency",
    "cache",
    "progress",
];

/// The keywords of [`strike`].
struct Options {
    scale: Option<f64>,
    impulse: Option<Vector>,
    striker: Option<(MaterialOrName, f64, f64)>,
    point: Option<Vector>,
    listener: Option<Vector>,
    seconds: Option<f64>,
    sample_rate: Option<u32>,
    quality: Option<String>,
    max_frequency: Option<f64>,
    cache: Option<PathBuf>,
    progress: Option<Py<PyAny>>,
}

impl Options {
    fn of(options: &Bound<'_, PyDict>) -> PyResult<Self> {
        Ok(Options {
            scale: keyword(options, "scale")?,
            impulse: keyword(options, "impulse")?,
            striker: keyword(options, "striker")?,
            point: keyword(options, "point")?,
            listener: keyword(options, "listener")?,
            seconds: keyword(options, "seconds")?,
            sample_rate: keyword(options, "sample_rate")?,
            quality: keyword(options, "quality")?,
            max_frequency: keyword(options, "max_frequency")?,
            cache: keyword(options, "cache")?,
            progress: keyword(options, "progress")?,
        })
    }
}

/// Strikes a body at rest: a shape of the library, a mesh file, or a sound model, by an impulse [N s] or by a
/// ball (`striker`: material, radius [m], speed [m/s]).
#[pyfunction]
#[pyo3(
    signature = (object, material, **options),
    text_signature = "(object, material, *, scale=1.0, impulse=None, striker=None, point=None, \
                      listener=None, \
                      seconds=None, sample_rate=48000, quality='normal', max_frequency=None, cache=None, \
                      progress=None)"
)]
pub(crate) fn strike(
    py: Python<'_>,
    object: &str,
    material: MaterialOrName,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<StruckSound> {
    let options = options.cloned().unwrap_or_else(|| PyDict::new(py));
    check_keywords(&options, KEYWORDS)?;
    let Options {
        scale,
        impulse,
        striker,
        point,
        listener,
        seconds,
        sample_rate,
        quality,
        max_frequency,
        cache,
        progress,
    } = Options::of(&options)?;
    let (scale, sample_rate) = (scale.unwrap_or(1.0), sample_rate.unwrap_or(48_000));
    let watch = Watch::new(progress);
    let models = model_options(quality.as_deref().unwrap_or("normal"), max_frequency)?;
    let material = material.material()?;
    let striker = striker.as_ref().map(settings::striker).transpose()?;
    if impulse.is_some() && striker.is_some() {
        return Err(PyValueError::new_err("give either `impulse` or `striker`"));
    }
    let sound = py.detach(|| {
        let body = StruckBody::open(object, scale, Some(material)).map_err(raised)?;
        let mut strike = Strike::new(body).sample_rate(sample_rate).models(models);
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
