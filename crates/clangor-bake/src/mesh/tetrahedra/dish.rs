//! Plates, bowls and coins: a square grid mapped to a disc, between the lower and the upper side of a wall of
//! revolution.
//!
//! A point of the disc at the fraction ρ of its radius lies on the lines that connect points of the two sides
//! at the fraction ρ of their lengths from the axis. Elements have nearly one size, whereas rotating a
//! section makes wedges that are narrow near the axis and long at the rim.

use clangor_core::geometry::meridian::Meridian;
use glam::{DVec2, DVec3};

use super::block::grid;
use super::{TetMesh, TetMeshError};
use crate::mesh::tetrahedra::cylinder::disc;

/// Points on each piece of the meridian.
const SAMPLES: usize = 64;
/// Candidate positions of the rim along the meridian.
const RIMS: usize = 400;
/// Largest thickness over the length of the sides.
const THIN: f64 = 0.25;
/// Chord of the rim over the thickness beside it: less than 1, because rounded rims narrow towards their end.
const CHORD: f64 = 0.85;
/// Ends of pieces closer to the rim than this fraction of the thickness become its edges.
const EDGE: f64 = 0.4;

/// The section of an open wall.
pub struct Dish {
    points: Vec<DVec2>,
    /// Length of the meridian up to each point \[m\].
    lengths: Vec<f64>,
    /// Interval of the rim \[m\].
    rim: [f64; 2],
    thickness: f64,
}

impl Dish {
    /// The wall along a meridian; `None` if it is not thin, or starts or ends off the axis.
    pub fn of(meridian: &Meridian) -> Option<Self> {
        if meridian.is_loop() {
            return None;
        }
        let pieces = meridian.pieces();
        // Sample the meridian by arc length.
        let mut points = vec![pieces[0].point(0.0)];
        for piece in pieces {
            points.extend((1..=SAMPLES).map(|k| piece.point(k as f64 / SAMPLES as f64)));
        }
        let mut lengths = vec![0.0];
        for pair in points.windows(2) {
            lengths.push(lengths[lengths.len() - 1] + pair[0].distance(pair[1]));
        }
        let total = lengths[lengths.len() - 1];
        let mut dish = Dish { points, lengths, rim: [0.0; 2], thickness: 0.0 };
        // Thickness between points at equal fractions of both sides.
        let walls = |dish: &Dish, rim: f64| -> Vec<f64> {
            let wall = |k: usize| {
                let part = k as f64 / 40.0;
                dish.at(part * rim).distance(dish.at(total - part * (total - rim)))
            };
            (0..40).map(wall).collect()
        };
        // Rim: the split that minimises the distance of the sides.
        let spread = |rim: f64| walls(&dish, rim).iter().map(|w| w * w).sum::<f64>();
        let rims = (RIMS / 4..3 * RIMS / 4).map(|k| total * k as f64 / RIMS as f64);
        let rim = rims.min_by(|a, b| spread(*a).total_cmp(&spread(*b)))?;
        let walls = walls(&dish, rim);
        let thickest = walls.iter().copied().fold(0.0, f64::max);
        if thickest > THIN * rim.min(total - rim) {
            return None;
        }
        // Interval of the rim: where its chord reaches the thickness.
        let thickness = walls[30];
        let step = 0.01 * thickness;
        let back = (1..400)
            .map(|k| k as f64 * step)
            .find(|back| dish.at(rim - back).distance(dish.at(rim + back)) >= CHORD * thickness)?;
        // Snap to a geometric edge nearby.
        let to_edge = |at: f64| {
            let ends = (0..=pieces.len()).map(|k| dish.lengths[k * SAMPLES]);
            let near = ends.min_by(|a, b| (a - at).abs().total_cmp(&(b - at).abs()));
            near.filter(|end| (end - at).abs() < EDGE * thickness).unwrap_or(at)
        };
        dish.rim = [to_edge(rim - back), to_edge(rim + back)];
        dish.thickness = thickness;
        (dish.rim[0] < dish.rim[1]).then_some(dish)
    }

    /// Thickness of the wall \[m\].
    pub fn thickness(&self) -> f64 {
        self.thickness
    }

    /// Length of the longer side from one end of the rim over the axis to the other \[m\].
    pub fn width(&self) -> f64 {
        2.0 * self.rim[0].max(self.lengths[self.lengths.len() - 1] - self.rim[1])
    }

    /// A mesh with `across` elements from rim to rim and `layers` through the wall; edges are straight.
    ///
    /// # Errors
    /// [`TetMeshError`] for no elements, or a wall that folds.
    pub fn mesh(&self, across: usize, layers: usize) -> Result<TetMesh, TetMeshError> {
        if across == 0 || layers == 0 {
            return Err(TetMeshError::Empty);
        }
        let total = self.lengths[self.lengths.len() - 1];
        let (points, tetrahedra) = grid([across, across, layers], |at| {
            let place = disc(at);
            let part = place.length();
            let point = if part > 1.0 - 1e-9 {
                self.at(self.rim[0] + at.z * (self.rim[1] - self.rim[0]))
            } else {
                self.at(part * self.rim[0]).lerp(self.at(total - part * (total - self.rim[1])), at.z)
            };
            let direction = place.normalize_or_zero();
            DVec3::new(point.x * direction.x, point.y, point.x * direction.y)
        });
        TetMesh::straight(points, &tetrahedra)
    }

    /// The point at an arc length of the meridian.
    fn at(&self, length: f64) -> DVec2 {
        let next = self.lengths.partition_point(|l| *l < length).clamp(1, self.lengths.len() - 1);
        let (from, to) = (self.lengths[next - 1], self.lengths[next]);
        let part = if to > from { ((length - from) / (to - from)).clamp(0.0, 1.0) } else { 0.0 };
        self.points[next - 1].lerp(self.points[next], part)
    }
}
