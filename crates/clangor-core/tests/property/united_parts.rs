//! Parts of a mesh that touch or cross become one solid: its volume is that of the union, whatever the parts
//! share, and the surface is closed.

use crate::messy_mesh::{MessyOptions, messy_shape};
use clangor_core::geometry::mend::{Fault, Mended, mend};
use clangor_core::geometry::solid::MeshError;
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::glam::{DQuat, DVec3};
use clangor_core::math::random::SplitMix;
use clangor_core::shape::Shape;
use std::f64::consts::PI;

/// A box of two triangles a side.
fn cuboid(low: DVec3, high: DVec3) -> TriMesh {
    let corner = |k: usize| {
        let side = |axis: usize| if k >> axis & 1 == 0 { low[axis] } else { high[axis] };
        DVec3::new(side(0), side(1), side(2))
    };
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = faces.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    TriMesh { vertices: (0..8).map(corner).collect(), triangles }
}

fn joined(parts: &[TriMesh]) -> TriMesh {
    let mut all = TriMesh::default();
    for part in parts {
        let start = all.vertices.len() as u32;
        all.vertices.extend(&part.vertices);
        all.triangles.extend(part.triangles.iter().map(|t| t.map(|v| v + start)));
    }
    all
}

fn moved(mesh: &TriMesh, turn: DQuat, by: DVec3) -> TriMesh {
    TriMesh { vertices: mesh.vertices.iter().map(|v| turn * *v + by).collect(), ..mesh.clone() }
}

/// The same with vertices of its own for each triangle, in single precision, as STL files have it.
fn as_stl(mesh: &TriMesh) -> TriMesh {
    let corners = (0..mesh.triangles.len()).flat_map(|t| mesh.corners(t));
    let vertices = corners.map(|v| v.as_vec3().as_dvec3()).collect();
    let triangles = (0..mesh.triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    TriMesh { vertices, triangles }
}

/// The same triangles in another order.
fn shuffled(mut mesh: TriMesh, random: &mut SplitMix) -> TriMesh {
    for k in (1..mesh.triangles.len()).rev() {
        mesh.triangles.swap(k, random.uniform(0.0, k as f64 + 1.0) as usize);
    }
    mesh
}

/// Number of parts that were united.
fn united(mended: &Mended) -> Option<usize> {
    mended.mends.iter().find(|mend| mend.fault == Fault::United).map(|mend| mend.count)
}

/// Relative error of a volume \[m³\].
fn volume_error(mended: &Mended, volume: f64) -> f64 {
    (mended.report.mass.volume / volume - 1.0).abs()
}

/// Boxes with corners on a grid, each of which has a face or a part in common with those before.
fn boxes_on_a_grid(random: &mut SplitMix) -> Vec<[[i32; 3]; 2]> {
    let mut integer = |low: i32, high: i32| random.uniform(f64::from(low), f64::from(high)).floor() as i32;
    let count = integer(2, 9) as usize;
    let mut boxes: Vec<[[i32; 3]; 2]> = Vec::new();
    while boxes.len() < count {
        let low = [0; 3].map(|_| integer(0, 7));
        let high = low.map(|low| low + integer(1, 5));
        let meets = |[l, h]: &[[i32; 3]; 2]| {
            let overlaps = (0..3).map(|k| high[k].min(h[k]) - low[k].max(l[k]));
            overlaps.clone().all(|o| o >= 0) && overlaps.filter(|o| *o == 0).count() < 2
        };
        if boxes.is_empty() || boxes.iter().any(meets) {
            boxes.push([low, high]);
        }
    }
    boxes
}

/// Cells of the grid in some box.
fn cells(boxes: &[[[i32; 3]; 2]]) -> usize {
    let holds = |x: [i32; 3]| boxes.iter().any(|[l, h]| (0..3).all(|k| l[k] <= x[k] && x[k] < h[k]));
    (0..12_i32.pow(3)).filter(|k| holds([k % 12, k / 12 % 12, k / 144])).count()
}

#[test]
fn property_boxes_have_the_volume_of_their_cells() {
    // Seen: 1020 boxes united, one set of triangles in random order refused, volumes off by up to 1.3e-5.
    let (edge, mut refused, mut worst) = (0.02, 0, 0.0_f64);
    let mut together = 0;
    for seed in 0..200 {
        let mut random = SplitMix::new(seed);
        let boxes = boxes_on_a_grid(&mut random);
        let at = |x: [i32; 3]| edge * DVec3::from_array(x.map(f64::from));
        let parts: Vec<TriMesh> = boxes.iter().map(|[low, high]| cuboid(at(*low), at(*high))).collect();
        let mesh = match seed % 4 {
            0 | 2 => joined(&parts),
            1 => as_stl(&joined(&parts)),
            // Where a part ends is not known from the order of its triangles.
            _ => as_stl(&shuffled(joined(&parts), &mut random)),
        };
        let volume = cells(&boxes) as f64 * edge.powi(3);
        match mend(&mesh) {
            Ok(mended) => {
                together += united(&mended).unwrap_or(0);
                let error = volume_error(&mended, volume);
                assert!(error < 1e-4, "seed {seed}: {error:e}");
                worst = worst.max(error);
            }
            Err(error) => {
                println!("seed {seed} of {} boxes: {error}", boxes.len());
                refused += 1;
            }
        }
    }
    println!("{together} boxes united, {refused} refused, volumes off by {worst:.1e}");
    assert!(refused <= 2 && together > 600, "{refused} {together}");
}

/// Two balls, one of which is a scan of other triangles.
#[test]
fn analytic_two_balls_share_a_lens() {
    let (radius, distance) = (0.05, 0.06);
    let ball = Shape::parse("sphere:0.05@0.0015").unwrap().mesh();
    let options = MessyOptions { seed: 3, triangles: 24_000, noise: 0.0, scale: [0.7, 1.4] };
    let messy = messy_shape("sphere:0.05", options).unwrap();
    let scan = moved(&messy.mesh, DQuat::IDENTITY, -messy.offset);
    let scan = TriMesh { vertices: scan.vertices.iter().map(|v| *v / messy.scale).collect(), ..scan };
    let at = |mesh: &TriMesh, x: f64| moved(mesh, DQuat::IDENTITY, DVec3::X * x);
    let whole = |mesh: &TriMesh| mend(mesh).unwrap().report.mass.volume;
    let height = radius - 0.5 * distance;
    let lens = 2.0 * PI * height * height * (radius - height / 3.0);
    let mended = mend(&joined(&[at(&ball, 0.0), at(&scan, distance)])).unwrap();
    assert_eq!(united(&mended), Some(2));
    // Facets lie within the balls. Seen: -1.9e-3 of the lens (-7e-3 with edges twice as long).
    let found = whole(&ball) + whole(&scan) - mended.report.mass.volume;
    println!("lens {:.3e} of {lens:.3e}: {:.1e}", found, found / lens - 1.0);
    assert!((found / lens - 1.0).abs() < 4e-3, "{}", found / lens - 1.0);
}

/// Six plates that form a hollow box, a hollow ball with a stick through its wall, a ring of four bars.
#[test]
fn property_cavities_and_holes_remain() {
    let (outer, wall) = (0.1, 0.01);
    let plate = |axis: usize, side: f64| {
        let (mut low, mut high) = (DVec3::ZERO, DVec3::splat(outer));
        let at = side * (outer - wall);
        (low[axis], high[axis]) = (at, at + wall);
        cuboid(low, high)
    };
    let plates: Vec<TriMesh> = (0..3).flat_map(|axis| [plate(axis, 0.0), plate(axis, 1.0)]).collect();
    let turn = DQuat::from_euler(clangor_core::glam::EulerRot::XYZ, 0.4, -0.3, 0.2);
    let hollow = mend(&moved(&joined(&plates), turn, DVec3::new(3.0, 0.0, -1.0))).unwrap();
    let inner: f64 = outer - 2.0 * wall;
    let volume = outer.powi(3) - inner.powi(3);
    assert_eq!((united(&hollow), hollow.report.components), (Some(6), 2));
    // Seen: 3.9e-5.
    assert!(volume_error(&hollow, volume) < 1e-4);

    let ball = Shape::parse("sphere:0.05@0.005").unwrap().mesh();
    let inside = TriMesh {
        vertices: ball.vertices.iter().map(|v| 0.9 * *v).collect(),
        triangles: ball.triangles.iter().map(|[a, b, c]| [*a, *c, *b]).collect(),
    };
    let stick = cuboid(DVec3::new(0.047, -0.003, -0.003), DVec3::new(0.2, 0.003, 0.003));
    let stuck = mend(&joined(&[ball, inside, stick])).unwrap();
    assert_eq!((united(&stuck), stuck.report.components), (Some(2), 2));

    let bar = |low: [f64; 3], high: [f64; 3]| cuboid(DVec3::from_array(low), DVec3::from_array(high));
    let frame = [
        bar([0.0, 0.0, 0.0], [0.2, 0.02, 0.02]),
        bar([0.0, 0.18, 0.0], [0.2, 0.2, 0.02]),
        bar([0.0, 0.02, 0.0], [0.02, 0.18, 0.02]),
        bar([0.18, 0.02, 0.0], [0.2, 0.18, 0.02]),
    ];
    let frame = mend(&joined(&frame)).unwrap();
    let volume = 0.02 * (0.2 * 0.2 - 0.16 * 0.16);
    assert_eq!(united(&frame), Some(4));
    // Seen: 2.0e-5.
    assert!(volume_error(&frame, volume) < 1e-4);
}

/// A ball on a plate touches it in a point; a leg ends below its seat; a part lies within.
#[test]
fn parts_that_meet_in_a_point_or_not_at_all_are_apart() {
    let plate = cuboid(DVec3::ZERO, DVec3::new(0.2, 0.2, 0.01));
    let ball = Shape::parse("sphere:0.03@0.003").unwrap().mesh();
    let top = ball.vertices.iter().map(|v| v.z).fold(0.0, f64::max);
    let on_it = moved(&ball, DQuat::IDENTITY, DVec3::new(0.1, 0.1, 0.01 + top));
    let leg = cuboid(DVec3::new(0.0, 0.0, -0.1), DVec3::new(0.02, 0.02, -0.001));
    for (case, parts) in [("ball", vec![plate.clone(), on_it]), ("gap", vec![plate.clone(), leg.clone()])] {
        let error = mend(&joined(&parts)).unwrap_err();
        assert!(
            matches!(error, MeshError::Shells { shells: 2, .. } | MeshError::CrossingShells { .. }),
            "{case}: {error}"
        );
    }
    // Gaps of rounding, in the diagonal of 0.3 m.
    for (gap, closes) in [(0.9e-6, true), (0.9e-5, true), (5e-5, false)] {
        let leg = cuboid(DVec3::new(0.0, 0.0, -0.1), DVec3::new(0.02, 0.02, -0.3 * gap));
        assert_eq!(mend(&joined(&[plate.clone(), leg])).is_ok(), closes, "{gap:e}");
    }
    // Two that touch, and one apart from both.
    let block = cuboid(DVec3::new(0.05, 0.05, 0.01), DVec3::new(0.1, 0.1, 0.05));
    let error = mend(&joined(&[plate.clone(), block.clone(), leg])).unwrap_err();
    assert!(matches!(error, MeshError::Shells { shells: 2, .. }), "{error}");
    // Within one that touches another.
    let pea = cuboid(DVec3::new(0.06, 0.06, 0.02), DVec3::new(0.07, 0.07, 0.03));
    let error = mend(&joined(&[plate.clone(), block.clone(), pea])).unwrap_err();
    assert!(matches!(error, MeshError::Nested { .. }), "{error}");
    // Within both together.
    let pin = cuboid(DVec3::new(0.06, 0.06, 0.002), DVec3::new(0.07, 0.07, 0.03));
    let whole = mend(&joined(&[plate, block, pin])).unwrap();
    assert_eq!(united(&whole), Some(3));
    let volume = 0.2 * 0.2 * 0.01 + 0.05 * 0.05 * 0.04;
    // Seen: 9.3e-6.
    assert!(volume_error(&whole, volume) < 1e-4);
}
