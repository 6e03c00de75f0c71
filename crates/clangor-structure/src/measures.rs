//! Measures lengths: of files, functions, parameter lists and lines.
//!
//! Tests do not count, except for the length of lines: neither folders `tests` nor items for tests only.

use std::collections::BTreeSet;
use std::fmt;

use syn::visit::{self, Visit};
use syn::{Block, FnArg, ImplItemFn, Item, ItemFn, Signature, TraitItemFn, Visibility};

use crate::rust_syntax::{attributes, is_test_only, parse, test_line_ranges, test_only_files};
use crate::source_files::{Language, SourceFile, SourceTree};

/// A number with its place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Measure {
    /// Path of the file.
    pub path: String,
    /// Line, counted from 1.
    pub line: usize,
    /// What is measured: the name of a function, the begin of a line, or nothing for a file.
    pub what: String,
    /// The measured number.
    pub number: usize,
}

impl fmt::Display for Measure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}: {} {}", self.path, self.line, self.number, self.what)
    }
}

/// Returns the measures above a limit, the largest first.
pub fn above(limit: usize, measures: Vec<Measure>) -> Vec<Measure> {
    let mut found: Vec<Measure> = measures.into_iter().filter(|measure| measure.number > limit).collect();
    found.sort_by(|a, b| b.number.cmp(&a.number).then_with(|| (&a.path, a.line).cmp(&(&b.path, b.line))));
    found
}

/// Returns the files that are no tests as a whole.
fn files_beside_tests(tree: &SourceTree) -> impl Iterator<Item = &SourceFile> {
    let tests: BTreeSet<String> = test_only_files(tree);
    tree.files.iter().filter(move |file| !file.is_in_tests_folder() && !tests.contains(&file.path))
}

/// Measures the lines of every file, without tests.
pub fn file_lengths(tree: &SourceTree) -> Vec<Measure> {
    let length = |file: &SourceFile| {
        let lines = file.text.lines().count();
        let has_tests = file.language == Language::Rust && file.text.contains("test");
        let in_tests: usize = if has_tests {
            test_line_ranges(&parse(file)).iter().map(|range| range.end() + 1 - range.start()).sum()
        } else {
            0
        };
        Measure { path: file.path.clone(), line: 1, what: "lines".into(), number: lines - in_tests }
    };
    files_beside_tests(tree).map(length).collect()
}

/// Lengths of functions and of their parameter lists.
#[derive(Clone, Debug, Default)]
pub struct FunctionMeasures {
    /// Lines from the signature to the closing brace.
    pub lengths: Vec<Measure>,
    /// Parameters without the receiver.
    pub parameters: Vec<Measure>,
}

/// Measures the functions of every Rust file, without tests.
pub fn functions(tree: &SourceTree) -> FunctionMeasures {
    let mut measures = FunctionMeasures::default();
    for file in files_beside_tests(tree).filter(|file| file.language == Language::Rust) {
        let mut scan = FunctionScan { path: &file.path, measures: &mut measures };
        scan.visit_file(&parse(file));
    }
    measures
}

struct FunctionScan<'a> {
    path: &'a str,
    measures: &'a mut FunctionMeasures,
}

impl FunctionScan<'_> {
    fn add(&mut self, visibility: Option<&Visibility>, signature: &Signature, body: Option<&Block>) {
        let start = match visibility {
            Some(Visibility::Public(word)) => word.span,
            Some(Visibility::Restricted(restricted)) => restricted.pub_token.span,
            _ => signature.fn_token.span,
        };
        let line = start.start().line;
        let what = format!("fn {}", signature.ident);
        let parameters = signature.inputs.iter().filter(|input| matches!(input, FnArg::Typed(_))).count();
        let measure = |number| Measure { path: self.path.to_string(), line, what: what.clone(), number };
        self.measures.parameters.push(measure(parameters));
        if let Some(body) = body {
            let end = body.brace_token.span.close().end().line;
            self.measures.lengths.push(measure(end + 1 - line));
        }
    }
}

impl<'ast> Visit<'ast> for FunctionScan<'_> {
    fn visit_item(&mut self, item: &'ast Item) {
        if !is_test_only(attributes(item)) {
            visit::visit_item(self, item);
        }
    }

    fn visit_item_fn(&mut self, function: &'ast ItemFn) {
        self.add(Some(&function.vis), &function.sig, Some(&function.block));
        visit::visit_item_fn(self, function);
    }

    fn visit_impl_item_fn(&mut self, function: &'ast ImplItemFn) {
        if !is_test_only(&function.attrs) {
            self.add(Some(&function.vis), &function.sig, Some(&function.block));
            visit::visit_impl_item_fn(self, function);
        }
    }

    fn visit_trait_item_fn(&mut self, function: &'ast TraitItemFn) {
        self.add(None, &function.sig, function.default.as_ref());
        visit::visit_trait_item_fn(self, function);
    }
}

/// Measures the columns of every line, tests included, without web addresses and tables.
pub fn line_lengths(tree: &SourceTree) -> Vec<Measure> {
    let mut measures = Vec::new();
    for file in &tree.files {
        for (index, line) in file.text.lines().enumerate() {
            if !is_exempt_from_width(line) {
                let what = format!("columns: {}…", line.trim().chars().take(50).collect::<String>());
                let number = line.chars().count();
                measures.push(Measure { path: file.path.clone(), line: index + 1, what, number });
            }
        }
    }
    measures
}

/// Returns true for lines that cannot be broken: web addresses, rows of comment tables, rows of numbers.
fn is_exempt_from_width(line: &str) -> bool {
    let address = line.contains("http://") || line.contains("https://");
    let comment = line.trim_start().strip_prefix("//").map(|rest| rest.trim_start_matches(['/', '!']).trim());
    let table = comment.is_some_and(|row| row.starts_with('|') && row.matches('|').count() >= 2);
    let numbers = line.chars().all(|c| c.is_ascii_digit() || " \t.,+-_eE[]()".contains(c));
    address || table || numbers
}
