//! Pieces of random fractures are closed, manifold and positively oriented, and conserve volume and moments.
//!
//! All 10 000: `cargo test -p clangor-sim --release --test property fracture_pieces:: -- --ignored`.

use std::collections::BTreeMap;

use clangor_bake::mesh::tetrahedra::TetMesh;
use clangor_bake::mesh::tetrahedra::ball::ellipsoid;
use clangor_bake::mesh::tetrahedra::block::block;
use clangor_bake::mesh::tetrahedra::cylinder::{cylinder, torus};
use clangor_bake::mesh::tetrahedra::isosurface_stuffing::stuff;
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::glam::DVec3;
use clangor_core::math::random::SplitMix;
use clangor_sim::fracture::pattern::{PatternSettings, draw_pattern};
use clangor_sim::fracture::piece::Piece;
use clangor_sim::fracture::split::{Split, split_by_regions};

/// Bodies of about 200 tetrahedra.
fn bodies() -> Vec<Piece> {
    let ball = ellipsoid(DVec3::new(0.05, 0.04, 0.03), 2).unwrap();
    let surface = Piece::whole(&ellipsoid(DVec3::splat(0.05), 3).unwrap()).unwrap().surface();
    let meshes: [TetMesh; 6] = [
        block(DVec3::new(0.1, 0.08, 0.06), [4, 3, 3]).unwrap(),
        block(DVec3::new(0.1, 0.1, 0.004), [6, 6, 1]).unwrap(),
        ball,
        stuff(&surface, 0.03).unwrap().0,
        cylinder(0.05, 0.006, 2, 1).unwrap(),
        torus(0.05, 0.015, 1, 12).unwrap(),
    ];
    meshes.iter().map(|m| Piece::whole(m).unwrap()).collect()
}

/// Smooth random energy densities at the corners, as after impacts on some points of a body.
fn random_energy(piece: &Piece, random: &mut SplitMix) -> Vec<f64> {
    let nodes = &piece.mesh.nodes[..piece.mesh.corners];
    let size = piece.surface().diagonal();
    let impacts: Vec<DVec3> =
        (0..3).map(|_| nodes[random.uniform(0.0, nodes.len() as f64) as usize]).collect();
    let density = |p: &DVec3| impacts.iter().map(|b| 1.0 / (0.01 + (p.distance(*b) / size).powi(2))).sum();
    nodes.iter().map(density).collect()
}

/// Regions from seeds, or random regions of single corners.
fn random_regions(piece: &Piece, random: &mut SplitMix) -> Option<Vec<u32>> {
    let regions = 2 + random.uniform(0.0, 11.0) as usize;
    if random.uniform(0.0, 1.0) < 0.25 {
        let draw = |_| random.uniform(0.0, regions as f64) as u32;
        return Some((0..piece.mesh.corners).map(draw).collect());
    }
    let settings = PatternSettings {
        fracture_energy: 1.0,
        efficiency: 1.0,
        exponent: random.uniform(0.0, 0.6),
        smallest_piece: 0.0,
        most_pieces: regions,
        seed: random.uniform(0.0, 1e15) as u64,
    };
    let energy = random_energy(piece, random);
    draw_pattern(&piece.mesh, &energy, 1e9, &settings).unwrap().map(|p| p.region)
}

/// Every edge has two triangles, in opposite directions; around every vertex they form one ring; and they are
/// connected, so that no piece contains another. Implemented without the library's own topology.
fn assert_solid(surface: &TriMesh) {
    let mut edges: BTreeMap<(u32, u32), i32> = BTreeMap::new();
    let mut links: BTreeMap<u32, BTreeMap<u32, u32>> = BTreeMap::new();
    for [a, b, c] in &surface.triangles {
        for (from, to, third) in [(*a, *b, *c), (*b, *c, *a), (*c, *a, *b)] {
            assert!(edges.insert((from, to), 1).is_none(), "two triangles run along one edge alike");
            links.entry(from).or_default().insert(to, third);
        }
    }
    assert!(edges.keys().all(|(a, b)| edges.contains_key(&(*b, *a))), "open edge");
    for link in links.values() {
        let start = *link.keys().next().unwrap();
        let (mut at, mut steps) = (start, 0);
        while steps == 0 || at != start {
            at = link[&at];
            steps += 1;
        }
        assert_eq!(steps, link.len(), "two fans at one vertex");
    }
    assert_eq!(links.len(), surface.vertices.len());
    let mut seen = vec![false; surface.vertices.len()];
    let mut next = vec![0];
    while let Some(vertex) = next.pop() {
        if !std::mem::replace(&mut seen[vertex as usize], true) {
            next.extend(links[&vertex].keys());
        }
    }
    assert!(seen.iter().all(|s| *s), "a hollow");
}

/// Invariants of a fracture: volume, first and second moments, and with them mass, centre, momentum and
/// angular momentum of every rigid motion.
fn assert_balance(parent: &Piece, split: &Split) {
    let whole = parent.mass_properties().unwrap();
    let parts: Vec<MassProperties> = split.pieces.iter().map(|p| p.mass_properties().unwrap()).collect();
    let volume: f64 = parts.iter().map(|p| p.volume).sum();
    // Seen: below 1e-12.
    assert!((volume / whole.volume - 1.0).abs() < 1e-11, "volume {:e}", volume / whole.volume - 1.0);
    let (v, w) = (DVec3::new(1.0, -2.0, 0.5), DVec3::new(30.0, 10.0, -20.0));
    let at = |x: DVec3| v + w.cross(x - whole.centre_of_mass);
    let momentum: DVec3 = parts.iter().map(|p| p.volume * at(p.centre_of_mass)).sum();
    assert!((momentum - whole.volume * v).length() < 1e-11 * whole.volume * v.length());
    let spin: DVec3 = parts
        .iter()
        .map(|p| {
            let arm = p.centre_of_mass - whole.centre_of_mass;
            p.inertia * w + p.volume * arm.cross(at(p.centre_of_mass))
        })
        .sum();
    let before = whole.inertia * w;
    assert!((spin - before).length() < 1e-11 * before.length(), "{:e}", (spin - before).length());
    // The original surface is divided among the pieces; the crack counts twice.
    let [outside, inside] = areas(parent);
    let sums = split.pieces.iter().map(areas).fold([0.0; 2], |s, a| [s[0] + a[0], s[1] + a[1]]);
    let all = outside + inside;
    assert!((sums[0] - outside).abs() < 1e-9 * all, "outside {:e}", sums[0] / outside - 1.0);
    assert!((sums[1] - inside - 2.0 * split.crack_area()).abs() < 1e-9 * all);
}

/// Area of the original surface, and of the surface created by cracks.
fn areas(piece: &Piece) -> [f64; 2] {
    let surface = piece.surface();
    let mut sums = [0.0; 2];
    for (t, inside) in piece.inside.iter().enumerate() {
        sums[usize::from(*inside)] += surface.area_vector(t).length();
    }
    sums
}

/// Fractures bodies one after the other, and the largest piece of each again, up to a given number of
/// fractures.
fn fracture_many(count: usize, seed: u64) {
    let bodies = bodies();
    let mut random = SplitMix::new(seed);
    let mut done = 0;
    while done < count {
        let mut body = bodies[done % bodies.len()].clone();
        for _generation in 0..2 {
            let Some(regions) = random_regions(&body, &mut random) else { break };
            let Some(split) = split_by_regions(&body, &regions).unwrap() else { break };
            done += 1;
            for piece in &split.pieces {
                assert_solid(&piece.surface());
                let quality = piece.mesh.quality();
                assert!(quality.least_jacobian > 0.0);
            }
            assert_balance(&body, &split);
            let cracks: usize = split.pieces.iter().map(|p| p.inside.iter().filter(|i| **i).count()).sum();
            let old = body.inside.iter().any(|i| *i);
            assert!(old || cracks == 2 * split.crack_faces.len());
            let largest = split.pieces.iter().max_by_key(|p| p.mesh.elements.len()).unwrap();
            body = largest.clone();
        }
    }
}

/// 12 (3V)^(2/3) / Σ edge², 1 for the regular tetrahedron.
fn worst_shape(mesh: &TetMesh) -> f64 {
    let shape = |e| {
        let [a, b, c, d, ..] = mesh.positions(e);
        let volume = (b - a).cross(c - a).dot(d - a) / 6.0;
        let squares: f64 =
            [b - a, c - a, d - a, c - b, d - b, d - c].into_iter().map(DVec3::length_squared).sum();
        12.0 * (3.0 * volume).powf(2.0 / 3.0) / squares
    };
    (0..mesh.elements.len()).map(shape).fold(f64::INFINITY, f64::min)
}

/// Everything breaks in three, five times over. Elements do not collapse, and their number stays limited:
/// each generation has three times the pieces, and at first at most twice the elements, later fewer.
#[test]
fn elements_stay_sound_over_generations() {
    let mut random = SplitMix::new(8);
    for body in bodies() {
        let volume = body.mass_properties().unwrap().volume;
        let mut before = body.mesh.elements.len();
        let mut pieces = vec![body];
        for (generation, least) in [0.2, 0.1, 0.06, 0.03, 0.02].into_iter().enumerate() {
            let mut next = Vec::new();
            for body in &pieces {
                let settings = PatternSettings {
                    most_pieces: 3,
                    smallest_piece: 1e-4 * volume,
                    ..PatternSettings::new(1.0, volume, generation as u64)
                };
                let energy = random_energy(body, &mut random);
                let pattern = draw_pattern(&body.mesh, &energy, 1e9, &settings).unwrap();
                let split = pattern.and_then(|p| split_by_regions(body, &p.region).unwrap());
                next.extend(split.map_or_else(|| vec![body.clone()], |s| s.pieces));
            }
            let worst = next.iter().map(|p| worst_shape(&p.mesh)).fold(f64::INFINITY, f64::min);
            let elements: usize = next.iter().map(|p| p.mesh.elements.len()).sum();
            println!("{generation}: {} pieces, {elements} elements, worst {worst}", next.len());
            assert!(worst > least, "generation {generation}: {worst}");
            assert!(elements < 3 * before, "generation {generation}: {before} to {elements}");
            before = elements;
            pieces = next;
        }
    }
}

/// A seed in the middle of a cube makes no piece, because an enclosed piece could not get out.
#[test]
fn what_lies_within_a_piece_stays_its_own() {
    let body = Piece::whole(&block(DVec3::splat(0.1), [4, 4, 4]).unwrap()).unwrap();
    let nodes = &body.mesh.nodes[..body.mesh.corners];
    let around = |centre: DVec3, radius: f64| {
        nodes.iter().map(|p| u32::from(p.distance(centre) < radius)).collect::<Vec<u32>>()
    };
    // Corners are 25 mm apart, and the middle is one of them.
    let middle = 0.5 * (body.surface().bounds().0 + body.surface().bounds().1);
    assert_eq!(split_by_regions(&body, &around(middle, 0.01)).unwrap(), None);
    // Half of the cube, with an enclosed region in the other half: two pieces, not three.
    let mut regions = around(middle + DVec3::X * 0.025, 0.01);
    for (region, p) in regions.iter_mut().zip(nodes) {
        *region += 2 * u32::from(p.x < middle.x - 0.01);
    }
    assert_eq!(regions.iter().filter(|r| **r == 1).count(), 1);
    let split = split_by_regions(&body, &regions).unwrap().unwrap();
    assert_eq!(split.pieces.len(), 2);
    split.pieces.iter().for_each(|piece| assert_solid(&piece.surface()));
    assert_balance(&body, &split);
}

#[test]
fn three_hundred_fractures() {
    fracture_many(300, 1);
}

#[test]
#[ignore = "3 min: cargo test --release -p clangor-sim --test property fracture_pieces:: -- --ignored"]
fn ten_thousand_fractures() {
    fracture_many(10_000, 2);
}
