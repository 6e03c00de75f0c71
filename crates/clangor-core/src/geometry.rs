//! Shapes as surfaces and solids.
//!
//! * [`tri_mesh`]: triangles; [`topology`]: which triangles share an edge; [`refine`]: smaller triangles;
//! * [`solid`]: whether a mesh bounds a solid, and what is wrong with it if not;
//! * [`mend`]: small faults of files;
//! * [`mass_properties`], [`principal_axes`]: volume, centre of mass, inertia;
//! * [`principal_curvature`], which sets the contact time; [`vertex_curvature`]: the same on a mesh;
//! * [`sharp_place`]: creases and corners, where a mesh has no curvature;
//! * [`curvature`]: mean curvature and normals at vertices;
//! * [`surface_tree`]: nearest point, inside or outside;
//! * [`meridian`]: the exact section of a body of revolution; [`turning`]: its surface from rings;
//! * [`convex`], [`hull`], [`parts_fit`]: convex parts, which collide, and how close they are to the surface.

pub mod ball_tree;
pub mod components;
pub mod convex;
pub mod curvature;
pub mod hull;
pub mod icosahedron;
pub mod mass_properties;
pub mod mend;
pub mod meridian;
mod mesh_error;
pub mod parts_fit;
pub mod principal_axes;
pub mod principal_curvature;
pub mod refine;
mod self_intersection;
pub mod sharp_place;
pub mod solid;
pub mod surface_tree;
pub mod topology;
pub mod tri_mesh;
pub mod turning;
pub mod vertex_curvature;
