//! Straight tetrahedral meshes for the stress and fracture of bodies.
//!
//! The element edges limit the smallest pieces, and the nodes determine the cost of a solve, so the size is
//! chosen by the number of nodes. Boxes, also rounded, are grids of cells, thin ones with two layers where
//! nodes allow. Ellipsoids are divided icosahedra. Plates, bowls and coins are discs of cells. Other
//! axisymmetric bodies are rotated sections of triangles. All other bodies use isosurface stuffing.
//!
//! Straight edges lose volume on convex bodies. The mesh is scaled to the volume of the body and moved to its
//! centre of mass, so that mass is exact. The relative error of its moments of inertia is about that of the
//! lost volume.

use std::f64::consts::TAU;

use clangor_core::geometry::meridian::Meridian;
use glam::{DQuat, DVec3};

use crate::geometry_class::bake_geometry::BakeGeometry;
use crate::geometry_class::solver_choice::FractureChoice;
use crate::mesh::tetrahedra::dish::Dish;
use crate::mesh::tetrahedra::isosurface_stuffing::{StuffingError, stuff};
use crate::mesh::tetrahedra::{TetMesh, TetMeshError, axisymmetric, ball, block};
use crate::modal_analysis::axisymmetric::section_mesh::SectionMesh;

/// Default number of nodes, midpoints of edges included.
const NODES: usize = 10_000;
/// Elements from the centre of an ellipsoid to its surface for about that number.
const BALL_DIVISIONS: f64 = 7.0;
/// Most nodes of a mesh: its factor takes about two gigabytes.
const MOST_NODES: usize = 80_000;
/// Ratio of edge to plate thickness up to which two layers justify their nodes.
const TWO_LAYERS: f64 = 3.0;
/// Largest fraction of the volume that straight edges may lose.
const MOST_LOST: f64 = 0.15;
/// Edges of the section, relative to the thickness of walls.
const SECTION_EDGE: f64 = 2.0;
/// Least number of sectors around the axis.
const LEAST_SECTORS: f64 = 12.0;
/// Ratio of edges between trials.
const STEP: f64 = 0.93;
const MOST_STEPS: i32 = 200;

/// Reasons why a body has no fracture mesh.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FractureMeshError {
    /// Invalid edge length.
    #[error("the edge of elements is {0} m, but must be positive")]
    Edge(f64),
    /// Isosurface stuffing failed.
    #[error(transparent)]
    Filling(#[from] StuffingError),
    /// The elements do not form a valid mesh.
    #[error("the tetrahedra make no mesh: {0}")]
    Tetrahedra(#[from] TetMeshError),
    /// The section intersects itself.
    #[error("the section of the body crosses itself")]
    Section,
    /// The mesh is not connected.
    #[error("the body falls into {0} parts that do not hang together")]
    LooseParts(usize),
    /// Too many nodes.
    #[error(
        "the mesh has {nodes} nodes, more than the {most} allowed: ask for longer edges or thicken the walls"
    )]
    TooLarge {
        /// Nodes.
        nodes: usize,
        /// Nodes allowed.
        most: usize,
    },
    /// The mesh does not match the volume of the body.
    #[error("straight edges lose {:.0} % of the volume: ask for shorter ones", 100.0 * lost)]
    Coarse {
        /// Fraction of the volume.
        lost: f64,
    },
}

/// A mesh of a body with edges of about `edge` \[m\], or with about ten thousand nodes; in the frame of the
/// geometry.
///
/// # Errors
/// [`FractureMeshError`].
pub fn fracture_mesh(geometry: &BakeGeometry, edge: Option<f64>) -> Result<TetMesh, FractureMeshError> {
    if let Some(edge) = edge.filter(|e| !(*e > 0.0 && e.is_finite())) {
        return Err(FractureMeshError::Edge(edge));
    }
    // Mesh by the class of the geometry.
    let mass = geometry.mass_properties().map_err(StuffingError::Input)?;
    let mesh = match geometry.fracture_choice() {
        FractureChoice::Ball(semi_axes) => {
            let divisions =
                edge.map_or(BALL_DIVISIONS, |edge| (semi_axes.max_element() / edge).ceil().max(2.0));
            check_nodes((27.0 * divisions.powi(3)) as usize)?;
            ball::ellipsoid(semi_axes, divisions as usize)?
        }
        FractureChoice::Cells(edges, round) => {
            let cells = finest(edges.max_element(), edge, |edge| cells(edges, edge))?;
            rounded_box(edges, round, cells)?
        }
        FractureChoice::Section(axisymmetry) => {
            let mut mesh = axisymmetric_mesh(&axisymmetry.meridian, edge)?;
            let rotation = axisymmetry.rotation();
            if rotation != DQuat::IDENTITY {
                mesh.nodes.iter_mut().for_each(|x| *x = rotation * *x);
            }
            mesh
        }
        FractureChoice::Tetrahedra(surface) => {
            // The grid has two points and fourteen edges per cube.
            let edge = edge.unwrap_or((16.0 * mass.volume / NODES as f64).cbrt());
            stuff(surface, edge)?.0
        }
    };
    // One connected body; scale it to the exact volume.
    check_nodes(mesh.nodes.len())?;
    match mesh.parts() {
        1 => fitted(mesh, mass.volume, mass.centre_of_mass),
        parts => Err(FractureMeshError::LooseParts(parts)),
    }
}

fn check_nodes(nodes: usize) -> Result<(), FractureMeshError> {
    if nodes > MOST_NODES { Err(FractureMeshError::TooLarge { nodes, most: MOST_NODES }) } else { Ok(()) }
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
    cells.iter().fold(1, |nodes: usize, n| nodes.saturating_mul(n.saturating_mul(2).saturating_add(1)))
}

/// The cells for an edge or, without one, for the shortest edge within the node limit.
fn finest(
    longest: f64,
    edge: Option<f64>,
    cells: impl Fn(f64) -> [usize; 3],
) -> Result<[usize; 3], FractureMeshError> {
    let edge = edge.unwrap_or_else(|| {
        let steps = (1..MOST_STEPS).map(|k| longest * STEP.powi(k));
        steps.take_while(|edge| grid_nodes(cells(*edge)) <= NODES).last().unwrap_or(longest)
    });
    let cells = cells(edge);
    check_nodes(grid_nodes(cells))?;
    Ok(cells)
}

/// A grid in a rounded box: concentric shells of boxes with proportional rounding.
fn rounded_box(edges: DVec3, round: f64, cells: [usize; 3]) -> Result<TetMesh, TetMeshError> {
    let mesh = block::block(edges, cells)?;
    if round == 0.0 {
        return Ok(mesh);
    }
    let half = 0.5 * edges;
    let rounded = |x: &DVec3| {
        let shell = (*x / half).abs().max_element();
        if shell == 0.0 {
            return DVec3::ZERO;
        }
        let on_box = *x / shell;
        let kernel = (half - round).max(DVec3::ZERO);
        let kernel = on_box.clamp(-kernel, kernel);
        shell * (kernel + (on_box - kernel).clamp_length_max(round))
    };
    let points = mesh.nodes[..mesh.corners].iter().map(rounded).collect();
    let elements: Vec<[u32; 4]> = mesh.elements.iter().map(|e| [e[0], e[1], e[2], e[3]]).collect();
    TetMesh::straight(points, &elements)
}

/// A grid on a thin wall, or a triangulated section rotated about the axis.
fn axisymmetric_mesh(meridian: &Meridian, edge: Option<f64>) -> Result<TetMesh, FractureMeshError> {
    if let Some(dish) = Dish::of(meridian) {
        let sizes = DVec3::new(dish.width(), dish.width(), dish.thickness());
        // An even number, so that a node lies on the axis.
        let even = |edge: f64| {
            let [across, _, layers] = cells(sizes, edge);
            [across + across % 2, across + across % 2, layers]
        };
        let [across, _, layers] = finest(sizes.x, edge, even)?;
        return Ok(dish.mesh(across, layers)?);
    }
    // Thick body: mesh of the section, rotated.
    let radius = meridian.bounding_radius();
    let widest = meridian.pieces().iter().flat_map(|p| [p.point(0.0).x, p.point(0.5).x, p.point(1.0).x]);
    let around = TAU * widest.fold(0.0, f64::max);
    let of_edge = |edge: f64| -> Result<(SectionMesh, usize), FractureMeshError> {
        // Walls have one element through the thickness, at most twice as long as that.
        let section = SectionMesh::new(meridian, edge / SECTION_EDGE, SECTION_EDGE)
            .ok_or(FractureMeshError::Section)?;
        Ok((section, (around / edge).ceil().max(LEAST_SECTORS) as usize))
    };
    let nodes = |(section, sectors): &(SectionMesh, usize)| 2 * sectors * section.nodes.len();
    let length: f64 = meridian.pieces().iter().map(|p| p.length(0.0, 1.0)).sum();
    // Given edge, or the finest within the node limit.
    let made = match edge {
        Some(edge) => {
            check_nodes((around / edge * length / edge) as usize)?;
            of_edge(edge)?
        }
        None => {
            let mut made = of_edge(0.5 * radius)?;
            for k in 1..MOST_STEPS {
                let finer = of_edge(0.5 * radius * STEP.powi(k))?;
                if nodes(&finer) > NODES {
                    break;
                }
                made = finer;
            }
            made
        }
    };
    check_nodes(nodes(&made))?;
    let (section, sectors) = made;
    let corners =
        section.elements.iter().flat_map(|t| [t[0], t[1], t[2]]).max().map_or(0, |n| n as usize + 1);
    let triangles: Vec<[u32; 3]> = section.elements.iter().map(|t| [t[0], t[1], t[2]]).collect();
    Ok(axisymmetric::sweep_section(&section.nodes[..corners], &triangles, sectors)?)
}
