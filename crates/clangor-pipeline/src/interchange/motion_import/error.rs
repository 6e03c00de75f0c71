//! Why a recording could not be imported.

use std::path::PathBuf;

use clangor_core::contact::ContactError;
use clangor_core::scene::instantiate::GeometryError;

use crate::formats::contact_list::ContactListError;
use crate::formats::mesh_reader::MeshFileError;
use crate::formats::pose_table::PoseTableError;
use crate::formats::record_table::RecordTableError;
use crate::formats::timeline_file::TimelineError;
use crate::interchange::gltf_bodies::fault::GltfBodyFaults;
use crate::motion::contact_checks::ContactFault;
use crate::motion::recording::{MAX_TIME, RecordingError};

/// Why a recording could not be imported.
#[derive(Debug, thiserror::Error)]
pub enum MotionImportError {
    /// A glTF file is wrong.
    #[error(transparent)]
    Gltf(#[from] MeshFileError),
    /// Nodes are no bodies.
    #[error("{0}")]
    Nodes(GltfBodyFaults),
    /// A node that is to be left out does not exist.
    #[error("no glTF file has a node {name}, which is to be left out (--leave-out)")]
    LeaveOut {
        /// The name.
        name: String,
    },
    /// An animation that is to move the nodes does not exist.
    #[error("the glTF files have no animation {name} (--animation); known: {}", known.join(", "))]
    Animation {
        /// The name.
        name: String,
        /// Those that there are.
        known: Vec<String>,
    },
    /// A table of poses is wrong.
    #[error(transparent)]
    Poses(#[from] PoseTableError),
    /// Frames are wrong.
    #[error("{path}, {error}")]
    Recording {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        error: RecordingError,
    },
    /// A contact list is wrong.
    #[error(transparent)]
    List(#[from] ContactListError),
    /// A contact is impossible.
    #[error("{path}, {fault}")]
    Contact {
        /// The list.
        path: PathBuf,
        /// What is wrong.
        fault: ContactFault,
    },
    /// A contact at a time that no timeline has.
    #[error(
        "{path}, row {row}: a contact is at t = {time} s; times run from 0 to {MAX_TIME} s; times in \
         milliseconds need --time-scale 0.001"
    )]
    Time {
        /// The list.
        path: PathBuf,
        /// Line of a text, row of a Parquet file.
        row: usize,
        /// The time \[s\].
        time: f64,
    },
    /// The poses are those of no body, or not finite.
    #[error(transparent)]
    Motion(#[from] ContactError),
    /// The centre of mass of a body whose origins are given is not known.
    #[error("{path} gives origins of {body}, whose centre of mass cannot be told: {reason}")]
    Centre {
        /// The table.
        path: PathBuf,
        /// The body.
        body: String,
        /// Why not.
        reason: GeometryError,
    },
    /// A glTF file without animation.
    #[error(
        "{path} has no animation, and so nothing moves. In Blender: give the objects keys (Object > Rigid \
         Body > Bake to Keyframes), and export with Animation on, and with \"Bake All Objects Animations\" \
         if constraints or parents move them; the Animation mode \"NLA Tracks\" exports nothing of actions \
         that are on no track, \"Active actions merged\" does"
    )]
    NoAnimation {
        /// The first file.
        path: PathBuf,
    },
    /// Bodies that only appear and vanish.
    #[error(
        "{path} moves no body: it has only keys of scale, which show and hide {node}{}, and what stands \
         still makes no sound",
        match others { 0 => String::new(), more => format!(" and {more} more") }
    )]
    OnlyShown {
        /// The first file.
        path: PathBuf,
        /// The first of them.
        node: String,
        /// How many more there are.
        others: usize,
    },
    /// Nothing of the scene moves.
    #[error(
        "{path} moves no body of the scene; nodes and rows belong to bodies by their names, and of a glTF \
         file with several scenes the default one is read"
    )]
    NothingMoves {
        /// The first file.
        path: PathBuf,
    },
    /// Two files move a body.
    #[error("{path} moves {body}, which another file moves too")]
    Twice {
        /// The later file.
        path: PathBuf,
        /// The body.
        body: String,
    },
    /// The scene moves the body, or holds it.
    #[error(
        "{path} moves {body}, which is {motion} in the scene; leave that out of the scene, or {body} out \
         of the file"
    )]
    NotFree {
        /// The file.
        path: PathBuf,
        /// The body.
        body: String,
        /// Fixed, or moved by keyframes.
        motion: &'static str,
    },
    /// A body without mass.
    #[error("{body} has a mass of {mass} kg; a body that others move needs a mass above 0")]
    NoMass {
        /// The body.
        body: String,
        /// Its mass \[kg\].
        mass: f64,
    },
    /// A table that another program writes to while it is read.
    #[error("{path} changed while it was read; import it when it is complete")]
    Changed {
        /// The table.
        path: PathBuf,
    },
    /// The timeline cannot be written.
    #[error(transparent)]
    Timeline(#[from] TimelineError),
    /// A row did not reach the timeline.
    #[error("cannot write {path}: {source}")]
    Row {
        /// The timeline.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
}

impl From<RecordTableError> for MotionImportError {
    fn from(error: RecordTableError) -> Self {
        MotionImportError::Poses(error.into())
    }
}
