//! Data sets: labelled strikes as dictionaries, and their files.

use std::ffi::CString;
use std::path::PathBuf;

use clangor::Progress;
use clangor::pipeline::dataset::{Dataset, DatasetError, DatasetOptions, FileKind, LabelledStrike, Shard};
use numpy::PyArray1;
use pyo3::exceptions::{PyUserWarning, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors::raised;
use crate::progress::Watch;
use crate::settings::{check_keywords, keyword, model_options};

const KEYWORDS: &[&str] = &["text", "path", "folder", "seed", "quality", "max_frequency", "cache"];

/// The strikes of a recipe.
#[pyclass(frozen, module = "clangor")]
pub(crate) struct Strikes {
    dataset: Dataset,
}

#[pymethods]
impl Strikes {
    /// Strikes of a recipe as `text`, whose paths are relative to `folder`, or of a recipe or table at
    /// `path`.
    #[new]
    #[pyo3(signature = (**options), text_signature = "(*, text=None, path=None, folder=None, seed=None, \
                                                     quality='normal', max_frequency=None, cache=None)")]
    fn new(py: Python<'_>, options: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let options = options.cloned().unwrap_or_else(|| PyDict::new(py));
        check_keywords(&options, KEYWORDS)?;
        let text: Option<String> = keyword(&options, "text")?;
        let path: Option<PathBuf> = keyword(&options, "path")?;
        let folder: Option<PathBuf> = keyword(&options, "folder")?;
        let quality: Option<String> = keyword(&options, "quality")?;
        let models =
            model_options(quality.as_deref().unwrap_or("normal"), keyword(&options, "max_frequency")?)?;
        let settings =
            DatasetOptions { models, cache: keyword(&options, "cache")?, seed: keyword(&options, "seed")? };
        let dataset = match (text, path) {
            (Some(text), None) => Dataset::from_text(&text, &folder.unwrap_or_default(), settings),
            (None, Some(path)) => Dataset::open(&path, settings),
            _ => return Err(PyValueError::new_err("give either `text` or `path`")),
        };
        Ok(Strikes { dataset: dataset.map_err(raised)? })
    }

    fn __len__(&self) -> usize {
        self.dataset.count() as usize
    }

    /// Number of bodies, each of one material.
    #[getter]
    fn bodies(&self) -> usize {
        self.dataset.body_count()
    }

    /// Strikes `start` to `stop`.
    #[pyo3(signature = (start, stop, progress=None))]
    fn range(
        &self,
        py: Python<'_>,
        start: u64,
        stop: u64,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Vec<Py<PyDict>>> {
        let watch = Watch::new(progress);
        let strikes = py.detach(|| {
            let mut reached = |progress: &Progress<'_>| watch.reached(progress);
            self.dataset.strikes(start..stop, &mut reached).map_err(|error| watch.cause(raised(error)))
        })?;
        self.warn(py)?;
        strikes.into_iter().map(|strike| labelled(py, strike)).collect()
    }

    /// Writes a part, its number from 1 of all: path, number of strikes, and whether the file was there
    /// already.
    #[pyo3(signature = (folder, part, files="parquet", progress=None))]
    fn write(
        &self,
        py: Python<'_>,
        folder: PathBuf,
        part: (u32, u32),
        files: &str,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<(PathBuf, u64, bool)> {
        let kind = match files {
            "parquet" => FileKind::Parquet,
            "wav" => FileKind::Wav,
            other => {
                let message = format!("files is \"{other}\"; it can be \"parquet\" or \"wav\"");
                return Err(PyValueError::new_err(message));
            }
        };
        let part = shard(part)?;
        let watch = Watch::new(progress);
        let written = py.detach(|| {
            let mut reached = |progress: &Progress<'_>| watch.reached(progress);
            let written = self.dataset.write(&folder, part, kind, &mut reached);
            written.map_err(|error| watch.cause(raised(error)))
        })?;
        self.warn(py)?;
        Ok((written.path, written.rows, written.kept))
    }

    /// Bakes the sound models of a part of the objects into the cache; returns their number.
    #[pyo3(signature = (part, progress=None))]
    fn bake(&self, py: Python<'_>, part: (u32, u32), progress: Option<Py<PyAny>>) -> PyResult<usize> {
        let part = shard(part)?;
        let watch = Watch::new(progress);
        let bodies = py.detach(|| {
            let mut reached = |progress: &Progress<'_>| watch.reached(progress);
            self.dataset.bake(part, &mut reached).map_err(|error| watch.cause(raised(error)))
        })?;
        self.warn(py)?;
        Ok(bodies)
    }
}

impl Strikes {
    /// Warns of defects of the sound models that were just found or baked.
    fn warn(&self, py: Python<'_>) -> PyResult<()> {
        let category = py.get_type::<PyUserWarning>();
        self.dataset.take_remarks().into_iter().try_for_each(|remark| {
            let text = CString::new(remark.to_string().replace('\0', ""))?;
            PyErr::warn(py, &category, &text, 2)
        })
    }
}

/// Number of files of `count` strikes where none is asked for.
#[pyfunction]
pub(crate) fn usual_shards(count: u64) -> u32 {
    Shard::usual_number(count)
}

fn shard((number, of): (u32, u32)) -> PyResult<Shard> {
    Shard::new(number, of).map_err(|error: DatasetError| PyValueError::new_err(error.to_string()))
}

/// A strike as a dictionary.
fn labelled(py: Python<'_>, strike: LabelledStrike) -> PyResult<Py<PyDict>> {
    let row = PyDict::new(py);
    row.set_item("index", strike.index)?;
    row.set_item("seed", strike.seed)?;
    row.set_item("object", strike.object)?;
    row.set_item("material", strike.material)?;
    row.set_item("mass", strike.mass)?;
    row.set_item("draft", strike.draft)?;
    row.set_item("point", strike.point.to_array())?;
    row.set_item("normal", strike.normal.to_array())?;
    row.set_item("striker", strike.striker.as_ref().map(|ball| ball.material.clone()))?;
    row.set_item("striker_radius", strike.striker.as_ref().map(|ball| ball.radius))?;
    row.set_item("speed", strike.striker.as_ref().map(|ball| ball.speed))?;
    row.set_item("impulse", strike.impulse.to_array())?;
    row.set_item("peak_force", strike.peak_force)?;
    row.set_item("contact_duration", strike.contact_duration)?;
    row.set_item("listener", strike.listener.to_array())?;
    row.set_item("room", strike.room.as_ref().map(|room| room.name.clone()))?;
    row.set_item("body", strike.room.as_ref().map(|room| room.body.to_array()))?;
    row.set_item("frequencies", PyArray1::from_slice(py, &strike.frequencies))?;
    row.set_item("t60s", PyArray1::from_slice(py, &strike.t60s))?;
    row.set_item("sample_rate", strike.sample_rate)?;
    row.set_item("start", strike.start)?;
    row.set_item("peak_pressure", strike.peak_pressure)?;
    row.set_item("samples", PyArray1::from_vec(py, strike.samples))?;
    Ok(row.unbind())
}
