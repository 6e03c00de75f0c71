//! A closed triangle surface about its centre of mass, with what contact and collision ask of it: the nearest
//! point, the normal, the distance, and the curvature between the vertices.

use glam::DVec3;

use crate::geometry::convex::ConvexPart;
use crate::geometry::curvature::mean_curvature;
use crate::geometry::mass_properties::MassProperties;
use crate::geometry::principal_curvature::Curvature;
use crate::geometry::sharp_place::SharpPlace;
use crate::geometry::solid::{MeshError, check_solid};
use crate::geometry::surface_tree::{NearestPoint, SurfaceTree};
use crate::geometry::tri_mesh::TriMesh;
use crate::geometry::vertex_curvature::{self, principal_curvatures};

/// A closed triangle surface with the data for contact and collision.
#[derive(Clone, Debug)]
pub struct MeshSurface {
    /// The surface; the origin is the centre of mass of the body.
    pub mesh: TriMesh,
    /// Mean curvature H = (κ₁+κ₂)/2 at each vertex [1/m], positive where convex: a sphere has 1/R.
    pub mean_curvature: Vec<f64>,
    /// Principal curvatures at each vertex, whose mean is not exactly `mean_curvature`.
    pub curvature: Vec<Curvature>,
    /// Convex parts whose union collides; none where nothing collides.
    pub parts: Vec<ConvexPart>,
    /// Volume \[m³\].
    pub volume: f64,
    /// Of the homogeneous solid at unit density, in this frame; `None` if the mesh bounds no solid.
    solid: Option<MassProperties>,
    /// Search tree for the nearest triangle.
    tree: SurfaceTree,
}

/// What follows from the mesh does not count: the integrals of a form are sharper than those of its facets.
impl PartialEq for MeshSurface {
    fn eq(&self, other: &Self) -> bool {
        let MeshSurface { mesh, mean_curvature, curvature, parts, volume, solid: _, tree: _ } = self;
        (mesh, mean_curvature, curvature, parts, volume)
            == (&other.mesh, &other.mean_curvature, &other.curvature, &other.parts, &other.volume)
    }
}

impl MeshSurface {
    /// Moves a closed mesh and its convex collision parts to the centre of mass, and prepares the contact
    /// queries. The mass properties are those of unit density in the frame of `mesh`.
    ///
    /// # Errors
    /// [`MeshError`] if the mesh does not bound a solid.
    pub fn try_new(mesh: TriMesh, parts: Vec<ConvexPart>) -> Result<(Self, MassProperties), MeshError> {
        let mass = check_solid(&mesh)?.mass;
        Ok((Self::of_solid(&mesh, &mass, &parts), mass))
    }

    /// As [`try_new`](Self::try_new) for a mesh that is known to bound a solid of these mass properties.
    pub fn of_solid(mesh: &TriMesh, mass: &MassProperties, parts: &[ConvexPart]) -> Self {
        let mesh = mesh.relative_to(mass.centre_of_mass);
        let parts = parts.iter().map(|p| p.relative_to(mass.centre_of_mass)).collect();
        let tree = SurfaceTree::new(&mesh);
        let mean_curvature = mean_curvature(&mesh);
        let curvature = principal_curvatures(&mesh);
        let solid = Some(MassProperties { centre_of_mass: DVec3::ZERO, ..*mass });
        MeshSurface { mesh, mean_curvature, curvature, parts, volume: mass.volume, solid, tree }
    }

    /// A surface as a timeline stores it: centred, with the mean curvature [1/m] per vertex, which holds in
    /// all directions, and the volume \[m³\], and without the parts that only collisions need.
    pub fn restored(mesh: TriMesh, mean_curvature: Vec<f64>, volume: f64) -> Self {
        let tree = SurfaceTree::new(&mesh);
        let curvature = mean_curvature.iter().map(|h| Curvature::isotropic(*h)).collect();
        let solid = MassProperties::of(&mesh).ok();
        MeshSurface { mesh, mean_curvature, curvature, parts: Vec::new(), volume, solid, tree }
    }

    /// The same surface with other convex parts, in its own frame.
    #[must_use]
    pub fn with_parts(self, parts: Vec<ConvexPart>) -> Self {
        MeshSurface { parts, ..self }
    }

    /// The same surface with other principal curvatures, one for each vertex.
    #[must_use]
    pub fn with_curvature(self, curvature: Vec<Curvature>) -> Self {
        MeshSurface { curvature, ..self }
    }

    /// The same surface with its origin at `origin` \[m\], a point in its present frame.
    pub fn relative_to(&self, origin: DVec3) -> Self {
        let mesh = self.mesh.relative_to(origin);
        let tree = SurfaceTree::new(&mesh);
        let parts = self.parts.iter().map(|part| part.relative_to(origin)).collect();
        let shifted =
            |mass: MassProperties| MassProperties { centre_of_mass: mass.centre_of_mass - origin, ..mass };
        MeshSurface { mesh, parts, tree, solid: self.solid.map(shifted), ..self.clone() }
    }

    /// The same surface with all lengths multiplied by `factor`.
    pub fn scaled(mut self, factor: f64) -> Self {
        self.mesh.vertices.iter_mut().for_each(|v| *v *= factor);
        self.mean_curvature.iter_mut().for_each(|h| *h /= factor);
        self.curvature.iter_mut().for_each(|c| *c = c.scaled(factor));
        self.parts = self.parts.iter().map(|p| p.scaled(factor)).collect();
        self.volume *= factor.powi(3);
        self.solid = self.solid.map(|solid| solid.scaled(factor));
        self.tree = SurfaceTree::new(&self.mesh);
        self
    }

    /// Mass properties of the homogeneous solid at unit density, in this frame; `None` for an open surface.
    pub fn solid(&self) -> Option<MassProperties> {
        self.solid
    }

    /// Mean curvature [1/m] at the point of the surface nearest to `point_body`, interpolated between the
    /// vertices.
    pub fn mean_curvature_at(&self, point_body: DVec3) -> f64 {
        self.tree.nearest(&self.mesh, point_body).map_or(0.0, |nearest| {
            let corners = self.mesh.triangles[nearest.triangle];
            (0..3).map(|k| nearest.weights[k] * self.mean_curvature[corners[k] as usize]).sum()
        })
    }

    /// Principal curvatures at the point of the surface nearest to `point_body`, on its own side of any sharp
    /// edge.
    pub fn curvature_at(&self, point_body: DVec3) -> Curvature {
        let Some(nearest) = self.tree.nearest(&self.mesh, point_body) else { return Curvature::FLAT };
        vertex_curvature::curvature_at(&self.mesh, &self.tree, &self.curvature, &nearest)
    }

    /// The crease or corner within `tolerance` \[m\] of the point of the surface nearest to `point_body`.
    pub fn sharp_place_at(&self, point_body: DVec3, tolerance: f64) -> Option<SharpPlace> {
        let nearest = self.tree.nearest(&self.mesh, point_body)?;
        self.tree.sharp_place(&self.mesh, &nearest, tolerance)
    }

    /// The point of the surface nearest to `point_body`; `None` without triangles.
    pub fn nearest(&self, point_body: DVec3) -> Option<NearestPoint> {
        self.tree.nearest(&self.mesh, point_body)
    }

    /// Outward unit normal at the point of the surface nearest to `point_body`; `None` for an open surface.
    pub fn normal_at(&self, point_body: DVec3) -> Option<DVec3> {
        self.tree.outward_normal(&self.mesh, point_body)
    }

    /// The same at a point of the surface that is known.
    pub fn normal_of(&self, nearest: &NearestPoint) -> Option<DVec3> {
        self.tree.outward_normal_of(&self.mesh, nearest)
    }

    /// Distance of `point_body` from the surface \[m\], negative inside.
    pub fn signed_distance(&self, point_body: DVec3) -> f64 {
        self.tree.signed_distance(&self.mesh, point_body).unwrap_or(f64::INFINITY)
    }

    /// Whether `point_body` lies inside the solid.
    pub fn contains(&self, point_body: DVec3) -> bool {
        self.signed_distance(point_body) < 0.0
    }
}
