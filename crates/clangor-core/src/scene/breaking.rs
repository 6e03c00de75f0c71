//! Whether a body may break, and how its fracture is computed: what a scene says under `fracture` of a
//! `[[body]]`.
//!
//! Strength and toughness are the material's: `tensile_strength` and `fracture_energy`.

use glam::DVec3;

/// How a body breaks.
#[derive(Clone, Debug, PartialEq)]
pub struct Breaking {
    /// Longest edges of the tetrahedra in which stress is sought \[m\]; `None`: what suits the body.
    pub edge: Option<f64>,
    /// Seed of the crack pattern; `None`: the simulation's, with the number of the body mixed in.
    pub seed: Option<u64>,
    /// Edge of the cube that is as large as the smallest piece allowed \[m\]; `None`: a tenth of the cube as
    /// large as the body.
    pub smallest_piece: Option<f64>,
    /// Most pieces that the body and its pieces may fall into.
    pub most_pieces: usize,
    /// Whether what is left of the strain energy drives the pieces apart.
    pub crack_impulses: bool,
    /// What holds a free body while its stress is computed.
    pub reaction: Reaction,
    /// Which force an impulse stands for.
    pub load: Load,
    /// Where the body is scored. A scored body breaks along these planes and nowhere else.
    pub scores: Vec<Score>,
}

impl Breaking {
    /// Most pieces, unless the scene names another number.
    pub const MOST_PIECES: usize = 400;
}

impl Default for Breaking {
    fn default() -> Self {
        Breaking {
            edge: None,
            seed: None,
            smallest_piece: None,
            most_pieces: Self::MOST_PIECES,
            crack_impulses: true,
            reaction: Reaction::InertiaRelief,
            load: Load::HalfSinePeak,
            scores: Vec::new(),
        }
    }
}

/// What balances the contact forces on a free body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Reaction {
    /// The inertia of its mass: f − M T (TᵀMT)⁻¹ Tᵀ f.
    #[default]
    InertiaRelief,
    /// An equal force at each node: f − Q Qᵀ f, as \[FRAC\] App. B prints it. It depends on the mesh.
    LeastResidual,
}

/// The force that an impulse j stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Load {
    /// The peak of the contact's half-sine: (π/2) j/τ.
    HalfSinePeak,
    /// j/Δt, as \[FRAC\] has it. Stress and what becomes of the body depend on the step.
    Step,
}

/// A plane along which a body has been scored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Score {
    /// A point of the plane \[m\], in the frame of the body, about its centre of mass.
    pub point: DVec3,
    /// Its unit normal, in the frame of the body.
    pub normal: DVec3,
    /// How deep the scratch is \[m\]: stress concentrates at its bottom. 0 for none.
    pub depth: f64,
}
