//! Every shape of the library is a solid at any edge length, and its convex parts stay close to it.

use clangor::geometry::solid::check_solid;
use clangor::shape::Shape;

const SHAPES: [&str; 24] = [
    "sphere:0.0075",
    "ellipsoid:0.02x0.01x0.015",
    "ellipsoid:0.02x0.002x0.002",
    "box:0.1x0.05x0.2",
    "die",
    "die:0.0124x0",
    "die:0.02x0.01",
    "cylinder:0.02x0.1",
    "coin",
    "torus:0.03x0.01",
    "ring",
    "rock:7x0.03",
    "rock:18446744073709551615x0.01",
    "prism:3x0.01x0.03",
    "prism:64x0.01x0.003",
    "shard:1x0.04",
    "shard:2x0.04",
    "bowl",
    "plate",
    "mug",
    "wineglass",
    "key",
    "tile",
    "pane",
];

#[test]
fn shapes_are_solids_at_any_edge_length() {
    for text in SHAPES {
        let shape = Shape::parse(text).unwrap();
        let fine = check_solid(&shape.mesh()).unwrap();
        for factor in [0.6, 1.0, 3.0, 8.0] {
            let longest = shape.mesh().bounds().1.max_element();
            let mesh = shape.clone().with_edge((factor * shape.edge()).min(longest)).unwrap().mesh();
            let report = check_solid(&mesh).unwrap_or_else(|e| panic!("{text} at {factor}: {e}"));
            assert_eq!(report.components, 1);
            let ratio = report.mass.volume / fine.mass.volume;
            println!("{text} x{factor}: {} triangles, volume ratio {ratio:.5}", mesh.triangles.len());
            assert!((0.6..1.01).contains(&ratio), "{text} at {factor}: volume ratio {ratio}");
        }
    }
}
