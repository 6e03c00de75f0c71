//! Triangles that face the other way than their neighbours: each patch takes the sense of most of its
//! triangles.

use super::super::mesh_error::MeshError;
use super::edges::{Sides, patches};
use super::{Fault, Repair};

/// Turns triangles until neighbours agree.
///
/// # Errors
/// [`MeshError::OneSided`].
pub(super) fn turn_flipped(work: &mut Repair) -> Result<(), MeshError> {
    let count = work.mesh.triangles.len();
    let across = Sides::new(&work.mesh).across(count);
    let (patch_count, patch) = patches(&across);
    let mut turned: Vec<Option<bool>> = vec![None; count];
    let mut front = Vec::new();
    for seed in 0..count {
        if turned[seed].is_some() {
            continue;
        }
        turned[seed] = Some(false);
        front.push((seed, false));
        while let Some((t, way)) = front.pop() {
            for (n, agree) in across[t].iter().flatten() {
                let (n, wanted) = (*n as usize, way == *agree);
                match turned[n] {
                    None => {
                        turned[n] = Some(wanted);
                        front.push((n, wanted));
                    }
                    Some(have) if have != wanted => {
                        return Err(MeshError::OneSided { position: work.mesh.centroid(n) });
                    }
                    Some(_) => {}
                }
            }
        }
    }
    let turned: Vec<bool> = turned.into_iter().map(|t| t == Some(true)).collect();
    let mut balance = vec![0_i64; patch_count];
    (0..count).for_each(|t| balance[patch[t]] += if turned[t] { 1 } else { -1 });
    let marked: Vec<bool> = (0..count).map(|t| turned[t] != (balance[patch[t]] > 0)).collect();
    let first = marked.iter().position(|m| *m);
    let triangles = work.mesh.triangles.iter_mut().zip(&marked);
    triangles.filter(|(_, marked)| **marked).for_each(|(corners, _)| corners.swap(1, 2));
    if let Some(first) = first {
        let position = work.mesh.centroid(first);
        work.note(Fault::Flipped, marked.iter().filter(|m| **m).count(), position);
    }
    Ok(())
}
