//! Finds and reads the Rust and JavaScript files of the repository.
//!
//! The folders are `crates`, `integrations` and `validation` (Rust), and `web/src`, `web/tests` and
//! `web/scripts` (JavaScript). Build outputs and installed packages are skipped.

use std::path::Path;
use std::{fs, io};

/// Folders of the repository that hold sources.
const SOURCE_FOLDERS: &[&str] =
    &["crates", "integrations", "validation", "web/src", "web/tests", "web/scripts"];

/// Folders that hold no sources of ours.
const SKIPPED_FOLDERS: &[&str] = &["target", "node_modules", "dist", "public"];

/// The language of a source file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Language {
    /// A file `*.rs`.
    Rust,
    /// A file `*.js` or `*.mjs`.
    JavaScript,
}

/// One source file.
#[derive(Clone, Debug)]
pub struct SourceFile {
    /// Path from the root of the repository, with `/` between folders.
    pub path: String,
    /// Content.
    pub text: String,
    /// Language, by the extension of the path.
    pub language: Language,
}

impl SourceFile {
    /// Creates a file, or `None` if the extension belongs to no measured language.
    pub fn new(path: &str, text: &str) -> Option<Self> {
        let language = match path.rsplit_once('.')?.1 {
            "rs" => Language::Rust,
            "js" | "mjs" => Language::JavaScript,
            _ => return None,
        };
        Some(Self { path: path.to_string(), text: text.to_string(), language })
    }

    /// Returns true if the file lies in a folder `tests`.
    pub fn is_in_tests_folder(&self) -> bool {
        self.path.split('/').rev().skip(1).any(|folder| folder == "tests")
    }

    /// Returns the crate's folder, such as `crates/clangor` or `validation`, or `None` of a file of no
    /// crate.
    pub fn crate_folder(&self) -> Option<&str> {
        let (first, rest) = self.path.split_once('/')?;
        let (name, _) = rest.split_once('/')?;
        if first == "validation" {
            return Some(first);
        }
        matches!(first, "crates" | "integrations").then(|| &self.path[..first.len() + 1 + name.len()])
    }
}

/// All source files of a repository, in the order of their paths.
#[derive(Clone, Debug, Default)]
pub struct SourceTree {
    /// The files.
    pub files: Vec<SourceFile>,
}

impl SourceTree {
    /// Reads the source files below `root`.
    ///
    /// # Errors
    /// Fails if a folder or file cannot be read, or if `root` holds no source file.
    pub fn read(root: &Path) -> io::Result<Self> {
        let mut tree = Self::default();
        for folder in SOURCE_FOLDERS {
            if root.join(folder).is_dir() {
                tree.read_folder(root, folder)?;
            }
        }
        if tree.files.is_empty() {
            let message = format!("{} holds no source files", root.display());
            return Err(io::Error::new(io::ErrorKind::NotFound, message));
        }
        tree.files.sort_by(|a, b| a.path.cmp(&b.path));
        Ok(tree)
    }

    /// Builds a tree of given paths and texts, for tests of the measures.
    pub fn from_texts(texts: &[(&str, &str)]) -> Self {
        let mut files: Vec<_> = texts.iter().filter_map(|(path, text)| SourceFile::new(path, text)).collect();
        files.sort_by(|a, b| a.path.cmp(&b.path));
        Self { files }
    }

    /// Returns the file of a path.
    pub fn file(&self, path: &str) -> Option<&SourceFile> {
        self.files.binary_search_by(|file| file.path.as_str().cmp(path)).ok().map(|index| &self.files[index])
    }

    /// Iterates over the Rust files.
    pub fn rust_files(&self) -> impl Iterator<Item = &SourceFile> {
        self.files.iter().filter(|file| file.language == Language::Rust)
    }

    fn read_folder(&mut self, root: &Path, folder: &str) -> io::Result<()> {
        for entry in fs::read_dir(root.join(folder))? {
            let entry = entry?;
            let name = entry.file_name().to_string_lossy().into_owned();
            let path = format!("{folder}/{name}");
            if entry.file_type()?.is_dir() {
                if !SKIPPED_FOLDERS.contains(&name.as_str()) {
                    self.read_folder(root, &path)?;
                }
            } else if SourceFile::new(&path, "").is_some() {
                let text = fs::read_to_string(entry.path())?;
                self.files.extend(SourceFile::new(&path, &text));
            }
        }
        Ok(())
    }
}
