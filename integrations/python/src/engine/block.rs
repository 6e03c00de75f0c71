//! A NumPy array that the real-time engine renders into.

use std::sync::MutexGuard;

use clangor::realtime::Engine;
use numpy::ndarray::{ArrayViewMut2, s};
use numpy::{
    BorrowError, Element, PyArray2, PyArrayDescrMethods, PyArrayMethods, PyReadwriteArray2, PyUntypedArray,
    PyUntypedArrayMethods, dtype,
};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

use crate::settings::named;

/// Most frames of a call: 350 s at 48 kHz.
const MOST_FRAMES: i64 = 1 << 24;
/// Frames that the engine renders at once.
const PART: usize = 4096;
/// Parts between looks for Ctrl-C.
const PARTS: usize = 16;

/// An array of single or double precision, one row per frame and one column per listener.
pub(crate) enum Block<'py> {
    Single(PyReadwriteArray2<'py, f32>),
    Double(PyReadwriteArray2<'py, f64>),
}

/// A number of frames.
pub(crate) fn frames_of(value: &Bound<'_, PyAny>) -> PyResult<usize> {
    let wrong = || {
        let value = value.repr().map_or_else(|_| "?".into(), |text| text.to_string());
        PyValueError::new_err(format!("frames is {value}; it can be 1 to {MOST_FRAMES}"))
    };
    match value.extract::<i64>() {
        Ok(frames) if (1..=MOST_FRAMES).contains(&frames) => Ok(frames as usize),
        Err(error) if error.is_instance_of::<PyTypeError>(value.py()) => Err(named("frames", error)),
        _ => Err(wrong()),
    }
}

impl<'py> Block<'py> {
    /// The array, which must have as many columns and, if it is asked for, as many frames.
    pub(crate) fn of(array: &Bound<'py, PyAny>, (frames, columns): (Option<usize>, usize)) -> PyResult<Self> {
        let Ok(untyped) = array.cast::<PyUntypedArray>() else {
            let kind = array.get_type().name()?;
            return Err(PyTypeError::new_err(format!("out is a {kind}; it must be a NumPy array")));
        };
        let shape = untyped.shape();
        let fits = matches!(shape, [rows, width]
            if *width == columns && *rows > 0 && frames.is_none_or(|frames| frames == *rows));
        if !fits {
            let rows = frames.map_or_else(|| "frames".to_owned(), |frames| frames.to_string());
            let message = format!("out has the shape {shape:?}; it must be [{rows}, {columns}]");
            return Err(PyValueError::new_err(message));
        }
        if !untyped.is_aligned() || overlaps(untyped) {
            let strides = untyped.strides();
            let message =
                format!("out: with strides of {strides:?} bytes, its numbers overlap or are not aligned");
            return Err(PyValueError::new_err(message));
        }
        let (py, kind) = (array.py(), untyped.dtype());
        if kind.is_equiv_to(&dtype::<f32>(py)) {
            Ok(Block::Single(writable(array)?))
        } else if kind.is_equiv_to(&dtype::<f64>(py)) {
            Ok(Block::Double(writable(array)?))
        } else {
            Err(PyTypeError::new_err(format!("out has the dtype {kind}; it must be float32 or float64")))
        }
    }

    /// Renders into the array, without the interpreter's lock.
    pub(crate) fn fill<'e>(
        &mut self,
        py: Python<'py>,
        engine: impl FnOnce() -> PyResult<MutexGuard<'e, Engine>> + Send,
    ) -> PyResult<()> {
        match self {
            Block::Single(array) => render(py, array.as_array_mut(), engine, |p| p as f32),
            Block::Double(array) => render(py, array.as_array_mut(), engine, |p| p),
        }
    }
}

fn render<'e, T: Send>(
    py: Python<'_>,
    mut block: ArrayViewMut2<'_, T>,
    engine: impl FnOnce() -> PyResult<MutexGuard<'e, Engine>> + Send,
    sample: fn(f64) -> T,
) -> PyResult<()> {
    py.detach(|| {
        let mut engine = engine()?;
        let frames = block.nrows();
        for (part, start) in (0..frames).step_by(PART).enumerate() {
            if part > 0 && part % PARTS == 0 {
                Python::attach(|py| py.check_signals())?;
            }
            let end = frames.min(start + PART);
            let channels = engine.render(end - start);
            let mut rows = block.slice_mut(s![start..end, ..]);
            for (mut column, channel) in rows.columns_mut().into_iter().zip(channels) {
                column.iter_mut().zip(channel).for_each(|(out, pressure)| *out = sample(*pressure));
            }
        }
        Ok(())
    })
}

/// The array, if nothing else in this package writes to it.
fn writable<'py, T: Element>(array: &Bound<'py, PyAny>) -> PyResult<PyReadwriteArray2<'py, T>> {
    let array = array.cast::<PyArray2<T>>().map_err(|error| named("out", error))?;
    array.try_readwrite().map_err(|error| match error {
        BorrowError::NotWriteable => PyValueError::new_err("out is read-only"),
        error => PyValueError::new_err(format!("out: {error}")),
    })
}

/// Whether two elements may share memory.
fn overlaps(array: &Bound<'_, PyUntypedArray>) -> bool {
    let size = array.dtype().itemsize();
    let mut axes: Vec<(usize, usize)> = array
        .strides()
        .iter()
        .zip(array.shape())
        .filter(|(_, count)| **count > 1)
        .map(|(stride, count)| (stride.unsigned_abs(), *count))
        .collect();
    axes.sort_unstable();
    let mut extent = size;
    axes.into_iter().any(|(stride, count)| {
        let overlapping = stride < extent;
        extent += stride * (count - 1);
        overlapping
    })
}
