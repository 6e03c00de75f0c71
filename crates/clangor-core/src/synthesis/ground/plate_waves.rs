//! Pressure above a thin endless plate under a force at a point, exactly, at one frequency and place.
//!
//! In horizontal slownesses P times c, ζ = √(1 − P²) the vertical one, a plate with fluid on both sides has
//!
//! ```text
//! I(x, θ) = ∫₀^∞ f(ζ) J₀(x P sin θ) e^{−i x ζ cos θ} P dP/(iζ)
//! f = ζ/(ζ (1 − Ω² (1−ζ²)²) − iε),   Ω = (1+iη)^½ ω/ω_c,   ε = 2ρc/(ω m″),   x = ωR/c
//! ```
//!
//! f is rational in ζ with five poles, f = Σ A_j/(ζ − ζ_j): the bending wave and its near field, up and down,
//! and the load of the fluid. For one pole the integral is one over images of the source above it, and with
//! ζ_j = cos α_j, counted by the length of the path,
//!
//! ```text
//! T_j = i e^{−ix} ∫₀^∞ e^{−τ} dτ/√((τ+a)(τ+b)) + [π H₀⁽²⁾(x sin α_j sin θ) e^{−ixζ_j cos θ}]
//! a, b = ix (1 − cos(θ ∓ α_j)),   √(ab) = ix (cos θ − ζ_j) at τ = 0
//! ```
//!
//! The first term is the wave from the driven point, e^{−ix} f(cos θ)/x far away (stationary phase). The
//! second is the wave that the plate sheds as the bending wave runs along it: a Mach front above
//! coincidence, below it a field that decays with height. It counts where −a has crossed the ray of
//! integration, that is where α_j lies before the path of steepest descent through θ,
//! Re α_j < θ ± arccos(1/cosh Im α_j), with the sign of Im α_j. The ray is the one of five that is farthest
//! from −a and −b; the sum does not depend on it.
//!
//! Source of the spectrum: Junger and Feit, *Sound, Structures, and Their Interaction* (1986), section 8.3;
//! Cremer, Heckl, Petersson (2005), section 6.5. The evaluation by poles is that of the half-space
//! ([`direction`](super::direction)).

use std::f64::consts::{PI, TAU};

use num_complex::Complex64;

use crate::math::complex_root::sqrt;
use crate::math::hankel::hankel_0_scaled;

/// Angles of the rays of integration.
const RAYS: [f64; 5] = [0.0, 0.5, -0.5, 1.0, -1.0];
/// Step of the double-exponential rule, and its half number of nodes.
const STEP: f64 = 0.2;
const HALF: i32 = 21;
/// Waves that have fallen by e^−40 are left out.
const FALLEN: f64 = 40.0;
/// Iterations for the five poles.
const ROUNDS: usize = 200;

/// Nodes of ∫₀^∞ e^{−τ} g dτ along every ray: τ and weight, e^{−τ} included.
#[derive(Clone, Debug)]
pub(super) struct Rule {
    rays: [Vec<(Complex64, Complex64)>; RAYS.len()],
}

impl Rule {
    /// τ = e^{q − e^{−q}} turned by each angle.
    pub(super) fn new() -> Self {
        let nodes = |angle: f64| {
            let turn = Complex64::cis(angle);
            let node = |n: i32| {
                let q = STEP * f64::from(n);
                let tau = (q - (-q).exp()).exp() * turn;
                (tau, (-tau).exp() * tau * (STEP * (1.0 + (-q).exp())))
            };
            (-HALF..=HALF).map(node).filter(|(_, weight)| weight.norm() > 1e-14).collect()
        };
        Rule { rays: RAYS.map(nodes) }
    }
}

/// The plate at one frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PlateAt {
    /// Ω².
    pub(super) square: Complex64,
    /// ε.
    pub(super) load: f64,
}

/// A pole ζ_j of f with its weight A_j.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct PlatePole {
    zeta: Complex64,
    weight: Complex64,
}

impl PlateAt {
    /// f.
    pub(super) fn response(&self, zeta: Complex64) -> Complex64 {
        let flat = 1.0 - zeta * zeta;
        zeta / (zeta * (1.0 - self.square * flat * flat) - Complex64::I * self.load)
    }

    /// The poles.
    pub(super) fn poles(&self) -> [PlatePole; 5] {
        let inverse = 1.0 / self.square;
        let constant = Complex64::I * self.load * inverse;
        let monic = |z: Complex64| {
            let square = z * z;
            z * (square * (square - 2.0) + (1.0 - inverse)) + constant
        };
        let apart = |z: &[Complex64; 5], j: usize| -> Complex64 {
            (0..5).filter(|k| *k != j).map(|k| z[j] - z[k]).product()
        };
        // Weierstrass' iteration, from the poles of the unloaded plate.
        let root = sqrt(inverse);
        let [fast, slow] = [sqrt(1.0 - root), sqrt(1.0 + root)];
        let spread = |index: f64| 1e-3 * (1.0 + slow.norm()) * Complex64::cis(1.3 * index + 0.4);
        let mut z = [
            slow + spread(0.0),
            -slow + spread(1.0),
            fast + spread(2.0),
            -fast + spread(3.0),
            spread(4.0) - constant / (1.0 - inverse + constant.norm()),
        ];
        for _ in 0..ROUNDS {
            let mut largest = 0.0_f64;
            for j in 0..5 {
                let change = monic(z[j]) / apart(&z, j);
                if change.is_finite() {
                    z[j] -= change;
                    largest = largest.max(change.norm() / (z[j].norm() + 1e-3));
                } else {
                    z[j] += spread(j as f64);
                    largest = 1.0;
                }
            }
            if largest < 1e-14 {
                break;
            }
        }
        std::array::from_fn(|j| PlatePole { zeta: z[j], weight: -inverse * z[j] / apart(&z, j) })
    }
}

/// I(x, θ) of a plate with these poles, for 0 ≤ θ ≤ π/2.
pub(super) fn plate_waves(poles: &[PlatePole; 5], rule: &Rule, x: f64, (cos, sin): (f64, f64)) -> Complex64 {
    poles.iter().map(|pole| pole.weight * pole_wave(pole.zeta, rule, x, (cos, sin))).sum()
}

/// T of a pole.
fn pole_wave(zeta: Complex64, rule: &Rule, x: f64, (cos, sin): (f64, f64)) -> Complex64 {
    let slowness = downward(zeta);
    let ix = Complex64::new(0.0, x);
    // cos(θ ∓ α) without cancellation near the pole, where a is small.
    let (product, cross) = (cos * zeta, sin * slowness);
    let a = ix * one_less_cosine(zeta, slowness, (cos, sin), product + cross);
    let b = ix * one_less_cosine(zeta, -slowness, (cos, sin), product - cross);
    let (args, ray) = best_ray([-a, -b]);
    let start = ix * (cos - zeta);
    // √((τ+a)(τ+b)) from its value at τ = 0: 1 + τ/a crosses no cut, because −a is not on the ray.
    let nodes = &rule.rays[ray];
    let direct: Complex64 = nodes
        .iter()
        .map(|(tau, weight)| weight / (sqrt(1.0 + tau / a) * sqrt(1.0 + tau / b)))
        .sum::<Complex64>()
        / start;
    let mut wave = Complex64::I * Complex64::cis(-x) * direct;
    if is_shed(zeta, sin.atan2(cos), args[0], RAYS[ray]) {
        let along = x * sin * slowness;
        let phase = -Complex64::I * (along + x * cos * zeta);
        if phase.re > -FALLEN && along != Complex64::ZERO {
            wave += PI * hankel_0_scaled(along) * phase.exp();
        }
    }
    wave
}

/// sin α of the pole cos α, α in the half plane that `is_shed` uses.
fn downward(zeta: Complex64) -> Complex64 {
    // √((1−ζ)(1+ζ)) has the sign of a wave that decays outwards.
    let root = sqrt((1.0 - zeta) * (1.0 + zeta));
    if root.im > 0.0 { -root } else { root }
}

/// 1 − cos(θ − α) where `cosine` is cos θ ζ + sin θ sin α.
fn one_less_cosine(
    zeta: Complex64,
    slowness: Complex64,
    (cos, sin): (f64, f64),
    cosine: Complex64,
) -> Complex64 {
    let plain = 1.0 - cosine;
    if plain.norm_sqr() > 1e-8 {
        return plain;
    }
    // sin²/(1 + cos) of θ − α.
    let sine = sin * zeta - cos * slowness;
    let floor = Complex64::new(1e-300, 0.0);
    let small = sine * sine / (1.0 + cosine);
    if small.norm_sqr() == 0.0 { floor } else { small }
}

/// Angles of −a and −b, and the ray farthest from both.
fn best_ray(points: [Complex64; 2]) -> ([f64; 2], usize) {
    let args = points.map(|point| point.arg());
    let distance = |ray: usize| {
        let apart = |angle: f64| {
            let turn = (angle - RAYS[ray]).abs();
            turn.min(TAU - turn)
        };
        apart(args[0]).min(apart(args[1])) - 0.2 * RAYS[ray].abs()
    };
    let farthest = |best: usize, ray: usize| if distance(ray) > distance(best) { ray } else { best };
    (args, (1..RAYS.len()).fold(0, farthest))
}

/// Whether the wave of a pole is shed by the plate: see the module. `angle` is that of −a.
fn is_shed(zeta: Complex64, theta: f64, angle: f64, ray: f64) -> bool {
    let mut alpha = zeta.acos();
    if zeta.re > 0.0 && alpha.im > 0.0 {
        alpha = -alpha;
    }
    let rising = alpha.im > 0.0;
    let width = (1.0 / alpha.im.cosh()).acos();
    let steepest = theta + if rising { width } else { -width };
    // Between the ray and the axis, −a has crossed one of the two only.
    let above = |line: f64| angle > line;
    let shed_on_axis = alpha.re < steepest;
    let between = (angle > ray.min(0.0)) && (angle < ray.max(0.0));
    if between { above(ray) == rising } else { shed_on_axis }
}
