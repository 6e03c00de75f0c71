//! Fracture settings of a body: the table `fracture` of a `[[body]]`.
//!
//! Strength and toughness are the material's: `tensile_strength` and `fracture_energy`.

use glam::DVec3;

/// Fracture settings of a body.
#[derive(Clone, Debug, PartialEq)]
pub struct Breaking {
    /// Largest edge length of the tetrahedra of the stress solution \[m\]; `None`: chosen from the size of
    /// the body.
    pub edge: Option<f64>,
    /// Seed of the crack pattern; `None`: derived from the simulation's seed and the number of the body.
    pub seed: Option<u64>,
    /// Edge of the cube with the volume of the smallest piece allowed \[m\]; `None`: a tenth of the edge of
    /// the cube with the volume of the body.
    pub smallest_piece: Option<f64>,
    /// Largest number of pieces of the body, pieces of pieces included.
    pub most_pieces: usize,
    /// Whether the remaining strain energy accelerates the pieces apart.
    pub crack_impulses: bool,
    /// Force that balances the contact forces on a free body in the stress solution.
    pub reaction: Reaction,
    /// Force of an impact.
    pub load: Load,
    /// Scored planes. A scored body breaks along these planes only.
    pub scores: Vec<Score>,
}

impl Breaking {
    /// Default of the largest number of pieces.
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
            load: Load::History,
            scores: Vec::new(),
        }
    }
}

/// Balance of the contact forces on a free body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Reaction {
    /// The inertia of its mass: f − M T (TᵀMT)⁻¹ Tᵀ f.
    #[default]
    InertiaRelief,
    /// An equal force at each node: f − Q Qᵀ f, as \[FRAC\] App. B prints it. It depends on the mesh.
    LeastResidual,
}

/// Force of an impact of impulse j.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Load {
    /// Force and stored energy at every instant of the solved contact; the peak of the half-sine where
    /// bodies do not give way in impacts.
    History,
    /// The peak of the contact's half-sine: (π/2) j/τ.
    HalfSinePeak,
    /// j/Δt, as in \[FRAC\]. Stress and fracture then depend on the time step.
    Step,
}

/// A plane along which a body is scored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Score {
    /// A point of the plane \[m\], in the frame of the body, about its centre of mass.
    pub point: DVec3,
    /// Its unit normal, in the frame of the body.
    pub normal: DVec3,
    /// Depth of the scratch \[m\], at whose bottom stress concentrates. 0 for none.
    pub depth: f64,
}
