//! Meshes with small faults become the solids that they were meant to be; all others are refused at their
//! place, and none panics.

use crate::messy_mesh::{MessyOptions, messy_shape};
use clangor_core::geometry::mend::{Fault, Mended, SAME, mend};
use clangor_core::geometry::solid::{MeshError, check_solid};
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::glam::DVec3;
use clangor_core::math::random::SplitMix;
use clangor_core::shape::Shape;

/// The same surface with three vertices of its own for every triangle, as STL files have it.
fn unwelded(mesh: &TriMesh) -> TriMesh {
    let vertices = (0..mesh.triangles.len()).flat_map(|t| mesh.corners(t)).collect();
    let triangles = (0..mesh.triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    TriMesh { vertices, triangles }
}

fn shape(text: &str) -> TriMesh {
    Shape::parse(text).unwrap().mesh()
}

fn messy(text: &str, seed: u64) -> TriMesh {
    let options = MessyOptions { seed, triangles: 3000, noise: 0.01, scale: [0.7, 1.4] };
    messy_shape(text, options).unwrap().mesh
}

fn joined(a: &TriMesh, b: &TriMesh) -> TriMesh {
    let start = a.vertices.len() as u32;
    let mut both = a.clone();
    both.vertices.extend(&b.vertices);
    both.triangles.extend(b.triangles.iter().map(|t| t.map(|i| i + start)));
    both
}

fn shifted(mesh: &TriMesh, by: DVec3) -> TriMesh {
    mesh.relative_to(-by)
}

fn scaled(mesh: &TriMesh, factor: f64) -> TriMesh {
    let vertices = mesh.vertices.iter().map(|v| *v * factor).collect();
    TriMesh { vertices, triangles: mesh.triangles.clone() }
}

fn inverted(mesh: &TriMesh) -> TriMesh {
    let triangles = mesh.triangles.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
    TriMesh { vertices: mesh.vertices.clone(), triangles }
}

fn some_index(random: &mut SplitMix, count: usize) -> usize {
    (random.uniform(0.0, count as f64) as usize).min(count - 1)
}

fn has(mended: &Mended, wanted: fn(&Fault) -> bool) -> bool {
    mended.mends.iter().any(|m| wanted(&m.fault) && m.count > 0 && m.position.is_finite())
}

#[test]
fn property_good_meshes_keep_every_bit() {
    for text in ["sphere", "die", "key", "mug", "moneybox", "box:0.1x0.001x0.2"] {
        let mesh = shape(text);
        let mended = mend(&mesh).unwrap();
        assert_eq!(mended.mesh, mesh.weld(SAME * mesh.diagonal()), "{text}");
        assert_eq!(mended.mends, [], "{text}");
    }
    // A cavity is part of a good solid.
    let outer = shape("box:0.1x0.1x0.1@0.05");
    let hollow = joined(&outer, &inverted(&scaled(&outer, 0.5)));
    let mended = mend(&hollow).unwrap();
    assert_eq!((mended.mends.len(), mended.report.components), (0, 2));
    assert_eq!(mended.mesh, hollow.weld(SAME * hollow.diagonal()));
}

#[test]
fn property_messy_shapes_are_solids() {
    for (seed, text) in
        [(1, "mug"), (2, "key"), (3, "die"), (4, "wineglass"), (5, "pane"), (6, "rock:3x0.03")]
    {
        let options = MessyOptions { seed, triangles: 7000, noise: 0.01, scale: [0.7, 1.4] };
        let made = messy_shape(text, options).unwrap();
        assert!(made.mesh.triangles.len().abs_diff(7000) <= 1, "{text}");
        assert_eq!(made, messy_shape(text, options).unwrap());
        let clean = check_solid(&Shape::parse(text).unwrap().mesh()).unwrap();
        let found = mend(&unwelded(&made.mesh)).unwrap();
        let volume = found.report.mass.volume / (clean.mass.volume * made.scale.powi(3)) - 1.0;
        let area = found.report.area / (clean.area * made.scale.powi(2)) - 1.0;
        println!("{text}: volume {volume:.1e}, area {area:.1e}, mends {:?}", found.mends);
        assert!(volume.abs() < VOLUME && area.abs() < AREA, "{text}: {volume} {area}");
        assert_eq!(found.mends, [], "{text}");
    }
}

/// Largest relative differences between a messy mesh and the clean shape. Seen: 3.0e-3 and 2.1e-3, both of
/// the wineglass, whose clean mesh has coarser facets.
const VOLUME: f64 = 6e-3;
const AREA: f64 = 5e-3;

/// Flips some of the triangles.
fn with_flips(mut mesh: TriMesh, random: &mut SplitMix) -> TriMesh {
    for t in &mut mesh.triangles {
        if random.uniform(0.0, 1.0) < 0.2 {
            t.swap(0, 1);
        }
    }
    mesh
}

/// Takes out single triangles, of the small ones.
fn with_holes(mut mesh: TriMesh, random: &mut SplitMix) -> TriMesh {
    let border = |mesh: &TriMesh, t: usize| {
        let [a, b, c] = mesh.corners(t);
        a.distance(b) + b.distance(c) + c.distance(a)
    };
    let mut borders: Vec<f64> = (0..mesh.triangles.len()).map(|t| border(&mesh, t)).collect();
    borders.sort_by(f64::total_cmp);
    let most = borders[borders.len() / 5];
    let mut holes = 0;
    while holes < 5 {
        let t = some_index(random, mesh.triangles.len());
        if border(&mesh, t) < most {
            mesh.triangles.remove(t);
            holes += 1;
        }
    }
    mesh
}

/// Writes some triangles twice, one of them the other way round.
fn with_doubles(mut mesh: TriMesh, random: &mut SplitMix) -> TriMesh {
    for k in 0..6 {
        let mut t = mesh.triangles[some_index(random, mesh.triangles.len())];
        if k == 0 {
            t.swap(1, 2);
        }
        mesh.triangles.push(t);
    }
    mesh
}

/// Gives every triangle corners of its own, off by up to 2e-5 of the diagonal.
fn with_cracks(mesh: TriMesh, random: &mut SplitMix) -> TriMesh {
    let most = 2e-5 * mesh.diagonal();
    let mut soup = unwelded(&mesh);
    soup.vertices.iter_mut().for_each(|v| *v += random.direction() * random.uniform(0.0, most));
    soup
}

/// Divides one triangle at the middle of a side, and with `cap` closes the gap by a triangle without area.
fn with_junction(mut mesh: TriMesh, random: &mut SplitMix, cap: bool) -> TriMesh {
    let t = some_index(random, mesh.triangles.len());
    let [a, b, c] = mesh.triangles[t];
    let m = mesh.vertices.len() as u32;
    mesh.vertices.push(0.5 * (mesh.vertices[a as usize] + mesh.vertices[b as usize]));
    mesh.triangles[t] = [a, m, c];
    mesh.triangles.push([m, b, c]);
    if cap {
        mesh.triangles.push([a, b, m]);
    }
    mesh
}

/// A triangle that stands on an edge.
fn with_fin(mut mesh: TriMesh, random: &mut SplitMix) -> TriMesh {
    let t = some_index(random, mesh.triangles.len());
    let [a, b, _] = mesh.triangles[t];
    let [p, q, r] = mesh.corners(t);
    let m = mesh.vertices.len() as u32;
    mesh.vertices.push(p + (q - p).cross(r - p).normalize() * p.distance(q));
    mesh.triangles.push([a, b, m]);
    mesh
}

/// Grains beside the body.
fn with_dust(mesh: TriMesh, random: &mut SplitMix) -> TriMesh {
    let size = mesh.diagonal();
    let grain = scaled(&shape("sphere:0.5@0.4"), 1e-3 * size);
    let (_, high) = mesh.bounds();
    (0..3).fold(mesh, |m, _| joined(&m, &shifted(&grain, high + size * random.uniform(0.1, 0.2))))
}

/// Pulls single vertices inwards through the triangles beside them.
fn with_folds(mut mesh: TriMesh, random: &mut SplitMix) -> TriMesh {
    for _ in 0..3 {
        let t = some_index(random, mesh.triangles.len());
        let [p, q, r] = mesh.corners(t);
        let beyond = (q + r) * 0.5 + ((q + r) * 0.5 - p) * 0.3;
        let i = mesh.triangles[t][0] as usize;
        mesh.vertices[i] = beyond + 0.02 * (q - p).cross(r - p).normalize() * p.distance(q);
    }
    mesh
}

type Messing = (fn(TriMesh, &mut SplitMix) -> TriMesh, fn(&Fault) -> bool);

const MESSINGS: [Messing; 8] = [
    (with_flips, |f| matches!(f, Fault::Flipped)),
    (|mesh, _| inverted(&mesh), |f| matches!(f, Fault::InsideOut)),
    (with_holes, |f| matches!(f, Fault::Hole { .. })),
    (with_doubles, |f| matches!(f, Fault::Double)),
    (with_cracks, |f| matches!(f, Fault::Crack { .. })),
    (|mesh, random| with_junction(mesh, random, false), |f| matches!(f, Fault::Crack { .. })),
    (with_fin, |f| matches!(f, Fault::Fin)),
    (with_dust, |f| matches!(f, Fault::Dust { .. })),
];

fn assert_close(mended: &Mended, clean: &TriMesh, case: &str) {
    let clean = check_solid(clean).unwrap();
    let volume = mended.report.mass.volume / clean.mass.volume - 1.0;
    let area = mended.report.area / clean.area - 1.0;
    println!("{case}: volume {volume:.1e}, area {area:.1e}");
    assert!(volume.abs() < 2e-3 && area.abs() < 5e-3, "{case}: volume {volume:.1e}, area {area:.1e}");
}

#[test]
fn property_each_fault_is_mended_and_said() {
    for (k, (mess, wanted)) in MESSINGS.into_iter().enumerate() {
        for (seed, text) in [(1, "mug"), (2, "die"), (3, "key")] {
            let clean = messy(text, seed);
            let bad = mess(clean.clone(), &mut SplitMix::new(seed));
            let case = format!("messing {k} of {text}");
            let mended = mend(&bad).unwrap_or_else(|e| panic!("{case}: {e}"));
            let said: Vec<String> = mended.mends.iter().map(ToString::to_string).collect();
            println!("{case}: {said:?}");
            assert!(has(&mended, wanted), "{case}: {said:?}");
            assert_close(&mended, &clean, &case);
            // What was mended is good.
            assert_eq!(mend(&mended.mesh).unwrap().mends, [], "{case}");
        }
    }
}

#[test]
fn property_triangles_without_area_are_turned_away() {
    for seed in 0..4 {
        let clean = messy("die", seed);
        let bad = with_junction(clean.clone(), &mut SplitMix::new(seed), true);
        let mended = mend(&bad).unwrap();
        assert!(has(&mended, |f| matches!(f, Fault::NoArea)), "{:?}", mended.mends);
        assert_close(&mended, &clean, "cap");
    }
}

#[test]
fn property_faults_together_are_mended_and_said() {
    for seed in 10..22 {
        let mut random = SplitMix::new(seed);
        let clean = messy(["mug", "rock:3x0.03", "torus:0.03x0.006"][seed as usize % 3], seed);
        let chosen: Vec<usize> = (0..MESSINGS.len()).filter(|_| random.uniform(0.0, 1.0) < 0.4).collect();
        // Cracks come last, since they leave no edges for the others; turned triangles hide turned bodies.
        let order = chosen.iter().filter(|k| **k != 4).chain(chosen.iter().filter(|k| **k == 4));
        let bad = order.fold(clean.clone(), |mesh, k| (MESSINGS[*k].0)(mesh, &mut random));
        let case = format!("seed {seed}, messings {chosen:?}");
        let mended = mend(&bad).unwrap_or_else(|e| panic!("{case}: {e}"));
        for k in &chosen {
            assert!(has(&mended, MESSINGS[*k].1), "{case}: {k} is not said, {:?}", mended.mends);
        }
        assert_close(&mended, &clean, &case);
    }
}

#[test]
fn property_small_folds_are_smoothed_and_said() {
    let mut folded = 0;
    for seed in 0..6 {
        let options = MessyOptions { seed, triangles: 20_000, noise: 0.01, scale: [1.0, 1.0] };
        let clean = messy_shape("torus:0.03x0.006", options).unwrap().mesh;
        let bad = with_folds(clean.clone(), &mut SplitMix::new(seed));
        if check_solid(&bad).is_ok() {
            continue;
        }
        folded += 1;
        let mended = mend(&bad).unwrap_or_else(|e| panic!("seed {seed}: {e}"));
        assert!(has(&mended, |f| matches!(f, Fault::Fold { .. })), "{:?}", mended.mends);
        assert_close(&mended, &clean, "fold");
    }
    assert!(folded >= 3, "{folded}");
}

#[test]
fn what_cannot_be_meant_is_refused_at_its_place() {
    let cube = shape("box:0.1x0.1x0.1@0.05");
    let refused = |mesh: &TriMesh| mend(mesh).map(|m| m.mends).unwrap_err();
    let near = |e: &MeshError, x: DVec3, within: f64| match e {
        MeshError::Hole { position, .. }
        | MeshError::Nested { position }
        | MeshError::SelfIntersection { position, .. }
        | MeshError::Sheet { position }
        | MeshError::NonManifold { position, .. }
        | MeshError::OneSided { position } => assert!(position.distance(x) < within, "{e}"),
        other => panic!("{other}"),
    };
    // A box without its top, a face alone, a face from both sides.
    let without = |keep: &dyn Fn(DVec3) -> bool| {
        let triangles = (0..cube.triangles.len()).filter(|t| keep(cube.centroid(*t)));
        TriMesh { vertices: cube.vertices.clone(), triangles: triangles.map(|t| cube.triangles[t]).collect() }
    };
    near(&refused(&without(&|x| x.y < 0.049)), DVec3::Y * 0.05, 0.08);
    let face = without(&|x| x.y > 0.049);
    near(&refused(&face), DVec3::Y * 0.05, 0.08);
    near(&refused(&joined(&face, &inverted(&face))), DVec3::Y * 0.05, 0.08);
    // Two solids, apart, one in the other, sharing an edge.
    match refused(&joined(&cube, &shifted(&scaled(&cube, 0.5), DVec3::X * 0.2))) {
        MeshError::Shells { shells: 2, centres, share } => {
            assert!(centres[0].length() < 1e-12 && centres[1].distance(DVec3::X * 0.2) < 1e-12);
            assert!((share - 0.125).abs() < 1e-12);
        }
        other => panic!("{other}"),
    }
    near(&refused(&joined(&cube, &scaled(&cube, 0.5))), DVec3::ZERO, 0.05);
    near(
        &refused(&joined(&cube, &shifted(&cube, DVec3::new(0.1, 0.1, 0.0)))),
        DVec3::new(0.05, 0.05, 0.0),
        0.06,
    );
    // A vertex pulled through the far side.
    let mut pulled = shape("sphere:0.01");
    pulled.vertices[100] *= -1.2;
    near(&refused(&pulled), DVec3::ZERO, 0.013);
    // A Möbius strip.
    let mut strip = TriMesh::default();
    for k in 0..24_u32 {
        let turn = f64::from(k) * std::f64::consts::TAU / 24.0;
        let (across, up) = (0.1 * (turn / 2.0).cos(), 0.1 * (turn / 2.0).sin());
        for side in [-1.0, 1.0] {
            let radius = 1.0 + side * across;
            strip.vertices.push(DVec3::new(radius * turn.cos(), side * up, radius * turn.sin()));
        }
        let (a, b) = (2 * k, 2 * k + 1);
        let (c, d) = if k == 23 { (1, 0) } else { (2 * k + 2, 2 * k + 3) };
        strip.triangles.extend([[a, b, c], [b, d, c]]);
    }
    near(&refused(&strip), DVec3::ZERO, 1.2);
}

#[test]
fn property_no_mesh_panics() {
    for seed in 0..200 {
        let mut random = SplitMix::new(seed);
        let count = 4 + some_index(&mut random, 12);
        let grid = |random: &mut SplitMix| random.uniform(-2.0, 3.0).floor();
        let vertices =
            (0..count).map(|_| DVec3::new(grid(&mut random), grid(&mut random), grid(&mut random)));
        let vertices: Vec<DVec3> = vertices.collect();
        let triangles = (0..40).map(|_| [0; 3].map(|_| some_index(&mut random, count) as u32)).collect();
        let _ = mend(&TriMesh { vertices, triangles }).map(|m| check_solid(&m.mesh).unwrap());
    }
    let cube = shape("box:0.1x0.1x0.1@0.05");
    for bad in [f64::NAN, f64::INFINITY, 1e300, -1e-310] {
        let mut mesh = cube.clone();
        mesh.vertices[3].y = bad;
        let _ = mend(&mesh);
    }
    assert_eq!(mend(&TriMesh::default()).unwrap_err(), MeshError::Empty);
}
