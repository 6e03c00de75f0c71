//! Field of an ellipsoid between those of a bank: the weighted mean of the neighbouring ellipsoids.
//!
//! \[PROXY\] §3 takes the nearest ellipsoid. Differs: the fields of the corners of the cell of (B/A, C/A) in
//! which the body is are averaged with bilinear weights, or linear ones in the three corners of a cell on the
//! diagonal B = C:
//!
//! ```text
//! Q(s) = Σ_e w_e Q^e(s)
//! ```
//!
//! Each ellipsoid has other nodes. The coefficients of the others are first interpolated to the nodes of the
//! nearest. Only the orders that a body of this size radiates in the band are kept: n ≤ κ + 3, and at least
//! [`LEAST_ORDER`].
//!
//! This is done once for each body; its clicks cost the same as those of any field.

use std::collections::BTreeMap;
use std::sync::Arc;

use num_complex::{Complex32, Complex64};

use crate::sound_model::acceleration::field::{AccelerationField, Node, Term};
use crate::sound_model::acceleration::field_evaluator::FieldEvaluator;
use crate::sound_model::acceleration::model_evaluator::BankEvaluator;
use crate::sound_model::soundbank::ellipsoid_bank::{EllipsoidBank, Proxy};

/// Orders kept for the smallest bodies: their near field needs them.
pub const LEAST_ORDER: usize = 10;
/// Orders kept above κ.
const MORE_ORDERS: f64 = 3.0;

/// Computes and caches the fields of proxies.
#[derive(Clone, Debug)]
pub struct ProxyFields<'a> {
    bank: &'a BankEvaluator,
    /// k [1/m].
    max_wavenumber: f64,
    moved: MovedFields,
    fields: BTreeMap<FieldKey, Arc<FieldEvaluator>>,
}

/// Coefficients of one ellipsoid at the nodes of another: indices of the two.
type MovedFields = BTreeMap<(usize, usize), Arc<[Complex32]>>;
/// Ellipsoids, bits of their weights, highest order.
type FieldKey = ([(usize, u64); 4], usize);

impl<'a> ProxyFields<'a> {
    /// Fields for a band that ends at this k = 2πf/c [1/m].
    pub fn new(bank: &'a BankEvaluator, max_wavenumber: f64) -> Self {
        ProxyFields { bank, max_wavenumber, moved: BTreeMap::new(), fields: BTreeMap::new() }
    }

    /// The bank.
    pub fn bank(&self) -> &'a BankEvaluator {
        self.bank
    }

    /// The field of a proxy of the bank.
    pub fn field(&mut self, proxy: &Proxy) -> Arc<FieldEvaluator> {
        let order = ((proxy.radius * self.max_wavenumber + MORE_ORDERS).ceil() as usize).max(LEAST_ORDER);
        let key = (proxy.mean.map(|(entry, weight)| (entry, weight.to_bits())), order);
        if let Some(field) = self.fields.get(&key) {
            return Arc::clone(field);
        }
        let field = mean_of(self.bank.bank(), proxy, order, &mut self.moved);
        // A mean of valid fields is valid.
        let field =
            FieldEvaluator::try_new(&field).map_or_else(|_| Arc::clone(self.bank.field(proxy)), Arc::new);
        self.fields.insert(key, Arc::clone(&field));
        field
    }
}

/// The field of the proxy of a body, of orders up to `order`.
pub fn mean_field(bank: &EllipsoidBank, proxy: &Proxy, order: usize) -> AccelerationField {
    mean_of(bank, proxy, order, &mut BTreeMap::new())
}

fn mean_of(bank: &EllipsoidBank, proxy: &Proxy, order: usize, moved: &mut MovedFields) -> AccelerationField {
    let entries = bank.entries();
    let nearest = &entries[proxy.entry].field;
    let count = nearest.nodes.len();
    let shares: Vec<(usize, f64)> = proxy.mean.iter().copied().filter(|(_, weight)| *weight > 0.0).collect();
    let mut rows: BTreeMap<Term, Vec<Complex64>> = BTreeMap::new();
    for &(entry, weight) in &shares {
        let of = &entries[entry].field;
        let values = moved
            .entry((entry, proxy.entry))
            .or_insert_with(|| at_nodes_of(of, &nearest.nodes, entry == proxy.entry));
        for (term, row) in of.terms.iter().zip(values.chunks_exact(count)) {
            if usize::from(term.n) > order {
                break;
            }
            let sums = rows.entry(*term).or_insert_with(|| vec![Complex64::ZERO; count]);
            for (sum, q) in sums.iter_mut().zip(row) {
                *sum += weight * Complex64::new(f64::from(q.re), f64::from(q.im));
            }
        }
    }
    let of_shares =
        |number: fn(&AccelerationField) -> f64| shares.iter().map(move |s| number(&entries[s.0].field));
    AccelerationField {
        max_wavenumber: of_shares(|f| f.max_wavenumber).fold(f64::INFINITY, f64::min),
        ring_time: of_shares(|f| f.ring_time).fold(0.0, f64::max),
        nodes: nearest.nodes.clone(),
        terms: rows.keys().copied().collect(),
        real: rows.values().flatten().map(|q| q.re as f32).collect(),
        imaginary: rows.values().flatten().map(|q| q.im as f32).collect(),
    }
}

/// The coefficients of a field at these nodes, its own or another's: for each term, for each node.
fn at_nodes_of(field: &AccelerationField, nodes: &[Node], own: bool) -> Arc<[Complex32]> {
    let values = field.real.iter().zip(&field.imaginary).map(|(re, im)| Complex32::new(*re, *im));
    if own {
        return values.collect();
    }
    let values: Vec<Complex64> = values.map(|q| Complex64::new(f64::from(q.re), f64::from(q.im))).collect();
    let count = field.nodes.len();
    let shares: Vec<Vec<(Complex64, Complex64)>> =
        nodes.iter().map(|node| shares_at(field, node.s)).collect();
    values
        .chunks_exact(count)
        .flat_map(|row| {
            shares.iter().map(move |shares| {
                let q: Complex64 = row.iter().zip(shares).map(|(q, (a, b))| a * q + b * q.conj()).sum();
                Complex32::new(q.re as f32, q.im as f32)
            })
        })
        .collect()
}

/// a_j and b_j for which the interpolation to s is Σ_j (a_j Q_j + b_j conj Q_j).
fn shares_at(field: &AccelerationField, s: Complex64) -> Vec<(Complex64, Complex64)> {
    let close = |at: Complex64| (s - at).norm_sqr() < 1e-28 * (1.0 + s.norm_sqr());
    if let Some(at) = field.nodes.iter().position(|node| close(node.s)) {
        let share = |j| (Complex64::from(f64::from(u8::from(j == at))), Complex64::ZERO);
        return (0..field.nodes.len()).map(share).collect();
    }
    let mut shares: Vec<(Complex64, Complex64)> =
        field.nodes.iter().map(|n| (n.weight / (s - n.s), n.weight.conj() / (s - n.s.conj()))).collect();
    let below: Complex64 = shares.iter().map(|(a, b)| a + b).sum();
    shares.iter_mut().for_each(|(a, b)| (*a, *b) = (*a / below, *b / below));
    shares
}
