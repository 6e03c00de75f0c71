//! Measures the structure of the source code of this repository with a real parser.
//!
//! | module | measure |
//! |---|---|
//! | [`source_files`] | the files that are measured |
//! | [`rust_syntax`] | parsing, and which parts of a file are tests |
//! | [`module_tree`] | the modules of a crate, the names each declares and imports |
//! | [`name_resolution`] | from a path in the code to the file that defines the item |
//! | [`path_scan`] | all paths of a file, also those inside macro invocations |
//! | [`module_graph`] | which file uses items of which, and its cycles |
//! | [`dependency_cycle`] | a cycle, and the edges whose removal opens it at the least cost |
//! | [`measures`] | lengths of files, functions, parameter lists and lines |
//! | [`narrow_dispatch`] | closures that would run with narrow vectors |
//! | [`old_names`] | names that have been replaced and must not return |
//! | [`old_name_table`] | the list of those names |
//!
//! `cargo run -p clangor-structure` prints a report; `tests/property_structure.rs` holds the limits.

pub mod dependency_cycle;
pub mod measures;
pub mod module_graph;
pub mod module_tree;
pub mod name_resolution;
pub mod narrow_dispatch;
pub mod old_name_table;
pub mod old_names;
pub mod path_scan;
pub mod rust_syntax;
pub mod source_files;
