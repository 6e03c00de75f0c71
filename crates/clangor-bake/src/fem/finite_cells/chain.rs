//! Closed surfaces as sums of oriented triangles (chains), cut by planes and closed again.
//!
//! A cut keeps the triangles on one side and closes the chain with cones in the plane: one signed triangle
//! per cut segment, all with the same apex. Their sum is the section of the body, whatever its form, since
//! parts outside it cancel. Integrals over the closed chain therefore stay exact.
//!
//! Neighbouring triangles find the same crossing of their common side, bit for bit, and a point on the plane
//! is always above it: nothing is lost or counted twice, however the surface lies to the plane.

use glam::DVec3;

/// Where a triangle of a chain comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Origin {
    /// The surface of the body.
    Surface,
    /// A face of the cell: twice the axis, plus 1 for the upper one.
    Face(u8),
    /// A plane inside a part; its two sides cancel.
    Inner,
    /// The division from the wall of this number.
    Division(u8),
}

/// An oriented triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Oriented {
    pub(super) corners: [DVec3; 3],
    pub(super) origin: Origin,
}

impl Oriented {
    /// Twice the area along the normal.
    pub(super) fn area_vector(&self) -> DVec3 {
        let [a, b, c] = self.corners;
        (b - a).cross(c - a)
    }
}

/// A plane, by a linear function that is positive above it.
pub(super) struct Plane<F> {
    pub(super) value: F,
    /// Axis and coordinate of a plane across an axis: crossings lie on it to the last bit.
    pub(super) across: Option<(usize, f64)>,
}

/// The plane across an axis at a coordinate.
pub(super) fn plane_across(axis: usize, at: f64) -> Plane<impl Fn(DVec3) -> f64> {
    Plane { value: move |x: DVec3| x[axis] - at, across: Some((axis, at)) }
}

/// The part of a closed chain above a plane, or below it, closed again.
pub(super) fn cut<F: Fn(DVec3) -> f64>(
    chain: &[Oriented],
    plane: &Plane<F>,
    above: bool,
    closing: Origin,
) -> Vec<Oriented> {
    let mut kept = Vec::new();
    let mut apex = None;
    let mut close = |from: DVec3, to: DVec3, kept: &mut Vec<Oriented>| {
        let apex = *apex.get_or_insert(from);
        if apex != from && apex != to && from != to {
            kept.push(Oriented { corners: [apex, to, from], origin: closing });
        }
    };
    for triangle in chain {
        let values = triangle.corners.map(&plane.value);
        let inside = values.map(|value| (value >= 0.0) == above);
        let count = inside.iter().filter(|inside| **inside).count();
        if count == 3 {
            kept.push(*triangle);
        }
        if count == 0 || count == 3 {
            continue;
        }
        // The corner alone on its side comes first.
        let lone = (0..3).find(|k| inside[*k] == (count == 1)).unwrap_or(0);
        let corner = |k: usize| (triangle.corners[(lone + k) % 3], values[(lone + k) % 3]);
        let [first, second] = [1, 2].map(|k| crossing(plane, corner(0), corner(k)));
        let mut push =
            |corners: [DVec3; 3]| kept.push(Oriented { corners, origin: triangle.origin });
        if count == 1 {
            push([corner(0).0, first, second]);
            close(first, second, &mut kept);
        } else {
            push([corner(1).0, corner(2).0, second]);
            push([corner(1).0, second, first]);
            close(second, first, &mut kept);
        }
    }
    kept
}

/// Where a side crosses the plane: from its end above, whichever triangle asks.
fn crossing<F>(plane: &Plane<F>, one: (DVec3, f64), other: (DVec3, f64)) -> DVec3 {
    let (high, low) = if one.1 >= 0.0 { (one, other) } else { (other, one) };
    let mut at = high.0 + high.1 / (high.1 - low.1) * (low.0 - high.0);
    if let Some((axis, coordinate)) = plane.across {
        at[axis] = coordinate;
    }
    at
}

/// The body in each of some cells as a closed chain, in units of cells from the corner of each; `places`
/// ascend.
pub(super) fn cell_chains(surface: Vec<Oriented>, places: &[[usize; 3]]) -> Vec<Vec<Oriented>> {
    let mut chains = Vec::with_capacity(places.len());
    for slab in places.chunk_by(|a, b| a[0] == b[0]) {
        let in_slab = between(&surface, 0, slab[0][0]);
        for bar in slab.chunk_by(|a, b| a[1] == b[1]) {
            let in_bar = between(&in_slab, 1, bar[0][1]);
            for place in bar {
                let mut chain = between(&in_bar, 2, place[2]);
                let corner = DVec3::from_array(place.map(|n| n as f64));
                chain.iter_mut().flat_map(|t| &mut t.corners).for_each(|x| *x -= corner);
                chains.push(chain);
            }
        }
    }
    chains
}

/// The part of a chain in one layer of cells.
fn between(chain: &[Oriented], axis: usize, place: usize) -> Vec<Oriented> {
    let [low, high] = [place as f64, (place + 1) as f64];
    let face = 2 * axis as u8;
    let above = cut(chain, &plane_across(axis, low), true, Origin::Face(face));
    cut(&above, &plane_across(axis, high), false, Origin::Face(face + 1))
}
