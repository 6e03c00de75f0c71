//! A sound as samples, with its place in the output of a rendering.

/// Samples of a sound.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct SampledSound {
    /// Index of the first sample.
    pub(crate) first: i64,
    /// Pressures \[Pa\].
    pub(crate) pressures: Vec<f64>,
}

impl SampledSound {
    /// Adds another sound.
    pub(crate) fn add(&mut self, other: &SampledSound) {
        if other.pressures.is_empty() {
            return;
        }
        if self.pressures.is_empty() {
            *self = other.clone();
            return;
        }
        let first = self.first.min(other.first);
        let end = (self.first + self.pressures.len() as i64).max(other.first + other.pressures.len() as i64);
        let mut sum = vec![0.0; (end - first) as usize];
        for part in [&*self, other] {
            let at = (part.first - first) as usize;
            sum[at..].iter_mut().zip(&part.pressures).for_each(|(sum, p)| *sum += p);
        }
        *self = SampledSound { first, pressures: sum };
    }

    /// Adds the part that overlaps `block`, whose first sample has this index.
    pub(crate) fn add_to(&self, block: &mut [f64], first: i64) {
        let skip = (first - self.first).clamp(0, self.pressures.len() as i64) as usize;
        let at = (self.first - first).clamp(0, block.len() as i64) as usize;
        block[at..].iter_mut().zip(&self.pressures[skip..]).for_each(|(sum, p)| *sum += p);
    }

    /// ∫ p² dt [Pa² s].
    pub(crate) fn energy(&self, rate: f64) -> f64 {
        self.pressures.iter().map(|p| p * p).sum::<f64>() / rate
    }
}
