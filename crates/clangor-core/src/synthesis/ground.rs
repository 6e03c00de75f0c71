//! The sound of the ground under an impact: an elastic half-space, pressed at a point of its surface,
//! radiates.
//!
//! ```text
//! p(x, t) = ρ/2π ∫ a(y, t − |x−y|/c) / |x−y| dS          Rayleigh's integral
//! a: normal acceleration of the surface (Lamb's problem), the half-space under a vertical point force F(t)
//! ```
//!
//! as in Qu and James, *On the Impact of Ground Sound*, DAFx 2019. By horizontal slowness P, in units of 1/c,
//! this is
//!
//! ```text
//! p(ω) = ρ/(2πμ) ω² F(ω) I(ωR/c, θ)
//! I(x, θ) = ∫₀^∞ f(P) J₀(x P sin θ) e^{−i x √(1−P²) cos θ} P dP / (i √(1−P²))
//! f(P) = −n² √(P²−m²) / ((2P²−n²)² − 4P² √(P²−m²) √(P²−n²)),   n = c/c_S,  m = c/c_P
//! ```
//!
//! with R and θ the distance of the listener from the point and its angle from the normal, μ the shear
//! modulus. Nothing but the dimensionless f depends on the solid, and nothing has a length of its own: one
//! solid and one medium are one [`GroundSource`], for all places and frequencies.
//!
//! The method of integration is new here. f is written as a sum of poles in P² ([`poles`]), most of them off
//! the axis. Each pole is a surface wave: one is Rayleigh's, the others represent body waves along the
//! surface. The pressure of one surface wave above the surface has a closed form but for one quadrature,
//! which all listeners share ([`direction`]). Impacts blend stored directions. Each direction consists of a
//! wave from the point of contact and waves shed by the surface (Mach fronts, if faster than sound), each
//! e^{−ixt} times an amplitude smooth in log x.
//!
//! Differs from Qu and James, who smooth the force in time and sum the integral over the surface: their sum
//! is [`rayleigh_integral`](rayleigh_integral()), which the tests compare.
//!
//! A plane of finite thickness is a plate instead ([`plate`]).
//!
//! The ground models of the papers are in [`reference`](crate::reference).
//!
//! Not covered: horizontal forces; losses in the ground, its layers, roughness and edges; the load of the air
//! on the ground. The force acts at a point, which is right while the contact patch is small against the
//! wavelengths in the ground.

pub mod direction;
mod directions;
pub mod half_space;
pub mod model;
pub mod plate;
mod plate_waves;
pub mod poles;
pub mod pulses;
pub mod rayleigh_integral;
pub mod source;
pub(super) mod spectrum;

pub use half_space::{GroundError, HalfSpace};
pub use model::Ground;
pub use plate::PlateSource;
pub use pulses::ground_clicks;
pub use rayleigh_integral::rayleigh_integral;
pub use source::GroundSource;
