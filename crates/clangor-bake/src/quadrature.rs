//! Quadrature rules: Gauss–Legendre on a line, Radon's and equal parts on a triangle, Walkington's on a
//! tetrahedron.

use std::f64::consts::PI;

/// Seven points of a triangle in barycentric coordinates, and weights, which sum to 1: exact for polynomials
/// of degree 5. Source: Radon (1948), "Zur mechanischen Kubatur".
pub(crate) const TRIANGLE_FIFTH_DEGREE: [([f64; 3], f64); 7] = {
    const A: f64 = 0.470_142_064_105_115_1;
    const B: f64 = 0.101_286_507_323_456_34;
    const WA: f64 = 0.132_394_152_788_506_2;
    const WB: f64 = 0.125_939_180_544_827_15;
    const A1: f64 = 1.0 - 2.0 * A;
    const B1: f64 = 1.0 - 2.0 * B;
    const THIRD: f64 = 1.0 / 3.0;
    [
        ([THIRD, THIRD, THIRD], 0.225),
        ([A1, A, A], WA),
        ([A, A1, A], WA),
        ([A, A, A1], WA),
        ([B1, B, B], WB),
        ([B, B1, B], WB),
        ([B, B, B1], WB),
    ]
};

/// Fourteen points of a tetrahedron in barycentric coordinates, and weights, which sum to 1: exact for
/// polynomials of degree 5. Source: Walkington (2000), "Quadrature on
/// simplices of arbitrary dimension".
pub(crate) const TETRAHEDRON_FIFTH_DEGREE: [([f64; 4], f64); 14] = {
    const A: f64 = 0.310_885_919_263_300_6;
    const B: f64 = 0.092_735_250_310_891_23;
    const C: f64 = 0.045_503_704_125_649_65;
    const WA: f64 = 0.112_687_925_718_015_85;
    const WB: f64 = 0.073_493_043_116_361_95;
    const WC: f64 = 0.042_546_020_777_081_47;
    const A1: f64 = 1.0 - 3.0 * A;
    const B1: f64 = 1.0 - 3.0 * B;
    const C1: f64 = 0.5 - C;
    [
        ([A1, A, A, A], WA),
        ([A, A1, A, A], WA),
        ([A, A, A1, A], WA),
        ([A, A, A, A1], WA),
        ([B1, B, B, B], WB),
        ([B, B1, B, B], WB),
        ([B, B, B1, B], WB),
        ([B, B, B, B1], WB),
        ([C, C, C1, C1], WC),
        ([C, C1, C, C1], WC),
        ([C, C1, C1, C], WC),
        ([C1, C, C, C1], WC),
        ([C1, C, C1, C], WC),
        ([C1, C1, C, C], WC),
    ]
};

/// Nodes and weights of the n-point Gauss–Legendre rule on [0, 1], ascending: exact for polynomials of degree
/// 2n − 1.
///
/// Newton's method on the Legendre polynomial from Tricomi's guess.
pub fn gauss_legendre(n: usize) -> Vec<(f64, f64)> {
    let mut rule = vec![(0.0, 0.0); n];
    for i in 0..n {
        let mut x = (PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
        let mut slope = 1.0;
        for _ in 0..100 {
            let (mut before, mut here) = (0.0, 1.0);
            for j in 0..n {
                let j = j as f64;
                (before, here) = (here, ((2.0 * j + 1.0) * x * here - j * before) / (j + 1.0));
            }
            slope = n as f64 * (x * here - before) / (x * x - 1.0);
            let step = here / slope;
            x -= step;
            if step.abs() < 1e-16 {
                break;
            }
        }
        rule[n - 1 - i] = (0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * slope * slope));
    }
    rule
}

/// Centroids of the equal parts of a triangle, by the coordinates along two sides.
pub(crate) fn parts_of_triangle(divisions: usize) -> impl Iterator<Item = [f64; 2]> {
    let scale = 1.0 / divisions as f64;
    let upward = move |i: usize, j: usize| [(i as f64 + 1.0 / 3.0) * scale, (j as f64 + 1.0 / 3.0) * scale];
    let downward = move |i: usize, j: usize| [(i as f64 + 2.0 / 3.0) * scale, (j as f64 + 2.0 / 3.0) * scale];
    (0..divisions).flat_map(move |i| {
        let up = (0..divisions - i).map(move |j| upward(i, j));
        up.chain((0..(divisions - i).saturating_sub(1)).map(move |j| downward(i, j)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_integrate_their_polynomials() {
        for n in 1..=30 {
            let rule = gauss_legendre(n);
            for power in 0..2 * n {
                let sum: f64 = rule.iter().map(|(x, w)| w * x.powi(power as i32)).sum();
                // Residual seen: 4e-15.
                assert!((sum * (power + 1) as f64 - 1.0).abs() < 1e-12, "{n} {power} {sum}");
            }
        }
    }

    #[test]
    fn the_rule_of_a_tetrahedron_is_exact_to_the_fifth_degree() {
        let factorial = |n: usize| (1..=n).map(|k| k as f64).product::<f64>();
        for (a, b, c) in (0..216).map(|k| (k % 6, k / 6 % 6, k / 36)) {
            if a + b + c > 5 {
                continue;
            }
            let term = |(at, w): &([f64; 4], f64)| {
                w * at[0].powi(a as i32) * at[1].powi(b as i32) * at[2].powi(c as i32)
            };
            let sum: f64 = TETRAHEDRON_FIFTH_DEGREE.iter().map(term).sum();
            let exact = 6.0 * factorial(a) * factorial(b) * factorial(c) / factorial(a + b + c + 3);
            // Residual seen: 2e-16.
            assert!((sum - exact).abs() < 1e-15, "{a} {b} {c}: {sum} {exact}");
        }
    }

    #[test]
    fn parts_of_a_triangle_have_its_moments() {
        for divisions in [1, 2, 5] {
            let all: Vec<[f64; 2]> = parts_of_triangle(divisions).collect();
            assert_eq!(all.len(), divisions * divisions);
            let mean = all.iter().map(|[u, _]| u).sum::<f64>() / all.len() as f64;
            assert!((mean - 1.0 / 3.0).abs() < 1e-14, "{mean}");
        }
    }
}
