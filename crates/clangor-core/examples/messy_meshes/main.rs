//! Writes a messy mesh of every shape of the library: turned, scaled, with 7000 to 70 000 uneven triangles
//! and noise of 1 % of an edge.
//!
//! `cargo run --release -p clangor-core --example messy_meshes -- FOLDER [FORMAT [SEED [SHAPE …]]]`
//!
//! FORMAT is `obj` (the default), `ply` or `stl`. Without shapes, all of [`SHAPES`]. `meshes.csv` in the
//! folder has the shape, the factor on its lengths and the volume of each file.

mod messy_mesh;

use std::error::Error;
use std::fmt::Write;
use std::path::Path;

use clangor_core::geometry::solid::check_solid;
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::shape::Shape;
use messy_mesh::{MessyOptions, messy_shape};

/// Every shape of the library, the bare names first.
const SHAPES: [&str; 19] = [
    "sphere",
    "die",
    "coin",
    "ring",
    "bowl",
    "plate",
    "mug",
    "wineglass",
    "moneybox",
    "key",
    "tile",
    "pane",
    "ellipsoid:0.03x0.02x0.015",
    "box:0.08x0.05x0.03",
    "cylinder:0.01x0.06",
    "torus:0.03x0.006",
    "rock:3x0.03",
    "prism:6x0.02x0.05",
    "shard:2x0.06",
];
/// Fewest and most triangles.
const TRIANGLES: [f64; 2] = [7e3, 70e3];
const NOISE: f64 = 0.01;
const SCALE: [f64; 2] = [0.7, 1.4];

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [folder, options @ ..] = arguments.as_slice() else {
        return Err("usage: messy_meshes FOLDER [FORMAT [SEED [SHAPE …]]]".into());
    };
    let format = options.first().map_or("obj", String::as_str);
    let seed = options.get(1).map_or(Ok(1), |text| text.parse::<u64>())?;
    let named: Vec<&str> = options.iter().skip(2).map(String::as_str).collect();
    let shapes = if named.is_empty() { SHAPES.to_vec() } else { named };
    std::fs::create_dir_all(folder)?;
    let mut table = String::from("file,shape,triangles,scale,volume,volume_of_shape\n");
    for (k, text) in shapes.iter().enumerate() {
        // In steps of the golden section, so that every seed has small and large ones.
        let place = (0.618 * (k as f64 + seed as f64)).fract();
        let triangles = (TRIANGLES[0] * (TRIANGLES[1] / TRIANGLES[0]).powf(place)) as usize;
        let seed = seed.wrapping_mul(1000).wrapping_add(k as u64);
        let messy = messy_shape(text, MessyOptions { seed, triangles, noise: NOISE, scale: SCALE })?;
        let solid = check_solid(&messy.mesh).map_err(|e| format!("{text}: {e}"))?;
        let clean = check_solid(&Shape::parse(text)?.mesh())?.mass.volume * messy.scale.powi(3);
        let name = text.replace([':', '@'], "_");
        let file = format!("{name}.{format}");
        write_mesh(&Path::new(folder).join(&file), format, &messy.mesh)?;
        let count = messy.mesh.triangles.len();
        writeln!(table, "{file},{text},{count},{},{},{clean}", messy.scale, solid.mass.volume)?;
        println!("{file}: {count} triangles, volume {:+.2} %", 100.0 * (solid.mass.volume / clean - 1.0));
    }
    std::fs::write(Path::new(folder).join("meshes.csv"), table)?;
    Ok(())
}

fn write_mesh(path: &Path, format: &str, mesh: &TriMesh) -> Result<(), Box<dyn Error>> {
    let bytes = match format {
        "obj" => obj(mesh).into_bytes(),
        "ply" => ply(mesh).into_bytes(),
        "stl" => stl(mesh),
        _ => return Err(format!("format {format}: obj, ply or stl is expected").into()),
    };
    Ok(std::fs::write(path, bytes)?)
}

/// Coordinates with the seven digits that most programs write.
fn obj(mesh: &TriMesh) -> String {
    let vertices = mesh.vertices.iter().map(|v| format!("v {:.6e} {:.6e} {:.6e}\n", v.x, v.y, v.z));
    let faces = mesh.triangles.iter().map(|t| format!("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1));
    vertices.chain(faces).collect()
}

fn ply(mesh: &TriMesh) -> String {
    let head = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        mesh.vertices.len(),
        mesh.triangles.len()
    );
    let vertices = mesh.vertices.iter().map(|v| format!("{:.6e} {:.6e} {:.6e}\n", v.x, v.y, v.z));
    let faces = mesh.triangles.iter().map(|t| format!("3 {} {} {}\n", t[0], t[1], t[2]));
    std::iter::once(head).chain(vertices).chain(faces).collect()
}

/// Binary, with three corners of its own for every facet.
fn stl(mesh: &TriMesh) -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes.extend((mesh.triangles.len() as u32).to_le_bytes());
    for t in 0..mesh.triangles.len() {
        let normal = mesh.area_vector(t).normalize_or_zero();
        for v in std::iter::once(normal).chain(mesh.corners(t)) {
            bytes.extend(v.to_array().iter().flat_map(|x| (*x as f32).to_le_bytes()));
        }
        bytes.extend([0, 0]);
    }
    bytes
}
