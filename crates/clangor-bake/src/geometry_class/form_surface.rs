//! The surface of an exact form as smooth faces: distance of a point from each, and points that sample all of
//! them with their edges and corners.
//!
//! A triangle that samples a form has its corners on one smooth face. A bevel joins two, and the wall of a
//! hole
//! none.

use std::f64::consts::TAU;

use clangor_core::geometry::icosahedron::icosahedron;
use clangor_core::geometry::meridian::{Meridian, Piece};
use glam::{DVec2, DVec3};

use super::bake_geometry::BakeGeometry;

/// Sine of the angle between two pieces of a section above which they are two faces.
const EDGE: f64 = 0.2;
/// Samples along a piece of a section; around the axis, a number that shares no factor with usual meshes.
const ALONG: usize = 9;
const AROUND: usize = 37;
/// Samples along an edge of a face of a box.
const ACROSS: usize = 9;
/// Parts of an edge of the icosahedron that samples an ellipsoid or a rounding.
const DIVISIONS: u32 = 5;

/// Smooth faces of an exact form; a body of revolution has its axis along y.
pub(super) enum FormSurface {
    Ellipsoid(DVec3),
    /// A box without rounding: half edges.
    Box(DVec3),
    /// Half edges of the core, and the radius of the rounding.
    RoundedBox(DVec3, f64),
    /// The pieces of the section that continue each other smoothly.
    Revolution(Vec<Vec<Piece>>),
}

impl FormSurface {
    /// `None` for a mesh.
    pub(super) fn of(form: &BakeGeometry) -> Option<Self> {
        Some(match form {
            BakeGeometry::Ellipsoid { semi_axes } => FormSurface::Ellipsoid(*semi_axes),
            BakeGeometry::RoundedBox { edges, round: 0.0 } => FormSurface::Box(0.5 * *edges),
            BakeGeometry::RoundedBox { edges, round } => {
                FormSurface::RoundedBox(0.5 * *edges - *round, *round)
            }
            BakeGeometry::Axisymmetric { meridian, .. } => FormSurface::Revolution(smooth_runs(meridian)),
            BakeGeometry::Mesh(_) => return None,
        })
    }

    /// Number of faces.
    pub(super) fn faces(&self) -> usize {
        match self {
            FormSurface::Ellipsoid(_) | FormSurface::RoundedBox(..) => 1,
            FormSurface::Box(_) => 6,
            FormSurface::Revolution(runs) => runs.len(),
        }
    }

    /// Distance of a point from a face \[m\]; of an ellipsoid to first order.
    pub(super) fn distance(&self, face: usize, x: DVec3) -> f64 {
        match self {
            FormSurface::Ellipsoid(semi_axes) => {
                // The scaled distance to the centre, over the length of its gradient.
                let scaled = x / *semi_axes;
                ((scaled.length() - 1.0) * scaled.length() / (scaled / *semi_axes).length()).abs()
            }
            FormSurface::Box(half) => {
                let mut nearest = x.clamp(-*half, *half);
                let axis = face / 2;
                nearest[axis] = if face.is_multiple_of(2) { half[axis] } else { -half[axis] };
                x.distance(nearest)
            }
            FormSurface::RoundedBox(core, round) => {
                let outside = x.abs() - *core;
                (outside.max(DVec3::ZERO).length() + outside.max_element().min(0.0) - round).abs()
            }
            FormSurface::Revolution(runs) => {
                let point = DVec2::new(x.x.hypot(x.z), x.y);
                runs[face].iter().map(|piece| distance_to(piece, point)).fold(f64::INFINITY, f64::min)
            }
        }
    }

    /// Points all over the surface, corners and edges of boxes among them, with the outward normals there.
    pub(super) fn samples(&self) -> Vec<(DVec3, DVec3)> {
        match self {
            FormSurface::Ellipsoid(semi_axes) => {
                directions().map(|d| (d * *semi_axes, (d / *semi_axes).normalize_or_zero())).collect()
            }
            FormSurface::Box(half) => faces_of(*half, 0.0).collect(),
            FormSurface::RoundedBox(core, round) => {
                let corners = directions().map(|d| (*core * d.map(f64::signum) + *round * d, d));
                corners.chain(faces_of(*core, *round)).collect()
            }
            FormSurface::Revolution(runs) => {
                let pieces = runs.iter().flatten();
                let points = pieces.flat_map(|piece| {
                    // The material is to the left.
                    let place = |k: usize| {
                        (piece.point(inside(k)), -piece.velocity(inside(k)).normalize_or_zero().perp())
                    };
                    (0..ALONG).map(place)
                });
                let ring = |(n, (p, normal)): (usize, (DVec2, DVec2))| {
                    (0..AROUND).map(move |k| {
                        // Each ring starts at another angle.
                        let (sin, cos) = (TAU * (k as f64 + 0.618 * n as f64) / AROUND as f64).sin_cos();
                        let turned = |v: DVec2| DVec3::new(v.x * cos, v.y, v.x * sin);
                        (turned(p), turned(normal))
                    })
                };
                points.enumerate().flat_map(ring).collect()
            }
        }
    }
}

/// Parameters along a piece, from 2 to 98 %: at an edge itself, the side that a sample belongs to is
/// undecided.
fn inside(k: usize) -> f64 {
    0.02 + 0.96 * k as f64 / (ALONG - 1) as f64
}

/// Unit vectors in all directions, about evenly.
fn directions() -> impl Iterator<Item = DVec3> {
    icosahedron().into_iter().flat_map(|[a, b, c]| {
        let each = (0..=DIVISIONS).flat_map(|i| (0..=DIVISIONS - i).map(move |j| (i, j)));
        each.map(move |(i, j)| {
            let [u, v] = [i, j].map(|n| f64::from(n) / f64::from(DIVISIONS));
            (a * u + b * v + c * (1.0 - u - v)).normalize_or_zero()
        })
    })
}

/// Grids on the faces of a box with these half edges, moved outwards, with their normals.
fn faces_of(half: DVec3, out: f64) -> impl Iterator<Item = (DVec3, DVec3)> {
    let step = |k: usize| 2.0 * k as f64 / (ACROSS - 1) as f64 - 1.0;
    (0..6).flat_map(move |face| {
        (0..ACROSS * ACROSS).map(move |k| {
            let axis = face / 2;
            let side = if face % 2 == 0 { 1.0 } else { -1.0 };
            let mut unit = DVec3::splat(side);
            unit[(axis + 1) % 3] = step(k % ACROSS);
            unit[(axis + 2) % 3] = step(k / ACROSS);
            let normal = side * DVec3::AXES[axis];
            (unit * half + out * normal, normal)
        })
    })
}

/// The pieces of a section in runs without a sharp edge inside.
fn smooth_runs(meridian: &Meridian) -> Vec<Vec<Piece>> {
    let joins = |before: &Piece, after: &Piece| {
        let (from, to) = (before.velocity(1.0).normalize_or_zero(), after.velocity(0.0).normalize_or_zero());
        from.perp_dot(to).abs() <= EDGE && from.dot(to) > 0.0
    };
    let mut runs: Vec<Vec<Piece>> = Vec::new();
    for piece in meridian.pieces() {
        match runs.last_mut() {
            Some(run) if run.last().is_some_and(|before| joins(before, piece)) => run.push(*piece),
            _ => runs.push(vec![*piece]),
        }
    }
    // The end of a loop continues its start.
    let around = |runs: &[Vec<Piece>]| {
        let (last, first) = (runs.last()?.last()?, runs.first()?.first()?);
        Some(runs.len() > 1 && joins(last, first))
    };
    if meridian.is_loop() && around(&runs) == Some(true) {
        let mut last = runs.pop().unwrap_or_default();
        last.append(&mut runs[0]);
        runs[0] = last;
    }
    runs
}

/// Distance of a point from a piece of a section, exact on the piece.
pub(super) fn distance_to(piece: &Piece, point: DVec2) -> f64 {
    let nearest = match *piece {
        Piece::Line { from, to } => {
            ((point - from).dot(to - from) / (to - from).length_squared()).clamp(0.0, 1.0)
        }
        Piece::Arc { centre, semi_axes, from, to } => {
            let scaled = (point - centre) / semi_axes;
            // The angle in the turn that is nearest to the middle of the arc.
            let middle = 0.5 * (from + to);
            let angle = scaled.y.atan2(scaled.x);
            let angle = angle + TAU * ((middle - angle) / TAU).round();
            ((angle - from) / (to - from)).clamp(0.0, 1.0)
        }
    };
    piece.point(nearest).distance(point)
}
