//! A scene file becomes a world: its text is decoded, its shapes are built, its mesh files are read.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clangor::body::World;
use clangor::scene::body_description::{Geometry, GeometryReference};
use clangor::scene::diagnostic::{SceneErrors, SceneWarning};
use clangor::scene::instantiate::{GeometryError, LoadedGeometry};
use clangor::scene::{Scene, instantiate};
use clangor::shape::Shape;

/// A scene with everything that its file refers to.
#[derive(Clone, Debug)]
pub struct LoadedScene {
    /// Where it was read.
    pub path: PathBuf,
    /// Its text.
    pub text: String,
    /// What the text says.
    pub scene: Scene,
    /// The bodies.
    pub world: World,
    /// Allowed but probably not meant.
    pub warnings: Vec<SceneWarning>,
}

/// Why a scene cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    /// The file cannot be read.
    #[error("cannot read {path}: {source}")]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// The file is not text.
    #[error("{path} is not a scene: byte {at} is not UTF-8 text")]
    NotText {
        /// The file.
        path: PathBuf,
        /// The first bad byte.
        at: usize,
    },
    /// The scene has errors.
    #[error("{path}:\n{errors}")]
    Scene {
        /// The file.
        path: PathBuf,
        /// Its text.
        text: String,
        /// All of them.
        errors: SceneErrors,
    },
}

/// Reads a scene and everything that it refers to.
///
/// `seed` replaces the seed of the scene; `adjust` may change what the text says before bodies are made of it.
///
/// # Errors
/// [`LoadError`], with every error of the scene at once.
pub fn load_scene(path: &Path, adjust: &dyn Fn(&mut Scene)) -> Result<LoadedScene, LoadError> {
    let bytes = std::fs::read(path).map_err(|source| LoadError::Read { path: path.into(), source })?;
    let text = String::from_utf8(bytes)
        .map_err(|e| LoadError::NotText { path: path.into(), at: e.utf8_error().valid_up_to() })?;
    scene_from_text(path, text, adjust)
}

/// As [`load_scene`] for a text that is already there; `path` is where its mesh files are looked for.
///
/// # Errors
/// [`LoadError`].
pub fn scene_from_text(
    path: &Path,
    text: String,
    adjust: &dyn Fn(&mut Scene),
) -> Result<LoadedScene, LoadError> {
    let refuse = |text: &str, errors| LoadError::Scene { path: path.into(), text: text.into(), errors };
    let mut scene = Scene::from_toml(&text).map_err(|e| refuse(&text, e))?;
    adjust(&mut scene);
    let folder = path.parent().unwrap_or(Path::new(""));
    let instance = instantiate(&scene, &mut |r| load_geometry(folder, r)).map_err(|e| refuse(&text, e))?;
    let warnings = scene.warnings.iter().cloned().chain(instance.warnings).collect();
    Ok(LoadedScene { path: path.into(), text, world: instance.world, scene, warnings })
}

/// Endings of the mesh files that can be read.
const MESH_ENDINGS: [&str; 5] = ["obj", "ply", "stl", "gltf", "glb"];

/// What a word on the command line means: a mesh file by its ending, else a shape.
pub fn geometry_reference(text: &str, scale: f64) -> GeometryReference {
    let ending = Path::new(text).extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    let geometry = match MESH_ENDINGS.contains(&ending.as_str()) {
        true => Geometry::File(text.into()),
        false => Geometry::Shape(text.into()),
    };
    GeometryReference { geometry, scale }
}

/// Builds a shape, or reads a mesh file relative to `folder`.
///
/// # Errors
/// [`GeometryError`] with what to do.
pub fn load_geometry(folder: &Path, reference: &GeometryReference) -> Result<LoadedGeometry, GeometryError> {
    match &reference.geometry {
        Geometry::Shape(text) => load_shape(text, reference.scale),
        Geometry::File(file) => Err(GeometryError {
            reason: format!("{} mesh", folder.join(file).display()),
            remedy: String::new(),
        }),
    }
}

fn load_shape(text: &str, scale: f64) -> Result<LoadedGeometry, GeometryError> {
    let shape = Shape::parse(text).map_err(|e| GeometryError {
        reason: e.to_string(),
        remedy: "correct the shape; docs/format/scene.md lists them".into(),
    })?;
    let (surface, mass) = shape.surface().map_err(|e| GeometryError {
        reason: e.to_string(),
        remedy: "choose another edge length with @EDGE".into(),
    })?;
    let (surface, mass) = (surface.scaled(scale), mass.scaled(scale));
    Ok(LoadedGeometry { surface: Arc::new(surface), mass, warnings: Vec::new() })
}
