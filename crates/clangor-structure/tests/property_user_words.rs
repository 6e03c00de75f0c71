//! Keys of scenes and options of the program bear the field's words; former words live in alias tables only.

use std::path::{Path, PathBuf};
use std::{fs, io};

/// Folders and endings of files with words of the user, and beginnings of lines that are former words.
const FORMER: &[(&str, &str, &[&str])] = &[
    ("scenes", "toml", &["sound = ", "ringing = ", "[sound", "[ringing"]),
    ("docs/format", "md", &["sound = ", "ringing = "]),
    ("crates/clangor-cli/src/arguments", "rs", &["Published,", "#[value(name = \"published\")]"]),
    ("crates/clangor-core/src/scene/decode", "rs", &["\"sound\",", "\"ringing\","]),
];

/// Files that list former words as aliases.
const ALIAS_TABLES: &[&str] = &["former_keys.rs", "former_names.rs"];

fn files(folder: &Path, ending: &str, found: &mut Vec<PathBuf>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            files(&path, ending, found)?;
        } else if path.extension().is_some_and(|e| e == ending) {
            found.push(path);
        }
    }
    Ok(())
}

#[test]
fn former_keys_and_options_are_in_alias_tables_only() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    for (folder, ending, former) in FORMER {
        let mut found = Vec::new();
        files(&root.join(folder), ending, &mut found).expect("a folder of the repository");
        assert!(!found.is_empty(), "{folder} has no file that ends in {ending}");
        for path in found {
            if ALIAS_TABLES.iter().any(|table| path.ends_with(table)) {
                continue;
            }
            let text = fs::read_to_string(&path).expect("text");
            for (number, line) in text.lines().enumerate() {
                let word = former.iter().find(|word| line.trim_start().starts_with(**word));
                assert!(word.is_none(), "{}:{}: {line}", path.display(), number + 1);
            }
        }
    }
}
