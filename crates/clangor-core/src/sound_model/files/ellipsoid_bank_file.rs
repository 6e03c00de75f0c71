//! A soundbank of ellipsoids as bytes: many fields in one small file; docs/format/model.md describes it.
//!
//! Two measures make the file small. First, a body radiates few multipoles at low frequencies, so every node
//! has its own highest order. It keeps the orders whose coefficients together exceed a tolerance of the
//! loudest motion at that node, on the bounding sphere, where high orders are loudest. Orders n ≤ 2, which
//! decay least with distance, are always kept. Second, the coefficients are 16-bit integers with one scale
//! for each term: the error is at most 1/65534 of the largest value of the term.

use num_complex::Complex64;
use serde::{Deserialize, Serialize};

use crate::sound_model::acceleration::field::{AccelerationField, Node, RIGID_DOFS, Term};
use crate::sound_model::files::field_checks::{check_field, term};
use crate::sound_model::files::tensor_file::{TensorFileError, TensorReader, TensorWriter, check_finite};
use crate::sound_model::soundbank::ellipsoid_bank::{BankEntry, EllipsoidBank};

/// Version of the format.
pub const VERSION: u32 = 1;
/// Kind of the file in its description.
pub const KIND: &str = "ellipsoid soundbank";

/// Largest number of ellipsoids in a file.
const MOST_ELLIPSOIDS: usize = 10_000;
/// Multipoles up to this n are kept at every node.
const ALWAYS_KEPT: u8 = 2;

/// A bank with its origin.
#[derive(Clone, Debug, PartialEq)]
pub struct BankFile {
    /// The ellipsoids.
    pub bank: EllipsoidBank,
    /// Its origin and accuracy.
    pub origin: BankOrigin,
}

/// Origin and accuracy of a bank.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BankOrigin {
    /// Program and version.
    pub program: String,
    /// Level error requested.
    pub asked_accuracy: f64,
    /// Solver, in words.
    pub method: String,
    /// Number of frequencies solved, of all ellipsoids together.
    pub solves: u64,
    /// Largest level error of any rational fit at frequencies outside the fit.
    pub held_out_error: f64,
}

/// The description in the header.
#[derive(Serialize, Deserialize)]
struct Description {
    kind: String,
    version: u32,
    units: String,
    origin: BankOrigin,
}

const UNITS: &str = "lengths over the longest semi-axis A = R, which is along x, s = i k R, pressures over \
(density R) for accelerations (a, R alpha); no material and no medium is in it";

impl BankFile {
    /// The bytes of the file; coefficients that together are below `tolerance` of the loudest are left out.
    ///
    /// # Errors
    /// [`TensorFileError`] for invalid fields.
    pub fn encode(&self, tolerance: f64) -> Result<Vec<u8>, TensorFileError> {
        let entries = self.bank.entries();
        let (mut ellipsoids, mut counts) = (Vec::new(), Vec::new());
        let (mut nodes, mut terms, mut orders) = (Vec::new(), Vec::new(), Vec::new());
        let (mut scales, mut values) = (Vec::new(), Vec::new());
        for BankEntry { b, c, field } in entries {
            check_field(field)?;
            let count = field.nodes.len();
            ellipsoids.extend([*b, *c, field.max_wavenumber, field.ring_time]);
            counts.extend([count as u32, field.terms.len() as u32]);
            nodes.extend(field.nodes.iter().flat_map(|n| [n.s.re, n.s.im, n.weight.re, n.weight.im]));
            terms.extend(
                field.terms.iter().flat_map(|t| [i16::from(t.n), i16::from(t.m), i16::from(t.degree)]),
            );
            let kept = orders_at_nodes(field, tolerance);
            orders.extend(kept.iter().map(|n| i16::from(*n)));
            for (row, term) in field.terms.iter().enumerate() {
                let at = (0..count).filter(|j| term.n <= kept[*j]).map(|j| row * count + j);
                let pairs: Vec<f32> = at.flat_map(|i| [field.real[i], field.imaginary[i]]).collect();
                let scale = pairs.iter().fold(0.0f32, |m, q| m.max(q.abs())) / f32::from(i16::MAX);
                scales.push(scale);
                let inverse = if scale > 0.0 { 1.0 / f64::from(scale) } else { 0.0 };
                values.extend(pairs.iter().map(|q| (f64::from(*q) * inverse).round() as i16));
            }
        }
        let mut file = TensorWriter::default();
        file.add("ellipsoids", &[entries.len(), 4], ellipsoids);
        file.add("counts", &[entries.len(), 2], counts);
        file.add("nodes", &[nodes.len() / 4, 4], nodes);
        file.add("orders", &[orders.len()], orders);
        file.add("terms", &[terms.len() / 3, 3], terms);
        file.add("scales", &[scales.len()], scales);
        file.add("values", &[values.len() / 2, 2], values);
        let description = Description {
            kind: KIND.into(),
            version: VERSION,
            units: UNITS.into(),
            origin: self.origin.clone(),
        };
        file.finish(&description)
    }

    /// Reads a file.
    ///
    /// # Errors
    /// [`TensorFileError`] for anything that [`encode`](Self::encode) does not write.
    pub fn decode(bytes: &[u8]) -> Result<Self, TensorFileError> {
        let file = TensorReader::open(bytes, KIND, VERSION)?;
        let Description { origin, .. } = file.describe()?;
        let (count, ellipsoids) = file.rows::<f64>("ellipsoids", &[4])?;
        if !(1..=MOST_ELLIPSOIDS).contains(&count) {
            return Err(TensorFileError::value(
                "the array \"ellipsoids\"",
                format!("has {count} rows, not 1 to {MOST_ELLIPSOIDS}"),
            ));
        }
        let counts = file.array::<u32>("counts", &[count, 2])?;
        let mut rest = Parts {
            nodes: &file.rows::<f64>("nodes", &[4])?.1,
            orders: &file.rows::<i16>("orders", &[])?.1,
            terms: &file.rows::<i16>("terms", &[3])?.1,
            scales: &file.rows::<f32>("scales", &[])?.1,
            values: &file.rows::<i16>("values", &[2])?.1,
        };
        check_finite("scales", rest.scales)?;
        let mut entries = Vec::with_capacity(count);
        for (numbers, counts) in ellipsoids.chunks_exact(4).zip(counts.chunks_exact(2)) {
            let field = rest.field(numbers[2], numbers[3], counts[0] as usize, counts[1] as usize)?;
            check_field(&field)?;
            entries.push(BankEntry { b: numbers[0], c: numbers[1], field });
        }
        rest.check_end()?;
        let bank = EllipsoidBank::try_new(entries).map_err(|error| {
            TensorFileError::value("the array \"ellipsoids\"", format!("is wrong: {error}"))
        })?;
        Ok(BankFile { bank, origin })
    }
}

/// Read positions in the long arrays.
struct Parts<'a> {
    nodes: &'a [f64],
    orders: &'a [i16],
    terms: &'a [i16],
    scales: &'a [f32],
    values: &'a [i16],
}

impl Parts<'_> {
    /// The next field.
    fn field(
        &mut self,
        max_wavenumber: f64,
        ring_time: f64,
        nodes: usize,
        terms: usize,
    ) -> Result<AccelerationField, TensorFileError> {
        let orders = take(&mut self.orders, "orders", nodes, 1)?;
        let node = |n: &[f64]| Node { s: Complex64::new(n[0], n[1]), weight: Complex64::new(n[2], n[3]) };
        let mut field = AccelerationField {
            max_wavenumber,
            ring_time,
            nodes: take(&mut self.nodes, "nodes", nodes, 4)?.chunks_exact(4).map(node).collect(),
            terms: take(&mut self.terms, "terms", terms, 3)?
                .chunks_exact(3)
                .map(term)
                .collect::<Result<Vec<Term>, _>>()?,
            real: Vec::new(),
            imaginary: Vec::new(),
        };
        let scales = take(&mut self.scales, "scales", terms, 1)?;
        for (term, scale) in field.terms.iter().zip(scales) {
            for order in orders {
                let (mut re, mut im) = (0.0, 0.0);
                if i16::from(term.n) <= *order {
                    let pair = take(&mut self.values, "values", 1, 2)?;
                    (re, im) = (f32::from(pair[0]) * scale, f32::from(pair[1]) * scale);
                }
                field.real.push(re);
                field.imaginary.push(im);
            }
        }
        Ok(field)
    }

    /// Rejects data beyond the last ellipsoid.
    fn check_end(&self) -> Result<(), TensorFileError> {
        let left = [
            ("nodes", self.nodes.len()),
            ("orders", self.orders.len()),
            ("terms", self.terms.len()),
            ("scales", self.scales.len()),
            ("values", self.values.len()),
        ];
        match left.into_iter().find(|(_, length)| *length > 0) {
            Some((name, _)) => {
                Err(TensorFileError::value(format!("the array \"{name}\""), "is longer than \"counts\" says"))
            }
            None => Ok(()),
        }
    }
}

/// The next `rows` of an array.
fn take<'a, T>(array: &mut &'a [T], name: &str, rows: usize, row: usize) -> Result<&'a [T], TensorFileError> {
    let (taken, rest) = rows.checked_mul(row).and_then(|n| array.split_at_checked(n)).ok_or_else(|| {
        TensorFileError::value(format!("the array \"{name}\""), "is shorter than \"counts\" says")
    })?;
    *array = rest;
    Ok(taken)
}

/// Highest n kept at each node.
fn orders_at_nodes(field: &AccelerationField, tolerance: f64) -> Vec<u8> {
    let count = field.nodes.len();
    let order = field.order();
    (0..count)
        .map(|j| {
            // Squares by n and degree of freedom. The field of a monopole has the factor s².
            let mut squares = vec![[0.0f64; RIGID_DOFS]; order + 1];
            for (row, term) in field.terms.iter().enumerate() {
                let at = row * count + j;
                let q = Complex64::new(f64::from(field.real[at]), f64::from(field.imaginary[at]));
                let factor = if term.n == 0 { field.nodes[j].s.norm_sqr().powi(2) } else { 1.0 };
                squares[usize::from(term.n)][usize::from(term.degree)] += factor * q.norm_sqr();
            }
            let total = |n: usize| {
                (0..RIGID_DOFS).map(|d| squares[n..].iter().map(|s| s[d]).sum::<f64>()).fold(0.0, f64::max)
            };
            let least = tolerance * tolerance * total(0);
            let highest = (0..=order).rev().find(|n| total(*n) > least).unwrap_or(0);
            (highest as u8).max(ALWAYS_KEPT)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A field whose order n is 10⁻ⁿ at low frequency and 1 at the last node.
    fn field() -> AccelerationField {
        let terms: Vec<Term> = (1..=6).map(|n| Term { n, m: 0, degree: 2 }).collect();
        let nodes: Vec<Node> =
            (1..=3).map(|j| Node { s: Complex64::new(0.0, f64::from(j)), weight: Complex64::ONE }).collect();
        let value = |n: u8, j: usize| if j == 2 { 1.0 } else { 10f32.powi(-i32::from(n)) };
        let real = terms.iter().flat_map(|t| (0..3).map(move |j| value(t.n, j))).collect();
        AccelerationField {
            max_wavenumber: 3.0,
            ring_time: 2.0,
            imaginary: vec![-0.25; terms.len() * nodes.len()],
            real,
            nodes,
            terms,
        }
    }

    #[test]
    fn each_node_keeps_the_orders_that_matter_there() {
        let mut field = field();
        field.imaginary.fill(0.0);
        assert_eq!(orders_at_nodes(&field, 2e-3), [3, 3, 6]);
        assert_eq!(orders_at_nodes(&field, 0.5), [2, 2, 5]);
        assert_eq!(orders_at_nodes(&field, 0.0), [6, 6, 6]);
    }
}
