//! Timeline: contacts, poses and fractures over time, the interface between dynamics and sound.
//!
//! Solvers, importers and hand-written lists produce the same rows; sound synthesis has no other input. A
//! timeline may also carry the forces of its impacts ([`ForceRow`]), which otherwise follow from its rows.

mod force_row;

use std::collections::BTreeSet;

pub use force_row::{FORCE_REACH, FORCE_STEPS, ForceProblem, ForceRow};
use glam::{DQuat, DVec3};

use crate::body::{Body, BodyId};

/// Kind of a contact row.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
pub enum ContactKind {
    /// An impulse that changed velocities at an instant.
    Impact = 0,
    /// Resting, sliding or rolling contact, integrated over a time step.
    Contact = 1,
    /// A rod, spring or other link, integrated over a time step.
    Constraint = 2,
    /// The release of a crack.
    Fracture = 3,
    /// Momentum removed from a body when it falls asleep.
    Sleep = 4,
}

impl ContactKind {
    /// The kind with this number in a file.
    pub fn from_code(code: u8) -> Option<Self> {
        use ContactKind::*;
        [Impact, Contact, Constraint, Fracture, Sleep].into_iter().find(|k| *k as u8 == code)
    }
}

/// One point of one contact at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactRow {
    /// Time \[s\].
    pub time: f64,
    /// The body on which the impulse acts as written.
    pub body_a: BodyId,
    /// The body on which its opposite acts; [`BodyId::WORLD`] if none.
    pub body_b: BodyId,
    /// Kind of the row.
    pub kind: ContactKind,
    /// Contact point \[m\], world.
    pub point: DVec3,
    /// Unit normal, from B to A.
    pub normal: DVec3,
    /// Normal impulse on A \[N s\], along `normal`.
    pub impulse_n: f64,
    /// Tangential impulse on A \[N s\], world.
    pub impulse_t: DVec3,
    /// Couple impulse on A \[N m s\], world: rolling and spinning loss.
    pub couple: DVec3,
    /// Velocity of A relative to B at the point before the impulse \[m/s\]; approach is negative along
    /// `normal`.
    pub velocity: DVec3,
    /// Overlap \[m\]; negative for a gap.
    pub depth: f64,
    /// Impact id, shared by the rows of one impact; 0 for rows outside impacts.
    pub impact_id: u64,
    /// Effective mass \[kg\] of A and B against each other along `normal` at the point; `None` for that of
    /// the bodies alone. Links on joints have a larger one: 1/(nᵀ J M⁻¹ Jᵀ n), with the mass matrix M of the
    /// joints and the Jacobian J of the relative velocity at the point.
    pub effective_mass: Option<f64>,
}

impl ContactRow {
    /// Total impulse on A \[N s\].
    pub fn impulse(&self) -> DVec3 {
        self.normal * self.impulse_n + self.impulse_t
    }

    /// Approach speed of the surfaces \[m/s\]; 0 if they separate.
    pub fn approach_speed(&self) -> f64 {
        (-self.velocity.dot(self.normal)).max(0.0)
    }
}

/// State of a body at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseRow {
    /// Time \[s\].
    pub time: f64,
    /// The body.
    pub body: BodyId,
    /// Centre of mass \[m\].
    pub position: DVec3,
    /// Rotation from body to world, unit.
    pub orientation: DQuat,
    /// Velocity of the centre of mass \[m/s\].
    pub velocity: DVec3,
    /// Angular velocity \[rad/s\], world.
    pub angular_velocity: DVec3,
}

/// Fracture of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FractureRow {
    /// Time \[s\]: death of the parent and birth of the pieces.
    pub time: f64,
    /// The body that broke.
    pub parent: BodyId,
    /// The first piece; the others follow it.
    pub first_child: BodyId,
    /// Number of pieces.
    pub children: u32,
    /// Energy ½ m V² of the impacts that broke it \[J\].
    pub impact_energy: f64,
    /// Strain energy in the parent \[J\].
    pub strain_energy: f64,
    /// Energy of the new surfaces \[J\].
    pub fracture_energy: f64,
    /// Kinetic energy that the impulses of the cracks gave to the pieces \[J\].
    pub kinetic_energy_gain: f64,
    /// Area of the cracks, each counted once \[m²\].
    pub crack_area: f64,
    /// Duration of the impulses of the cracks \[s\].
    pub duration: f64,
    /// Seed of the crack pattern.
    pub seed: u64,
}

impl FractureRow {
    /// A fracture of `parent` whose other fields are zero.
    pub const fn of(parent: BodyId) -> Self {
        FractureRow {
            time: 0.0,
            parent,
            first_child: BodyId(0),
            children: 0,
            impact_energy: 0.0,
            strain_energy: 0.0,
            fracture_energy: 0.0,
            kinetic_energy_gain: 0.0,
            crack_area: 0.0,
            duration: 0.0,
            seed: 0,
        }
    }

    /// The pieces.
    pub fn pieces(&self) -> impl Iterator<Item = BodyId> + use<> {
        (self.first_child.0..self.first_child.0.saturating_add(self.children)).map(BodyId)
    }
}

/// Receiver of the rows of a simulation: memory, or a file.
///
/// Rows come in order of time within each kind, up to the merging window of impacts (0.5 ms). The force of an
/// impact may begin a little before its time, and lasts up to [`FORCE_REACH`].
pub trait TimelineSink {
    /// Takes a contact row.
    fn contact(&mut self, row: &ContactRow) -> std::io::Result<()>;
    /// Takes a pose row.
    fn pose(&mut self, row: &PoseRow) -> std::io::Result<()>;
    /// Takes a fracture and the pieces, before any row that names one of them. The first has the id
    /// `row.first_child`, which is the number of bodies so far.
    fn fracture(&mut self, row: &FractureRow, children: &[Body]) -> std::io::Result<()>;
}

/// A timeline in memory.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Timeline {
    /// Contacts, in order of time.
    pub contacts: Vec<ContactRow>,
    /// Poses, in order of time.
    pub poses: Vec<PoseRow>,
    /// Fractures, in order of time.
    pub fractures: Vec<FractureRow>,
    /// Bodies born after the beginning, in the order of their ids, which follow those of the world.
    pub births: Vec<Body>,
    /// Forces of impacts over time, in order of time; empty for none.
    pub forces: Vec<ForceRow>,
}

impl Timeline {
    /// The numbers of the impacts.
    pub fn impacts(&self) -> BTreeSet<u64> {
        self.contacts.iter().map(|row| row.impact_id).filter(|id| *id != 0).collect()
    }

    /// All bodies at any time: those of the world at the beginning, `start`, then those born later, each with
    /// its complete span of existence.
    pub fn all_bodies(&self, start: &[Body]) -> Vec<Body> {
        let mut bodies = [start, &self.births].concat();
        for fracture in &self.fractures {
            if let Some(parent) = bodies.get_mut(fracture.parent.index()) {
                parent.life.death = fracture.time;
            }
        }
        bodies
    }
}

impl TimelineSink for Timeline {
    fn contact(&mut self, row: &ContactRow) -> std::io::Result<()> {
        self.contacts.push(*row);
        Ok(())
    }

    fn pose(&mut self, row: &PoseRow) -> std::io::Result<()> {
        self.poses.push(*row);
        Ok(())
    }

    fn fracture(&mut self, row: &FractureRow, children: &[Body]) -> std::io::Result<()> {
        // Only the number of bodies at the beginning is known.
        let start = row.first_child.index().saturating_sub(self.births.len());
        let born = row.parent.index().checked_sub(start);
        if let Some(parent) = born.and_then(|at| self.births.get_mut(at)) {
            parent.life.death = row.time;
        }
        self.fractures.push(*row);
        self.births.extend_from_slice(children);
        Ok(())
    }
}
