//! Members and contacts of an impact, checked and arranged for stepping.

use std::ops::Range;

use glam::DVec3;
use num_complex::Complex64;

use super::compliant_error::CompliantContactError;
use super::contact_law::{ContactLaw, StepLaw, hertz_duration};
use super::contact_rows::{ContactRow, RigidMember};
use super::few_modes::{FEW, MANY_ROWS};
use super::member::{Member, MemberContact};
use super::modal_propagator::LANES;
use super::validation::check;

/// What a contact is, apart from its rows.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct SystemContact {
    pub(super) law: ContactLaw,
    pub(super) gap: f64,
    pub(super) friction: f64,
    pub(super) standing: bool,
    /// First the normal, then with friction two tangents.
    pub(super) rows: Range<usize>,
    /// m_∞ \[kg\].
    pub(super) mass: f64,
    /// Normal from B to A, and two tangents.
    pub(super) axes: [DVec3; 3],
}

/// The modes of a member, and the rows that drive them.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MemberModes {
    /// Among all modes, padded.
    pub(super) own: Range<usize>,
    /// Without padding.
    pub(super) count: usize,
    /// Among [`ContactSystem::driven`].
    pub(super) driven: Range<usize>,
    /// Among [`ContactSystem::shapes`]: one after another for each driven row.
    pub(super) shapes: Range<usize>,
    /// Among [`ContactSystem::across`]: one after another for each mode; empty where modes are many.
    pub(super) across: Range<usize>,
}

/// An impact ready to be solved. It can be refilled without new memory.
#[derive(Clone, Debug, Default)]
pub struct ContactSystem {
    pub(super) members: Vec<RigidMember>,
    pub(super) contacts: Vec<SystemContact>,
    pub(super) rows: Vec<ContactRow>,
    /// W of all pairs of rows [1/kg].
    pub(super) rigid: Vec<f64>,
    /// Poles and states w of all modes, padded with zeros.
    pub(super) poles: Vec<Complex64>,
    pub(super) states: Vec<Complex64>,
    pub(super) modes: Vec<MemberModes>,
    /// Rows that drive modes, grouped by member, and their shapes: displacement along the row [kg^−½].
    pub(super) driven: Vec<usize>,
    pub(super) shapes: Vec<f64>,
    /// The shapes of members with few modes, at all their driven rows.
    pub(super) across: Vec<f64>,
}

impl ContactSystem {
    /// Checks and arranges an impact.
    ///
    /// # Errors
    ///
    /// With numbers that are not finite or out of range, members that do not exist, or more than
    /// [`MAX_CONTACTS`](super::MAX_CONTACTS) contacts.
    pub fn new(members: &[Member], contacts: &[MemberContact]) -> Result<Self, CompliantContactError> {
        let mut system = ContactSystem::default();
        system.replace(members, contacts)?;
        Ok(system)
    }

    /// Replaces the impact by another one, in the same memory if that is large enough.
    ///
    /// # Errors
    ///
    /// As [`ContactSystem::new`]; the system is then empty.
    pub fn replace(
        &mut self,
        members: &[Member],
        contacts: &[MemberContact],
    ) -> Result<(), CompliantContactError> {
        self.contacts.clear();
        check(members, contacts)?;
        self.members.clear();
        self.members.extend(members.iter().map(RigidMember::new));
        self.place_rows(members, contacts);
        self.place_modes(members, contacts);
        self.couple();
        let weighed = self.weigh_contacts();
        if weighed.is_err() {
            self.contacts.clear();
        }
        weighed
    }

    fn place_rows(&mut self, members: &[Member], contacts: &[MemberContact]) {
        self.contacts.clear();
        self.rows.clear();
        for contact in contacts {
            let normal = contact.normal.normalize();
            let (first, second) = normal.any_orthonormal_pair();
            let axes = [normal, first, second];
            let begin = self.rows.len();
            let count = if contact.friction > 0.0 { 3 } else { 1 };
            self.rows.extend(axes[..count].iter().map(|axis| ContactRow::new(contact, *axis, members)));
            self.contacts.push(SystemContact {
                law: contact.law,
                gap: contact.gap,
                friction: contact.friction,
                standing: contact.standing || matches!(contact.law, ContactLaw::Spring { .. }),
                rows: begin..self.rows.len(),
                mass: f64::INFINITY,
                axes,
            });
        }
    }

    fn place_modes(&mut self, members: &[Member], contacts: &[MemberContact]) {
        self.poles.clear();
        self.states.clear();
        self.modes.clear();
        self.driven.clear();
        self.shapes.clear();
        self.across.clear();
        for (index, member) in members.iter().enumerate() {
            let (begin, count) = (self.poles.len(), member.poles.len());
            let end = begin + count.next_multiple_of(LANES);
            self.poles.extend_from_slice(&member.poles);
            self.poles.resize(end, Complex64::ZERO);
            self.states.extend_from_slice(&member.state);
            self.states.resize(end, Complex64::ZERO);
            let (driven, shapes) = (self.driven.len(), self.shapes.len());
            for (contact, placed) in contacts.iter().zip(&self.contacts) {
                let Some(at) = contact.members.iter().position(|m| *m == Some(index)) else { continue };
                if contact.shapes[at].is_empty() {
                    continue;
                }
                let sign = if at == 0 { 1.0 } else { -1.0 };
                for (row, axis) in placed.rows.clone().zip(placed.axes) {
                    self.driven.push(row);
                    let from = self.shapes.len();
                    self.shapes.extend(contact.shapes[at].iter().map(|shape| sign * shape.dot(axis)));
                    self.shapes.resize(from + end - begin, 0.0);
                }
            }
            let across = self.across.len();
            if count <= FEW && self.driven.len() - driven >= MANY_ROWS {
                let of_mode =
                    |mode: usize| self.shapes[shapes..].iter().skip(mode).step_by((end - begin).max(1));
                self.across.extend((0..count).flat_map(of_mode));
            }
            self.modes.push(MemberModes {
                own: begin..end,
                count,
                driven: driven..self.driven.len(),
                shapes: shapes..self.shapes.len(),
                across: across..self.across.len(),
            });
        }
    }

    fn couple(&mut self) {
        self.rigid.clear();
        for row in &self.rows {
            self.rigid.extend(self.rows.iter().map(|other| row.coupling(other, &self.members)));
        }
    }

    /// The mass that moves at first: 1/m_∞ = W_cc + Σφ².
    fn weigh_contacts(&mut self) -> Result<(), CompliantContactError> {
        for contact in 0..self.contacts.len() {
            let row = self.contacts[contact].rows.start;
            let inverse = self.rigid[row * (self.rows.len() + 1)]
                + self
                    .shapes_of(row)
                    .fold(0.0, |sum, (_, shape)| sum + shape.iter().map(|phi| phi * phi).sum::<f64>());
            if !(inverse > 0.0 && inverse.is_finite()) {
                return Err(CompliantContactError::Contact {
                    contact,
                    what: "inverse mass behind the contact",
                    value: inverse,
                    wanted: "finite and positive",
                });
            }
            self.contacts[contact].mass = 1.0 / inverse;
        }
        Ok(())
    }

    /// Modes that a row drives, with its shape of each.
    pub(super) fn shapes_of(&self, row: usize) -> impl Iterator<Item = (Range<usize>, &[f64])> {
        self.modes.iter().flat_map(move |modes| {
            let rows = self.driven[modes.driven.clone()].iter();
            let shapes = self.shapes[modes.shapes.clone()].chunks_exact(modes.own.len().max(1));
            rows.zip(shapes).filter(move |(driven, _)| **driven == row).map(|(_, s)| (modes.own.clone(), s))
        })
    }

    /// τ_∞ \[s\]: the least Hertz duration, with m_∞, of the contacts that come together.
    ///
    /// The speed of a contact is that of its approach, what its overlap stores, and the mean square speed of
    /// the vibration. Standing contacts count only if no other comes together, springs by half a period.
    /// `None` if nothing touches or approaches.
    pub fn first_duration(&self) -> Option<f64> {
        let least = |standing: bool| {
            let contacts = self.contacts.iter().filter(|contact| contact.standing == standing);
            contacts.filter_map(|contact| self.duration_of(contact)).reduce(f64::min)
        };
        least(false).or_else(|| least(true))
    }

    fn duration_of(&self, contact: &SystemContact) -> Option<f64> {
        let ContactLaw::Hertz(law) = contact.law else {
            let ContactLaw::Spring { stiffness, .. } = contact.law else { return None };
            return Some(std::f64::consts::PI * (contact.mass / stiffness).sqrt());
        };
        let row = contact.rows.start;
        let (mut displacement, mut vibration) = (0.0, 0.0);
        for (own, shape) in self.shapes_of(row) {
            let modes = shape.iter().zip(&self.states[own.clone()]).zip(&self.poles[own]);
            for ((phi, w), pole) in modes.filter(|(_, pole)| pole.im > 0.0) {
                displacement += phi * w.im / pole.im;
                vibration += 0.5 * phi * phi * w.norm_sqr();
            }
        }
        let approach = (-self.rows[row].velocity(&self.members)).max(0.0) + vibration.sqrt();
        let stored = StepLaw::new(&contact.law, contact.mass, 1.0).stored(-contact.gap - displacement);
        let speed = (approach * approach + 2.0 * stored / contact.mass).sqrt();
        let duration = hertz_duration(1.0 / contact.mass, law.stiffness, speed);
        (speed > 0.0 && duration > 0.0 && duration.is_finite()).then_some(duration)
    }
}
