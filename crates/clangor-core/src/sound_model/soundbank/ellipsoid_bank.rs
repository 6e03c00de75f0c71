//! Soundbank of the fields of ellipsoids of many proportions, and selection of the one for a body without a
//! field of its own.
//!
//! \[PROXY\] §3: a body is replaced by the ellipsoid with the same principal axes and moments of inertia,
//! uniformly rescaled to the same volume. With the moments per unit mass I₁ ≤ I₂ ≤ I₃, eq. (11) inverted is
//!
//! ```text
//! A² = 5/2 (I₂ + I₃ − I₁),   B² = 5/2 (I₁ + I₃ − I₂),   C² = 5/2 (I₁ + I₂ − I₃)
//! ```
//!
//! The bank holds ellipsoids with A = 1. As an [`AccelerationField`] has no unit of length, eq. (10) is the
//! choice of its radius, R = A. The terms contain the rules of sign between octants, eqs. (16)–(21): a motion
//! has only the harmonics of its own parity.
//!
//! The approximation is good for small convex bodies. It fails for a bowl, with the inertia of a large
//! ellipsoid and the volume of a small one.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};

use crate::geometry::principal_axes::principal_axes;
use crate::sound_model::acceleration::field::AccelerationField;

/// An ellipsoid of the bank: its longest semi-axis is 1, along x.
#[derive(Clone, Debug, PartialEq)]
pub struct BankEntry {
    /// Semi-axis along y, in units of the longest.
    pub b: f64,
    /// Semi-axis along z, the shortest, in units of the longest.
    pub c: f64,
    /// Its field; the radius R is the longest semi-axis.
    pub field: AccelerationField,
}

/// Fields of ellipsoids of many proportions.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EllipsoidBank {
    /// Ascending in B, then in C.
    entries: Vec<BankEntry>,
}

/// Error in the ellipsoids of a bank.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum BankError {
    /// Axes that are not 1 ≥ B ≥ C > 0.
    #[error("ellipsoid {index} of the bank has the semi-axes 1 : {b} : {c}; expected 1 ≥ b ≥ c > 0")]
    Axes {
        /// Index of the ellipsoid.
        index: usize,
        /// Second semi-axis.
        b: f64,
        /// Third semi-axis.
        c: f64,
    },
}

/// Difference below which two proportions count as equal.
const SAME_PROPORTION: f64 = 1e-6;

/// The ellipsoid that represents a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Proxy {
    /// Semi-axes A ≥ B ≥ C \[m\] of the ellipsoid that has the volume and the proportions of inertia of the
    /// body.
    pub semi_axes: DVec3,
    /// Index of the nearest ellipsoid of the bank.
    pub entry: usize,
    /// The ellipsoids whose mean represents it: the neighbouring ones, or the nearest alone. Their weights
    /// sum to 1, or to less for a body that is more slender than all of them.
    pub mean: [(usize, f64); 4],
    /// Radius R \[m\] of that ellipsoid's field.
    pub radius: f64,
    /// Rotation from the frame of the field to the frame of the body, about its centre of mass. Positions and
    /// accelerations of the body are transformed to the field by its transpose.
    pub rotation: DMat3,
}

impl Proxy {
    /// The same body, represented by the nearest ellipsoid alone.
    pub fn of_nearest(self) -> Self {
        Proxy { mean: alone(self.entry, self.mean.iter().map(|(_, weight)| weight).sum()), ..self }
    }
}

fn alone(entry: usize, weight: f64) -> [(usize, f64); 4] {
    [(entry, weight), (entry, 0.0), (entry, 0.0), (entry, 0.0)]
}

impl EllipsoidBank {
    /// A bank of these ellipsoids, in any order.
    ///
    /// # Errors
    /// [`BankError`] for axes that are out of order or not finite.
    pub fn try_new(mut entries: Vec<BankEntry>) -> Result<Self, BankError> {
        for (index, &BankEntry { b, c, .. }) in entries.iter().enumerate() {
            if !(c > 0.0 && b >= c && b <= 1.0) {
                return Err(BankError::Axes { index, b, c });
            }
        }
        entries.sort_by(|p, q| p.b.total_cmp(&q.b).then(p.c.total_cmp(&q.c)));
        Ok(EllipsoidBank { entries })
    }

    /// The ellipsoids, ascending in B, then in C.
    pub fn entries(&self) -> &[BankEntry] {
        &self.entries
    }

    /// The ellipsoid of the bank that represents a body with this `inertia` about its centre of mass, per
    /// unit density \[m⁵\], and this `volume` \[m³\].
    ///
    /// A body that is more slender than all entries, B < B₀, is that of its cross-section with B₀, and sounds
    /// less by (B/B₀)²: a slender body displaces air, and takes air along, in proportion to the area of its
    /// cross-section.
    ///
    /// `None` for an empty bank, and for an invalid inertia or volume.
    pub fn proxy_for(&self, inertia: DMat3, volume: f64) -> Option<Proxy> {
        let (semi_axes, rotation) = matched_ellipsoid(inertia, volume)?;
        let (b, c) = (semi_axes.y / semi_axes.x, semi_axes.z / semi_axes.x);
        let slender = (b / self.entries.first()?.b).min(1.0);
        let (b, c) = (b / slender, c / slender);
        let distance = |e: &BankEntry| (e.b - b).powi(2) + (e.c - c).powi(2);
        let nearest = (0..self.entries.len())
            .min_by(|i, j| distance(&self.entries[*i]).total_cmp(&distance(&self.entries[*j])))?;
        let mut mean = self.around(b, c).unwrap_or_else(|| alone(nearest, 1.0));
        mean.iter_mut().for_each(|(_, weight)| *weight *= slender * slender);
        Some(Proxy { semi_axes, entry: nearest, mean, radius: semi_axes.x, rotation })
    }

    /// The ellipsoids at the corners of the cell that contains 1 : b : c, with their weights; `None` unless
    /// the bank is a grid there. Points outside the grid are moved to its edge.
    fn around(&self, b: f64, c: f64) -> Option<[(usize, f64); 4]> {
        let mut steps: Vec<f64> = self.entries.iter().map(|e| e.b).collect();
        steps.dedup();
        let last = steps.len().checked_sub(2)?;
        // The step below, and the fraction of the distance to the next.
        let place = |x: f64| {
            let i = steps.partition_point(|s| *s <= x).saturating_sub(1).min(last);
            (i, ((x - steps[i]) / (steps[i + 1] - steps[i])).clamp(0.0, 1.0))
        };
        let ((i, u), (j, v)) = (place(b), place(c));
        let corners = if i == j {
            // There are no ellipsoids above the diagonal B = C.
            let v = v.min(u);
            [(i, i, 1.0 - u), (i + 1, i, u - v), (i + 1, i + 1, v), (i, i, 0.0)]
        } else {
            let (p, q) = (1.0 - u, 1.0 - v);
            [(i, j, p * q), (i + 1, j, u * q), (i, j + 1, p * v), (i + 1, j + 1, u * v)]
        };
        let mut mean = alone(0, 0.0);
        for (share, (i, j, weight)) in mean.iter_mut().zip(corners) {
            let same = |e: &BankEntry| {
                (e.b - steps[i]).abs() < SAME_PROPORTION && (e.c - steps[j]).abs() < SAME_PROPORTION
            };
            *share = (self.entries.iter().position(same)?, weight);
        }
        Some(mean)
    }
}

/// Semi-axes A ≥ B ≥ C \[m\] of the ellipsoid with the proportions of this inertia and this volume, and the
/// rotation from its axes to the frame of the inertia.
///
/// `None` for a volume or inertia that is not positive. A tensor with I₃ > I₁ + I₂, which no solid has,
/// counts as flat.
pub fn matched_ellipsoid(inertia: DMat3, volume: f64) -> Option<(DVec3, DMat3)> {
    let (moments, rotation) = principal_axes(inertia);
    let sum = moments.element_sum();
    if !(volume > 0.0 && volume.is_finite() && moments.x > 0.0 && sum.is_finite()) {
        return None;
    }
    // A needle or a disc without thickness would need an infinite scale: no axis below 1e-3 of the longest.
    let square = (DVec3::splat(sum) - 2.0 * moments) / (sum - 2.0 * moments.x);
    let proportions = square.max(DVec3::splat(1e-6)).map(f64::sqrt);
    let scale = (volume / (4.0 / 3.0 * PI * proportions.element_product())).cbrt();
    Some((scale * proportions, rotation))
}

#[cfg(test)]
mod tests {
    use glam::DQuat;

    use super::*;
    use crate::geometry::mass_properties::MassProperties;

    fn silent() -> AccelerationField {
        AccelerationField {
            max_wavenumber: 20.0,
            ring_time: 10.0,
            nodes: Vec::new(),
            terms: Vec::new(),
            real: Vec::new(),
            imaginary: Vec::new(),
        }
    }

    fn ellipsoid(axes: DVec3) -> (DMat3, f64) {
        let volume = 4.0 / 3.0 * PI * axes.element_product();
        let square = axes * axes;
        (DMat3::from_diagonal(DVec3::splat(square.element_sum()) - square) * (volume / 5.0), volume)
    }

    #[test]
    fn an_ellipsoid_finds_itself_however_it_is_turned() {
        let mut entries = Vec::new();
        for (b, c) in [(0.7, 0.2), (1.0, 1.0), (0.3, 0.3), (0.7, 0.6)] {
            entries.push(BankEntry { b, c, field: silent() });
        }
        let bank = EllipsoidBank::try_new(entries).unwrap();
        let axes = 0.013 * DVec3::new(1.0, 0.71, 0.22);
        let (inertia, volume) = ellipsoid(axes);
        let turn = DMat3::from_quat(DQuat::from_scaled_axis(DVec3::new(0.4, -1.3, 0.8)));
        let proxy = bank.proxy_for(turn * inertia * turn.transpose(), volume).unwrap();
        // Residual seen: 1e-17.
        assert!((proxy.semi_axes - axes).length() < 1e-12, "{proxy:?}");
        assert_eq!((bank.entries()[proxy.entry].b, bank.entries()[proxy.entry].c), (0.7, 0.2));
        assert!((proxy.rotation.determinant() - 1.0).abs() < 1e-12);
        let x = turn * DVec3::new(0.0, 1.0, 0.0);
        assert!(((proxy.rotation.transpose() * x).y.abs() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn between_ellipsoids_the_ones_around_share() {
        let steps = [0.1, 0.4, 0.7, 1.0];
        let entry = |b: f64, c: f64| BankEntry { b, c, field: silent() };
        let all =
            steps.iter().flat_map(|b| steps.iter().filter(move |c| *c <= b).map(move |c| entry(*b, *c)));
        let bank = EllipsoidBank::try_new(all.collect()).unwrap();
        for (b, c) in [(0.55, 0.2), (0.6, 0.5), (0.4, 0.4), (1.0, 1.0), (0.95, 0.1), (1.0, 0.85)] {
            let (inertia, volume) = ellipsoid(DVec3::new(1.0, b, c));
            let proxy = bank.proxy_for(inertia, volume).unwrap();
            let mean = |of: fn(&BankEntry) -> f64| -> f64 {
                proxy.mean.iter().map(|(e, weight)| weight * of(&bank.entries()[*e])).sum()
            };
            // Residual seen: 3e-16. Functions linear in B and C are reproduced.
            assert!((mean(|_| 1.0) - 1.0).abs() < 1e-12);
            assert!((mean(|e| e.b) - b).abs() < 1e-12 && (mean(|e| e.c) - c).abs() < 1e-12, "{proxy:?}");
            assert!(proxy.mean.iter().all(|(_, weight)| (0.0..=1.0).contains(weight)), "{proxy:?}");
        }
        // Thinner than the thinnest: at the edge.
        let (inertia, volume) = ellipsoid(DVec3::new(1.0, 0.5, 0.03));
        let proxy = bank.proxy_for(inertia, volume).unwrap();
        assert!(proxy.mean.iter().all(|(e, weight)| *weight == 0.0 || bank.entries()[*e].c == 0.1));
        // More slender than all: the same cross-section, of less area.
        let (inertia, volume) = ellipsoid(DVec3::new(1.0, 0.02, 0.02));
        let proxy = bank.proxy_for(inertia, volume).unwrap();
        for proxy in [proxy, proxy.of_nearest()] {
            let shares = proxy.mean.map(|(e, weight)| (bank.entries()[e].b, weight));
            assert!(shares.iter().all(|(b, weight)| weight.abs() < 1e-12 || *b == 0.1), "{proxy:?}");
            let sum: f64 = shares.iter().map(|(_, weight)| weight).sum();
            // Residual seen: 1e-17.
            assert!((sum - 0.04).abs() < 1e-12, "{proxy:?}");
        }
    }

    #[test]
    fn invalid_inertia_gives_none_and_a_flat_one_is_clamped() {
        let bank = EllipsoidBank::try_new(vec![BankEntry { b: 1.0, c: 0.05, field: silent() }]).unwrap();
        let sphere = MassProperties::of_sphere(0.01);
        assert!(bank.proxy_for(sphere.inertia, sphere.volume).is_some());
        assert_eq!(bank.proxy_for(sphere.inertia, 0.0), None);
        assert_eq!(bank.proxy_for(DMat3::ZERO, 1.0), None);
        assert_eq!(bank.proxy_for(sphere.inertia * f64::NAN, 1.0), None);
        assert_eq!(EllipsoidBank::default().proxy_for(sphere.inertia, sphere.volume), None);
        let flat = DMat3::from_diagonal(DVec3::new(1.0, 1.0, 3.0));
        assert!(bank.proxy_for(flat, 1.0).unwrap().semi_axes.is_finite());
    }

    #[test]
    fn axes_out_of_order_are_refused() {
        for (b, c) in [(0.5, 0.6), (1.1, 0.2), (0.5, 0.0), (f64::NAN, 0.1), (0.5, f64::NAN)] {
            assert!(EllipsoidBank::try_new(vec![BankEntry { b, c, field: silent() }]).is_err());
        }
    }
}
