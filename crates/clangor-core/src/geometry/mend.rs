//! Small faults of mesh files, mended where only one solid can be meant.
//!
//! ```text
//! mesh ─► weld ─► a good solid: as it is
//!           └──► flat ─► seams ─► double, fins ─► walls ─► winding
//!                   ─► holes ─► shells ─► union ─► folds ─► check
//! ```
//!
//! | fault | mended | otherwise |
//! |---|---|---|
//! | triangles without area, faces twice, fins | removed | |
//! | walls inside of a body, between edges of three triangles | removed | [`MeshError::NonManifold`] |
//! | cracks | vertices on open edges merge within [`SEAM`] of the diagonal | [`MeshError::Open`] |
//! | triangles that face the other way, bodies inside out | turned | [`MeshError::OneSided`] |
//! | holes | closed, up to a border of [`HOLE`] or [`TRIANGLE_HOLE`] diagonals | [`MeshError::Hole`] |
//! | several shells | those below [`DUST`] of the largest are left out | |
//! | shells that touch or cross | united | [`MeshError::CrossingShells`] |
//! | shells that are apart, or one in another | | [`MeshError::Shells`], [`MeshError::Nested`] |
//! | folds | smoothed, by up to [`FOLD`] diagonals | [`MeshError::SelfIntersection`] |
//!
//! What is a solid already comes back with no bit changed, but for coincident vertices that merge. Everything
//! else is a [`Mend`]. It gives no thickness to sheets: that would be a guess.

mod edges;
mod faces;
mod folds;
mod holes;
mod inner_walls;
mod seams;
mod shells;
mod slivers;
mod touching;
mod union;
mod unite;
mod winding;

use std::fmt;

use glam::DVec3;

use super::mesh_error::{MeshError, check_numbers};
use super::solid::{SolidReport, check_solid, check_uncrossed};
use super::topology::Topology;
use super::tri_mesh::TriMesh;
use unite::{NotUnited, unite_shells};

/// Vertices closer than this fraction of the diagonal are one: files repeat them for each triangle.
pub const SAME: f64 = 1e-9;
/// Vertices on open edges merge within this fraction of the diagonal: files keep four digits or more.
pub const SEAM: f64 = 1e-4;
/// Longest border of a hole that is closed, over the diagonal: a round one has 3 % of the size.
pub const HOLE: f64 = 0.1;
/// The same where a single triangle is missing, which leaves no choice.
pub const TRIANGLE_HOLE: f64 = 0.3;
/// Shells below this fraction of the volume of the largest are dust.
pub const DUST: f64 = 1e-3;
/// Farthest that vertices move to undo a fold, over the diagonal.
pub const FOLD: f64 = 1e-2;

/// A mesh that bounds a solid, and what was changed for that.
#[derive(Clone, Debug, PartialEq)]
pub struct Mended {
    /// The mesh.
    pub mesh: TriMesh,
    /// Its mass properties and area.
    pub report: SolidReport,
    /// Mends in their order; none if the mesh was good.
    pub mends: Vec<Mend>,
}

/// A fault of a mesh that was mended.
#[derive(Clone, Debug, PartialEq)]
pub struct Mend {
    /// The fault.
    pub fault: Fault,
    /// Number of triangles, holes, vertices or shells.
    pub count: usize,
    /// Place of the first \[m\].
    pub position: DVec3,
}

/// What was mended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault {
    /// Triangles without area.
    NoArea,
    /// Triangles that lie on others.
    Double,
    /// Triangles of sheets that stick to the surface by one side.
    Fin,
    /// Triangles of walls inside of a body.
    InnerWall,
    /// Vertices on open edges that were merged with others, or inserted into edges on which they lie.
    Crack {
        /// Largest distance over the diagonal.
        gap: f64,
    },
    /// Triangles that faced the other way than their neighbours.
    Flipped,
    /// Triangles of shells that were inside out.
    InsideOut,
    /// Holes.
    Hole {
        /// Longest border over the diagonal.
        border: f64,
    },
    /// Shells of next to no volume.
    Dust {
        /// Their volume over that of the largest.
        share: f64,
    },
    /// Shells that touched or crossed.
    United,
    /// Vertices of triangles that crossed.
    Fold {
        /// Farthest that a vertex was moved, over the diagonal.
        moved: f64,
    },
}

impl fmt::Display for Mend {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Mend { fault, count, position } = self;
        let some = |one: &str, many: &str| format!("{count} {}", if *count == 1 { one } else { many });
        let triangles = some("triangle", "triangles");
        let percent = |share: &f64| format!("{} % of the diagonal", two_digits(100.0 * share));
        match fault {
            Fault::NoArea => write!(f, "left out {triangles} without area"),
            Fault::Double => write!(f, "left out {triangles} that lay on others"),
            Fault::Fin => write!(f, "left out {triangles} of sheets that bound nothing"),
            Fault::InnerWall => write!(f, "left out {triangles} of walls inside of the body"),
            Fault::Crack { gap } => {
                let vertices = some("vertex", "vertices");
                write!(f, "closed cracks of up to {} at {vertices}", percent(gap))
            }
            Fault::Flipped => write!(f, "turned {triangles} that faced the other way"),
            Fault::InsideOut => write!(f, "turned a surface of {triangles} that was inside out"),
            Fault::Hole { border } => {
                let holes = some("hole", "holes");
                write!(f, "closed {holes} with borders of up to {}", percent(border))
            }
            Fault::Dust { share } => {
                let shells = some("separate shell", "separate shells");
                write!(f, "left out {shells} with {} % of the volume", two_digits(100.0 * share))
            }
            Fault::United => {
                write!(f, "united {count} shells that touch or cross, as one piece of one material")
            }
            Fault::Fold { moved } => {
                let vertices = some("vertex", "vertices");
                write!(f, "smoothed crossing triangles: {vertices} moved by up to {}", percent(moved))
            }
        }?;
        write!(f, ", near {position:.5}")
    }
}

/// A number with two digits.
fn two_digits(x: f64) -> String {
    if x == 0.0 {
        return "0".into();
    }
    let decimals = (1.0 - x.abs().log10().floor()).clamp(0.0, 12.0);
    format!("{x:.*}", decimals as usize)
}

/// A solid of a mesh in any state. Lengths are in the unit of the mesh, called metres.
///
/// # Errors
/// A [`MeshError`] of what cannot be mended without guessing.
pub fn mend(mesh: &TriMesh) -> Result<Mended, MeshError> {
    check_numbers(mesh)?;
    let diagonal = mesh.diagonal();
    let welded = mesh.weld(SAME * diagonal);
    match check_solid(&welded) {
        Ok(report) if report.components == 1 => {
            return Ok(Mended { mesh: welded, report, mends: Vec::new() });
        }
        _ => {}
    }
    let mut work = Repair { mesh: welded, mends: Vec::new(), diagonal };
    faces::remove_flat(&mut work);
    seams::close_cracks(&mut work);
    inner_walls::remove_faces_between_parts(&mut work);
    let mut touching = touching::separate(&mut work);
    faces::remove_double(&mut work)?;
    faces::remove_fins(&mut work);
    inner_walls::remove_inner_walls(&mut work);
    winding::turn_flipped(&mut work)?;
    holes::close_holes(&mut work)?;
    touching = touching.or_else(|| touching::separate(&mut work));
    Topology::try_new(&work.mesh)?;
    make_one_solid(&mut work, touching)?;
    folds::smooth_folds(&mut work)?;
    let mesh = work.mesh.weld(0.0);
    let report = check_uncrossed(&mesh)?;
    // A net volume far below that of a skin as thick as the cracks is rounding.
    if report.mass.volume < SEAM * SEAM * report.area * diagonal {
        return Err(MeshError::NoVolume { volume: report.mass.volume });
    }
    Ok(Mended { mesh, report, mends: work.mends })
}

/// Leaves one solid: drops what is too small, and unites what touches or crosses. `shared` is the error of
/// parts that shared edges.
///
/// # Errors
/// [`MeshError`]: that of parts that shared edges, where these cannot be united.
fn make_one_solid(work: &mut Repair, shared: Option<MeshError>) -> Result<(), MeshError> {
    let first = match shells::keep_one_solid(work) {
        Ok(()) => return Ok(()),
        Err(error @ (MeshError::CrossingShells { .. } | MeshError::Shells { .. })) => shared.unwrap_or(error),
        Err(error) => return Err(error),
    };
    unite_shells(work).map_err(|why| match why {
        NotUnited::Left(error) => error,
        NotUnited::Apart | NotUnited::Degenerate => first,
    })
}

/// A mesh under repair.
struct Repair {
    mesh: TriMesh,
    mends: Vec<Mend>,
    /// Of the mesh as it came \[m\].
    diagonal: f64,
}

impl Repair {
    fn note(&mut self, fault: Fault, count: usize, position: DVec3) {
        if count > 0 {
            self.mends.push(Mend { fault, count, position });
        }
    }

    /// Drops the marked triangles and notes why.
    fn remove(&mut self, marked: &[bool], fault: Fault) {
        let Some(first) = marked.iter().position(|m| *m) else { return };
        let position = self.mesh.centroid(first);
        self.note(fault, marked.iter().filter(|m| **m).count(), position);
        let mut marks = marked.iter();
        self.mesh.triangles.retain(|_| !marks.next().copied().unwrap_or(false));
    }
}
