//! An impact between bodies that give way: one force per contact from surfaces, motion and vibration.
//!
//! ```text
//! d_c = −g_c − ∬(W F)_c − Σᵢ φ_ci qᵢ − Y_c ∫F_c + V_c t         approach of contact c [m], overlap > 0
//! q̈ᵢ + 2ξω q̇ᵢ + ω² qᵢ = Σ_c φ_ci F_c                            modes of all bodies, mass-normalised
//! F = max(0, k d^{3/2} + γ(d) ḋ)                                Hertz with losses, or a linear spring
//! γ = α √(k m_∞) d^{1/4} + (3/2) k A √d + κ ((3/2) k)² d        1/m_∞ = W_cc + Σφ²
//! ```
//!
//! The force is constant on a step h, so that rigid motion and modes advance exactly. It is the discrete
//! gradient of the energy of the contact \[Gonzalez1996\] and a damping that is not negative, so that energy
//! never grows, whatever h. Friction obeys Coulomb's law in every step: it sticks by the tangential mobility,
//! modes included, or opposes the slip of this step.
//!
//! ```text
//! Member, MemberContact ─► ContactSystem ─► solve(StepSettings, SolverMemory) ─► ContactSolution
//! ```
//!
//! Normals, points and inertias stay as they are at t₀. Not covered: plastic deformation, adhesion, the
//! gyroscopic torque ω × Iω, the compliance of friction itself.

mod compliant_error;
mod contact_law;
mod contact_rows;
mod contact_system;
mod end_rule;
mod energy_balance;
mod few_modes;
mod friction;
mod half_space;
mod member;
mod modal_propagator;
mod modal_tail;
mod restitution_damping;
mod solution;
mod solver;
mod step_forces;
mod validation;

pub use compliant_error::CompliantContactError;
pub use contact_law::{ContactLaw, HertzLaw, hertz_duration};
pub use contact_system::ContactSystem;
pub use energy_balance::EnergyBalance;
pub use half_space::{HalfSpaceLoss, half_space_loss, half_space_radiation};
pub use member::{Member, MemberContact, StepSettings};
pub use modal_tail::{ModalTail, modal_tail};
pub use restitution_damping::{restitution_damping, viscosity};
pub use solution::{ContactEnd, ContactSolution};
pub use solver::SolverMemory;
pub use validation::MAX_CONTACTS;
