//! Radiation of surface waves in one direction, at all frequencies at once.
//!
//! With P² = 1 − N², N the vertical slowness, a wave of slowness √σ is a pole at N = ±ξ, ξ = √(1−σ). Turned
//! to the direction θ of the listener, the integral over plane waves is one over the cosine t of their angle
//! with it, and the mean over the azimuth is elementary:
//!
//! ```text
//! I(x) = i ∫ E(t) e^{−ixt} dt from t = 1 down,   E = w/2ξ Σ± 1/√((t ∓ ξ cos θ)² − σ sin² θ)
//! ```
//!
//! t = 1 is the wave from the force; the roots t₊ = ±ξ cos θ + √σ sin θ of the argument are when the surface
//! wave passes. Down from 1, along a ray t = 1 − i v e^{iχ}, nothing oscillates, and E does not depend on x:
//! I is a Laplace transform, done by the trapezoidal rule in log v. Where the way from the real integral to
//! the ray crosses t₊, the wave shed by the surface is added, by its residue:
//!
//! ```text
//! −π w / (±2ξ) H₀⁽²⁾(x √σ sin θ) e^{∓ i x ξ cos θ}
//! ```
//!
//! Each pole takes the ray, of three, that is farthest from its t₊: the sum does not depend on it. Amplitudes
//! change little from one direction to a near one, and impacts blend two that are kept. Measured against the
//! integral over slownesses: 2.3e-3 (`tests/cross/ground.rs`).

use std::f64::consts::{FRAC_PI_2, PI};

use num_complex::Complex64;

use super::poles::{Branch, Pole};
use crate::math::complex_root::sqrt;
use crate::math::hankel::hankel_0_scaled;

/// Step of ln x between amplitudes.
const STEP: f64 = 1.0 / 6.0;
/// Nodes that an amplitude is interpolated from.
const ORDER: usize = 6;
/// Amplitude nodes per node of ln v: commensurate grids share their exponentials.
const SPACING: usize = 3;
/// χ of the rays.
const TILTS: [f64; 3] = [0.0, 0.7, -0.7];
/// Least x v, below which E is constant; greatest, beyond which e^{−xv} is negligible.
const V_RANGE: [f64; 2] = [1e-3, 40.0];
/// Waves that have fallen by e^−25 are not computed.
const FALLEN: f64 = 25.0;

/// Values of x = ωR/c in geometric progression.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Octaves {
    first: f64,
    count: usize,
}

impl Octaves {
    /// Nodes to interpolate between x = `from` and x = `to`.
    pub fn spanning(from: f64, to: f64) -> Self {
        let count = ((to / from).ln().max(0.0) / STEP).ceil() as usize + ORDER;
        Octaves { first: from * (-2.0 * STEP).exp(), count }
    }

    /// x of a node.
    fn at(&self, node: usize) -> f64 {
        self.first * (STEP * node as f64).exp()
    }

    /// First of the six nodes around x and their weights: the polynomial in ln x through them; beyond the
    /// ends its value there.
    fn weights(&self, x: f64) -> (usize, [f64; ORDER]) {
        let place = ((x / self.first).ln() / STEP).clamp(0.0, (self.count - 1) as f64);
        let node = (place.floor().max(2.0) as usize).min(self.count - 4) - 2;
        let t: [f64; ORDER] = std::array::from_fn(|i| place - (node + i) as f64);
        let (ahead, behind) = (t[0] * t[1] * t[2], t[3] * t[4] * t[5]);
        let weights = [
            -t[1] * t[2] * behind / 120.0,
            t[0] * t[2] * behind / 24.0,
            -t[0] * t[1] * behind / 12.0,
            ahead * t[4] * t[5] / 12.0,
            -ahead * t[3] * t[5] / 24.0,
            ahead * t[3] * t[4] / 120.0,
        ];
        (node, weights)
    }
}

/// Origin of a wave.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// The point of contact.
    Contact,
    /// The surface, along which a wave of this branch runs; 0 for ξ, 1 for −ξ.
    Surface(Branch, usize),
}

/// A wave at the listener: amplitude times e^{−ix·arrival}.
#[derive(Clone, Debug, PartialEq)]
pub struct Train {
    /// Origin.
    pub origin: Origin,
    /// Time of arrival, over R/c.
    pub arrival: f64,
    /// Amplitudes at the nodes.
    amplitudes: Vec<Complex64>,
}

/// The waves in one direction.
#[derive(Clone, Debug, PartialEq)]
pub struct Direction {
    nodes: Octaves,
    /// Not empty; the first comes from the point of contact.
    pub trains: Vec<Train>,
}

impl Direction {
    /// The waves that these poles radiate at the angle θ from the normal, between these frequencies.
    ///
    /// `squares`: of the slownesses of Rayleigh's, pressure, shear and leaking waves.
    pub fn new(poles: &[Pole], (cos, sin): (f64, f64), squares: [Complex64; 4], nodes: Octaves) -> Self {
        // Straight above, a surface wave is a point with a logarithmic singularity; the angle is moved off by
        // 1e-9.
        let sin = sin.max(1e-9);
        let arrivals = squares.map(|square| passing(square, cos, sin));
        let mut contact = FromContact::new(nodes);
        let silence = || vec![Complex64::ZERO; nodes.count];
        let mut trains = vec![Train { origin: Origin::Contact, arrival: 1.0, amplitudes: silence() }];
        for pole in poles {
            let slowness = sqrt(pole.square);
            let xi = sqrt(1.0 - pole.square);
            let both = [1.0, -1.0].map(|sign| Pass {
                sign,
                xi,
                slowness,
                first: sign * xi * cos + slowness * sin,
                second: sign * xi * cos - slowness * sin,
            });
            let tilt = best_tilt(&both);
            contact.add(pole, &both, cos, tilt);
            let ray = -FRAC_PI_2 + TILTS[tilt];
            // A residue counts only between the two paths: Re sin(θ − w) > 0 with √σ = sin w.
            let outside = (sin * xi - cos * slowness).re > 0.0;
            for (family, pass) in both.iter().enumerate() {
                let angle = angle_below(pass.first - 1.0);
                let shed = if family == 0 { outside && angle < ray } else { angle > ray };
                if !shed {
                    continue;
                }
                let from_contact = pass.first - 1.0;
                // A wave that decays as fast as it oscillates needs no separate arrival.
                let near = from_contact.re.abs() <= -from_contact.im;
                let (origin, arrival) = match pole.branch {
                    Branch::Pressure | Branch::Shear if near => (Origin::Contact, 1.0),
                    branch => (Origin::Surface(branch, family), arrivals[branch.index()][family]),
                };
                let index = trains.iter().position(|train| train.origin == origin).unwrap_or(trains.len());
                if index == trains.len() {
                    trains.push(Train { origin, arrival, amplitudes: silence() });
                }
                pass.shed(pole, sin, nodes, &mut trains[index]);
            }
        }
        contact.finish(&mut trains[0].amplitudes);
        Direction { nodes, trains }
    }

    /// Blends the amplitudes of two neighbouring directions; arrivals are those of this one.
    pub fn between(
        (low, high): (&Direction, &Direction),
        part: f64,
        (cos, sin): (f64, f64),
        squares: [Complex64; 4],
    ) -> Self {
        let arrivals = squares.map(|square| passing(square, cos, sin));
        let mut trains: Vec<Train> = Vec::with_capacity(8);
        for (direction, share) in [(low, 1.0 - part), (high, part)] {
            for Train { origin, amplitudes, .. } in &direction.trains {
                if let Some(sum) = trains.iter_mut().find(|train| train.origin == *origin) {
                    sum.amplitudes.iter_mut().zip(amplitudes).for_each(|(sum, a)| *sum += a * share);
                    continue;
                }
                let arrival = match *origin {
                    Origin::Contact => 1.0,
                    Origin::Surface(branch, family) => arrivals[branch.index()][family],
                };
                let amplitudes = amplitudes.iter().map(|a| a * share).collect();
                trains.push(Train { origin: *origin, arrival, amplitudes });
            }
        }
        Direction { nodes: low.nodes, trains }
    }

    /// I(x).
    pub fn at(&self, x: f64) -> Complex64 {
        let amplitudes = self.amplitudes(x);
        let phase = |train: &Train| Complex64::from_polar(1.0, -x * train.arrival);
        self.trains.iter().zip(amplitudes).map(|(train, a)| a * phase(train)).sum()
    }

    /// The amplitude of each wave at x.
    pub fn amplitudes(&self, x: f64) -> impl Iterator<Item = Complex64> {
        let (node, weights) = self.nodes.weights(x);
        self.trains.iter().map(move |train| {
            let near = &train.amplitudes[node..node + ORDER];
            near.iter().zip(weights).map(|(a, w)| a * w).sum()
        })
    }
}

/// Arrival times of the waves of the two signs of ξ, over R/c.
fn passing(square: Complex64, cos: f64, sin: f64) -> [f64; 2] {
    [1.0, -1.0].map(|sign| (sign * sqrt(1.0 - square) * cos + sqrt(square) * sin).re)
}

/// Angle of a number below the real axis, or on it, from −π to 0.
fn angle_below(z: Complex64) -> f64 {
    match z {
        z if z.im < 0.0 => z.arg(),
        z if z.re < 0.0 => -PI,
        _ => 0.0,
    }
}

/// A pole at one sign of ξ, for one direction.
struct Pass {
    sign: f64,
    /// ξ.
    xi: Complex64,
    /// √σ.
    slowness: Complex64,
    /// t₊.
    first: Complex64,
    /// t₋.
    second: Complex64,
}

impl Pass {
    /// Adds the wave shed by the surface.
    fn shed(&self, pole: &Pole, sin: f64, nodes: Octaves, train: &mut Train) {
        let scale = -PI * pole.weight / (2.0 * self.sign * self.xi);
        let rate = -Complex64::I * (self.first - train.arrival);
        for (node, amplitude) in train.amplitudes.iter_mut().enumerate() {
            let x = nodes.at(node);
            if -rate.re * x > FALLEN {
                break;
            }
            *amplitude += scale * hankel_0_scaled(x * sin * self.slowness) * (rate * x).exp();
        }
    }
}

/// The ray that is farthest from all t₊ and t₋, as seen from 1.
fn best_tilt(both: &[Pass; 2]) -> usize {
    let angles = both.each_ref().map(|pass| [(pass.first - 1.0).arg(), (pass.second - 1.0).arg()]);
    let distance = |tilt: usize| {
        let ray = -FRAC_PI_2 + TILTS[tilt];
        let apart = |angle: f64| {
            let turn = (angle - ray).abs();
            turn.min(2.0 * PI - turn)
        };
        angles.as_flattened().iter().map(|a| apart(*a)).fold(f64::INFINITY, f64::min)
    };
    let farthest = |best: usize, tilt: usize| if distance(tilt) > distance(best) { tilt } else { best };
    (1..TILTS.len()).fold(0, farthest)
}

/// The wave from the point of contact: E along the rays, at the nodes of v.
struct FromContact {
    nodes: Octaves,
    distances: Vec<f64>,
    sums: [Vec<Complex64>; TILTS.len()],
    used: [bool; TILTS.len()],
}

impl FromContact {
    fn new(nodes: Octaves) -> Self {
        let step = STEP * SPACING as f64;
        let least = V_RANGE[0] / nodes.at(nodes.count - 1);
        let greatest = V_RANGE[1] / nodes.first;
        let count = ((greatest / least).ln() / step).ceil() as usize + 1;
        let distances: Vec<f64> = (0..count).map(|n| least * (step * n as f64).exp()).collect();
        let sums = std::array::from_fn(|_| vec![Complex64::ZERO; count]);
        FromContact { nodes, distances, sums, used: [false; TILTS.len()] }
    }

    /// Adds E of a pole along a ray.
    fn add(&mut self, pole: &Pole, both: &[Pass; 2], cos: f64, tilt: usize) {
        self.used[tilt] = true;
        let ray = Complex64::from_polar(1.0, -FRAC_PI_2 + TILTS[tilt]);
        // (t − t±)/ray = (1 − t±)/ray + v moves to the right as v grows and so never crosses the cut of the
        // root.
        let starts = both.each_ref().map(|pass| {
            let [first, second] = [pass.first, pass.second].map(|t| (1.0 - t) / ray);
            let root = sqrt(first) * sqrt(second) * ray;
            // At v = 0 no azimuth matters, and E = w/2ξ · 1/(ξ ∓ cos θ).
            let mean = pass.xi - pass.sign * cos;
            let same = (root - mean).norm_sqr() < (root + mean).norm_sqr();
            let scale = pole.weight / (2.0 * pass.xi * ray) * if same { 1.0 } else { -1.0 };
            (first, second, scale)
        });
        for (sum, v) in self.sums[tilt].iter_mut().zip(&self.distances) {
            for (first, second, scale) in starts {
                *sum += scale / (sqrt(first + v) * sqrt(second + v));
            }
        }
    }

    /// Adds ∫ E e^{−xv…} dv at all nodes of x.
    fn finish(&self, amplitudes: &mut [Complex64]) {
        let step = STEP * SPACING as f64;
        let product = self.nodes.first * self.distances[0];
        let count = amplitudes.len() + SPACING * self.distances.len();
        for (tilt, sum) in self.sums.iter().enumerate().filter(|(tilt, _)| self.used[*tilt]) {
            let turn = Complex64::from_polar(1.0, TILTS[tilt]);
            let exponentials: Vec<Complex64> =
                (0..count).map(|i| (-turn * (product * (STEP * i as f64).exp())).exp()).collect();
            for (n, (e, v)) in sum.iter().zip(&self.distances).enumerate() {
                // Below the least v, E has its value there: a geometric series.
                let below = if n == 0 { 1.0 / (1.0 - (-step).exp()) } else { 1.0 };
                let weighted = e * turn * (step * v * below);
                for (amplitude, exponential) in amplitudes.iter_mut().zip(&exponentials[SPACING * n..]) {
                    *amplitude += weighted * exponential;
                }
            }
        }
    }
}
