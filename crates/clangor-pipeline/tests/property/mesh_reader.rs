//! Mesh files: every format gives the same surface, damage is told by place, nothing panics.

use std::fs;
use std::path::Path;

use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_pipeline::formats::mesh_reader::{MeshFault, MeshFileError, MeshPlace, read_mesh};
use glam::DVec3;
use proptest::prelude::*;

/// A square pyramid with a quadrangle as its base, in the formats as text.
const OBJ: &str = "# pyramid\no one\nv -1 0 -1\nv 1 0 -1\nv 1 0 1 1.0\nv -1 0 1\n\
    vn 0 1 0\nf 1/1 2/1/1 3//1 \\\n 4\ns off\no two\nv 0 2 0\nf 1 5 2\nf 2 -1 3\nf 3 5 4\nf 4 5 1\nl 1 2\n";

const PLY: &str = "ply\nformat ascii 1.0\ncomment pyramid\nelement vertex 5\nproperty float x\n\
    property float y\n\
    property float z\nproperty uchar red\nelement extra 1\nproperty list uchar int stuff\nelement face 5\n\
    property uchar flags\nproperty list uchar int vertex_indices\nend_header\n\
    -1 0 -1 7\n1 0 -1 7\n1 0 1 7\n-1 0 1 7\n0 2 0 7\n2 5 6\n\
    0 4 0 1 2 3\n0 3 0 4 1\n0 3 1 4 2\n0 3 2 4 3\n0 3 3 4 0\n";

fn pyramid() -> Vec<[DVec3; 3]> {
    let p = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    let (a, b, c, d, top) = (p(-1., 0., -1.), p(1., 0., -1.), p(1., 0., 1.), p(-1., 0., 1.), p(0., 2., 0.));
    vec![[a, b, c], [a, c, d], [a, top, b], [b, top, c], [c, top, d], [d, top, a]]
}

fn stl_binary() -> Vec<u8> {
    // A header that pretends to be text, as some programs write it.
    let mut bytes = b"solid but binary".to_vec();
    bytes.resize(80, b' ');
    bytes.extend_from_slice(&6u32.to_le_bytes());
    for triangle in pyramid() {
        bytes.extend_from_slice(&[0; 12]);
        for x in triangle.iter().flat_map(|c| c.to_array()) {
            bytes.extend_from_slice(&(x as f32).to_le_bytes());
        }
        bytes.extend_from_slice(&[0; 2]);
    }
    bytes
}

fn stl_text() -> String {
    let mut text = String::from("solid pyramid\n");
    for triangle in pyramid() {
        text += " facet normal 0 0 0\n  outer loop\n";
        for c in triangle {
            text += &format!("   vertex {:e} {} {}\n", c.x, c.y, c.z);
        }
        text += "  endloop\n endfacet\n";
    }
    text + "endsolid pyramid\n"
}

/// PLY with numbers of either byte order, doubles and short indices.
fn ply_binary(big: bool) -> Vec<u8> {
    let order = if big { "big" } else { "little" };
    let mut bytes = format!(
        "ply\nformat binary_{order}_endian 1.0\nelement vertex 18\nproperty double x\nproperty double y\n\
         property double z\nelement face 6\nproperty list ushort short vertex_index\nend_header\n"
    )
    .into_bytes();
    for x in pyramid().concat().iter().flat_map(|c| c.to_array()) {
        bytes.extend_from_slice(&if big { x.to_be_bytes() } else { x.to_le_bytes() });
    }
    for face in 0..6i16 {
        for x in [3, 3 * face, 3 * face + 1, 3 * face + 2] {
            bytes.extend_from_slice(&if big { x.to_be_bytes() } else { x.to_le_bytes() });
        }
    }
    bytes
}

/// One triangle list under a moved, turned and mirrored node.
fn gltf(uri: &str) -> String {
    format!(
        r#"{{"asset": {{"version": "2.0"}}, "scene": 0, "scenes": [{{"nodes": [0]}}],
        "nodes": [{{"children": [1], "translation": [10, 0, 0], "scale": [2, 2, -2]}},
                  {{"mesh": 0, "rotation": [0, 0.7071067811865476, 0, 0.7071067811865476]}}],
        "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "indices": 1}}]}}],
        "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}},
                      {{"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"}}],
        "bufferViews": [{{"buffer": 0, "byteLength": 36}},
                        {{"buffer": 0, "byteOffset": 36, "byteLength": 6}}],
        "buffers": [{{"byteLength": 42, "uri": "{uri}"}}]}}"#
    )
}

fn gltf_buffer() -> Vec<u8> {
    let mut bytes = Vec::new();
    for x in [0f32, 0., 0., 1., 0., 0., 0., 1., 0.] {
        bytes.extend_from_slice(&x.to_le_bytes());
    }
    bytes.extend([0u16, 1, 2].iter().flat_map(|i| i.to_le_bytes()));
    bytes
}

const GLTF_BASE64: &str =
    "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAABAAIA";

fn read_bytes(name: &str, bytes: impl AsRef<[u8]>) -> Result<TriMesh, MeshFileError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, bytes).unwrap();
    read_mesh(&path)
}

fn corners(mesh: &TriMesh) -> Vec<[DVec3; 3]> {
    (0..mesh.triangles.len()).map(|t| mesh.corners(t)).collect()
}

#[test]
fn every_format_gives_the_same_surface() {
    let files: [(&str, Vec<u8>, usize); 6] = [
        ("a.obj", OBJ.into(), 5),
        ("a.PLY", PLY.into(), 5),
        ("le.ply", ply_binary(false), 18),
        ("be.ply", ply_binary(true), 18),
        ("a.stl", stl_text().into(), 5),
        ("b.stl", stl_binary(), 5),
    ];
    for (name, bytes, vertices) in files {
        let mesh = read_bytes(name, bytes).unwrap();
        assert_eq!(corners(&mesh), pyramid(), "{name}");
        assert_eq!(mesh.vertices.len(), vertices, "{name}");
    }
}

#[test]
fn gltf_nodes_move_what_they_hold() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("the buffer.bin"), gltf_buffer()).unwrap();
    for (name, uri) in [("a.gltf", "the%20buffer.bin"), ("b.gltf", GLTF_BASE64)] {
        let path = folder.path().join(name);
        fs::write(&path, gltf(uri)).unwrap();
        let mesh = read_mesh(&path).unwrap();
        // A quarter turn about y takes x to −z, the parent takes −z to 2 z; the mirror swaps two corners.
        let expected = [DVec3::X * 10.0, DVec3::new(10.0, 2.0, 0.0), DVec3::new(10.0, 0.0, 2.0)];
        for (corner, expected) in mesh.corners(0).iter().zip(expected) {
            // Seen: 4e-16.
            assert!(corner.distance(expected) < 1e-14, "{corner}");
        }
    }
    for uri in ["../the%20buffer.bin", "/etc/hosts", "http://a/b.bin", "none.bin", "data:;base64,*"] {
        let path = folder.path().join("c.gltf");
        fs::write(&path, gltf(uri)).unwrap();
        let error = read_mesh(&path).unwrap_err();
        assert!(matches!(error, MeshFileError::Content { fault: MeshFault::Buffer { .. }, .. }), "{error}");
    }
}

#[test]
fn damage_is_told_by_place() {
    let line = MeshPlace::Line;
    let cases: Vec<(&str, Vec<u8>, MeshPlace, &str)> = vec![
        ("a.obj", b"".to_vec(), MeshPlace::Whole, "there are no triangles"),
        ("a.obj", OBJ.replace("1 0 1 1.0", "1 zero 1").into(), line(5), "\"zero\" is no number"),
        ("a.obj", OBJ.replace("1 0 1 1.0", "1 nan 1").into(), line(5), "a coordinate is not finite"),
        ("a.obj", OBJ.replace("1 0 1 1.0", "1 1").into(), line(5), "three coordinates are expected"),
        (
            "a.obj",
            OBJ.replace("f 1 5 2", "f 1 9 2").into(),
            line(13),
            "a face names vertex 9, but there are 5",
        ),
        ("a.obj", OBJ.replace("f 1 5 2", "f 1 0 2").into(), line(13), "a face names vertex 0"),
        ("a.obj", OBJ.replace("f 1 5 2", "f 1 -6 2").into(), line(13), "a face names vertex -6"),
        ("a.obj", OBJ.replace("f 1 5 2", "f 1 5").into(), line(13), "a face has 2 corners"),
        ("a.ply", b"".to_vec(), line(1), "no end_header"),
        ("a.ply", PLY.replace("ply\n", "plx\n").into(), line(1), "begins with the line ply"),
        ("a.ply", PLY.replace("float z", "floot z").into(), line(7), "type is unknown"),
        (
            "a.ply",
            PLY.replace("float z", "float w").into(),
            MeshPlace::Whole,
            "lacks the properties x, y and z",
        ),
        ("a.ply", PLY[..PLY.len() - 6].into(), MeshPlace::Element("face", 4), "the file is truncated"),
        ("a.ply", PLY.replace("3 4 0\n", "3 9 0\n").into(), MeshPlace::Element("face", 4), "names vertex 9"),
        ("a.ply", PLY.replace("0 2 0 7", "0 inf 0 7").into(), MeshPlace::Element("vertex", 4), "not finite"),
        (
            "a.ply",
            PLY.replace("vertex 5", "vertex 99999999999").into(),
            MeshPlace::Element("vertex", 12),
            "the file is truncated",
        ),
        ("a.stl", b"".to_vec(), MeshPlace::Byte(0), "the file is truncated"),
        ("a.stl", stl_binary()[..300].to_vec(), MeshPlace::Element("facet", 4), "the file is truncated"),
        ("a.stl", stl_text()[..100].into(), line(6), "three coordinates are expected"),
        ("a.stl", stl_text().replace("endsolid pyramid\n", "").into(), line(44), "the file is truncated"),
        ("a.stl", stl_text().replacen("   vertex -1e0 0 -1\n", "", 1).into(), line(6), "exactly 3 vertices"),
        ("a.stl", b"solid x\nendsolid x\n".to_vec(), MeshPlace::Whole, "there are no triangles"),
        ("a.gltf", b"{".to_vec(), line(1), "export it again"),
        ("a.gltf", b"{}".to_vec(), MeshPlace::Whole, "there are no triangles"),
        ("a.glb", b"glTF\x01\0\0\0".to_vec(), MeshPlace::Byte(4), "only version 2"),
        ("a.glb", b"glTF\x02\0\0\0".to_vec(), MeshPlace::Byte(12), "the file is truncated"),
    ];
    for (name, bytes, place, expected) in cases {
        let text = String::from_utf8_lossy(&bytes).into_owned();
        let error = read_bytes(name, bytes).unwrap_err();
        let message = error.to_string();
        assert!(message.contains(expected), "{text}: {message}");
        assert!(
            matches!(&error, MeshFileError::Content { place: p, .. } if *p == place),
            "{text}: {message}"
        );
    }
    let gltf_cases = [
        ("\"indices\": 1", "\"indices\": 1, \"mode\": 1", "lines cannot be read"),
        ("\"indices\": 1", "\"indices\": 0", "indices SCALAR"),
        ("\"indices\": 1", "\"indices\": 7", "does not exist"),
        ("\"count\": 3, \"type\": \"VEC3\"", "\"count\": 4, \"type\": \"VEC3\"", "the file is truncated"),
        (
            "\"count\": 3, \"type\": \"VEC3\"",
            "\"count\": 2, \"type\": \"VEC3\"",
            "names vertex 2, but there are 2",
        ),
        ("\"mesh\": 0", "\"mesh\": 1", "it does not exist"),
        ("\"children\": [1]", "\"children\": [0]", "form a loop"),
        ("\"byteOffset\": 36", "\"byteOffset\": 18446744073709551615", "the file is truncated"),
        ("\"scale\": [2, 2, -2]", "\"scale\": [2, 1e300, 1e300]", "mesh 0"),
    ];
    for (from, to, expected) in gltf_cases {
        let text = gltf(GLTF_BASE64);
        assert!(text.contains(from), "{from}");
        match read_bytes("a.gltf", text.replacen(from, to, 1)) {
            Err(error) => assert!(error.to_string().contains(expected), "{to}: {error}"),
            // A huge scale is the business of whoever looks at sizes.
            Ok(mesh) => assert!(mesh.vertices.iter().all(|v| v.is_finite()), "{to}"),
        }
    }
}

#[test]
fn a_small_gltf_cannot_stand_for_more_than_fits_into_memory() {
    // 2000 nodes share a mesh whose 500 primitives share an accessor of 1000 vertices.
    let list = |part: &str, count: usize| vec![part; count].join(",");
    let nodes: Vec<String> = (0..2000).map(|node| node.to_string()).collect();
    let text = format!(
        r#"{{"asset": {{"version": "2.0"}}, "scenes": [{{"nodes": [{}]}}], "nodes": [{}],
        "meshes": [{{"primitives": [{}]}}],
        "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 999, "type": "VEC3"}}],
        "bufferViews": [{{"buffer": 0, "byteLength": 11988}}],
        "buffers": [{{"byteLength": 12000, "uri": "data:;base64,{}"}}]}}"#,
        nodes.join(","),
        list(r#"{"mesh": 0}"#, 2000),
        list(r#"{"attributes": {"POSITION": 0}}"#, 500),
        "A".repeat(16_000)
    );
    let message = read_bytes("small.gltf", text).unwrap_err().to_string();
    assert!(message.contains("more than 20 million vertices"), "{message}");
}

#[test]
fn buffers_that_name_one_file_are_read_once() {
    let folder = tempfile::tempdir().unwrap();
    let mut buffer = gltf_buffer();
    // 100 times this would be more than all buffers may have.
    buffer.resize(20 << 20, 0);
    fs::write(folder.path().join("a.bin"), buffer).unwrap();
    let one = r#"{"byteLength": 42, "uri": "a.bin"}"#;
    let text = gltf("a.bin").replace(one, &vec![one; 100].join(","));
    let path = folder.path().join("many.gltf");
    fs::write(&path, text).unwrap();
    assert_eq!(read_mesh(&path).unwrap().triangles.len(), 1);
    let outside = gltf("../a.bin");
    fs::write(&path, outside).unwrap();
    let message = read_mesh(&path).unwrap_err().to_string();
    assert!(message.contains("only files in the folder of the mesh"), "{message}");
}

#[test]
fn files_that_are_no_meshes_are_refused() {
    assert!(matches!(read_bytes("a.txt", "x"), Err(MeshFileError::Extension { .. })));
    assert!(matches!(read_bytes("obj", "x"), Err(MeshFileError::Extension { .. })));
    let missing = read_mesh(Path::new("/nowhere/a.obj")).unwrap_err();
    assert!(missing.to_string().contains("/nowhere/a.obj"), "{missing}");
}

/// Some bytes of a good file are replaced, and its end may be missing.
fn damaged(good: Vec<u8>) -> impl Strategy<Value = Vec<u8>> {
    let length = good.len();
    let edits = prop::collection::vec((0..length, any::<u8>()), 0..8);
    (edits, 0..=length).prop_map(move |(edits, cut)| {
        let mut bytes = good.clone();
        edits.iter().for_each(|(at, byte)| bytes[*at] = *byte);
        bytes.truncate(if cut % 3 == 0 { cut } else { bytes.len() });
        bytes
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn damaged_files_are_meshes_or_errors(
        obj in damaged(OBJ.into()),
        ply in damaged(PLY.into()),
        binary_ply in damaged(ply_binary(true)),
        stl in damaged(stl_text().into()),
        binary_stl in damaged(stl_binary()),
        gltf in damaged(gltf(GLTF_BASE64).into()),
        noise in prop::collection::vec(any::<u8>(), 0..200),
    ) {
        let files = [
            ("a.obj", obj), ("a.ply", ply), ("b.ply", binary_ply), ("a.stl", stl), ("b.stl", binary_stl),
            ("a.gltf", gltf), ("n.obj", noise.clone()), ("n.ply", noise.clone()), ("n.stl", noise.clone()),
            ("n.gltf", noise.clone()), ("n.glb", [b"glTF\x02\0\0\0".to_vec(), noise].concat()),
        ];
        for (name, bytes) in files {
            if let Ok(mesh) = read_bytes(name, bytes) {
                prop_assert!(mesh.vertices.iter().all(|v| v.is_finite()));
                prop_assert!(mesh.triangles.iter().flatten().all(|i| (*i as usize) < mesh.vertices.len()));
            }
        }
    }
}
