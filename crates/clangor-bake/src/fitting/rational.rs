//! Rational interpolation in frequency of many functions that share their poles.
//!
//! The set-valued AAA algorithm (Nakatsukasa, Sète and Trefethen 2018; Lietaert and others 2022): nodes are
//! taken one by one from the samples, each where the error is largest; the weights of
//!
//! ```text
//! r(s) = N(s)/D(s)
//! N(s) = Σ_j [ w_j f_j/(s − s_j) + conj(w_j f_j)/(s − conj s_j) ]
//! D(s) = Σ_j [ w_j/(s − s_j) + conj(w_j)/(s − conj s_j) ]
//! ```
//!
//! minimise the linearised residual over all samples and functions. The mirrored nodes make r(conj s) = conj
//! r(s): the response in time is real. Poles are common to all functions, as those of a body are to all
//! directions.

mod loewner;

use clangor_core::sound_model::acceleration::field::Node;
use faer::{Mat, Side};
use num_complex::Complex64;

use self::loewner::LoewnerMatrix;

/// A sample: s, the values of the functions there, and their error scales.
#[derive(Clone, Debug, PartialEq)]
pub struct FunctionSample {
    /// s, with Im s ≥ 0.
    pub s: Complex64,
    /// Values of the functions.
    pub values: Vec<Complex64>,
    /// 1 over the magnitude that corresponds to an error of 100 % for each function.
    pub weights: Vec<f64>,
    /// Number of consecutive functions that share an error: the root of their mean square.
    pub group: usize,
}

/// Nodes among the samples, and their weights.
#[derive(Clone, Debug, PartialEq)]
pub struct RationalFit {
    /// Which samples are nodes.
    pub support: Vec<usize>,
    /// The nodes, in the same order.
    pub nodes: Vec<Node>,
    /// Largest error at a sample.
    pub error: f64,
}

/// A fit, and the best with fewer nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct NestedFits {
    /// The fit.
    pub best: RationalFit,
    /// The best with fewer nodes; the fit itself if that has one.
    pub fewer: RationalFit,
}

/// Fits with the fewest nodes that reach `tolerance`, at most `most`.
///
/// With too few samples for the tolerance, all but one become nodes; the error is that at the last.
pub fn fit(samples: &[FunctionSample], tolerance: f64, most: usize) -> RationalFit {
    fit_nested(samples, tolerance, most).best
}

/// As [`fit`], together with the fit that the steps before it had reached.
pub fn fit_nested(samples: &[FunctionSample], tolerance: f64, most: usize) -> NestedFits {
    fit_from(samples, &[], tolerance, most)
}

/// As [`fit_nested`], with these samples for the first nodes: those of a fit to fewer samples save the steps
/// up to them.
pub fn fit_from(samples: &[FunctionSample], first: &[usize], tolerance: f64, most: usize) -> NestedFits {
    let most = most.min(samples.len().saturating_sub(1)).max(1);
    let mut best = RationalFit { support: Vec::new(), nodes: Vec::new(), error: f64::INFINITY };
    let mut fewer = best.clone();
    if samples.is_empty() {
        return NestedFits { best, fewer };
    }
    let mut matrix = LoewnerMatrix::new(samples);
    let (mut next, before) = match first.split_last() {
        Some((last, before)) => (*last, before),
        None => (loudest(samples), first),
    };
    before.iter().take(most - 1).for_each(|node| matrix.push(*node));
    while matrix.nodes().len() < most {
        matrix.push(next);
        let weights = least_residual(&matrix);
        let node = |(&i, w): (&usize, &[f64])| Node { s: samples[i].s, weight: Complex64::new(w[0], w[1]) };
        let nodes: Vec<Node> = matrix.nodes().iter().zip(weights.chunks_exact(2)).map(node).collect();
        // Largest error at the samples that are no nodes.
        let mut error = 0.0;
        for (i, squares) in matrix.residual(&weights) {
            let below: Complex64 = nodes.iter().map(|node| below(node, samples[i].s)).sum();
            let here = worst_group(&squares, samples[i].group) / below.norm();
            if here > error || (here == error && i > next) {
                (error, next) = (here, i);
            }
        }
        let none = best.nodes.is_empty();
        if none || error < best.error {
            let found = RationalFit { support: matrix.nodes().to_vec(), nodes, error };
            fewer = if none { found.clone() } else { best };
            best = found;
        }
        if error <= tolerance {
            break;
        }
    }
    NestedFits { best, fewer }
}

/// The sample with the largest weighted value.
fn loudest(samples: &[FunctionSample]) -> usize {
    let size = |s: &FunctionSample| -> f64 {
        s.values.iter().zip(&s.weights).map(|(v, w)| (v * w).norm_sqr()).sum()
    };
    (0..samples.len()).max_by(|&a, &b| size(&samples[a]).total_cmp(&size(&samples[b]))).unwrap_or(0)
}

/// The weighted error at a sample, of the worst group of functions.
pub fn error_at(samples: &[FunctionSample], support: &[usize], nodes: &[Node], at: &FunctionSample) -> f64 {
    let predicted = predict(samples, support, nodes, at.s);
    let squares: Vec<f64> = predicted
        .iter()
        .zip(&at.values)
        .zip(&at.weights)
        .map(|((p, v), w)| ((p - v) * *w).norm_sqr())
        .collect();
    worst_group(&squares, at.group)
}

/// Root of the mean square of the worst group of consecutive functions.
fn worst_group(squares: &[f64], group: usize) -> f64 {
    let mean = |group: &[f64]| group.iter().sum::<f64>() / group.len() as f64;
    squares.chunks(group.max(1)).map(mean).fold(0.0, f64::max).sqrt()
}

/// The part of a node in the denominator.
fn below(node: &Node, s: Complex64) -> Complex64 {
    node.weight / (s - node.s) + node.weight.conj() / (s - node.s.conj())
}

/// Values of all functions at `s`.
pub fn predict(
    samples: &[FunctionSample],
    support: &[usize],
    nodes: &[Node],
    s: Complex64,
) -> Vec<Complex64> {
    let count = samples.first().map_or(0, |s| s.values.len());
    let mut above = vec![Complex64::ZERO; count];
    let mut below = Complex64::ZERO;
    // At a node the value is that of its sample.
    let nearest = (1e-14 * (1.0 + s.norm())).powi(2);
    for (&i, node) in support.iter().zip(nodes) {
        if (s - node.s).norm_sqr() < nearest {
            return samples[i].values.clone();
        }
        let here = node.weight / (s - node.s);
        let mirrored = node.weight.conj() / (s - node.s.conj());
        below += here + mirrored;
        for (sum, value) in above.iter_mut().zip(&samples[i].values) {
            *sum += here * value + mirrored * value.conj();
        }
    }
    above.iter().map(|a| a / below).collect()
}

/// Weights of unit length that minimise the linearised residual, as real and imaginary parts: the last
/// eigenvector of the Gram matrix.
///
/// The Gram matrix squares the condition number: residuals below 1e-8 of the largest are indistinguishable,
/// far below the error of any solver.
fn least_residual(matrix: &LoewnerMatrix<'_>) -> Vec<f64> {
    let columns = 2 * matrix.nodes().len();
    let gram = Mat::from_fn(columns, columns, |a, b| matrix.product(a.max(b), a.min(b)));
    match gram.self_adjoint_eigen(Side::Lower) {
        Ok(eigen) => eigen.U().col(0).iter().copied().collect(),
        Err(_) => [1.0, 0.0].repeat(matrix.nodes().len()),
    }
}

/// Poles of a fit: the zeros of its denominator.
///
/// Besides 0 the eigenvalues of Λ − e wᵀΛ/(wᵀe) are the zeros of Σ w/(s − s_j): its left eigenvector of 0 is
/// w, so every other right eigenvector (Λ − λ)⁻¹e is orthogonal to w.
pub fn poles(nodes: &[Node]) -> Vec<Complex64> {
    let all: Vec<(Complex64, Complex64)> =
        nodes.iter().flat_map(|n| [(n.s, n.weight), (n.s.conj(), n.weight.conj())]).collect();
    // Shifted, so that the extra eigenvalue lies far in the right half plane, away from the poles of a body.
    let shift = 2.0 * all.iter().map(|(s, _)| s.norm()).fold(1.0, f64::max);
    let total: Complex64 = all.iter().map(|(_, w)| w).sum();
    let matrix = Mat::<Complex64>::from_fn(all.len(), all.len(), |a, b| {
        let diagonal = if a == b { all[a].0 - shift } else { Complex64::ZERO };
        diagonal - all[b].1 * (all[b].0 - shift) / total
    });
    let Ok(values) = matrix.eigenvalues() else { return Vec::new() };
    let extra = (0..values.len()).min_by(|&a, &b| values[a].norm().total_cmp(&values[b].norm()));
    values.iter().enumerate().filter(|(k, _)| Some(*k) != extra).map(|(_, v)| v + shift).collect()
}

/// Size of the residue of each function at a pole.
pub fn residues(samples: &[FunctionSample], support: &[usize], nodes: &[Node], pole: Complex64) -> Vec<f64> {
    let count = samples.first().map_or(0, |s| s.values.len());
    let mut above = vec![Complex64::ZERO; count];
    let mut slope = Complex64::ZERO;
    for (&i, node) in support.iter().zip(nodes) {
        let here = node.weight / (pole - node.s);
        let mirrored = node.weight.conj() / (pole - node.s.conj());
        slope -= here / (pole - node.s) + mirrored / (pole - node.s.conj());
        for (sum, value) in above.iter_mut().zip(&samples[i].values) {
            *sum += here * value + mirrored * value.conj();
        }
    }
    above.iter().map(|a| (a / slope).norm()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sphere's dipole at two distances: poles −1 ± i, nothing else.
    fn sphere(s: Complex64) -> FunctionSample {
        let below = 2.0 + 2.0 * s + s * s;
        let values: Vec<Complex64> = [1.0, 3.0].iter().map(|r| (s / r + 1.0 / (r * r)) / below).collect();
        let weights = vec![1.0; values.len()];
        FunctionSample { s, values, weights, group: 1 }
    }

    #[test]
    fn the_poles_of_a_sphere_are_found() {
        let samples: Vec<FunctionSample> =
            (0..8).map(|k| sphere(Complex64::new(0.02, 0.1 + 0.4 * k as f64))).collect();
        let fit = fit(&samples, 1e-9, 10);
        assert_eq!(fit.nodes.len(), 2);
        let mut poles = poles(&fit.nodes);
        poles.sort_by(|a, b| a.im.total_cmp(&b.im));
        let near = |p: Complex64| poles.iter().map(|q| (q - p).norm()).fold(f64::INFINITY, f64::min);
        // Residual seen: 1e-7.
        assert!(
            near(Complex64::new(-1.0, 1.0)) < 1e-5 && near(Complex64::new(-1.0, -1.0)) < 1e-5,
            "{poles:?}"
        );
        let held_out = sphere(Complex64::new(0.0, 1.234));
        // Residual seen: 2e-16.
        assert!(error_at(&samples, &fit.support, &fit.nodes, &held_out) < 1e-7);
    }

    /// Five damped resonances in seven functions of different weights, in groups of two.
    fn resonances(s: Complex64) -> FunctionSample {
        let value = |v: usize| -> Complex64 {
            (0..5)
                .map(|j| {
                    let pole = Complex64::new(-0.03 - 0.05 * j as f64, 0.7 + 0.9 * j as f64);
                    let a = Complex64::cis((1 + 3 * v + v * j) as f64);
                    a / (s - pole) + a.conj() / (s - pole.conj())
                })
                .sum()
        };
        let weights = (0..7).map(|v| 0.1 + 0.05 * v as f64).collect();
        FunctionSample { s, values: (0..7).map(value).collect(), weights, group: 2 }
    }

    /// Weights from the Loewner matrix as it is defined.
    fn weights_by_definition(samples: &[FunctionSample], support: &[usize]) -> Vec<Complex64> {
        let mut rows: Vec<Vec<Complex64>> = Vec::new();
        for at in (0..samples.len()).filter(|i| !support.contains(i)).map(|i| &samples[i]) {
            rows.extend(at.values.iter().enumerate().map(|(v, value)| {
                let column = |j: &usize| {
                    let node = &samples[*j];
                    let direct = (value - node.values[v]) / (at.s - node.s) * at.weights[v];
                    let mirrored = (value - node.values[v].conj()) / (at.s - node.s.conj()) * at.weights[v];
                    [direct + mirrored, Complex64::I * (direct - mirrored)]
                };
                support.iter().flat_map(column).collect::<Vec<_>>()
            }));
        }
        let product = |a: usize, b: usize| rows.iter().map(|row| (row[a].conj() * row[b]).re).sum::<f64>();
        let gram = Mat::from_fn(2 * support.len(), 2 * support.len(), product);
        let eigen = gram.self_adjoint_eigen(Side::Lower).unwrap();
        let vector = eigen.U().col(0);
        (0..support.len()).map(|j| Complex64::new(vector[2 * j], vector[2 * j + 1])).collect()
    }

    #[test]
    fn a_fit_is_that_of_the_matrix_by_its_definition() {
        let samples: Vec<FunctionSample> =
            (0..40).map(|k| resonances(Complex64::new(0.0, 0.05 + 0.11 * k as f64))).collect();
        for most in 1..5 {
            let NestedFits { best, fewer } = fit_nested(&samples, 0.0, most);
            assert!(fewer.nodes.len() <= best.nodes.len() && fewer.error >= best.error);
            assert_eq!(fewer, fit(&samples, 0.0, best.nodes.len().saturating_sub(1).max(1)));
            assert_eq!(fit_from(&samples, &best.support, 0.0, best.nodes.len()).best, best);
            let nodes: Vec<Node> = weights_by_definition(&samples, &best.support)
                .into_iter()
                .zip(&best.support)
                .map(|(weight, i)| Node { s: samples[*i].s, weight })
                .collect();
            let others: Vec<&FunctionSample> =
                (0..40).filter(|i| !best.support.contains(i)).map(|i| &samples[i]).collect();
            let errors = |nodes: &[Node]| -> Vec<f64> {
                others.iter().map(|at| error_at(&samples, &best.support, nodes, at)).collect()
            };
            let (found, expected) = (errors(&best.nodes), errors(&nodes));
            let largest = expected.iter().copied().fold(0.0, f64::max);
            let apart = found.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            // Residuals seen: 8e-13 and 5e-13.
            assert!(apart < 1e-9 * largest && (best.error / largest - 1.0).abs() < 1e-9, "{most} nodes");
        }
    }
}
