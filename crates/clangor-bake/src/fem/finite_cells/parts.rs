//! The parts of a body in the cells of a grid, and their ties.
//!
//! A cell in which walls meet is divided between them; every other cell has one part. Parts of one cell
//! that touch are tied by a penalty on the difference of their displacements over the division.

use clangor_core::geometry::tri_mesh::TriMesh;
use glam::DVec3;
use rayon::prelude::*;

use super::basis::Basis;
use super::chain::{Cap, Chain, Origin, cell_chains};
use super::division::{Divided, Division};
use super::faces::Faces;
use super::grid::CellGrid;
use super::moments::{CellMoments, cell_moments, part_moments, rules, section_moments};
use super::{DROPPED, FILLED, WrongCell};

/// Part of the volume in a cell below which a part joins its neighbour across the largest division.
const SLIVER: f64 = 0.02;
/// Largest difference between the filled part of a cell and the sum of its parts.
const CLOSED: f64 = 1e-9;

/// Sections of the body with the lower and with the upper faces of a cell across the axes.
type Sections = [[f64; 3]; 2];
/// A division and the surface of the body in the cell that it divides.
type Work = (Division, Chain);

/// A cell that contains a part of the body.
#[derive(Clone, Debug)]
pub(super) struct Cell {
    pub(super) place: [usize; 3],
    /// How walls divide it, if they do.
    pub(super) division: Option<Division>,
    /// The part of each wall; one without a division.
    pub(super) parts: Vec<Option<usize>>,
    /// Section of the body with its upper face across each axis, in that of the face.
    pub(super) sections: [f64; 3],
    /// The same with its lower face.
    pub(super) lower_sections: [f64; 3],
}

impl Cell {
    /// Section of one of its parts with its lower face across an axis, in that of the face.
    pub(super) fn lower_section(&self, part: &Part, axis: usize) -> f64 {
        self.section(part, 2 * axis as u8)
    }

    /// Section of one of its parts with a face (twice the axis, plus 1 for the upper one), in that of the
    /// face.
    pub(super) fn section(&self, part: &Part, face: u8) -> f64 {
        let axis = usize::from(face / 2);
        match self.division {
            Some(_) => face_area(&part.sections, face),
            None if face.is_multiple_of(2) => self.lower_sections[axis],
            None => self.sections[axis],
        }
    }

    /// Its parts, each once.
    pub(super) fn distinct_parts(&self) -> Vec<usize> {
        let mut parts: Vec<usize> = self.parts.iter().flatten().copied().collect();
        parts.sort_unstable();
        parts.dedup();
        parts
    }
}

/// The body in a cell, or one wall of it.
#[derive(Clone, Debug)]
pub(super) struct Part {
    pub(super) place: [usize; 3],
    /// Its volume in that of the cell.
    pub(super) filled: f64,
    /// Weights of the quadrature, on the Gauss points of the cube \[m³\].
    pub(super) weights: Vec<f64>,
    /// Sections with the faces of the cell; none without a division.
    pub(super) sections: Vec<Cap>,
}

/// Where two parts of a cell touch.
#[derive(Clone, Debug)]
pub(super) struct Tie {
    pub(super) parts: [usize; 2],
    /// Weights of the quadrature over the division, on the Gauss points of the cube \[m²\].
    pub(super) weights: Vec<f64>,
}

/// The body in all cells.
#[derive(Clone, Debug, Default)]
pub(super) struct Parts {
    /// Ascending by place.
    pub(super) cells: Vec<Cell>,
    pub(super) parts: Vec<Part>,
    pub(super) ties: Vec<Tie>,
}

/// The parts of one divided cell.
struct DividedCell {
    division: Division,
    /// Moments and chain of each wall.
    walls: Vec<(CellMoments, Chain)>,
    /// Moments of the division between two walls.
    ties: Vec<([usize; 2], CellMoments)>,
}

impl Parts {
    /// The cell at a place.
    pub(super) fn cell(&self, place: [usize; 3]) -> Option<&Cell> {
        self.cells.binary_search_by_key(&place, |cell| cell.place).ok().map(|k| &self.cells[k])
    }

    /// The parts of a body with walls of a thickness \[m\], in the cells that the grid keeps and that are
    /// `wanted`.
    ///
    /// # Errors
    /// [`WrongCell`].
    pub(super) fn new(
        surface: &TriMesh,
        grid: &CellGrid,
        basis: &Basis,
        wall: f64,
        wanted: impl Fn([usize; 3]) -> bool + Sync,
    ) -> Result<Self, WrongCell> {
        let wanted = |place: [usize; 3]| grid.keeps(place) && wanted(place);
        let moments = cell_moments(surface, grid, basis, wanted);
        let sections = sections(&moments);
        let mut own: Vec<(CellMoments, Sections)> = Vec::new();
        let kept = |(cell, _): &(CellMoments, Sections)| wanted(cell.place);
        for (cell, sections) in moments.into_iter().zip(sections).filter(kept) {
            let part = cell.filled();
            if !(-FILLED..=1.0 + FILLED).contains(&part) {
                return Err(WrongCell { place: grid.middle(cell.place), filled: part, edge: grid.edge });
            }
            if part > DROPPED {
                own.push((cell, sections));
            }
        }
        let faces = Faces::new(surface, grid, wall, wanted);
        let divided = faces.map_or_else(Vec::new, |faces| divided_cells(surface, grid, basis, &faces, &own));
        let mut divided = divided.into_iter();
        let mut all = Parts::default();
        let scale = grid.edge;
        for (cell, sections) in own {
            let place = cell.place;
            match divided.next().flatten() {
                Some(found) => all.push_divided(place, sections, found, basis, scale),
                None => {
                    let [lower_sections, sections] = sections;
                    let part = all.parts.len();
                    all.parts.push(Part {
                        place,
                        filled: cell.filled(),
                        weights: scaled(cell.weights(basis), scale.powi(3)),
                        sections: Vec::new(),
                    });
                    all.cells.push(Cell {
                        place,
                        division: None,
                        parts: vec![Some(part)],
                        sections,
                        lower_sections,
                    });
                }
            }
        }
        Ok(all)
    }

    fn push_divided(
        &mut self,
        place: [usize; 3],
        [lower_sections, sections]: Sections,
        found: DividedCell,
        basis: &Basis,
        edge: f64,
    ) {
        let DividedCell { division, walls, ties } = found;
        let mut group = without_slivers(&walls, &ties);
        if walls.iter().all(|(own, _)| own.filled() <= DROPPED) {
            // A cell that hardly touches the body has one part.
            group.fill(0);
        }
        let first = self.parts.len();
        let mut parts = vec![None; walls.len()];
        for wall in 0..walls.len() {
            if group[wall] != wall {
                continue;
            }
            let mut members = walls.iter().enumerate().filter(|(k, _)| group[*k] == wall).map(|(_, own)| own);
            let Some((own, chain)) = members.next() else { continue };
            let (mut own, mut chain) = (own.clone(), chain.clone());
            for (other, more) in members {
                own.add(other);
                chain.extend(more.clone());
            }
            if own.filled() > DROPPED || group.iter().all(|first| *first == wall) {
                parts[wall] = Some(self.parts.len());
                chain.caps.retain(|cap| matches!(cap.origin, Origin::Face(_)));
                self.parts.push(Part {
                    place,
                    filled: own.filled(),
                    weights: scaled(own.weights(basis), edge.powi(3)),
                    sections: chain.caps,
                });
            }
        }
        for wall in 0..walls.len() {
            parts[wall] = parts[group[wall]];
        }
        let begin = self.ties.len();
        for ([a, b], moments) in ties {
            let (Some(a), Some(b)) = (parts[a], parts[b]) else { continue };
            if a == b {
                continue;
            }
            // Moments are over a square of edge 2.
            let weights = scaled(moments.weights(basis), 2.0 * edge * edge);
            let pair = [a.min(b), a.max(b)];
            match self.ties[begin..].iter_mut().find(|tie| tie.parts == pair) {
                Some(tie) => tie.weights.iter_mut().zip(&weights).for_each(|(sum, more)| *sum += more),
                None => self.ties.push(Tie { parts: pair, weights }),
            }
        }
        let division = (self.parts.len() > first + 1).then_some(division);
        if division.is_none() {
            parts = vec![Some(first)];
        }
        self.cells.push(Cell { place, division, parts, sections, lower_sections });
    }
}

fn scaled(mut weights: Vec<f64>, factor: f64) -> Vec<f64> {
    weights.iter_mut().for_each(|w| *w *= factor);
    weights
}

/// The divided ones among some cells.
fn divided_cells(
    surface: &TriMesh,
    grid: &CellGrid,
    basis: &Basis,
    faces: &Faces,
    cells: &[(CellMoments, Sections)],
) -> Vec<Option<DividedCell>> {
    let divisions: Vec<Option<Division>> =
        cells.par_iter().map(|(cell, _)| faces.division(cell.place)).collect();
    let places: Vec<[usize; 3]> =
        cells.iter().zip(&divisions).filter(|(_, d)| d.is_some()).map(|((cell, _), _)| cell.place).collect();
    let triangles = (0..surface.triangles.len()).map(|t| surface.corners(t).map(|x| grid.scaled(x)));
    let mut chains = cell_chains(triangles.collect(), &places).into_iter();
    let work: Vec<Option<Work>> =
        divisions.into_iter().map(|division| Some((division?, chains.next()?))).collect();
    let (rules, count) = (rules(basis), basis.points().len());
    let divide = |(work, (cell, _)): (Option<Work>, &(CellMoments, Sections))| {
        let (division, chain) = work?;
        let (walls, cuts) = division.parts(&chain);
        let moments = |chain: Chain| (part_moments(cell.place, &chain, &rules, count), chain);
        let walls: Vec<_> = walls.into_iter().map(moments).collect();
        let total: f64 = walls.iter().map(|(own, _)| own.filled()).sum();
        // Not of a surface that crosses itself.
        if (total - cell.filled()).abs() > CLOSED || walls.iter().any(|(own, _)| own.filled() < -CLOSED) {
            return None;
        }
        let mut pairs: Vec<[usize; 2]> = cuts.iter().map(|cut| cut.walls).collect();
        pairs.sort_unstable();
        pairs.dedup();
        let section = |pair: [usize; 2]| {
            let own = cuts.iter().filter(|cut: &&Divided| cut.walls == pair);
            (pair, section_moments(cell.place, own, &rules, count))
        };
        Some(DividedCell { division, walls, ties: pairs.into_iter().map(section).collect() })
    };
    work.into_par_iter().zip(cells).map(divide).collect()
}

/// The wall that each wall counts as: itself, or the one across its largest division if it is a sliver.
fn without_slivers(walls: &[(CellMoments, Chain)], ties: &[([usize; 2], CellMoments)]) -> Vec<usize> {
    let total: f64 = walls.iter().map(|(own, _)| own.filled()).sum();
    let mut group: Vec<usize> = (0..walls.len()).collect();
    for wall in 0..walls.len() {
        let volume: f64 =
            walls.iter().zip(&group).filter(|(_, g)| **g == wall).map(|((own, _), _)| own.filled()).sum();
        if group[wall] != wall || volume > SLIVER * total {
            continue;
        }
        let mut best = (0.0, wall);
        for ([a, b], moments) in ties {
            let (a, b) = (group[*a], group[*b]);
            let area = moments.section_area();
            if a != b && (a == wall || b == wall) && area > best.0 {
                best = (area, if a == wall { b } else { a });
            }
        }
        group.iter_mut().filter(|g| **g == wall).for_each(|g| *g = best.1);
    }
    // The number of a group is its first wall.
    let first: Vec<usize> =
        (0..walls.len()).map(|wall| group.iter().position(|g| *g == group[wall]).unwrap_or(wall)).collect();
    first
}

/// Sections of the body with the faces of cells, by the theorem of Gauss along each axis.
fn sections(cells: &[CellMoments]) -> Vec<Sections> {
    let mut sections = vec![[[0.0; 3]; 2]; cells.len()];
    for (axis, [second, third]) in [(0, [1, 2]), (1, [2, 0]), (2, [0, 1])] {
        let rest = |k: usize| [cells[k].place[second], cells[k].place[third]];
        let mut order: Vec<usize> = (0..cells.len()).collect();
        order.sort_by_key(|k| (rest(*k), cells[*k].place[axis]));
        for row in order.chunk_by(|a, b| rest(*a) == rest(*b)) {
            let mut section = 0.0;
            for k in row {
                sections[*k][0][axis] = section;
                section -= cells[*k].surface[axis];
                sections[*k][1][axis] = section;
            }
        }
    }
    sections
}

/// Area of the section with a face of a cell, in that of the face.
pub(super) fn face_area(section: &[Cap], face: u8) -> f64 {
    let own = section.iter().filter(|cap| cap.origin == Origin::Face(face));
    own.map(Cap::area_vector).sum::<DVec3>()[usize::from(face / 2)].abs()
}
