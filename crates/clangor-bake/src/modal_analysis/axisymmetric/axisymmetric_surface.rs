//! The surface of an axisymmetric body as six-node triangles, and section fields evaluated on it.
//!
//! Points along the curve become rings with numbers of points in proportion to their length. Neighbouring
//! rings are triangulated. All nodes lie on the true surface, and have the section's motion times the exact
//! cos mφ or sin mφ.

use std::f64::consts::{FRAC_PI_4, TAU};

use clangor_core::geometry::meridian::{Meridian, Piece};
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::geometry::turning::lace_pair;
use clangor_core::sound_model::modal::surface::ModalSurface;
use glam::DVec3;

use super::section_mesh::SectionMesh;

/// Points of the smallest ring.
const LEAST_RING: usize = 8;

/// A node: its position on the curve, and its angle.
#[derive(Clone, Copy, Debug)]
struct Place {
    piece: usize,
    parameter: f64,
    /// φ \[turns\].
    turn: f64,
}

/// A surface with the position on the section of each node.
#[derive(Clone, Debug)]
pub(super) struct AxisymmetricSurface {
    pub(super) surface: ModalSurface,
    places: Vec<Place>,
}

struct Ring {
    piece: usize,
    parameter: f64,
    turns: Vec<f64>,
}

/// Unit vectors away from the axis and along φ at an angle \[turns\].
fn directions(turn: f64) -> (DVec3, DVec3) {
    let (sin, cos) = (TAU * turn).sin_cos();
    (DVec3::new(cos, 0.0, -sin), DVec3::new(-sin, 0.0, -cos))
}

impl AxisymmetricSurface {
    /// With edges of about `edge` \[m\], shorter where the curve bends.
    pub(super) fn new(meridian: &Meridian, edge: f64) -> Self {
        let rings = rings(meridian, edge);
        let pieces = meridian.pieces();
        let mut flat = TriMesh::default();
        let mut places = Vec::new();
        let mut starts = Vec::new();
        // Corner nodes on the rings.
        for ring in &rings {
            starts.push(places.len() as u32);
            let (piece, parameter) = (ring.piece, ring.parameter);
            places.extend(ring.turns.iter().map(|turn| Place { piece, parameter, turn: *turn }));
        }
        let corners = places.len();
        // The edge between two rings belongs to the piece that begins at the lower one.
        let pairs = if meridian.is_loop() { rings.len() } else { rings.len() - 1 };
        let mut bands = Vec::new();
        for below in 0..pairs {
            let above = (below + 1) % rings.len();
            let before = flat.triangles.len();
            lace_pair(&mut flat, (&rings[below].turns, starts[below]), (&rings[above].turns, starts[above]));
            bands.extend((before..flat.triangles.len()).map(|_| below));
        }
        // Mid-edge nodes, one per edge, on the true surface.
        let mut sides: Vec<([u32; 2], usize)> = Vec::new();
        for (t, band) in flat.triangles.iter().zip(&bands) {
            sides.extend((0..3).map(|k| (sorted([t[k], t[(k + 1) % 3]]), *band)));
        }
        sides.sort_unstable();
        sides.dedup_by_key(|(side, _)| *side);
        for ([a, b], band) in &sides {
            places.push(between(&rings, *band, &starts, [*a, *b], &places));
        }
        let number = |side: [u32; 2]| (corners + sides.partition_point(|(s, _)| *s < side)) as u32;
        let triangles = flat
            .triangles
            .iter()
            .map(|&[a, b, c]| {
                let [ab, bc, ca] = [[a, b], [b, c], [c, a]].map(|side| number(sorted(side)));
                [a, b, c, ab, bc, ca]
            })
            .collect();
        // Positions of all nodes.
        let position = |place: &Place| {
            let point = pieces[place.piece].point(place.parameter);
            directions(place.turn).0 * point.x + DVec3::Y * point.y
        };
        let nodes = places.iter().map(position).collect();
        AxisymmetricSurface { surface: ModalSurface { nodes, triangles }, places }
    }

    /// The motion of order m at the nodes, from that of the section's nodes. `across` shifts it by a quarter
    /// of its wave.
    pub(super) fn shape(&self, mesh: &SectionMesh, motion: &[DVec3], order: u32, across: bool) -> Vec<DVec3> {
        let at = |place: &Place| {
            let u = on_border(mesh, motion, place);
            let (out, around) = directions(place.turn);
            let (sin, cos) = (TAU * f64::from(order) * place.turn).sin_cos();
            // For m = 0, W is the twist.
            let (cos, sin) = match (order, across) {
                (0, _) => (1.0, 1.0),
                (_, false) => (cos, sin),
                (_, true) => (sin, -cos),
            };
            out * (u.x * cos) + DVec3::Y * (u.y * cos) + around * (u.z * sin)
        };
        self.places.iter().map(at).collect()
    }
}

fn sorted([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// The middle of an edge of a band, on the surface.
fn between(rings: &[Ring], band: usize, starts: &[u32], [a, b]: [u32; 2], places: &[Place]) -> Place {
    let [from, to] = [a, b].map(|n| places[n as usize]);
    let ring_of = |n: u32| starts.partition_point(|s| *s <= n) - 1;
    let (i, j) = (ring_of(a), ring_of(b));
    let pole = |k: usize| rings[k].turns.len() == 1;
    let turn = match (pole(i), pole(j)) {
        (true, _) => to.turn,
        (_, true) => from.turn,
        // The shorter way around, across φ = 0.
        _ if (from.turn - to.turn).abs() > 0.5 => (0.5 * (from.turn + to.turn + 1.0)).fract(),
        _ => 0.5 * (from.turn + to.turn),
    };
    if i == j {
        return Place { turn, ..from };
    }
    let low = &rings[band];
    let high = &rings[(band + 1) % rings.len()];
    let end = if high.piece == low.piece && high.parameter > low.parameter { high.parameter } else { 1.0 };
    Place { piece: low.piece, parameter: 0.5 * (low.parameter + end), turn }
}

fn rings(meridian: &Meridian, edge: f64) -> Vec<Ring> {
    let smallest = 1e-9 * meridian.bounding_radius();
    let mut rings = Vec::new();
    let mut add = |piece: usize, parameter: f64, r: f64| {
        let count = if r <= smallest { 1 } else { ((TAU * r / edge).ceil() as usize).max(LEAST_RING) };
        let turns = (0..count).map(|k| k as f64 / count as f64).collect();
        rings.push(Ring { piece, parameter, turns });
    };
    let pieces = meridian.pieces();
    for (k, piece) in pieces.iter().enumerate() {
        let bend = match piece {
            Piece::Line { .. } => 0.0,
            Piece::Arc { from, to, .. } => (to - from).abs() / FRAC_PI_4,
        };
        let count = (piece.length(0.0, 1.0) / edge).max(bend).ceil().max(1.0) as usize;
        for n in 0..count {
            let t = n as f64 / count as f64;
            add(k, t, piece.point(t).x);
        }
    }
    if !meridian.is_loop() {
        add(pieces.len() - 1, 1.0, 0.0);
    }
    rings
}

/// Interpolates values at the nodes of the section to a position on its border.
fn on_border(mesh: &SectionMesh, values: &[DVec3], place: &Place) -> DVec3 {
    let key = (place.piece, place.parameter);
    let after = mesh.border.partition_point(|e| (e.piece, e.range[0]) <= key);
    let edge = &mesh.border[after.max(1) - 1];
    let [from, to] = edge.range;
    let s = ((place.parameter - from) / (to - from)).clamp(0.0, 1.0);
    let weights = [(1.0 - s) * (1.0 - 2.0 * s), 4.0 * s * (1.0 - s), s * (2.0 * s - 1.0)];
    edge.nodes.iter().zip(weights).map(|(n, w)| values[*n as usize] * w).sum()
}
