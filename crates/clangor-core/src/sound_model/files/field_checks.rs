//! Checks of an acceleration field read from a file.

use num_complex::Complex64;

use crate::quantity;
use crate::sound_model::acceleration::field::{AccelerationField, RIGID_DOFS, Term};
use crate::sound_model::files::number_checks::{check_count, within};
use crate::sound_model::files::tensor_file::TensorFileError;

/// Most nodes in frequency that a file may have.
const MOST_NODES: usize = 1024;
/// Highest n that a file may have: m must fit.
const HIGHEST_ORDER: u8 = 127;
/// Rejects a field that could not be played.
pub(crate) fn check_field(field: &AccelerationField) -> Result<(), TensorFileError> {
    within("the highest wavenumber", field.max_wavenumber, &quantity::WAVENUMBER)?;
    within("the ring time", field.ring_time, &quantity::RING_TIME)?;
    let nodes = field.nodes.len();
    if !(1..=MOST_NODES).contains(&nodes) {
        return Err(TensorFileError::value(
            "the array \"acceleration.nodes\"",
            format!("has {nodes} rows, not 1 to {MOST_NODES}"),
        ));
    }
    for (at, node) in field.nodes.iter().enumerate() {
        within(&format!("node {at}"), node.s.norm(), &quantity::NODE)?;
        within(&format!("the weight of node {at}"), node.weight.norm(), &quantity::NODE_WEIGHT)?;
        if field.nodes[..at].iter().any(|other| other.s == node.s) {
            return Err(TensorFileError::value(format!("node {at}"), "repeats an earlier one"));
        }
    }
    if field.nodes.iter().all(|n| n.weight == Complex64::ZERO) {
        return Err(TensorFileError::value("every weight", "is zero"));
    }
    if let Some(at) = field.terms.iter().position(|t| !clamped(t)) {
        return Err(TensorFileError::value(format!("term {at}"), "is no multipole of a rigid motion"));
    }
    if let Some(at) = field.terms.windows(2).position(|pair| pair[0] >= pair[1]) {
        return Err(TensorFileError::value(format!("term {}", at + 1), "is not after the one before it"));
    }
    check_count("acceleration.real", &field.real, field.terms.len() * nodes)?;
    check_count("acceleration.imaginary", &field.imaginary, field.terms.len() * nodes)
}

/// Whether n, m and the degree of freedom go together.
fn clamped(term: &Term) -> bool {
    term.n <= HIGHEST_ORDER && term.m.unsigned_abs() <= term.n && usize::from(term.degree) < RIGID_DOFS
}

pub(crate) fn term(numbers: &[i16]) -> Result<Term, TensorFileError> {
    let impossible =
        |_| TensorFileError::value(format!("the term {numbers:?}"), "is no multipole of a rigid motion");
    Ok(Term {
        n: numbers[0].try_into().map_err(impossible)?,
        m: numbers[1].try_into().map_err(impossible)?,
        degree: numbers[2].try_into().map_err(impossible)?,
    })
}
