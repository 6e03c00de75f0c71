//! A folder of baked sound models, so that no body is baked twice.
//!
//! An entry is a model file named by the hash of everything that it depends on: the geometry, the band, the options and the
//! versions of format and solvers; not the material, which no field depends on. It appears under its name only when it
//! is whole ([`write_atomically`]), so that a process may be killed at any moment, and several may bake the same model.
//! What is read is verified and belongs to the hash in its name, or is baked again: an entry is never trusted.
//!
//! Beside the entries are the frequencies that long bakes have solved so far, `acceleration-HASH.partial`, under the same
//! promises; they go when the entry comes.

mod partial_bake;

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use clangor::geometry::meridian::Piece;
use clangor::model::model_file::{ModelFile, VERSION};
use clangor::model::tensor_file::TensorFileError;
use clangor_bake::acceleration_noise::{BakeGeometry, BakeOptions, Method, SolvedFrequency};
use twox_hash::xxhash3_128::Hasher;

use crate::atomic_file::{OutputError, write_atomically};

/// To be raised when a change to the solvers changes what they compute by more than their accuracy.
const SOLVERS: u32 = 1;
/// A partial entry this old belongs to a process that was killed: writing one takes seconds.
const ABANDONED: Duration = Duration::from_secs(3600);
/// What was solved of a bake that nobody took up again for so long is given up.
const GIVEN_UP: Duration = Duration::from_secs(30 * 24 * 3600);

/// Why an entry could not be kept; the model itself is none the worse.
#[derive(Debug, thiserror::Error)]
pub enum CacheError {
    /// The folder cannot be made.
    #[error(
        "the cache folder {folder} cannot be made: {source}; choose another with --cache or CLANGOR_CACHE"
    )]
    Folder {
        /// The folder.
        folder: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// The entry cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The model cannot be stored.
    #[error("the model cannot be stored: {0}")]
    Model(#[from] TensorFileError),
}

/// What is in the cache under a key.
#[derive(Debug)]
pub enum Lookup {
    /// A verified model.
    Found(Box<ModelFile>),
    /// Nothing.
    Missing,
    /// Something that is not the model, and why.
    Invalid(String),
}

/// A folder of models.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ModelCache {
    folder: PathBuf,
}

impl ModelCache {
    /// The cache in this folder, which need not exist yet.
    pub fn new(folder: impl Into<PathBuf>) -> Self {
        ModelCache { folder: folder.into() }
    }

    /// The cache in the folder that `asked` names, else that of the environment: `CLANGOR_CACHE`, or `clangor` in the
    /// platform's folder for caches. `None` where the system has no such folder.
    pub fn find(asked: Option<&Path>) -> Option<Self> {
        let variable =
            |name: &str| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
        let platform = || {
            if cfg!(windows) {
                variable("LOCALAPPDATA").map(|folder| folder.join("clangor").join("cache"))
            } else if cfg!(target_os = "macos") {
                variable("HOME").map(|home| home.join("Library/Caches/clangor"))
            } else {
                // The standard of the XDG wants relative paths ignored.
                variable("XDG_CACHE_HOME")
                    .filter(|folder| folder.is_absolute())
                    .or_else(|| variable("HOME").map(|home| home.join(".cache")))
                    .map(|folder| folder.join("clangor"))
            }
        };
        let folder = asked.map(Path::to_path_buf).or_else(|| variable("CLANGOR_CACHE")).or_else(platform)?;
        Some(ModelCache { folder })
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Where the entry of a key is, or would be.
    pub fn path(&self, key: &str) -> PathBuf {
        self.folder.join(format!("acceleration-{key}.safetensors"))
    }

    fn partial_path(&self, key: &str) -> PathBuf {
        self.folder.join(format!("acceleration-{key}.partial"))
    }

    /// The frequencies that an interrupted bake has solved; none if they cannot be used.
    pub fn read_partial(&self, key: &str) -> Vec<SolvedFrequency> {
        let bytes = fs::read(self.partial_path(key)).ok();
        bytes.and_then(|bytes| partial_bake::decode(key, &bytes)).unwrap_or_default()
    }

    /// Keeps the frequencies that a bake has solved so far.
    ///
    /// # Errors
    /// [`CacheError`]; those kept before are untouched then.
    pub fn write_partial(&self, key: &str, solved: &[SolvedFrequency]) -> Result<(), CacheError> {
        self.make_folder()?;
        Ok(write_atomically(&self.partial_path(key), &partial_bake::encode(key, solved))?)
    }

    /// Forgets them: the model is there. What remains is removed when it is old.
    pub fn remove_partial(&self, key: &str) {
        let _ = fs::remove_file(self.partial_path(key));
    }

    fn make_folder(&self) -> Result<(), CacheError> {
        fs::create_dir_all(&self.folder)
            .map_err(|source| CacheError::Folder { folder: self.folder.clone(), source })
    }

    /// Looks an entry up and verifies it.
    pub fn read(&self, key: &str) -> Lookup {
        let path = self.path(key);
        let bytes = match fs::read(&path) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Lookup::Missing,
            Err(error) => return Lookup::Invalid(format!("{} cannot be read: {error}", path.display())),
        };
        match ModelFile::decode(&bytes) {
            Ok(model) if model.origin.inputs == key => Lookup::Found(Box::new(model)),
            Ok(model) => Lookup::Invalid(format!(
                "{} is the model of other inputs, {}",
                path.display(),
                model.origin.inputs
            )),
            Err(error) => Lookup::Invalid(format!("{} is not valid: {error}", path.display())),
        }
    }

    /// Keeps a model under the hash of its inputs, in place of what is there.
    ///
    /// # Errors
    /// [`CacheError`]; whatever was there before is untouched then.
    pub fn write(&self, model: &ModelFile) -> Result<PathBuf, CacheError> {
        let bytes = model.encode()?;
        self.make_folder()?;
        self.remove_abandoned();
        let path = self.path(&model.origin.inputs);
        write_atomically(&path, &bytes)?;
        Ok(path)
    }

    /// Removes what processes that were killed have left. Failures matter to nobody: the next writer tries again.
    fn remove_abandoned(&self) {
        let entries = fs::read_dir(&self.folder).into_iter().flatten().flatten();
        for entry in entries {
            let name = entry.file_name();
            let name = name.to_string_lossy();
            let longest = if name.contains(".part-") {
                ABANDONED
            } else if name.ends_with(".partial") {
                GIVEN_UP
            } else {
                continue;
            };
            let age = entry.metadata().and_then(|m| m.modified()).ok().and_then(|t| t.elapsed().ok());
            if age.is_some_and(|age| age > longest) {
                let _ = fs::remove_file(entry.path());
            }
        }
    }
}

/// The hash of everything that a baked model depends on, 32 hexadecimal digits. Where it was computed is none of it: what
/// comes from either device is equal to well below any accuracy.
pub fn model_key(geometry: &BakeGeometry, options: &BakeOptions) -> String {
    let mut inputs = Inputs(Hasher::new());
    inputs.text("acceleration");
    inputs.whole(VERSION.into());
    inputs.whole(SOLVERS.into());
    inputs.geometry(geometry);
    inputs.number(options.max_wavenumber);
    inputs.number(options.accuracy);
    inputs.text(match options.method {
        Method::Auto => "auto",
        Method::Bem => "bem",
        Method::Fdtd => "fdtd",
    });
    inputs.whole(options.near_field.into());
    format!("{:032x}", inputs.0.finish_128())
}

/// Hashes numbers bit by bit.
struct Inputs(Hasher);

impl Inputs {
    /// A word, after its length, so that words do not run into each other.
    fn text(&mut self, text: &str) {
        self.whole(text.len() as u64);
        self.0.write(text.as_bytes());
    }

    fn whole(&mut self, number: u64) {
        self.0.write(&number.to_le_bytes());
    }

    fn number(&mut self, number: f64) {
        // −0 is 0.
        self.0.write(&(number + 0.0).to_le_bytes());
    }

    fn geometry(&mut self, geometry: &BakeGeometry) {
        match geometry {
            BakeGeometry::Ellipsoid { semi_axes } => {
                self.text("ellipsoid");
                semi_axes.to_array().into_iter().for_each(|a| self.number(a));
            }
            BakeGeometry::RoundedBox { edges, round } => {
                self.text("rounded box");
                edges.to_array().into_iter().for_each(|e| self.number(e));
                self.number(*round);
            }
            BakeGeometry::Revolution(meridian) => {
                self.text("revolution");
                self.whole(meridian.pieces().len() as u64);
                meridian.pieces().iter().for_each(|piece| self.piece(piece));
            }
            BakeGeometry::Mesh(mesh) => {
                self.text("mesh");
                self.whole(mesh.vertices.len() as u64);
                mesh.vertices.iter().flat_map(|v| v.to_array()).for_each(|x| self.number(x));
                self.whole(mesh.triangles.len() as u64);
                mesh.triangles.iter().flatten().for_each(|i| self.whole((*i).into()));
            }
        }
    }

    fn piece(&mut self, piece: &Piece) {
        let numbers = match *piece {
            Piece::Line { from, to } => {
                self.text("line");
                [from.x, from.y, to.x, to.y, 0.0, 0.0]
            }
            Piece::Arc { centre, semi_axes, from, to } => {
                self.text("arc");
                [centre.x, centre.y, semi_axes.x, semi_axes.y, from, to]
            }
        };
        numbers.into_iter().for_each(|n| self.number(n));
    }
}
