//! Holes: closed chains of open edges. Small ones are closed by triangles between their corners.
//!
//! The ear with the widest angle is cut off first, as long as it neither folds over nor covers another corner
//! seen along the mean normal of the hole.

use std::collections::{BTreeMap, HashMap, HashSet};

use glam::DVec3;

use super::super::mesh_error::MeshError;
use super::super::tri_mesh::TriMesh;
use super::edges::Sides;
use super::{Fault, HOLE, Repair, TRIANGLE_HOLE};

/// Most corners of a hole that is closed.
const MOST_CORNERS: usize = 400;

/// Closes the holes with borders of up to [`HOLE`] diagonals, and of three edges up to [`TRIANGLE_HOLE`].
///
/// # Errors
/// [`MeshError::Hole`] for the largest other; [`MeshError::Open`] where open edges form no chain.
pub(super) fn close_holes(work: &mut Repair) -> Result<(), MeshError> {
    let sides = Sides::new(&work.mesh);
    let open = sides.open();
    if open.is_empty() {
        return Ok(());
    }
    let triangles = &work.mesh.triangles;
    // Against the sense of the triangles, which is that of the triangles that are missing.
    let mut next: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for side in &open {
        let t = triangles[side.triangle as usize];
        let slot = usize::from(side.slot);
        next.entry(t[(slot + 1) % 3]).or_default().push(t[slot]);
    }
    let loops = chains(next).ok_or_else(|| MeshError::Open {
        edges: open.len(),
        position: work.mesh.vertices[open[0].low as usize],
    })?;
    let border = |chain: &Vec<u32>| -> f64 {
        let at = |k: usize| work.mesh.vertices[chain[k % chain.len()] as usize];
        (0..chain.len()).map(|k| at(k).distance(at(k + 1))).sum()
    };
    let share = |chain: &Vec<u32>| border(chain) / work.diagonal;
    let longer = |a: &&Vec<u32>, b: &&Vec<u32>| border(a).total_cmp(&border(b));
    let too_long = |chain: &&Vec<u32>| match chain.len() {
        3 => share(chain) > TRIANGLE_HOLE,
        corners => share(chain) > HOLE || corners > MOST_CORNERS,
    };
    if let Some(longest) = loops.iter().filter(too_long).max_by(longer) {
        let position = work.mesh.vertices[longest[0] as usize];
        return Err(MeshError::Hole { holes: loops.len(), share: share(longest), position });
    }
    let largest = loops.iter().map(share).fold(0.0, f64::max);
    let position = work.mesh.vertices[loops[0][0] as usize];
    let mut edges: HashSet<(u32, u32)> = sides.edges().map(|e| (e[0].low, e[0].high)).collect();
    for chain in &loops {
        close(&mut work.mesh, chain.clone(), &mut edges);
    }
    work.note(Fault::Hole { border: largest }, loops.len(), position);
    Ok(())
}

/// Closed chains of directed edges; `None` if some end nowhere. A vertex at which several meet parts them.
fn chains(mut next: BTreeMap<u32, Vec<u32>>) -> Option<Vec<Vec<u32>>> {
    let mut loops = Vec::new();
    while let Some(start) = next.first_key_value().map(|(start, _)| *start) {
        let mut chain = vec![start];
        let mut place = HashMap::from([(start, 0)]);
        loop {
            let here = *chain.last()?;
            let ends = next.get_mut(&here)?;
            let to = ends.pop()?;
            if ends.is_empty() {
                next.remove(&here);
            }
            if let Some(k) = place.get(&to).copied() {
                let closed = chain.split_off(k);
                for i in &closed {
                    place.remove(i);
                }
                loops.push(closed);
                if chain.is_empty() {
                    break;
                }
            }
            // A vertex where the chain closed on itself is still on the way of the outer one.
            place.insert(to, chain.len());
            chain.push(to);
        }
    }
    Some(loops)
}

/// Fills one hole; a corner in its middle is added where no ear can be cut off.
fn close(mesh: &mut TriMesh, mut chain: Vec<u32>, edges: &mut HashSet<(u32, u32)>) {
    let at = |mesh: &TriMesh, i: u32| mesh.vertices[i as usize];
    let normal: DVec3 = (0..chain.len())
        .map(|k| at(mesh, chain[k]).cross(at(mesh, chain[(k + 1) % chain.len()])))
        .sum::<DVec3>()
        .normalize_or_zero();
    while chain.len() > 3 {
        let count = chain.len();
        let ear = |k: usize| [chain[(k + count - 1) % count], chain[k], chain[(k + 1) % count]];
        let best = (0..count)
            .filter(|k| is_ear(mesh, &chain, ear(*k), normal))
            .filter(|k| !edges.contains(&ordered(ear(*k)[0], ear(*k)[2])))
            .min_by(|j, k| angle(mesh, ear(*j)).total_cmp(&angle(mesh, ear(*k))));
        let Some(k) = best else { break };
        let [a, b, c] = ear(k);
        mesh.triangles.push([a, b, c]);
        edges.insert(ordered(a, c));
        chain.remove(k);
    }
    if let [a, b, c] = chain[..] {
        mesh.triangles.push([a, b, c]);
        return;
    }
    let middle = chain.iter().map(|i| at(mesh, *i)).sum::<DVec3>() / chain.len() as f64;
    let m = mesh.vertices.len() as u32;
    mesh.vertices.push(middle);
    for k in 0..chain.len() {
        mesh.triangles.push([chain[k], chain[(k + 1) % chain.len()], m]);
    }
}

fn ordered(a: u32, b: u32) -> (u32, u32) {
    (a.min(b), a.max(b))
}

/// Angle at the middle corner.
fn angle(mesh: &TriMesh, ear: [u32; 3]) -> f64 {
    let [a, b, c] = ear.map(|i| mesh.vertices[i as usize]);
    (a - b).angle_between(c - b)
}

fn is_ear(mesh: &TriMesh, chain: &[u32], ear: [u32; 3], normal: DVec3) -> bool {
    let corners = ear.map(|i| mesh.vertices[i as usize]);
    let [a, b, c] = corners;
    if (b - a).cross(c - a).dot(normal) <= 0.0 {
        return false;
    }
    let covers = |x: DVec3| {
        (0..3).all(|k| (corners[(k + 1) % 3] - corners[k]).cross(x - corners[k]).dot(normal) >= 0.0)
    };
    !chain.iter().any(|i| !ear.contains(i) && covers(mesh.vertices[*i as usize]))
}
