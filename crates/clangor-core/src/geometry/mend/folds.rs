//! Folds: triangles that cross others near them, as noise makes them on fine meshes. Their vertices move to
//! the mean of their neighbours until nothing crosses.

use glam::DVec3;

use super::super::mesh_error::MeshError;
use super::super::self_intersection::crossings;
use super::super::surface_tree::SurfaceTree;
use super::super::topology::Topology;
use super::shells::refuse_crossing_shells;
use super::{FOLD, Fault, Repair};

/// Rounds of smoothing.
const ROUNDS: usize = 12;
/// Largest part of the triangles that may cross.
const MOST_CROSSING: f64 = 0.02;
/// Crossings of small meshes that are looked at in any case.
const FEW: usize = 8;

/// Smooths crossing triangles.
///
/// # Errors
/// [`MeshError::CrossingShells`] if two shells cross; [`MeshError::SelfIntersection`] for crossings that
/// would need vertices to move farther than [`FOLD`] diagonals, or are many.
pub(super) fn smooth_folds(work: &mut Repair) -> Result<(), MeshError> {
    let topology = Topology::try_new(&work.mesh)?;
    let most = FEW.max((MOST_CROSSING * work.mesh.triangles.len() as f64) as usize);
    let start = work.mesh.vertices.clone();
    let mut first = None;
    for round in 0..=ROUNDS {
        let tree = SurfaceTree::new(&work.mesh);
        let found = crossings(&work.mesh, &topology, &tree, most + 1);
        let Some((t, n, position)) = found.first().copied() else { break };
        let crossing = MeshError::SelfIntersection { first: t, second: n, position };
        let seen = first.get_or_insert((crossing, position)).clone();
        refuse_crossing_shells(&work.mesh, &found)?;
        if round == ROUNDS || found.len() > most {
            return Err(seen.0);
        }
        let mut marked = vec![false; work.mesh.vertices.len()];
        for t in found.iter().flat_map(|(t, n, _)| [*t, *n]) {
            work.mesh.triangles[t].iter().for_each(|i| marked[*i as usize] = true);
        }
        relax(work, &marked);
        let moved = farthest(&work.mesh.vertices, &start);
        if moved > FOLD * work.diagonal {
            return Err(seen.0);
        }
    }
    let Some((_, position)) = first else { return Ok(()) };
    let moved = farthest(&work.mesh.vertices, &start) / work.diagonal;
    let count = work.mesh.vertices.iter().zip(&start).filter(|(a, b)| a != b).count();
    work.note(Fault::Fold { moved }, count, position);
    Ok(())
}

fn farthest(now: &[DVec3], before: &[DVec3]) -> f64 {
    now.iter().zip(before).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max)
}

/// Moves marked vertices half of the way to the mean of their neighbours.
fn relax(work: &mut Repair, marked: &[bool]) {
    let mut sum = vec![(DVec3::ZERO, 0.0); marked.len()];
    for corners in &work.mesh.triangles {
        for k in 0..3 {
            let (a, b) = (corners[k] as usize, corners[(k + 1) % 3] as usize);
            if marked[a] {
                sum[a].0 += work.mesh.vertices[b];
                sum[a].1 += 1.0;
            }
        }
    }
    for (x, (total, count)) in work.mesh.vertices.iter_mut().zip(sum) {
        if count > 0.0 {
            *x = 0.5 * (*x + total / count);
        }
    }
}
