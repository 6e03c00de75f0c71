//! Shells that touch or cross, united: the legs and the seat of a chair, a handle that ends in the wall of a
//! mug. They become one piece of one material, as if they were glued all over the faces that touch.
//!
//! The [`union`] of two solids wants them in general position. Every vertex moves outwards by [`GROWTHS`] of
//! the diagonal, and by a random part of that in any direction. Faces that touch then overlap, and nothing
//! lies exactly on anything else. Afterwards, vertices of the file go back to where they were.
//!
//! Shells that meet in a point or along a line only ([`JOINT`]) are apart.

use glam::DVec3;

use super::super::components::{winding_number, winding_volume};
use super::super::mesh_error::MeshError;
use super::super::solid::check_solid;
use super::super::tri_mesh::TriMesh;
use super::shells::{Shell, shells_of, turn_outwards};
use super::slivers::without_slivers;
use super::union::{Degenerate, Union, compact, union};
use super::{Fault, Repair};
use crate::math::random::SplitMix;

/// By how much solids grow, over the diagonal, one after the other until a union is found: more than the
/// rounding of single precision at first.
const GROWTHS: [f64; 5] = [1e-6, 1.5e-6, 2e-6, 5e-6, 1e-5];
/// Random part of the growth.
const RANDOM: f64 = 0.3;
/// Smallest cosine between the direction in which a vertex moves and the normals around it.
const SHARPEST: f64 = 0.3;
/// Least area of a surface within the other solid, in the growth times the root of the area of the smaller
/// one. Seen: 6 of tetrahedra that share an edge, 2 of blocks, 0.1 of a ball on a plate; 1800 of parts.
const JOINT: f64 = 15.0;
/// Triangles lower than this are slivers between two unions, in growths.
const SLIVER: f64 = 0.2;
/// The same afterwards, one after the other until the surface bounds a solid.
const LAST_SLIVERS: [f64; 3] = [20.0, 60.0, 5.0];

/// Why shells were not united.
pub(super) enum NotUnited {
    /// The geometry allows no union.
    Degenerate,
    /// Some were, and others are apart from them or within.
    Left(MeshError),
    /// All are apart.
    Apart,
}

/// A closed surface in units of the diagonal, and where its vertices were before it grew.
#[derive(Clone)]
struct Solid {
    mesh: TriMesh,
    before: Vec<Option<DVec3>>,
    area: f64,
}

/// Unites all shells.
///
/// # Errors
/// [`NotUnited`], with the mesh as it was but for shells that were inside out.
pub(super) fn unite_shells(work: &mut Repair) -> Result<(), NotUnited> {
    let shells = shells_of(&work.mesh);
    let shells = turn_outwards(work, shells);
    let solids = with_cavities(&shells);
    let attempt = |growth: f64| united(work, &shells, &solids, growth);
    let first = attempt(GROWTHS[0]);
    let (mesh, position) = match first {
        Ok(united) => united,
        Err(why) => GROWTHS[1..].iter().find_map(|growth| attempt(*growth).ok()).ok_or(why)?,
    };
    work.mesh = mesh;
    work.note(Fault::United, solids.len(), position);
    Ok(())
}

/// The shells that bound solids, each with those that bound its cavities.
fn with_cavities(shells: &[Shell]) -> Vec<Vec<usize>> {
    let mut solids: Vec<Vec<usize>> =
        (0..shells.len()).filter(|k| shells[*k].volume > 0.0).map(|k| vec![k]).collect();
    for cavity in (0..shells.len()).filter(|k| shells[*k].volume <= 0.0) {
        let holds = |solid: &&mut Vec<usize>| shells[solid[0]].holds(shells[cavity].part.vertices[0]);
        // The smallest comes last.
        if let Some(solid) = solids.iter_mut().rev().find(holds) {
            solid.push(cavity);
        }
    }
    solids
}

/// The union of all solids, and a place where two meet.
fn united(
    work: &Repair,
    shells: &[Shell],
    solids: &[Vec<usize>],
    growth: f64,
) -> Result<(TriMesh, DVec3), NotUnited> {
    let (low, high) = work.mesh.bounds();
    let scale = Scale { middle: 0.5 * (low + high), diagonal: work.diagonal };
    let mut random = SplitMix::new(0);
    let grown = solids.iter().map(|solid| {
        let triangles = solid.iter().flat_map(|k| &shells[*k].triangles);
        grown(&scale.small(&work.mesh, triangles.copied()), growth, &mut random)
    });
    let all: Vec<Solid> = grown.collect();
    let mut whole = all[0].clone();
    let mut left: Vec<usize> = (1..all.len()).collect();
    let mut meeting = None;
    // Those that touch what is united, until none does.
    loop {
        let before = left.len();
        let mut apart = Vec::new();
        for k in left {
            match union(&whole.mesh, &all[k].mesh).map_err(|Degenerate| NotUnited::Degenerate)? {
                Some(both) if is_joint(&both, [&whole, &all[k]], growth) => {
                    meeting = meeting.or(Some(both.position));
                    whole = whole.with(&all[k], both, growth);
                }
                None if is_covered(k, &whole, &all) => {}
                _ => apart.push(k),
            }
        }
        left = apart;
        if left.is_empty() || left.len() == before {
            break;
        }
    }
    match (meeting, left.first().map(|k| &all[*k])) {
        (None, _) => Err(NotUnited::Apart),
        (Some(_), Some(other)) => Err(NotUnited::Left(whole.apart_from(other, 1 + left.len(), &scale))),
        (Some(position), None) => {
            let mesh = tidy(whole, growth).ok_or(NotUnited::Degenerate)?;
            Ok((scale.large(mesh), scale.back(position)))
        }
    }
}

/// Whether solids meet in faces, and not in points or lines only.
fn is_joint(both: &Union, solids: [&Solid; 2], growth: f64) -> bool {
    let [first, second] = solids.map(|solid| solid.area);
    both.covered >= JOINT * growth * first.min(second).sqrt()
}

/// Whether a solid lies within the union of others, of which it crosses one.
fn is_covered(k: usize, whole: &Solid, all: &[Solid]) -> bool {
    let crosses = |other: &Solid| matches!(union(&other.mesh, &all[k].mesh), Ok(Some(_)));
    whole.holds(&all[k]) && all.iter().enumerate().any(|(other, solid)| other != k && crosses(solid))
}

impl Solid {
    /// Whether another solid that does not cross it lies within.
    fn holds(&self, other: &Solid) -> bool {
        winding_number(&self.mesh, other.mesh.vertices[0]) > 0.5
    }

    /// The union with another solid.
    fn with(&self, other: &Solid, both: Union, growth: f64) -> Solid {
        let before = |source: &Option<u32>| {
            let source = source.map(|v| v as usize)?;
            let own = self.before.len();
            if source < own { self.before[source] } else { other.before[source - own] }
        };
        let (mesh, kept) = without_slivers(&both.mesh, SLIVER * growth);
        let before = kept.iter().map(|v| before(&both.sources[*v as usize])).collect();
        Solid { before, area: mesh.area(), mesh }
    }

    /// What is wrong with two solids that are not one.
    fn apart_from(&self, other: &Solid, shells: usize, scale: &Scale) -> MeshError {
        let position = other.mesh.vertices[0];
        if self.holds(other) {
            return MeshError::Nested { position: scale.back(position) };
        }
        let middle = |solid: &Solid| {
            let (low, high) = solid.mesh.bounds();
            scale.back(0.5 * (low + high))
        };
        let volume = |solid: &Solid| winding_volume(&solid.mesh, DVec3::ZERO);
        let share = volume(other) / volume(self);
        MeshError::Shells { shells, centres: Box::new([middle(self), middle(other)]), share }
    }
}

/// A solid that has grown into general position.
fn grown(mesh: &TriMesh, growth: f64, random: &mut SplitMix) -> Solid {
    let normals: Vec<DVec3> =
        (0..mesh.triangles.len()).map(|t| mesh.area_vector(t).normalize_or_zero()).collect();
    let mut outwards = vec![DVec3::ZERO; mesh.vertices.len()];
    for (t, corners) in mesh.triangles.iter().enumerate() {
        let places = mesh.corners(t);
        for k in 0..3 {
            let (to_next, to_last) = (places[(k + 1) % 3] - places[k], places[(k + 2) % 3] - places[k]);
            outwards[corners[k] as usize] += to_next.angle_between(to_last) * normals[t];
        }
    }
    outwards.iter_mut().for_each(|outwards| *outwards = outwards.normalize_or_zero());
    // Every face moves by the growth at least.
    let mut cosines = vec![1.0_f64; mesh.vertices.len()];
    for (corners, normal) in mesh.triangles.iter().zip(&normals) {
        for v in corners.map(|v| v as usize) {
            cosines[v] = cosines[v].min(outwards[v].dot(*normal)).max(SHARPEST);
        }
    }
    let moved = mesh.vertices.iter().zip(outwards.iter().zip(&cosines)).map(|(x, (outwards, cosine))| {
        let shift = RANDOM * random.uniform(0.0, 1.0) * random.direction();
        *x + growth * (*outwards / *cosine + shift)
    });
    let before = mesh.vertices.iter().map(|x| Some(*x)).collect();
    Solid {
        mesh: TriMesh { vertices: moved.collect(), triangles: mesh.triangles.clone() },
        before,
        area: mesh.area(),
    }
}

/// The surface without slivers and with its vertices where they were, as far as it stays one that bounds a
/// solid.
fn tidy(solid: Solid, growth: f64) -> Option<TriMesh> {
    let Solid { mesh, before, .. } = solid;
    let restored = |mesh: &TriMesh, kept: &[u32]| {
        let places = mesh.vertices.iter().zip(kept);
        let vertices = places.map(|(x, old)| before[*old as usize].unwrap_or(*x)).collect();
        TriMesh { vertices, triangles: mesh.triangles.clone() }
    };
    let all: Vec<u32> = (0..before.len() as u32).collect();
    let tidied = LAST_SLIVERS.iter().map(|height| without_slivers(&mesh, height * growth));
    let candidates = tidied.chain([(mesh.clone(), all)]).flat_map(|(own, kept)| [restored(&own, &kept), own]);
    candidates.into_iter().find(|mesh| check_solid(mesh).is_ok())
}

/// The size and place of a mesh.
struct Scale {
    middle: DVec3,
    diagonal: f64,
}

impl Scale {
    fn small(&self, mesh: &TriMesh, triangles: impl Iterator<Item = usize>) -> TriMesh {
        let triangles: Vec<[u32; 3]> = triangles.map(|t| mesh.triangles[t]).collect();
        let (mut own, _) = compact(&mesh.vertices, &triangles);
        own.vertices.iter_mut().for_each(|x| *x = (*x - self.middle) / self.diagonal);
        own
    }

    fn back(&self, x: DVec3) -> DVec3 {
        self.middle + self.diagonal * x
    }

    fn large(&self, mesh: TriMesh) -> TriMesh {
        TriMesh { vertices: mesh.vertices.iter().map(|x| self.back(*x)).collect(), ..mesh }
    }
}
