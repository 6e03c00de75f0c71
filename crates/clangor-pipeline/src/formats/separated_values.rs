//! Lines of separated values: commas, or semicolons or tabs where the header has no comma.
//!
//! Values may stand in double quotes, within which a separator is none and two quotes are one. Where commas
//! do not separate, numbers may have one for their decimal point, but then all of them: `1,234` beside `1.5`
//! is one thousand with a separator of thousands, and such separators are refused. Where no other number
//! shows it, `1,234` is 1.234. A first column without a name that counts the rows from 0, as pandas writes
//! it, is left out.

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
    /// A number with a separator of thousands.
    #[error("{text} has a separator of thousands; write numbers without any")]
    Thousands {
        /// The number.
        text: String,
    },
    /// A number with a decimal comma, and another one with a point.
    #[error(
        "{text} stands here and {other} in line {line}: either one of them has a separator of thousands, or \
         the decimal signs differ; write all numbers with the same decimal sign, and none with a separator \
         of thousands"
    )]
    DecimalSigns {
        /// The number.
        text: String,
        /// The other number.
        other: String,
        /// Its line, from 1.
        line: u64,
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
#[derive(Clone, Debug)]
pub(crate) struct SeparatedValues {
    separator: char,
    /// Whether the first column has no name.
    is_numbered: bool,
    /// Whether a column holds names, and not numbers.
    has_names: Vec<bool>,
    rows: u64,
    /// The first number with a decimal sign.
    marked: Option<Marked>,
}

/// A number with a decimal sign.
#[derive(Clone, Debug)]
struct Marked {
    sign: char,
    text: String,
    line: u64,
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
        let has_names = names.iter().map(|name| name.starts_with("body") || name == "kind").collect();
        Ok((SeparatedValues { separator, is_numbered, has_names, rows: 0, marked: None }, names))
    }

    /// The values of the next line, one for each name; `number` is that of the line in its file, from 1.
    ///
    /// # Errors
    /// [`ValueFault`] for broken quotes, separators of thousands, and where a column without a name does not
    /// count the rows.
    pub(crate) fn next(&mut self, line: &str, number: u64) -> Result<Vec<String>, ValueFault> {
        let mut values = split(line, self.separator)?;
        if self.is_numbered {
            let text = values.remove(0);
            if text.parse() != Ok(self.rows as f64) {
                return Err(ValueFault::Unnamed { text });
            }
        }
        self.rows += 1;
        for (place, text) in values.iter_mut().enumerate() {
            if text.contains([',', '.']) && !self.has_names.get(place).copied().unwrap_or(false) {
                self.take_decimal_sign(text, number)?;
            }
        }
        Ok(values)
    }

    /// Writes a number with a decimal comma with a point, where commas do not separate.
    fn take_decimal_sign(&mut self, text: &mut String, line: u64) -> Result<(), ValueFault> {
        let is_number = |text: String| text.parse::<f64>().is_ok();
        let [commas, points] = [',', '.'].map(|sign| text.matches(sign).count());
        if commas + points > 1 {
            return match has_thousands(text, commas > 0 && points > 0) {
                true => Err(ValueFault::Thousands { text: text.clone() }),
                false => Ok(()),
            };
        }
        let sign = if commas == 1 { ',' } else { '.' };
        let is_known = self.marked.as_ref().is_some_and(|marked| marked.sign == sign);
        if self.separator == ',' || is_known && sign == '.' || !is_number(text.replace(',', ".")) {
            return Ok(());
        }
        let marked = self.marked.get_or_insert_with(|| Marked { sign, text: text.clone(), line });
        if marked.sign != sign {
            let Marked { text: other, line, .. } = marked.clone();
            return Err(ValueFault::DecimalSigns { text: text.clone(), other, line });
        }
        if sign == ',' {
            *text = text.replace(',', ".");
        }
        Ok(())
    }
}

/// Whether commas and points divide a number into thousands; the last of two kinds of signs is the decimal
/// one.
fn has_thousands(text: &str, has_both: bool) -> bool {
    let digits = text.strip_prefix(['-', '+']).unwrap_or(text);
    let mut groups: Vec<&str> = digits.split([',', '.']).collect();
    if has_both {
        groups.pop();
    }
    let are_digits = |group: &&str| !group.is_empty() && group.bytes().all(|b| b.is_ascii_digit());
    groups.iter().all(are_digits) && groups[1..].iter().all(|group| group.len() == 3)
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
