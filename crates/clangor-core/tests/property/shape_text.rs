//! Shapes read from text: what is accepted, what is rejected and how, and that text survives a round trip.

use clangor_core::shape::{Shape, ShapeError};

#[test]
fn bare_names_have_the_papers_sizes() {
    assert_eq!(Shape::parse("sphere").unwrap().sphere_radius(), Some(0.0075));
    assert_eq!(Shape::parse("coin").unwrap(), Shape::parse("coin:0.01213x0.00175").unwrap());
    for name in ["die", "ring", "bowl", "plate", "mug", "wineglass", "moneybox", "key", "tile", "pane"] {
        assert!(Shape::parse(name).is_ok(), "{name}");
    }
}

#[test]
fn text_survives_a_round_trip() {
    for text in [
        "sphere:0.0075@0.001",
        "ellipsoid:0.02x0.01x1.5e-2",
        "box:0.1x0.05x0.2@0.02",
        "die",
        "die:0.02x0",
        "cylinder:0.02x0.1",
        "coin@0.0005",
        "torus:0.03x0.01",
        "ring",
        "rock:18446744073709551615x0.03",
        "prism:6x0.01x0.03",
        "shard:3x0.04",
        "bowl",
        "plate",
        "mug@0.006",
        "wineglass",
        "moneybox",
        "key",
        "tile",
        "pane",
    ] {
        let shape = Shape::parse(text).unwrap();
        assert_eq!(Shape::parse(&shape.to_string()).unwrap(), shape, "{text}");
    }
}

#[test]
fn an_edge_of_the_mesh_is_about_as_long_as_asked() {
    for text in
        ["sphere:0.0075@0.001", "coin@0.0005", "bowl@0.004", "mug@0.004", "key@0.0008", "rock:1x0.03@0.003"]
    {
        let shape = Shape::parse(text).unwrap();
        let mesh = shape.mesh();
        let mean = (mesh.area() / mesh.triangles.len() as f64 * 4.0 / 3.0_f64.sqrt()).sqrt() / shape.edge();
        println!("{text}: {mean:.2}");
        // Seen: 0.6 to 1.05 (edge of the equilateral triangle of mean area).
        assert!((0.5..1.2).contains(&mean), "{text}: {mean}");
    }
}

#[test]
fn bad_text_is_refused_with_an_example() {
    let sizes = [
        "sphere:",
        "sphere:abc",
        "sphere:1x2",
        "box:1x2",
        "box:1x2x3x4",
        "ellipsoid",
        "cylinder:0.1",
        "bowl:0.1",
        "rock:1.5x0.1",
        "rock:-1x0.1",
        "rock",
        "prism:2.5x0.1x0.1",
        "sphere:0.1@",
        "sphere:0.1@x",
        "box: 1x2x3",
    ];
    for text in sizes {
        match Shape::parse(text) {
            Err(error @ ShapeError::Sizes { example, .. }) => {
                assert!(error.to_string().contains(example) && error.to_string().contains(text));
                assert!(Shape::parse(example).is_ok(), "{example}");
            }
            other => panic!("{text}: {other:?}"),
        }
    }
    for text in ["", "spere:1", "Sphere:1", ":0.1", "@0.1", "mesh.obj"] {
        match Shape::parse(text) {
            Err(ShapeError::UnknownName { known, .. }) => assert!(known.contains("wineglass")),
            other => panic!("{text}: {other:?}"),
        }
    }
}

#[test]
fn absurd_sizes_are_refused() {
    for text in [
        "sphere:0",
        "sphere:-1",
        "sphere:NaN",
        "sphere:inf",
        "sphere:1e9",
        "sphere:1e-9",
        "box:1x0x1",
        "die:0.01x0.006",
        "die:0.01x-0.001",
        "die:0.01xNaN",
        "torus:0.01x0.01",
        "torus:0.01x0.02",
        "prism:2x0.1x0.1",
        "prism:65x0.1x0.1",
        "shard:1x0",
        "rock:1x0",
        "cylinder:0.1xinf",
    ] {
        assert!(
            matches!(Shape::parse(text), Err(ShapeError::Value { .. })),
            "{text}: {:?}",
            Shape::parse(text)
        );
    }
    for text in [
        "sphere:0.01@0",
        "sphere:0.01@-1",
        "sphere:0.01@NaN",
        "sphere:0.01@0.03",
        "sphere:0.01@1e-7",
        "mug@1e-5",
    ] {
        assert!(matches!(Shape::parse(text), Err(ShapeError::Edge { .. })), "{text}");
    }
}
