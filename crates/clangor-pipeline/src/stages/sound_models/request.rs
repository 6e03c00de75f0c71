//! A request for one part of the sound model of a body: what is baked, how, and under which key it is kept.

use std::collections::VecDeque;
use std::sync::{Mutex, PoisonError};

use clangor_bake::geometry_class::bake_geometry::BakeGeometry;
use clangor_core::body::{Body, Surface};
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::glam::DVec3;
use clangor_core::sound_model::files::model_file::Solid;

/// Meshes whose forms are kept.
const KEPT: usize = 16;

/// A request for the part `P` of a sound model: the field of acceleration
/// ([`AccelerationBake`](super::acceleration_bake::AccelerationBake)) or the modes
/// ([`ModalBake`](super::modal_bake::ModalBake)).
#[derive(Clone, Debug, PartialEq)]
pub struct SoundModelRequest<P> {
    /// What radiates.
    pub(super) geometry: BakeGeometry,
    /// The solid, as the file describes it.
    pub(super) solid: Solid,
    /// The part, and how it is baked.
    pub(super) part: P,
    /// Hash of geometry and part.
    pub(super) key: String,
}

/// A part of a sound model that is baked by itself.
pub trait RequestedPart {
    /// Hash of the geometry and everything else that the result depends on.
    fn key(&self, geometry: &BakeGeometry) -> String;

    /// Its draft.
    #[must_use]
    fn draft(&self) -> Self;

    /// The same, if it takes no more than this CPU time \[s\].
    #[must_use]
    fn within(&self, seconds: f64) -> Self;

    /// Operations that a bake takes, estimated.
    fn operations(&self, geometry: &BakeGeometry) -> f64;
}

/// Why a body has no sound model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RequestError {
    /// It is the ground.
    #[error("a half-space does not move, and has no sound of its own")]
    HalfSpace,
}

impl<P: RequestedPart> SoundModelRequest<P> {
    /// A request for a solid about its centre of mass; `name` is its name in the file.
    ///
    /// # Errors
    /// [`RequestError`].
    pub fn new(name: &str, surface: &Surface, mass: MassProperties, part: P) -> Result<Self, RequestError> {
        let (geometry, mesh) = radiating(surface)?;
        let key = part.key(&geometry);
        Ok(SoundModelRequest { geometry, solid: Solid { name: name.into(), mass, surface: mesh }, part, key })
    }

    /// A request for a body of a scene or a timeline.
    ///
    /// # Errors
    /// [`RequestError`].
    pub fn of_body(body: &Body, part: P) -> Result<Self, RequestError> {
        SoundModelRequest::new(&body.name, &body.surface, body.homogeneous(), part)
    }
}

impl<P: RequestedPart> SoundModelRequest<P> {
    /// The same solid with the part baked in another way.
    #[must_use]
    pub fn with_part(&self, part: P) -> Self {
        let SoundModelRequest { geometry, solid, .. } = self;
        let key = part.key(geometry);
        SoundModelRequest { geometry: geometry.clone(), solid: solid.clone(), part, key }
    }
}

impl<P> SoundModelRequest<P> {
    /// What radiates.
    pub fn geometry(&self) -> &BakeGeometry {
        &self.geometry
    }

    /// Hash of what the result depends on: bodies of the same key share it.
    pub fn key(&self) -> &str {
        &self.key
    }

    /// How it is baked.
    pub fn part(&self) -> &P {
        &self.part
    }

    /// Name of the solid.
    pub fn name(&self) -> &str {
        &self.solid.name
    }
}

/// What radiates, and its mesh if it has one.
pub(crate) fn radiating(surface: &Surface) -> Result<(BakeGeometry, Option<TriMesh>), RequestError> {
    match surface {
        Surface::HalfSpace | Surface::Plate { .. } => Err(RequestError::HalfSpace),
        Surface::Sphere { radius } => {
            Ok((BakeGeometry::Ellipsoid { semi_axes: DVec3::splat(*radius) }, None))
        }
        Surface::Mesh(surface) => {
            let mesh = &surface.mesh;
            Ok((recognised(mesh), Some(mesh.clone())))
        }
    }
}

/// [`BakeGeometry::of_mesh`] of the last [`KEPT`] meshes is kept: click, ringing and the modes of impacts ask
/// for the same body, and its form takes a second to recognise.
pub(super) fn recognised(mesh: &TriMesh) -> BakeGeometry {
    static LAST: Mutex<VecDeque<(TriMesh, BakeGeometry)>> = Mutex::new(VecDeque::new());
    let known = |last: &VecDeque<(TriMesh, BakeGeometry)>| {
        last.iter().find(|(other, _)| other == mesh).map(|(_, geometry)| geometry.clone())
    };
    // A panic elsewhere leaves whole entries.
    if let Some(geometry) = known(&LAST.lock().unwrap_or_else(PoisonError::into_inner)) {
        return geometry;
    }
    let geometry = BakeGeometry::of_mesh(mesh);
    let mut last = LAST.lock().unwrap_or_else(PoisonError::into_inner);
    last.push_back((mesh.clone(), geometry.clone()));
    if last.len() > KEPT {
        last.pop_front();
    }
    geometry
}
