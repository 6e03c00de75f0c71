//! A scene file becomes a world: its text is decoded, its shapes are built, its mesh files are read.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::io;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use clangor_core::body::{MeshSurface, Surface, World};
use clangor_core::geometry::mend::{Mended, mend};
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::scene::body_description::{Geometry, GeometryReference};
use clangor_core::scene::diagnostic::{Doubt, Problem, SceneError, SceneErrors, SceneWarning};
use clangor_core::scene::instantiate::{GeometryError, LoadedGeometry, load_shape, references};
use clangor_core::scene::{Scene, instantiate};
use clangor_sim::fracture::Breakable;
use rayon::prelude::*;

use crate::formats::input_file::read_bounded;
use crate::formats::mesh_reader::{MeshFileError, read_mesh};
use crate::stages::breakables::breakables;
use crate::stages::collision_parts::{CollisionMesh, Collisions};
use crate::stages::gltf_node::{file_and_node, node_mesh, nodes_to_choose};
use crate::stages::impact_modes::ImpactModes;

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
    /// Those of them that may break.
    pub breakables: Vec<Breakable>,
    /// Modes of those that give way in impacts; none until
    /// [`find_impact_modes`](fn@super::find_impact_modes::find_impact_modes) has found them.
    pub modes: ImpactModes,
    /// Meshes whose convex parts collide; none have parts until
    /// [`find_collision_parts`](fn@super::find_collision_parts::find_collision_parts) has found them.
    pub collisions: Collisions,
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
    /// An animated model.
    #[error(
        "{path} is a model and not a scene; with a scene that has its planes and listeners, `clangor import \
         gltf SCENE.toml {} -o RUN.timeline` reads its motion, and `clangor render \
         RUN.timeline` makes the sound",
        if *is_blender { "EXPORTED.glb".into() } else { path.display().to_string() }
    )]
    Model {
        /// The file.
        path: PathBuf,
        /// Whether it is Blender's own format, which is exported first.
        is_blender: bool,
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

impl LoadedScene {
    /// Gives the bodies their modes, and thin bodies without modes the restitution of whole bodies, in which
    /// vibration counts.
    pub fn give_modes(&mut self, modes: ImpactModes) {
        for id in &modes.rigid {
            let material = &mut self.world.bodies[id.index()].material;
            *material = material.clone().rigid();
        }
        self.modes = modes;
    }
}

/// Reads a scene and everything that it refers to.
///
/// `adjust` may change what the text says before bodies are made of it.
///
/// # Errors
/// [`LoadError`], with every error of the scene at once.
pub fn load_scene(path: &Path, adjust: &dyn Fn(&mut Scene)) -> Result<LoadedScene, LoadError> {
    let ends_in = |ending: &str| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(ending));
    if path.is_file() && ["blend", "glb", "gltf"].into_iter().any(ends_in) {
        return Err(LoadError::Model { path: path.into(), is_blender: ends_in("blend") });
    }
    let bytes =
        read_bounded(path, MOST_TEXT).map_err(|source| LoadError::Read { path: path.into(), source })?;
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
    let folder = path.parent().unwrap_or(Path::new(""));
    let read = Scene::from_toml_with_files(&text, &mut |r| load_geometry(folder, r));
    let mut scene = match read {
        Ok(scene) => scene,
        Err(errors) => return Err(LoadError::Scene { path: path.into(), text, errors }),
    };
    adjust(&mut scene);
    loaded(path, text, scene)
}

/// A scene that was not read from a file; its mesh files are looked for in the current folder.
///
/// # Errors
/// [`LoadError::Scene`].
pub fn scene_in_memory(scene: Scene) -> Result<LoadedScene, LoadError> {
    loaded(Path::new(""), String::new(), scene)
}

/// The bodies of a scene.
fn loaded(path: &Path, text: String, mut scene: Scene) -> Result<LoadedScene, LoadError> {
    let refuse = |text: &str, errors| LoadError::Scene { path: path.into(), text: text.into(), errors };
    let folder = path.parent().unwrap_or(Path::new(""));
    // The text was judged before listeners were added to it.
    if !scene.listeners.is_empty() {
        scene.warnings.retain(|w| w.doubt != Doubt::NoListener);
    }
    let references = references(&scene);
    if references.len() > MANY_GEOMETRIES {
        refuse_too_many(&scene).map_err(|e| refuse(&text, e))?;
    }
    let geometries: BTreeMap<String, Result<Loaded, GeometryError>> =
        references.into_par_iter().map(|r| (r.to_string(), load_for_scene(folder, &r))).collect();
    let mut find = |r: &GeometryReference| match geometries.get(&r.to_string()) {
        Some(found) => found.as_ref().map(|loaded| loaded.geometry.clone()).map_err(Clone::clone),
        None => load_geometry(folder, r),
    };
    let instance = instantiate(&scene, &mut find).map_err(|e| refuse(&text, e))?;
    let warnings = scene.warnings.iter().cloned().chain(instance.warnings).collect();
    let mut world = instance.world;
    let breakables = breakables(&scene, &mut world).map_err(|e| refuse(&text, e))?;
    let meshes = geometries
        .into_values()
        .filter_map(|loaded| loaded.ok().and_then(|loaded| Some((loaded.geometry.surface, loaded.mesh?))));
    let collisions = Collisions::from_scene(&scene, &world, meshes);
    let modes = ImpactModes::default();
    Ok(LoadedScene { path: path.into(), text, world, breakables, modes, collisions, scene, warnings })
}

/// Number of distinct geometries from which on a scene is asked whether it has too many, before any is built.
const MANY_GEOMETRIES: usize = 1000;

/// Refuses more geometries than are built. [`instantiate`] does so before it loads the first one, and here
/// none can be loaded.
fn refuse_too_many(scene: &Scene) -> Result<(), SceneErrors> {
    let mut none = |_: &GeometryReference| {
        Err(GeometryError { reason: "nothing is loaded here".into(), remedy: String::new() })
    };
    match instantiate(scene, &mut none) {
        Err(SceneErrors(errors)) => {
            let too_many = |e: &SceneError| matches!(e.problem, Problem::TooManyGeometries { .. });
            let errors: Vec<SceneError> = errors.into_iter().filter(too_many).collect();
            if errors.is_empty() { Ok(()) } else { Err(SceneErrors(errors)) }
        }
        Ok(_) => Ok(()),
    }
}

/// Longest scene that is read \[bytes\].
const MOST_TEXT: u64 = 16 << 20;

/// Endings of the mesh files that can be read.
const MESH_ENDINGS: [&str; 5] = ["obj", "ply", "stl", "gltf", "glb"];

/// What a word on the command line means: a mesh file by its ending, else a shape.
pub fn geometry_reference(text: &str, scale: f64) -> GeometryReference {
    let geometry = match is_mesh_file(text.as_ref()) {
        true => Geometry::File(text.into()),
        false => Geometry::Shape(text.into()),
    };
    GeometryReference { geometry, scale, centre_of_mass: None }
}

fn is_mesh_file(word: &OsStr) -> bool {
    let (file, _) = file_and_node(word);
    let ending = Path::new(file).extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    MESH_ENDINGS.contains(&ending.as_str())
}

/// As [`load`], with a warning of a file outside the folder of the scene: who gets a scene from a stranger
/// may not want it to be read.
fn load_for_scene(folder: &Path, reference: &GeometryReference) -> Result<Loaded, GeometryError> {
    let mut loaded = load(folder, reference)?;
    if let Geometry::File(file) = &reference.geometry
        && !Path::new(file).components().all(|c| matches!(c, Component::Normal(_) | Component::CurDir))
    {
        let warning = format!("{file} lies outside the folder of the scene; was it meant to be read?");
        loaded.geometry.warnings.push(warning);
    }
    Ok(loaded)
}

/// A geometry, and the mesh of its file.
struct Loaded {
    geometry: LoadedGeometry,
    mesh: Option<CollisionMesh>,
}

/// Builds a shape, or reads a mesh file relative to `folder`. A mesh has no convex parts: only bodies that
/// collide need them ([`super::collision_parts`]).
///
/// # Errors
/// [`GeometryError`] with what to do.
pub fn load_geometry(folder: &Path, reference: &GeometryReference) -> Result<LoadedGeometry, GeometryError> {
    load(folder, reference).map(|loaded| loaded.geometry)
}

fn load(folder: &Path, reference: &GeometryReference) -> Result<Loaded, GeometryError> {
    match &reference.geometry {
        Geometry::Shape(_) => Ok(Loaded { geometry: load_shape(reference)?, mesh: None }),
        Geometry::File(file) => {
            let (geometry, mesh) = in_folder(folder, file, reference.scale)?;
            let Some(centre) = reference.centre_of_mass else {
                return Ok(Loaded { geometry, mesh: Some(mesh) });
            };
            let mesh = mesh.about(centre / reference.scale);
            Ok(Loaded { geometry: geometry.with_centre_of_mass(centre)?, mesh: Some(mesh) })
        }
    }
}

/// A mesh larger than this \[m\] was probably written in millimetres.
const HUGE: f64 = 50.0;

/// The shape or mesh file of a word on the command line, with a warning of sizes that can hardly be meant.
///
/// # Errors
/// [`GeometryError`] with what to do.
pub fn load_named(word: impl AsRef<OsStr>, scale: f64) -> Result<LoadedGeometry, GeometryError> {
    let word = word.as_ref();
    // The name of a file need not be text, that of a shape is.
    let mut loaded = match is_mesh_file(word) {
        true => load_mesh(Path::new(word), scale)?.0,
        false => {
            let geometry = Geometry::Shape(word.to_string_lossy().into_owned());
            load_shape(&GeometryReference { geometry, scale, centre_of_mass: None })?
        }
    };
    loaded.warnings.extend(size_warning(&loaded.surface));
    Ok(loaded)
}

/// What to say of a mesh that is probably in millimetres.
pub fn size_warning(surface: &Surface) -> Option<String> {
    let Surface::Mesh(mesh) = surface else { return None };
    let diagonal = mesh.mesh.diagonal();
    (diagonal > HUGE).then(|| {
        format!(
            "the body is {diagonal:.0} m across; a file in millimetres needs `scale = 0.001` (--scale 0.001)"
        )
    })
}

/// The geometry of a mesh file, or of a node of one (`FILE.glb#NODE`), and what its convex parts are made of.
///
/// # Errors
/// [`GeometryError`] with what to do.
pub fn load_mesh(path: &Path, scale: f64) -> Result<(LoadedGeometry, CollisionMesh), GeometryError> {
    if let (file, Some(node)) = file_and_node(path.as_os_str()) {
        return solid_of_mesh(&node_mesh(Path::new(file), node)?, scale);
    }
    let mesh = read_mesh(path).map_err(|error| unread(&error))?;
    solid_of_mesh(&mesh, scale).map_err(|error| match nodes_to_choose(path) {
        Some(names) => {
            GeometryError { remedy: format!("{}; or take one body of it: {names}", error.remedy), ..error }
        }
        None => error,
    })
}

/// What to do about a file that is no mesh.
fn unread(error: &MeshFileError) -> GeometryError {
    let text = error.to_string();
    let (reason, remedy) = match (error, text.rsplit_once("; ")) {
        (MeshFileError::Content { .. }, Some(both)) => both,
        (MeshFileError::Content { .. }, None) => (&*text, "export the mesh again"),
        _ => (&*text, "correct the path, or export the mesh again"),
    };
    GeometryError { reason: reason.into(), remedy: remedy.into() }
}

/// A body from a mesh file whose path is relative to the folder of a scene, as is said where it is missing.
fn in_folder(
    folder: &Path,
    file: &str,
    scale: f64,
) -> Result<(LoadedGeometry, CollisionMesh), GeometryError> {
    let path = folder.join(file);
    let is_missing = !Path::new(file_and_node(path.as_os_str()).0).is_file();
    load_mesh(&path, scale).map_err(|error| {
        let place = if is_missing { "; paths are relative to the file that names them" } else { "" };
        GeometryError { remedy: format!("{}{place}", error.remedy), ..error }
    })
}

/// A body from a triangle mesh in any frame, as if it were read from a file.
///
/// # Errors
/// [`GeometryError`] with what to do.
pub fn mesh_geometry(mesh: TriMesh, scale: f64) -> Result<LoadedGeometry, GeometryError> {
    solid_of_mesh(&mesh, scale).map(|(geometry, _)| geometry)
}

fn solid_of_mesh(mesh: &TriMesh, scale: f64) -> Result<(LoadedGeometry, CollisionMesh), GeometryError> {
    let Mended { mesh, report, mends } = mend(mesh).map_err(|e| GeometryError {
        reason: e.to_string(),
        remedy: "a body needs one closed surface that does not cross itself".into(),
    })?;
    let mass = report.mass;
    let surface = MeshSurface::of_solid(&mesh, &mass, &[]);
    let geometry = LoadedGeometry {
        surface: Arc::new(Surface::Mesh(surface).scaled(scale)),
        mass: mass.scaled(scale),
        warnings: mends.iter().map(|mend| format!("the mesh was mended: {mend}")).collect(),
    };
    Ok((geometry, CollisionMesh::new(Arc::new(mesh), mass.centre_of_mass, scale)))
}
