//! Plain data of an impact: bodies, their contacts, and how to step.

use glam::{DMat3, DVec3};
use num_complex::Complex64;

use super::contact_law::ContactLaw;

/// A body that takes part in an impact, at the instant t₀.
#[derive(Clone, Debug, PartialEq)]
pub struct Member {
    /// 1/m [1/kg]; 0 for a body that is held.
    pub inverse_mass: f64,
    /// I⁻¹ in world axes [1/(kg m²)], symmetric.
    pub inverse_inertia: DMat3,
    /// Centre of mass \[m\].
    pub centre: DVec3,
    /// Velocity of the centre of mass [m/s].
    pub velocity: DVec3,
    /// Angular velocity [rad/s].
    pub angular_velocity: DVec3,
    /// Constant acceleration by gravity [m/s²]; zero for a body that is held.
    pub acceleration: DVec3,
    /// λ = −ξω + iω_d of the modes [1/s], those of a tail included. Empty for a rigid body.
    pub poles: Vec<Complex64>,
    /// w = q̇ − λ̄q of each mode at t₀ [m kg^½/s]; empty for modes at rest.
    pub state: Vec<Complex64>,
}

/// A contact between two members, or of one with something immovable.
#[derive(Clone, Debug, PartialEq)]
pub struct MemberContact {
    /// Indices of the bodies A and B; `None` is immovable.
    pub members: [Option<usize>; 2],
    /// Point of contact \[m\].
    pub point: DVec3,
    /// Unit normal from B to A.
    pub normal: DVec3,
    /// Velocity of A relative to B at the point that the members' velocities do not contain [m/s]: of a
    /// description that knows the approach of its points and not the motion of its bodies.
    pub velocity: DVec3,
    /// Force law.
    pub law: ContactLaw,
    /// Gap between the surfaces at t₀ without vibration \[m\]; negative where they overlap, as the preload of
    /// a standing contact has it.
    pub gap: f64,
    /// Coulomb's coefficient of friction μ; 0 for a spring.
    pub friction: f64,
    /// A contact that carries load before and after the impact: it does not keep the solve from ending. A
    /// spring always is one.
    pub standing: bool,
    /// Uᵢ of each body's modes at the point, in world axes [kg^−½]; empty without modes.
    pub shapes: [Vec<DVec3>; 2],
}

/// How to step through an impact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepSettings {
    /// Steps per first duration τ_∞ of the
    /// [system](super::ContactSystem::first_duration).
    pub steps_per_duration: f64,
    /// Length of a step \[s\], if it is not to follow from the first duration.
    pub step: Option<f64>,
    /// Most steps; whatever touches then, touches still.
    pub max_steps: usize,
    /// Whether to end once the bodies have parted for good. Otherwise `max_steps` are made.
    pub end_when_parted: bool,
    /// A contact that gravity closes again within this time, in first durations, has not parted.
    pub return_durations: f64,
    /// Longest time without a force \[s\]: what comes after it is another impact.
    pub longest_flight: f64,
    /// Whether to compute what the damping of the modes takes. It costs another pass per step.
    pub modal_loss: bool,
    /// Whether to keep the energy stored in contacts and modes after every step. It costs another pass.
    pub stored_energy: bool,
}

impl Default for StepSettings {
    fn default() -> Self {
        StepSettings {
            steps_per_duration: 16.0,
            step: None,
            max_steps: 65_536,
            end_when_parted: true,
            return_durations: 2.0,
            longest_flight: f64::INFINITY,
            modal_loss: false,
            stored_energy: false,
        }
    }
}
