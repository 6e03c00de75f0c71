//! A folder of baked sound models, so that no body is baked twice.
//!
//! An entry is a file named by the hash of everything that it depends on: the geometry, the band, the options
//! and the versions of format and solvers; ringing also on the elasticity and the medium, on which clicks do
//! not. It appears under its name only when it is whole ([`write_atomically`]), so that a process may be
//! killed at any moment, and several may bake the same model. What is read is verified and belongs to the
//! hash in its name, or is baked again: an entry is never trusted.
//!
//! Beside the entries is what long bakes have so far, under the same promises: `acceleration-HASH.partial`
//! the frequencies that are solved, `modal-HASH.partial` the modes whose sound is not. They go when the entry
//! comes.
//!
//! The convex parts with which meshes collide are kept in the same way, as `collision-HASH.parts`.

mod collision_parts;
mod key;
mod partial_bake;

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use clangor_bake::acceleration::SolvedFrequency;
use clangor_core::sound_model::files::modal_file::ModalFile;
use clangor_core::sound_model::files::modal_soundbank_file::ModalSoundbankFile;
use clangor_core::sound_model::files::model_file::ModelFile;
use clangor_core::sound_model::files::tensor_file::TensorFileError;
use clangor_sim::decompose::Decomposition;

use crate::formats::atomic_file::{OutputError, part, write_atomically};
pub use key::{collision_parts_key, given_modes_key, modal_key, modal_soundbank_key, model_key};

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

/// A file that the cache keeps: one kind for each part of a sound model, one for banks of ringing ellipsoids.
pub trait CacheEntry: Sized {
    /// Beginning of the name of its files.
    const PREFIX: &'static str;

    /// Reads and verifies the content of a file.
    ///
    /// # Errors
    /// [`TensorFileError`].
    fn decode(bytes: &[u8]) -> Result<Self, TensorFileError>;

    /// The content of a file.
    ///
    /// # Errors
    /// [`TensorFileError`].
    fn encode(&self) -> Result<Vec<u8>, TensorFileError>;

    /// Hash of what it was baked from.
    fn key(&self) -> &str;
}

impl CacheEntry for ModelFile {
    const PREFIX: &'static str = "acceleration";

    fn decode(bytes: &[u8]) -> Result<Self, TensorFileError> {
        ModelFile::decode(bytes)
    }

    fn encode(&self) -> Result<Vec<u8>, TensorFileError> {
        ModelFile::encode(self)
    }

    fn key(&self) -> &str {
        &self.origin.inputs
    }
}

impl CacheEntry for ModalFile {
    const PREFIX: &'static str = "modal";

    fn decode(bytes: &[u8]) -> Result<Self, TensorFileError> {
        ModalFile::decode(bytes)
    }

    fn encode(&self) -> Result<Vec<u8>, TensorFileError> {
        ModalFile::encode(self)
    }

    fn key(&self) -> &str {
        &self.modal.origin.inputs
    }
}

impl CacheEntry for ModalSoundbankFile {
    const PREFIX: &'static str = "modal-bank";

    fn decode(bytes: &[u8]) -> Result<Self, TensorFileError> {
        ModalSoundbankFile::decode(bytes)
    }

    fn encode(&self) -> Result<Vec<u8>, TensorFileError> {
        ModalSoundbankFile::encode(self)
    }

    fn key(&self) -> &str {
        &self.origin.inputs
    }
}

/// What is in the cache under a key.
#[derive(Debug)]
pub enum Lookup<M = ModelFile> {
    /// A verified model.
    Found(Box<M>),
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

    /// The cache in the folder that `asked` names, else that of the environment: `CLANGOR_CACHE`, or
    /// `clangor` in the platform's folder for caches. `None` where the system has no such folder. Removes
    /// the temporary files of killed processes.
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
        let cache = ModelCache { folder };
        cache.remove_temporary_files();
        Some(cache)
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Where the entry of a key is, or would be.
    pub fn path<M: CacheEntry>(&self, key: &str) -> PathBuf {
        self.folder.join(format!("{}-{key}.safetensors", M::PREFIX))
    }

    /// Where an unfinished bake of a key keeps what it has.
    fn partial_path<M: CacheEntry>(&self, key: &str) -> PathBuf {
        self.folder.join(format!("{}-{key}.partial", M::PREFIX))
    }

    /// The frequencies that an interrupted bake has solved; none if they cannot be used.
    pub fn read_partial(&self, key: &str) -> Vec<SolvedFrequency> {
        let bytes = fs::read(self.partial_path::<ModelFile>(key)).ok();
        bytes.and_then(|bytes| partial_bake::decode(key, &bytes)).unwrap_or_default()
    }

    /// Keeps the frequencies that a bake has solved so far.
    ///
    /// # Errors
    /// [`CacheError`]; those kept before are untouched then.
    pub fn write_partial(&self, key: &str, solved: &[SolvedFrequency]) -> Result<(), CacheError> {
        self.make_folder()?;
        Ok(write_atomically(&self.partial_path::<ModelFile>(key), &partial_bake::encode(key, solved))?)
    }

    fn make_folder(&self) -> Result<(), CacheError> {
        fs::create_dir_all(&self.folder)
            .map_err(|source| CacheError::Folder { folder: self.folder.clone(), source })
    }

    /// Looks an entry up and verifies it. What an unfinished bake of a model that is there has left is
    /// removed: a process may have been killed after it wrote the entry, or while another wrote it.
    pub fn read<M: CacheEntry>(&self, key: &str) -> Lookup<M> {
        let found = read_entry(&self.path::<M>(key), key);
        if let Lookup::Found(_) = found {
            let _ = fs::remove_file(self.partial_path::<M>(key));
        }
        found
    }

    /// The modes that an interrupted bake has found; nothing if they cannot be used.
    pub fn read_modes(&self, key: &str) -> Option<ModalFile> {
        match read_entry(&self.partial_path::<ModalFile>(key), key) {
            Lookup::Found(file) => Some(*file),
            _ => None,
        }
    }

    /// Keeps the modes of a body while their sound is computed.
    ///
    /// # Errors
    /// [`CacheError`].
    pub fn write_modes(&self, file: &ModalFile) -> Result<(), CacheError> {
        let bytes = file.encode()?;
        self.make_folder()?;
        Ok(write_atomically(&self.partial_path::<ModalFile>(file.key()), &bytes)?)
    }

    /// Keeps an entry under the hash of its inputs, in place of what is there, and removes what its
    /// unfinished bake kept.
    ///
    /// # Errors
    /// [`CacheError`]; whatever was there before is untouched then.
    pub fn write<M: CacheEntry>(&self, entry: &M) -> Result<PathBuf, CacheError> {
        let path = self.path::<M>(entry.key());
        self.write_entry(&path, &entry.encode()?)?;
        let _ = fs::remove_file(self.partial_path::<M>(entry.key()));
        Ok(path)
    }

    fn collision_parts_path(&self, key: &str) -> PathBuf {
        self.folder.join(format!("collision-{key}.parts"))
    }

    /// Looks up the convex parts of a mesh.
    pub fn read_collision_parts(&self, key: &str) -> Lookup<Decomposition> {
        let path = self.collision_parts_path(key);
        match fs::read(&path) {
            Ok(bytes) => match collision_parts::decode(key, &bytes) {
                Some(parts) => Lookup::Found(Box::new(parts)),
                None => Lookup::Invalid(format!("{} is not valid", path.display())),
            },
            Err(error) if error.kind() == io::ErrorKind::NotFound => Lookup::Missing,
            Err(error) => Lookup::Invalid(format!("{} cannot be read: {error}", path.display())),
        }
    }

    /// Keeps the convex parts of a mesh.
    ///
    /// # Errors
    /// [`CacheError`]; whatever was there before is untouched then.
    pub fn write_collision_parts(&self, key: &str, parts: &Decomposition) -> Result<(), CacheError> {
        self.write_entry(&self.collision_parts_path(key), &collision_parts::encode(key, parts))
    }

    fn write_entry(&self, path: &Path, bytes: &[u8]) -> Result<(), CacheError> {
        self.make_folder()?;
        self.remove_temporary_files();
        self.remove_given_up();
        Ok(write_atomically(path, bytes)?)
    }

    /// Removes the temporary files of processes that were killed. Failures are ignored: the next process
    /// tries again.
    fn remove_temporary_files(&self) {
        for path in self.files_with(|name| name.contains(".part-")) {
            part::remove_abandoned(&path);
        }
    }

    /// Removes what was solved of bakes that nobody took up again for long. Only where an entry is written:
    /// a run that writes nothing may be about to use the modes in such a file.
    fn remove_given_up(&self) {
        for path in self.files_with(|name| name.ends_with(".partial")) {
            let age = fs::metadata(&path).and_then(|m| m.modified()).ok().and_then(|t| t.elapsed().ok());
            if age.is_some_and(|age| age > GIVEN_UP) {
                let _ = fs::remove_file(&path);
            }
        }
    }

    /// The files of the folder whose names are so.
    fn files_with(&self, wanted: impl Fn(&str) -> bool) -> Vec<PathBuf> {
        let entries = fs::read_dir(&self.folder).into_iter().flatten().flatten();
        let chosen = entries.filter(|entry| wanted(&entry.file_name().to_string_lossy()));
        chosen.map(|entry| entry.path()).collect()
    }
}

/// Reads a file and verifies that it is the entry of a key.
fn read_entry<M: CacheEntry>(path: &Path, key: &str) -> Lookup<M> {
    let bytes = match fs::read(path) {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Lookup::Missing,
        Err(error) => return Lookup::Invalid(format!("{} cannot be read: {error}", path.display())),
    };
    match M::decode(&bytes) {
        Ok(entry) if entry.key() == key => Lookup::Found(Box::new(entry)),
        Ok(entry) => {
            Lookup::Invalid(format!("{} is the model of other inputs, {}", path.display(), entry.key()))
        }
        Err(error) => Lookup::Invalid(format!("{} is not valid: {error}", path.display())),
    }
}
