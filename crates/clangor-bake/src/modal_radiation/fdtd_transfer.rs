//! Radiation of the modes of any closed surface by finite differences in time, several modes in one run.
//!
//! For large bodies without mirror planes, beyond the reach of boundary elements. The motion of a mode acts
//! on the cells that the surface cuts, with U from the nearest face of similar orientation, and its flux
//! corrected to the exact one. For cost and error see [`crate::fdtd`]; for the modes of a shared run,
//! [`crate::fdtd::WaveSolver::run_modes`].

use std::f64::consts::TAU;
use std::ops::ControlFlow;

use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::math::radial::outgoing;
use clangor_core::sound_model::modal::model::ModalTransfer;
use clangor_core::sound_model::modal::surface::{ModalSurface, SurfaceLocator};
use glam::DVec3;
use num_complex::Complex64;

use super::surface_motion::volume_flux;
use super::{ModalMotion, ModalSolver, check};
use crate::acceleration::{BakeProgress, has_cavities, watched};
use crate::fdtd::{Boundary, MOST_CELLS, WaveError, WaveMotion, WaveOptions, WaveSolver};
use crate::modal_radiation::bem_transfer::{order, trimmed};
use crate::radiation::RadiationError;

/// Least number of cells per shortest wavelength, across a wall and on the radius.
const CELLS: [f64; 3] = [10.0, 2.0, 8.0];
/// Cell updates in a second of CPU time.
pub(super) const UPDATES: f64 = 8e8;
/// Time after the bursts, in R/c, for a body without cavities and with them.
const LONGEST: [f64; 2] = [6.0, 30.0];

/// The modes of a closed surface by finite differences.
#[derive(Clone, Debug)]
pub struct FdtdModalSolver {
    solver: WaveSolver,
    radius: f64,
}

impl FdtdModalSolver {
    /// Prepares the surface of a body whose centre of mass is at the origin, with walls of thickness `wall`
    /// \[m\], for modes up to `highest` [1/m].
    ///
    /// # Errors
    /// [`WaveError`].
    pub fn try_new(surface: &TriMesh, highest: f64, wall: f64) -> Result<Self, WaveError> {
        let radius = surface.bounding_radius(DVec3::ZERO);
        Self::with_spacing(surface, highest, spacing(radius, highest, wall))
    }

    /// The same with cells of edge `spacing` \[m\].
    ///
    /// # Errors
    /// [`WaveError`].
    pub fn with_spacing(surface: &TriMesh, highest: f64, spacing: f64) -> Result<Self, WaveError> {
        let radius = surface.bounding_radius(DVec3::ZERO);
        let cavity = MassProperties::of(surface).is_ok_and(|mass| has_cavities(surface, &mass));
        let options = wave_options(radius, highest, spacing, cavity);
        Ok(FdtdModalSolver { solver: WaveSolver::try_new(surface, options)?, radius })
    }

    /// Cells of the grid.
    pub fn cells(&self) -> usize {
        self.solver.cells()
    }

    /// Cell updates for modes of these wavenumbers [1/m].
    pub fn updates(&self, wavenumbers: &[f64]) -> f64 {
        self.solver.updates_of_modes(wavenumbers)
    }
}

/// Settings of runs with cells of edge `spacing` \[m\].
fn wave_options(radius: f64, highest: f64, spacing: f64, has_cavities: bool) -> WaveOptions {
    WaveOptions {
        max_wavenumber: highest,
        spacing,
        order: order(highest * radius),
        boundary: Boundary::CutCells,
        longest: LONGEST[usize::from(has_cavities)],
    }
}

/// Edge of the cells \[m\].
fn spacing(radius: f64, highest: f64, wall: f64) -> f64 {
    let [on_wave, across, on_radius] = CELLS;
    (TAU / highest / on_wave).min(wall / across).min(radius / on_radius)
}

/// Cell updates for modes of these wavenumbers [1/m] of a body of bounding radius `radius` \[m\], without a
/// grid; `None` if there would be more cells than fit.
pub(crate) fn expected_updates(
    wavenumbers: &[f64],
    (radius, wall): (f64, f64),
    has_cavities: bool,
) -> Option<f64> {
    let highest = wavenumbers.iter().copied().fold(0.0, f64::max);
    let options = wave_options(radius, highest, spacing(radius, highest, wall), has_cavities);
    let [cells, _] = options.extent(radius, 0);
    (cells <= MOST_CELLS as f64).then(|| options.expected_updates_of_modes(wavenumbers, radius))
}

impl ModalSolver for FdtdModalSolver {
    fn transfers(
        &self,
        surface: &ModalSurface,
        motions: &[ModalMotion<'_>],
        progress: &mut dyn FnMut(usize) -> ControlFlow<()>,
    ) -> Result<Vec<ModalTransfer>, RadiationError> {
        check(surface, motions)?;
        let radius = surface.radius();
        // Surface point that drives each cut cell.
        let locator = SurfaceLocator::new(surface);
        let places = self.solver.places();
        let area: f64 = places.iter().map(|place| place.area.length()).sum();
        let located: Option<Vec<_>> =
            places.iter().map(|place| locator.nearest_facing(place.position, place.area)).collect();
        let located = located.ok_or(RadiationError::Empty)?;
        // Normal flux of each mode through the cells, with the exact volume flux.
        let driven: Vec<WaveMotion> = motions
            .iter()
            .map(|motion| {
                let at_places = located.iter().zip(&places);
                let mut flux: Vec<f64> =
                    at_places.map(|(at, place)| at.interpolate(motion.shape).dot(place.area)).collect();
                let excess = (flux.iter().sum::<f64>() - volume_flux(surface, motion.shape)) / area;
                flux.iter_mut().zip(&places).for_each(|(f, place)| *f -= excess * place.area.length());
                WaveMotion { wavenumber: motion.wavenumber, flux }
            })
            .collect();
        if progress(0).is_break() {
            return Err(RadiationError::Interrupted);
        }
        let mut on_progress =
            |on_progress: &BakeProgress| progress((on_progress.done * motions.len() as f64) as usize);
        // Time stepping of all modes.
        let solved = watched(&mut on_progress, |report| self.solver.run_modes(&driven, report))
            .map_err(|_| RadiationError::Interrupted)?;
        let of_motion = |(motion, mut coefficients): (&ModalMotion<'_>, Vec<Complex64>)| {
            // Multipoles from the sphere around the surface to that around the elements.
            let kappa = motion.wavenumber * self.radius;
            let highest = order(motion.wavenumber * radius).min(coefficients.len().isqrt() - 1);
            let mut waves = Vec::new();
            outgoing(Complex64::new(0.0, kappa), radius / self.radius, highest, &mut waves);
            coefficients.truncate((highest + 1) * (highest + 1));
            for (n, wave) in waves.iter().enumerate() {
                coefficients[n * n..(n + 1) * (n + 1)].iter_mut().for_each(|c| *c *= wave / radius);
            }
            if coefficients.iter().all(|c| c.is_finite()) {
                Ok(trimmed(coefficients, motion.wavenumber * radius))
            } else {
                Err(RadiationError::NotFinite { wavenumber: motion.wavenumber })
            }
        };
        motions.iter().zip(solved).map(of_motion).collect()
    }

    fn seconds(&self, wavenumbers: &[f64]) -> f64 {
        self.updates(wavenumbers) / UPDATES
    }
}
