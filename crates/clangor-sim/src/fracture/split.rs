//! Cuts a body into closed pieces that fit together.
//!
//! Elements whose corners belong to several regions are divided by the walls of `tetrahedron_parts`: through
//! the middles of their edges, or along the planes of scores. Elements that become unnecessarily small or
//! flat are then merged with their neighbours (`coarsen`), which does not change the outer surface.
//!
//! Why pieces are closed and manifold: in the barycentric division of a tetrahedral mesh, the neighbourhood
//! of the part that the corners of one region span is a manifold with boundary if the mesh is one (Rourke and
//! Sanderson, *Introduction to piecewise-linear topology*, ch. 3), and merging preserves this by its own
//! conditions. Each piece is checked nevertheless, because mass, contact and sound rely on it.
//!
//! Worst shapes of elements, with 12 (3V)^(2/3) / Σ edge² = 1 for the regular one, where those of the whole
//! body have 0.6 or better: above 0.2 after one fracture of blocks, plates, balls and rings, above 0.02 after
//! five, each of all pieces. Scores give 0.1 or better in blocks and plates, 0.02 in balls, on whose surface
//! no point can move. A plate of 73 000 nodes breaks into 70 pieces in 1.3 s.

use clangor_bake::mesh::tetrahedra::TetMesh;
use clangor_core::glam::DVec3;
pub use clangor_core::scene::breaking::Score;

use super::cells::{Cells, SharedFace};
use super::coarsen::{Walls, coarsen};
use super::error::FractureError;
use super::piece::{Piece, check_manifold};

/// Least distance of a cut from the ends of an edge, as a share of the edge: the smallest first, larger ones
/// if elements stay poor.
const MARGINS: [f64; 4] = [1e-7, 1e-3, 0.02, 0.1];
/// Worst shape of an element that is accepted without a further try.
const FAIR: f64 = 0.1;
/// Ends of edges this near to a plane, as a share of the body's size, are on it.
const ON_PLANE: f64 = 1e-9;

/// One triangle of a crack, between two pieces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CrackFace {
    /// The pieces a and b; a has the smaller number.
    pub pieces: [u32; 2],
    /// Its index in `Piece::faces` of each piece.
    pub faces: [u32; 2],
    /// The element of the unbroken body on either side; usually the same.
    pub elements: [u32; 2],
    /// Corners \[m\], counter-clockwise seen from outside a, that is from b.
    pub corners: [DVec3; 3],
}

impl CrackFace {
    /// Area \[m²\] along the normal that points out of a, into b.
    pub fn area_vector(&self) -> DVec3 {
        let [a, b, c] = self.corners;
        0.5 * (b - a).cross(c - a)
    }

    /// Centre \[m\].
    pub fn centroid(&self) -> DVec3 {
        let [a, b, c] = self.corners;
        (a + b + c) / 3.0
    }
}

/// The pieces of a body, and the crack between them.
#[derive(Clone, Debug, PartialEq)]
pub struct Split {
    /// The pieces, in the frame of the body.
    pub pieces: Vec<Piece>,
    /// The triangles between them.
    pub crack_faces: Vec<CrackFace>,
}

impl Split {
    /// Area A_F of the crack \[m²\], counted once.
    pub fn crack_area(&self) -> f64 {
        self.crack_faces.iter().map(|f| f.area_vector().length()).sum()
    }
}

/// Cuts between corners of different regions; `None` if all belong to one region. Disconnected parts of a
/// region become pieces of their own, except parts enclosed by another piece, which are merged with it.
///
/// # Errors
/// [`FractureError::Counts`]; and [`FractureError::Mesh`], [`FractureError::Surface`] or
/// [`FractureError::Pinched`] for a body without valid pieces.
pub fn split_by_regions(piece: &Piece, region: &[u32]) -> Result<Option<Split>, FractureError> {
    if region.len() != piece.mesh.corners {
        return Err(FractureError::Counts { what: "regions", got: region.len(), wanted: piece.mesh.corners });
    }
    let whole = Cells::of(piece);
    let middle = |a: u32, b: u32| 0.5 * (whole.points[a as usize] + whole.points[b as usize]);
    let mut divided = whole.divide(region, middle);
    let parts = divided.separate();
    if divided.absorb_enclosed(parts) < 2 {
        return Ok(None);
    }
    pieces_of(piece, coarsen(divided, &piece.element_size, Walls::Free)).map(Some)
}

/// Cuts along planes; `None` if none of them divides the body.
///
/// # Errors
/// [`FractureError::Setting`] for a plane that is not finite or has no normal; the rest as for
/// [`split_by_regions`].
pub fn split_by_scores(piece: &Piece, scores: &[Score]) -> Result<Option<Split>, FractureError> {
    for score in scores {
        let length = score.normal.length();
        if !(length > 0.0 && length.is_finite() && score.point.is_finite()) {
            return Err(FractureError::Setting { setting: "length of a score's normal", value: length });
        }
    }
    let mut best: Option<(f64, Cells)> = None;
    for margin in MARGINS {
        let mut cells = cut_along(piece, scores, margin);
        if cells.separate() < 2 {
            return Ok(None);
        }
        let cells = coarsen(cells, &piece.element_size, Walls::Flat);
        let worst = cells.worst_shape();
        if best.as_ref().is_none_or(|(least, _)| worst > *least) {
            best = Some((worst, cells));
        }
        if worst >= FAIR {
            break;
        }
    }
    best.map(|(_, cells)| pieces_of(piece, cells)).transpose()
}

/// Cuts along one plane after the other, no nearer to the ends of an edge than `margin` times its length.
fn cut_along(piece: &Piece, scores: &[Score], margin: f64) -> Cells {
    let mut cells = Cells::of(piece);
    let (low, high) = piece.surface().bounds();
    let on_plane = ON_PLANE * (high - low).length();
    for score in scores {
        let normal = score.normal.normalize();
        let height: Vec<f64> = cells.points.iter().map(|p| (*p - score.point).dot(normal)).collect();
        let side: Vec<u32> = height.iter().map(|h| u32::from(*h > on_plane)).collect();
        let points = &cells.points;
        let cut = |a: u32, b: u32| {
            let (from, to) = (height[a as usize], height[b as usize]);
            let along = (from / (from - to)).clamp(margin, 1.0 - margin);
            points[a as usize].lerp(points[b as usize], along)
        };
        cells = cells.divide(&side, cut);
    }
    cells
}

/// The pieces and crack faces of cells of several regions.
fn pieces_of(parent: &Piece, cells: Cells) -> Result<Split, FractureError> {
    let count = cells.cells.iter().map(|c| c.region as usize + 1).max().unwrap_or(0);
    let mut outer: Vec<([u32; 3], bool)> =
        cells.outer.iter().map(|f| (ascending(f.corners), f.inside)).collect();
    outer.sort_unstable();
    let mut pieces = Vec::with_capacity(count);
    // For each piece the ascending indices of its corners among all points.
    let mut origins = Vec::with_capacity(count);
    for members in by_region(&cells, count) {
        let mut own: Vec<u32> = members.iter().flat_map(|k| cells.cells[*k as usize].corners).collect();
        own.sort_unstable();
        own.dedup();
        let number = |n: u32| own.partition_point(|o| *o < n) as u32;
        let points = own.iter().map(|n| cells.points[*n as usize]).collect();
        let tetrahedra: Vec<[u32; 4]> =
            members.iter().map(|k| cells.cells[*k as usize].corners.map(number)).collect();
        let mesh = TetMesh::straight(points, &tetrahedra)?;
        let faces: Vec<[u32; 3]> = mesh.surface().iter().map(|f| [f[0], f[1], f[2]]).collect();
        let inside = faces
            .iter()
            .map(|f| {
                let key = ascending(f.map(|n| own[n as usize]));
                outer.binary_search_by(|o| o.0.cmp(&key)).map_or(true, |k| outer[k].1)
            })
            .collect();
        let size = |k: &u32| parent.element_size[cells.cells[*k as usize].element as usize];
        let element_size = members.iter().map(size).collect();
        let piece = Piece { mesh, faces, inside, element_size };
        check_manifold(&piece.surface())?;
        pieces.push(piece);
        origins.push(own);
    }
    let crack_faces = cells
        .shared_faces()
        .iter()
        .filter(|f| cells.cells[f.cells[0] as usize].region != cells.cells[f.cells[1] as usize].region)
        .filter_map(|face| crack_face(&cells, face, &pieces, &origins))
        .collect();
    Ok(Split { pieces, crack_faces })
}

/// The cells of each region.
fn by_region(cells: &Cells, count: usize) -> Vec<Vec<u32>> {
    let mut members = vec![Vec::new(); count];
    for (k, cell) in cells.cells.iter().enumerate() {
        members[cell.region as usize].push(k as u32);
    }
    members
}

fn crack_face(
    cells: &Cells,
    shared: &SharedFace,
    pieces: &[Piece],
    origins: &[Vec<u32>],
) -> Option<CrackFace> {
    let mut sides = shared.cells.map(|k| cells.cells[k as usize]);
    sides.sort_unstable_by_key(|c| c.region);
    let numbers = sides.map(|c| c.region);
    let mut faces = [0; 2];
    for (side, region) in numbers.iter().enumerate() {
        let own = &origins[*region as usize];
        let key = shared.corners.map(|n| own.partition_point(|o| *o < n) as u32);
        // The faces of a mesh are sorted by their corners.
        let found = pieces[*region as usize].faces.binary_search_by(|f| ascending(*f).cmp(&key));
        faces[side] = found.ok()? as u32;
    }
    let piece = &pieces[numbers[0] as usize];
    let corners = piece.faces[faces[0] as usize].map(|n| piece.mesh.nodes[n as usize]);
    Some(CrackFace { pieces: numbers, faces, elements: sides.map(|c| c.element), corners })
}

fn ascending(mut corners: [u32; 3]) -> [u32; 3] {
    corners.sort_unstable();
    corners
}
