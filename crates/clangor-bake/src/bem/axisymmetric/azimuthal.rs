//! Fields of any azimuthal order: a normal acceleration a(s) cos mφ or a(s) sin mφ at a real frequency.
//!
//! Both have the same pressure p(s) apart from the angle. All accelerations of the same k and m share the
//! matrix. Waves on one mesh share the terms that depend on the geometry alone.
//!
//! Where the interior may resonate, the equations at the nodes are extended by those at points inside and
//! solved by least squares. The residual pressure at further, unused points must then be small. If it is not,
//! more points are added.

use std::f64::consts::{PI, TAU};

use clangor_core::geometry::meridian::Meridian;
use faer::Mat;
use faer::linalg::solvers::SolveLstsq;
use glam::DVec2;
use num_complex::Complex64;
use rayon::prelude::*;

use super::inside::{first_resonance, inner_points, inscribed_radius};
use super::multipoles::AxisProjection;
use super::panels::Panels;
use super::ring::MidpointLadder;
use super::rows::{Observer, Row, RowContext, Wave};
use super::{AxisymmetricOptions, BATCH_MEMORY, MOST_UNKNOWNS, solve_system, system_matrix};
use crate::radiation::RadiationError;

/// Orders n of multipoles beyond kR and beyond m.
const EXTRA_ORDERS: usize = 10;

/// Upper limit of n: above it (2n − 1)!! overflows.
const MOST_ORDER: usize = 148;

/// Most waves that are solved at a time.
const MOST_WAVES: usize = 16;

/// Largest interior pressure that counts as zero, relative to the surface maximum of the loudest motion of a
/// wave. Beside a mode cos mφ the part sin mφ is the noise of its mesh, which no panel resolves: relative to
/// its own maximum, its pressure inside is never small.
const QUIET: f64 = 3e-4;

/// Attempts to add interior points before the solve fails.
const ATTEMPTS: usize = 4;

/// The solver of one body.
#[derive(Clone, Debug)]
pub struct AzimuthalSolver {
    meridian: Meridian,
    radius: f64,
    options: AxisymmetricOptions,
    resonance: f64,
}

/// The meridian cut into panels.
#[derive(Clone, Debug)]
pub struct MeridianMesh {
    panels: Panels,
}

/// A node of a [`MeridianMesh`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeridianNode {
    /// (r, y) \[m\].
    pub position: DVec2,
    /// Outward unit normal.
    pub normal: DVec2,
    /// Share of the length of the meridian \[m\]: weight of the rule.
    pub length: f64,
}

/// Vibrations of one order and frequency.
#[derive(Clone, Debug, PartialEq)]
pub struct RingWave {
    /// k [1/m].
    pub wavenumber: f64,
    /// m.
    pub order: usize,
    /// Normal accelerations at the nodes, of any number of surface motions, which are told from resonances of
    /// the interior to within a fraction of the loudest.
    pub accelerations: Vec<Vec<f64>>,
}

/// The field of one surface motion, for ρ = 1.
#[derive(Clone, Debug, PartialEq)]
pub struct RingField {
    /// Pressure at the nodes.
    pub pressure: Vec<Complex64>,
    /// Multipoles on the sphere of the reference radius R about the origin, n from 0: with φ counted as for
    /// the acceleration and the axis as the polar one, p e^{ikr} = Σ c_n x^{−(n+1)} θₙ(ikRx)/θₙ(ikR) Y_n,±m,
    /// x = r/R.
    pub coefficients: Vec<Complex64>,
}

impl MeridianMesh {
    /// The nodes, panel after panel.
    pub fn nodes(&self) -> impl Iterator<Item = MeridianNode> + '_ {
        self.panels.nodes.iter().map(|node| {
            let speed = node.normal.length();
            MeridianNode { position: node.position, normal: node.normal / speed, length: node.weight * speed }
        })
    }

    /// Values at the nodes of another mesh of the same meridian from those at the nodes of this one.
    pub fn interpolate(&self, values: &[f64], onto: &MeridianMesh) -> Vec<f64> {
        let count = self.panels.rule.len();
        let mut cardinal = vec![0.0; count];
        onto.panels
            .nodes
            .iter()
            .map(|node| {
                let piece = onto.panels.panels[node.panel].piece;
                let (panel, x) = self.panels.locate(piece, node.t);
                self.panels.cardinal(x, &mut cardinal);
                let own = &values[panel * count..(panel + 1) * count];
                own.iter().zip(&cardinal).map(|(v, c)| v * c).sum()
            })
            .collect()
    }

    /// ∫ (da/ds)² r ds of values at the nodes.
    pub fn slope_square(&self, values: &[f64]) -> f64 {
        let count = self.panels.rule.len();
        let slopes = self.panels.slopes();
        let span = |panel: usize| self.panels.panels[panel].end - self.panels.panels[panel].start;
        let at_node = |(i, node): (usize, MeridianNode)| {
            let (panel, own) = (i / count, i % count);
            let here = &values[panel * count..(panel + 1) * count];
            let slope: f64 = here.iter().zip(&slopes[own * count..]).map(|(v, d)| v * d).sum();
            let speed = self.panels.nodes[i].normal.length() * span(panel);
            (slope / speed).powi(2) * node.position.x * node.length
        };
        self.nodes().enumerate().map(at_node).sum()
    }
}

impl AzimuthalSolver {
    /// For a meridian about the origin, with multipoles on the sphere of `radius` \[m\]. The highest
    /// wavenumber of the options is ignored: each mesh has its own.
    pub fn new(meridian: &Meridian, radius: f64, options: AxisymmetricOptions) -> Self {
        let resonance = first_resonance(inscribed_radius(meridian));
        AzimuthalSolver { meridian: meridian.clone(), radius, options, resonance }
    }

    /// A mesh that resolves waves of this wavenumber [1/m], both in the air and on the surface.
    ///
    /// # Errors
    /// [`RadiationError::TooLarge`].
    pub fn mesh(&self, wavenumber: f64) -> Result<MeridianMesh, RadiationError> {
        let length: f64 = self.meridian.pieces().iter().map(|piece| piece.length(0.0, 1.0)).sum();
        let waves = length * wavenumber / TAU * self.options.nodes_per_wavelength;
        let too_large = |unknowns| RadiationError::TooLarge { unknowns, most: MOST_UNKNOWNS, wavenumber };
        // Checked before the mesh is built, and after.
        if waves > MOST_UNKNOWNS as f64 {
            return Err(too_large(waves as usize));
        }
        let panels = Panels::new(&self.meridian, wavenumber, &self.options);
        if panels.nodes.len() > MOST_UNKNOWNS {
            return Err(too_large(panels.nodes.len()));
        }
        Ok(MeridianMesh { panels })
    }

    /// The largest number of waves in one solve on a mesh.
    pub fn batch(&self, mesh: &MeridianMesh) -> usize {
        (BATCH_MEMORY / (mesh.panels.nodes.len().pow(2) * size_of::<Complex64>())).clamp(1, MOST_WAVES)
    }

    /// The fields of the surface motions of each wave, at most [`batch`](Self::batch) waves.
    ///
    /// # Errors
    /// [`RadiationError`].
    pub fn solve(
        &self,
        mesh: &MeridianMesh,
        waves: &[RingWave],
    ) -> Result<Vec<Vec<RingField>>, RadiationError> {
        let panels = &mesh.panels;
        // Collect the right-hand sides of all waves.
        let mut accelerations = Vec::new();
        let mut asked = Vec::new();
        for wave in waves {
            let first = accelerations.len();
            accelerations.extend(wave.accelerations.iter().cloned());
            asked.push(Wave {
                wavenumber: Complex64::new(wave.wavenumber, 0.0),
                orders: [wave.order],
                sources: [(first..accelerations.len()).collect()],
            });
        }
        // Quadrature around the axis, shared by all rows.
        let highest = waves.iter().map(|w| w.wavenumber).fold(0.0, f64::max);
        let around = waves.iter().map(|w| w.order).max().unwrap_or(0);
        let ladder = MidpointLadder::new(highest * panels.widest(), around);
        let context = RowContext::new(panels, &ladder, &asked, &accelerations);
        // Assembly, one row per collocation point.
        let rows: Vec<Row> = panels.nodes.par_iter().map(|node| context.row(Observer::node(node))).collect();
        // Surface pressures.
        let pressures = self.pressures(&context, panels, &rows, waves)?;
        waves
            .par_iter()
            .zip(pressures)
            .map(|(wave, pressures)| {
                let finite = pressures.iter().flatten().all(|p| p.is_finite());
                if !finite {
                    return Err(RadiationError::NotFinite { wavenumber: wave.wavenumber });
                }
                // Multipole projection of each motion.
                let order = self.order(wave)?;
                let projection = AxisProjection::new(panels, self.radius, wave.order, order);
                let k = Complex64::new(wave.wavenumber, 0.0);
                let fields = pressures.into_iter().zip(&wave.accelerations);
                Ok(fields
                    .map(|(pressure, a)| RingField {
                        coefficients: projection.coefficients(&pressure, a, k),
                        pressure,
                    })
                    .collect())
            })
            .collect()
    }

    /// Highest n of the multipoles of a wave.
    fn order(&self, wave: &RingWave) -> Result<usize, RadiationError> {
        let reach = (wave.wavenumber * self.radius).ceil() as usize;
        let order = reach.max(wave.order) + EXTRA_ORDERS;
        if order > MOST_ORDER {
            let (unknowns, most) = ((order + 1).pow(2), (MOST_ORDER + 1).pow(2));
            return Err(RadiationError::TooLarge { unknowns, most, wavenumber: wave.wavenumber });
        }
        Ok(order)
    }

    /// Pressures at the nodes.
    fn pressures(
        &self,
        context: &RowContext<1>,
        panels: &Panels,
        rows: &[Row],
        waves: &[RingWave],
    ) -> Result<Vec<Vec<Vec<Complex64>>>, RadiationError> {
        // Below the first interior resonance the square system is unique: direct solve.
        let resonant: Vec<usize> =
            (0..waves.len()).filter(|f| waves[*f].wavenumber >= self.resonance).collect();
        let mut pressures: Vec<Vec<Vec<Complex64>>> = waves
            .par_iter()
            .enumerate()
            .map(|(f, wave)| {
                if wave.wavenumber >= self.resonance {
                    return Vec::new();
                }
                solve_system::<1>(rows, f, 0, 0..wave.accelerations.len())
            })
            .collect();
        let mut left = resonant;
        let (mut used, mut spare): (Vec<Row>, Vec<Row>) = (Vec::new(), Vec::new());
        let mut drawn = 0;
        for attempt in 0..=ATTEMPTS {
            let Some(lowest) = left.iter().map(|f| waves[*f].wavenumber).reduce(f64::min) else { break };
            if attempt == ATTEMPTS {
                return Err(RadiationError::Resonance { wavenumber: lowest });
            }
            // The spare points of the last attempt are used now; the first attempt has none.
            let wanted = if attempt == 0 { [1, 2] } else { [2, 1] }.map(|k| k * (panels.nodes.len() / 8 + 8));
            used.append(&mut spare);
            // Assemble rows for new interior points: some for the equations, some held out.
            for (rows, count) in [(&mut used, wanted[0]), (&mut spare, wanted[1])] {
                let points = inner_points(&self.meridian, lowest, drawn, count);
                drawn += count;
                rows.par_extend(points.into_par_iter().map(|p| context.row(Observer::inside(p))));
            }
            // Least squares, accepted where the held-out points show no pressure.
            let solved: Vec<(usize, Option<Vec<Vec<Complex64>>>)> = left
                .par_iter()
                .map(|f| {
                    let found = solve_joined(rows, &used, *f);
                    let loudest = found.iter().flatten().map(|p| p.norm()).fold(0.0, f64::max);
                    let inside = |(i, p): (usize, &Vec<Complex64>)| inner_pressure(&spare, *f, i, p);
                    let loud = found.iter().enumerate().map(inside).any(|p| p > QUIET * loudest);
                    (*f, (!loud).then_some(found))
                })
                .collect();
            left.clear();
            for (f, found) in solved {
                match found {
                    Some(found) => pressures[f] = found,
                    None => left.push(f),
                }
            }
        }
        Ok(pressures)
    }
}

/// Least-squares pressures from the equations at the nodes and at interior points.
fn solve_joined(rows: &[Row], inside: &[Row], wave: usize) -> Vec<Vec<Complex64>> {
    let nodes = rows.len();
    let square = system_matrix::<1>(rows, wave, 0);
    let matrix = Mat::from_fn(nodes + inside.len(), nodes, |i, j| {
        if i < nodes {
            return square[(i, j)];
        }
        let row = &inside[i - nodes];
        -Complex64::new(row.real[wave * nodes + j], row.imaginary[wave * nodes + j])
    });
    let count = rows[0].rhs[wave].len();
    let rhs = Mat::from_fn(nodes + inside.len(), count, |i, j| {
        if i < nodes { rows[i].rhs[wave][j] } else { inside[i - nodes].rhs[wave][j] }
    });
    let solution = matrix.qr().solve_lstsq(&rhs);
    (0..count).map(|j| (0..nodes).map(|i| solution[(i, j)]).collect()).collect()
}

/// Largest pressure at interior points.
fn inner_pressure(inside: &[Row], wave: usize, source: usize, pressure: &[Complex64]) -> f64 {
    let start = wave * pressure.len();
    let residual = |row: &Row| {
        let sum: Complex64 = pressure
            .iter()
            .enumerate()
            .map(|(j, p)| Complex64::new(row.real[start + j], row.imaginary[start + j]) * p)
            .sum();
        (sum + row.rhs[wave][source]).norm()
    };
    inside.iter().map(residual).fold(0.0, f64::max)
}

/// ∫ dφ of cos²mφ.
pub fn turn_square(order: usize) -> f64 {
    if order == 0 { TAU } else { PI }
}
