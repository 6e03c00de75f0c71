//! Errors and warnings of a scene: the problem, its place, and a remedy.
//!
//! Every error and warning names the byte span, line, column and field path in the text. The problem is typed
//! and carries its numbers. Its `Display` describes the error, and [`Problem::remedy`] the correction.

use std::fmt;
use std::ops::Range;

use super::suggest::nearest;
use super::support_problem::SupportProblem;
use super::syntax_remedy::syntax_remedy;
use crate::propagation::PlanesError;
use crate::propagation::room::RoomError;
use crate::quantity::readable;
use crate::shape::ShapeError;

/// A place in a scene. Parts of a scene that do not come from a text, such as a listener of the command line,
/// have line 0.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// Bytes of the text.
    pub span: Range<usize>,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// Path of the field, such as `body[2].velocity`; empty for the whole file. Array elements count from 0.
    pub field: String,
}

impl Place {
    /// Sort key of places: the order of the text.
    pub(super) fn order(&self) -> (usize, String) {
        (self.span.start, self.field.clone())
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.line, self.field.as_str()) {
            (0, field) => write!(f, "{field}"),
            (line, "") => write!(f, "{line}:{}", self.column),
            (line, field) => write!(f, "{line}:{}: {field}", self.column),
        }
    }
}

/// An error in a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneError {
    /// Place.
    pub place: Place,
    /// Problem.
    pub problem: Problem,
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}; {}", self.place, self.problem, self.problem.remedy())
    }
}

/// All errors of a scene, in the order of the text. Messages show the first [`SHOWN`] and count the others.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneErrors(pub Vec<SceneError>);

/// Errors, or warnings, that a message shows; of more than these, their number is enough.
pub const SHOWN: usize = 50;

impl fmt::Display for SceneErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, error) in self.0.iter().take(SHOWN).enumerate() {
            if index > 0 {
                writeln!(f)?;
            }
            write!(f, "{error}")?;
        }
        match self.0.len().checked_sub(SHOWN) {
            None | Some(0) => Ok(()),
            Some(1) => write!(f, "\nand 1 more error"),
            Some(more) => write!(f, "\nand {more} more errors"),
        }
    }
}

impl std::error::Error for SceneErrors {}

/// Problem in a scene.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Problem {
    /// The text is not TOML.
    #[error("not valid TOML: {message}")]
    Syntax {
        /// Message of the parser.
        message: String,
    },
    /// An unknown key.
    #[error("unknown key `{key}`")]
    UnknownKey {
        /// The key.
        key: String,
        /// The accepted key that looks most like it.
        nearest: Option<String>,
        /// All accepted keys.
        accepted: &'static [&'static str],
    },
    /// A missing key.
    #[error("`{key}` is missing")]
    Missing {
        /// The key.
        key: &'static str,
        /// Expected content.
        expected: String,
    },
    /// A value of the wrong type.
    #[error("this is {found}")]
    WrongType {
        /// Type found.
        found: &'static str,
        /// Expected type.
        expected: String,
    },
    /// An array of the wrong length.
    #[error("this has {found} elements")]
    WrongLength {
        /// Length found.
        found: usize,
        /// Expected content.
        expected: String,
    },
    /// NaN or an infinity.
    #[error("this is not a finite number")]
    NotFinite {
        /// Expected content.
        expected: String,
    },
    /// A number outside its range.
    #[error("{} is out of range", readable(*value))]
    OutOfRange {
        /// The number.
        value: f64,
        /// Expected range.
        expected: String,
    },
    /// An undefined name.
    #[error("there is no {what} `{name}`")]
    UnknownName {
        /// Kind of name.
        what: &'static str,
        /// The name.
        name: String,
        /// The known name that looks most like it.
        nearest: Option<String>,
        /// All known names.
        known: Vec<String>,
    },
    /// A name used twice.
    #[error("the name `{name}` is already taken on line {first_line}")]
    DuplicateName {
        /// The name.
        name: String,
        /// Place of its first use.
        first_line: usize,
    },
    /// An empty name.
    #[error("this name is empty")]
    EmptyName,
    /// A material named like a preset.
    #[error("`{name}` is the name of a preset")]
    PresetName {
        /// The name.
        name: String,
    },
    /// Two keys that exclude each other.
    #[error("`{key}` cannot be combined with {other}")]
    Conflict {
        /// The key.
        key: &'static str,
        /// The conflicting key.
        other: &'static str,
    },
    /// A body with fracture settings, of a material without strength or toughness.
    #[error("it cannot break: material \"{material}\" has no `{missing}`")]
    CannotBreak {
        /// The material.
        material: String,
        /// The missing property.
        missing: &'static str,
    },
    /// A key without its partner.
    #[error("`{key}` means nothing without {other}")]
    Needs {
        /// The key.
        key: &'static str,
        /// The missing key.
        other: &'static str,
    },
    /// An unsupported format version.
    #[error("version {found} is not supported")]
    UnsupportedVersion {
        /// The version.
        found: i64,
    },
    /// An invalid shape.
    #[error(transparent)]
    Shape(ShapeError),
    /// Geometry that its loader rejects.
    #[error("`{reference}` cannot be used: {reason}")]
    Geometry {
        /// The shape or file.
        reference: String,
        /// Reason.
        reason: String,
        /// Remedy.
        remedy: String,
    },
    /// A direction of no length.
    #[error("this vector has no direction")]
    NoDirection {
        /// Expected content.
        expected: &'static str,
    },
    /// Times of keyframes, or of rows of a force, that do not increase.
    #[error("times must increase, but {time} s follows {previous} s")]
    UnorderedTimes {
        /// Time of the offending key \[s\].
        time: f64,
        /// Time of the key before it \[s\].
        previous: f64,
    },
    /// Frequencies of a table that are not in ascending order.
    #[error("frequencies must ascend, but {frequency} Hz follows {previous} Hz")]
    UnorderedFrequencies {
        /// The offending frequency \[Hz\].
        frequency: f64,
        /// The one before it \[Hz\].
        previous: f64,
    },
    /// A size outside the supported range.
    #[error("a bounding radius of {radius:.3e} m is absurd")]
    AbsurdSize {
        /// Bounding radius \[m\].
        radius: f64,
    },
    /// Too many bodies.
    #[error("the scene has {count} bodies")]
    TooManyBodies {
        /// Number of bodies.
        count: u64,
        /// Largest number of bodies.
        limit: u64,
    },
    /// Too many distinct geometries.
    #[error("the bodies up to here have more than {limit} distinct geometries")]
    TooManyGeometries {
        /// Largest number of geometries.
        limit: usize,
    },
    /// A speed that is too close to that of sound, or above it.
    #[error("{} m/s is not slower than sound ({sound_speed} m/s)", readable(*speed))]
    Supersonic {
        /// Speed \[m/s\].
        speed: f64,
        /// Speed of sound \[m/s\].
        sound_speed: f64,
    },
    /// A listener inside a body.
    #[error("the listener is inside the body `{body}` by {depth:.3e} m")]
    ListenerInside {
        /// The body.
        body: String,
        /// Depth \[m\].
        depth: f64,
    },
    /// A listener under a reflecting floor.
    #[error("the listener at height {height} m is below the rigid floor at {floor} m")]
    ListenerBelowFloor {
        /// Height of the listener \[m\].
        height: f64,
        /// Height of the floor \[m\].
        floor: f64,
    },
    /// A listener outside the room.
    #[error("the listener leaves the room")]
    ListenerOutside,
    /// An invalid room.
    #[error(transparent)]
    Room(RoomError),
    /// Planes that cannot reflect together.
    #[error(transparent)]
    Planes(PlanesError),
    /// Copies that do not fit in their region.
    #[error("only {placed} of {count} copies fit in the region without touching")]
    DoesNotFit {
        /// Number of copies placed.
        placed: usize,
        /// Number of copies in the scene.
        count: usize,
    },
    /// An invalid support of a body.
    #[error(transparent)]
    Support(SupportProblem),
    /// A link to a body that does not admit it.
    #[error("the body `{body}` {reason}")]
    BadLink {
        /// The body.
        body: String,
        /// Reason.
        reason: &'static str,
        /// Remedy.
        remedy: &'static str,
    },
}

impl Problem {
    /// The correction of the text.
    pub fn remedy(&self) -> String {
        match self {
            Problem::Syntax { message } => syntax_remedy(message).into(),
            Problem::UnknownKey { nearest, accepted, .. } => match nearest {
                Some(nearest) => format!("did you mean `{nearest}`?"),
                None => format!("delete it; accepted here: {}", accepted.join(", ")),
            },
            Problem::Missing { key, expected } => format!("add `{key}`: {expected}"),
            Problem::WrongType { expected, .. }
            | Problem::WrongLength { expected, .. }
            | Problem::NotFinite { expected }
            | Problem::OutOfRange { expected, .. } => format!("write {expected}"),
            Problem::UnknownName { what, nearest, known, .. } => match nearest {
                Some(nearest) => format!("did you mean `{nearest}`?"),
                None if known.is_empty() => format!("define a {what} of that name"),
                None => format!("known: {}", abridged(known)),
            },
            Problem::DuplicateName { .. } => "give each a name of its own".into(),
            Problem::EmptyName => "write a name, or delete the key".into(),
            Problem::PresetName { name } => {
                format!("choose another name, and write base = \"{name}\" to start from the preset")
            }
            Problem::Conflict { key, other } => format!("keep either `{key}` or {other}"),
            Problem::CannotBreak { material, missing } => {
                format!("add `{missing}` to [material.{material}], or start it from a preset with `base`")
            }
            Problem::Needs { key, other } => format!("add {other}, or delete `{key}`"),
            Problem::UnsupportedVersion { .. } => "write version = 1, or use a newer program".into(),
            Problem::Shape(error) => shape_remedy(error),
            Problem::Geometry { remedy, .. } => remedy.clone(),
            Problem::NoDirection { expected } => format!("write {expected}"),
            Problem::UnorderedTimes { .. } => "sort them by time, each later than the last".into(),
            Problem::UnorderedFrequencies { .. } => "sort the rows by frequency, each only once".into(),
            Problem::AbsurdSize { radius } if *radius > 1.0 => {
                "lengths are in metres; if the file is in millimetres, set scale = 0.001".into()
            }
            Problem::AbsurdSize { .. } => "lengths are in metres; correct the shape or its `scale`".into(),
            Problem::TooManyBodies { limit, .. } => format!("use at most {limit}"),
            Problem::TooManyGeometries { .. } => {
                "let copies share shapes, files and scales: without {n}, and with one `scale`".into()
            }
            Problem::Supersonic { .. } => "linear acoustics ends there: write a lower speed in m/s".into(),
            Problem::ListenerInside { .. } => "move the listener outside, or the body away from it".into(),
            Problem::ListenerBelowFloor { .. } => {
                "raise the listener, lower `floor_height`, or set floor = \"none\"".into()
            }
            Problem::ListenerOutside => "move the listener into the room, or enlarge the room".into(),
            Problem::Room(RoomError::Undamped { .. }) => {
                "let a wall absorb a little, such as 0.01, or set late = false".into()
            }
            Problem::Room(_) => "write the lower corner as `lowest`, the other as `highest`".into(),
            Problem::Planes(PlanesError::TooMany { .. }) => {
                "let fewer planes reflect, or lower `reflection_order`".into()
            }
            Problem::Planes(_) => "delete `reflects` of one of them, or move a plane".into(),
            Problem::DoesNotFit { .. } => "enlarge the region, or lower `count` or `scale`".into(),
            Problem::Support(problem) => problem.remedy().into(),
            Problem::BadLink { remedy, .. } => (*remedy).into(),
        }
    }
}

/// The correction of an invalid shape.
pub(in crate::scene) fn shape_remedy(error: &ShapeError) -> String {
    match error {
        ShapeError::UnknownName { name, .. } if is_file_name(name) => {
            "a mesh file ends in .obj, .ply, .stl, .gltf or .glb, and is a `mesh` in a scene: export it as \
             one of these"
                .into()
        }
        ShapeError::UnknownName { name, known } => match nearest(name, known.split(", ")) {
            Some(nearest) => format!("did you mean `{nearest}`?"),
            None => "write one of these names".into(),
        },
        ShapeError::Sizes { example, .. } => format!("write sizes in metres, as in \"{example}\""),
        ShapeError::Value { limit, .. } => format!("write a size in metres that is {limit}"),
        ShapeError::Edge { .. } => "choose another edge length after @, or leave it out".into(),
        ShapeError::Mesh(_) => "change the sizes of the shape".into(),
    }
}

/// Whether a text ends as the name of a file does.
fn is_file_name(text: &str) -> bool {
    let ending = text.rsplit_once('.').map_or("", |(_, ending)| ending);
    (2..=7).contains(&ending.len())
        && ending.chars().all(|c| c.is_ascii_alphanumeric())
        && ending.contains(|c: char| c.is_ascii_alphabetic())
}

/// Known names that a message shows.
const SHOWN_NAMES: usize = 20;
/// Known names that an error keeps: with one more than it shows, it is clear that there are more.
pub(super) const KEPT_NAMES: usize = SHOWN_NAMES + 1;

/// The first names of a list.
fn abridged(names: &[String]) -> String {
    let shown = names.iter().take(SHOWN_NAMES).cloned().collect::<Vec<_>>().join(", ");
    if names.len() > SHOWN_NAMES { format!("{shown}, …") } else { shown }
}

/// A warning: accepted, but probably not intended.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneWarning {
    /// Place.
    pub place: Place,
    /// Doubt.
    pub doubt: Doubt,
}

impl fmt::Display for SceneWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.place, self.doubt)
    }
}

/// Doubtful part of a scene.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Doubt {
    /// A number outside the usual range.
    #[error("{what} of {} {unit} is unusual (usually {usual}); check the unit", readable(*value))]
    Unusual {
        /// Quantity.
        what: &'static str,
        /// The number.
        value: f64,
        /// Its unit.
        unit: &'static str,
        /// Usual range.
        usual: &'static str,
    },
    /// No listener.
    #[error("the scene has no listener, so nothing is heard; add a [[listener]]")]
    NoListener,
    /// No two bodies that could collide.
    #[error(
        "nothing moves, so the scene is silent; add a free body, gravity, a velocity or keyframes, or import \
        motion into it (`clangor import`)"
    )]
    NothingMoves,
    /// A free body that cannot collide with anything.
    #[error(
        "there is one body and nothing that it could hit, so the scene is silent; add a [[plane]] or a body"
    )]
    NothingToHit,
    /// A listener too far from all bodies.
    #[error(
        "the nearest body is {} m away, so next to nothing is heard; move the listener closer",
        readable(distance.round())
    )]
    FarListener {
        /// Distance to the nearest body \[m\].
        distance: f64,
    },
    /// A sample rate that excludes audible frequencies.
    #[error("this sample rate cuts the band at {nyquist} Hz; {} keeps all that can be heard",
        crate::synthesis::SampleRate::HZ_48000.hz())]
    CutBand {
        /// Half of the sample rate \[Hz\].
        nyquist: f64,
    },
    /// A key that no longer does anything.
    #[error("`{key}` has no effect: contacts are solved, which bounds the energy; remove it")]
    WithoutEffect {
        /// The key.
        key: &'static str,
    },
    /// A key under its former name.
    #[error("`{former}` is now `{key}`; the former name is accepted in this version only")]
    FormerKey {
        /// Its former name.
        former: &'static str,
        /// Its name.
        key: &'static str,
    },
    /// A warning of the geometry loader.
    #[error("{message}")]
    Geometry {
        /// Message.
        message: String,
    },
}
