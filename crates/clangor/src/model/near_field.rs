//! The field close to a body, inside the ball where its multipoles converge.
//!
//! Multipoles about the centre of mass are valid outside the bounding sphere only, and converge slowly just outside it.
//! Closer, the pressure is the boundary integral over the surface,
//!
//! ```text
//! p(x) = ∫ (p ∂G/∂n + ρ a_n G) dS,    G = e^{−ikr}/(4πr)
//! ```
//!
//! with the surface pressure p that the solver found, linear on each triangle, and a_n of the rigid motion.
//!
//! Each triangle has one quadrature point where it is small against its distance, seven where it is nearer, and is
//! divided in four where it is nearer still, down to a thousandth of its size. The pressure at x takes milliseconds
//! instead of microseconds.

use glam::DVec3;

use super::acceleration_field::{DEGREES, Node};
use super::playable_field::{FieldError, GROUP, NodeGroup};
use crate::geometry::tri_mesh::TriMesh;

/// Distance from the centre of mass, over R, from which on the multipoles speak alone.
pub const FAR: f64 = 1.2;
/// Distance, over R, up to which the boundary integral speaks alone.
pub const NEAR: f64 = 1.1;
/// Divisions of a triangle, at most.
const MAX_DIVISIONS: u32 = 10;

/// Surface pressures of the six motions, in the units of
/// [`AccelerationField`](super::acceleration_field::AccelerationField): lengths over R, s = ikR, p/(ρ R) for z = (a, R α).
#[derive(Clone, Debug, PartialEq)]
pub struct NearField {
    /// The surface, its vertices over R, the centre of mass at the origin.
    pub surface: TriMesh,
    /// Real parts: for each vertex, for each degree of freedom, the values at the nodes of the field.
    pub real: Vec<f32>,
    /// Imaginary parts.
    pub imaginary: Vec<f32>,
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
    /// Refuses what would put NaN or nonsense into the sound of a field with so many nodes.
    pub(super) fn check(&self, nodes: usize) -> Result<(), FieldError> {
        let TriMesh { vertices, triangles } = &self.surface;
        let expected = vertices.len() * DEGREES * nodes;
        let (real, imaginary) = (self.real.len(), self.imaginary.len());
        if real != expected || imaginary != expected {
            return Err(FieldError::Lengths {
                terms: vertices.len() * DEGREES,
                nodes,
                expected,
                real,
                imaginary,
            });
        }
        let corner = triangles.iter().flatten().find(|i| **i as usize >= vertices.len());
        if let Some(corner) = corner {
            return Err(FieldError::Number {
                what: "a corner of the near field's surface",
                value: f64::from(*corner),
            });
        }
        let coordinates = vertices.iter().flat_map(|v| v.to_array());
        let pressures = self.real.iter().chain(&self.imaginary).map(|p| f64::from(*p));
        match coordinates.chain(pressures).find(|x| !x.is_finite()) {
            Some(value) => Err(FieldError::Number { what: "a number of the near field", value }),
            None => Ok(()),
        }
    }

    /// p e^{s|x|}/(ρ R) at the nodes, for z = (a, R α), at `x` in units of R outside the body.
    pub fn at_nodes(&self, nodes: &[Node], z: &[f64; DEGREES], x: DVec3, values: &mut Vec<NodeGroup>) {
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
    fn surface_pressure(&self, nodes: usize, z: &[f64; DEGREES]) -> Vec<NodeGroup> {
        let groups = nodes.div_ceil(GROUP);
        let mut pressure = vec![NodeGroup::default(); self.surface.vertices.len() * groups];
        let real = self.real.chunks_exact(nodes);
        let rows = real.zip(self.imaginary.chunks_exact(nodes));
        for (row, (real, imaginary)) in rows.enumerate() {
            let factor = z[row % DEGREES];
            let at = row / DEGREES * groups;
            for (j, (re, im)) in real.iter().zip(imaginary).enumerate() {
                let value = &mut pressure[at + j / GROUP];
                value.re[j % GROUP] += factor * f64::from(*re);
                value.im[j % GROUP] += factor * f64::from(*im);
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
