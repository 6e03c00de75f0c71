//! A plate and a brick with holes in cells, against quadratic hexahedra on grids that are fitted to the
//! holes.

use std::f64::consts::TAU;

use clangor_bake::fem::ElasticConstants;
use clangor_bake::geometry_class::bake_geometry::BakeGeometry;
use clangor_bake::modal_analysis::{ModalAnalysisOptions, modal_analysis};
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::material::presets::STEEL;
use clangor_core::sound_model::modal::model::ModalMode;
use glam::DVec3;
use std::collections::BTreeMap;
use std::ops::ControlFlow;

/// Sides of a hole, a multiple of four.
const SIDES: u32 = 32;

/// Equal squares with a hole of many sides in each.
struct Perforated {
    /// Holes along x and y.
    holes: [u32; 2],
    /// Edge of a square \[m\].
    spacing: f64,
    /// Of the holes \[m\].
    radius: f64,
    /// \[m\]
    thickness: f64,
}

impl Perforated {
    fn mesh(&self) -> TriMesh {
        let [columns, rows] = self.holes;
        let mut corners: BTreeMap<[i64; 3], u32> = BTreeMap::new();
        let mut mesh = TriMesh::default();
        let mut quad = |places: [DVec3; 4]| {
            let [a, b, c, d] = places.map(|place| {
                let key = (place * 1e9).to_array().map(|x| x.round() as i64);
                *corners.entry(key).or_insert_with(|| {
                    mesh.vertices.push(place);
                    mesh.vertices.len() as u32 - 1
                })
            });
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        };
        let half = 0.5 * self.spacing;
        // On the border of a square and on the hole, in the same direction.
        let at = |k: u32| {
            let (sine, cosine) = (TAU * (f64::from(k % SIDES) + 0.5) / f64::from(SIDES)).sin_cos();
            DVec3::new(cosine, sine, 0.0)
        };
        let border = |k: u32| {
            let along = TAU / 4.0 / f64::from(SIDES / 4);
            let (side, step) = (k % SIDES / (SIDES / 4), k % (SIDES / 4));
            let part = 2.0 * f64::from(step) * along / (TAU / 4.0) - 1.0;
            let corner = |x: f64, y: f64| DVec3::new(x, y, 0.0) * half;
            match side {
                0 => corner(1.0, part),
                1 => corner(-part, 1.0),
                2 => corner(-1.0, -part),
                _ => corner(part, -1.0),
            }
        };
        let up = DVec3::Z * 0.5 * self.thickness;
        for i in 0..columns {
            for j in 0..rows {
                let middle = DVec3::new(f64::from(i), f64::from(j), 0.0) * self.spacing;
                for k in 0..SIDES {
                    let turn = SIDES - SIDES / 8;
                    let [a, b] = [k, k + 1].map(|k| middle + border(k));
                    let [c, d] = [k, k + 1].map(|k| middle + self.radius * at(k + turn));
                    quad([a + up, b + up, d + up, c + up]);
                    quad([b - up, a - up, c - up, d - up]);
                    quad([d - up, c - up, c + up, d + up]);
                    let outside = [i + 1 == columns, j + 1 == rows, i == 0, j == 0];
                    if outside[(k / (SIDES / 4)) as usize] {
                        quad([a - up, b - up, b + up, a + up]);
                    }
                }
            }
        }
        mesh
    }

    /// Modes of steel up to a frequency \[Hz\], by default.
    fn modes(&self, limit: f64) -> Vec<ModalMode> {
        let constants = ElasticConstants::of(&STEEL.material()).expect("an elastic material");
        let geometry = BakeGeometry::of_mesh(&self.mesh());
        let options = ModalAnalysisOptions::to(limit);
        modal_analysis(&geometry, &constants, &options, &mut |_| ControlFlow::Continue(()))
            .expect("modes")
            .modes
    }
}

/// Three holes of 35 mm in 210 × 70 × 65 mm, in cells that are longer than the holes at first.
#[test]
fn a_brick_with_three_holes_is_as_far_off_as_stated() {
    let brick = Perforated { holes: [3, 1], spacing: 0.07, radius: 0.0175, thickness: 0.065 };
    let found = brick.modes(14e3);
    // 68 574 unknowns, still falling by 0.2 %.
    let references = [5119.8, 5464.5, 5629.1, 8944.2, 9915.0, 10_451.7, 10_666.5, 12_929.8];
    assert_eq!(found.len(), references.len());
    for (mode, reference) in found.iter().zip(references) {
        let (off, said) = (mode.frequency / reference - 1.0, mode.mesh_error);
        println!("{:.2} Hz of {reference}: {off:+.1e}, stated {said:.1e}", mode.frequency);
        // Seen: up to 2.0e-3, stated 7.8e-3; 1.1e-2, stated 2.5e-3, where convergence is of fourth order.
        assert!(off < said && off < 0.01, "{} of {reference}, stated {said:.1e}", mode.frequency);
    }
}

#[test]
fn a_perforated_plate_rings_as_in_fitted_hexahedra() {
    let plate = Perforated { holes: [5; 2], spacing: 0.02, radius: 0.005, thickness: 0.002 };
    let found = plate.modes(1200.0);
    // Converged to 0.4 % from above; holes of another number of sides.
    let reference = [621.8, 885.7, 1015.2];
    assert_eq!(found.len(), reference.len());
    for (mode, reference) in found.iter().zip(reference) {
        let error = mode.frequency / reference - 1.0;
        println!("{:.2} Hz of {reference}: {error:+.1e}, stated {:.1e}", mode.frequency, mode.mesh_error);
        // Seen: 7.3e-4.
        assert!(error.abs() < 0.01, "{} of {reference}", mode.frequency);
    }
}
