//! Reading of typed values from the TOML tree with spans; collects all errors.
//!
//! serde's derive stops at the first error; this reader continues. Each method returns `None` for an absent
//! or invalid value, and records the error. The caller continues with a default that is never used.

use std::ops::Range;

use glam::DVec3;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::former_keys::FormerKey;
pub(super) use crate::quantity::Quantity;
use crate::scene::diagnostic::{Doubt, KEPT_NAMES, Place, Problem, SceneError, SceneWarning};
use crate::scene::suggest::nearest;

/// Collects errors and warnings, and computes lines and columns.
pub(super) struct Decoder<'t> {
    text: &'t str,
    line_starts: Vec<usize>,
    /// Number of UTF-8 continuation bytes before each block of [`BLOCK`] bytes. It makes the cost of a column
    /// independent of the length of the line.
    continuations: Vec<usize>,
    pub(super) errors: Vec<SceneError>,
    pub(super) warnings: Vec<SceneWarning>,
    /// Comparisons of names that suggestions may still take.
    comparisons: usize,
}

/// Comparisons of names for all suggestions together: about a second of work, however many names are
/// misspelt and however many are known.
const COMPARISONS: usize = 200_000;

const BLOCK: usize = 1024;

impl<'t> Decoder<'t> {
    pub(super) fn new(text: &'t str) -> Self {
        let after_breaks = text.bytes().enumerate().filter(|(_, b)| *b == b'\n').map(|(i, _)| i + 1);
        let line_starts = std::iter::once(0).chain(after_breaks).collect();
        let mut continuations = vec![0];
        for block in text.as_bytes().chunks(BLOCK) {
            continuations.push(continuations[continuations.len() - 1] + count_continuations(block));
        }
        Decoder {
            text,
            line_starts,
            continuations,
            errors: Vec::new(),
            warnings: Vec::new(),
            comparisons: COMPARISONS,
        }
    }

    pub(super) fn place(&self, span: Range<usize>, field: impl Into<String>) -> Place {
        let start = span.start.min(self.text.len());
        let line = self.line_starts.partition_point(|s| *s <= start);
        let line_start = self.line_starts[line - 1];
        let column = self.characters_before(start) - self.characters_before(line_start) + 1;
        Place { span, line, column, field: field.into() }
    }

    /// Number of characters that begin before a byte, which may be inside one.
    fn characters_before(&self, byte: usize) -> usize {
        let block = byte / BLOCK;
        let rest = &self.text.as_bytes()[block * BLOCK..byte];
        byte - self.continuations[block] - count_continuations(rest)
    }

    /// The known name that was probably meant; none once the comparisons are used up.
    fn nearest(&mut self, name: &str, known: &[&str]) -> Option<String> {
        self.comparisons = self.comparisons.saturating_sub(known.len());
        if self.comparisons == 0 { None } else { nearest(name, known.iter().copied()) }
    }

    /// How many known names are of use to [`unknown_name`](Self::unknown_name).
    pub(super) fn comparable(&self) -> usize {
        self.comparisons.max(KEPT_NAMES)
    }

    /// A name that is not among those known.
    pub(super) fn unknown_name<'a>(
        &mut self,
        place: Place,
        what: &'static str,
        name: &str,
        known: impl Iterator<Item = &'a str>,
    ) {
        // Of thousands, the message shows the first ones.
        let known: Vec<&str> = known.take(self.comparable()).collect();
        let nearest = self.nearest(name, &known);
        let known = known.into_iter().take(KEPT_NAMES).map(str::to_owned).collect();
        self.error(place, Problem::UnknownName { what, name: name.to_owned(), nearest, known });
    }

    pub(super) fn error(&mut self, place: Place, problem: Problem) {
        self.errors.push(SceneError { place, problem });
    }

    pub(super) fn warn(&mut self, place: Place, doubt: Doubt) {
        self.warnings.push(SceneWarning { place, doubt });
    }
}

fn count_continuations(bytes: &[u8]) -> usize {
    bytes.iter().filter(|b| (**b & 0xC0) == 0x80).count()
}

/// A value with its span and path; line and column are computed only when requested.
#[derive(Clone)]
pub(super) struct Node<'t> {
    value: &'t DeValue<'t>,
    span: Range<usize>,
    field: String,
}

impl<'t> Node<'t> {
    pub(super) fn place(&self, d: &Decoder<'_>) -> Place {
        d.place(self.span.clone(), self.field.clone())
    }

    fn wrong_type(&self, d: &mut Decoder<'_>, expected: impl Into<String>) {
        let problem = Problem::WrongType { found: type_name(self.value), expected: expected.into() };
        d.error(self.place(d), problem);
    }

    pub(super) fn is_text(&self) -> bool {
        self.value.is_str()
    }

    pub(super) fn is_boolean(&self) -> bool {
        self.value.is_bool()
    }

    pub(super) fn is_array(&self) -> bool {
        self.value.is_array()
    }

    pub(super) fn is_table(&self) -> bool {
        self.value.is_table()
    }

    pub(super) fn text(&self, d: &mut Decoder<'_>, expected: &str) -> Option<&'t str> {
        let text = self.value.as_str();
        if text.is_none() {
            self.wrong_type(d, expected);
        }
        text
    }

    pub(super) fn boolean(&self, d: &mut Decoder<'_>) -> Option<bool> {
        let flag = self.value.as_bool();
        if flag.is_none() {
            self.wrong_type(d, "true or false");
        }
        flag
    }

    pub(super) fn integer(&self, d: &mut Decoder<'_>, low: i64, high: i64) -> Option<i64> {
        let expected = format!("a whole number from {low} to {high}");
        let Some(integer) = self.value.as_integer() else {
            self.wrong_type(d, expected);
            return None;
        };
        let digits = integer.as_str().replace('_', "");
        match i64::from_str_radix(&digits, integer.radix()) {
            Ok(value) if (low..=high).contains(&value) => Some(value),
            Ok(value) => {
                d.error(self.place(d), Problem::OutOfRange { value: value as f64, expected });
                None
            }
            Err(_) => {
                d.error(self.place(d), Problem::WrongType { found: "too large a number", expected });
                None
            }
        }
    }

    pub(super) fn number(&self, d: &mut Decoder<'_>, quantity: Quantity) -> Option<f64> {
        if !matches!(self.value, DeValue::Float(_) | DeValue::Integer(_)) {
            self.wrong_type(d, quantity.expected());
            return None;
        }
        // Digits beyond the range of the type count as infinite.
        let value = self.peek_number().unwrap_or(f64::INFINITY);
        if !value.is_finite() {
            d.error(self.place(d), Problem::NotFinite { expected: quantity.expected() });
        } else if !quantity.admits(value) {
            d.error(self.place(d), Problem::OutOfRange { value, expected: quantity.expected() });
        } else {
            return Some(value);
        }
        None
    }

    /// The number at this place, without a check of its range.
    pub(super) fn peek_number(&self) -> Option<f64> {
        match self.value {
            DeValue::Float(float) => float.as_str().replace('_', "").parse().ok(),
            DeValue::Integer(integer) => {
                i64::from_str_radix(&integer.as_str().replace('_', ""), integer.radix())
                    .ok()
                    .map(|i| i as f64)
            }
            _ => None,
        }
    }

    pub(super) fn elements(&self, d: &mut Decoder<'_>, expected: &str) -> Option<Vec<Node<'t>>> {
        let Some(array) = self.value.as_array() else {
            self.wrong_type(d, expected);
            return None;
        };
        let node = |(i, value): (usize, &'t Spanned<DeValue<'t>>)| Node {
            value: value.get_ref(),
            span: value.span(),
            field: format!("{}[{i}]", self.field),
        };
        Some(array.iter().enumerate().map(node).collect())
    }

    /// An array of as many numbers as there are places in `N`.
    pub(super) fn numbers<const N: usize>(
        &self,
        d: &mut Decoder<'_>,
        quantity: Quantity,
    ) -> Option<[f64; N]> {
        let unit = quantity.unit();
        let before = if unit.is_empty() { "" } else { " in " };
        let expected = format!("an array of {N} numbers{before}{unit}");
        let elements = self.elements(d, &expected)?;
        if elements.len() != N {
            d.error(self.place(d), Problem::WrongLength { found: elements.len(), expected });
            return None;
        }
        // Every element is read before the array is rejected.
        let read: Vec<Option<f64>> = elements.iter().map(|e| e.number(d, quantity)).collect();
        let mut numbers = [0.0; N];
        for (slot, value) in numbers.iter_mut().zip(read) {
            *slot = value?;
        }
        Some(numbers)
    }

    pub(super) fn vector(&self, d: &mut Decoder<'_>, unit: &'static str) -> Option<DVec3> {
        self.numbers::<3>(d, Quantity::coordinate(unit)).map(DVec3::from_array)
    }

    /// A vector of any length but 0, as a unit vector.
    pub(super) fn direction(&self, d: &mut Decoder<'_>) -> Option<DVec3> {
        let vector = DVec3::from_array(self.numbers::<3>(d, Quantity::any(""))?);
        // Scaled first, so that neither tiny nor huge components underflow or overflow when squared.
        let scaled = vector / vector.abs().max_element();
        let unit = scaled.try_normalize();
        if unit.is_none() {
            d.error(
                self.place(d),
                Problem::NoDirection { expected: "a vector that is not zero, such as [0, 1, 0]" },
            );
        }
        unit
    }

    /// One of a list of words.
    pub(super) fn choice<T: Copy>(
        &self,
        d: &mut Decoder<'_>,
        what: &'static str,
        words: &[(&str, T)],
    ) -> Option<T> {
        let names: Vec<String> = words.iter().map(|(word, _)| format!("\"{word}\"")).collect();
        let text = self.text(d, &format!("one of {}", names.join(", ")))?;
        let found = words.iter().find(|(word, _)| *word == text).map(|(_, value)| *value);
        if found.is_none() {
            d.unknown_name(self.place(d), what, text, words.iter().map(|(word, _)| *word));
        }
        found
    }

    /// A value of a table whose other keys are checked elsewhere.
    pub(super) fn get(&self, d: &Decoder<'_>, key: &str) -> Option<Node<'t>> {
        let table = self.value.as_table()?;
        Section { table, place: self.place(d), misspelt: Vec::new() }.get(key)
    }

    /// A table whose keys are all among `keys`.
    pub(super) fn section(&self, d: &mut Decoder<'_>, keys: &'static [&'static str]) -> Option<Section<'t>> {
        let Some(table) = self.value.as_table() else {
            let expected = match self.field.rsplit_once(']') {
                // An element of a list of tables.
                Some((_, "")) => "a table, such as { ... }".to_owned(),
                _ => format!("a table, such as {{ {} = ... }}", keys.first().unwrap_or(&"key")),
            };
            self.wrong_type(d, expected);
            return None;
        };
        Some(Section::new(d, table, self.place(d), keys))
    }
}

/// A table whose keys have been checked.
pub(super) struct Section<'t> {
    table: &'t DeTable<'t>,
    pub(super) place: Place,
    /// Likely intended keys of unknown keys: they count as misspelt, not as missing.
    misspelt: Vec<String>,
}

impl<'t> Section<'t> {
    pub(super) fn new(
        d: &mut Decoder<'_>,
        table: &'t DeTable<'t>,
        place: Place,
        keys: &'static [&'static str],
    ) -> Self {
        let mut section = Section { table, place, misspelt: Vec::new() };
        for (key, _) in table.iter() {
            let name: &str = key.get_ref();
            if !keys.contains(&name) {
                let place = d.place(key.span(), section.path(name));
                if let Some(former) = FormerKey::of(name, keys) {
                    section.note_former(d, place, former);
                    continue;
                }
                let nearest = d.nearest(name, keys);
                section.misspelt.extend(nearest.clone());
                d.error(place, Problem::UnknownKey { key: name.to_owned(), nearest, accepted: keys });
            }
        }
        section
    }

    /// A table whose keys are names that the user chooses.
    pub(super) fn of_names(d: &mut Decoder<'_>, node: &Node<'t>) -> Vec<(&'t str, Node<'t>)> {
        let Some(table) = node.value.as_table() else {
            node.wrong_type(d, "a table of tables, such as [material.NAME]");
            return Vec::new();
        };
        let section = Section { table, place: node.place(d), misspelt: Vec::new() };
        table.iter().filter_map(|(key, _)| Some((&**key.get_ref(), section.get(key.get_ref())?))).collect()
    }

    /// Warns of a former key, or records an error where its replacement is present too.
    fn note_former(&self, d: &mut Decoder<'_>, place: Place, former: FormerKey) {
        let FormerKey { name: key, replacement, conflict } = former;
        if self.table.contains_key(replacement) {
            d.error(place, Problem::Conflict { key, other: conflict });
        } else {
            d.warn(place, Doubt::FormerKey { former: key, key: replacement });
        }
    }

    /// The key and its value; the key may be present under its former name.
    fn entry(&self, key: &str) -> Option<(&'t str, &'t Spanned<DeValue<'t>>)> {
        let named = |name: &str| self.table.get_key_value(name);
        let (key, value) = named(key).or_else(|| named(FormerKey::replaced_by(key)?.name))?;
        Some((&**key.get_ref(), value))
    }

    fn path(&self, key: &str) -> String {
        if self.place.field.is_empty() { key.to_owned() } else { format!("{}.{key}", self.place.field) }
    }

    pub(super) fn get(&self, key: &str) -> Option<Node<'t>> {
        let (key, value) = self.entry(key)?;
        Some(Node { value: value.get_ref(), span: value.span(), field: self.path(key) })
    }

    pub(super) fn has(&self, key: &str) -> bool {
        self.entry(key).is_some()
    }

    /// Whether a key is present, possibly misspelt.
    pub(super) fn mentions(&self, key: &str) -> bool {
        self.has(key) || self.misspelt.iter().any(|misspelt| misspelt == key)
    }

    pub(super) fn missing(&self, d: &mut Decoder<'_>, key: &'static str, expected: impl Into<String>) {
        if !self.mentions(key) {
            d.error(self.place.clone(), Problem::Missing { key, expected: expected.into() });
        }
    }

    /// Records a conflict at `key` if both it and `other` are present.
    pub(super) fn exclude(
        &self,
        d: &mut Decoder<'_>,
        key: &'static str,
        other: &'static str,
        words: &'static str,
    ) {
        if self.has(other)
            && let Some(node) = self.get(key)
        {
            d.error(node.place(d), Problem::Conflict { key, other: words });
        }
    }

    pub(super) fn number(&self, d: &mut Decoder<'_>, key: &str, quantity: Quantity) -> Option<f64> {
        self.get(key)?.number(d, quantity)
    }

    pub(super) fn vector(&self, d: &mut Decoder<'_>, key: &str, unit: &'static str) -> Option<DVec3> {
        self.get(key)?.vector(d, unit)
    }

    pub(super) fn text(&self, d: &mut Decoder<'_>, key: &str, expected: &str) -> Option<&'t str> {
        self.get(key)?.text(d, expected)
    }

    pub(super) fn boolean(&self, d: &mut Decoder<'_>, key: &str) -> Option<bool> {
        self.get(key)?.boolean(d)
    }

    pub(super) fn integer(&self, d: &mut Decoder<'_>, key: &str, low: i64, high: i64) -> Option<i64> {
        self.get(key)?.integer(d, low, high)
    }

    pub(super) fn choice<T: Copy>(
        &self,
        d: &mut Decoder<'_>,
        key: &'static str,
        words: &[(&str, T)],
    ) -> Option<T> {
        self.get(key)?.choice(d, key, words)
    }

    /// The tables of a `[[key]]` list.
    pub(super) fn list(
        &self,
        d: &mut Decoder<'_>,
        key: &'static str,
        keys: &'static [&'static str],
    ) -> Vec<Section<'t>> {
        let Some(node) = self.get(key) else { return Vec::new() };
        let Some(elements) = node.elements(d, &format!("a list of tables: [[{key}]]")) else {
            return Vec::new();
        };
        elements.iter().filter_map(|e| e.section(d, keys)).collect()
    }
}

fn type_name(value: &DeValue<'_>) -> &'static str {
    match value {
        DeValue::String(_) => "text",
        DeValue::Integer(_) => "a whole number",
        DeValue::Float(_) => "a number",
        DeValue::Boolean(_) => "true or false",
        DeValue::Datetime(_) => "a date or time",
        DeValue::Array(_) => "an array",
        DeValue::Table(_) => "a table",
    }
}
