//! Closed shells of a mesh: which are cavities, which are dust, and whether they bound one solid.

use glam::DVec3;

use super::super::components::{winding_number, winding_volume};
use super::super::mass_properties::MassProperties;
use super::super::mesh_error::MeshError;
use super::super::self_intersection::crossings;
use super::super::surface_tree::SurfaceTree;
use super::super::topology::Topology;
use super::super::tri_mesh::TriMesh;
use super::edges::{Sides, patches};
use super::{DUST, Fault, Repair};

/// Crossings among which one of two shells is looked for.
const MOST_CROSSINGS: usize = 10_000;

/// A closed shell of a mesh.
pub(super) struct Shell {
    /// Its triangles, each with vertices of its own.
    pub(super) part: TriMesh,
    /// Their numbers in the mesh.
    pub(super) triangles: Vec<usize>,
    /// Signed \[m³\].
    pub(super) volume: f64,
    bounds: (DVec3, DVec3),
}

impl Shell {
    pub(super) fn holds(&self, x: DVec3) -> bool {
        let (low, high) = self.bounds;
        x.cmpge(low).all() && x.cmple(high).all() && winding_number(&self.part, x).abs() > 0.5
    }

    fn middle(&self) -> DVec3 {
        let (low, high) = self.bounds;
        MassProperties::of(&self.part).map_or(0.5 * (low + high), |m| m.centre_of_mass)
    }
}

/// Drops dust, turns the surface outwards, and checks that all shells bound one solid.
///
/// # Errors
/// [`MeshError::CrossingShells`] for shells that cross, [`MeshError::Shells`] for solids apart from each
/// other, [`MeshError::Nested`] for one in another.
pub(super) fn keep_one_solid(work: &mut Repair) -> Result<(), MeshError> {
    let shells = drop_dust(work, shells_of(&work.mesh));
    if shells.len() > 1 {
        let topology = Topology::try_new(&work.mesh)?;
        let found = crossings(&work.mesh, &topology, &SurfaceTree::new(&work.mesh), MOST_CROSSINGS);
        refuse_crossing_shells(&work.mesh, &found)?;
    }
    let shells = turn_outwards(work, shells);
    let mut solids = Vec::new();
    for (k, shell) in shells.iter().enumerate() {
        let x = shell.part.vertices[0];
        let depth = shells.iter().enumerate().filter(|(j, other)| *j != k && other.holds(x)).count();
        match (depth % 2 == 1, shell.volume < 0.0) {
            (true, true) => {}
            (true, false) => return Err(MeshError::Nested { position: x }),
            (false, _) => solids.push(shell),
        }
    }
    match solids.as_slice() {
        [first, second, ..] => Err(MeshError::Shells {
            shells: solids.len(),
            centres: Box::new([first.middle(), second.middle()]),
            share: second.volume / first.volume,
        }),
        _ => Ok(()),
    }
}

/// # Errors
/// [`MeshError::CrossingShells`] if one of some crossings is between two shells.
pub(super) fn refuse_crossing_shells(
    mesh: &TriMesh,
    found: &[(usize, usize, DVec3)],
) -> Result<(), MeshError> {
    if found.is_empty() {
        return Ok(());
    }
    let (_, shell) = patches(&Sides::new(mesh).across(mesh.triangles.len()));
    match found.iter().find(|(t, n, _)| shell[*t] != shell[*n]) {
        Some((_, _, position)) => Err(MeshError::CrossingShells { position: *position }),
        None => Ok(()),
    }
}

/// The shells, the largest first.
pub(super) fn shells_of(mesh: &TriMesh) -> Vec<Shell> {
    let (count, patch) = patches(&Sides::new(mesh).across(mesh.triangles.len()));
    let mut members = vec![Vec::new(); count];
    patch.iter().enumerate().for_each(|(t, k)| members[*k].push(t));
    let shell = |triangles: Vec<usize>| {
        let part = part_of(mesh, &triangles);
        let volume = winding_volume(&part, part.vertices[0]);
        Shell { volume, bounds: part.bounds(), part, triangles }
    };
    let mut shells: Vec<Shell> = members.into_iter().map(shell).collect();
    shells.sort_by(|a, b| b.volume.abs().total_cmp(&a.volume.abs()));
    shells
}

fn drop_dust(work: &mut Repair, shells: Vec<Shell>) -> Vec<Shell> {
    let Some(largest) = shells.first().map(|s| s.volume.abs()) else { return shells };
    let (kept, dust): (Vec<Shell>, Vec<Shell>) =
        shells.into_iter().partition(|s| s.volume.abs() >= DUST * largest && largest > 0.0);
    let (Some(first), false) = (dust.first(), kept.is_empty()) else { return kept };
    let position = first.part.vertices[0];
    let share = dust.iter().map(|s| s.volume.abs()).sum::<f64>() / largest;
    let mut gone = vec![false; work.mesh.triangles.len()];
    dust.iter().flat_map(|s| &s.triangles).for_each(|t| gone[*t] = true);
    let mut marks = gone.iter();
    work.mesh.triangles.retain(|_| !marks.next().copied().unwrap_or(false));
    work.note(Fault::Dust { share }, dust.len(), position);
    shells_of(&work.mesh)
}

/// Turns everything if the largest shell is inside out, then every other shell that lies in none and is.
pub(super) fn turn_outwards(work: &mut Repair, mut shells: Vec<Shell>) -> Vec<Shell> {
    if shells.first().is_some_and(|s| s.volume < 0.0) {
        let position = shells[0].part.vertices[0];
        (0..shells.len()).for_each(|k| turn(work, &mut shells[k]));
        work.note(Fault::InsideOut, work.mesh.triangles.len(), position);
    }
    for k in 1..shells.len() {
        let x = shells[k].part.vertices[0];
        let is_held = || shells.iter().enumerate().any(|(j, other)| j != k && other.holds(x));
        if shells[k].volume < 0.0 && !is_held() {
            turn(work, &mut shells[k]);
            work.note(Fault::InsideOut, shells[k].triangles.len(), x);
        }
    }
    shells
}

fn turn(work: &mut Repair, shell: &mut Shell) {
    shell.triangles.iter().for_each(|t| work.mesh.triangles[*t].swap(1, 2));
    shell.part.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    shell.volume = -shell.volume;
}

/// The mesh of some triangles, with vertices of its own for each.
fn part_of(mesh: &TriMesh, triangles: &[usize]) -> TriMesh {
    let vertices = triangles.iter().flat_map(|t| mesh.corners(*t)).collect();
    let triangles = (0..triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    TriMesh { vertices, triangles }
}
