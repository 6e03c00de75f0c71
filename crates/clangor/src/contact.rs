//! From impulses to forces: how long a collision lasts, and how its force runs over that time (\[PAN\] §3).
//!
//! ```text
//! rows of an impact ─► effective mass, local radii, speed ─► duration τ (Hertz) ─► force profile ─► pulse per body
//! ```

pub mod effective_mass;
pub mod force_profile;
pub mod hertz;
pub mod local_curvature;
