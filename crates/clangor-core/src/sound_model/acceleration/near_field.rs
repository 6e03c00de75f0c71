//! The field close to a body, inside the ball where its multipoles converge.
//!
//! Multipoles about the centre of mass are valid only outside the bounding sphere, and converge slowly just
//! outside it. Closer to the body, the pressure is the boundary integral over the surface,
//!
//! ```text
//! p(x) = ∫ (p ∂G/∂n + ρ a_n G) dS,    G = e^{−ikr}/(4πr)
//! ```
//!
//! with the surface pressure p of the solver, linear on each triangle, and a_n of the rigid motion.
//!
//! A triangle that is small against its distance has one quadrature point, a nearer one seven. An even nearer
//! one is divided in four, recursively, down to a thousandth of its size. The pressure at x takes
//! milliseconds instead of microseconds.
//!
//! A bowl has 14 000 vertices, six motions and 40 nodes. However, around its axis and between mirror images,
//! the pressure of a motion is the same spectrum times a number. Each spectrum is therefore stored once, in
//! 16 bits, and each vertex and motion refers to one with a factor. Spectra that differ by less than
//! [`SAME_SPECTRUM`] of their size count as equal.

use glam::DVec3;
use num_complex::Complex32;

use crate::geometry::tri_mesh::TriMesh;
use crate::math::random::SplitMix;
use crate::sound_model::acceleration::field::{Node, RIGID_DOFS};
use crate::sound_model::acceleration::field_evaluator::{FieldError, GROUP, NodeGroup};

/// Distance from the centre of mass, over R, from which on only the multipoles count.
pub const FAR: f64 = 1.2;
/// Distance, over R, up to which only the boundary integral counts.
pub const NEAR: f64 = 1.1;
/// Largest number of divisions of a triangle.
const MAX_DIVISIONS: u32 = 10;

/// Difference of two spectra, over their size, below which they are merged.
pub const SAME_SPECTRUM: f64 = 5e-5;
/// Ratio to the loudest spectrum below which a spectrum counts as zero.
const SILENT: f64 = 1e-7;

/// Surface pressures of the six motions, in the units of
/// [`AccelerationField`](crate::sound_model::acceleration::field::AccelerationField): lengths over R, s =
/// ikR, p/(ρ R) for z = (a, R α).
#[derive(Clone, Debug, PartialEq)]
pub struct NearField {
    /// The surface, its vertices over R, the centre of mass at the origin.
    pub surface: TriMesh,
    /// Real and imaginary parts of each spectrum at the nodes of the field, in units of its scale.
    pub spectra: Vec<[i16; 2]>,
    /// Scale of each spectrum.
    pub scales: Vec<f32>,
    /// Index of the spectrum, for each vertex, for each degree of freedom.
    pub which: Vec<u32>,
    /// Factor on that spectrum.
    pub factors: Vec<f32>,
}

/// A point of a quadrature.
struct Sample {
    position: DVec3,
    /// Normal times weight.
    area: DVec3,
    /// Barycentric coordinates in the whole triangle.
    place: [f64; 3],
}

impl NearField {
    /// From pressures, for each vertex, for each degree of freedom, at this number of nodes, in the order of
    /// the field.
    pub fn from_pressures(surface: TriMesh, nodes: usize, pressures: &[Complex32]) -> Self {
        let rows: Vec<&[Complex32]> = pressures.chunks_exact(nodes.max(1)).collect();
        let square = |x: f32| f64::from(x) * f64::from(x);
        let size = |row: &[Complex32]| row.iter().map(|p| square(p.re) + square(p.im)).sum::<f64>().sqrt();
        let sizes: Vec<f64> = rows.iter().map(|row| size(row)).collect();
        let silent = SILENT * sizes.iter().fold(0.0, |m: f64, s| m.max(*s));
        // Equal spectra have equal projections on any vector, up to the sign.
        let mut random = SplitMix::new(1);
        let probe: Vec<[f64; 2]> = (0..nodes).map(|_| [(); 2].map(|()| random.uniform(-1.0, 1.0))).collect();
        let probe_size = probe.iter().flatten().map(|p| p * p).sum::<f64>().sqrt();
        let project = |row: &[Complex32]| -> f64 {
            row.iter().zip(&probe).map(|(p, [a, b])| f64::from(p.re) * a + f64::from(p.im) * b).sum()
        };
        let mut order: Vec<(f64, usize)> = (0..rows.len())
            .filter(|&at| sizes[at] > silent)
            .map(|at| ((project(rows[at]) / sizes[at]).abs(), at))
            .collect();
        order.sort_by(|p, q| p.0.total_cmp(&q.0).then(p.1.cmp(&q.1)));

        let mut near = NearField {
            surface,
            spectra: Vec::new(),
            scales: Vec::new(),
            which: vec![0; rows.len()],
            // Values that are not finite are kept; evaluators reject them.
            factors: sizes.iter().map(|size| if size.is_finite() { 0.0 } else { f32::NAN }).collect(),
        };
        // Spectra whose projection is little below: index, and a row that has them.
        let mut recent: Vec<(f64, u32, usize)> = Vec::new();
        for (projection, at) in order {
            recent.retain(|(before, ..)| projection - before <= SAME_SPECTRUM * probe_size);
            let likeness = |other: usize| -> f64 {
                let pairs = rows[at].iter().zip(rows[other]);
                let dot = |p: f32, q: f32| f64::from(p) * f64::from(q);
                let dot: f64 = pairs.map(|(p, q)| dot(p.re, q.re) + dot(p.im, q.im)).sum();
                dot / (sizes[at] * sizes[other])
            };
            // |u − v|² = 2 − 2 u·v for u and v of size 1.
            let same = |likeness: f64| 2.0 - 2.0 * likeness.abs() <= SAME_SPECTRUM * SAME_SPECTRUM;
            let known = recent.iter().map(|(_, number, row)| (*number, *row, likeness(*row)));
            let (number, row, likeness) = match { known }.find(|(_, _, likeness)| same(*likeness)) {
                Some(known) => known,
                None => {
                    let number = near.add_spectrum(rows[at]);
                    recent.push((projection, number, at));
                    (number, at, 1.0)
                }
            };
            near.which[at] = number;
            near.factors[at] = (likeness * sizes[at] / sizes[row]) as f32;
        }
        near
    }

    fn add_spectrum(&mut self, row: &[Complex32]) -> u32 {
        let largest = row.iter().fold(0.0f32, |m, p| m.max(p.re.abs()).max(p.im.abs()));
        let inverse = f64::from(i16::MAX) / f64::from(largest);
        let rounded = |x: f32| (f64::from(x) * inverse).round() as i16;
        self.spectra.extend(row.iter().map(|p| [rounded(p.re), rounded(p.im)]));
        self.scales.push(largest / f32::from(i16::MAX));
        self.scales.len() as u32 - 1
    }

    /// Rejects what would put NaN or wrong values into the sound of a field with this number of nodes.
    pub(super) fn check(&self, nodes: usize) -> Result<(), FieldError> {
        let NearField { surface: TriMesh { vertices, triangles }, spectra, scales, which, factors } = self;
        let expected = vertices.len() * RIGID_DOFS;
        if which.len() != expected || factors.len() != expected || spectra.len() != scales.len() * nodes {
            return Err(FieldError::Lengths {
                terms: expected,
                nodes,
                expected: scales.len() * nodes,
                real: spectra.len(),
                imaginary: which.len().min(factors.len()),
            });
        }
        let corner = triangles.iter().flatten().find(|i| **i as usize >= vertices.len());
        if let Some(corner) = corner {
            let value = f64::from(*corner);
            return Err(FieldError::Number { what: "a corner of the near field's surface", value });
        }
        let missing =
            which.iter().zip(factors).find(|(i, factor)| **factor != 0.0 && **i as usize >= scales.len());
        if let Some((number, _)) = missing {
            let value = f64::from(*number);
            return Err(FieldError::Number { what: "the number of a spectrum of the near field", value });
        }
        let coordinates = vertices.iter().flat_map(|v| v.to_array());
        let pressures = scales.iter().chain(factors).map(|p| f64::from(*p));
        match coordinates.chain(pressures).find(|x| !x.is_finite()) {
            Some(value) => Err(FieldError::Number { what: "a number of the near field", value }),
            None => Ok(()),
        }
    }

    /// p e^{s|x|}/(ρ R) at the nodes, for z = (a, R α), at `x` in units of R outside the body.
    pub fn at_nodes(&self, nodes: &[Node], z: &[f64; RIGID_DOFS], x: DVec3, values: &mut Vec<NodeGroup>) {
        let groups = nodes.len().div_ceil(GROUP);
        values.clear();
        values.resize(groups, NodeGroup::default());
        let pressure = self.surface_pressure(nodes.len(), z);
        let (linear, angular) = (DVec3::from_slice(&z[..3]), DVec3::from_slice(&z[3..]));
        let distance = x.length();
        for (t, triangle) in self.surface.triangles.iter().enumerate() {
            let corners = self.surface.corners(t);
            let of_corners = triangle.map(|i| &pressure[i as usize * groups..][..groups]);
            let whole = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
            divide(corners, whole, x, MAX_DIVISIONS, &mut |sample: &Sample| {
                let towards = x - sample.position;
                let r = towards.length().max(1e-12);
                // ∂/∂n at the surface: of r it is −n·(x − y)/r.
                let slope = -sample.area.dot(towards) / r;
                let motion = linear.dot(sample.area) + angular.dot(sample.position.cross(sample.area));
                let spread = 1.0 / (4.0 * std::f64::consts::PI * r);
                for (group, value) in values.iter_mut().enumerate() {
                    let mut p = NodeGroup::default();
                    for (corner, weight) in of_corners.iter().zip(sample.place) {
                        for lane in 0..GROUP {
                            p.re[lane] += weight * corner[group].re[lane];
                            p.im[lane] += weight * corner[group].im[lane];
                        }
                    }
                    for (lane, node) in nodes[group * GROUP..].iter().take(GROUP).enumerate() {
                        // G e^{s|x|}; ∂G/∂n = −(s + 1/r) G ∂r/∂n.
                        let size = spread * (node.s.re * (distance - r)).exp();
                        let (sin, cos) = (node.s.im * (distance - r)).sin_cos();
                        let (green_re, green_im) = (size * cos, size * sin);
                        let re =
                            motion - slope * ((node.s.re + 1.0 / r) * p.re[lane] - node.s.im * p.im[lane]);
                        let im = -slope * ((node.s.re + 1.0 / r) * p.im[lane] + node.s.im * p.re[lane]);
                        value.re[lane] += green_re * re - green_im * im;
                        value.im[lane] += green_re * im + green_im * re;
                    }
                }
            });
        }
    }

    /// Pressure of the motion z at the vertices: for each vertex, the groups of nodes.
    fn surface_pressure(&self, nodes: usize, z: &[f64; RIGID_DOFS]) -> Vec<NodeGroup> {
        let groups = nodes.div_ceil(GROUP);
        let mut pressure = vec![NodeGroup::default(); self.surface.vertices.len() * groups];
        for (row, (which, factor)) in self.which.iter().zip(&self.factors).enumerate() {
            let factor = z[row % RIGID_DOFS] * f64::from(*factor);
            if factor == 0.0 {
                continue;
            }
            let which = *which as usize;
            let factor = factor * f64::from(self.scales[which]);
            let at = row / RIGID_DOFS * groups;
            let spectrum = &self.spectra[which * nodes..][..nodes];
            for (value, spectrum) in pressure[at..].iter_mut().zip(spectrum.chunks(GROUP)) {
                for (lane, [re, im]) in spectrum.iter().enumerate() {
                    value.re[lane] += factor * f64::from(*re);
                    value.im[lane] += factor * f64::from(*im);
                }
            }
        }
        pressure
    }
}

/// Gives the quadrature points of a triangle as seen from x.
fn divide(
    corners: [DVec3; 3],
    places: [[f64; 3]; 3],
    x: DVec3,
    divisions: u32,
    take: &mut impl FnMut(&Sample),
) {
    let [a, b, c] = corners;
    let centre = (a + b + c) / 3.0;
    let size = (b - a).length().max((c - b).length()).max((a - c).length());
    let distance = (x - centre).length() / size.max(1e-300);
    let area = 0.5 * (b - a).cross(c - a);
    if distance < 2.0 && divisions > 0 {
        let middle = |p: [f64; 3], q: [f64; 3]| std::array::from_fn(|i| 0.5 * (p[i] + q[i]));
        let [u, v, w] = places;
        let (vw, wu, uv) = (middle(v, w), middle(w, u), middle(u, v));
        let (bc, ca, ab) = (0.5 * (b + c), 0.5 * (c + a), 0.5 * (a + b));
        for (corners, places) in [
            ([a, ab, ca], [u, uv, wu]),
            ([ab, b, bc], [uv, v, vw]),
            ([ca, bc, c], [wu, vw, w]),
            ([bc, ca, ab], [vw, wu, uv]),
        ] {
            divide(corners, places, x, divisions - 1, take);
        }
        return;
    }
    let rule: &[([f64; 3], f64)] = if distance > 8.0 { &ONE_POINT } else { &SEVEN_POINTS };
    for (local, weight) in rule {
        let place = std::array::from_fn(|i| (0..3).map(|k| local[k] * places[k][i]).sum());
        let position = local[0] * a + local[1] * b + local[2] * c;
        take(&Sample { position, area: *weight * area, place });
    }
}

const ONE_POINT: [([f64; 3], f64); 1] = [([1.0 / 3.0; 3], 1.0)];

/// Radon's rule, exact to degree 5.
const SEVEN_POINTS: [([f64; 3], f64); 7] = {
    const A: f64 = 0.059_715_871_789_769_82;
    const B: f64 = 0.470_142_064_105_115_1;
    const C: f64 = 0.797_426_985_353_087_3;
    const D: f64 = 0.101_286_507_323_456_34;
    const U: f64 = 0.132_394_152_788_506_2;
    const V: f64 = 0.125_939_180_544_827_15;
    [
        ([1.0 / 3.0; 3], 0.225),
        ([A, B, B], U),
        ([B, A, B], U),
        ([B, B, A], U),
        ([C, D, D], V),
        ([D, C, D], V),
        ([D, D, C], V),
    ]
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spectra_that_differ_by_a_factor_are_kept_once() {
        let (nodes, vertices) = (9, 60);
        let spectrum = |kind: usize, j: usize| {
            Complex32::new((1.0 + (kind * 7 + j) as f32).sin(), (0.3 * (kind * 5 + j) as f32).cos())
        };
        // As around an axis: two rings of vertices, motions of order 0 and 1, one of them silent.
        let pressure = |vertex: usize, degree: usize, j: usize| {
            let (ring, angle) = (vertex % 2, 0.1 * vertex as f32);
            let factor = [angle.cos(), 1.0, angle.sin(), angle.sin(), 0.0, -angle.cos()][degree];
            factor * spectrum(6 * ring + [0, 1, 0, 2, 3, 2][degree], j)
        };
        let pressures: Vec<Complex32> = (0..vertices)
            .flat_map(|v| (0..RIGID_DOFS).flat_map(move |d| (0..nodes).map(move |j| pressure(v, d, j))))
            .collect();
        let surface = TriMesh { vertices: vec![DVec3::X; vertices], triangles: Vec::new() };
        let near = NearField::from_pressures(surface, nodes, &pressures);
        assert_eq!(near.scales.len(), 6);
        assert!(near.check(nodes).is_ok());
        for (at, expected) in pressures.iter().enumerate() {
            let (row, j) = (at / nodes, at % nodes);
            let which = near.which[row] as usize;
            let [re, im] = near.spectra[which * nodes + j].map(f32::from);
            let value = near.factors[row] * near.scales[which] * Complex32::new(re, im);
            // Residual seen: 2.2e-5 of the largest, of 16 bits.
            assert!((value - expected).norm() < 5e-5, "{row} {j}: {value} {expected}");
        }
    }
}
