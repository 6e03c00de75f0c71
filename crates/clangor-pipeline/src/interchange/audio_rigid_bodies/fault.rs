//! What can be wrong with the extension in a file, and where.

use std::fmt;
use std::path::PathBuf;

use crate::formats::mesh_reader::{MeshFault, MeshFileError};

/// Why the bodies of a file could not be read.
#[derive(Debug, thiserror::Error)]
pub enum AudioFileError {
    /// The file, or the glTF around the extension, is wrong.
    #[error(transparent)]
    File(#[from] MeshFileError),
    /// The extension is wrong.
    #[error("{path}, {place}: {fault}")]
    Content {
        /// The file.
        path: PathBuf,
        /// Where in it.
        place: AudioPlace,
        /// What is wrong there.
        fault: AudioFault,
    },
}

/// A place in a file with the extension.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum AudioPlace {
    /// The extension of the document.
    Document,
    /// An element of one of its lists, from 0.
    Element(&'static str, usize),
    /// A node, from 0, with its name.
    Node(usize, String),
}

impl fmt::Display for AudioPlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            AudioPlace::Document => write!(f, "{}", super::EXTENSION),
            AudioPlace::Element(list, index) => write!(f, "{} {list} {index}", super::EXTENSION),
            AudioPlace::Node(index, name) => write!(f, "node {index} \"{name}\""),
        }
    }
}

/// What is wrong with the extension.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum AudioFault {
    /// It has another name or other properties.
    #[error(
        "{found} belongs to another draft of the extension; convert it to that of 2026, {}",
        super::EXTENSION
    )]
    Draft {
        /// What is there.
        found: String,
    },
    /// A property is missing or of another type.
    #[error("{reason}")]
    Property {
        /// What the JSON reader says.
        reason: String,
    },
    /// An index of something that does not exist.
    #[error("names {what} {index}, of which there are {count}")]
    Missing {
        /// What it names.
        what: &'static str,
        /// The index.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// An accessor of another type than the draft wants.
    #[error("{property} is an accessor of {found}, and must be {wanted}")]
    Accessor {
        /// The property.
        property: &'static str,
        /// Type and component type that it has.
        found: String,
        /// What it must have.
        wanted: &'static str,
    },
    /// The numbers of an accessor cannot be read.
    #[error("{property}: {fault}")]
    Numbers {
        /// The property.
        property: &'static str,
        /// Why.
        fault: MeshFault,
    },
    /// Nothing where something must be, or counts that disagree.
    #[error("{property} has {found} elements, and needs {wanted}")]
    Count {
        /// The property.
        property: &'static str,
        /// How many there are.
        found: usize,
        /// How many there must be.
        wanted: String,
    },
    /// A number that cannot be.
    #[error("{property}{} is {value}, and must be {limit}", .at.map_or(String::new(), |at| format!(" {at}")))]
    Value {
        /// The property.
        property: &'static str,
        /// Which of its numbers, from 0.
        at: Option<usize>,
        /// The number.
        value: f64,
        /// What it must be.
        limit: &'static str,
    },
    /// Triangles that are said to be quarters of larger ones, and are not.
    #[error("triangles {triangle} to {} are said to be the quarters of one of six nodes, and are \
        not", triangle + 3)]
    Quarters {
        /// The first of the four.
        triangle: usize,
    },
    /// A node that is stretched.
    #[error(
        "the node is stretched, by {least} to {most}; modes hold at one shape: apply the scale to the mesh"
    )]
    Stretched {
        /// Smallest factor.
        least: f64,
        /// Largest factor.
        most: f64,
    },
    /// Neither a mesh nor triangles between the sample points.
    #[error("the body has no triangles: give the node a mesh, or the model indices")]
    NoSurface,
}
