//! Timelines as columns of NumPy arrays, which `pandas.DataFrame`, `polars.DataFrame` and `pyarrow.table`
//! take.

use clangor::glam::DVec3;
use clangor::pipeline::formats::timeline_file::TimelineReader;
use clangor::timeline::{self, ContactRow, PoseRow};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors::raised;

/// What happened: contacts and poses.
#[pyclass(frozen, module = "clangor")]
pub(crate) struct Timeline {
    bodies: Vec<String>,
    contacts: Vec<ContactRow>,
    poses: Vec<PoseRow>,
}

impl Timeline {
    pub(crate) fn new(bodies: Vec<String>, timeline: &timeline::Timeline) -> Self {
        Timeline { bodies, contacts: timeline.contacts.clone(), poses: timeline.poses.clone() }
    }
}

#[pymethods]
impl Timeline {
    /// Reads a timeline folder.
    #[staticmethod]
    fn open(py: Python<'_>, path: std::path::PathBuf) -> PyResult<Self> {
        py.detach(|| {
            let reader = TimelineReader::open(&path).map_err(raised)?;
            let bodies = reader.header().world.bodies.iter().map(|body| body.name.clone()).collect();
            let timeline = reader.read_all().map_err(raised)?;
            Ok(Timeline { bodies, contacts: timeline.contacts, poses: timeline.poses })
        })
    }

    /// Names of the bodies; `body_a`, `body_b` and `body` are indices into them, −1 is the surroundings.
    #[getter]
    fn bodies(&self) -> Vec<String> {
        self.bodies.clone()
    }

    /// One row per contact point and instant, as columns: `t` [s], `body_a`, `body_b`, `kind`, `impact_id`,
    /// `impulse_n` [N s], `depth` [m], `effective_mass` [kg] (NaN for that of the bodies alone), and
    /// `point_x`, `normal_x`, `impulse_t_x`, `couple_x`, `velocity_x` with their `_y` and `_z`.
    #[getter]
    fn contacts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let rows = &self.contacts;
        let columns = PyDict::new(py);
        columns.set_item("t", column(py, rows, |row| row.time))?;
        columns.set_item("body_a", column(py, rows, |row| index(row.body_a)))?;
        columns.set_item("body_b", column(py, rows, |row| index(row.body_b)))?;
        columns.set_item("kind", column(py, rows, |row| row.kind as u8))?;
        columns.set_item("impact_id", column(py, rows, |row| row.impact_id))?;
        columns.set_item("impulse_n", column(py, rows, |row| row.impulse_n))?;
        columns.set_item("depth", column(py, rows, |row| row.depth))?;
        columns.set_item("effective_mass", column(py, rows, |row| row.effective_mass.unwrap_or(f64::NAN)))?;
        vector(&columns, "point", rows, |row| row.point)?;
        vector(&columns, "normal", rows, |row| row.normal)?;
        vector(&columns, "impulse_t", rows, |row| row.impulse_t)?;
        vector(&columns, "couple", rows, |row| row.couple)?;
        vector(&columns, "velocity", rows, |row| row.velocity)?;
        Ok(columns)
    }

    /// One row per body and recorded instant, as columns: `t` [s], `body`, `position_x` [m], `velocity_x`,
    /// `angular_velocity_x` with their `_y` and `_z`, and `orientation_x`, `_y`, `_z`, `_w`.
    #[getter]
    fn poses<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let rows = &self.poses;
        let columns = PyDict::new(py);
        columns.set_item("t", column(py, rows, |row| row.time))?;
        columns.set_item("body", column(py, rows, |row| index(row.body)))?;
        vector(&columns, "position", rows, |row| row.position)?;
        for (k, axis) in ["x", "y", "z", "w"].into_iter().enumerate() {
            let values = column(py, rows, |row| row.orientation.to_array()[k]);
            columns.set_item(format!("orientation_{axis}"), values)?;
        }
        vector(&columns, "velocity", rows, |row| row.velocity)?;
        vector(&columns, "angular_velocity", rows, |row| row.angular_velocity)?;
        Ok(columns)
    }

    fn __repr__(&self) -> String {
        let (bodies, contacts, poses) = (self.bodies.len(), self.contacts.len(), self.poses.len());
        format!("Timeline({bodies} bodies, {contacts} contact rows, {poses} poses)")
    }
}

fn index(body: clangor::body::BodyId) -> i64 {
    if body == clangor::body::BodyId::WORLD { -1 } else { i64::from(body.0) }
}

fn column<'py, R, T: numpy::Element>(
    py: Python<'py>,
    rows: &[R],
    value: impl Fn(&R) -> T,
) -> Bound<'py, PyArray1<T>> {
    PyArray1::from_vec(py, rows.iter().map(value).collect())
}

fn vector<R>(
    columns: &Bound<'_, PyDict>,
    name: &str,
    rows: &[R],
    value: impl Fn(&R) -> DVec3,
) -> PyResult<()> {
    for (k, axis) in ["x", "y", "z"].into_iter().enumerate() {
        columns.set_item(format!("{name}_{axis}"), column(columns.py(), rows, |row| value(row)[k]))?;
    }
    Ok(())
}
