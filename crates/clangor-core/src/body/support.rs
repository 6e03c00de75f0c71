//! What holds a body: regions of it that are clamped, or that lie on springs and dampers.
//!
//! A support belongs to the body and to its frame: a fixed body is held in the world, a body with keyframes
//! by what moves it. It acts on the vibration alone; forces of the dynamics do not know it.

use glam::DVec3;

/// A part of space, in the frame of the body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SupportRegion {
    /// A ball.
    Ball {
        /// Centre \[m\].
        centre: DVec3,
        /// Radius \[m\].
        radius: f64,
    },
    /// A box along the axes of the body.
    Box {
        /// Lowest corner \[m\].
        low: DVec3,
        /// Highest corner \[m\].
        high: DVec3,
    },
}

/// How a support holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SupportKind {
    /// Nothing in the region moves.
    Clamped,
    /// Springs and dampers along the axes of the body, spread over the region.
    Sprung {
        /// Total stiffness along each axis [N/m].
        stiffness: DVec3,
        /// Total damping along each axis [N s/m].
        damping: DVec3,
    },
}

/// A support of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Support {
    /// Where it holds.
    pub region: SupportRegion,
    /// How.
    pub kind: SupportKind,
}

impl SupportRegion {
    /// Distance of a point from the region \[m\]; 0 inside.
    pub fn distance(&self, point: DVec3) -> f64 {
        match *self {
            SupportRegion::Ball { centre, radius } => (point.distance(centre) - radius).max(0.0),
            SupportRegion::Box { low, high } => point.distance(point.clamp(low, high)),
        }
    }

    /// Lowest and highest coordinate along an axis \[m\].
    pub fn ends(&self, axis: usize) -> [f64; 2] {
        let (middle, half) = self.bounds();
        [middle[axis] - half[axis], middle[axis] + half[axis]]
    }

    /// Middle and half extent \[m\].
    pub fn bounds(&self) -> (DVec3, DVec3) {
        match *self {
            SupportRegion::Ball { centre, radius } => (centre, DVec3::splat(radius)),
            SupportRegion::Box { low, high } => (0.5 * (low + high), 0.5 * (high - low)),
        }
    }

    /// Whether two regions have a point in common.
    pub fn overlaps(&self, other: &SupportRegion) -> bool {
        match (*self, *other) {
            (SupportRegion::Ball { centre, radius }, other) => other.distance(centre) < radius,
            (own, SupportRegion::Ball { centre, radius }) => own.distance(centre) < radius,
            (own, other) => {
                (0..3).all(|a| own.ends(a)[0] < other.ends(a)[1] && other.ends(a)[0] < own.ends(a)[1])
            }
        }
    }

    /// The same region in a frame whose origin is at `origin` \[m\].
    #[must_use]
    pub fn about(self, origin: DVec3) -> Self {
        match self {
            SupportRegion::Ball { centre, radius } => SupportRegion::Ball { centre: centre - origin, radius },
            SupportRegion::Box { low, high } => SupportRegion::Box { low: low - origin, high: high - origin },
        }
    }
}

/// Least pivot of the stiffness against motions of the whole body, over the largest, of a body that is held.
const LEAST_PIVOT: f64 = 1e-12;

/// Number of motions of a whole body, of six, that cost no energy if it is held at these places \[m\] with
/// these stiffnesses along its axes, in any unit.
pub fn free_motions(held: &[(DVec3, DVec3)]) -> usize {
    let Some((first, _)) = held.first() else { return 6 };
    let size = held.iter().map(|(x, _)| x.distance(*first)).fold(0.0, f64::max).max(1e-300);
    let stiffest = held.iter().map(|(_, stiffness)| stiffness.max_element()).fold(0.0, f64::max);
    let mut energy = [[0.0_f64; 6]; 6];
    for (place, stiffness) in held {
        // Translations, and rotations about the first place.
        let arm = (*place - *first) / size;
        let axes = [DVec3::X, DVec3::Y, DVec3::Z];
        let motions: [DVec3; 6] =
            std::array::from_fn(|k| if k < 3 { axes[k] } else { axes[k - 3].cross(arm) });
        for (row, own) in energy.iter_mut().zip(motions) {
            let forced = own * *stiffness / stiffest.max(1e-300);
            row.iter_mut().zip(motions).for_each(|(sum, other)| *sum += forced.dot(other));
        }
    }
    6 - rank(energy)
}

/// Rank of a positive semidefinite matrix, by elimination with the largest pivots.
fn rank(mut a: [[f64; 6]; 6]) -> usize {
    let largest = (0..6).map(|k| a[k][k]).fold(0.0, f64::max);
    let mut left: Vec<usize> = (0..6).collect();
    for done in 0..6 {
        let Some(at) = (0..left.len()).max_by(|i, j| a[left[*i]][left[*i]].total_cmp(&a[left[*j]][left[*j]]))
        else {
            return done;
        };
        let pivot = left.swap_remove(at);
        if a[pivot][pivot] <= LEAST_PIVOT * largest {
            return done;
        }
        let row = a[pivot];
        for &k in &left {
            for l in 0..6 {
                a[k][l] -= row[k] / row[pivot] * row[l];
            }
        }
    }
    6
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_hold_a_body_as_they_lie() {
        let pinned = |places: &[DVec3]| {
            let held: Vec<_> = places.iter().map(|x| (0.1 * *x + DVec3::ONE, DVec3::ONE)).collect();
            free_motions(&held)
        };
        assert_eq!(pinned(&[]), 6);
        assert_eq!(pinned(&[DVec3::X]), 3);
        assert_eq!(pinned(&[DVec3::X, DVec3::NEG_X]), 1);
        assert_eq!(pinned(&[DVec3::X, DVec3::NEG_X, DVec3::Z]), 0);
        // Vertical springs leave sliding and turning about the vertical.
        let held = [DVec3::X, DVec3::NEG_X, DVec3::Z].map(|x| (x, 30.0 * DVec3::Y));
        assert_eq!(free_motions(&held), 3);
    }

    #[test]
    fn regions_overlap_where_they_share_a_point() {
        let ball = |x: f64| SupportRegion::Ball { centre: DVec3::X * x, radius: 1.0 };
        let slab = |x: f64| SupportRegion::Box { low: DVec3::splat(x), high: DVec3::splat(x + 1.0) };
        assert!(ball(0.0).overlaps(&ball(1.9)) && !ball(0.0).overlaps(&ball(2.1)));
        assert!(slab(0.0).overlaps(&slab(0.9)) && !slab(0.0).overlaps(&slab(1.1)));
        assert!(slab(0.4).overlaps(&ball(0.0)) && ball(0.0).overlaps(&slab(0.4)));
        assert!(!slab(0.6).overlaps(&ball(0.0)) && !ball(0.0).overlaps(&slab(0.6)));
    }
}
