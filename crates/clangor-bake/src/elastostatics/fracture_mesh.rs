//! A mesh of straight tetrahedra for the stress and the breaking of a body.
//!
//! The edges of its elements bound the smallest pieces that make sense, and its nodes decide what a solve costs; so its
//! size is chosen by nodes. Boxes are grids of cells, plates of them with two layers where nodes allow; ellipsoids are
//! divided icosahedra; bodies of revolution are turned triangles; anything else is filled with a grid that is cut at the
//! surface.
//!
//! Straight edges cut corners off round bodies. The mesh is scaled to the volume of the body and moved to its centre of
//! mass, so that mass is kept; its moments of inertia are then off by about the part of the volume that was missing.

use clangor::geometry::mass_properties::MassProperties;
use clangor::geometry::meridian::Meridian;
use glam::DVec3;

use crate::acceleration_noise::BakeGeometry;
use crate::tetrahedra::stuffing::{StuffingError, stuff};
use crate::tetrahedra::{TetMesh, TetMeshError, ball, block, turned};
use crate::turned_body::section_mesh::SectionMesh;
use crate::vibration::rounded_box;

/// Nodes, middles of edges included, where no edge is asked for.
const NODES: usize = 10_000;
/// Most nodes of a mesh: its factor takes about two gigabytes.
const MOST_NODES: usize = 80_000;
/// Edge over the thickness of a plate up to which two layers are worth their nodes.
const TWO_LAYERS: f64 = 3.0;
/// Largest part of the volume that straight edges may lose.
const MOST_LOST: f64 = 0.15;
/// Edges in the section over the thickness of walls.
const SECTION_EDGE: f64 = 2.0;
/// Steps around the axis at least.
const LEAST_SECTORS: f64 = 12.0;
/// How much finer each trial is.
const STEP: f64 = 0.93;

/// Why a body has no mesh to break.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FractureMeshError {
    /// The edge makes no sense.
    #[error("the edge of elements is {0} m, but must be positive")]
    Edge(f64),
    /// The body cannot be filled.
    #[error(transparent)]
    Filling(#[from] StuffingError),
    /// The elements do not fit.
    #[error("the tetrahedra make no mesh: {0}")]
    Tetrahedra(#[from] TetMeshError),
    /// The section crosses itself.
    #[error("the section of the body crosses itself")]
    Section,
    /// The body falls apart.
    #[error("the body falls into {0} parts that do not hang together")]
    LooseParts(usize),
    /// Too fine.
    #[error(
        "the mesh has {nodes} nodes, more than the {most} allowed: ask for longer edges or thicken the walls"
    )]
    TooLarge {
        /// Nodes.
        nodes: usize,
        /// Nodes allowed.
        most: usize,
    },
    /// The mesh does not follow the body.
    #[error("straight edges lose {:.0} % of the volume: ask for shorter ones", 100.0 * lost)]
    Coarse {
        /// Part of the volume.
        lost: f64,
    },
}

/// A mesh of a body with edges of about `edge` \[m\], or with about ten thousand nodes; in the frame of the geometry.
///
/// # Errors
/// [`FractureMeshError`].
pub fn fracture_mesh(geometry: &BakeGeometry, edge: Option<f64>) -> Result<TetMesh, FractureMeshError> {
    if let Some(edge) = edge.filter(|e| !(*e > 0.0 && e.is_finite())) {
        return Err(FractureMeshError::Edge(edge));
    }
    let filled =
        |surface: &clangor::geometry::tri_mesh::TriMesh| -> Result<(TetMesh, f64, DVec3), FractureMeshError> {
            let mass = MassProperties::of(surface).map_err(StuffingError::Input)?;
            // The grid has two points and fourteen edges per cube.
            let edge = edge.unwrap_or((16.0 * mass.volume / NODES as f64).cbrt());
            Ok((stuff(surface, edge)?.0, mass.volume, mass.centre_of_mass))
        };
    let (mesh, volume, centre) = match geometry {
        BakeGeometry::Ellipsoid { semi_axes } => {
            let longest = semi_axes.max_element();
            let divisions = edge.map_or(7, |edge| (longest / edge).ceil().max(2.0) as usize);
            let nodes = 27 * divisions.pow(3);
            if nodes > MOST_NODES {
                return Err(FractureMeshError::TooLarge { nodes, most: MOST_NODES });
            }
            let volume = 4.0 / 3.0 * std::f64::consts::PI * semi_axes.element_product();
            (ball::ellipsoid(*semi_axes, divisions)?, volume, DVec3::ZERO)
        }
        BakeGeometry::RoundedBox { edges, round: 0.0 } => {
            let cells = match edge {
                Some(edge) => cells(*edges, edge),
                None => finest(
                    edges.max_element(),
                    |edge| grid_nodes(cells(*edges, edge)),
                    |edge| cells(*edges, edge),
                ),
            };
            let nodes = grid_nodes(cells);
            if nodes > MOST_NODES {
                return Err(FractureMeshError::TooLarge { nodes, most: MOST_NODES });
            }
            (block::block(*edges, cells)?, edges.element_product(), DVec3::ZERO)
        }
        BakeGeometry::RoundedBox { edges, round } => filled(&rounded_box(*edges, *round)?)?,
        BakeGeometry::Revolution(meridian) => {
            let centre = DVec3::Y * meridian.centre_of_mass();
            (turned_mesh(meridian, edge)?, meridian.volume(), centre)
        }
        BakeGeometry::Mesh(surface) => filled(surface)?,
    };
    let nodes = mesh.nodes.len();
    if nodes > MOST_NODES {
        return Err(FractureMeshError::TooLarge { nodes, most: MOST_NODES });
    }
    match mesh.parts() {
        1 => fitted(mesh, volume, centre),
        parts => Err(FractureMeshError::LooseParts(parts)),
    }
}

/// The mesh with straight edges, scaled and moved to a volume \[m³\] and a centre of mass \[m\].
fn fitted(mesh: TetMesh, volume: f64, centre: DVec3) -> Result<TetMesh, FractureMeshError> {
    let mut points = mesh.nodes;
    points.truncate(mesh.corners);
    let elements: Vec<[u32; 4]> = mesh.elements.iter().map(|e| [e[0], e[1], e[2], e[3]]).collect();
    let (mut own_volume, mut moment) = (0.0, DVec3::ZERO);
    for element in &elements {
        let [a, b, c, d] = element.map(|n| points[n as usize]);
        let part = (b - a).cross(c - a).dot(d - a) / 6.0;
        own_volume += part;
        moment += 0.25 * part * (a + b + c + d);
    }
    let lost = 1.0 - own_volume / volume;
    if lost.is_nan() || lost.abs() > MOST_LOST {
        return Err(FractureMeshError::Coarse { lost });
    }
    let own_centre = moment / own_volume;
    let scale = (volume / own_volume).cbrt();
    points.iter_mut().for_each(|x| *x = centre + scale * (*x - own_centre));
    Ok(TetMesh::straight(points, &elements)?)
}

/// Cells of a box with edges of about `edge`.
fn cells(edges: DVec3, edge: f64) -> [usize; 3] {
    edges.to_array().map(|length| match (length / edge - 1e-9).ceil().max(1.0) as usize {
        1 if edge <= TWO_LAYERS * length => 2,
        count => count,
    })
}

fn grid_nodes(cells: [usize; 3]) -> usize {
    cells.iter().map(|n| 2 * n + 1).product()
}

/// What `make` gives for the shortest edge that keeps to the number of nodes.
fn finest<T>(longest: f64, nodes: impl Fn(f64) -> usize, make: impl Fn(f64) -> T) -> T {
    let mut edge = longest;
    while nodes(STEP * edge) <= NODES {
        edge *= STEP;
    }
    make(edge)
}

/// A section filled with triangles and turned.
fn turned_mesh(meridian: &Meridian, edge: Option<f64>) -> Result<TetMesh, FractureMeshError> {
    let radius = meridian.bounding_radius();
    let widest = meridian.pieces().iter().flat_map(|p| [p.point(0.0).x, p.point(0.5).x, p.point(1.0).x]);
    let around = std::f64::consts::TAU * widest.fold(0.0, f64::max);
    let of_edge = |edge: f64| -> Result<(SectionMesh, usize), FractureMeshError> {
        // Walls have one element across, not longer than twice their thickness.
        let section = SectionMesh::new(meridian, edge / SECTION_EDGE, SECTION_EDGE)
            .ok_or(FractureMeshError::Section)?;
        Ok((section, (around / edge).ceil().max(LEAST_SECTORS) as usize))
    };
    let nodes = |(section, sectors): &(SectionMesh, usize)| 2 * sectors * section.nodes.len();
    let mut made = of_edge(edge.unwrap_or(0.5 * radius))?;
    if edge.is_none() {
        let mut shorter = 0.5 * radius;
        loop {
            shorter *= STEP;
            let finer = of_edge(shorter)?;
            if nodes(&finer) > NODES {
                break;
            }
            made = finer;
        }
    }
    let nodes = nodes(&made);
    if nodes > MOST_NODES {
        return Err(FractureMeshError::TooLarge { nodes, most: MOST_NODES });
    }
    let (section, sectors) = made;
    let corners =
        section.elements.iter().flat_map(|t| [t[0], t[1], t[2]]).max().map_or(0, |n| n as usize + 1);
    let triangles: Vec<[u32; 3]> = section.elements.iter().map(|t| [t[0], t[1], t[2]]).collect();
    Ok(turned::turned(&section.nodes[..corners], &triangles, sectors)?)
}
