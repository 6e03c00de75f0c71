//! Bodies of revolution about y: a profile in the (r, y) half-plane, sampled and turned.
//!
//! Rings hold fewer points towards the axis, so that triangles keep their shape. Every ring has a multiple of
//! four points, which keeps the centre of mass on the axis.

use std::f64::consts::{PI, TAU};

use glam::DVec2;

use crate::geometry::convex::ConvexPart;
use crate::geometry::meridian::{Meridian, Piece};
use crate::geometry::tri_mesh::TriMesh;
pub(super) use crate::geometry::turning::{Ring, lace, lace_pair, on_ring};

/// A profile: points (r, y) \[m\], counter-clockwise around the material. It starts and ends on the axis,
/// below and above, or is a closed loop off the axis.
#[derive(Clone, Debug)]
pub(super) struct Profile {
    points: Vec<DVec2>,
    pieces: Vec<Piece>,
    closed: bool,
    edge: f64,
    /// Largest distance of a chord from its arc \[m\].
    sagitta: f64,
}

impl Profile {
    /// Starts at a point; pieces are sampled at `edge` \[m\], and finer where a chord would leave its arc by
    /// `sagitta`.
    pub(super) fn start(point: DVec2, edge: f64, sagitta: f64) -> Self {
        Profile { points: vec![point], pieces: Vec::new(), closed: false, edge, sagitta }
    }

    fn end(&self) -> DVec2 {
        self.points[self.points.len() - 1]
    }

    /// A straight piece to a point.
    pub(super) fn line_to(mut self, r: f64, y: f64) -> Self {
        let (from, to) = (self.end(), DVec2::new(r, y));
        let count = (from.distance(to) / self.edge).ceil().max(1.0) as usize;
        self.points.extend((1..count).map(|k| from + (to - from) * (k as f64 / count as f64)));
        self.points.push(to);
        self.pieces.push(Piece::Line { from, to });
        self
    }

    /// A circular arc about `centre` to a point as far from it, by at most half a turn; `turn` is 1 for
    /// counter-clockwise, −1 for clockwise.
    pub(super) fn arc_to(mut self, centre: DVec2, to: DVec2, turn: f64) -> Self {
        let spoke = self.end() - centre;
        let radius = spoke.length();
        let angle = turn * (turn * spoke.angle_to(to - centre)).rem_euclid(TAU);
        // A chord of angle 2x leaves its arc by R (1 − cos x).
        let finest = 2.0 * (1.0 - (self.sagitta / radius).min(1.0)).acos();
        let count = (angle.abs() * radius / self.edge).max(angle.abs() / finest.min(PI / 3.0)).ceil().max(1.0)
            as usize;
        let at = |k: usize| centre + DVec2::from_angle(angle * (k as f64 / count as f64)).rotate(spoke);
        self.points.extend((1..count).map(at));
        self.points.push(to);
        let start = spoke.to_angle();
        self.pieces.push(Piece::Arc {
            centre,
            semi_axes: DVec2::splat(radius),
            from: start,
            to: start + angle,
        });
        self
    }

    /// The exact curve, if it bounds a body.
    pub(super) fn meridian(self) -> Option<Meridian> {
        Meridian::try_new(self.pieces).ok()
    }

    /// The points.
    pub(super) fn points(&self) -> &[DVec2] {
        &self.points
    }

    /// Ends a loop that has come back to its start.
    pub(super) fn close(mut self) -> Self {
        self.points.pop();
        self.closed = true;
        self
    }

    /// The surface of revolution.
    pub(super) fn turn(&self) -> TriMesh {
        let widest = self.points.iter().map(|p| p.x).fold(0.0, f64::max);
        let narrowest = self.points.iter().map(|p| p.x).fold(f64::INFINITY, f64::min);
        // A tube around a wide hole keeps one count: regular rings have smoother curvature.
        let even = self.closed && widest < 2.0 * narrowest;
        let rings: Vec<Ring> = self
            .points
            .iter()
            .map(|p| Ring { radius: p.x, y: p.y, turns: self.even_turns(if even { widest } else { p.x }) })
            .collect();
        lace(&rings, self.closed)
    }

    /// Angles of a ring, in turns.
    pub(super) fn even_turns(&self, radius: f64) -> Vec<f64> {
        if radius <= 0.0 {
            return vec![0.0];
        }
        let by_edge = TAU * radius / self.edge;
        let by_sagitta = PI / (1.0 - (self.sagitta / radius).min(1.0)).acos();
        let count = 4 * ((0.25 * by_edge.max(by_sagitta)).round() as usize).max(2);
        (0..count).map(|k| k as f64 / count as f64).collect()
    }
}

/// Fewest sides of a cylinder, and fewest chords around the tube of a torus, however slender they are: a rod
/// of eight sides is a tenth lighter than a round one, and bends more easily.
const FEWEST_SIDES: f64 = 48.0;
const FEWEST_CHORDS: f64 = 24.0;

/// Largest sagitta on a circle \[m\] that gives it at least `fewest` chords, where those of an edge are
/// fewer.
fn sagitta_of(radius: f64, edge: f64, fewest: f64) -> f64 {
    if TAU * radius / edge < fewest { radius * (1.0 - (PI / fewest).cos()) } else { f64::INFINITY }
}

/// A cylinder of full height `height` about the origin.
pub(super) fn cylinder_profile(radius: f64, height: f64, edge: f64) -> Profile {
    let half = 0.5 * height;
    Profile::start(DVec2::new(0.0, -half), edge, sagitta_of(radius, edge, FEWEST_SIDES))
        .line_to(radius, -half)
        .line_to(radius, half)
        .line_to(0.0, half)
}

/// A torus: the circle of radius `minor` about (major, 0), turned.
pub(super) fn torus_profile(major: f64, minor: f64, edge: f64) -> Profile {
    let centre = DVec2::new(major, 0.0);
    let (outermost, innermost) = (centre + DVec2::X * minor, centre - DVec2::X * minor);
    Profile::start(outermost, edge, sagitta_of(minor, edge, FEWEST_CHORDS))
        .arc_to(centre, innermost, 1.0)
        .arc_to(centre, outermost, 1.0)
        .close()
}

/// Convex wedges whose union stands for a turned section, cut into `sectors`.
///
/// `far` are the points (r, y) of the section on the side away from the axis: they are repeated halfway, so
/// that a wedge follows the round outside. `near` are those on the side of a hole or cavity: there the wedge
/// has a chord, moved outwards by half of its sagitta, so that it errs equally to both sides.
pub(super) fn wedges(far: &[DVec2], near: &[DVec2], sectors: usize) -> Vec<ConvexPart> {
    let step = TAU / sectors as f64;
    let chord = balance(0.5 * step);
    (0..sectors)
        .map(|k| {
            let from = step * k as f64;
            let far = far.iter().flat_map(|p| [0.0, 0.5, 1.0].map(|s| on_ring(*p, from + s * step)));
            let near = near
                .iter()
                .flat_map(|p| [0.0, 1.0].map(|s| on_ring(*p * DVec2::new(chord, 1.0), from + s * step)));
            ConvexPart::Hull(far.chain(near).collect())
        })
        .collect()
}

/// Factor on the radius of a chord of half angle `half` \[rad\] that makes it err as much inwards as
/// outwards.
pub(super) fn balance(half: f64) -> f64 {
    2.0 / (1.0 + half.cos())
}

/// The hull of circles (r, y), each as 40 points: a convex body of revolution, off by 0.16 % of the radius.
pub(super) fn axisymmetric_hull(circles: &[DVec2]) -> ConvexPart {
    const COUNT: usize = 40;
    let widen = DVec2::new(balance(PI / COUNT as f64), 1.0);
    let ring = |p: &DVec2| {
        let p = *p * widen;
        (0..COUNT).map(move |k| on_ring(p, TAU * k as f64 / COUNT as f64))
    };
    ConvexPart::Hull(circles.iter().flat_map(ring).collect())
}

/// A torus as drums between sections of the tube, `sectors` of them.
///
/// The section is a dodecagon whose sides err as much inwards as its corners err outwards.
pub(super) fn torus_parts(major: f64, minor: f64, sectors: usize) -> Vec<ConvexPart> {
    let corner = |k: usize| {
        let spoke = DVec2::from_angle(TAU * (k as f64 + 0.5) / 12.0);
        DVec2::new(major, 0.0) + spoke * minor * balance(PI / 12.0)
    };
    let (far, near): (Vec<DVec2>, Vec<DVec2>) = (0..12).map(corner).partition(|p| p.x > major);
    wedges(&far, &near, sectors)
}
