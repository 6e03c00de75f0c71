//! Options and values that have been renamed.
//!
//! A former name means what the new one means, and gives a warning. It is accepted for one version. The
//! words of the command line are replaced before they are parsed: the parser and its help know only the new
//! names.

use std::ffi::OsString;

/// A word of the command line that has been renamed.
enum FormerName {
    /// An option.
    Option { former: &'static str, name: &'static str },
    /// A value of an option.
    Value { option: &'static str, former: &'static str, name: &'static str },
}

const FORMER_NAMES: &[FormerName] = &[
    FormerName::Option { former: "--sound", name: "--acceleration" },
    FormerName::Option { former: "--degree", name: "--dof" },
    FormerName::Value { option: "--representation", former: "published", name: "pan" },
    FormerName::Value { option: "--transfer", former: "published", name: "frac" },
];

/// A command line under its new names.
pub(crate) struct Renewed {
    /// Its words.
    pub(crate) words: Vec<OsString>,
    /// One warning for each former name.
    pub(crate) warnings: Vec<String>,
}

/// Replaces the former names in a command line, up to the word `--`.
pub(crate) fn renew(words: impl IntoIterator<Item = OsString>) -> Renewed {
    let mut renewed = Renewed { words: Vec::new(), warnings: Vec::new() };
    let mut words = words.into_iter();
    for word in words.by_ref() {
        if word == "--" {
            renewed.words.push(word);
            break;
        }
        let word = renewed.renew_option(word);
        let word = renewed.renew_value(word);
        renewed.words.push(word);
    }
    renewed.words.extend(words);
    renewed
}

impl Renewed {
    /// `--former` and `--former=VALUE` under the new name of the option.
    fn renew_option(&mut self, word: OsString) -> OsString {
        for known in FORMER_NAMES {
            let FormerName::Option { former, name } = known else { continue };
            let Some(rest) = word.to_str().and_then(|text| text.strip_prefix(former)) else { continue };
            if rest.is_empty() || rest.starts_with('=') {
                self.warn(former, name);
                return format!("{name}{rest}").into();
            }
        }
        word
    }

    /// `--option=former`, and `former` after `--option`, as the new value.
    fn renew_value(&mut self, word: OsString) -> OsString {
        for known in FORMER_NAMES {
            let FormerName::Value { option, former, name } = known else { continue };
            let prefix = match self.words.last() {
                Some(last) if last == option => String::new(),
                _ => format!("{option}="),
            };
            if word.to_str().and_then(|text| text.strip_prefix(&prefix)) == Some(former) {
                self.warn(&format!("{option} {former}"), &format!("{option} {name}"));
                return format!("{prefix}{name}").into();
            }
        }
        word
    }

    fn warn(&mut self, former: &str, name: &str) {
        let warning = format!("`{former}` is now `{name}`; the former name is accepted in this version only");
        self.warnings.push(warning);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn renewed(line: &str) -> (String, Vec<String>) {
        let Renewed { words, warnings } = renew(line.split(' ').map(OsString::from));
        let words: Vec<&str> = words.iter().map(|word| word.to_str().unwrap()).collect();
        (words.join(" "), warnings)
    }

    #[test]
    fn former_names_are_replaced_with_a_warning_that_names_the_new_ones() {
        let cases = [
            ("render a.toml --sound own", "render a.toml --acceleration own", "`--acceleration`"),
            ("strike coin --sound=proxy", "strike coin --acceleration=proxy", "`--acceleration`"),
            ("plot field m --degree rx", "plot field m --dof rx", "`--dof`"),
            ("bake c --representation published", "bake c --representation pan", "`--representation pan`"),
            ("bake c --representation=published", "bake c --representation=pan", "`--representation pan`"),
            ("render a --transfer published", "render a --transfer frac", "`--transfer frac`"),
            ("render a --transfer=published", "render a --transfer=frac", "`--transfer frac`"),
        ];
        for (former, new, named) in cases {
            let (words, warnings) = renewed(former);
            assert_eq!(words, new);
            assert!(warnings.len() == 1 && warnings[0].contains(named), "{warnings:?}");
            assert_eq!(renewed(new), (new.into(), Vec::new()));
        }
    }

    #[test]
    fn other_words_stay() {
        for line in ["render published", "render a --soundly b", "render -- --sound", "bake published -o a"] {
            assert_eq!(renewed(line), (line.into(), Vec::new()));
        }
    }
}
