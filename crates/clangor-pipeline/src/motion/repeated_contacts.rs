//! Rows of contact lists that repeat another row: one impact, heard twice as loud.
//!
//! Programs that ask each body for its contacts write every one twice, the second time with the bodies
//! exchanged and the normal reversed; lists that were joined have rows twice as they are. A repetition has
//! the same time, kind, bodies, point and impulse, to the last digit.
//!
//! Not for impacts that are nearly the same: two corners may well have them.

use std::collections::HashMap;
use std::fmt;
use std::path::{Path, PathBuf};

use clangor_core::timeline::ContactRow;

use crate::formats::contact_list::ListedContact;

/// Digits of what makes a row, with the bodies in one order.
type Key = ([u64; 8], u8, [u32; 2]);

/// The rows of lists so far.
#[derive(Debug, Default)]
pub(crate) struct RepeatedContacts {
    /// The list and the row of each.
    known: HashMap<Key, (usize, usize)>,
    lists: Vec<PathBuf>,
}

/// Rows of a list that repeat others, for people.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct RepeatedNotice {
    count: usize,
    /// The first of them.
    row: usize,
    /// The row that it repeats, and its list if that is another.
    first: (usize, Option<PathBuf>),
}

impl RepeatedContacts {
    /// Adds the rows of a list, which come in order of time, and finds which are repetitions.
    pub(crate) fn look(&mut self, list: &Path, rows: &[ListedContact]) -> Option<RepeatedNotice> {
        let own = self.lists.len();
        self.lists.push(list.into());
        let (mut count, mut first) = (0, None);
        for ListedContact { line, row, .. } in rows.iter().filter(|listed| pushes(&listed.row)) {
            let known = *self.known.entry(key(row)).or_insert((own, *line));
            if known != (own, *line) {
                count += 1;
                let pair =
                    if known.0 == own { [known.1.min(*line), known.1.max(*line)] } else { [known.1, *line] };
                first = first.or(Some((pair[1], (pair[0], known.0))));
            }
        }
        let (row, (repeated, of)) = first?;
        let other = (of != own).then(|| self.lists[of].clone());
        Some(RepeatedNotice { count, row, first: (repeated, other) })
    }
}

fn pushes(row: &ContactRow) -> bool {
    row.impulse().length_squared() > 0.0
}

fn key(row: &ContactRow) -> Key {
    let (is_exchanged, bodies) = match [row.body_a.0, row.body_b.0] {
        [a, b] if a <= b => (false, [a, b]),
        [a, b] => (true, [b, a]),
    };
    let impulse = if is_exchanged { -row.impulse_t } else { row.impulse_t };
    let [x, y, z] = row.point.to_array();
    let [u, v, w] = impulse.to_array();
    // Adding 0 makes −0 positive.
    let numbers = [row.time, x, y, z, row.impulse_n, u, v, w].map(|number| (number + 0.0).to_bits());
    (numbers, row.kind as u8, bodies)
}

impl fmt::Display for RepeatedNotice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let RepeatedNotice { count, row, first: (repeated, list) } = self;
        let of = list.as_ref().map_or_else(String::new, |list| format!(" of {}", list.display()));
        match count {
            1 => write!(f, "row {row} repeats row {repeated}{of}")?,
            more => {
                write!(f, "{more} rows repeat others, first row {row}, which repeats row {repeated}{of}")?
            }
        }
        write!(
            f,
            ": time, bodies, point and impulse are the same, and the contact sounds twice as loud; list each \
             contact once, not once for each body"
        )
    }
}
