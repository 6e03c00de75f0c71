//! Bodies as tables and lists name them: by their name, or by their number where none has it for a name.

use std::collections::HashMap;

use clangor_core::body::{BodyId, World};
use clangor_core::scene::suggest::nearest;

/// Bodies that may be named.
#[derive(Clone, Debug, Default)]
pub struct NamedBodies<'a> {
    names: Vec<&'a str>,
    ids: HashMap<&'a str, BodyId>,
}

impl<'a> NamedBodies<'a> {
    /// Bodies of these names, in the order of their numbers. The first body of a name has it.
    pub fn new(names: impl IntoIterator<Item = &'a str>) -> Self {
        let names: Vec<&str> = names.into_iter().collect();
        let mut ids = HashMap::with_capacity(names.len());
        for (index, name) in names.iter().enumerate() {
            ids.entry(*name).or_insert(BodyId(index as u32));
        }
        NamedBodies { names, ids }
    }

    /// Those of a world.
    pub fn of(world: &'a World) -> Self {
        NamedBodies::new(world.bodies.iter().map(|body| body.name.as_str()))
    }

    /// How many there are.
    pub(crate) fn count(&self) -> usize {
        self.names.len()
    }

    /// The name of a body.
    pub(crate) fn name(&self, id: BodyId) -> &'a str {
        self.names.get(id.index()).copied().unwrap_or_default()
    }

    /// Whether a body has this name.
    pub(crate) fn has(&self, name: &str) -> bool {
        self.ids.contains_key(name)
    }

    /// The body of a name or number: `1`, but not `01` or `+1`, which may be meant as names.
    pub(crate) fn find(&self, text: &str) -> Option<BodyId> {
        let number = || {
            let number: u32 = text.parse().ok()?;
            ((number as usize) < self.count() && number.to_string() == text).then_some(BodyId(number))
        };
        self.ids.get(text).copied().or_else(number)
    }

    /// What to say after a text that is no body: the name that is likely meant.
    pub(crate) fn meant(&self, text: &str) -> String {
        let name = nearest(text, self.names.iter().copied().filter(|name| !name.is_empty()));
        name.map_or_else(String::new, |name| format!("; did you mean {name}?"))
    }
}
