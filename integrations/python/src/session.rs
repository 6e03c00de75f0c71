//! A scene or a timeline on its way to sound.

use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, TryLockError};

use clangor::SessionBuilder;
use clangor::pipeline::stages::render::HeardPressure;
use clangor::scene::Scene;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors::raised;
use crate::progress::Watch;
use crate::settings::{Vector, check_keywords, keyword, model_options};
use crate::sound::Sound;
use crate::timeline::Timeline;

/// A scene (`.toml`) or a timeline (`.timeline`) on its way to sound.
#[pyclass(frozen, module = "clangor")]
pub(crate) struct Session {
    inner: Mutex<clangor::Session<'static>>,
    watch: Watch,
}

/// A body of a session.
#[pyclass(frozen, get_all, module = "clangor")]
pub(crate) struct Body {
    /// Its name.
    name: String,
    /// Name of its material.
    material: String,
    /// Mass [kg]; infinite for a plane.
    mass: f64,
    /// Position of the centre of mass at the start [m].
    position: Vector,
}

const KEYWORDS: &[&str] = &[
    "text",
    "listeners",
    "duration",
    "seed",
    "sample_rate",
    "quality",
    "max_frequency",
    "cache",
    "timeline",
    "progress",
];

/// The keywords of a session.
struct Options {
    text: Option<String>,
    listeners: Option<Vec<Vector>>,
    duration: Option<f64>,
    seed: Option<u64>,
    sample_rate: Option<u32>,
    quality: Option<String>,
    max_frequency: Option<f64>,
    cache: Option<PathBuf>,
    timeline: Option<PathBuf>,
    progress: Option<Py<PyAny>>,
}

impl Options {
    fn of(options: &Bound<'_, PyDict>) -> PyResult<Self> {
        Ok(Options {
            text: keyword(options, "text")?,
            listeners: keyword(options, "listeners")?,
            duration: keyword(options, "duration")?,
            seed: keyword(options, "seed")?,
            sample_rate: keyword(options, "sample_rate")?,
            quality: keyword(options, "quality")?,
            max_frequency: keyword(options, "max_frequency")?,
            cache: keyword(options, "cache")?,
            timeline: keyword(options, "timeline")?,
            progress: keyword(options, "progress")?,
        })
    }
}

impl Options {
    fn builder(&self, watch: &Watch) -> PyResult<SessionBuilder<'static>> {
        let reached = watch.clone();
        let models = model_options(self.quality.as_deref().unwrap_or("normal"), self.max_frequency)?;
        let mut builder =
            SessionBuilder::new().models(models).on_progress(move |progress| reached.reached(progress));
        for position in self.listeners.iter().flatten() {
            builder = builder.listener(*position);
        }
        if let Some(seconds) = self.duration {
            builder = builder.duration(seconds);
        }
        if let Some(seed) = self.seed {
            builder = builder.seed(seed);
        }
        if let Some(hz) = self.sample_rate {
            builder = builder.sample_rate(hz);
        }
        if let Some(folder) = &self.cache {
            builder = builder.cache(folder);
        }
        if let Some(folder) = &self.timeline {
            builder = builder.keep_timeline(folder, true);
        }
        Ok(builder)
    }
}

#[pymethods]
impl Session {
    /// Opens a scene or a timeline. What is not given follows the scene.
    #[new]
    #[pyo3(
        signature = (path=None, **options),
        text_signature = "(path=None, *, text=None, listeners=None, duration=None, seed=None, \
                          sample_rate=None, quality='normal', max_frequency=None, cache=None, timeline=None, \
                          progress=None)"
    )]
    fn new(py: Python<'_>, path: Option<PathBuf>, options: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let options = options.cloned().unwrap_or_else(|| PyDict::new(py));
        check_keywords(&options, KEYWORDS)?;
        let options: Options = Options::of(&options)?;
        let watch = Watch::new(options.progress.as_ref().map(|callback| callback.clone_ref(py)));
        let builder = options.builder(&watch)?;
        let text = options.text;
        let inner = py.detach(|| match (path, text) {
            (Some(path), None) => builder.open(path).map_err(raised),
            (None, Some(text)) => {
                let scene = Scene::from_toml(&text).map_err(raised)?;
                builder.from_scene(scene).map_err(raised)
            }
            _ => Err(PyValueError::new_err("give either `path` or `text`")),
        })?;
        Ok(Session { inner: Mutex::new(inner), watch })
    }

    /// The bodies: those present from the beginning, and after `simulate` all that ever were.
    #[getter]
    fn bodies(&self) -> PyResult<Vec<Body>> {
        let inner = self.lock()?;
        let body = |body: &clangor::body::Body| Body {
            name: body.name.clone(),
            material: body.material.name.clone(),
            mass: body.mass,
            position: body.pose.position.to_array(),
        };
        Ok(inner.bodies().iter().map(body).collect())
    }

    /// Warnings of the scene.
    #[getter]
    fn warnings(&self) -> PyResult<Vec<String>> {
        let inner = self.lock()?;
        Ok(inner
            .scene()
            .map_or_else(Vec::new, |loaded| loaded.warnings.iter().map(ToString::to_string).collect()))
    }

    /// Simulates the scene, or reads the timeline. Returns what happened, of what is heard.
    fn simulate(&self, py: Python<'_>) -> PyResult<Timeline> {
        self.work(py, |session| {
            session.simulate()?;
            let bodies = session.bodies().iter().map(|body| body.name.clone()).collect();
            Ok(Timeline::new(bodies, session.timeline().unwrap_or(&Default::default())))
        })
    }

    /// Bakes the sound models of all struck bodies, or finds them in the cache. Returns remarks on them.
    fn bake(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        self.work(py, |session| {
            let models = session.obtain_models()?;
            Ok(models.remarks.iter().map(ToString::to_string).collect())
        })
    }

    /// Simulates, bakes and renders. Returns the sound at each listener; with `output`, writes it to a WAV
    /// file too.
    #[pyo3(signature = (output=None))]
    fn render(&self, py: Python<'_>, output: Option<PathBuf>) -> PyResult<Vec<Sound>> {
        let (heard, rate) = self.work(py, |session| {
            if let Some(output) = output {
                session.render(output)?;
            }
            let rate = session.options().synthesis.sample_rate.hz();
            Ok((session.pressures()?, rate))
        })?;
        heard
            .into_iter()
            .map(|HeardPressure { listener, channels, interleaved }| {
                Sound::new(py, listener, rate, (interleaved, channels))
            })
            .collect()
    }
}

impl Session {
    /// The session, unless another thread works with it.
    pub(crate) fn lock(&self) -> PyResult<MutexGuard<'_, clangor::Session<'static>>> {
        match self.inner.try_lock() {
            Ok(inner) => Ok(inner),
            Err(TryLockError::WouldBlock) => {
                Err(PyRuntimeError::new_err("another thread works with this session"))
            }
            Err(TryLockError::Poisoned(_)) => {
                Err(PyRuntimeError::new_err("this session failed before; open it again"))
            }
        }
    }

    /// Works without the interpreter's lock.
    fn work<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut clangor::Session<'static>) -> Result<T, clangor::Error> + Send,
    ) -> PyResult<T> {
        py.detach(|| {
            let mut inner = self.lock()?;
            work(&mut inner).map_err(|error| self.watch.cause(raised(error)))
        })
    }
}
