//! Lines of separated values: commas, or semicolons or tabs where the header has no comma.
//!
//! Values may stand in double quotes, within which a separator is none and two quotes are one. Where commas
//! do not separate, a number may have one for its decimal point. A first column without a name that counts
//! the rows from 0, as pandas writes it, is left out.

/// What is wrong with a line of separated values.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ValueFault {
    /// A column of the header without a name.
    #[error("column {column} of the header has no name; name it, or delete it (a separator too many?)")]
    NoName {
        /// Its number, from 1.
        column: usize,
    },
    /// A first column without a name that is no number of the row.
    #[error(
        "the first column has no name, and is {text} here, which does not count the rows from 0; name it, \
         or leave it out (pandas: to_csv(FILE, index=False))"
    )]
    Unnamed {
        /// What is there.
        text: String,
    },
    /// Broken quotes.
    #[error("at column {place}: {reason}")]
    Quotes {
        /// Place in the line, from 1.
        place: usize,
        /// What is wrong.
        reason: String,
    },
}

/// How the lines of a file are divided.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SeparatedValues {
    separator: char,
    /// Whether the first column has no name.
    is_numbered: bool,
    rows: u64,
}

impl SeparatedValues {
    /// Of a file with this header, and the names of its columns.
    ///
    /// # Errors
    /// [`ValueFault`] for broken quotes and columns without a name.
    pub(crate) fn of_header(line: &str) -> Result<(Self, Vec<String>), ValueFault> {
        let separator = [',', ';', '\t'].into_iter().find(|separator| line.contains(*separator));
        let separator = separator.unwrap_or(',');
        let mut names = split(line, separator)?;
        let is_numbered = names.len() > 1 && names[0].is_empty();
        if is_numbered {
            names.remove(0);
        }
        if let Some(place) = names.iter().position(String::is_empty) {
            return Err(ValueFault::NoName { column: place + 1 + usize::from(is_numbered) });
        }
        Ok((SeparatedValues { separator, is_numbered, rows: 0 }, names))
    }

    /// The values of the next line, one for each name.
    ///
    /// # Errors
    /// [`ValueFault`] for broken quotes, and where a column without a name does not count the rows.
    pub(crate) fn next(&mut self, line: &str) -> Result<Vec<String>, ValueFault> {
        let mut values = split(line, self.separator)?;
        if self.is_numbered {
            let text = values.remove(0);
            if text.parse() != Ok(self.rows as f64) {
                return Err(ValueFault::Unnamed { text });
            }
        }
        self.rows += 1;
        if self.separator != ',' {
            values.iter_mut().for_each(point_for_comma);
        }
        Ok(values)
    }
}

/// Writes a number with a decimal comma with a point.
fn point_for_comma(text: &mut String) {
    if text.matches(',').count() == 1 && !text.contains('.') {
        let number = text.replace(',', ".");
        if number.parse::<f64>().is_ok() {
            *text = number;
        }
    }
}

/// The values of a line, spaces around them removed.
fn split(line: &str, separator: char) -> Result<Vec<String>, ValueFault> {
    let syntax = |at: usize, reason: String| ValueFault::Quotes { place: at + 1, reason };
    // A tab is a separator and no space then.
    let is_space = |c: char| c.is_whitespace() && c != separator;
    let mut values = Vec::new();
    let mut rest = line;
    loop {
        let trimmed = rest.trim_start_matches(is_space);
        let at = line.len() - trimmed.len();
        if let Some(quoted) = trimmed.strip_prefix('"') {
            let (value, after) =
                unquote(quoted).ok_or_else(|| syntax(at, "the quote is not closed".into()))?;
            values.push(value);
            let after = after.trim_start_matches(is_space);
            if after.is_empty() {
                return Ok(values);
            }
            let place = line.len() - after.len();
            let name = match separator {
                ',' => "comma",
                ';' => "semicolon",
                _ => "tab",
            };
            let wrong = || syntax(place, format!("a {name} is expected after the quote"));
            rest = after.strip_prefix(separator).ok_or_else(wrong)?;
        } else if let Some((value, after)) = trimmed.split_once(separator) {
            values.push(value.trim_end_matches(is_space).into());
            rest = after;
        } else {
            values.push(trimmed.trim_end_matches(is_space).into());
            return Ok(values);
        }
    }
}

/// The value up to the closing quote, and what follows it.
fn unquote(text: &str) -> Option<(String, &str)> {
    let mut value = String::new();
    let mut rest = text;
    loop {
        let (part, after) = rest.split_once('"')?;
        value.push_str(part);
        match after.strip_prefix('"') {
            Some(after) => {
                value.push('"');
                rest = after;
            }
            None => return Some((value, after)),
        }
    }
}

/// How many values there are, for people.
pub(crate) fn values_of(count: usize) -> String {
    if count == 1 { "there is 1 value".into() } else { format!("there are {count} values") }
}
