//! `KHR_implicit_shapes` (draft of Khronos, <https://github.com/eoineoineoin/glTF_Physics>): spheres, boxes,
//! cylinders, capsules and planes in the frame of a node.
//!
//! ```text
//! capsule    radius r(φ) of the ball at its end; the cone between touches both at the latitude φ,
//!            sin φ = (r_bottom − r_top) / height, the distance of the centres
//! ```
//!
//! Spheres, boxes and cylinders become shapes of the library, cones and capsules meshes of revolution
//! about y.

use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::shape::Form;
use glam::{DVec2, DVec3};
use serde_json::Value;

use crate::formats::mesh_reader::gltf::document::Document;

/// Sectors of a mesh of revolution, and parts of the quarter circle of a capsule: volumes are within 0.1 %.
const SECTORS: usize = 96;
const ARC_PARTS: usize = 24;
/// Largest difference of scales that counts as none.
const EVEN: f64 = 1e-3;

/// A shape of a collider \[m\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ImplicitShape {
    /// A shape of the library.
    Form(Form),
    /// A cylinder with different radii at its ends.
    Cone {
        /// Full height.
        height: f64,
        /// Radii at the bottom and the top.
        radii: [f64; 2],
    },
    /// Two balls and the cone around them.
    Capsule {
        /// Distance of their centres.
        height: f64,
        /// Radii at the bottom and the top.
        radii: [f64; 2],
    },
    /// The plane y = 0, endless; its sizes are not read.
    Plane,
}

/// Why a shape is no solid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ShapeFault {
    /// No such shape in the file.
    #[error("there is no shape {index} in KHR_implicit_shapes")]
    Missing {
        /// Its number.
        index: usize,
    },
    /// A type that the draft does not have.
    #[error("{found} is none of sphere, box, cylinder, capsule, plane")]
    Type {
        /// What is there.
        found: String,
    },
    /// A size that is not positive.
    #[error("its {property} is {found}; it must be above 0 m")]
    Size {
        /// Which.
        property: &'static str,
        /// What is there.
        found: f64,
    },
    /// One ball of a capsule that holds the other.
    #[error("a capsule of height {height} m has radii {bottom} m and {top} m: one end lies within the other")]
    Swallowed {
        /// Distance of the centres.
        height: f64,
        /// Radius at the bottom.
        bottom: f64,
        /// Radius at the top.
        top: f64,
    },
    /// A scale that makes something else of it.
    #[error("a {kind} under the scale {x}, {y}, {z} is none any more; apply the scale before the export")]
    Scale {
        /// Its type.
        kind: &'static str,
        /// Along x.
        x: f64,
        /// Along y.
        y: f64,
        /// Along z.
        z: f64,
    },
}

impl ImplicitShape {
    /// The shape of a number under the scale of a node.
    pub(super) fn of_file(document: &Document, index: usize, scale: DVec3) -> Result<Self, ShapeFault> {
        let shapes = document.extensions.shapes.as_ref().and_then(|shapes| shapes.get("shapes"));
        let shape = shapes.and_then(|shapes| shapes.get(index)).ok_or(ShapeFault::Missing { index })?;
        let kind = shape.get("type").and_then(Value::as_str).unwrap_or_default();
        let sizes = shape.get(kind).unwrap_or(&Value::Null);
        let size = |property: &'static str, default: f64| {
            let found = sizes.get(property).map_or(default, |value| value.as_f64().unwrap_or(f64::NAN));
            if found > 0.0 && found.is_finite() {
                Ok(found)
            } else {
                Err(ShapeFault::Size { property, found })
            }
        };
        // A mirrored shape is the same shape.
        let scale = scale.abs();
        let even = |kind: &'static str, one: f64, other: f64| {
            let is_even = (one - other).abs() <= EVEN * one.max(other);
            let DVec3 { x, y, z } = scale;
            if is_even { Ok(()) } else { Err(ShapeFault::Scale { kind, x, y, z }) }
        };
        match kind {
            "sphere" => {
                let radius = size("radius", 0.5)?;
                let is_even = even("sphere", scale.x, scale.y).and(even("sphere", scale.x, scale.z)).is_ok();
                Ok(ImplicitShape::Form(match is_even {
                    true => Form::Sphere { radius: radius * scale.x },
                    false => Form::Ellipsoid { semi_axes: scale * radius },
                }))
            }
            "box" => {
                let edges = sizes.get("size").map(|size| serde_json::from_value::<[f64; 3]>(size.clone()));
                let edges = edges.map_or(DVec3::ONE, |edges| edges.map_or(DVec3::NAN, DVec3::from_array));
                let least = edges.min_element();
                if !(least > 0.0 && edges.is_finite()) {
                    return Err(ShapeFault::Size { property: "size", found: least });
                }
                Ok(ImplicitShape::Form(Form::Box { edges: edges * scale }))
            }
            "cylinder" => {
                even("cylinder", scale.x, scale.z)?;
                let (height, radii) =
                    (size("height", 0.5)? * scale.y, end_radii(sizes)?.map(|r| r * scale.x));
                let [bottom, top] = radii;
                Ok(match bottom == top {
                    true => ImplicitShape::Form(Form::Cylinder { radius: top, height }),
                    false => ImplicitShape::Cone { height, radii },
                })
            }
            "capsule" => {
                even("capsule", scale.x, scale.y).and(even("capsule", scale.x, scale.z))?;
                let (height, radii) =
                    (size("height", 0.5)? * scale.x, end_radii(sizes)?.map(|r| r * scale.x));
                let [bottom, top] = radii;
                if (bottom - top).abs() >= height {
                    return Err(ShapeFault::Swallowed { height, bottom, top });
                }
                Ok(ImplicitShape::Capsule { height, radii })
            }
            "plane" => Ok(ImplicitShape::Plane),
            other => Err(ShapeFault::Type { found: other.into() }),
        }
    }

    /// The mesh of a cone or capsule.
    pub fn mesh(&self) -> Option<TriMesh> {
        match *self {
            ImplicitShape::Cone { height, radii: [bottom, top] } => {
                let half = 0.5 * height;
                let ends = [DVec2::new(0.0, -half), DVec2::new(0.0, half)];
                Some(revolved(&[ends[0], DVec2::new(bottom, -half), DVec2::new(top, half), ends[1]]))
            }
            ImplicitShape::Capsule { height, radii: [bottom, top] } => {
                let latitude = ((bottom - top) / height).asin();
                let arc = |radius: f64, centre: f64, from: f64, to: f64| {
                    (0..=ARC_PARTS).map(move |k| {
                        let angle = from + (to - from) * k as f64 / ARC_PARTS as f64;
                        DVec2::new(radius * angle.cos(), centre + radius * angle.sin())
                    })
                };
                let quarter = std::f64::consts::FRAC_PI_2;
                let lower = arc(bottom, -0.5 * height, -quarter, latitude);
                Some(revolved(&lower.chain(arc(top, 0.5 * height, latitude, quarter)).collect::<Vec<_>>()))
            }
            ImplicitShape::Form(_) | ImplicitShape::Plane => None,
        }
    }
}

/// Radii at the bottom and the top, of which one may be 0.
fn end_radii(sizes: &Value) -> Result<[f64; 2], ShapeFault> {
    let radius = |property: &'static str| {
        let found = sizes.get(property).map_or(0.25, |value| value.as_f64().unwrap_or(f64::NAN));
        if found >= 0.0 && found.is_finite() { Ok(found) } else { Err(ShapeFault::Size { property, found }) }
    };
    let radii = [radius("radiusBottom")?, radius("radiusTop")?];
    if radii == [0.0; 2] { Err(ShapeFault::Size { property: "radiusTop", found: 0.0 }) } else { Ok(radii) }
}

/// The closed surface that a profile from the lowest to the highest point makes about y; x is the radius.
fn revolved(profile: &[DVec2]) -> TriMesh {
    let on_axis = |point: &DVec2| point.x.abs() < 1e-12;
    let mut mesh = TriMesh::default();
    let mut rings: Vec<Vec<u32>> = Vec::new();
    for (k, point) in profile.iter().enumerate() {
        // The tip of a cone is on the axis twice.
        if k > 0 && on_axis(point) && on_axis(&profile[k - 1]) {
            continue;
        }
        let first = mesh.vertices.len() as u32;
        let count = if on_axis(point) { 1 } else { SECTORS };
        mesh.vertices.extend((0..count).map(|sector| {
            let angle = std::f64::consts::TAU * sector as f64 / SECTORS as f64;
            let radius = if count == 1 { 0.0 } else { point.x };
            DVec3::new(radius * angle.cos(), point.y, radius * angle.sin())
        }));
        rings.push((0..SECTORS as u32).map(|sector| first + sector.min(count as u32 - 1)).collect());
    }
    for pair in rings.windows(2) {
        for sector in 0..SECTORS {
            let next = (sector + 1) % SECTORS;
            let corners = [pair[0][sector], pair[1][sector], pair[1][next], pair[0][next]];
            for triangle in [[corners[0], corners[1], corners[2]], [corners[0], corners[2], corners[3]]] {
                let [a, b, c] = triangle;
                if a != b && b != c && c != a {
                    mesh.triangles.push(triangle);
                }
            }
        }
    }
    mesh
}

#[cfg(test)]
mod tests {
    use clangor_core::geometry::mass_properties::MassProperties;

    use super::*;

    #[test]
    fn capsules_and_cones_have_their_volumes() {
        let pi = std::f64::consts::PI;
        let capsule = ImplicitShape::Capsule { height: 0.04, radii: [0.01, 0.01] };
        let volume = pi * 1e-4 * 0.04 + 4.0 / 3.0 * pi * 1e-6;
        let cone = ImplicitShape::Cone { height: 0.03, radii: [0.02, 0.0] };
        let cases = [(capsule, volume), (cone, pi / 3.0 * 4e-4 * 0.03)];
        for (shape, expected) in cases {
            let mass = MassProperties::of(&shape.mesh().unwrap()).unwrap();
            // Seen: 8.2e-4 and 7.1e-4, of the sectors.
            assert!((mass.volume / expected - 1.0).abs() < 1e-3, "{shape:?}: {}", mass.volume / expected);
        }
        // Of unequal ends, no vertex lies outside of both balls and their tangent cone: the widest is the
        // ball.
        let drop = ImplicitShape::Capsule { height: 0.04, radii: [0.02, 0.005] }.mesh().unwrap();
        assert!(MassProperties::of(&drop).is_ok());
        let widest = drop.vertices.iter().map(|v| v.x.hypot(v.z)).fold(0.0, f64::max);
        assert!((widest - 0.02).abs() < 1e-5, "{widest}");
        let lowest = drop.vertices.iter().map(|v| v.y).fold(0.0, f64::min);
        assert!((lowest + 0.04).abs() < 1e-12, "{lowest}");
    }
}
