//! Each measure of lengths, names and dispatches finds what breaks it, and only that.

use clangor_structure::measures::{Measure, above, file_lengths, functions, line_lengths};
use clangor_structure::narrow_dispatch::dispatched_closures;
use clangor_structure::old_names::{NameKind, OldName, matches_pattern, remaining};
use clangor_structure::source_files::SourceTree;

const PLACE: &str = "crates/small/src/lib.rs";

fn places(measures: &[Measure]) -> Vec<(&str, usize, usize)> {
    measures.iter().map(|measure| (measure.path.as_str(), measure.line, measure.number)).collect()
}

#[test]
fn a_long_file_is_found_without_its_tests() {
    let body = "// A line.\n".repeat(11);
    let tests = format!("{}#[cfg(test)]\nmod tests {{\n{body}}}\n", "// A line.\n".repeat(5));
    let tree = SourceTree::from_texts(&[
        (PLACE, &body),
        ("crates/small/src/a.rs", &tests),
        ("crates/small/tests/t.rs", &body),
        ("web/src/page.js", &body),
        ("web/tests/page.test.mjs", &body),
    ]);
    assert_eq!(places(&above(10, file_lengths(&tree))), [(PLACE, 1, 11), ("web/src/page.js", 1, 11)]);
    assert_eq!(file_lengths(&tree)[0].number, 5);
}

#[test]
fn a_file_that_is_a_test_module_does_not_count() {
    let body = "// A line.\n".repeat(11);
    let texts = [(PLACE, "#[cfg(test)]\nmod checks;"), ("crates/small/src/checks.rs", &body)];
    assert_eq!(places(&above(10, file_lengths(&SourceTree::from_texts(&texts)))), []);
}

#[test]
fn long_functions_are_found_without_docs_and_tests() {
    let text = "
/// A doc line.
#[inline]
pub fn long(
    a: u8,
) -> u8 {
    a
}

struct S;

impl S {
    fn method(&self) {
        fn inner() {
            drop(1);
        }
    }
}

trait T {
    fn required(&self);
    fn provided() {
        drop(1);
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn t() {
        drop(1);
        drop(2);
    }
}
";
    let tree = SourceTree::from_texts(&[(PLACE, text)]);
    let found = above(2, functions(&tree).lengths);
    assert_eq!(places(&found), [(PLACE, 4, 5), (PLACE, 13, 5), (PLACE, 14, 3), (PLACE, 22, 3)]);
    assert_eq!(found[0].to_string(), "crates/small/src/lib.rs:4: 5 fn long");
}

#[test]
fn long_parameter_lists_are_found_without_the_receiver() {
    let text = "fn three(a: u8, b: u8, c: u8) {}
struct S;
impl S { fn two(&mut self, a: u8, b: u8) {} }
trait T { fn four(&self, a: u8, b: u8, c: u8, d: u8); }
#[test] fn five(a: u8, b: u8, c: u8, d: u8, e: u8) {}";
    let tree = SourceTree::from_texts(&[(PLACE, text)]);
    assert_eq!(places(&above(2, functions(&tree).parameters)), [(PLACE, 4, 4), (PLACE, 1, 3)]);
}

#[test]
fn long_lines_are_found_except_addresses_and_tables() {
    let long = format!("// {}\n", "é".repeat(30));
    let text = format!(
        "{long}// https://example.org/{}\n//! | a | {} |\n    {},\n",
        "x".repeat(40),
        "y".repeat(40),
        "1.5e-3, ".repeat(10)
    );
    let tree = SourceTree::from_texts(&[
        (PLACE, &text),
        ("crates/small/tests/t.rs", &long),
        ("web/src/a.js", &long),
    ]);
    let expected = [(PLACE, 1, 33), ("crates/small/tests/t.rs", 1, 33), ("web/src/a.js", 1, 33)];
    assert_eq!(places(&above(32, line_lengths(&tree))), expected);
    assert_eq!(above(33, line_lengths(&tree)), []);
}

#[test]
fn old_names_are_found_by_kind_place_and_pattern() {
    let old = |kind, pattern, within| OldName { kind, pattern, within, replacement: "new" };
    let names = [
        old(NameKind::Module, "round", ""),
        old(NameKind::Type, "Turned*", ""),
        old(NameKind::Function, "possible", "small"),
        old(NameKind::Constant, "DEGREES", "elsewhere"),
        old(NameKind::Identifier, "told", ""),
    ];
    let text = "
mod round { pub struct TurnedBody; pub enum Body { Turned } }
// told
impl S { pub fn possible(told: u8) { let round = 1.5.round(); } }
const DEGREES: u8 = 6;
fn f() { println!(\"told\", told = 1) }
";
    let tree =
        SourceTree::from_texts(&[(PLACE, text), ("crates/small/src/round/alias.rs", "type TurnedOld = u8;")]);
    let found = |exempt: &[&str]| -> Vec<String> {
        let found = remaining(&tree, &names, exempt);
        found
            .iter()
            .map(|name| format!("{}:{} {}", name.path.replace("crates/small/src/", ""), name.line, name.name))
            .collect()
    };
    let in_lib =
        ["lib.rs:2 round", "lib.rs:2 TurnedBody", "lib.rs:4 possible", "lib.rs:4 told", "lib.rs:6 told"];
    assert_eq!(found(&["crates/small/src/round/alias.rs"]), in_lib);
    assert_eq!(found(&[PLACE]), ["round/alias.rs:1 round", "round/alias.rs:1 TurnedOld"]);
}

#[test]
fn patterns_match_whole_names() {
    for (name, pattern, expected) in [
        ("Blow", "Blow", true),
        ("Blows", "Blow", false),
        ("RoundSolver", "Round*Solver", true),
        ("RoundBodySolver", "Round*Solver", true),
        ("RoundBody", "Round*Solver", false),
        ("take_blows", "*_blows", true),
        ("anything", "*", true),
    ] {
        assert_eq!(matches_pattern(name, pattern), expected, "{name} {pattern}");
    }
}

#[test]
fn a_dispatched_closure_is_found() {
    let text = "
fn f(arch: Arch) {
    arch.dispatch(Type { x: 1 });
    arch.call(|| ());
    arch.dispatch(
        #[inline(always)]
        || ());
}
";
    let tree = SourceTree::from_texts(&[(PLACE, text)]);
    assert_eq!(places(&dispatched_closures(&tree)), [(PLACE, 5, 1)]);
}
