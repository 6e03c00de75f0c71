//! The keys `mass`, `centre_of_mass` and `inertia` of a body.

use glam::DMat3;

use super::reader::{Decoder, Node, Quantity, Section};
use crate::geometry::principal_axes::principal_axes;
use crate::quantity;
use crate::scene::body_description::GivenMass;
use crate::scene::diagnostic::Problem;

/// The keys.
const KEYS: [&str; 3] = ["mass", "centre_of_mass", "inertia"];

/// The mass properties that a body is given. Pieces of a body that breaks are homogeneous, and copies of
/// different sizes have different masses, so that neither can be given any.
pub(super) fn given_mass(d: &mut Decoder<'_>, section: &Section<'_>) -> GivenMass {
    for key in KEYS {
        section.exclude(d, key, "fracture", "`fracture`, whose pieces are homogeneous");
        section.exclude(d, key, "preset", "`preset`, which does not move");
        if section.get("scale").is_some_and(|node| node.is_array())
            && let Some(node) = section.get(key)
        {
            d.error(node.place(d), Problem::Conflict { key, other: "a range of scales" });
        }
    }
    GivenMass {
        mass: section.number(d, "mass", quantity::MASS),
        centre_of_mass: section.vector(d, "centre_of_mass", "m"),
        inertia: section.get("inertia").and_then(|node| inertia(d, &node)),
    }
}

/// Three rows of a symmetric matrix with positive principal moments.
fn inertia(d: &mut Decoder<'_>, node: &Node<'_>) -> Option<DMat3> {
    let expected = "three rows of a symmetric matrix in kg m², such as [[2e-6, 0, 0], [0, 2e-6, 0], \
                    [0, 0, 3e-6]]";
    let nodes = node.elements(d, expected)?;
    if nodes.len() != 3 {
        d.error(node.place(d), Problem::WrongLength { found: nodes.len(), expected: expected.into() });
        return None;
    }
    let moment = Quantity::between(-1e18, 1e18, "kg m²");
    let rows: Vec<Option<[f64; 3]>> = nodes.iter().map(|row| row.numbers::<3>(d, moment)).collect();
    let rows: Vec<[f64; 3]> = rows.into_iter().collect::<Option<_>>()?;
    let matrix = DMat3::from_cols_array_2d(&[rows[0], rows[1], rows[2]]).transpose();
    let size = matrix.to_cols_array().into_iter().fold(0.0, |a: f64, b| a.max(b.abs()));
    let skew = matrix - matrix.transpose();
    let skew = skew.to_cols_array().into_iter().fold(0.0, |a: f64, b| a.max(b.abs()));
    if skew > SYMMETRIC * size {
        let expected = format!("a symmetric matrix, to {SYMMETRIC} of its largest number");
        d.error(node.place(d), Problem::OutOfRange { value: skew / size, expected });
        return None;
    }
    let matrix = (matrix + matrix.transpose()) * 0.5;
    let least = principal_axes(matrix).0.min_element();
    if !(least > 0.0 && matrix.determinant() > 0.0) {
        let expected = "principal moments above 0".to_owned();
        d.error(node.place(d), Problem::OutOfRange { value: least, expected });
        return None;
    }
    Some(matrix)
}

/// Difference of numbers across the diagonal, over the largest number, that is rounding.
const SYMMETRIC: f64 = 1e-6;
