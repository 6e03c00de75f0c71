//! The surface of an ellipsoid as six-node triangles, and motions on it from their harmonics.

use std::collections::BTreeMap;

use clangor_core::math::spherical_harmonics::HarmonicTable;
use clangor_core::sound_model::modal::surface::ModalSurface;
use clangor_core::sound_model::soundbank::modal_soundbank::parity_harmonics;
use glam::DVec3;

/// Triangles along an edge of an octant, for each degree of the shapes.
const DIVISIONS_PER_DEGREE: f64 = 0.75;

/// Triangles of six nodes on an ellipsoid, and the harmonics at the nodes.
pub struct EllipsoidSurface {
    /// The triangles.
    pub surface: ModalSurface,
    degree: usize,
    /// Harmonics in the direction ξ = x/(a, b, c) of each node.
    harmonics: Vec<Vec<f64>>,
}

impl EllipsoidSurface {
    /// The faces of an octahedron, divided and projected onto the unit ball, then mapped to the ellipsoid;
    /// fine enough for shapes of this degree.
    pub fn new(semi_axes: DVec3, degree: usize) -> Self {
        let divisions = ((DIVISIONS_PER_DEGREE * degree as f64).ceil() as usize).max(4);
        let (directions, triangles) = divided_octahedron(divisions);
        let table = HarmonicTable::new(degree);
        let harmonics = directions
            .iter()
            .map(|direction| {
                let mut values = Vec::new();
                table.evaluate(*direction, &mut values);
                values
            })
            .collect();
        let nodes = directions.iter().map(|direction| *direction * semi_axes).collect();
        EllipsoidSurface { surface: ModalSurface { nodes, triangles }, degree, harmonics }
    }

    /// Values of the harmonics of a parity class at the nodes.
    pub fn motion(&self, parity: u8, shape: &[Vec<f64>; 3]) -> Vec<DVec3> {
        let lists = [0, 1, 2].map(|axis| parity_harmonics(parity ^ (1 << axis), self.degree));
        let at = |values: &Vec<f64>| {
            DVec3::from_array(std::array::from_fn(|axis| {
                lists[axis].iter().zip(&shape[axis]).map(|(y, u)| values[*y as usize] * u).sum()
            }))
        };
        self.harmonics.iter().map(at).collect()
    }
}

/// Directions, and triangles of six of them: corners counter-clockwise from outside, then the middles of
/// their edges.
fn divided_octahedron(divisions: usize) -> (Vec<DVec3>, Vec<[u32; 6]>) {
    let fine = 2 * divisions as i64;
    let mut known: BTreeMap<[i64; 3], u32> = BTreeMap::new();
    let mut directions = Vec::new();
    let mut triangles = Vec::new();
    // Each octant: lattice nodes, shared at the borders, and their triangles.
    for octant in 0..8 {
        let sign = [0, 1, 2].map(|axis| if octant >> axis & 1 == 1 { -1 } else { 1 });
        let flipped = sign.iter().product::<i64>() < 0;
        // Lattice points on the face |x| + |y| + |z| = `fine`.
        let mut node = |i: i64, j: i64| {
            let key = [sign[0] * (fine - i - j), sign[1] * i, sign[2] * j];
            *known.entry(key).or_insert_with(|| {
                directions.push(DVec3::from_array(key.map(|k| k as f64)).normalize());
                directions.len() as u32 - 1
            })
        };
        let mut add = |a: [i64; 2], b: [i64; 2], c: [i64; 2]| {
            let (b, c) = if flipped { (c, b) } else { (b, c) };
            let middle = |p: [i64; 2], q: [i64; 2]| [(p[0] + q[0]) / 2, (p[1] + q[1]) / 2];
            let six = [a, b, c, middle(a, b), middle(b, c), middle(c, a)];
            triangles.push(six.map(|[i, j]| node(i, j)));
        };
        for i in (0..fine).step_by(2) {
            for j in (0..fine - i).step_by(2) {
                add([i, j], [i + 2, j], [i, j + 2]);
                if i + j + 2 < fine {
                    add([i + 2, j], [i + 2, j + 2], [i, j + 2]);
                }
            }
        }
    }
    (directions, triangles)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_surface_is_closed_and_outwards() {
        let surface = EllipsoidSurface::new(DVec3::new(0.2, 0.5, 0.9), 8).surface;
        let mass = clangor_core::geometry::mass_properties::MassProperties::of(&surface.quarters());
        let volume = mass.expect("a solid").volume;
        let exact = 4.0 / 3.0 * std::f64::consts::PI * 0.09;
        // Flat triangles lie inside.
        assert!(volume < exact && volume > 0.98 * exact, "{volume} {exact}");
        assert!((surface.radius() - 0.9).abs() < 1e-12);
    }
}
