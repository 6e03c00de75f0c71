//! The directions in which the published representation stores signals, and linear interpolation between
//! them.
//!
//! \[PAN\] §4.2: a uniform grid in polar and azimuthal angle, 5 × 10 or 40 × 80, interpolated linearly in
//! both angles. Differs: the paper does not say where its grid lies. Ours is about the z axis and has its
//! directions in the centres of the cells, so that none repeats; beyond the last row the neighbours are those
//! across the pole.
//!
//! \[PROXY\] §5: for bodies with three planes of symmetry one octant, triangulated: with 8 divisions of an
//! edge 64 triangles and 45 vertices. The other octants follow from the signs of \[PROXY\] eqs. (16)–(21): a
//! translation along an axis is odd in that coordinate and even in the others, a rotation about an axis the
//! other way round. Differs: the paper does not print its triangulation. Ours is the lattice of the
//! octahedron's face, projected onto the sphere.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use crate::sound_model::acceleration::field::RIGID_DOFS;

/// Where signals are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Directions {
    /// A grid in angles over the whole sphere.
    Angles {
        /// Divisions of the polar angle.
        rows: usize,
        /// Divisions of the azimuth; even.
        columns: usize,
    },
    /// A triangulated octant of a body with three planes of symmetry.
    Octant {
        /// Divisions of an edge.
        divisions: usize,
    },
}

/// Weights of the stored directions around a direction, at most four that are not zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Neighbours {
    /// Stored direction and its weight.
    pub weights: [(usize, f64); 4],
    /// Sign of each degree of freedom.
    pub signs: [f64; RIGID_DOFS],
}

impl Directions {
    /// The directions of \[PROXY\]: 45 in the octant.
    pub const OCTANT_45: Directions = Directions::Octant { divisions: 8 };

    /// Number of directions.
    pub fn count(self) -> usize {
        match self {
            Directions::Angles { rows, columns } => rows * columns,
            Directions::Octant { divisions } => (divisions + 1) * (divisions + 2) / 2,
        }
    }

    /// Whether there are directions on all sides.
    pub fn is_valid(self) -> bool {
        match self {
            Directions::Angles { rows, columns } => rows >= 1 && columns >= 2 && columns.is_multiple_of(2),
            Directions::Octant { divisions } => divisions >= 1,
        }
    }

    /// Unit vectors, in the order in which signals are stored.
    pub fn vectors(self) -> Vec<DVec3> {
        match self {
            Directions::Angles { rows, columns } => (0..rows * columns)
                .map(|i| {
                    let polar = PI * ((i / columns) as f64 + 0.5) / rows as f64;
                    let azimuth = TAU * (i % columns) as f64 / columns as f64;
                    DVec3::new(polar.sin() * azimuth.cos(), polar.sin() * azimuth.sin(), polar.cos())
                })
                .collect(),
            Directions::Octant { divisions } => (0..=divisions)
                .flat_map(|i| (0..=divisions - i).map(move |j| lattice(divisions, i, j).normalize()))
                .collect(),
        }
    }

    /// Terms of the interpolation at a direction (a vector of any length but 0).
    pub fn neighbours(self, x: DVec3) -> Neighbours {
        match self {
            Directions::Angles { rows, columns } => {
                Neighbours { weights: grid_weights(rows, columns, x), signs: [1.0; RIGID_DOFS] }
            }
            Directions::Octant { divisions } => {
                Neighbours { weights: octant_weights(divisions, x.abs()), signs: octant_signs(x) }
            }
        }
    }
}

/// Signs of the six degrees of freedom in the octant of x.
fn octant_signs(x: DVec3) -> [f64; RIGID_DOFS] {
    let [x, y, z] = x.to_array().map(|c| if c < 0.0 { -1.0 } else { 1.0 });
    [x, y, z, y * z, x * z, x * y]
}

fn grid_weights(rows: usize, columns: usize, x: DVec3) -> [(usize, f64); 4] {
    let polar = x.x.hypot(x.y).atan2(x.z);
    let azimuth = x.y.atan2(x.x).rem_euclid(TAU);
    let row = polar / PI * rows as f64 - 0.5;
    let column = azimuth / TAU * columns as f64;
    let (above, left) = (row.floor(), column.floor());
    let (down, right) = (row - above, column - left);
    let place = |row: f64, column: usize| {
        // Across a pole the same row continues on the opposite meridian.
        let (row, column) = if row < 0.0 {
            (0, column + columns / 2)
        } else if row >= rows as f64 {
            (rows - 1, column + columns / 2)
        } else {
            (row as usize, column)
        };
        row * columns + column % columns
    };
    let left = left as usize;
    [
        (place(above, left), (1.0 - down) * (1.0 - right)),
        (place(above, left + 1), (1.0 - down) * right),
        (place(above + 1.0, left), down * (1.0 - right)),
        (place(above + 1.0, left + 1), down * right),
    ]
}

/// Point (i, j, k)/divisions of the octahedron's face.
fn lattice(divisions: usize, i: usize, j: usize) -> DVec3 {
    DVec3::new(i as f64, j as f64, (divisions - i - j) as f64) / divisions as f64
}

/// Barycentric coordinates in the flat triangle of stored unit vectors that the direction pierces.
fn octant_weights(divisions: usize, x: DVec3) -> [(usize, f64); 4] {
    let x = x * (divisions as f64 / x.element_sum());
    let i = (x.x as usize).min(divisions - 1);
    let j = (x.y as usize).min(divisions - 1 - i);
    let (u, v) = (x.x - i as f64, x.y - j as f64);
    let corners = if u + v <= 1.0 || i + j + 1 == divisions {
        [(i, j, 1.0 - u - v), (i + 1, j, u), (i, j + 1, v)]
    } else {
        [(i + 1, j + 1, u + v - 1.0), (i, j + 1, 1.0 - u), (i + 1, j, 1.0 - v)]
    };
    // From the plane of the octahedron to that of the triangle between unit vectors.
    let scaled = corners.map(|(i, j, w)| w.max(0.0) * lattice(divisions, i, j).length());
    let total: f64 = scaled.iter().sum();
    let mut weights = [(0, 0.0); 4];
    for (weight, ((i, j, _), share)) in weights.iter_mut().zip(corners.into_iter().zip(scaled)) {
        *weight = (vertex(divisions, i, j), share / total);
    }
    weights
}

/// Place of a lattice point in the order of [`Directions::vectors`].
fn vertex(divisions: usize, i: usize, j: usize) -> usize {
    i * (divisions + 1) - i * i.saturating_sub(1) / 2 + j
}

#[cfg(test)]
mod tests {
    use super::*;

    const KINDS: [Directions; 5] = [
        Directions::Angles { rows: 5, columns: 10 },
        Directions::Angles { rows: 40, columns: 80 },
        Directions::Angles { rows: 1, columns: 2 },
        Directions::OCTANT_45,
        Directions::Octant { divisions: 1 },
    ];

    /// Directions all over the sphere, poles and axes among them.
    fn everywhere() -> impl Iterator<Item = DVec3> {
        let axes = [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z];
        let spiral = (0..400).map(|i| {
            let z = 1.0 - (f64::from(i) + 0.5) / 200.0;
            let r = (1.0 - z * z).sqrt();
            let a = 2.4 * f64::from(i);
            DVec3::new(r * a.cos(), r * a.sin(), z)
        });
        axes.into_iter().chain(spiral)
    }

    #[test]
    fn octant_has_the_published_counts() {
        assert_eq!(Directions::OCTANT_45.count(), 45);
        assert_eq!(Directions::OCTANT_45.vectors().len(), 45);
        assert!(KINDS.iter().all(|k| k.vectors().len() == k.count() && k.is_valid()));
    }

    #[test]
    fn stored_directions_are_their_own_neighbours() {
        for kind in KINDS {
            for (i, v) in kind.vectors().into_iter().enumerate() {
                let share: f64 =
                    kind.neighbours(v).weights.iter().filter(|(j, _)| *j == i).map(|(_, w)| w).sum();
                // Residual seen: 5e-15; a row through one cell only has its neighbour across the pole.
                assert!((share - 1.0).abs() < 1e-12, "{kind:?} {i}: {share}");
            }
        }
    }

    #[test]
    fn weights_are_a_mean_of_near_directions() {
        for kind in KINDS {
            let vectors = kind.vectors();
            for x in everywhere() {
                let Neighbours { weights, .. } = kind.neighbours(x);
                let total: f64 = weights.iter().map(|(_, w)| w).sum();
                assert!((total - 1.0).abs() < 1e-12, "{kind:?} {x}: {total}");
                assert!(weights.iter().all(|(i, w)| *i < vectors.len() && *w >= 0.0), "{kind:?} {x}");
                if kind.count() > 40 {
                    let folded = if matches!(kind, Directions::Octant { .. }) { x.abs() } else { x };
                    let mean: DVec3 = weights.iter().map(|(i, w)| vectors[*i] * *w).sum();
                    // Second order in the spacing: seen 0.09 for 5 × 10, less for the finer ones.
                    assert!((mean - folded).length() < 0.1, "{kind:?} {x}: {mean}");
                }
            }
        }
    }

    /// \[PROXY\] eqs. (16)–(21) as printed: for each degree, the vertices of the cube with positive sign.
    #[test]
    fn signs_are_the_published_ones() {
        let corners = [
            (1.0, 1.0, 1.0),
            (1.0, 1.0, -1.0),
            (-1.0, 1.0, 1.0),
            (-1.0, 1.0, -1.0),
            (1.0, -1.0, 1.0),
            (1.0, -1.0, -1.0),
            (-1.0, -1.0, 1.0),
            (-1.0, -1.0, -1.0),
        ];
        let positive: [[usize; 4]; RIGID_DOFS] =
            [[0, 1, 4, 5], [0, 1, 2, 3], [0, 2, 4, 6], [0, 2, 5, 7], [0, 3, 4, 7], [0, 1, 6, 7]];
        for (at, (x, y, z)) in corners.into_iter().enumerate() {
            let signs = Directions::OCTANT_45.neighbours(DVec3::new(x, y, z)).signs;
            for degree in 0..RIGID_DOFS {
                let expected = if positive[degree].contains(&at) { 1.0 } else { -1.0 };
                assert_eq!(signs[degree], expected, "degree {degree} at x_{at}");
            }
        }
    }
}
