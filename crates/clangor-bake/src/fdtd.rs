//! Time-domain solver: the wave equation around a body driven by an acceleration pulse, on a regular grid.
//!
//! The published way to precompute acceleration noise (\[PAN\] §4: second-order leapfrog on a staggered grid,
//! a perfectly matched layer), for any closed surface, cavities and thin walls included. It also checks the
//! boundary elements independently. One run per motion:
//!
//! ```text
//! surface ─► cut cells ─► rows ─► leapfrog + absorber ─► multipoles on a sphere ─► spectra ─► samples
//!            cut_cells    boundary  grid, absorber                recorder                   field, tail
//! ```
//!
//! Differs from \[PAN\], which makes each cell all solid or all air and reads pulses at points:
//!
//! * cells are cut ([`Boundary::CutCells`]): the error at 8 cells per radius falls from 9 % to 0.2 %, and is
//!   of second order instead of first;
//! * the Laplacian is isotropic and the spectrum is read at the frequency at which the *grid* carries the
//!   wavenumber, so that there is no dispersion up to fourth order;
//! * the grid ends just beyond 1.25 to 1.5 R: outside, multipoles are exact at any distance;
//! * of a body with mirror planes one side is simulated (`mirrors`).
//!
//! It is not for the highest accuracy (the error falls with h², the cost grows with h⁻⁴), and it does not
//! model the losses at walls. Sharp edges reduce the order: the level of a wall of 1.8 mm with edges of 90°
//! is 5.3, 3.0, 2.1 % too low at cells of 0.9, 0.6, 0.45 mm; in theory the error falls with h^{4/3}, for
//! triangles too. Signals that have not decayed when the run ends are continued by their resonances (`tail`).

mod absorber;
mod boundary;
mod cut_cells;
mod field;
#[cfg(feature = "gpu")]
mod gpu;
mod grid;
mod lattice;
mod mirrors;
mod modal_bursts;
mod pulse;
mod recorder;
mod row_blocks;
mod tail;

use std::ops::ControlFlow;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::math::spherical_harmonics::count;
use clangor_core::sound_model::acceleration::field::RIGID_DOFS;
use glam::DVec3;
use num_complex::Complex64;
use rayon::prelude::*;

pub use boundary::Boundary;
use boundary::Rows;
use cut_cells::CutCells;
pub use field::WaveField;
use grid::{Drive, WaveGrid};
use lattice::{COURANT, GHOSTS, Lattice, phase_per_step};
use mirrors::Mirrors;
pub use modal_bursts::{DrivenPlace, WaveMotion};
use pulse::Pulse;
use recorder::{Recorder, Sphere};
use tail::Tail;

use crate::gpu::GpuError;

/// Smallest and largest radius of the recording sphere, in bounding radii.
const RECORDING: [f64; 2] = [1.25, 1.5];
/// Least distance of the smallest sphere from that of the body \[cells\].
const CELLS_BETWEEN: f64 = 4.0;
/// What is left on it of multipoles that alias, and the lowest degree of those beyond the order.
const ALIASED: (f64, usize) = (1e-4, 12);
/// Position of the centre of mass in its cell: no face of a symmetric body coincides with a grid plane.
const OFFSET: DVec3 = DVec3::new(0.137, 0.271, 0.391);
/// Samples of the recorded signals per shortest period of the band. The pulse has no energy where they would
/// alias.
const OVERSAMPLING: f64 = 4.5;

/// Time in which a wave crosses the body, in R/c.
const PASSED: f64 = 2.0;

/// Device of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum WaveDevice {
    /// On this machine's processor.
    #[default]
    Cpu,
    /// On its graphics processor ([`crate::gpu`]); needs the feature `gpu`.
    Gpu,
}

/// Settings of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WaveOptions {
    /// Highest wavenumber of the band, k = 2πf/c [1/m].
    pub max_wavenumber: f64,
    /// Edge of a cell h \[m\].
    pub spacing: f64,
    /// Highest degree of the multipoles.
    pub order: usize,
    /// How cells at the surface are treated.
    pub boundary: Boundary,
    /// Longest time simulated after the pulse, in R/c.
    pub longest: f64,
}

impl WaveOptions {
    /// Cells and steps of the run of each motion, for a body of bounding radius `radius` \[m\] with so many
    /// mirror planes; without the pulse, some hundred steps.
    pub(crate) fn extent(&self, radius: f64, planes: usize) -> [f64; 2] {
        let half = half_width(radius / self.spacing, self.order);
        let cells = (2.0 * half).powi(3 - planes.min(3) as i32) * (half + GHOSTS as f64).powi(planes as i32);
        [cells, self.steps_after(radius) as f64]
    }

    /// Steps from the end of a pulse to the end of a run.
    fn steps_after(&self, radius: f64) -> usize {
        let cells = radius / self.spacing;
        ((recording(self.order, cells) + self.longest) * cells / COURANT) as usize
    }
}

/// Reasons why a body cannot be simulated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum WaveError {
    /// No triangles or a coordinate that is not finite.
    #[error("the surface has no extent or coordinates that are not finite")]
    Surface,
    /// An option that is not a positive number.
    #[error("{name} is {value}, and must be positive")]
    Option {
        /// Name of the option.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// A band that the cells do not resolve.
    #[error(
        "cells of {spacing:.3e} m do not resolve a wavenumber of {wavenumber:.4e} 1/m; {most:.3e} m would"
    )]
    Coarse {
        /// Edge of a cell \[m\].
        spacing: f64,
        /// Highest wavenumber of the band [1/m].
        wavenumber: f64,
        /// Largest sufficient edge \[m\].
        most: f64,
    },
    /// More cells than are supported.
    #[error("the body needs {cells} cells of {spacing:.3e} m, more than the {most} that are run")]
    TooLarge {
        /// Cells needed.
        cells: usize,
        /// Largest number supported.
        most: usize,
        /// Edge of a cell \[m\].
        spacing: f64,
    },
    /// A part between mirror planes where the whole grid is needed.
    #[error("modes and graphics processors take the whole grid, not a part between mirror planes")]
    Mirrored,
    /// No graphics processor, or a failure of it.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// Stopped by the caller.
    #[error("interrupted")]
    Interrupted,
}

/// Most cells of a grid: indices have 32 bits, and six grids of this size take 12 GB.
pub(crate) const MOST_CELLS: usize = 256_000_000;
/// Most cells of the box about a body, all sides of its mirror planes, in which cells are cut: 2.6 GB.
pub(crate) const MOST_CUT_CELLS: usize = 80_000_000;
/// Least half-width of a grid \[cells\]: rows between a mirror plane and the rim fill the widest vectors.
const LEAST_WIDTH: f64 = 16.0;
/// Largest kh: 6 cells per wavelength.
const MOST_PHASE: f64 = 1.05;

/// Radius of the recording sphere of multipoles up to a degree, in bounding radii, for a body of this
/// radius in cells. Where waves of higher degree decay sooner it is smaller, and the grid with it.
fn recording(order: usize, radius: f64) -> f64 {
    let [least, most] = RECORDING;
    let (left, beyond) = ALIASED;
    let least = (1.0 + CELLS_BETWEEN / radius).clamp(least, most);
    left.powf(-1.0 / (order + beyond) as f64).clamp(least, most)
}

/// Half the cells along an axis of a grid that holds the recording sphere and the absorbing layer, for a body
/// of this radius in cells, and multipoles up to a degree.
fn half_width(radius: f64, order: usize) -> f64 {
    let width = (recording(order, radius) * radius).ceil() + (recorder::REACH + absorber::LAYER + 2) as f64;
    width.max(LEAST_WIDTH)
}

/// Cells of `spacing` \[m\] in the box about a surface with mirror planes of these normals, without its
/// margin.
pub(crate) fn cut_cells(surface: &TriMesh, normals: &[DVec3], spacing: f64) -> f64 {
    let mirrors = Mirrors::new(normals);
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for vertex in &surface.vertices {
        let place = mirrors.frame.transpose() * *vertex;
        (low, high) = (low.min(place), high.max(place));
    }
    ((high - low) / spacing).element_product()
}

/// A body in its grid, ready to run.
#[derive(Clone, Debug)]
pub struct WaveSolver {
    options: WaveOptions,
    radius: f64,
    mirrors: Mirrors,
    lattice: Lattice,
    centre: DVec3,
    rows: Rows,
    closed: usize,
}

impl WaveSolver {
    /// Lays a grid around a closed surface about its centre of mass \[m\].
    ///
    /// # Errors
    /// [`WaveError`].
    pub fn try_new(surface: &TriMesh, options: WaveOptions) -> Result<Self, WaveError> {
        Self::try_symmetric(surface, &[], options)
    }

    /// The same for a surface with mirror planes of these orthogonal normals through its centre of mass: one
    /// side of each, which stands for the other. For rigid motions on the processor.
    ///
    /// # Errors
    /// [`WaveError`].
    pub fn try_symmetric(
        surface: &TriMesh,
        normals: &[DVec3],
        options: WaveOptions,
    ) -> Result<Self, WaveError> {
        let h = options.spacing;
        // Validate the options, the surface and the resolution.
        for (name, value) in
            [("max_wavenumber", options.max_wavenumber), ("spacing", h), ("longest", options.longest)]
        {
            if !(value > 0.0 && value.is_finite()) {
                return Err(WaveError::Option { name, value });
            }
        }
        let radius = surface.bounding_radius(DVec3::ZERO);
        if !(radius > 0.0 && radius.is_finite()) || surface.vertices.iter().any(|v| !v.is_finite()) {
            return Err(WaveError::Surface);
        }
        if options.max_wavenumber * h > MOST_PHASE {
            return Err(WaveError::Coarse {
                spacing: h,
                wavenumber: options.max_wavenumber,
                most: MOST_PHASE / options.max_wavenumber,
            });
        }
        let mirrors = Mirrors::new(normals);
        let half = half_width(radius / h, options.order);
        let [cells, _] = options.extent(radius, normals.len());
        if cells > MOST_CELLS as f64 {
            return Err(WaveError::TooLarge { cells: cells as usize, most: MOST_CELLS, spacing: h });
        }
        let cut = cut_cells(surface, normals, h);
        if cut > MOST_CUT_CELLS as f64 {
            return Err(WaveError::TooLarge { cells: cut as usize, most: MOST_CUT_CELLS, spacing: h });
        }
        // The whole grid, and the part of it before the mirror planes, which lie between cells.
        let of_axis = |mirrored: bool, whole: usize, part: usize| if mirrored { part } else { whole };
        let width = half as usize;
        let size = mirrors.planes.map(|mirrored| of_axis(mirrored, 2 * width, width + GHOSTS));
        let origin = mirrors.planes.map(|mirrored| of_axis(mirrored, 0, width - GHOSTS));
        let lattice = Lattice { size, mirrored: mirrors.planes };
        // Cut the cells at the surface, in units of cells.
        let offset = std::array::from_fn(|axis| if mirrors.planes[axis] { 0.0 } else { OFFSET[axis] });
        let centre = DVec3::splat(half) + DVec3::from_array(offset);
        let vertices = surface.vertices.iter().map(|v| mirrors.clear(*v / h)).collect();
        let scaled = TriMesh { vertices, triangles: surface.triangles.clone() };
        let mut cut = CutCells::new(&scaled, centre);
        let closed = match options.boundary {
            Boundary::CutCells => cut.close_walls(centre),
            Boundary::Staircase => {
                cut.coarsen(centre);
                0
            }
        };
        // Sparse update rows of the cells near the body.
        let rows = Rows::new(cut, &lattice, origin);
        let centre = centre - DVec3::from_array(origin.map(|cell| cell as f64));
        Ok(WaveSolver { options, radius, mirrors, lattice, centre, rows, closed })
    }

    /// Cells of the grid.
    pub fn cells(&self) -> usize {
        self.lattice.cells()
    }

    /// Cells that were closed because they contain both sides of a wall. More than zero means that some walls
    /// are thinner than the grid resolves; their thickness is off by up to a cell.
    pub fn closed_cells(&self) -> usize {
        self.closed
    }

    /// Runs the six motions on the processor. `progress` receives the completed part, and may stop the rest.
    ///
    /// # Errors
    /// [`WaveError::Interrupted`].
    pub fn run(&self, progress: &(dyn Fn(f64) -> ControlFlow<()> + Sync)) -> Result<WaveField, WaveError> {
        self.run_on(WaveDevice::Cpu, progress)
    }

    /// Runs the six motions on either processor: fields agree to 1e-5.
    ///
    /// # Errors
    /// [`WaveError::Interrupted`], [`WaveError::Gpu`], [`WaveError::Mirrored`].
    pub fn run_on(
        &self,
        device: WaveDevice,
        progress: &(dyn Fn(f64) -> ControlFlow<()> + Sync),
    ) -> Result<WaveField, WaveError> {
        let WaveOptions { max_wavenumber, spacing: h, order, .. } = self.options;
        let phase = phase_per_step(Complex64::from(max_wavenumber * h)).re;
        let stride = (std::f64::consts::TAU / (OVERSAMPLING * phase)).floor().max(1.0) as usize;
        let pulse = Pulse::new(phase);
        // Length of the run: the pulse, the travel time to the sphere, and the time of the options.
        let steps = pulse.values.len() + self.options.steps_after(self.radius);
        let signals = match device {
            WaveDevice::Cpu => self.mirrors.about_body(self.step_all(&pulse, stride, steps, progress)?),
            _ if self.mirrors.any() => return Err(WaveError::Mirrored),
            #[cfg(feature = "gpu")]
            WaveDevice::Gpu => {
                let (lattice, rows, pulse) = (&self.lattice, &self.rows, &pulse);
                let recorder = &self.recorder([1.0; 3]);
                gpu::signals(&gpu::GpuRun { lattice, rows, recorder, pulse, stride, steps }, progress)?
            }
            #[cfg(not(feature = "gpu"))]
            WaveDevice::Gpu => return Err(GpuError::NotBuilt.into()),
        };
        let updates = (RIGID_DOFS * steps * self.lattice.cells()) as f64;
        let free = pulse.values.len() + self.steps_of_passage();
        let weights: [f64; RIGID_DOFS] = std::array::from_fn(|d| if d < 3 { 1.0 } else { h / self.radius });
        let tail = Tail::fit(&signals, count(order), free.div_ceil(stride), &weights);
        Ok(WaveField { spacing: h, radius: self.radius, order, stride, pulse, updates, signals, tail })
    }

    /// Reads the recording sphere, of a field with these signs under the reflections.
    fn recorder(&self, signs: [f64; 3]) -> Recorder {
        let WaveOptions { spacing, order, .. } = self.options;
        let cells = self.radius / spacing;
        let sphere = Sphere { centre: self.centre, radius: recording(order, cells) * cells };
        Recorder::new(&self.lattice, sphere, order, &self.mirrors, signs)
    }

    /// Steps after the pulse until the direct wave, from any side of the body, has passed the recording
    /// sphere: only resonances remain.
    fn steps_of_passage(&self) -> usize {
        let WaveOptions { spacing, order, .. } = self.options;
        let cells = self.radius / spacing;
        ((recording(order, cells) + PASSED) * cells / COURANT) as usize
    }

    /// The time loop on the processor, one thread per motion of the axes of the mirror planes: the signal of
    /// each.
    fn step_all(
        &self,
        pulse: &Pulse,
        stride: usize,
        steps: usize,
        progress: &(dyn Fn(f64) -> ControlFlow<()> + Sync),
    ) -> Result<Vec<Vec<f64>>, WaveError> {
        let done = AtomicUsize::new(0);
        // Motions of the same parities share a recorder.
        let parities: [[f64; 3]; RIGID_DOFS] = std::array::from_fn(|motion| self.mirrors.signs(motion));
        let of_parities = |motion: usize| parities.iter().position(|signs| *signs == parities[motion]);
        let recorders: Vec<OnceLock<Recorder>> = vec![OnceLock::new(); RIGID_DOFS];
        (0..RIGID_DOFS)
            .into_par_iter()
            .map(|motion| {
                let signs = parities[motion];
                let recorder =
                    recorders[of_parities(motion).unwrap_or(motion)].get_or_init(|| self.recorder(signs));
                let drive = Drive::rigid(&self.rows, motion);
                let mut grid = WaveGrid::new(self.lattice, &self.rows, vec![drive], signs);
                let mut signals = Vec::with_capacity((steps / stride + 1) * count(self.options.order));
                for step in 0..steps {
                    if step % stride == 0 {
                        recorder.record(&self.lattice, grid.pressure(), &mut signals);
                        let done = done.fetch_add(stride, Ordering::Relaxed);
                        if progress(done as f64 / (RIGID_DOFS * steps) as f64).is_break() {
                            return Err(WaveError::Interrupted);
                        }
                    }
                    grid.step(&[pulse.at(step)]);
                }
                Ok(signals)
            })
            .collect()
    }
}
