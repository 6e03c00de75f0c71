//! Reaction that balances the forces on a free body.
//!
//! ```text
//! f − W T (TᵀW T)⁻¹ Tᵀ f,    u − T (TᵀW T)⁻¹ Tᵀ W u,    T the six rigid motions at the nodes
//! ```
//!
//! With the mass for W it is inertia: the body accelerates rigidly, and each part takes its share of the
//! force. With W = 1 it is the projection P = I − Q Qᵀ of \[FRAC\] App. B, which distributes the reaction
//! equally over the nodes, hence more of it where the mesh is fine.
//!
//! Differs from \[FRAC\]: T is orthogonalised about the centre of W in closed form instead of by a QR
//! factorisation.

use glam::{DMat3, DVec3};

use super::Reaction;
use crate::fem::ElasticSystem;

/// A rigid motion about the centre.
#[derive(Clone, Copy)]
pub(super) struct Motion {
    pub(super) along: DVec3,
    pub(super) about: DVec3,
}

impl Motion {
    /// Unit motions along and about x, y, z.
    pub(super) fn units() -> [Self; 6] {
        let axes = [DVec3::X, DVec3::Y, DVec3::Z];
        std::array::from_fn(|k| match k {
            0..3 => Motion { along: axes[k], about: DVec3::ZERO },
            _ => Motion { along: DVec3::ZERO, about: axes[k - 3] },
        })
    }

    pub(super) fn to_array(self) -> [f64; 6] {
        let (a, b) = (self.along, self.about);
        [a.x, a.y, a.z, b.x, b.y, b.z]
    }
}

/// W of a mesh, by its products with translations and rotations.
pub(super) struct Balance {
    /// Positions about the centre \[m\].
    arms: Vec<DVec3>,
    /// Rows of W times 1.
    weights: Vec<f64>,
    /// Rows of W times the arms.
    moments: Vec<DVec3>,
    total: f64,
    inverse_inertia: DMat3,
}

impl Balance {
    pub(super) fn new(system: &ElasticSystem, reaction: Reaction) -> Self {
        let count = system.node_count();
        let weigh = |x: &[f64]| match reaction {
            Reaction::InertiaRelief => {
                let mut y = vec![0.0; x.len()];
                system.multiply_mass(x, 1, &mut y);
                y
            }
            Reaction::LeastResidual => x.to_vec(),
        };
        let weights: Vec<f64> = weigh(&vec![1.0; 3 * count]).into_iter().step_by(3).collect();
        let total: f64 = weights.iter().sum();
        let nodes = system.nodes();
        let centre = weights.iter().zip(nodes).map(|(w, x)| *x * *w).sum::<DVec3>() / total;
        let arms: Vec<DVec3> = nodes.iter().map(|x| *x - centre).collect();
        let flat: Vec<f64> = arms.iter().flat_map(|x| x.to_array()).collect();
        let moments: Vec<DVec3> = weigh(&flat).chunks_exact(3).map(DVec3::from_slice).collect();
        let mut inertia = DMat3::ZERO;
        for (x, s) in arms.iter().zip(&moments) {
            let outer = DMat3::from_cols(*x * s.x, *x * s.y, *x * s.z);
            inertia += DMat3::from_diagonal(DVec3::splat(x.dot(*s))) - 0.5 * (outer + outer.transpose());
        }
        Balance { arms, weights, moments, total, inverse_inertia: inertia.inverse() }
    }

    /// Rigid motion due to forces: the acceleration along and about each axis, if W is the mass.
    pub(super) fn motion(&self, forces: &[DVec3]) -> Motion {
        let force: DVec3 = forces.iter().sum();
        let torque: DVec3 = self.arms.iter().zip(forces).map(|(x, f)| x.cross(*f)).sum();
        Motion { along: force / self.total, about: self.inverse_inertia * torque }
    }

    /// The forces W T a of a motion.
    pub(super) fn forces_of(&self, motion: Motion) -> impl Iterator<Item = DVec3> {
        self.weights.iter().zip(&self.moments).map(move |(w, s)| motion.along * *w + motion.about.cross(*s))
    }

    /// Removes the rigid motion from a displacement.
    pub(super) fn remove_rigid_motion(&self, displacement: &mut [DVec3]) {
        let push =
            self.weights.iter().zip(displacement.iter()).map(|(w, u)| *u * *w).sum::<DVec3>() / self.total;
        let turn: DVec3 = self.moments.iter().zip(displacement.iter()).map(|(s, u)| s.cross(*u)).sum();
        let turn = self.inverse_inertia * turn;
        for (u, x) in displacement.iter_mut().zip(&self.arms) {
            *u -= push + turn.cross(*x);
        }
    }
}
