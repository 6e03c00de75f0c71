//! Names of a scene's bodies, planes and listeners: read, defaulted, and each used once.

use std::collections::{BTreeMap, BTreeSet};

use super::reader::{Decoder, Section};
use crate::scene::diagnostic::{Place, Problem};

/// Names of bodies and planes, each with the line of its first use.
#[derive(Default)]
pub(super) struct Names {
    lines: BTreeMap<String, usize>,
    /// Names of bodies that have errors of their own.
    faulty: BTreeSet<String>,
}

impl Names {
    /// Takes a name, noting an error if it is taken.
    pub(super) fn take(&mut self, d: &mut Decoder<'_>, name: &str, place: &Place) {
        if let Some(first_line) = self.lines.insert(name.to_owned(), place.line) {
            d.error(place.clone(), Problem::DuplicateName { name: name.to_owned(), first_line });
        }
    }

    /// Notes that the body of a name has errors.
    pub(super) fn mark_faulty(&mut self, name: String) {
        self.faulty.insert(name);
    }

    /// Whether a name is that of a body with errors, or of a copy of one.
    pub(super) fn is_faulty(&self, name: &str) -> bool {
        let is_number = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
        let group = name.rsplit_once('-').filter(|(_, number)| is_number(number)).map(|(group, _)| group);
        self.faulty.contains(name) || group.is_some_and(|group| self.faulty.contains(group))
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
