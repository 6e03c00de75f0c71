//! Functions of the frequency that are slow to compute and smooth: tabulated, and interpolated by power laws.

/// Points per octave.
const PER_OCTAVE: f64 = 6.0;

/// `N` positive functions between two frequencies.
#[derive(Clone, Debug)]
pub(super) struct MeanTable<const N: usize> {
    low: f64,
    /// Logarithms of the values, at even steps of the logarithm of the frequency.
    rows: Vec<[f64; N]>,
    step: f64,
}

impl<const N: usize> MeanTable<N> {
    /// From `low` to `high` \[Hz\], with low < high.
    pub(super) fn new([low, high]: [f64; 2], of: impl Fn(f64) -> [f64; N]) -> Self {
        let octaves = (high / low).log2();
        let steps = (PER_OCTAVE * octaves).ceil().max(1.0);
        let step = octaves / steps;
        let row = |i: usize| of(low * (step * i as f64).exp2()).map(f64::ln);
        MeanTable { low, rows: (0..=steps as usize).map(row).collect(), step }
    }

    /// The values at a frequency \[Hz\]; outside, those at the end.
    pub(super) fn at(&self, frequency: f64) -> [f64; N] {
        let last = self.rows.len() - 1;
        let place = ((frequency / self.low).log2() / self.step).clamp(0.0, last as f64);
        let row = (place as usize).min(last.saturating_sub(1));
        let part = place - row as f64;
        let next = (row + 1).min(last);
        std::array::from_fn(|k| ((1.0 - part) * self.rows[row][k] + part * self.rows[next][k]).exp())
    }

    /// Means over a band \[Hz\].
    pub(super) fn mean(&self, [from, to]: [f64; 2]) -> [f64; N] {
        const POINTS: usize = 16;
        let mut sums = [0.0; N];
        for i in 0..POINTS {
            let values = self.at(from + (to - from) * (i as f64 + 0.5) / POINTS as f64);
            sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += value / POINTS as f64);
        }
        sums
    }
}
