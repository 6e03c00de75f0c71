//! The keys `shape`, `mesh` and `scale` of a body.

use super::reader::{Decoder, Quantity, Section};
use crate::scene::body_description::{COPY_NUMBER, Geometry};
use crate::scene::diagnostic::{Place, Problem};
use crate::shape::Shape;

const SCALE: Quantity = Quantity::above(0.0, 1e6, "");

/// The geometry of a body and its place in the text.
pub(super) fn geometry(
    d: &mut Decoder<'_>,
    section: &Section<'_>,
    preset: Option<&str>,
    several: bool,
) -> Option<(Geometry, Place)> {
    if let Some(shape) = preset {
        return Some((Geometry::Shape(shape.to_owned()), section.place.clone()));
    }
    section.exclude(d, "mesh", "shape", "`shape`");
    if let Some(node) = section.get("shape") {
        let text = node.text(d, "a shape in quotes, such as \"sphere:0.0075\"")?;
        if text.contains(COPY_NUMBER) && !several {
            d.error(node.place(d), Problem::Needs { key: COPY_NUMBER, other: "`count` or `positions`" });
            return None;
        }
        // Any copy is sufficient: its number is only a seed.
        if let Err(error) = Shape::parse(&text.replace(COPY_NUMBER, "1")) {
            d.error(node.place(d), Problem::Shape(error));
            return None;
        }
        return Some((Geometry::Shape(text.to_owned()), node.place(d)));
    }
    if let Some(node) = section.get("mesh") {
        let path = node.text(d, "a path in quotes, such as \"mug.obj\"")?;
        if path.is_empty() {
            let problem = Problem::Geometry {
                reference: String::new(),
                reason: "the path is empty".into(),
                remedy: "write the path of a mesh file, relative to the scene file".into(),
            };
            d.error(node.place(d), problem);
            return None;
        }
        return Some((Geometry::File(path.to_owned()), node.place(d)));
    }
    if !section.mentions("preset") && !section.mentions("mesh") {
        section.missing(d, "shape", "a shape in quotes, such as \"sphere:0.0075\", or `mesh`");
    }
    None
}

/// The factor on lengths, or its range for copies.
pub(super) fn scale(d: &mut Decoder<'_>, section: &Section<'_>, several: bool) -> Option<[f64; 2]> {
    let Some(node) = section.get("scale") else { return Some([1.0, 1.0]) };
    if !node.is_array() {
        return node.number(d, SCALE).map(|scale| [scale, scale]);
    }
    let [least, greatest] = node.numbers::<2>(d, SCALE)?;
    if least > greatest {
        let expected = "the smaller factor first, such as [0.5, 2.0]".to_owned();
        d.error(node.place(d), Problem::OutOfRange { value: least, expected });
        return None;
    }
    if !several {
        d.error(node.place(d), Problem::Needs { key: "a range of scales", other: "`count` or `positions`" });
        return None;
    }
    Some([least, greatest])
}
