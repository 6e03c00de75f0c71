//! Shapes as text: `NAME[:SIZES][@EDGE]`, sizes in metres joined by `x`.
//!
//! | text | shape | bare name |
//! |---|---|---|
//! | `sphere:R` | radius | the ball bearing of \[PAN\], 7.5 mm |
//! | `ellipsoid:AxBxC` | semi-axes along x, y, z | |
//! | `box:XxYxZ` | full edges | |
//! | `die:EDGExROUND` | cube with rounded edges | 15 mm, rounded by 3 mm |
//! | `cylinder:RxH` | radius, full height, axis y | |
//! | `coin:RxH` | the same, thin | 12.13 mm × 1.75 mm, a US quarter as in \[PAN\] |
//! | `torus:Rxr` | radius of the circle, radius of the tube | |
//! | `ring` | | key ring: torus of 18 mm × 1.65 mm |
//! | `rock:SEEDxR` | convex stone, radius of the ball of equal volume | |
//! | `prism:NxRxH` | regular polygon with N corners at radius R, full height | |
//! | `shard:SEEDxSIZE` | flat convex splinter, thickness 8 % of its size | |
//! | `bowl` | | 148 mm wide, 62 mm high, walls of 5.5 mm |
//! | `plate` | | 260 mm wide, 4.5 mm thick |
//! | `mug` | | 84 mm wide, 98 mm high, walls of 5 mm, a handle |
//! | `wineglass` | | 142 mm high, walls of 1.5 mm |
//! | `moneybox` | | 110 mm wide, walls of 4 mm, a hole of 19 mm in its top |
//! | `key` | | 53 mm long, 1.8 mm thick, a hole of 8 mm to hang it by |
//! | `tile` | | 100 × 8 × 100 mm |
//! | `pane` | | 400 × 4 × 400 mm |
//!
//! \[PAN\] prints the size of the ball and calls the coin a quarter. The key ring's sizes follow from its
//! Table 1: the lowest frequency and the pulse time scale, which fixes the volume. The other sizes are
//! everyday ones.

use std::fmt;

use glam::DVec3;

use super::{Form, Shape};
use crate::geometry::solid::MeshError;

/// Meshes larger than this are rejected.
pub const MOST_TRIANGLES: f64 = 2e6;

/// Sizes outside this range \[m\] are taken for a mistake in the unit.
const SIZE_RANGE: [f64; 2] = [1e-6, 1e3];

/// Error in the text of a shape.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ShapeError {
    /// No such shape.
    #[error("there is no shape \"{name}\"; expected one of {known}")]
    UnknownName {
        /// The text.
        name: String,
        /// The names.
        known: String,
    },
    /// The sizes do not have the form that the shape needs.
    #[error("shape \"{text}\": expected {expected}, for example \"{example}\"")]
    Sizes {
        /// The text.
        text: String,
        /// Expected content.
        expected: &'static str,
        /// A valid text.
        example: &'static str,
    },
    /// A size is out of range.
    #[error("{what} is {value}, but must be {limit}")]
    Value {
        /// Which size.
        what: &'static str,
        /// Its value \[m\] (or a number).
        value: f64,
        /// Expected range.
        limit: String,
    },
    /// The edge length does not fit the shape.
    #[error("mesh edge @{edge}: {reason}")]
    Edge {
        /// The edge length \[m\].
        edge: f64,
        /// The fault.
        reason: String,
    },
    /// The generated surface is no solid.
    #[error("the shape makes no solid: {0}")]
    Mesh(#[from] MeshError),
}

/// A name, the sizes it takes (none, some or both) and an example.
struct Entry {
    name: &'static str,
    expected: &'static str,
    example: &'static str,
}

const fn entry(name: &'static str, expected: &'static str, example: &'static str) -> Entry {
    Entry { name, expected, example }
}

const ENTRIES: [Entry; 19] = [
    entry("sphere", "a radius or nothing", "sphere:0.0075"),
    entry("ellipsoid", "three semi-axes AxBxC", "ellipsoid:0.02x0.01x0.015"),
    entry("box", "three full edges XxYxZ", "box:0.1x0.05x0.2"),
    entry("die", "EDGExROUND or nothing", "die:0.015x0.003"),
    entry("cylinder", "RADIUSxHEIGHT", "cylinder:0.02x0.1"),
    entry("coin", "RADIUSxHEIGHT or nothing", "coin:0.01213x0.00175"),
    entry("torus", "Rxr, the circle and the tube", "torus:0.03x0.01"),
    entry("ring", "no sizes", "ring"),
    entry("rock", "SEEDxRADIUS with a whole number as seed", "rock:7x0.03"),
    entry("prism", "SIDESxRADIUSxHEIGHT", "prism:6x0.01x0.03"),
    entry("shard", "SEEDxSIZE with a whole number as seed", "shard:3x0.04"),
    entry("bowl", "no sizes", "bowl"),
    entry("plate", "no sizes", "plate"),
    entry("mug", "no sizes", "mug"),
    entry("wineglass", "no sizes", "wineglass"),
    entry("moneybox", "no sizes", "moneybox"),
    entry("key", "no sizes", "key"),
    entry("tile", "no sizes", "tile"),
    entry("pane", "no sizes", "pane"),
];

pub(super) fn parse(text: &str) -> Result<Shape, ShapeError> {
    let text = text.trim();
    let (body, edge) = match text.split_once('@') {
        Some((body, edge)) => (body, Some(edge)),
        None => (text, None),
    };
    let (name, sizes) = match body.split_once(':') {
        Some((name, sizes)) => (name, Some(sizes)),
        None => (body, None),
    };
    let Some(entry) = ENTRIES.iter().find(|e| e.name == name) else {
        let known: Vec<&str> = ENTRIES.iter().map(|e| e.name).collect();
        return Err(ShapeError::UnknownName { name: name.to_owned(), known: known.join(", ") });
    };
    let refuse =
        || ShapeError::Sizes { text: text.to_owned(), expected: entry.expected, example: entry.example };
    let fields: Vec<&str> = sizes.map(|s| s.split('x').collect()).unwrap_or_default();
    let numbers: Option<Vec<f64>> = fields.iter().map(|f| f.parse().ok()).collect();
    let numbers = numbers.ok_or_else(refuse)?;
    let form = form_of(name, &fields, &numbers).ok_or_else(refuse)?;
    let edge = match edge {
        Some(text) => Some(text.parse().map_err(|_| refuse())?),
        None => None,
    };
    Shape::try_new(form, edge)
}

fn form_of(name: &str, fields: &[&str], numbers: &[f64]) -> Option<Form> {
    Some(match (name, numbers) {
        ("sphere", []) => Form::Sphere { radius: 0.0075 },
        ("sphere", [radius]) => Form::Sphere { radius: *radius },
        ("ellipsoid", [a, b, c]) => Form::Ellipsoid { semi_axes: DVec3::new(*a, *b, *c) },
        ("box", [x, y, z]) => Form::Box { edges: DVec3::new(*x, *y, *z) },
        ("die", []) => Form::Die { size: 0.015, round: 0.003 },
        ("die", [size, round]) => Form::Die { size: *size, round: *round },
        ("coin", []) => Form::Cylinder { radius: 0.01213, height: 0.00175 },
        ("cylinder" | "coin", [radius, height]) => Form::Cylinder { radius: *radius, height: *height },
        ("torus", [major, minor]) => Form::Torus { major: *major, minor: *minor },
        ("ring", []) => Form::Torus { major: 0.018, minor: 0.00165 },
        ("rock", [_, radius]) => Form::Rock { seed: fields.first()?.parse().ok()?, radius: *radius },
        ("prism", [_, radius, height]) => {
            Form::Prism { sides: fields.first()?.parse().ok()?, radius: *radius, height: *height }
        }
        ("shard", [_, size]) => Form::Shard { seed: fields.first()?.parse().ok()?, size: *size },
        ("bowl", []) => Form::Bowl,
        ("plate", []) => Form::Plate,
        ("mug", []) => Form::Mug,
        ("wineglass", []) => Form::Wineglass,
        ("moneybox", []) => Form::Moneybox,
        ("key", []) => Form::Key,
        ("tile", []) => Form::Box { edges: DVec3::new(0.1, 0.008, 0.1) },
        ("pane", []) => Form::Box { edges: DVec3::new(0.4, 0.004, 0.4) },
        _ => return None,
    })
}

/// Rejects sizes out of range.
pub(super) fn check_form(form: &Form) -> Result<(), ShapeError> {
    let [least, most] = SIZE_RANGE;
    let size = |what, value: f64| {
        let good = (least..=most).contains(&value);
        let limit = || format!("between {least} m and {most} m");
        if good { Ok(()) } else { Err(ShapeError::Value { what, value, limit: limit() }) }
    };
    let all = |what, v: DVec3| v.to_array().into_iter().try_for_each(|x| size(what, x));
    match *form {
        Form::Sphere { radius } | Form::Rock { radius, .. } => size("the radius", radius),
        Form::Ellipsoid { semi_axes } => all("a semi-axis", semi_axes),
        Form::Box { edges } => all("an edge", edges),
        Form::Die { size: full, round } => {
            size("the edge", full)?;
            let limit = || format!("0, or from {} m to half of the edge", 1e-3 * full);
            let good = round == 0.0 || (1e-3 * full..=0.5 * full).contains(&round);
            if good {
                Ok(())
            } else {
                Err(ShapeError::Value { what: "the rounding", value: round, limit: limit() })
            }
        }
        Form::Cylinder { radius, height } => {
            size("the radius", radius)?;
            size("the height", height)
        }
        Form::Prism { sides, radius, height } => {
            size("the radius", radius)?;
            size("the height", height)?;
            if (3..=64).contains(&sides) {
                return Ok(());
            }
            let limit = "from 3 to 64".to_owned();
            Err(ShapeError::Value { what: "the number of sides", value: f64::from(sides), limit })
        }
        Form::Shard { size: full, .. } => size("the size", full),
        Form::Bowl | Form::Plate | Form::Mug | Form::Wineglass | Form::Moneybox | Form::Key => Ok(()),
        Form::Torus { major, minor } => {
            size("the radius of the circle", major)?;
            size("the radius of the tube", minor)?;
            if minor <= 0.95 * major {
                return Ok(());
            }
            let limit = format!("at most 0.95 of the circle's, {} m", 0.95 * major);
            Err(ShapeError::Value { what: "the radius of the tube", value: minor, limit })
        }
    }
}

/// Rejects an edge longer than the shape, or one that makes too many triangles.
pub(super) fn check_edge(shape: &Shape, edge: f64) -> Result<(), ShapeError> {
    let coarse = shape.mesh();
    let (low, high) = coarse.bounds();
    let longest = (high - low).max_element();
    let refuse = |reason| Err(ShapeError::Edge { edge, reason });
    if !(edge > 0.0 && edge <= longest) {
        return refuse(format!("expected a length between 0 and the size of the shape, {longest} m"));
    }
    // Equilateral triangles of that edge; generators need up to a third more.
    let least = (coarse.area() * 4.0 / 3.0_f64.sqrt() * 1.33 / MOST_TRIANGLES).sqrt();
    if edge < least {
        return refuse(format!(
            "the mesh would have more than 2 million triangles; expected at least {least:.2e} m"
        ));
    }
    Ok(())
}

impl fmt::Display for Shape {
    /// A text that [`Shape::parse`] reads back.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self.form() {
            Form::Sphere { radius } => write!(f, "sphere:{radius}"),
            Form::Ellipsoid { semi_axes: DVec3 { x, y, z } } => write!(f, "ellipsoid:{x}x{y}x{z}"),
            Form::Box { edges: DVec3 { x, y, z } } => write!(f, "box:{x}x{y}x{z}"),
            Form::Die { size, round } => write!(f, "die:{size}x{round}"),
            Form::Cylinder { radius, height } => write!(f, "cylinder:{radius}x{height}"),
            Form::Torus { major, minor } => write!(f, "torus:{major}x{minor}"),
            Form::Rock { seed, radius } => write!(f, "rock:{seed}x{radius}"),
            Form::Prism { sides, radius, height } => write!(f, "prism:{sides}x{radius}x{height}"),
            Form::Shard { seed, size } => write!(f, "shard:{seed}x{size}"),
            Form::Bowl => f.write_str("bowl"),
            Form::Plate => f.write_str("plate"),
            Form::Mug => f.write_str("mug"),
            Form::Wineglass => f.write_str("wineglass"),
            Form::Moneybox => f.write_str("moneybox"),
            Form::Key => f.write_str("key"),
        }?;
        write!(f, "@{}", self.edge())
    }
}
