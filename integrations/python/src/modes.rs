//! The modes of a free body.

use std::ops::ControlFlow;

use clangor::bake::acceleration::BakeOptions;
use clangor::bake::fem::ElasticConstants;
use clangor::bake::modal_analysis::{ModalAnalysisOptions, ModalAnalysisProgress, modal_analysis_and_system};
use clangor::pipeline::stages::load::load_named;
use clangor::pipeline::stages::sound_models::{AccelerationBake, SoundModelRequest};
use clangor::{Progress, Stage};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors::raised;
use crate::progress::Watch;
use crate::settings::{MaterialOrName, check_keywords, keyword};

/// At which frequencies a free body rings, and for how long.
#[pyclass(frozen, get_all, module = "clangor")]
pub(crate) struct Modes {
    /// Frequencies [Hz], ascending.
    frequencies: Py<PyArray1<f64>>,
    /// Time to decay by 60 dB in the material [s].
    t60: Py<PyArray1<f64>>,
    /// Damping ratios.
    damping_ratios: Py<PyArray1<f64>>,
    /// Estimated relative error of each frequency; NaN where no second mesh was possible.
    errors: Py<PyArray1<f64>>,
    /// How they were found.
    method: String,
    /// Warnings of the solver.
    warnings: Vec<String>,
}

/// The keywords of [`modes`].
struct Options {
    scale: Option<f64>,
    max_frequency: Option<f64>,
    accuracy: Option<f64>,
    progress: Option<Py<PyAny>>,
}

impl Options {
    fn of(options: &Bound<'_, PyDict>) -> PyResult<Self> {
        Ok(Options {
            scale: keyword(options, "scale")?,
            max_frequency: keyword(options, "max_frequency")?,
            accuracy: keyword(options, "accuracy")?,
            progress: keyword(options, "progress")?,
        })
    }
}

/// All modes of a free body up to a frequency [Hz].
#[pyfunction]
#[pyo3(
    signature = (object, material, **options),
    text_signature = "(object, material, *, scale=1.0, max_frequency=20000.0, accuracy=0.01, progress=None)"
)]
pub(crate) fn modes(
    py: Python<'_>,
    object: &str,
    material: MaterialOrName,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<Modes> {
    let options = options.cloned().unwrap_or_else(|| PyDict::new(py));
    check_keywords(&options, &["scale", "max_frequency", "accuracy", "progress"])?;
    let Options { scale, max_frequency, accuracy, progress } = Options::of(&options)?;
    let (scale, accuracy) = (scale.unwrap_or(1.0), accuracy.unwrap_or(0.01));
    let max_frequency = max_frequency.unwrap_or(20_000.0);
    let watch = Watch::new(progress);
    let material = material.material()?;
    let found = py.detach(|| {
        let constants = ElasticConstants::of(&material).map_err(raised)?;
        let loaded = load_named(object, scale).map_err(raised)?;
        // How a body is recognised does not depend on the band.
        let part = AccelerationBake(BakeOptions::new(1.0, 0.01));
        let request = SoundModelRequest::new(object, &loaded.surface, loaded.mass, part).map_err(raised)?;
        let options = ModalAnalysisOptions { accuracy, ..ModalAnalysisOptions::to(max_frequency) };
        let mut reached = |p: &ModalAnalysisProgress| -> ControlFlow<()> {
            watch.reached(&Progress { stage: Stage::Modal, done: p.done, body: object, step: "find modes" })
        };
        let (found, _) = modal_analysis_and_system(request.geometry(), &constants, &options, &mut reached)
            .map_err(|error| watch.cause(raised(error)))?;
        Ok::<_, PyErr>(found)
    })?;
    let column = |value: &dyn Fn(usize) -> f64| {
        PyArray1::from_vec(py, (0..found.modes.len()).map(value).collect()).unbind()
    };
    let frequency = |k: usize| found.modes[k].frequency;
    Ok(Modes {
        frequencies: column(&frequency),
        t60: column(&|k| material.damping.t60(frequency(k))),
        damping_ratios: column(&|k| material.damping.damping_ratio(frequency(k))),
        errors: column(&|k| found.modes[k].mesh_error),
        method: found.method.to_string(),
        warnings: found.warnings.iter().map(ToString::to_string).collect(),
    })
}
