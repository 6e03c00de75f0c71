//! The examples are short, need nothing but this crate, and stand in the documentation as they are.

use std::fs;
use std::path::Path;

/// Each example and how many lines it may have.
const EXAMPLES: [(&str, usize); 3] = [("scene_to_wav", 10), ("struck_bowl", 15), ("real_time", 25)];

#[test]
fn examples_are_short_and_import_only_this_crate() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let documentation = fs::read_to_string(folder.join("src/lib.rs")).expect("the library");
    for (name, most) in EXAMPLES {
        let text = fs::read_to_string(folder.join(format!("examples/{name}.rs"))).expect("an example");
        // The first line is a comment: how to run it.
        let lines: Vec<&str> = text.lines().skip(1).collect();
        assert!(lines.len() <= most, "{name}: {} lines of at most {most}", lines.len());
        let imports: Vec<_> = lines.iter().filter(|line| line.trim_start().starts_with("use ")).collect();
        assert!(imports.iter().all(|line| line.contains("use clangor::")), "{name}: {imports:?}");
        let quoted: String =
            lines.iter().map(|line| format!("//! {line}").trim_end().to_owned() + "\n").collect();
        assert!(documentation.contains(&quoted), "{name} differs from the documentation");
    }
}
