//! The kernels of a ring: Green's function and its normal derivative, integrated around the axis with cos mφ.
//!
//! A source ring at (r', y') is seen from a target at (r, y), φ = 0, at the distance ρ² = δ² + 4 r r'
//! sin²(φ/2), δ being the distance in the half-plane. With C = cos kρ + kρ sin kρ and E = kρ cos kρ − sin kρ,
//!
//! ```text
//! S_m = 1/4π ∫ e^{−ikρ}/ρ cos mφ dφ                  = 1/4π ∫ (cos kρ/ρ − i sin kρ/ρ) cos mφ dφ
//! D_m = −1/4π ∫ (C + iE) g/ρ³ cos mφ dφ,  g = (x' − x)·n' = d·n' + 2 r n'_r sin²(φ/2)
//! ```
//!
//! cos kρ, C, sin kρ/ρ and E/ρ³ are entire functions of ρ² and therefore of cos φ. Their Fourier series end
//! at about k min(r, r'), with cos mφ at m more, however close the target is. Only 1/ρ and 1/ρ³ have slowly
//! decaying series. Their coefficients are Laplace's, known by elliptic integrals and a recurrence. The
//! integral of a product of the two over J midpoints is therefore as exact for a target on the ring as for a
//! distant one: Σ_j w_j cos kρ_j cos mφ_j, with w_j the first J terms of the series of 1/ρ. The weights hold
//! for all frequencies and orders.
//!
//! With ρ² = s²(1 − 2t cos φ + t²), 1/ρ = s⁻¹ (b₀/2 + Σ bₙ cos nφ), b₀ = 4K(t)/π, b₁ = 4(K − E)/(πt) and
//!
//! ```text
//! (2n+1) bₙ₊₁ = 2n (t + 1/t) bₙ − (2n−1) bₙ₋₁,    b'ₙ = (2n+1) [(1+t²) bₙ − 2t bₙ₊₁] / (1−t²)²
//! ```
//!
//! for 1/ρ³ (Brouwer and Clemence, Methods of Celestial Mechanics, 1961, ch. XV). The recurrence runs upwards
//! where t is close to 1, otherwise downwards by Miller's method. Where tⁿ has decayed within J terms the
//! plain midpoint rule is exact.

use std::f64::consts::PI;

use num_complex::Complex64;

use super::lanes::Lanes;

/// (1 − t) J up to which the recurrence runs upwards: it loses a factor of t^{−2J}, a few hundred.
const UPWARDS: f64 = 3.45;

/// −ln of the largest tᴶ for which the plain midpoint rule is accurate.
const DIED_OUT: f64 = 25.0;

/// −ln of the accuracy of Miller's method.
const MILLER: f64 = 16.0;

/// Eight points of source rings as seen from one target.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sources {
    /// r' \[m\].
    pub(super) radius: Lanes,
    /// δ² \[m²\].
    pub(super) gap_square: Lanes,
    /// n'_r times the speed of the parameter \[m\].
    pub(super) normal_r: Lanes,
    /// d·n' times the speed of the parameter \[m²\].
    pub(super) across: Lanes,
    /// Weight of the quadrature in the parameter.
    pub(super) weight: Lanes,
}

/// The J midpoints of half a revolution.
#[derive(Debug)]
pub(super) struct Midpoints {
    /// J, a multiple of 8.
    count: usize,
    /// sin²(φ_j/2).
    haversine: Vec<f64>,
    /// cos nφ_j for the first half of the j, n running fastest.
    harmonics: Vec<f64>,
    /// t below which the plain midpoint rule is accurate.
    plain: f64,
}

impl Midpoints {
    fn new(count: usize) -> Self {
        let angle = |j: usize| PI * (j as f64 + 0.5) / count as f64;
        let mut harmonics = Vec::with_capacity(count * count / 2);
        for j in 0..count / 2 {
            // An angle of n(2j + 1) units, reduced exactly.
            harmonics.extend((0..count).map(|n| {
                let turns = (n * (2 * j + 1)) % (4 * count);
                (PI * turns as f64 / (2 * count) as f64).cos()
            }));
        }
        Midpoints {
            count,
            haversine: (0..count).map(|j| (0.5 * angle(j)).sin().powi(2)).collect(),
            harmonics,
            plain: (-DIED_OUT / count as f64).exp(),
        }
    }

    /// cos mφ_j for m < J.
    #[inline(always)]
    fn harmonic(&self, m: usize, j: usize) -> f64 {
        if 2 * j < self.count {
            return self.harmonics[j * self.count + m];
        }
        let mirrored = self.harmonics[(self.count - 1 - j) * self.count + m];
        if m.is_multiple_of(2) { mirrored } else { -mirrored }
    }
}

/// Midpoint rules of all sizes used in a band.
#[derive(Debug)]
pub(super) struct MidpointLadder(Vec<Midpoints>);

impl MidpointLadder {
    /// Rules for all rings seen from a radius with kr up to `bandwidth`, for m up to `order`.
    pub(super) fn new(bandwidth: f64, order: usize) -> Self {
        let longest = points_for(bandwidth, order).div_ceil(8);
        MidpointLadder((1..=longest).map(|k| Midpoints::new(8 * k)).collect())
    }

    /// The rule for k min(r, r') = `bandwidth` and m up to `order`.
    #[inline(always)]
    pub(super) fn rule(&self, bandwidth: f64, order: usize) -> &Midpoints {
        let k = points_for(bandwidth, order).div_ceil(8).clamp(1, self.0.len());
        &self.0[k - 1]
    }
}

/// The series of cos kρ ends where the Bessel functions J₂ₙ(2kr) do: at n = kr plus a few times (kr)^{1/3}.
#[inline(always)]
fn points_for(bandwidth: f64, order: usize) -> usize {
    // 7 points hold m = 1 too.
    (bandwidth + 3.5 * bandwidth.cbrt() + 7.0).ceil() as usize + order.saturating_sub(1)
}

/// Factors of C, E, cos kρ and sin kρ at the midpoints.
#[derive(Debug, Default)]
pub(super) struct RingRule {
    /// Per midpoint: ρ, and the weights of cos kρ, sin kρ (single layer), C, E (double layer).
    points: Vec<[Lanes; 5]>,
    /// bₙ.
    coefficients: Vec<Lanes>,
    /// Coefficients by upward recurrence, where lanes need both directions.
    upward: Vec<Lanes>,
}

/// S_m and D_m of eight points for M orders m, real and imaginary parts.
#[derive(Clone, Copy, Debug)]
pub(super) struct RingKernels<const M: usize> {
    pub(super) single: [[Lanes; 2]; M],
    pub(super) double: [[Lanes; 2]; M],
}

impl RingRule {
    /// Prepares the weights for sources seen from the radius `r`.
    #[inline(always)]
    pub(super) fn prepare(&mut self, r: f64, sources: &Sources, midpoints: &Midpoints) {
        let count = midpoints.count;
        let one = Lanes::splat(1.0);
        let product = sources.radius * r;
        // Expansion parameter: χ = 1 + e is cosh η with t = e^{−η}.
        let e = sources.gap_square * (product * 2.0).recip();
        let root = (e * (e + Lanes::splat(2.0))).sqrt();
        let t = (one + e + root).recip();
        let short = (e + root) * t;
        let scale_square = product * t.recip();
        let step = 2.0 * PI / count as f64;
        // The area of a ring of unit width per radian, over 4π.
        let area = sources.weight * sources.radius * (0.25 / PI);
        // Plain midpoint rule: single and double layer at each point.
        self.points.clear();
        for j in 0..count {
            let h = midpoints.haversine[j];
            let square = (product * (4.0 * h)) + sources.gap_square;
            let inverse = square.sqrt().recip();
            let g = (sources.normal_r * (2.0 * r * h)) + sources.across;
            let plain = inverse * area * step;
            let double = -(g * plain * inverse * inverse);
            self.points.push([square * inverse, plain, plain, double, double]);
        }
        // Lanes far enough from the ring need no more.
        let (largest, _) = t.range();
        if largest < midpoints.plain {
            return;
        }
        // Fourier coefficients bₙ of 1/ρ, then b'ₙ of 1/ρ³.
        self.laplace(t.max(midpoints.plain), short, count);
        // Sum both series at the midpoints. Separate even and odd harmonics give the points j and J − 1 − j.
        let inverse_scale = scale_square.sqrt().recip();
        let single_factor = inverse_scale * area * step;
        let ends = short * (one + t);
        let cube_factor = single_factor * inverse_scale * inverse_scale * (ends * ends).recip();
        let curvature = sources.normal_r * (sources.radius * 2.0).recip();
        let flat = sources.across - curvature * sources.gap_square;
        let sum = one + t * t;
        let twice = t * -2.0;
        for n in 0..count {
            let (here, next) = (self.coefficients[n], self.coefficients[n + 1]);
            self.upward[n] = (sum * here + twice * next) * (2 * n + 1) as f64;
        }
        self.coefficients[0] = self.coefficients[0] * 0.5;
        self.upward[0] = self.upward[0] * 0.5;
        for j in 0..count / 2 {
            let row = &midpoints.harmonics[j * count..(j + 1) * count];
            let mut sums = [Lanes::default(); 4];
            for (pair, c) in row.chunks_exact(2).enumerate() {
                let (even, odd) = (Lanes::splat(c[0]), Lanes::splat(c[1]));
                sums[0] = even.mul_add(self.coefficients[2 * pair], sums[0]);
                sums[1] = odd.mul_add(self.coefficients[2 * pair + 1], sums[1]);
                sums[2] = even.mul_add(self.upward[2 * pair], sums[2]);
                sums[3] = odd.mul_add(self.upward[2 * pair + 1], sums[3]);
            }
            for (j, w, v) in [
                (j, sums[0] + sums[1], sums[2] + sums[3]),
                (count - 1 - j, sums[0] - sums[1], sums[2] - sums[3]),
            ] {
                let point = &mut self.points[j];
                let single = w * single_factor;
                // (1 − cos φ)/ρ³ from 1/ρ and 1/ρ³, without cancellation close by.
                let double = -(curvature * single + flat * (v * cube_factor));
                point[1] = t.below(midpoints.plain, point[1], single);
                point[3] = t.below(midpoints.plain, point[3], double);
            }
        }
    }

    /// b₀ … b_count for each lane, given t and 1 − t; resizes `upward` to the same length.
    #[inline(always)]
    fn laplace(&mut self, t: Lanes, short: Lanes, count: usize) {
        // Complete elliptic integrals by the arithmetic-geometric mean: b₀ = 2/a, b₁ = b₀ Σ/t.
        let (mut a, mut b) = (Lanes::splat(1.0), (short * (Lanes::splat(1.0) + t)).max(1e-300).sqrt());
        let mut sum = t * t * 0.5;
        let mut power = 1.0;
        for _ in 0..7 {
            let c = (a - b) * 0.5;
            sum = (c * c).mul_add(Lanes::splat(power), sum);
            (a, b) = ((a + b) * 0.5, (a * b).sqrt());
            power *= 2.0;
        }
        let zeroth = a.recip() * 2.0;
        let first = zeroth * sum * t.recip();
        let both = t + t.recip();
        let limit = UPWARDS / count as f64;
        let (longest, shortest) = short.range();
        self.upward.clear();
        self.upward.resize(count + 1, Lanes::default());
        self.coefficients.clear();
        self.coefficients.resize(count + 1, Lanes::default());
        // Upward recurrence, stable for lanes with t close to 1.
        if shortest < limit {
            self.upward[0] = zeroth;
            self.upward[1] = first;
            for n in 1..count {
                let inverse = 1.0 / (2 * n + 1) as f64;
                let (before, here) = (self.upward[n - 1], self.upward[n]);
                self.upward[n + 1] =
                    both * here * (2.0 * n as f64 * inverse) + before * (-((2 * n - 1) as f64) * inverse);
            }
        }
        if longest < limit {
            self.coefficients.copy_from_slice(&self.upward);
            return;
        }
        // Miller's method: downward recurrence from beyond the last term, normalised by b₀.
        let top = count + (MILLER / shortest.max(limit)).ceil() as usize;
        let (mut above, mut here) = (Lanes::default(), Lanes::splat(1e-100));
        for n in (1..=top).rev() {
            if n <= count {
                self.coefficients[n] = here;
            }
            let inverse = 1.0 / (2 * n - 1) as f64;
            let below = both * here * (2.0 * n as f64 * inverse) + above * (-((2 * n + 1) as f64) * inverse);
            (above, here) = (here, below);
        }
        self.coefficients[0] = here;
        let factor = zeroth * here.recip();
        // Each lane takes the recurrence that is stable for its t.
        for (down, up) in self.coefficients.iter_mut().zip(&self.upward) {
            *down = short.below(limit, *up, *down * factor);
        }
    }

    /// The kernels of some orders at a wavenumber. Its imaginary part enters only if `DAMPED`.
    #[inline(always)]
    pub(super) fn kernels<const DAMPED: bool, const M: usize>(
        &self,
        k: Complex64,
        orders: [usize; M],
        midpoints: &Midpoints,
    ) -> RingKernels<M> {
        let mut sums = [[Lanes::default(); 4]; M];
        for (j, point) in self.points.iter().enumerate() {
            let [distance, cos_single, sin_single, c_double, e_double] = *point;
            let phase = distance * k.re;
            let (s, c) = phase.sin_cos();
            let mut terms = [Lanes::default(); 4];
            if DAMPED {
                // k = a − ib: cos kρ = cos aρ cosh bρ + i sin aρ sinh bρ, and so on.
                let growth = distance * -k.im;
                let (sinh, cosh) = growth.small_sinh_cosh();
                let cosine = [c * cosh, s * sinh];
                let sine = [s * cosh, -(c * sinh)];
                // C = cos z + z sin z, E = z cos z − sin z with z = phase − i growth.
                let big_c = [
                    growth.mul_add(sine[1], phase.mul_add(sine[0], cosine[0])),
                    phase.mul_add(sine[1], cosine[1]) - growth * sine[0],
                ];
                let big_e = [
                    growth.mul_add(cosine[1], phase * cosine[0]) - sine[0],
                    phase.mul_add(cosine[1], -(growth * cosine[0])) - sine[1],
                ];
                terms[0] = cos_single.mul_add(cosine[0], sin_single * sine[1]);
                terms[1] = cos_single * cosine[1] - sin_single * sine[0];
                terms[2] = c_double * big_c[0] - e_double * big_e[1];
                terms[3] = c_double.mul_add(big_c[1], e_double * big_e[0]);
            } else {
                terms[0] = cos_single * c;
                terms[1] = -(sin_single * s);
                terms[2] = c_double * phase.mul_add(s, c);
                terms[3] = e_double * (phase * c - s);
            }
            // Fourier sum over the midpoints for each order.
            for (sums, m) in sums.iter_mut().zip(orders) {
                let cosine = Lanes::splat(midpoints.harmonic(m, j));
                for i in 0..4 {
                    sums[i] = cosine.mul_add(terms[i], sums[i]);
                }
            }
        }
        RingKernels {
            single: std::array::from_fn(|m| [sums[m][0], sums[m][1]]),
            double: std::array::from_fn(|m| [sums[m][2], sums[m][3]]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::lanes::LANES;
    use super::*;

    /// The orders tested.
    const ORDERS: [usize; 4] = [0, 1, 7, 40];

    /// S_m and D_m of one source by brute force: a midpoint rule on a grid graded to φ = 0.
    fn brute(r: f64, source: [f64; 5], k: Complex64) -> [Complex64; 8] {
        let [radius, gap_square, normal_r, across, weight] = source;
        let mut sums = [Complex64::ZERO; 8];
        let rule = crate::quadrature::gauss_legendre(80);
        let mut high = PI;
        for level in 0..60 {
            let low = if level == 59 { 0.0 } else { 0.5 * high };
            for (x, w) in &rule {
                let phi = low + (high - low) * x;
                let w = 2.0 * w * (high - low) * weight * radius / (4.0 * PI);
                let h = (0.5 * phi).sin().powi(2);
                let rho = (gap_square + 4.0 * r * radius * h).sqrt();
                let ik = Complex64::I * k * rho;
                let wave = (-ik).exp() / rho;
                let g = across + 2.0 * r * normal_r * h;
                let double = -(ik + 1.0) * wave * (g / (rho * rho));
                for (i, m) in ORDERS.into_iter().enumerate() {
                    let c = (m as f64 * phi).cos();
                    sums[i] += w * c * wave;
                    sums[4 + i] += w * c * double;
                }
            }
            high = low;
        }
        sums
    }

    #[test]
    fn kernels_are_those_of_direct_integration_near_and_far() {
        let mut rule = RingRule::default();
        for k in [0.0, 0.7, 6.0, 30.0, 55.0] {
            for damping in [0.0, 0.1] {
                let k = Complex64::new(k, -damping);
                let ladder = MidpointLadder::new(k.re, 40);
                let r = 0.9;
                for first in [1e-7, 1e-4, 1e-2, 0.3] {
                    // Rings beside the target, each lane farther away than the last.
                    let gap = Lanes::from_fn(|l| first * 1.4_f64.powi(l as i32));
                    let radius = Lanes::from_fn(|l| (r - 0.6 * gap.0[l]).abs() + 1e-6);
                    let gap_square = Lanes::from_fn(|l| (radius.0[l] - r).powi(2) + (0.8 * gap.0[l]).powi(2));
                    let normal_r = Lanes::from_fn(|l| 0.3 + 0.1 * l as f64);
                    let across = Lanes::from_fn(|l| 0.2 * gap_square.0[l] + 0.01 * first * gap.0[l]);
                    let weight = Lanes::splat(1.3);
                    let sources = Sources { radius, gap_square, normal_r, across, weight };
                    let midpoints = ladder.rule(k.re * r, 40);
                    rule.prepare(r, &sources, midpoints);
                    let found = if damping > 0.0 {
                        rule.kernels::<true, 4>(k, ORDERS, midpoints)
                    } else {
                        rule.kernels::<false, 4>(k, ORDERS, midpoints)
                    };
                    for l in 0..LANES {
                        let source = [radius.0[l], gap_square.0[l], normal_r.0[l], across.0[l], weight.0[l]];
                        let expected = brute(r, source, k);
                        let found: Vec<Complex64> = found
                            .single
                            .iter()
                            .chain(&found.double)
                            .map(|[re, im]| Complex64::new(re.0[l], im.0[l]))
                            .collect();
                        for (a, b) in found.iter().zip(&expected) {
                            let error = (a - b).norm() / expected[0].norm().max(b.norm());
                            // Residual seen: 1.2e-11.
                            assert!(error < 1e-9, "k {k} gap {first} lane {l}: {found:?} {expected:?}");
                        }
                    }
                }
            }
        }
    }
}
