//! Names of a scene's bodies, planes and listeners: read, defaulted, and each used once.

use std::collections::BTreeMap;

use super::reader::{Decoder, Section};
use crate::scene::diagnostic::{Place, Problem};

/// Names of bodies and planes, each with the line of its first use.
#[derive(Default)]
pub(super) struct Names {
    lines: BTreeMap<String, usize>,
}

impl Names {
    /// Takes a name, noting an error if it is taken.
    pub(super) fn take(&mut self, d: &mut Decoder<'_>, name: &str, place: &Place) {
        if let Some(first_line) = self.lines.insert(name.to_owned(), place.line) {
            d.error(place.clone(), Problem::DuplicateName { name: name.to_owned(), first_line });
        }
    }
}

/// Reads `name`, or gives the default, and takes it.
pub(super) fn name(d: &mut Decoder<'_>, section: &Section<'_>, default: &str, names: &mut Names) -> String {
    let written = section.get("name");
    let place = written.as_ref().map_or_else(|| section.place.clone(), |node| node.place(d));
    let mut name = written.and_then(|node| node.text(d, "a name in quotes")).unwrap_or(default).to_owned();
    if name.is_empty() {
        d.error(place.clone(), Problem::EmptyName);
        default.clone_into(&mut name);
    }
    names.take(d, &name, &place);
    name
}
