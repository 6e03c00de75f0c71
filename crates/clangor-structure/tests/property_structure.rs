//! The sources keep their structure: no dependency cycles, short files, functions, parameter lists and lines,
//! no loops that would run with narrow vectors, and no name that has been replaced.

use std::fmt::Display;
use std::path::Path;

use clangor_structure::measures::{above, file_lengths, functions, line_lengths};
use clangor_structure::module_graph::{cycles_of_crates, graphs_of_crates};
use clangor_structure::narrow_dispatch::dispatched_closures;
use clangor_structure::old_name_table::{ALIAS_FILES, OLD_NAMES};
use clangor_structure::old_names::remaining;
use clangor_structure::rust_syntax::test_only_files;
use clangor_structure::source_files::SourceTree;

/// Longest file \[lines\], without tests.
const MOST_FILE_LINES: usize = 500;

/// Longest function \[lines\], without tests.
const MOST_FUNCTION_LINES: usize = 80;

/// Longest parameter list, without the receiver and without tests.
const MOST_PARAMETERS: usize = 6;

/// Longest line \[columns\], tests included.
const MOST_COLUMNS: usize = 110;

/// The sources where the test runs: an executable may have been built elsewhere, in a shared target folder.
fn repository() -> SourceTree {
    let built_for = env!("CARGO_MANIFEST_DIR").to_owned();
    let root = Path::new(&std::env::var("CARGO_MANIFEST_DIR").unwrap_or(built_for)).join("../..");
    SourceTree::read(&root).expect("the sources of this repository")
}

/// Fails with one line for each offender.
fn assert_none<T: Display>(what: &str, offenders: &[T]) {
    let list: String = offenders.iter().map(|offender| format!("\n{offender}")).collect();
    assert!(offenders.is_empty(), "{} {what}:{list}", offenders.len());
}

#[test]
fn no_dependency_cycles() {
    assert_none("dependency cycles", &cycles_of_crates(&repository()));
}

#[test]
fn the_graph_covers_the_sources() {
    let tree = repository();
    let graphs = graphs_of_crates(&tree);
    let edges: usize = graphs.iter().map(|graph| graph.edges.len()).sum();
    assert!(edges > 1000, "only {edges} edges were found: does the scan still work?");
    let in_src = |path: &str| path.split('/').nth(2) == Some("src");
    let tests = test_only_files(&tree);
    let missing: Vec<&str> = tree
        .rust_files()
        .map(|file| file.path.as_str())
        .filter(|path| {
            in_src(path)
                && !tests.contains(*path)
                && !graphs.iter().any(|graph| graph.files.iter().any(|f| f == path))
        })
        .collect();
    assert_none("source files that no module declares outside of tests", &missing);
}

#[test]
fn files_are_short() {
    let offenders = above(MOST_FILE_LINES, file_lengths(&repository()));
    assert_none(&format!("files above {MOST_FILE_LINES} lines"), &offenders);
}

#[test]
fn functions_are_short() {
    let offenders = above(MOST_FUNCTION_LINES, functions(&repository()).lengths);
    assert_none(&format!("functions above {MOST_FUNCTION_LINES} lines"), &offenders);
}

#[test]
fn parameter_lists_are_short() {
    let offenders = above(MOST_PARAMETERS, functions(&repository()).parameters);
    assert_none(&format!("functions above {MOST_PARAMETERS} parameters"), &offenders);
}

#[test]
fn lines_are_short() {
    let offenders = above(MOST_COLUMNS, line_lengths(&repository()));
    assert_none(&format!("lines above {MOST_COLUMNS} columns"), &offenders);
}

#[test]
fn no_closure_is_dispatched_to_wide_vectors() {
    assert_none("closures in a dispatch: make them types with WithSimd", &dispatched_closures(&repository()));
}

#[test]
fn old_names_are_gone() {
    let tree = repository();
    for path in ALIAS_FILES {
        assert!(tree.file(path).is_some(), "{path} is exempt but does not exist");
    }
    assert_none("old names", &remaining(&tree, OLD_NAMES, ALIAS_FILES));
}
