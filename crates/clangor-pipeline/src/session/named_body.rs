//! A solid named by a word: a shape of the library, a mesh file, a node of a glTF file (`FILE.glb#NODE`), or
//! a body in one with the sound of its bodies (`KHR_audio_rigid_bodies`): `FILE.glb`, or `FILE.glb#BODY`.

use std::ffi::OsStr;
use std::path::Path;

use clangor_core::material::{Material, presets};
use clangor_core::scene::instantiate::LoadedGeometry;
use clangor_core::sound_model::modal::model::ModalModel;

use super::error::Error;
use crate::interchange::audio_rigid_bodies::{Played, choose_body, read_audio_bodies};
use crate::stages::gltf_node::{file_and_node, is_gltf_file};
use crate::stages::load::{load_named, mesh_geometry};

/// The material preset of a name.
///
/// # Errors
/// [`Error::Material`].
pub fn preset(name: &str) -> Result<Material, Error> {
    presets::preset(name).ok_or_else(|| Error::Material {
        name: name.into(),
        known: presets::names().collect::<Vec<_>>().join(", "),
    })
}

/// A shape of the library (`"bowl"`, `"box:0.3x0.03x0.01"`), or a mesh file whose unit is `scale` metres.
///
/// # Errors
/// [`Error::Geometry`].
pub(super) fn shape_or_mesh(word: &OsStr, scale: f64) -> Result<LoadedGeometry, Error> {
    load_named(word, scale).map_err(|source| Error::Geometry { name: word.to_string_lossy().into(), source })
}

/// The warnings of a geometry, with its name.
pub(super) fn geometry_remarks(word: &str, geometry: &LoadedGeometry) -> Vec<String> {
    geometry.warnings.iter().map(|warning| format!("\"{word}\": {warning}")).collect()
}

/// A body of a glTF file that gives its material.
#[derive(Clone, Debug, PartialEq)]
pub struct GltfBody {
    /// Surface and mass properties of unit density.
    pub geometry: LoadedGeometry,
    /// The material, with the mass and the decays of the file.
    pub material: Material,
    /// Its modes about the centre of mass, without transfers, if the file has them.
    pub modal: Option<ModalModel>,
    /// Properties of the file that are not used, or replaced.
    pub remarks: Vec<String>,
}

impl GltfBody {
    /// Reads the body that a word names; `None` if the word names no such file, or a file without such
    /// bodies. `otherwise` has the properties of the material that the file lacks.
    ///
    /// # Errors
    /// [`Error::AudioFile`], [`Error::AudioBody`], [`Error::AudioMaterial`] and [`Error::Geometry`].
    pub fn read(
        word: impl AsRef<OsStr>,
        scale: f64,
        otherwise: Option<&Material>,
    ) -> Result<Option<Self>, Error> {
        let word = word.as_ref();
        let name = &*word.to_string_lossy();
        let (file, body) = file_and_node(word);
        let bodies = read_audio_bodies(Path::new(file))?;
        let Some(body) = choose_body(bodies, body, &file.to_string_lossy())? else { return Ok(None) };
        let body = body.scaled(scale);
        let geometry = mesh_geometry(body.mesh.clone(), 1.0)
            .map_err(|source| Error::Geometry { name: name.into(), source })?;
        let Played { material, modal, remarks } = body
            .played(&geometry.mass, otherwise)
            .map_err(|source| Error::AudioMaterial { name: name.into(), source })?;
        let of_file = remarks.iter().map(|remark| format!("\"{name}\": {remark}"));
        let remarks = geometry_remarks(name, &geometry).into_iter().chain(of_file).collect();
        Ok(Some(GltfBody { geometry, material, modal, remarks }))
    }
}

/// A solid to bake, with what is known of its material and its modes.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedSolid {
    /// The word as text.
    pub name: String,
    /// Surface and mass properties of unit density.
    pub geometry: LoadedGeometry,
    /// The material, which only the modal part needs.
    pub material: Option<Material>,
    /// Modes about the centre of mass, without transfers, if a glTF file has them.
    pub modal: Option<ModalModel>,
    /// Mends of its mesh, and properties of a glTF file that are not used, or replaced.
    pub remarks: Vec<String>,
}

impl NamedSolid {
    /// A shape of the library, a mesh file whose unit is `scale` metres, or a body of a glTF file, whose
    /// material comes before the given one.
    ///
    /// # Errors
    /// [`Error::BakeGeometry`], and those of [`GltfBody::read`].
    pub fn open(word: impl AsRef<OsStr>, scale: f64, material: Option<Material>) -> Result<Self, Error> {
        let word = word.as_ref();
        let name = word.to_string_lossy().into_owned();
        if let Some(file) = GltfBody::read(word, scale, material.as_ref())? {
            let GltfBody { geometry, material, modal, remarks } = file;
            return Ok(NamedSolid { name, geometry, material: Some(material), modal, remarks });
        }
        let geometry =
            load_named(word, scale).map_err(|source| Error::BakeGeometry { name: name.clone(), source })?;
        let remarks = geometry_remarks(&name, &geometry);
        Ok(NamedSolid { name, geometry, material, modal: None, remarks })
    }
}

/// Whether a path is that of a glTF file, or of a body in one.
pub fn is_gltf(path: &Path) -> bool {
    is_gltf_file(file_and_node(path.as_os_str()).0)
}
