//! Shapes of the bodies: spheres, planes and meshes. Copies of a body share a mesh.

use std::collections::BTreeMap;
use std::sync::Arc;

use clangor_core::body::{Body, Surface};
use serde_json::{Value, json};

pub(super) struct Surfaces {
    /// Vertices of all meshes \[m\], about the centres of mass.
    pub(super) vertices: Vec<[f32; 3]>,
    /// Triangles of all meshes, as indices into the vertices of their own mesh.
    pub(super) triangles: Vec<[u32; 3]>,
    /// For each mesh: first vertex, vertex count, first triangle, triangle count.
    pub(super) ranges: Vec<[u32; 4]>,
    /// Form of each body.
    forms: Vec<Form>,
}

enum Form {
    Sphere { radius: f64 },
    Mesh(usize),
    Plane,
}

impl Surfaces {
    pub(super) fn of(bodies: &[Body]) -> Self {
        let mut known: BTreeMap<usize, usize> = BTreeMap::new();
        let (mut vertices, mut triangles, mut ranges) = (Vec::new(), Vec::new(), Vec::new());
        let mut form = |body: &Body| match &*body.surface {
            Surface::Sphere { radius } => Form::Sphere { radius: *radius },
            Surface::HalfSpace | Surface::Plate { .. } => Form::Plane,
            Surface::Mesh(surface) => {
                let at = *known.entry(Arc::as_ptr(&body.surface).addr()).or_insert_with(|| {
                    let mesh = &surface.mesh;
                    ranges.push(
                        [vertices.len(), mesh.vertices.len(), triangles.len(), mesh.triangles.len()]
                            .map(|n| n as u32),
                    );
                    vertices.extend(mesh.vertices.iter().map(|x| x.as_vec3().to_array()));
                    triangles.extend_from_slice(&mesh.triangles);
                    ranges.len() - 1
                });
                Form::Mesh(at)
            }
        };
        let forms = bodies.iter().map(&mut form).collect();
        Surfaces { vertices, triangles, ranges, forms }
    }

    /// The form of a body.
    pub(super) fn describe(&self, body: usize) -> Value {
        match self.forms[body] {
            Form::Sphere { radius } => json!({ "form": "sphere", "radius_m": radius }),
            Form::Mesh(mesh) => json!({ "form": "mesh", "mesh": mesh }),
            Form::Plane => json!({ "form": "plane" }),
        }
    }
}
