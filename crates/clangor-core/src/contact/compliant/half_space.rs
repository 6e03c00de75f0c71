//! What waves into an elastic half-space take from a contact: the imaginary part of Lamb's receptance.
//!
//! ```text
//! κ = β(ν)/(μ c_S)    R(p) = 0
//! β = (1/2π) [ ∫₀¹ |Im P √(P² − a²)/R| dP + π p √(p² − a²)/|R′(p)| ]
//! R = (2P² − 1)² − 4P² √(P² − a²) √(P² − 1)    a² = (1 − 2ν)/(2 − 2ν)
//! ```
//!
//! P is the slowness along the surface in units of 1/c_S; the first term are the waves into the body, the
//! second is Rayleigh's wave, 67.4 % at ν = ¼ \[MillerPursey1955\]. Force and displacement are those of a
//! point far smaller than the waves, as a contact is.

/// β of a half-space and its parts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfSpaceLoss {
    /// Part of the waves into the body.
    pub body: f64,
    /// Part of Rayleigh's wave.
    pub rayleigh: f64,
}

/// Nodes and weights of Gauss–Legendre quadrature of order 8 on [−1, 1], positive half.
const GAUSS: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_47),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
];
/// Panels of the quadrature over an angle from 0 to π/2.
const PANELS: usize = 8;

/// ∫ over [0, π/2].
fn quadrature(of: impl Fn(f64) -> f64) -> f64 {
    let half = 0.25 * std::f64::consts::PI / PANELS as f64;
    let panel = |i: usize| {
        let middle = half * (2 * i + 1) as f64;
        let pair =
            |(node, weight): &(f64, f64)| weight * (of(middle - half * node) + of(middle + half * node));
        half * GAUSS.iter().map(pair).sum::<f64>()
    };
    (0..PANELS).map(panel).sum()
}

/// β = `body` + `rayleigh` for Poisson's ratio −1 < ν < ½.
///
/// The quadrature is exact to 1e-9.
///
/// # Source
///
/// \[Lamb1904\], \[MillerPursey1955\].
pub fn half_space_loss(poisson: f64) -> HalfSpaceLoss {
    let square = (1.0 - 2.0 * poisson) / (2.0 - 2.0 * poisson);
    let rest = 1.0 - square;
    // Below the branch point a, with P = a sin θ: the term of R with two imaginary roots is real.
    let below = quadrature(|angle| {
        let (sine, cosine) = angle.sin_cos();
        let p2 = square * sine * sine;
        let rayleigh = (2.0 * p2 - 1.0).powi(2) + 4.0 * p2 * square.sqrt() * cosine * (1.0 - p2).sqrt();
        square.powf(1.5) * sine * cosine * cosine / rayleigh
    });
    // Between the branch points, with P² = a² + (1 − a²) sin²θ.
    let between = quadrature(|angle| {
        let (sine, cosine) = angle.sin_cos();
        let p2 = square + rest * sine * sine;
        let (real, imaginary) = ((2.0 * p2 - 1.0).powi(2), 4.0 * p2 * rest * sine * cosine);
        rest.powf(1.5) * sine * sine * cosine * imaginary / (real * real + imaginary * imaginary)
    });
    // Rayleigh's slowness: R falls from 1 at P = 1 to −∞.
    let rayleigh = |p: f64| {
        let (s, q) = ((p * p - square).sqrt(), (p * p - 1.0).sqrt());
        (2.0 * p * p - 1.0).powi(2) - 4.0 * p * p * s * q
    };
    let (mut low, mut high) = (1.0, 2.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if rayleigh(middle) > 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    let p = 0.5 * (low + high);
    let (s, q) = ((p * p - square).sqrt(), (p * p - 1.0).sqrt());
    let slope = 8.0 * p * (2.0 * p * p - 1.0) - 8.0 * p * s * q - 4.0 * p.powi(3) * (q / s + s / q);
    HalfSpaceLoss { body: (below + between) / std::f64::consts::TAU, rayleigh: 0.5 * p * s / slope.abs() }
}

/// κ [s m/N] of a half-space of Young's modulus \[Pa\], Poisson's ratio and density [kg/m³].
pub fn half_space_radiation(young: f64, poisson: f64, density: f64) -> f64 {
    let shear = young / (2.0 * (1.0 + poisson));
    let HalfSpaceLoss { body, rayleigh } = half_space_loss(poisson);
    (body + rayleigh) / (shear * (shear / density).sqrt())
}
