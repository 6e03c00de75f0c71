//! Shapes as surfaces and solids: triangle meshes, mass properties, curvature, convex parts.

pub mod convex;
pub mod mass_properties;
pub mod tri_mesh;
