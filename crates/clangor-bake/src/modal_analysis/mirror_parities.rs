//! The modes of a symmetric body by the parities of its mirror planes.
//!
//! Every mode of a body symmetric about a plane is even or odd under the reflection,
//!
//! ```text
//! u(R x) = ± R u(x),    R the mirror
//! ```
//!
//! so that half of the body is enough: where the body meets the plane, the normal motion vanishes, or the
//! tangential one. With three planes there are eight problems with an eighth of the unknowns each, which take
//! a fraction of the time. The modes of a degenerate pair are in different ones.

use std::borrow::Cow;

use glam::DVec3;

use super::Spectrum;
use crate::cost::work_limit::WorkLimit;
use crate::fem::ElasticSystem;
use crate::fem::elimination::Elimination;
use crate::modal_analysis::eigensolver::{ModalError, Mode, solve_in};

/// Parity for each axis: +1 for motions that equal their mirror image, −1 for their negative.
pub(super) type Parity = [f64; 3];

/// Whether the plane through the origin across each axis is a mirror plane. The solved part of the body lies
/// on the positive sides.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct MirrorParities(pub(super) [bool; 3]);

/// The nodes of the solved part of a body.
#[derive(Clone, Copy)]
pub(super) struct PartNodes<'a> {
    /// Places from the planes \[m\].
    pub(super) places: &'a [DVec3],
    /// Whether the body goes on through the plane across each axis there.
    pub(super) on_planes: &'a [[bool; 3]],
}

/// A mode on the nodes of the solved part, with the mass of the whole body.
pub(super) struct PartMode {
    pub(super) parity: Parity,
    pub(super) mode: Mode,
}

impl MirrorParities {
    fn planes(self) -> impl Iterator<Item = usize> {
        (0..3).filter(move |a| self.0[*a])
    }

    /// All modes up to a limit \[Hz\] of the whole, from the free system of the part. Without planes it may
    /// be held, and the nodes do not matter.
    pub(super) fn spectrum(
        self,
        system: &ElasticSystem,
        nodes: PartNodes<'_>,
        limit: f64,
        work: &WorkLimit,
    ) -> Result<Spectrum<Vec<PartMode>>, ModalError> {
        let mut all =
            Spectrum { frequencies: Vec::new(), first: f64::INFINITY, residual: 0.0, modes: Vec::new() };
        // Held unknowns stay in the pattern, so that all parities are eliminated in the same order.
        let structure = Elimination::new(system)?;
        for parity in self.parities() {
            let own = match self.0.contains(&true) {
                true => Cow::Owned(self.restricted(system, nodes, parity)),
                false => Cow::Borrowed(system),
            };
            match solve_in(&structure, &own, limit, work) {
                Ok(found) => {
                    all.residual = all.residual.max(found.residual);
                    all.modes.extend(found.modes.into_iter().map(|mode| self.of_whole(mode, parity)));
                }
                // A finer mesh may have modes in the band.
                Err(ModalError::Silent { first, .. }) => all.first = all.first.min(first),
                Err(error) => return Err(error),
            }
        }
        all.modes.sort_by(|a, b| a.mode.frequency.total_cmp(&b.mode.frequency));
        all.frequencies = all.modes.iter().map(|part| part.mode.frequency).collect();
        all.first = all.frequencies.first().map_or(all.first, |f| *f);
        Ok(all)
    }

    /// All combinations of even and odd.
    pub(super) fn parities(self) -> impl Iterator<Item = Parity> {
        let both = (0..8_usize).map(|k| [0, 1, 2].map(|a| if k >> a & 1 == 1 { -1.0 } else { 1.0 }));
        both.filter(move |parity| (0..3).all(|a| self.0[a] || parity[a] > 0.0))
    }

    /// The problem of one parity.
    fn restricted(self, system: &ElasticSystem, nodes: PartNodes<'_>, parity: Parity) -> ElasticSystem {
        let PartNodes { places, on_planes } = nodes;
        let held = on_planes.iter().flat_map(|on| {
            [0, 1, 2].map(|axis| self.planes().any(|a| on[a] && (parity[a] > 0.0) == (axis == a)))
        });
        let fits = |turns: bool, axis: usize| {
            // A translation is odd under reflection along itself, a rotation under reflection across its
            // axis.
            self.planes().all(|a| (parity[a] < 0.0) == ((a == axis) != turns))
        };
        let translations = (0..3).filter(|a| fits(false, *a)).map(|a| vec![DVec3::AXES[a]; places.len()]);
        let turns = (0..3)
            .filter(|a| fits(true, *a))
            .map(|a| places.iter().map(|p| DVec3::AXES[a].cross(*p)).collect());
        let rigid = translations.chain(turns).collect();
        system.clone().holding(held.collect(), rigid)
    }

    /// A mode of the part with the mass of all images.
    fn of_whole(self, mut mode: Mode, parity: Parity) -> PartMode {
        let scale = (self.parities().count() as f64).sqrt().recip();
        mode.shape.iter_mut().for_each(|motion| *motion *= scale);
        PartMode { parity, mode }
    }

    /// The image in the part of a place from the planes.
    pub(super) fn folded(self, at: DVec3) -> DVec3 {
        DVec3::from_array([0, 1, 2].map(|a| if self.0[a] { at[a].abs() } else { at[a] }))
    }

    /// The motion at a place, from that at its image in the part.
    pub(super) fn unfolded(self, parity: Parity, at: DVec3, mut motion: DVec3) -> DVec3 {
        for a in self.planes().filter(|a| at[*a] < 0.0) {
            motion *= parity[a];
            motion[a] = -motion[a];
        }
        motion
    }
}
