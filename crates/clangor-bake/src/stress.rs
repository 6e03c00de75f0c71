//! Quasistatic stress of a free body under many contact loads.
//!
//! ```text
//! K u = f − r,    σ = C ε(u),    E_S = ½ uᵀ (f − r)
//! ```
//!
//! The reaction r balances the load: by default the inertia of the rigid acceleration (see `balance`). K is
//! factorised once (see `anchored_factor`). A load then costs a forward and a back substitution or, at places
//! loaded before, sums over stored columns (see `unit_loads`). Contact forces are distributed over a patch
//! (see `contact_tractions`).
//!
//! This is the stress under slowly rising forces, without elastic waves. It holds where contacts last longer
//! than waves take through the body.
//!
//! Source: \[FRAC\] §3.1, App. B, C. Differs: inertia instead of a reaction distributed equally over the
//! nodes; quadratic elements, whose stress is linear; recovered stress at the corners.

mod anchored_factor;
mod balance;
mod contact_tractions;
mod fracture_mesh;
mod recovery;
mod symmetric_tensor;
mod unit_loads;

pub use clangor_core::scene::breaking::Reaction;
use glam::{DMat3, DVec3};

use crate::fem::out_of_memory::OutOfMemory;
use crate::fem::{ElasticConstants, ElasticSystem};
use crate::mesh::tetrahedra::TetMesh;
use anchored_factor::AnchoredFactor;
use balance::Balance;
use contact_tractions::ContactTractions;
pub use fracture_mesh::{FractureMeshError, fracture_mesh};
use recovery::Recovery;
pub use symmetric_tensor::SymmetricTensor;
use unit_loads::{UnitLoads, UnitResponse};

/// Relative distance of a midpoint from the middle of its edge above which the edge is curved.
const STRAIGHT: f64 = 1e-6;
/// Columns solved together: more cost less each, but take more memory.
const COLUMNS_TOGETHER: usize = 12;

/// Settings of the stress computation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StressOptions {
    /// Reaction that balances a load.
    pub reaction: Reaction,
    /// Radius over which a contact force is distributed \[m\], at least an edge of the mesh; `None` for 1 %
    /// of the longest extent of the body.
    pub contact_radius: Option<f64>,
    /// Memory limit of stored columns \[bytes\].
    pub cache_bytes: usize,
}

impl Default for StressOptions {
    fn default() -> Self {
        StressOptions { reaction: Reaction::default(), contact_radius: None, cache_bytes: 64 << 20 }
    }
}

/// A contact force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointLoad {
    /// Position in the frame of the mesh \[m\], projected onto the surface.
    pub point: DVec3,
    /// Force on the body \[N\].
    pub force: DVec3,
}

/// Reasons why stress cannot be computed.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ElastostaticsError {
    /// No elements.
    #[error("the mesh has no elements")]
    Empty,
    /// A curved edge.
    #[error("element {element} has a curved edge; the stress of a body needs straight ones")]
    Curved {
        /// The element.
        element: usize,
    },
    /// More than one connected body.
    #[error("the mesh falls into {0} parts that do not hang together")]
    LooseParts(usize),
    /// The stiffness has more than six zero-energy motions, or elements are too distorted.
    #[error(
        "the stiffness cannot be inverted (relative error {error:.1e}): parts hang together by a point or \
         an edge only, or elements are too distorted"
    )]
    Singular {
        /// Relative error of the displacement under a known load.
        error: f64,
    },
    /// Invalid contact radius.
    #[error("the contact radius is {0} m, but must not be negative")]
    ContactRadius(f64),
    /// A load or displacement is not finite.
    #[error("load or displacement {index} is not finite")]
    Load {
        /// Name of the quantity.
        index: usize,
    },
    /// Forces or displacements do not fit the mesh.
    #[error("there are {forces} vectors for {nodes} nodes")]
    ForceCount {
        /// Number given.
        forces: usize,
        /// Number of nodes.
        nodes: usize,
    },
    /// No memory for the factor.
    #[error("not enough memory for the factor of {unknowns} unknowns")]
    Memory {
        /// Number of unknowns.
        unknowns: usize,
    },
}

impl From<OutOfMemory> for ElastostaticsError {
    fn from(OutOfMemory { unknowns }: OutOfMemory) -> Self {
        ElastostaticsError::Memory { unknowns }
    }
}

/// Deformation of a body under a load. Corners are the first nodes of the mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Deformation {
    /// Displacement of each node, without rigid motion \[m\].
    pub displacement: Vec<DVec3>,
    /// E_S \[J\].
    pub strain_energy: f64,
    /// Recovered stress at each corner \[Pa\].
    pub corner_stress: Vec<SymmetricTensor>,
    /// Mean stress of each element \[Pa\].
    pub element_stress: Vec<SymmetricTensor>,
    /// Energy per volume at each corner: the mean of the elements there by volume [J/m³].
    pub corner_energy_density: Vec<f64>,
    /// Mean energy per volume of each element [J/m³]; times volumes they sum to E_S.
    pub element_energy_density: Vec<f64>,
}

/// The largest principal stress of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tension {
    /// The stress; negative if the whole body is in compression \[Pa\].
    pub stress: f64,
    /// Corner of the mesh.
    pub corner: usize,
    /// Unit vector along it; a crack opens perpendicular to it.
    pub direction: DVec3,
}

impl Deformation {
    /// Position and value of the largest tension.
    pub fn maximum_tension(&self) -> Tension {
        let stresses = self.corner_stress.iter().map(|s| s.largest()).enumerate();
        let (corner, _) =
            stresses.fold((0, f64::NEG_INFINITY), |most, here| if here.1 > most.1 { here } else { most });
        let (stress, direction) = self.corner_stress[corner].largest_with_direction();
        Tension { stress, corner, direction }
    }

    /// The same under forces scaled by `factor`.
    pub fn scaled(mut self, factor: f64) -> Self {
        self.displacement.iter_mut().for_each(|u| *u *= factor);
        let stresses = self.corner_stress.iter_mut().chain(&mut self.element_stress);
        stresses.for_each(|stress| *stress = *stress * factor);
        let densities = self.corner_energy_density.iter_mut().chain(&mut self.element_energy_density);
        densities.for_each(|density| *density *= factor * factor);
        self.strain_energy *= factor * factor;
        self
    }
}

/// A body, ready for loads.
pub struct StressBody {
    mesh: TetMesh,
    balance: Balance,
    factor: AnchoredFactor,
    loads: ContactTractions,
    recovery: Recovery,
    unit_loads: UnitLoads,
}

impl StressBody {
    /// Assembles and factors the stiffness of a mesh with straight edges.
    ///
    /// # Errors
    /// [`ElastostaticsError`].
    pub fn new(
        mesh: TetMesh,
        constants: &ElasticConstants,
        options: &StressOptions,
    ) -> Result<Self, ElastostaticsError> {
        // Validate the mesh: straight elements, one connected body.
        if mesh.elements.is_empty() {
            return Err(ElastostaticsError::Empty);
        }
        if let Some(element) = (0..mesh.elements.len()).find(|e| is_curved(&mesh.positions(*e))) {
            return Err(ElastostaticsError::Curved { element });
        }
        let parts = mesh.parts();
        if parts != 1 {
            return Err(ElastostaticsError::LooseParts(parts));
        }
        // Contact radius, by default a fraction of the extent.
        let (low, high) = mesh
            .nodes
            .iter()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), x| (low.min(*x), high.max(*x)));
        let radius = options.contact_radius.unwrap_or(0.01 * (high - low).max_element());
        if !(radius >= 0.0 && radius.is_finite()) {
            return Err(ElastostaticsError::ContactRadius(radius));
        }
        // Assembly, balance, factorisation, and the operators of loads and recovery.
        let system = ElasticSystem::new(&mesh, constants);
        let balance = Balance::new(&system, options.reaction);
        let factor = AnchoredFactor::new(&system, &balance)?;
        let loads = ContactTractions::new(&mesh, radius);
        let recovery = Recovery::new(&mesh, constants);
        let unit_loads = UnitLoads::new(loads.vertex_count(), mesh.corners, options.cache_bytes);
        Ok(StressBody { mesh, balance, factor, loads, recovery, unit_loads })
    }

    /// The mesh.
    pub fn mesh(&self) -> &TetMesh {
        &self.mesh
    }

    /// Numbers in the factor, of eight bytes each.
    pub fn factor_entries(&self) -> usize {
        self.factor.entries()
    }

    /// Forces on the nodes \[N\] of a traction \[Pa\] that is given by position and outward normal.
    pub fn traction_forces(&self, traction: impl Fn(DVec3, DVec3) -> DVec3) -> Vec<DVec3> {
        let mut forces = vec![DVec3::ZERO; self.mesh.nodes.len()];
        self.loads.add_traction(traction, &mut forces);
        forces
    }

    /// Forces on the nodes \[N\] of contact forces.
    ///
    /// # Errors
    /// [`ElastostaticsError::Load`].
    pub fn contact_forces(&self, loads: &[PointLoad]) -> Result<Vec<DVec3>, ElastostaticsError> {
        Ok(self.node_forces(&self.vertex_forces(loads)?))
    }

    /// Forces on the nodes of forces on the patches of vertices \[N\].
    fn node_forces(&self, forces: &[(usize, DVec3)]) -> Vec<DVec3> {
        let mut all = vec![DVec3::ZERO; self.mesh.nodes.len()];
        for (vertex, force) in forces {
            for (node, share) in self.loads.patch(*vertex) {
                all[*node as usize] += *force * *share;
            }
        }
        all
    }

    /// Deformation under simultaneous contact forces.
    ///
    /// # Errors
    /// [`ElastostaticsError::Load`].
    pub fn solve(&self, loads: &[PointLoad]) -> Result<Deformation, ElastostaticsError> {
        self.solve_forces(self.contact_forces(loads)?)
    }

    /// Deformation under forces on the nodes \[N\].
    ///
    /// # Errors
    /// [`ElastostaticsError::ForceCount`], [`ElastostaticsError::Load`].
    pub fn solve_forces(&self, mut forces: Vec<DVec3>) -> Result<Deformation, ElastostaticsError> {
        self.check(&forces)?;
        let motion = self.balance.motion(&forces);
        let mut displacement: Vec<f64> = forces.iter().flat_map(|f| f.to_array()).collect();
        self.factor.solve(&mut displacement, &[motion]);
        forces.iter_mut().zip(self.balance.forces_of(motion)).for_each(|(f, r)| *f -= r);
        let mut displacement: Vec<DVec3> = displacement.chunks_exact(3).map(DVec3::from_slice).collect();
        self.balance.remove_rigid_motion(&mut displacement);
        let strain_energy = 0.5 * displacement.iter().zip(&forces).map(|(u, f)| u.dot(*f)).sum::<f64>();
        Ok(Deformation { strain_energy, ..self.recovery.deformation(&self.mesh, displacement) })
    }

    /// Stress and energy of a given displacement of the nodes \[m\].
    ///
    /// # Errors
    /// [`ElastostaticsError::ForceCount`], [`ElastostaticsError::Load`].
    pub fn deformation_of(&self, displacement: Vec<DVec3>) -> Result<Deformation, ElastostaticsError> {
        self.check(&displacement)?;
        Ok(self.recovery.deformation(&self.mesh, displacement))
    }

    /// Checks that there is one finite vector for each node.
    fn check(&self, vectors: &[DVec3]) -> Result<(), ElastostaticsError> {
        let nodes = self.mesh.nodes.len();
        if vectors.len() != nodes {
            return Err(ElastostaticsError::ForceCount { forces: vectors.len(), nodes });
        }
        match vectors.iter().position(|f| !f.is_finite()) {
            Some(index) => Err(ElastostaticsError::Load { index }),
            None => Ok(()),
        }
    }

    /// An upper bound of the largest principal stress under contact forces \[Pa\], without a solve; `None` at
    /// places that were not loaded before.
    ///
    /// # Errors
    /// [`ElastostaticsError::Load`].
    pub fn tension_bound(&self, loads: &[PointLoad]) -> Result<Option<f64>, ElastostaticsError> {
        Ok(self.unit_loads.bound(&self.vertex_forces(loads)?))
    }

    /// Largest principal stress under contact forces, from stored columns. Missing columns are solved and
    /// stored.
    ///
    /// # Errors
    /// [`ElastostaticsError::Load`].
    pub fn maximum_tension(&mut self, loads: &[PointLoad]) -> Result<Tension, ElastostaticsError> {
        let forces = self.vertex_forces(loads)?;
        self.maximum_tension_of(&forces)
    }

    fn maximum_tension_of(&mut self, forces: &[(usize, DVec3)]) -> Result<Tension, ElastostaticsError> {
        if !self.store_missing(forces) {
            return Ok(self.solve_forces(self.node_forces(forces))?.maximum_tension());
        }
        let (corner, stress) = self.unit_loads.maximum(forces);
        let (stress, direction) = stress.largest_with_direction();
        Ok(Tension { stress, corner, direction })
    }

    /// E_S under contact forces \[J\], from stored columns. Missing columns are solved and stored.
    ///
    /// # Errors
    /// [`ElastostaticsError::Load`].
    pub fn strain_energy(&mut self, loads: &[PointLoad]) -> Result<f64, ElastostaticsError> {
        let forces = self.vertex_forces(loads)?;
        match self.store_missing(&forces) {
            true => Ok(self.unit_loads.strain_energy(&forces)),
            false => Ok(self.solve_forces(self.node_forces(&forces))?.strain_energy),
        }
    }

    /// Solves and stores the columns of all loaded vertices; `false` if they do not fit together.
    fn store_missing(&mut self, forces: &[(usize, DVec3)]) -> bool {
        if forces.len() > self.unit_loads.capacity() {
            return false;
        }
        self.unit_loads.touch(forces);
        let missing: Vec<usize> =
            forces.iter().map(|(vertex, _)| *vertex).filter(|v| !self.unit_loads.has(*v)).collect();
        missing.chunks(COLUMNS_TOGETHER / 3).for_each(|some| self.store_columns(some));
        true
    }

    /// Largest principal stress under contact forces if it reaches `strength` \[Pa\], otherwise `None`;
    /// mostly without a solve.
    ///
    /// # Errors
    /// [`ElastostaticsError::Load`].
    pub fn tension_above(
        &mut self,
        loads: &[PointLoad],
        strength: f64,
    ) -> Result<Option<Tension>, ElastostaticsError> {
        let forces = self.vertex_forces(loads)?;
        if self.unit_loads.bound(&forces).is_some_and(|bound| bound < strength) {
            return Ok(None);
        }
        Ok(Some(self.maximum_tension_of(&forces)?).filter(|tension| tension.stress >= strength))
    }

    /// Solves for unit forces on the patches of vertices.
    fn store_columns(&mut self, vertices: &[usize]) {
        let nodes = self.mesh.nodes.len();
        let frames: Vec<DMat3> = vertices.iter().map(|v| self.loads.frame(*v)).collect();
        let mut columns = Vec::with_capacity(9 * vertices.len() * nodes);
        let mut motions = Vec::with_capacity(3 * vertices.len());
        for (vertex, frame) in vertices.iter().zip(&frames) {
            let patch = self.loads.patch(*vertex);
            for axis in 0..3 {
                let mut forces = vec![DVec3::ZERO; nodes];
                patch.iter().for_each(|(node, share)| forces[*node as usize] = frame.col(axis) * *share);
                motions.push(self.balance.motion(&forces));
                columns.extend(forces.iter().flat_map(|f| f.to_array()));
            }
        }
        self.factor.solve(&mut columns, &motions);
        for ((vertex, frame), columns) in vertices.iter().zip(frames).zip(columns.chunks_exact(9 * nodes)) {
            let responses = std::array::from_fn(|axis| {
                let column = &columns[3 * nodes * axis..3 * nodes * (axis + 1)];
                let mut displacement: Vec<DVec3> = column.chunks_exact(3).map(DVec3::from_slice).collect();
                self.balance.remove_rigid_motion(&mut displacement);
                UnitResponse {
                    stress: self.recovery.corner_stress(&self.mesh, &displacement),
                    patches: self.loads.patch_means(&displacement),
                }
            });
            self.unit_loads.store(*vertex, frame, responses);
        }
    }

    /// The forces on the patches of the vertices of the surface, each vertex once.
    fn vertex_forces(&self, loads: &[PointLoad]) -> Result<Vec<(usize, DVec3)>, ElastostaticsError> {
        let mut all: Vec<(usize, DVec3)> = Vec::with_capacity(3 * loads.len());
        for (index, load) in loads.iter().enumerate() {
            let shares = self.loads.shares(load.point).filter(|_| load.force.is_finite());
            let shares = shares.ok_or(ElastostaticsError::Load { index })?;
            all.extend(shares.map(|(vertex, share)| (vertex, load.force * share)));
        }
        all.sort_by_key(|(vertex, _)| *vertex);
        let mut forces: Vec<(usize, DVec3)> = Vec::with_capacity(all.len());
        for (vertex, force) in all {
            match forces.last_mut() {
                Some(last) if last.0 == vertex => last.1 += force,
                _ => forces.push((vertex, force)),
            }
        }
        forces.retain(|(_, force)| *force != DVec3::ZERO);
        Ok(forces)
    }
}

fn is_curved(nodes: &[DVec3; 10]) -> bool {
    crate::mesh::tetrahedra::EDGES.iter().zip(&nodes[4..]).any(|([a, b], middle)| {
        let (a, b) = (nodes[*a], nodes[*b]);
        let off = middle.distance(0.5 * (a + b)) - STRAIGHT * a.distance(b);
        off.is_nan() || off > 0.0
    })
}
