//! Progress of long work: a callback of Python, and Ctrl-C.

use std::ops::ControlFlow;
use std::sync::{Arc, Mutex, PoisonError};

use clangor::{Progress, Stage};
use pyo3::prelude::*;

/// A callback, and the exception with which it or a signal stopped the work.
#[derive(Clone)]
pub(crate) struct Watch {
    callback: Option<Arc<Py<PyAny>>>,
    raised: Arc<Mutex<Option<PyErr>>>,
}

impl Watch {
    /// `callback(stage, done, body, step)` may return `False` to stop.
    pub(crate) fn new(callback: Option<Py<PyAny>>) -> Self {
        Watch { callback: callback.map(Arc::new), raised: Arc::default() }
    }

    /// Reports progress; breaks after a signal, an exception or `False`.
    pub(crate) fn reached(&self, progress: &Progress<'_>) -> ControlFlow<()> {
        let outcome = Python::attach(|py| {
            py.check_signals()?;
            let Some(callback) = &self.callback else { return Ok(true) };
            let Progress { stage, done, body, step } = *progress;
            let answer = callback.call1(py, (name(stage), done, body, step))?;
            Ok(answer.is_none(py) || answer.is_truthy(py)?)
        });
        match outcome {
            Ok(true) => ControlFlow::Continue(()),
            Ok(false) => ControlFlow::Break(()),
            Err(error) => {
                *self.raised.lock().unwrap_or_else(PoisonError::into_inner) = Some(error);
                ControlFlow::Break(())
            }
        }
    }

    /// The exception that stopped the work, or `otherwise`.
    pub(crate) fn cause(&self, otherwise: PyErr) -> PyErr {
        self.raised.lock().unwrap_or_else(PoisonError::into_inner).take().unwrap_or(otherwise)
    }
}

fn name(stage: Stage) -> &'static str {
    match stage {
        Stage::Simulation => "simulation",
        Stage::Acceleration => "acceleration",
        Stage::Modal => "modal",
        Stage::Render => "render",
        Stage::Level => "level",
        Stage::Playback => "playback",
    }
}
