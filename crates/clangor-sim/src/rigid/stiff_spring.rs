//! Springs that oscillate faster than a step follows, solved with the joints by backward Euler.
//!
//! A spring of stiffness k and damping c whose ends have the inverse effective mass w is an oscillator of
//! ω² = k w. Where ω Δt > 1, or c w Δt > 1, it is a row of its linkage that gives way: with its extension e
//! now and e⁺ at the middle of the next step, the impulse along it is
//!
//! `λ = −Δt k e⁺ − c (e⁺ − e)`, so `e⁺ + (λ − c e) / (k Δt + c) = 0`,
//!
//! which joints have with a right-hand side of zero, and A = J M⁻¹ Jᵀ has `1 / (Δt (k Δt + c))` more on its
//! diagonal (Lacoursière 2007; XPBD, Macklin, Müller and Chentanez 2016). Loads stretch it by exactly F/k.
//! Across itself a spring under tension resists with `k (1 − l₀/l)`: two rows more, where a step does not
//! follow that either. Without a rest length it is an isotropic oscillator.
//!
//! What it is not: the vibration itself. Backward Euler never adds energy, and takes that of oscillations
//! that the step does not resolve: `1/√(1 + ω² Δt²)` of the amplitude is left after a step. Springs so
//! strained that their directions turn by large angles within a step are an error.

use clangor_core::body::{BodyId, Link, LinkEnd};
use glam::DVec3;

use super::manifold::tangents;
use super::state::BodyState;

/// Across a spring, oscillations of (ω Δt)² below this are left to its direction, which turns from step to
/// step.
const FOLLOWED: f64 = 0.1;

/// Springs of one body are followed together up to this sum of (ω Δt)² + 2 c w Δt; the bound of stability is
/// 4.
const TOGETHER: f64 = 0.5;

/// The law of a spring that is solved implicitly.
#[derive(Clone, Copy)]
pub(super) struct StiffSpring {
    /// Length without force \[m\].
    pub(super) rest_length: f64,
    stiffness: f64,
    damping: f64,
    /// Upper bound of the inverse effective mass at its ends \[1/kg\].
    mobility: f64,
}

/// How a row gives way under its impulse.
#[derive(Clone, Copy)]
pub(super) struct Give {
    /// Extension after a unit impulse, `1 / (k Δt + c)` \[m/(N s)\].
    compliance: f64,
    /// Impulse of the damper for a spring that does not move on \[N s\].
    held: f64,
    /// Added to the diagonal of A \[1/kg\].
    pub(super) softness: f64,
}

impl Give {
    /// What an error lacks to the law of the spring after an impulse \[m\].
    pub(super) fn residual(&self, error: f64, impulse: f64) -> f64 {
        error + self.compliance * (impulse - self.held)
    }
}

/// Upper bounds of the inverse effective masses of the two ends of a link \[1/kg\], with their bodies.
fn mobilities(link: &Link, bodies: &[BodyState]) -> [Option<(usize, f64)>; 2] {
    let Link::Spring { body, at, to, .. } = *link else { return [None; 2] };
    let of = |body: BodyId, at: DVec3| {
        let state = bodies.get(body.index())?;
        Some((body.index(), state.largest_inverse_mass_at(at)))
    };
    let far = match to {
        LinkEnd::Point(_) => None,
        LinkEnd::Body { body, at } => of(body, at),
    };
    [of(body, at), far]
}

/// The laws of the springs among these links that steps of `step` \[s\] do not follow; `None` for other
/// links.
///
/// A step follows a spring of (ω Δt)² and c w Δt up to 1, unless it shares a body with others that all
/// together are faster than [`TOGETHER`].
pub(super) fn of_links(links: &[Link], bodies: &[BodyState], step: f64) -> Vec<Option<StiffSpring>> {
    let mut laws: Vec<Option<StiffSpring>> = links
        .iter()
        .map(|link| StiffSpring::of_link(link, bodies).filter(|law| !law.followed(step)))
        .collect();
    let mut sums = vec![(0, 0.0); bodies.len()];
    for (link, law) in links.iter().zip(&laws).filter(|(_, law)| law.is_none()) {
        let Some(law) = law.map_or_else(|| StiffSpring::of_link(link, bodies), Some) else { continue };
        let ends = mobilities(link, bodies);
        let moving = ends.iter().flatten().filter(|(_, mobility)| *mobility > 0.0).count() as f64;
        for (body, mobility) in ends.into_iter().flatten() {
            let speed = (law.stiffness * step + 2.0 * law.damping) * step * mobility;
            sums[body] = (sums[body].0 + 1, sums[body].1 + moving * speed);
        }
    }
    for (link, law) in links.iter().zip(&mut laws) {
        let crowded = |(body, _): &(usize, f64)| sums[*body].0 > 1 && sums[*body].1 > TOGETHER;
        if law.is_none() && mobilities(link, bodies).iter().flatten().any(crowded) {
            *law = StiffSpring::of_link(link, bodies);
        }
    }
    laws
}

impl StiffSpring {
    /// The law of a link, if it is a spring.
    fn of_link(link: &Link, bodies: &[BodyState]) -> Option<Self> {
        let &Link::Spring { rest_length, stiffness, damping, .. } = link else { return None };
        let mobility = mobilities(link, bodies).into_iter().flatten().map(|(_, mobility)| mobility).sum();
        Some(StiffSpring { rest_length, stiffness, damping, mobility })
    }

    /// Whether steps \[s\] follow it.
    fn followed(&self, step: f64) -> bool {
        self.stiffness * self.mobility * step * step <= 1.0 && self.damping * self.mobility * step <= 1.0
    }

    /// Energy that it stores at a length \[J\].
    pub(super) fn energy(&self, length: f64) -> f64 {
        0.5 * self.stiffness * (length - self.rest_length).powi(2)
    }

    /// Tension at a length, without damping \[N\].
    pub(super) fn force(&self, length: f64) -> f64 {
        self.stiffness * (length - self.rest_length)
    }

    /// Stiffness along it \[N/m\].
    pub(super) fn stiffness(&self) -> f64 {
        self.stiffness
    }

    /// Damping along it \[N s/m\].
    pub(super) fn damping(&self) -> f64 {
        self.damping
    }

    /// Stiffness across the spring, for its present length \[N/m\].
    pub(super) fn across(&self, length: f64) -> f64 {
        if length > self.rest_length { self.stiffness * (1.0 - self.rest_length / length) } else { 0.0 }
    }

    /// The directions that resist where its ends are apart by `between`: along it, and across it where it
    /// is under such a tension.
    pub(super) fn directions(&self, between: DVec3, step: f64) -> Vec<DVec3> {
        let along = between.normalize_or(DVec3::Y);
        let (one, two) = tangents(along);
        let pulled = self.across(between.length()) * self.mobility * step * step > FOLLOWED;
        if pulled { vec![along, one, two] } else { vec![along] }
    }

    /// Extension along each of these directions \[m\].
    pub(super) fn extensions(&self, between: DVec3, directions: impl Iterator<Item = DVec3>) -> Vec<f64> {
        let along = |direction: DVec3| {
            let unit = between.normalize_or(direction);
            (between.length() - self.rest_length) * unit.dot(direction)
        };
        let of = |(row, direction): (usize, DVec3)| {
            if row == 0 { along(direction) } else { between.dot(direction) }
        };
        directions.enumerate().map(of).collect()
    }

    /// How it gives way along each of these directions in a step \[s\]; its ends are apart by `between` at
    /// present.
    pub(super) fn gives(&self, between: DVec3, directions: &[DVec3], step: f64) -> Vec<Give> {
        let across = self.across(between.length());
        let give = |(row, extension): (usize, f64)| {
            let (stiffness, damping) = if row == 0 { (self.stiffness, self.damping) } else { (across, 0.0) };
            let compliance = (stiffness * step + damping).recip();
            Give { compliance, held: damping * extension, softness: compliance / step }
        };
        let extensions = self.extensions(between, directions.iter().copied());
        extensions.into_iter().enumerate().map(give).collect()
    }
}
