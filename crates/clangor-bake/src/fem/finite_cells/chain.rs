//! Closed surfaces as sums of oriented triangles and plane caps, cut by planes and closed again.
//!
//! A cut keeps what lies on one side and closes it with a cap in the plane. A cap is its border: segments
//! that end where others begin. Integrals over it are sums over cones, one signed triangle per segment with
//! the same apex; parts outside the section cancel, whatever its form. Integrals over the closed chain
//! therefore stay exact.
//!
//! Neighbouring triangles find the same crossing of their common side, bit for bit, and a point on the plane
//! is always above it: nothing is lost or counted twice, however the surface lies to the plane.

use glam::DVec3;

/// The plane of a cap.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Origin {
    /// A face of the cell: twice the axis, plus 1 for the upper one.
    Face(u8),
    /// A plane inside a part; its two sides cancel.
    Inner,
    /// The division from the wall of this number.
    Division(usize),
}

/// A plane piece of a closed surface.
#[derive(Clone, Debug)]
pub(super) struct Cap {
    pub(super) origin: Origin,
    /// Its border, counter-clockwise about the outward normal.
    pub(super) border: Vec<[DVec3; 2]>,
}

/// A closed surface.
#[derive(Clone, Debug, Default)]
pub(super) struct Chain {
    pub(super) triangles: Vec<[DVec3; 3]>,
    pub(super) caps: Vec<Cap>,
}

impl Cap {
    /// Signed triangles whose sum is the cap.
    pub(super) fn cones(&self) -> impl Iterator<Item = [DVec3; 3]> {
        let apex = self.border.first().map_or(DVec3::ZERO, |side| side[0]);
        self.border.iter().map(move |[from, to]| [apex, *from, *to])
    }

    /// Area along the outward normal.
    pub(super) fn area_vector(&self) -> DVec3 {
        self.cones().map(|[a, b, c]| 0.5 * (b - a).cross(c - a)).sum()
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

impl<F: Fn(DVec3) -> f64> Plane<F> {
    /// Where a side crosses the plane: from its end above, whichever triangle asks.
    fn crossing(&self, one: (DVec3, f64), other: (DVec3, f64)) -> DVec3 {
        let (high, low) = if one.1 >= 0.0 { (one, other) } else { (other, one) };
        let mut at = high.0 + high.1 / (high.1 - low.1) * (low.0 - high.0);
        if let Some((axis, coordinate)) = self.across {
            at[axis] = coordinate;
        }
        at
    }
}

impl Chain {
    pub(super) fn is_empty(&self) -> bool {
        self.triangles.is_empty() && self.caps.is_empty()
    }

    /// Adds another chain without its inner caps.
    pub(super) fn extend(&mut self, other: Chain) {
        self.triangles.extend(other.triangles);
        self.caps.extend(other.caps.into_iter().filter(|cap| cap.origin != Origin::Inner));
    }

    /// The part above a plane, or below it, closed again.
    pub(super) fn cut<F: Fn(DVec3) -> f64>(&self, plane: &Plane<F>, above: bool, closing: Origin) -> Chain {
        let mut kept = Chain::default();
        let mut closed = Cap { origin: closing, border: Vec::new() };
        for triangle in &self.triangles {
            cut_triangle(triangle, plane, above, &mut kept.triangles, &mut closed.border);
        }
        for cap in &self.caps {
            let mut part = Cap { origin: cap.origin, border: Vec::new() };
            // Where the border leaves the kept side (1), and where it comes back (−1).
            let mut ends: Vec<(DVec3, i32)> = Vec::new();
            for [from, to] in &cap.border {
                let values = [from, to].map(|x| (plane.value)(*x));
                match values.map(|value| (value >= 0.0) == above) {
                    [true, true] => part.border.push([*from, *to]),
                    [false, false] => {}
                    [leaving, _] => {
                        let at = plane.crossing((*from, values[0]), (*to, values[1]));
                        part.border.push(if leaving { [*from, at] } else { [at, *to] });
                        ends.push((at, if leaving { 1 } else { -1 }));
                    }
                }
            }
            for [from, to] in segments(&mut ends) {
                part.border.push([from, to]);
                closed.border.push([to, from]);
            }
            if !part.border.is_empty() {
                kept.caps.push(part);
            }
        }
        if !closed.border.is_empty() {
            kept.caps.push(closed);
        }
        kept
    }

    /// The part in one layer of cells.
    fn between(&self, axis: usize, place: usize) -> Chain {
        let [low, high] = [place as f64, (place + 1) as f64];
        let face = 2 * axis as u8;
        let above = self.cut(&plane_across(axis, low), true, Origin::Face(face));
        above.cut(&plane_across(axis, high), false, Origin::Face(face + 1))
    }
}

/// Adds the kept part of a triangle, and its piece of the border of the cap.
fn cut_triangle<F: Fn(DVec3) -> f64>(
    corners: &[DVec3; 3],
    plane: &Plane<F>,
    above: bool,
    kept: &mut Vec<[DVec3; 3]>,
    border: &mut Vec<[DVec3; 2]>,
) {
    let values = corners.map(&plane.value);
    let inside = values.map(|value| (value >= 0.0) == above);
    let count = inside.iter().filter(|inside| **inside).count();
    if count == 3 {
        kept.push(*corners);
    }
    if count == 0 || count == 3 {
        return;
    }
    // The corner alone on its side comes first.
    let lone = (0..3).find(|k| inside[*k] == (count == 1)).unwrap_or(0);
    let corner = |k: usize| (corners[(lone + k) % 3], values[(lone + k) % 3]);
    let [first, second] = [1, 2].map(|k| plane.crossing(corner(0), corner(k)));
    if count == 1 {
        kept.push([corner(0).0, first, second]);
        border.push([second, first]);
    } else {
        kept.push([corner(1).0, corner(2).0, second]);
        kept.push([corner(1).0, second, first]);
        border.push([first, second]);
    }
}

/// The segments of a line that close a border: each runs from where the border leaves to where it comes back.
fn segments(ends: &mut [(DVec3, i32)]) -> Vec<[DVec3; 2]> {
    let (low, high) = ends
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), (x, _)| (low.min(*x), high.max(*x)));
    let axis = (high - low).max_position();
    ends.sort_by(|a, b| a.0[axis].total_cmp(&b.0[axis]));
    let mut all = Vec::new();
    let mut winding = 0;
    for pair in ends.windows(2) {
        winding += pair[0].1;
        let [from, to] = [pair[0].0, pair[1].0];
        if from != to {
            for _ in 0..winding.abs() {
                all.push(if winding > 0 { [from, to] } else { [to, from] });
            }
        }
    }
    all
}

/// The body in each of some cells, in units of cells from the corner of each; `places` ascend.
pub(super) fn cell_chains(surface: Vec<[DVec3; 3]>, places: &[[usize; 3]]) -> Vec<Chain> {
    let mut chains = Vec::with_capacity(places.len());
    let surface = Chain { triangles: surface, caps: Vec::new() };
    for slab in places.chunk_by(|a, b| a[0] == b[0]) {
        let in_slab = surface.between(0, slab[0][0]);
        for bar in slab.chunk_by(|a, b| a[1] == b[1]) {
            let in_bar = in_slab.between(1, bar[0][1]);
            for place in bar {
                let mut chain = in_bar.between(2, place[2]);
                let corner = DVec3::from_array(place.map(|n| n as f64));
                chain.triangles.iter_mut().flatten().for_each(|x| *x -= corner);
                chain.caps.iter_mut().flat_map(|cap| &mut cap.border).flatten().for_each(|x| *x -= corner);
                chains.push(chain);
            }
        }
    }
    chains
}
