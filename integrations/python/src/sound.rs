//! The pressure at a listener.

use numpy::{PyArray2, PyArrayMethods};
use pyo3::prelude::*;

/// The pressure at a listener.
#[pyclass(frozen, module = "clangor")]
pub(crate) struct Sound {
    /// Name of the listener.
    #[pyo3(get)]
    listener: String,
    /// Samples per second [Hz].
    #[pyo3(get)]
    sample_rate: u32,
    /// Pressure [Pa], one row per frame and one column per receiver.
    #[pyo3(get)]
    pressure: Py<PyArray2<f32>>,
}

impl Sound {
    /// Takes over interleaved samples.
    pub(crate) fn new(
        py: Python<'_>,
        listener: String,
        sample_rate: u32,
        (interleaved, channels): (Vec<f32>, usize),
    ) -> PyResult<Self> {
        let frames = interleaved.len() / channels.max(1);
        let flat = numpy::PyArray1::from_vec(py, interleaved);
        let pressure = flat.reshape([frames, channels])?.unbind();
        Ok(Sound { listener, sample_rate, pressure })
    }
}

#[pymethods]
impl Sound {
    /// Duration [s].
    #[getter]
    fn duration(&self, py: Python<'_>) -> f64 {
        self.frames(py) as f64 / f64::from(self.sample_rate)
    }

    /// Largest absolute pressure [Pa].
    #[getter]
    fn peak(&self, py: Python<'_>) -> f64 {
        let view = self.pressure.bind(py).readonly();
        view.as_array().iter().fold(0.0, |peak, p| f64::max(peak, f64::from(p.abs())))
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        format!(
            "Sound(listener={:?}, {} frames at {} Hz, peak {:.4} Pa)",
            self.listener,
            self.frames(py),
            self.sample_rate,
            self.peak(py)
        )
    }
}

impl Sound {
    fn frames(&self, py: Python<'_>) -> usize {
        self.pressure.bind(py).readonly().as_array().nrows()
    }
}
