//! Spectra of force histories on the grid of a block.
//!
//! All waves of an impact need the same spectrum: of both bodies, at all receivers, by all paths, and of the
//! ground. The last few are kept.

use std::f64::consts::TAU;
use std::sync::Arc;

use super::spectrum::{ArrivingForce, ForceSpectrum, Grid};
use crate::contact::{ForceHistory, ForceShape};

/// Spectra that are kept.
const KEPT: usize = 4;

/// See the module.
#[derive(Default)]
pub(crate) struct HistorySpectra {
    kept: [Option<Kept>; KEPT],
    /// The one that is replaced next.
    oldest: usize,
}

/// A spectrum Ŝ(ω) e^{iωτ/2}, and what it belongs to.
struct Kept {
    history: Option<Arc<ForceHistory>>,
    spacing: f64,
    duration: f64,
    re: Vec<f64>,
    im: Vec<f64>,
}

impl Kept {
    fn is_of(&self, history: &Arc<ForceHistory>, grid: &Grid, duration: f64) -> bool {
        let same_grid = self.spacing == grid.spacing_hz && self.re.len() == grid.omega.len();
        let same_force = self.history.as_ref().is_some_and(|kept| Arc::ptr_eq(kept, history));
        same_force && same_grid && self.duration == duration
    }
}

impl HistorySpectra {
    /// Reserves memory for grids of up to this number of bins.
    pub(crate) fn reserve(&mut self, bins: usize) {
        for kept in &mut self.kept {
            let [re, im] = [(), ()].map(|()| Vec::with_capacity(bins));
            *kept = Some(Kept { history: None, spacing: 0.0, duration: 0.0, re, im });
        }
    }

    /// The force of a shape and a duration τ \[s\] whose middle is at `middle` \[s\], on a grid.
    #[inline(always)]
    pub(crate) fn arriving<'a>(
        &'a mut self,
        shape: &ForceShape,
        (duration, middle): (f64, f64),
        grid: &Grid,
    ) -> ArrivingForce<'a> {
        let spectrum = match shape {
            ForceShape::Profile(profile) => ForceSpectrum::Profile(*profile),
            ForceShape::History(history) => {
                let (re, im) = self.of(history, duration, grid);
                ForceSpectrum::Bins { re, im }
            }
        };
        ArrivingForce { spectrum, duration, middle }
    }

    #[inline(always)]
    fn of(&mut self, history: &Arc<ForceHistory>, duration: f64, grid: &Grid) -> (&[f64], &[f64]) {
        let found = self
            .kept
            .iter()
            .position(|kept| kept.as_ref().is_some_and(|kept| kept.is_of(history, grid, duration)));
        let at = found.unwrap_or_else(|| {
            let at = self.oldest;
            self.oldest = (at + 1) % KEPT;
            let (mut re, mut im) =
                self.kept[at].take().map_or((Vec::new(), Vec::new()), |kept| (kept.re, kept.im));
            re.resize(grid.omega.len(), 0.0);
            im.resize(grid.omega.len(), 0.0);
            history.spectra(TAU * grid.spacing_hz, 0.5 * duration, &mut re, &mut im);
            let history = Some(Arc::clone(history));
            self.kept[at] = Some(Kept { history, spacing: grid.spacing_hz, duration, re, im });
            at
        });
        self.kept[at].as_ref().map_or((&[], &[]), |kept| (&kept.re, &kept.im))
    }
}
