//! Triangles that bound nothing: without area, lying on others, or in sheets that stick out.

use std::collections::HashMap;

use super::super::mesh_error::MeshError;
use super::super::tri_mesh::TriMesh;
use super::edges::{Sides, patches};
use super::{Fault, Repair};

/// Rounds of turning edges of triangles without area; each undoes all that do not touch another.
const ROUNDS: usize = 16;
/// Largest area of a fin over that of the mesh.
const MOST_FIN: f64 = 0.05;

/// Triangles with two equal corners go. Those with three corners on a line share their longest edge with a
/// neighbour: the edge is turned, which leaves two triangles with area.
pub(super) fn remove_flat(work: &mut Repair) {
    let equal = |t: &[u32; 3]| t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
    let collapsed: Vec<bool> = work.mesh.triangles.iter().map(equal).collect();
    work.remove(&collapsed, Fault::NoArea);
    let first = (0..work.mesh.triangles.len()).find(|t| is_flat(&work.mesh, *t));
    let Some(position) = first.map(|t| work.mesh.centroid(t)) else { return };
    let mut turned = 0;
    for _ in 0..ROUNDS {
        let round = turn_long_edges(&mut work.mesh);
        if round == 0 {
            break;
        }
        turned += round;
    }
    work.note(Fault::NoArea, turned, position);
}

/// Whether the height of a triangle is below 1e-10 of its longest edge.
fn is_flat(mesh: &TriMesh, t: usize) -> bool {
    let [a, b, c] = mesh.corners(t);
    let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
    2.0 * mesh.area_vector(t).length() <= 1e-10 * longest
}

fn turn_long_edges(mesh: &mut TriMesh) -> usize {
    let across = Sides::new(mesh).across(mesh.triangles.len());
    let mut touched = vec![false; mesh.triangles.len()];
    let mut count = 0;
    for t in 0..mesh.triangles.len() {
        if touched[t] || !is_flat(mesh, t) {
            continue;
        }
        let corners = mesh.triangles[t];
        let length = |k: usize| {
            let [p, q] = [corners[k], corners[(k + 1) % 3]].map(|i| mesh.vertices[i as usize]);
            p.distance_squared(q)
        };
        let k = (0..3).fold(0, |best, k| if length(k) > length(best) { k } else { best });
        let Some((n, true)) = across[t][k] else { continue };
        let n = n as usize;
        let [a, b, c] = [0, 1, 2].map(|j| corners[(k + j) % 3]);
        let Some(d) = mesh.triangles[n].into_iter().find(|i| *i != a && *i != b) else { continue };
        if touched[n] || is_flat(mesh, n) || c == d {
            continue;
        }
        mesh.triangles[t] = [c, a, d];
        mesh.triangles[n] = [d, b, c];
        touched[t] = true;
        touched[n] = true;
        count += 1;
    }
    count
}

/// Of triangles with the same corners one remains, or none if that leaves fewer open edges: the two sides of
/// a sheet bound nothing.
///
/// # Errors
/// [`MeshError::Sheet`] if nothing remains.
pub(super) fn remove_double(work: &mut Repair) -> Result<(), MeshError> {
    let triangles = &work.mesh.triangles;
    let sorted = |t: &[u32; 3]| {
        let mut key = *t;
        key.sort_unstable();
        key
    };
    let mut groups: HashMap<[u32; 3], Vec<usize>> = HashMap::new();
    triangles.iter().enumerate().for_each(|(t, corners)| groups.entry(sorted(corners)).or_default().push(t));
    if groups.len() == triangles.len() {
        return Ok(());
    }
    let mut at_edge: HashMap<(u32, u32), usize> = HashMap::new();
    for key in groups.keys() {
        for (a, b) in [(key[0], key[1]), (key[1], key[2]), (key[0], key[2])] {
            *at_edge.entry((a, b)).or_default() += 1;
        }
    }
    let mut marked = vec![false; triangles.len()];
    for (t, corners) in triangles.iter().enumerate() {
        let key = sorted(corners);
        let group = &groups[&key];
        if group.len() < 2 || group[0] != t {
            continue;
        }
        let ascends = |t: usize| {
            let c = triangles[t];
            let k = c.iter().position(|i| *i == key[0]).unwrap_or(0);
            c[(k + 1) % 3] == key[1]
        };
        let up = group.iter().filter(|t| ascends(**t)).count();
        let edges = [(key[0], key[1]), (key[1], key[2]), (key[0], key[2])];
        let needed = edges.iter().filter(|e| at_edge[*e].is_multiple_of(2)).count() >= 2;
        // The copies that face as most of them do stand for all.
        let keep = group.iter().find(|t| ascends(**t) == (2 * up >= group.len())).filter(|_| needed);
        group.iter().filter(|t| Some(*t) != keep).for_each(|t| marked[*t] = true);
    }
    if marked.iter().all(|m| *m) {
        return Err(MeshError::Sheet { position: work.mesh.centroid(0) });
    }
    work.remove(&marked, Fault::Double);
    Ok(())
}

/// Sheets that stick to the surface along edges of three triangles or more, and end in the open, go.
pub(super) fn remove_fins(work: &mut Repair) {
    let sides = Sides::new(&work.mesh);
    let count = work.mesh.triangles.len();
    let (patch_count, patch) = patches(&sides.across(count));
    let mut open = vec![false; patch_count];
    let mut attached = vec![false; patch_count];
    for edge in sides.edges() {
        match edge {
            [side] => open[patch[side.triangle as usize]] = true,
            [_, _] => {}
            many => many.iter().for_each(|side| attached[patch[side.triangle as usize]] = true),
        }
    }
    let mut area = vec![0.0; patch_count];
    (0..count).for_each(|t| area[patch[t]] += work.mesh.area_vector(t).length());
    let most = MOST_FIN * work.mesh.area();
    let is_fin = |k: usize| open[k] && attached[k] && area[k] <= most;
    let marked: Vec<bool> = patch.iter().map(|k| is_fin(*k)).collect();
    work.remove(&marked, Fault::Fin);
}
