//! Stored time signals of the published representation: samples, or the wavelet coefficients that are large
//! enough.
//!
//! For each direction and degree of freedom there are N signals q_k(t). \[PAN\] stores every sample;
//! \[PROXY\] §4.1 stores the wavelet coefficients of all N signals at the places where the pressure at any of
//! the fitted radii is at least ε of its largest coefficient.

/// Signals of all directions and degrees of freedom.
#[derive(Clone, Debug, PartialEq)]
pub enum Signals {
    /// Weights q_k^j of shifted filters ψ(t − jΔt; Δt) (\[PAN\] eq. (22)): for each direction, for each
    /// degree of freedom, for each k, all j.
    Samples(Vec<f32>),
    /// Wavelet coefficients.
    Wavelets(SparseCoefficients),
}

/// The coefficients that are kept, by direction and degree of freedom.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SparseCoefficients {
    /// First entry of each pair of direction and degree of freedom, direction by direction; at the end the
    /// number of entries.
    pub first: Vec<u32>,
    /// Place of each entry among the coefficients of its signal, ascending.
    pub places: Vec<u16>,
    /// N values for each entry.
    pub values: Vec<f32>,
}

impl Signals {
    /// Bytes of the signals.
    pub fn bytes(&self) -> usize {
        match self {
            Signals::Samples(samples) => 4 * samples.len(),
            Signals::Wavelets(sparse) => {
                4 * sparse.first.len() + 2 * sparse.places.len() + 4 * sparse.values.len()
            }
        }
    }

    /// Whether there are `count` pairs of direction and degree of freedom, each with `terms` signals of
    /// `length` numbers, all of them finite.
    pub fn fits(&self, count: usize, terms: usize, length: usize) -> bool {
        match self {
            Signals::Samples(samples) => {
                samples.len() == count * terms * length && samples.iter().all(|x| x.is_finite())
            }
            Signals::Wavelets(SparseCoefficients { first, places, values }) => {
                first.len() == count + 1
                    && first[0] == 0
                    && first.is_sorted()
                    && first[count] as usize == places.len()
                    && values.len() == places.len() * terms
                    && places.iter().all(|&place| usize::from(place) < length)
                    && first
                        .windows(2)
                        .all(|w| places[w[0] as usize..w[1] as usize].is_sorted_by(|a, b| a < b))
                    && values.iter().all(|x| x.is_finite())
            }
        }
    }
}

impl SparseCoefficients {
    /// Adds Σ_k weights_k q̂_k of one pair of direction and degree of freedom to the coefficients at the
    /// beginning of a transform; those beyond the end of `sum` are left out.
    pub(super) fn add(&self, pair: usize, weights: &[f64], sum: &mut [f64]) {
        let entries = self.first[pair] as usize..self.first[pair + 1] as usize;
        let values = self.values[entries.start * weights.len()..entries.end * weights.len()]
            .chunks_exact(weights.len());
        for (&place, values) in self.places[entries].iter().zip(values) {
            let Some(target) = sum.get_mut(usize::from(place)) else { break };
            *target += weights.iter().zip(values).map(|(w, &v)| w * f64::from(v)).sum::<f64>();
        }
    }
}
