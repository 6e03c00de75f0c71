//! Choice of the method that radiates the modes of a closed surface: boundary elements, or finite differences
//! in time.
//!
//! Boundary elements to 20 kHz, CPU-s on one core:
//!
//! ```text
//! body                    kR   unknowns   planes   largest system   mode of one parity   of all parities
//! key                     12        922        1              531                  0.1               0.1
//! mug with a handle       27       8162        1             4195                  5.7               9.6
//! tile 250 × 250 × 8 mm   65     18 110        3             2305                  6.4                25
//! ```
//!
//! of which assembly takes 5e-8 N²/2^planes and the factorisation 4.3e-11 n³ for each system of n unknowns.
//! Finite differences perform about 8e8 cell updates per second. By their count, the mug in cells of 1.7 mm
//! takes 1e10 for a single mode, as long as boundary elements, and less for modes that share a run. But their
//! error is 0.5 % for a rounded die and 2 to 5 % for walls of few cells with sharp edges. Boundary elements
//! are therefore preferred while a system fits in memory; a body of thousands of unknowns without mirror
//! planes is simulated in time.

use std::ops::ControlFlow;

use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::math::random::SplitMix;
use clangor_core::sound_model::modal::model::ModalTransfer;
use clangor_core::sound_model::modal::surface::ModalSurface;

use super::{ModalMotion, ModalSolver};
use crate::acceleration::BakeError;
use crate::bem::triangles::MOST_UNKNOWNS;
use crate::cost::operations::{self, CHEAP, PER_SECOND};
use crate::mesh::remesh::resolution::resolution;
use crate::modal_radiation::bem_transfer::{BemModalSolver, centred_mirrors};
use crate::modal_radiation::fdtd_transfer::{FdtdModalSolver, UPDATES, expected_updates};
use crate::radiation::RadiationError;

/// CPU-s per square of the unknowns, and per cube of those of a system.
const ASSEMBLY: f64 = 5e-8;
const FACTORISATION: f64 = 4.3e-11;
/// Cost of an average mode, for which half of the finest mesh may suffice, relative to the highest.
const AVERAGE: f64 = 0.6;

/// Whether modes are simulated in time that take boundary elements so many CPU-s, infinitely many where they
/// do not fit, or so many cell updates.
fn in_time(elements: f64, updates: f64) -> bool {
    operations::much_longer(elements * PER_SECOND, updates / UPDATES * PER_SECOND)
}

/// Expected k of modes up to `highest` [1/m].
fn even_wavenumbers(modes: usize, highest: f64) -> Vec<f64> {
    (0..modes).map(|i| (i as f64 + 0.5) / modes as f64 * highest).collect()
}

/// Expected CPU-s of the cheaper adequate method for a number of modes up to `highest` [1/m], if boundary
/// elements take so many, of a body of this bounding radius and wall \[m\]; `None` if neither fits.
pub(crate) fn expected_seconds(
    elements: Option<f64>,
    (modes, highest): (usize, f64),
    sizes: (f64, f64),
    has_cavities: bool,
) -> Option<f64> {
    let elements = elements.unwrap_or(f64::INFINITY);
    let chosen = elements >= CHEAP / PER_SECOND
        && expected_updates(&even_wavenumbers(modes, highest), sizes, has_cavities)
            .is_some_and(|updates| in_time(elements, updates));
    match chosen {
        true => expected_updates(&random_wavenumbers(modes, highest), sizes, has_cavities)
            .map(|updates| updates / UPDATES),
        false => Some(elements).filter(|seconds| seconds.is_finite()),
    }
}

/// k of modes up to `highest` [1/m] as they lie in a solid: more at high frequencies, and some so close
/// together that they share no run.
fn random_wavenumbers(modes: usize, highest: f64) -> Vec<f64> {
    let mut random = SplitMix::new(1);
    (0..modes).map(|_| highest * random.uniform(0.0, 1.0).cbrt()).collect()
}

/// The modes of a closed surface by the cheaper adequate method.
#[derive(Clone, Debug)]
pub enum SurfaceModes {
    /// By boundary elements.
    Triangles(BemModalSolver),
    /// By finite differences in time.
    Fdtd(Box<FdtdModalSolver>),
}

impl SurfaceModes {
    /// Prepares the surface of a body whose centre of mass is at the origin, for a number of modes up to
    /// `highest` [1/m] and a level error of `accuracy`.
    ///
    /// # Errors
    /// [`BakeError`].
    pub fn try_new(surface: &TriMesh, highest: f64, modes: usize, accuracy: f64) -> Result<Self, BakeError> {
        let mass = MassProperties::of(surface)?;
        let fineness = resolution(surface, highest, accuracy)?;
        let within = accuracy * fineness.wall;
        let within = [within, within.min(2.0 * accuracy / highest)];
        let planes = centred_mirrors(surface, &mass, within, highest).len();
        let parts = f64::from(1_u32 << planes);
        let all = fineness.unknowns as f64;
        let system = all / parts;
        let fits = system <= MOST_UNKNOWNS as f64;
        let elements = match fits {
            true => AVERAGE * modes as f64 * (ASSEMBLY * all * system + FACTORISATION * system.powi(3)),
            false => f64::INFINITY,
        };
        if elements >= CHEAP / PER_SECOND {
            match FdtdModalSolver::try_new(surface, highest, fineness.wall) {
                Ok(fdtd) => {
                    if in_time(elements, fdtd.updates(&even_wavenumbers(modes, highest))) {
                        return Ok(SurfaceModes::Fdtd(Box::new(fdtd)));
                    }
                }
                Err(error) if !fits => return Err(error.into()),
                Err(_) => {}
            }
        }
        Ok(SurfaceModes::Triangles(BemModalSolver::try_new(surface, highest, accuracy)?))
    }

    /// A draft for any number of modes: boundary elements on few triangles.
    ///
    /// # Errors
    /// [`BakeError`].
    pub fn draft(surface: &TriMesh) -> Result<Self, BakeError> {
        Ok(SurfaceModes::Triangles(BemModalSolver::draft(surface)?))
    }

    /// Name of the method.
    pub fn method(&self) -> &'static str {
        match self {
            SurfaceModes::Triangles(_) => "boundary elements on triangles",
            SurfaceModes::Fdtd(_) => "finite differences in time",
        }
    }

    /// Unknowns or cells.
    pub fn size(&self) -> usize {
        match self {
            SurfaceModes::Triangles(triangles) => triangles.unknowns(),
            SurfaceModes::Fdtd(fdtd) => fdtd.cells(),
        }
    }
}

impl ModalSolver for SurfaceModes {
    fn transfers(
        &self,
        surface: &ModalSurface,
        motions: &[ModalMotion<'_>],
        progress: &mut dyn FnMut(usize) -> ControlFlow<()>,
    ) -> Result<Vec<ModalTransfer>, RadiationError> {
        match self {
            SurfaceModes::Triangles(triangles) => triangles.transfers(surface, motions, progress),
            SurfaceModes::Fdtd(fdtd) => fdtd.transfers(surface, motions, progress),
        }
    }

    fn seconds(&self, wavenumbers: &[f64]) -> f64 {
        match self {
            SurfaceModes::Triangles(triangles) => triangles.seconds(wavenumbers),
            SurfaceModes::Fdtd(fdtd) => fdtd.seconds(wavenumbers),
        }
    }
}
