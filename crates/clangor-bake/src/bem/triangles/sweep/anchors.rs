//! Factorised systems, evenly spaced in wavenumber, and solutions near them.

use std::sync::OnceLock;

use num_complex::Complex32;

use super::Band;
use super::refinement::{Start, refine};
use super::spares::Spares;
use crate::bem::triangles::dense_system::{ClassSystem, Factors};
use crate::bem::triangles::parity_classes::ParityClass;

/// Spacing of the anchors where memory allows it, and the largest that saves time [1/R].
pub(crate) const SPACING: f64 = 1.5;
pub(crate) const WIDEST: f64 = 3.0;

/// Unknowns of a class up to which factors of its own take no longer than the iteration.
pub(crate) const FEW: usize = 1200;

/// The anchors of a band.
#[derive(Clone, Debug)]
pub(super) struct Anchors {
    lowest: f64,
    error: f64,
    spacing: f64,
    anchors: Vec<OnceLock<Vec<Anchor>>>,
}

/// The system of one class at an anchor.
#[derive(Clone, Debug)]
struct Anchor {
    factors: Factors,
    solution: Vec<Complex32>,
}

impl Anchors {
    /// As many as fit in so many bytes; none where these are too few, or the systems small.
    pub(super) fn new(classes: &[ParityClass], band: &Band, memory: usize) -> Self {
        let entries: usize = classes.iter().map(|class| class.size * class.size).sum();
        let most = memory / (entries.max(1) * size_of::<Complex32>());
        let wanted = ((band.highest - band.lowest) / SPACING).ceil().max(1.0) as usize;
        let count = wanted.min(most);
        let spacing = (band.highest - band.lowest) / count.max(1) as f64;
        let largest = classes.iter().map(|class| class.size).max().unwrap_or(0);
        let count = if spacing <= WIDEST && largest > FEW { count } else { 0 };
        Self { lowest: band.lowest, error: band.error, spacing, anchors: vec![OnceLock::new(); count] }
    }

    /// Wavenumber of an anchor [1/R].
    pub(super) fn wavenumber(&self, anchor: usize) -> f64 {
        self.lowest + self.spacing * (anchor as f64 + 0.5)
    }

    /// The anchor of a wavenumber [1/R], if there are any.
    fn nearest(&self, k: f64) -> Option<usize> {
        let last = self.anchors.len().checked_sub(1)?;
        Some((((k - self.lowest) / self.spacing).max(0.0) as usize).min(last))
    }

    /// Anchors of some wavenumbers that have no factors yet.
    pub(super) fn missing(&self, wavenumbers: &[f64]) -> Vec<usize> {
        let mut needed: Vec<usize> = wavenumbers.iter().filter_map(|k| self.nearest(*k)).collect();
        needed.sort_unstable();
        needed.dedup();
        needed.retain(|anchor| self.anchors[*anchor].get().is_none());
        needed
    }

    /// Factorises the systems of an anchor.
    pub(super) fn factorise(&self, anchor: usize, systems: Vec<ClassSystem>) {
        self.anchors[anchor].get_or_init(|| {
            systems
                .into_iter()
                .map(|system| {
                    let factors = Factors::new(system.matrix, system.size);
                    let mut solution = system.right;
                    factors.solve(&mut solution);
                    Anchor { factors, solution }
                })
                .collect()
        });
    }

    /// The unknowns of each class, one motion after the other. Matrices of systems that the
    /// iteration solves go to `spares`.
    pub(super) fn solve(&self, k: f64, systems: Vec<ClassSystem>, spares: &Spares) -> Vec<Vec<Complex32>> {
        let Some(anchors) = self.nearest(k).and_then(|anchor| self.anchors[anchor].get()) else {
            return systems.into_iter().map(ClassSystem::solve).collect();
        };
        let solve = |(system, anchor): (ClassSystem, &Anchor)| {
            let start = Start { factors: &anchor.factors, solution: &anchor.solution };
            match refine(&system, start, self.error) {
                Some(solution) => {
                    spares.keep(system.matrix);
                    solution
                }
                None => system.solve(),
            }
        };
        systems.into_iter().zip(anchors).map(solve).collect()
    }
}
