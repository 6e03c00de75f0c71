//! Systems at many wavenumbers of a band, from a few that are assembled.
//!
//! ```text
//! A_ij(k) = e^{−ikr_ij} B_ij(k)/k,    b_i(k) = e^{−ikR} c_i(k)/k
//! ```
//!
//! with r_ij the distance of the vertices i and j. An entry integrates e^{−ikr} over the triangles at its two
//! vertices: without the phase of the vertices, B is as smooth in k as a wave across an edge, and is
//! interpolated from [a few Chebyshev nodes](entry_table). A load integrates over the whole body, with delays
//! from 0 to 2R/c: it needs [more nodes](load_table), but is a vector. The factor k removes that of γ.
//!
//! The dense factorisation is shared likewise: [anchors](anchors), evenly spaced in k, are factorised, and a
//! system between them is solved by iteration with the factors of the nearest one.
//!
//! A result depends on its wavenumber and on the band, not on what was solved before.
//!
//! Not for wavenumbers below 1/R, where γ is another function of k, nor for bodies whose tables do not fit in
//! [`MEMORY`].

pub(crate) mod anchors;
mod chebyshev;
mod entry_table;
mod load_table;
mod phased_column;
mod refinement;
mod spares;

use std::sync::OnceLock;

use num_complex::Complex32;
use rayon::prelude::*;

use self::anchors::Anchors;
use self::entry_table::EntryTable;
use self::load_table::LoadTable;
use self::spares::Spares;
use super::dense_system::ClassSystem;
use super::parity_classes::ParityClass;
use super::{TriangleSolver, narrow};

/// Lowest wavenumber of the tables [1/R].
const LOWEST: f64 = 1.0;
/// Lowest end of a band that is worth its tables [1/R].
pub(crate) const SHORTEST: f64 = 4.0;
/// Memory of the tables and the factors [bytes].
pub(crate) const MEMORY: usize = 3 << 30;

/// Least error of a solution: that of single precision.
const LEAST_ERROR: f64 = 1e-5;

/// A band of wavenumbers [1/R], and the relative error of systems and solutions in it.
#[derive(Clone, Copy, Debug)]
struct Band {
    lowest: f64,
    highest: f64,
    error: f64,
}

/// What the wavenumbers of a band share.
#[derive(Clone, Debug)]
pub(super) struct Sweep {
    band: Band,
    entries: OnceLock<EntryTable>,
    loads: OnceLock<LoadTable>,
    anchors: Anchors,
    spares: Spares,
}

impl TriangleSolver {
    /// Prepares for solves at many wavenumbers up to `highest` [1/m], with a relative `error` besides that of
    /// the triangles: 1e-5 or more.
    ///
    /// Worth its memory from some twenty solves on. A body that is too large or whose band is too low for it
    /// is solved as before.
    #[must_use]
    pub fn for_many_wavenumbers(self, highest: f64, error: f64) -> Self {
        let band = Band { lowest: LOWEST, highest: highest * self.radius, error: error.max(LEAST_ERROR) };
        let tables = EntryTable::bytes(&self, &band);
        let sweep = (band.highest > SHORTEST && tables <= MEMORY).then(|| Sweep {
            band,
            entries: OnceLock::new(),
            loads: OnceLock::new(),
            anchors: Anchors::new(&self.classes, &band, MEMORY - tables),
            spares: Spares::default(),
        });
        Self { sweep, ..self }
    }

    /// The same, with what solves for motions of the surface share computed
    /// ([`radiate`](Self::radiate)): worth its time from some ten of them on.
    #[must_use]
    pub fn for_many_motions(self, highest: f64, error: f64) -> Self {
        let solver = self.for_many_wavenumbers(highest, error);
        if let Some(sweep) = &solver.sweep {
            sweep.entries.get_or_init(|| EntryTable::new(&solver, &sweep.band));
        }
        solver
    }

    /// Memory of what systems of many wavenumbers share [bytes].
    pub(crate) fn table_bytes(&self) -> usize {
        self.sweep.as_ref().map_or(0, |sweep| EntryTable::bytes(self, &sweep.band))
    }
}

impl Sweep {
    /// Whether the tables hold at a wavenumber [1/R].
    pub(super) fn covers(&self, k: f64) -> bool {
        (self.band.lowest..=self.band.highest * (1.0 + 1e-9)).contains(&k)
    }

    /// Computes what solves at these wavenumbers [1/R] share.
    pub(super) fn prepare(&self, solver: &TriangleSolver, wavenumbers: &[f64]) {
        let covered: Vec<f64> = wavenumbers.iter().copied().filter(|k| self.covers(*k)).collect();
        if covered.is_empty() {
            return;
        }
        self.entries.get_or_init(|| EntryTable::new(solver, &self.band));
        self.loads.get_or_init(|| LoadTable::new(solver, &self.band));
        let needed = self.anchors.missing(&covered);
        needed.into_par_iter().for_each(|anchor| {
            let systems = self.systems(solver, self.anchors.wavenumber(anchor));
            self.anchors.factorise(anchor, systems.unwrap_or_default());
        });
    }

    /// The unknowns of each parity class at a wavenumber [1/R], one motion after the other; `None` before
    /// [`prepare`](Self::prepare).
    pub(super) fn solve(&self, solver: &TriangleSolver, k: f64) -> Option<Vec<Vec<Complex32>>> {
        let systems = self.systems(solver, k)?;
        Some(self.anchors.solve(k, systems, &self.spares))
    }

    /// The matrices of any parity classes at a wavenumber [1/R], column by column; `None` outside the band
    /// and before they are prepared.
    pub(super) fn matrices(&self, classes: &[ParityClass], k: f64) -> Option<Vec<Vec<Complex32>>> {
        let entries = self.entries.get().filter(|_| self.covers(k))?;
        Some(entries.matrices(classes, k, &self.spares))
    }

    /// The systems at a wavenumber [1/R].
    fn systems(&self, solver: &TriangleSolver, k: f64) -> Option<Vec<ClassSystem>> {
        let entries = self.entries.get()?;
        let loads = self.loads.get()?.at(k);
        let matrices = entries.matrices(&solver.classes, k, &self.spares);
        let systems = solver.classes.iter().zip(matrices).map(|(class, matrix)| {
            let right = class.motions.iter().flat_map(|d| class.vertices().map(|v| narrow(loads[v][*d])));
            ClassSystem { size: class.size, right: right.collect(), matrix }
        });
        Some(systems.collect())
    }
}
