//! What happened: contacts and poses over time, the waist between dynamics and sound.
//!
//! Our own solvers, an importer and a hand-written list produce the same rows; sound reads nothing else.

use glam::{DQuat, DVec3};

use crate::body::BodyId;

/// What a contact row records.
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
    /// The last momentum taken from a body that falls asleep.
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
    /// What the row records.
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
    /// Velocity of A relative to B at the point before the impulse \[m/s\]; approach is negative along `normal`.
    pub velocity: DVec3,
    /// Overlap \[m\]; negative for a gap.
    pub depth: f64,
    /// Shared by the rows of one impact; 0 for rows that belong to none.
    pub impact_id: u64,
}

impl ContactRow {
    /// Whole impulse on A \[N s\].
    pub fn impulse(&self) -> DVec3 {
        self.normal * self.impulse_n + self.impulse_t
    }

    /// Speed at which the surfaces approached \[m/s\]; 0 if they parted.
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

/// Where a simulation puts its rows as they happen: memory, or a file.
///
/// Rows come in order of time within each kind, up to the merging window of impacts (0.5 ms).
pub trait TimelineSink {
    /// Takes a contact row.
    fn contact(&mut self, row: &ContactRow) -> std::io::Result<()>;
    /// Takes a pose row.
    fn pose(&mut self, row: &PoseRow) -> std::io::Result<()>;
}

/// A timeline in memory.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Timeline {
    /// Contacts, in order of time.
    pub contacts: Vec<ContactRow>,
    /// Poses, in order of time.
    pub poses: Vec<PoseRow>,
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
}
