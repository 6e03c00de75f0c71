//! Prints all measures of a repository: `clangor-structure [ROOT]`, by default of this one.

use std::path::PathBuf;
use std::process::ExitCode;

use clangor_structure::measures::{Measure, above, file_lengths, functions, line_lengths};
use clangor_structure::module_graph::{cycles_of_crates, graphs_of_crates};
use clangor_structure::old_name_table::{ALIAS_FILES, OLD_NAMES};
use clangor_structure::old_names::remaining;
use clangor_structure::source_files::SourceTree;

fn main() -> ExitCode {
    let root = std::env::args_os()
        .nth(1)
        .map_or_else(|| PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")), PathBuf::from);
    match SourceTree::read(&root) {
        Ok(tree) => {
            print_report(&tree);
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("{}: {error}", root.display());
            ExitCode::FAILURE
        }
    }
}

fn print_report(tree: &SourceTree) {
    let cycles = cycles_of_crates(tree);
    let sizes: Vec<usize> = cycles.iter().map(|cycle| cycle.files.len()).collect();
    println!("Dependency cycles: {}, files in each: {sizes:?}\n", cycles.len());
    cycles.iter().for_each(|cycle| println!("{cycle}"));
    print_cycles_through_parents(tree);
    let functions = functions(tree);
    print_measures("Files above 500 lines", 500, file_lengths(tree));
    print_measures("Functions above 80 lines", 80, functions.lengths);
    print_measures("Functions above 6 parameters", 6, functions.parameters);
    print_measures("Lines above 110 columns", 110, line_lengths(tree));
    let names = remaining(tree, OLD_NAMES, ALIAS_FILES);
    println!("Old names: {}", names.len());
    names.iter().for_each(|name| println!("  {name}"));
}

fn print_cycles_through_parents(tree: &SourceTree) {
    println!("For information: cycles that include edges between parents and children, which are allowed:");
    for cycle in graphs_of_crates(tree).iter().flat_map(|graph| graph.cycles_through_parents()) {
        println!("  {} files: {}", cycle.files.len(), cycle.files.join(" "));
    }
    println!();
}

fn print_measures(title: &str, limit: usize, measures: Vec<Measure>) {
    let largest = measures.iter().max_by_key(|measure| measure.number).cloned();
    let offenders = above(limit, measures);
    println!("{title}: {}", offenders.len());
    offenders.iter().for_each(|measure| println!("  {measure}"));
    if let (true, Some(largest)) = (offenders.is_empty(), largest) {
        println!("  largest: {largest}");
    }
    println!();
}
