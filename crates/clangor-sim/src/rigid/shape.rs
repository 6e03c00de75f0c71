//! Collision shapes: the convex parts of a body with their full faces and support points.
//!
//! Hulls keep every vertex of a face, because with a manifold of four vertices a coin of 64 sides never stops
//! rocking. Balls, cylinders and half-spaces are exact. Mass and inertia belong to the body, not to its
//! shape.

use clangor_core::body::Surface;
use clangor_core::geometry::convex::ConvexPart;
use glam::{DMat3, DQuat, DVec3};
use parry3d_f64::shape::{ConvexPolyhedron, SupportMap};

/// Rounding radius of hulls and cylinders in contact with each other \[m\].
///
/// It keeps the distance query away from overlap, where it is slower and less accurate. Bodies therefore rest
/// 10 µm apart.
pub(super) const SKIN: f64 = 5e-6;

/// A hull thinner than this fraction of its size is rejected as flat.
const FLAT: f64 = 1e-6;

/// One convex piece in its own frame.
pub(super) enum PartShape {
    Hull(Hull),
    /// Smooth side, axis z, centred.
    Cylinder {
        radius: f64,
        half_height: f64,
    },
    Ball {
        radius: f64,
    },
    /// Solid where y < 0.
    HalfSpace,
}

/// A convex polyhedron.
pub(super) struct Hull {
    pub(super) vertices: Vec<DVec3>,
    pub(super) faces: Vec<Face>,
}

/// A face: outward normal, and vertex indices counter-clockwise seen from outside.
pub(super) struct Face {
    pub(super) normal: DVec3,
    pub(super) corners: Vec<u32>,
}

/// A convex piece placed in the frame of its body.
pub(super) struct Part {
    pub(super) shape: PartShape,
    /// Origin of the part's frame in the body frame, also the centre of its bounding ball \[m\].
    pub(super) centre: DVec3,
    /// Rotation from the part's frame to the body frame.
    pub(super) rotation: DQuat,
    /// Radius of the bounding ball \[m\].
    pub(super) radius: f64,
}

/// The parts of a body and the radius of their bounding ball about its centre of mass.
pub(super) struct Shape {
    pub(super) parts: Vec<Part>,
    pub(super) radius: f64,
    pub(super) half_space: bool,
}

/// Rejects surfaces that cannot collide.
///
/// # Errors
/// The defect of the surface.
#[cfg(feature = "fracture")]
pub(crate) fn check_surface(surface: &Surface) -> Result<(), &'static str> {
    Shape::try_new(surface).map(|_| ())
}

impl Shape {
    /// The parts of a surface; `Err` states what is wrong with it.
    pub(super) fn try_new(surface: &Surface) -> Result<Self, &'static str> {
        let parts = match surface {
            Surface::Sphere { radius } => {
                vec![Part::try_new(&ConvexPart::Ball { centre: DVec3::ZERO, radius: *radius })?]
            }
            Surface::HalfSpace | Surface::Plate { .. } => vec![Part {
                shape: PartShape::HalfSpace,
                centre: DVec3::ZERO,
                rotation: DQuat::IDENTITY,
                radius: f64::INFINITY,
            }],
            Surface::Mesh(mesh) => mesh.parts.iter().map(Part::try_new).collect::<Result<_, _>>()?,
        };
        if parts.is_empty() {
            return Err("has no convex parts");
        }
        if parts.len() > usize::from(u16::MAX) {
            return Err("has more than 65535 convex parts");
        }
        let radius = parts.iter().map(|p| p.centre.length() + p.radius).fold(0.0, f64::max);
        Ok(Shape { parts, radius, half_space: surface.is_plane() })
    }
}

impl Part {
    fn try_new(part: &ConvexPart) -> Result<Self, &'static str> {
        let positive = |x: f64| x > 0.0 && x.is_finite();
        match part {
            ConvexPart::Ball { centre, radius } => {
                if !positive(*radius) || !centre.is_finite() {
                    return Err("has a ball without a positive radius");
                }
                let shape = PartShape::Ball { radius: *radius };
                Ok(Part { shape, centre: *centre, rotation: DQuat::IDENTITY, radius: *radius })
            }
            ConvexPart::Cylinder { centre, axis, radius, half_height } => {
                let axis = axis.try_normalize().ok_or("has a cylinder without an axis")?;
                if !positive(*radius) || !positive(*half_height) || !centre.is_finite() {
                    return Err("has a cylinder without positive radius and height");
                }
                Ok(Part {
                    shape: PartShape::Cylinder { radius: *radius, half_height: *half_height },
                    centre: *centre,
                    rotation: DQuat::from_rotation_arc(DVec3::Z, axis),
                    radius: radius.hypot(*half_height),
                })
            }
            ConvexPart::Hull(points) => {
                let (hull, centre) = Hull::try_new(points)?;
                let radius = hull.vertices.iter().map(|v| v.length()).fold(0.0, f64::max);
                Ok(Part { shape: PartShape::Hull(hull), centre, rotation: DQuat::IDENTITY, radius })
            }
        }
    }

    /// Whether the contact point moves over the surface while the body turns.
    pub(super) fn is_curved(&self) -> bool {
        matches!(self.shape, PartShape::Ball { .. } | PartShape::Cylinder { .. })
    }

    /// Radius of a cylinder \[m\]; 0 for other parts.
    pub(super) fn cylinder_radius(&self) -> f64 {
        if let PartShape::Cylinder { radius, .. } = self.shape { radius } else { 0.0 }
    }

    /// Rounding radius \[m\] of the core in the distance query, against `other`.
    pub(super) fn rounding(&self, other: &Part) -> f64 {
        match (&self.shape, &other.shape) {
            (PartShape::Ball { radius }, _) => *radius,
            (_, PartShape::Ball { .. } | PartShape::HalfSpace) => 0.0,
            _ => SKIN,
        }
    }
}

impl SupportMap for Part {
    fn local_support_point(&self, direction: DVec3) -> DVec3 {
        match &self.shape {
            PartShape::Hull(hull) => {
                let (mut best, mut support) = (f64::NEG_INFINITY, DVec3::ZERO);
                for vertex in &hull.vertices {
                    let height = vertex.dot(direction);
                    if height > best {
                        (best, support) = (height, *vertex);
                    }
                }
                support
            }
            PartShape::Cylinder { radius, half_height } => {
                let across = direction.x.hypot(direction.y);
                let z = half_height.copysign(direction.z);
                if across < 1e-300 {
                    DVec3::new(*radius, 0.0, z)
                } else {
                    DVec3::new(direction.x / across * radius, direction.y / across * radius, z)
                }
            }
            PartShape::Ball { .. } | PartShape::HalfSpace => DVec3::ZERO,
        }
    }
}

impl Hull {
    /// The hull of points relative to its centre, and that centre.
    fn try_new(points: &[DVec3]) -> Result<(Self, DVec3), &'static str> {
        if !points.iter().all(|p| p.is_finite()) {
            return Err("has a hull with a point that is not finite");
        }
        let extent = Extent::of(points).ok_or("has a flat convex hull")?;
        // A sheet whose thickness is a thousandth of its length has no hull in the tolerances of the
        // library, but the one stretched to equal extents has, and stretching keeps what is convex.
        let polyhedron = ConvexPolyhedron::from_convex_hull(points);
        let (polyhedron, all) = match polyhedron.filter(|hull| hull.faces().len() >= 4) {
            Some(hull) => {
                let all = hull.points().to_vec();
                (hull, all)
            }
            None => {
                let even: Vec<DVec3> = points.iter().map(|p| extent.to_even(*p)).collect();
                let hull = ConvexPolyhedron::from_convex_hull(&even).ok_or("has a degenerate convex hull")?;
                let all = hull.points().iter().map(|p| extent.placed(*p)).collect();
                (hull, all)
            }
        };
        let corners_of = polyhedron.vertices_adj_to_face();
        let centre = all.iter().sum::<DVec3>() / all.len() as f64;
        let mut faces = Vec::new();
        for face in polyhedron.faces() {
            let first = face.first_vertex_or_edge as usize;
            let mut corners = corners_of[first..first + face.num_vertices_or_edges as usize].to_vec();
            let area: DVec3 = (0..corners.len())
                .map(|i| {
                    let next = corners[(i + 1) % corners.len()];
                    (all[corners[i] as usize] - centre).cross(all[next as usize] - centre)
                })
                .sum();
            let Some(outward) = area.try_normalize() else { continue };
            // The winding of merged faces is not guaranteed; the centre, which is inside, decides it.
            let outside = outward.dot(all[corners[0] as usize] - centre) > 0.0;
            if !outside {
                corners.reverse();
            }
            faces.push(Face { normal: if outside { outward } else { -outward }, corners });
        }
        if faces.len() < 4 {
            return Err("has a degenerate convex hull");
        }
        Ok((Hull { vertices: all.iter().map(|v| *v - centre).collect(), faces }, centre))
    }
}

/// Extents of a cloud of points along its length, across it, and along the normal of both.
struct Extent {
    first: DVec3,
    /// Columns: the directions times the extents \[m\].
    frame: DMat3,
}

impl Extent {
    /// `None` if the points span no volume: their thickness is nothing against their length.
    fn of(points: &[DVec3]) -> Option<Self> {
        let first = *points.first()?;
        let farthest = |measure: &dyn Fn(DVec3) -> f64| {
            points.iter().copied().max_by(|p, q| measure(*p).total_cmp(&measure(*q))).unwrap_or(first)
        };
        let along = farthest(&|p| (p - first).length()) - first;
        let axis = along.try_normalize()?;
        let across = farthest(&|p| (p - first).cross(axis).length()) - first;
        let width = across.cross(axis).length();
        let normal = axis.cross(across).try_normalize()?;
        let height = |p: DVec3| (p - first).dot(normal).abs();
        let height = height(farthest(&|p| height(p)));
        let length = along.length();
        (height > FLAT * length && width > FLAT * length).then(|| Extent {
            first,
            frame: DMat3::from_cols(along, normal.cross(axis) * width, normal * height),
        })
    }

    /// A point in units of the extents.
    fn to_even(&self, point: DVec3) -> DVec3 {
        self.frame.inverse() * (point - self.first)
    }

    fn placed(&self, even: DVec3) -> DVec3 {
        self.first + self.frame * even
    }
}
