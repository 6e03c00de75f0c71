//! The axes of the grid of a body in cells: its mirror planes, of which only the cells on one side are
//! solved, then its faces (see [`face_directions`](super::face_directions)).
//!
//! A mirror plane through an inner edge of thin walls is none here. The walls would be joined on a whole face
//! of a cell there, and not on their mitre, which is stiffer by more than the next order or half the edge
//! shows.

use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::geometry::tri_mesh::TriMesh;
use glam::{DMat3, DVec3};

use super::ImmersedBody;
use super::face_directions::main_direction;
use crate::geometry_class::inner_creases::inner_edges_of_walls;
use crate::geometry_class::mirror_symmetry::mirror_planes_of_walls;
use crate::mesh::remesh::frame_of;

/// Largest mean distance between a surface and its image, in walls and in the accuracy of frequencies: the
/// thickness of a wall changes by as much, and its frequencies of bending with it.
const ASYMMETRY: f64 = 0.5;
/// Largest accuracy for which planes are found: no grid mends an image that is none.
const MOST_ASYMMETRIC: f64 = 0.05;

/// Largest distance of the same, in walls: a face of a slit reaches deeper.
const DEEPEST: f64 = 0.2;

/// Largest distance of the ends of an inner edge from a plane that goes through it, in walls.
const THROUGH_EDGE: f64 = 0.3;
/// Largest difference of axes, in their components or 1 less their cosine, that counts as rounding.
const ROUNDING: f64 = 1e-9;

/// The mirror planes of a body, if any, and the body in their axes.
pub(super) struct Mirrors {
    /// Where they meet \[m\].
    pub(super) centre: DVec3,
    /// Rotation from the axes of the planes to those of the body.
    pub(super) frame: DMat3,
    /// Whether the plane across each of these axes is one.
    pub(super) planes: [bool; 3],
    /// The surface, from where the planes meet, in their axes.
    pub(super) surface: TriMesh,
}

impl ImmersedBody<'_> {
    /// The same free body on one side of its mirror planes, found within an accuracy of frequencies, with
    /// the other axes of the grid across its faces.
    pub(in crate::modal_analysis) fn by_mirrors(self, accuracy: f64) -> Self {
        let Ok(mass) = MassProperties::of(&self.surface) else { return self };
        let centre = mass.centre_of_mass;
        let within = ASYMMETRY * accuracy.min(MOST_ASYMMETRIC) * self.walls.thickness;
        let planes = mirror_planes_of_walls(&self.surface, within, DEEPEST * self.walls.thickness);
        // A plane that goes through an inner edge of thin walls is none.
        let edges = match self.walls.creased && self.walls.thin {
            true => inner_edges_of_walls(&self.surface, &self.walls),
            false => Vec::new(),
        };
        let near = |end: &DVec3, normal: DVec3| {
            (*end - centre).dot(normal).abs() < THROUGH_EDGE * self.walls.thickness
        };
        let is_kept = |normal: &DVec3| !edges.iter().any(|ends| ends.iter().all(|end| near(end, *normal)));
        let normals: Vec<DVec3> = planes.into_iter().map(|plane| plane.normal).filter(is_kept).collect();
        let mut axes = normals.clone();
        while axes.len() < 2
            && let Some(direction) = main_direction(&self.surface, &axes)
        {
            axes.push(direction);
        }
        let (frame, _) = frame_of(&axes);
        let planes = [0, 1, 2].map(|a| normals.iter().any(|n| 1.0 - frame.col(a).dot(*n).abs() < ROUNDING));
        if normals.is_empty() && frame.abs_diff_eq(DMat3::IDENTITY, ROUNDING) {
            return self;
        }
        let vertices = self.surface.vertices.iter().map(|v| frame.transpose() * (*v - centre)).collect();
        let surface = TriMesh { vertices, triangles: self.surface.triangles.clone() };
        ImmersedBody { mirrors: Some(Mirrors { centre, frame, planes, surface }), ..self }
    }
}

#[cfg(test)]
mod tests {
    use std::borrow::Cow;
    use std::f64::consts::TAU;

    use clangor_core::material::presets::GLASS;
    use glam::DQuat;

    use super::super::CellEffort;
    use super::*;
    use crate::cost::work_limit::WorkLimit;
    use crate::fem::ElasticConstants;
    use crate::fem::finite_cells::{CellGrid, Order};
    use crate::geometry_class::mirror_symmetry::{mirror_planes, mirror_planes_in_mean};
    use crate::modal_analysis::RefinableDiscretization;
    use crate::modal_analysis::mirror_parities::MirrorParities;

    fn turn() -> DQuat {
        DQuat::from_scaled_axis(DVec3::new(0.6, 0.9, 0.4))
    }

    /// A plate of fields without some of them, 8 mm thick, turned and off the origin: `place` of a corner
    /// along and across \[mm\]. All vertices are corners of fields.
    fn plate(
        [columns, rows]: [usize; 2],
        missing: &[[usize; 2]],
        place: impl Fn(usize, usize) -> [f64; 2],
    ) -> TriMesh {
        let corner = |k: usize| {
            let [x, y] = place(k / 2 / rows, k / 2 % rows);
            let z = if k.is_multiple_of(2) { -4.0 } else { 4.0 };
            turn() * (1e-3 * DVec3::new(x, y, z)) + DVec3::new(0.01, 0.0, -0.02)
        };
        let there = |i: usize, j: usize| i < columns - 1 && j < rows - 1 && !missing.contains(&[i, j]);
        let mut triangles = Vec::new();
        let mut quad = |corners: [[usize; 3]; 4]| {
            let [a, b, c, d] = corners.map(|[i, j, level]| (2 * (i * rows + j) + level) as u32);
            triangles.extend([[a, b, c], [a, c, d]]);
        };
        for (i, j) in (0..columns - 1).flat_map(|i| (0..rows - 1).map(move |j| (i, j))) {
            if !there(i, j) {
                continue;
            }
            let ring = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]];
            quad(ring.map(|[i, j]| [i, j, 1]));
            quad([0, 3, 2, 1].map(|k: usize| [ring[k][0], ring[k][1], 0]));
            let beside = [(i, j.wrapping_sub(1)), (i + 1, j), (i, j + 1), (i.wrapping_sub(1), j)];
            for (k, _) in beside.into_iter().enumerate().filter(|(_, (i, j))| !there(*i, *j)) {
                let ([ax, ay], [bx, by]) = (ring[k], ring[(k + 1) % 4]);
                quad([[ax, ay, 0], [bx, by, 0], [bx, by, 1], [ax, ay, 1]]);
            }
        }
        // Corners of missing fields only belong to no triangle.
        let mut used: Vec<u32> = triangles.iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        let vertices = used.iter().map(|k| corner(*k as usize)).collect();
        triangles.iter_mut().flatten().for_each(|k| *k = used.partition_point(|other| other < k) as u32);
        TriMesh { vertices, triangles }
    }

    /// On the same grid, all of it against one part with all parities: frequencies, and shapes in the axes of
    /// the body with the mass of the whole.
    fn against_whole(surface: &TriMesh, (planes, limit): (usize, f64)) {
        let constants = ElasticConstants::of(&GLASS.material()).expect("glass");
        let body = ImmersedBody::new(Cow::Borrowed(surface), &constants, 80_000, CellEffort::Accurate);
        let body = body.expect("a solid").by_mirrors(0.01);
        let part = body.with(0.011, Order::Third).expect("cells");
        let MirrorParities(mirrored) = part.mirrors();
        assert_eq!(mirrored.iter().filter(|plane| **plane).count(), planes, "{mirrored:?}");
        let whole = CellGrid { images: [0; 3], ..part.cells.grid() };
        let whole = body.on(whole, Order::Third).expect("cells");
        assert!(10 * part.cells.node_count() < 6 * whole.cells.node_count());
        let spectra = [&part, &whole].map(|mesh| body.solve(mesh, limit, &WorkLimit::none()).expect("modes"));
        let [of_part, of_whole] = &spectra;
        let count = of_part.frequencies.len();
        assert_eq!(count, of_whole.frequencies.len());
        assert!(count >= 8, "{:?}", of_part.frequencies);
        let (_, shapes) = body.shapes(&part, &of_part.modes, count);
        let (_, references) = body.shapes(&whole, &of_whole.modes, count);
        for k in 0..count {
            // Seen: 2e-11, and 7e-13 of shapes.
            let [found, reference] = [of_part.frequencies[k], of_whole.frequencies[k]];
            assert!((found / reference - 1.0).abs() < 1e-9, "{found} {reference}");
            let dot = |a: &[DVec3], b: &[DVec3]| a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum::<f64>();
            let square = dot(&references[k], &references[k]);
            let same = dot(&shapes[k], &references[k]) / square;
            let size = dot(&shapes[k], &shapes[k]) / square;
            assert!((same.abs() - 1.0).abs() < 1e-9 && (size - 1.0).abs() < 1e-9, "{k}: {same} {size}");
        }
    }

    #[test]
    fn a_part_has_the_modes_of_the_whole() {
        // The third plane, in the middle of the plate, spares no cells.
        let at = |i: usize, j: usize| [60.0 * i as f64, 40.0 * j as f64];
        against_whole(&plate([2, 2], &[], at), (2, 70e3));
    }

    /// A ring with a slit of 0.2 mm on one of its planes: its ends move apart.
    #[test]
    fn a_slit_on_a_plane_stays_open() {
        const SIDES: usize = 64;
        let at = |i: usize, j: usize| {
            let (begin, radius) = (0.1 / 30.0, if j == 0 { 34.0 } else { 26.0 });
            let angle = begin + (TAU - 2.0 * begin) * i as f64 / SIDES as f64;
            [radius * angle.cos(), radius * angle.sin()]
        };
        against_whole(&plate([SIDES + 1, 2], &[], at), (1, 20e3));
    }

    /// Two holes at opposite corners: no vertex tells that their images are none.
    #[test]
    fn holes_without_images_leave_no_planes() {
        let lines = [-30.0, -20.0, -10.0, 10.0, 20.0, 30.0];
        let surface = plate([6, 6], &[[1, 1], [3, 3]], |i, j| [lines[i], lines[j]]);
        let [x, y, z] = DVec3::AXES.map(|axis| turn() * axis);
        let planes = [
            mirror_planes(&surface, 1e-6),
            mirror_planes_in_mean(&surface, 5e-5, 5e-5),
            mirror_planes_of_walls(&surface, 1e-5, 2e-4),
        ];
        assert!(planes.iter().all(|planes| !planes.is_empty()));
        for plane in planes.into_iter().flatten() {
            // The middle plane and the diagonals are true ones.
            let along = [x, y, z].map(|axis| plane.normal.dot(axis).abs());
            assert!(along[2] > 0.999 || (along[0] - along[1]).abs() < 1e-6, "{along:?}");
        }
    }
}
