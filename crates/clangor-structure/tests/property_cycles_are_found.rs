//! The search for cycles finds them in small sets of sources, and allows what it must allow.

use clangor_structure::module_graph::{cycles_of_crates, graphs_of_crates};
use clangor_structure::source_files::SourceTree;

/// Puts files into the folder `src` of one crate.
fn crate_of(files: &[(&str, &str)]) -> SourceTree {
    let paths: Vec<String> = files.iter().map(|(path, _)| format!("crates/small/src/{path}")).collect();
    let texts: Vec<(&str, &str)> =
        paths.iter().zip(files).map(|(path, (_, text))| (path.as_str(), *text)).collect();
    SourceTree::from_texts(&texts)
}

/// Returns the files of each cycle, without the folder.
fn cycles(files: &[(&str, &str)]) -> Vec<Vec<String>> {
    let short = |path: &String| path.trim_start_matches("crates/small/src/").to_string();
    cycles_of_crates(&crate_of(files)).iter().map(|cycle| cycle.files.iter().map(short).collect()).collect()
}

/// Returns the edges as `from > to`, without the folder.
fn edges(files: &[(&str, &str)]) -> Vec<String> {
    let graph = &graphs_of_crates(&crate_of(files))[0];
    let name = |file: usize| graph.files[file].trim_start_matches("crates/small/src/").to_string();
    graph.edges.keys().map(|(from, to)| format!("{} > {}", name(*from), name(*to))).collect()
}

const PAIR: [&str; 2] = ["a.rs", "b.rs"];

#[test]
fn a_cycle_through_imports() {
    let a = "use crate::b::B; pub struct A(B);";
    let b = "use super::a::{self, A}; pub struct B(Box<A>);";
    assert_eq!(cycles(&[("lib.rs", "mod a; mod b;"), ("a.rs", a), ("b.rs", b)]), [PAIR]);
}

#[test]
fn a_cycle_through_a_reexport() {
    let root = "mod a; mod b; pub use b::*; pub use a::A as First;";
    let files =
        [("lib.rs", root), ("a.rs", "pub struct A(crate::B);"), ("b.rs", "pub struct B(Box<crate::First>);")];
    assert_eq!(cycles(&files), [PAIR]);
}

#[test]
fn a_cycle_through_a_chain_of_reexports() {
    let files = [
        ("lib.rs", "mod a; mod outer; use outer::Inner;"),
        ("a.rs", "use crate::outer::Inner; pub fn a(_: Inner) {}"),
        ("outer.rs", "mod middle; pub(crate) use middle::Inner;"),
        ("outer/middle.rs", "mod inner; pub use self::inner::{Inner};"),
        ("outer/middle/inner.rs", "pub struct Inner; fn f() { crate::a::a(Inner) }"),
    ];
    assert_eq!(cycles(&files), [["a.rs", "outer/middle/inner.rs"]]);
}

#[test]
fn a_cycle_through_an_inline_super_path() {
    let files = [
        ("lib.rs", "mod a; mod b;"),
        ("a.rs", "pub fn a() { super::b::b() }"),
        ("b.rs", "pub fn b() { let f = || super::a::a(); f() }"),
    ];
    assert_eq!(cycles(&files), [PAIR]);
}

#[test]
fn a_cycle_through_an_imported_module() {
    let files = [
        ("lib.rs", "mod a; mod b;"),
        ("a.rs", "use crate::b as other; pub fn a() { other::b() }"),
        ("b.rs", "use super::*; pub fn b() { a::a() }"),
    ];
    assert_eq!(cycles(&files), [PAIR]);
}

#[test]
fn a_cycle_through_a_name_that_a_glob_brings() {
    let files = [
        ("lib.rs", "mod a; mod b;"),
        ("a.rs", "use crate::b::*; pub fn a() { b() }"),
        ("b.rs", "pub fn b() { crate::a::a() }"),
    ];
    assert_eq!(cycles(&files), [PAIR]);
}

#[test]
fn a_cycle_through_the_tokens_of_a_macro() {
    let files = [
        ("lib.rs", "mod a; mod b;"),
        ("a.rs", "macro_rules! m { () => { $crate::b::b() } } pub fn a() { m!() }"),
        ("b.rs", "pub fn b() -> u8 { assert!(1 > 0, \"{}\", 1); vec![0; crate::a::a()].len() }"),
    ];
    assert_eq!(cycles(&files), [PAIR]);
}

#[test]
fn a_cycle_through_a_module_in_braces() {
    let files = [
        ("lib.rs", "mod a; mod b;"),
        ("a.rs", "mod inner { use super::super::b::B; pub struct I(B); } pub struct A;"),
        ("b.rs", "pub struct B; impl From<super::a::A> for B {}"),
    ];
    assert_eq!(cycles(&files), [PAIR]);
}

#[test]
fn a_parent_and_its_children_may_use_each_other() {
    let files = [
        ("lib.rs", "mod a;"),
        ("a.rs", "mod x; mod y; pub enum Error {} pub use x::X; pub fn f() { y::y() }"),
        ("a/x.rs", "use super::Error; pub struct X(Error);"),
        ("a/y.rs", "use super::{Error, X}; pub fn y() { let _: Option<(X, Error)> = None; }"),
    ];
    assert_eq!(cycles(&files), Vec::<Vec<String>>::new());
    assert_eq!(
        edges(&files),
        ["a.rs > a/x.rs", "a.rs > a/y.rs", "a/x.rs > a.rs", "a/y.rs > a.rs", "a/y.rs > a/x.rs"]
    );
}

#[test]
fn children_of_one_parent_may_not_use_each_other_in_a_circle() {
    let files = [
        ("lib.rs", "mod p;"),
        ("p.rs", "mod x; mod y; pub use x::X; pub use y::Y;"),
        ("p/x.rs", "use super::Y; pub struct X(Y);"),
        ("p/y.rs", "use super::X; pub struct Y(Box<X>);"),
    ];
    assert_eq!(cycles(&files), [["p/x.rs", "p/y.rs"]]);
}

#[test]
fn tests_attributes_visibilities_and_other_crates_make_no_edges() {
    let a = "
        pub(in crate::b) struct A;
        #[doc = crate::b::TEXT] use other::b::B;
        pub use glam::*;
        fn f(b: B) -> DVec3 { b.b(::b::c()) }
        #[cfg(test)] mod tests { use crate::b::B; }
        #[cfg(all(test, unix))] fn t() { crate::b::b() }";
    assert_eq!(edges(&[("lib.rs", "mod a; mod b;"), ("a.rs", a), ("b.rs", "pub fn b() {}")]), [""; 0]);
}

#[test]
fn code_that_only_excludes_tests_counts() {
    let a = "#[cfg(not(test))] fn f() { crate::b::b() }";
    let files = [("lib.rs", "mod a; mod b;"), ("a.rs", a), ("b.rs", "pub fn b() {}")];
    assert_eq!(edges(&files), ["a.rs > b.rs"]);
}

#[test]
fn a_reexport_alone_is_no_target() {
    let files = [
        ("lib.rs", "mod a; mod door; mod b;"),
        ("a.rs", "use crate::door::{B, b as other}; fn f(_: B) { other() }"),
        ("door.rs", "pub use crate::b::{B, b};"),
        ("b.rs", "pub struct B; pub fn b() {}"),
    ];
    assert_eq!(edges(&files), ["a.rs > b.rs", "door.rs > b.rs"]);
}

#[test]
fn the_cheapest_edge_is_the_one_to_cut() {
    let files = [
        ("lib.rs", "mod a; mod b;"),
        ("a.rs", "use crate::b::{B, C, D}; pub struct A(B, C, D);"),
        ("b.rs", "pub struct B; pub struct C; pub struct D; fn f(_: crate::a::A) {}"),
    ];
    let report = cycles_of_crates(&crate_of(&files))[0].to_string();
    let cut: Vec<&str> = report.lines().filter(|line| line.ends_with("to cut")).collect();
    assert_eq!(cut, ["  crates/small/src/b.rs -> crates/small/src/a.rs  <- to cut"], "{report}");
    assert!(report.contains("crates/small/src/b.rs:1: crate::a::A"), "{report}");
}
