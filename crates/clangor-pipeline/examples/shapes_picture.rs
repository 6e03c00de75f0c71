//! Draws every shape of the library from above and the side, each to its own scale, as
//! docs/format/shapes.svg: `cargo run --release -p clangor-pipeline --example shapes_picture >
//! docs/format/shapes.svg`.
//!
//! Faces that look at the observer are filled from the farthest to the nearest; brighter towards the light. A
//! picture, not a measurement: where faces overlap, the order of their middles decides.

use clangor_core::glam::{DMat3, DVec3};
use clangor_core::shape::{Shape, ShapeError};

/// What is drawn, coarse enough for a small file.
const SHAPES: [&str; 19] = [
    "sphere:0.0075@0.003",
    "ellipsoid:0.02x0.01x0.015@0.006",
    "box:0.1x0.05x0.2@0.2",
    "die:0.015x0.003@0.003",
    "cylinder:0.02x0.06@0.008",
    "coin:0.01213x0.00175@0.004",
    "torus:0.03x0.01@0.01",
    "ring@0.0025",
    "rock:7x0.03@0.02",
    "prism:6x0.01x0.03@0.03",
    "shard:3x0.04@0.03",
    "bowl@0.02",
    "plate@0.03",
    "mug@0.014",
    "wineglass@0.014",
    "moneybox@0.018",
    "key@0.005",
    "tile@0.1",
    "pane@0.4",
];
const COLUMNS: usize = 5;
/// Edge of a cell, and the part of it that a shape fills.
const CELL: f64 = 130.0;
const FILLED: f64 = 0.4;
/// Shades of grey.
const SHADES: usize = 24;

fn main() -> Result<(), ShapeError> {
    let rows = SHAPES.len().div_ceil(COLUMNS);
    let (width, height) = (CELL * COLUMNS as f64, CELL * rows as f64);
    println!(r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-size="11">"#);
    println!(r#"<style>path{{stroke-width:.4}}"#);
    for shade in 0..SHADES {
        let grey = 65 + 170 * shade / (SHADES - 1);
        println!(".s{shade}{{fill:rgb({grey},{grey},{0});stroke:rgb({grey},{grey},{0})}}", grey + 12);
    }
    println!("</style>");
    println!(r#"<rect width="{width}" height="{height}" fill="white"/>"#);
    for (index, text) in SHAPES.iter().enumerate() {
        let corner = CELL * DVec3::new((index % COLUMNS) as f64, (index / COLUMNS) as f64, 0.0);
        draw(text, corner)?;
    }
    println!("</svg>");
    Ok(())
}

/// One shape and its name in the cell at `corner`.
fn draw(text: &str, corner: DVec3) -> Result<(), ShapeError> {
    let mesh = Shape::parse(text)?.mesh();
    // The axis y upwards, seen from 30° above.
    let view = DMat3::from_rotation_x(30.0_f64.to_radians()) * DMat3::from_rotation_y(-35.0_f64.to_radians());
    let (low, high) = mesh.bounds();
    let middle = 0.5 * (low + high);
    let scale = FILLED * CELL / mesh.bounding_radius(middle);
    let seen: Vec<DVec3> = mesh.vertices.iter().map(|v| scale * (view * (*v - middle))).collect();
    let mut faces: Vec<(f64, f64, [DVec3; 3])> = mesh
        .triangles
        .iter()
        .filter_map(|t| {
            let [a, b, c] = t.map(|i| seen[i as usize]);
            let normal = (b - a).cross(c - a).try_normalize()?;
            let light = normal.dot(DVec3::new(-0.4, 0.75, 0.53));
            (normal.z > 0.0).then_some((a.z + b.z + c.z, light, [a, b, c]))
        })
        .collect();
    faces.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (_, light, face) in faces {
        let shade = (0.5 * (1.0 + light.clamp(-1.0, 1.0)) * (SHADES - 1) as f64).round();
        let at = |p: DVec3| format!("{:.1},{:.1}", corner.x + 0.5 * CELL + p.x, corner.y + 0.45 * CELL - p.y);
        let [a, b, c] = face.map(at);
        println!(r#"<path class="s{shade}" d="M{a} {b} {c}z"/>"#);
    }
    let name = text.split(['@', ':']).next().unwrap_or(text);
    let (x, y) = (corner.x + 0.5 * CELL, corner.y + 0.97 * CELL);
    println!(r#"<text x="{x}" y="{y}" text-anchor="middle">{name}</text>"#);
    Ok(())
}
