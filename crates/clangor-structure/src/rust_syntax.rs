//! Parses Rust files and recognises what is compiled for tests only.

use std::collections::BTreeSet;
use std::ops::RangeInclusive;

use proc_macro2::{TokenStream, TokenTree};
use syn::spanned::Spanned;
use syn::visit::{self, Visit};
use syn::{Attribute, Item, Meta};

use crate::source_files::{SourceFile, SourceTree};

/// Parses a file.
///
/// # Panics
/// Panics with the place if the file is no valid Rust, because every measure would be wrong then.
pub fn parse(file: &SourceFile) -> syn::File {
    syn::parse_file(&file.text)
        .unwrap_or_else(|error| panic!("{}:{}: {error}", file.path, error.span().start().line))
}

/// Returns true if the attributes restrict an item to tests: `#[test]` or a `#[cfg]` that asks for `test`.
pub fn is_test_only(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| match &attribute.meta {
        Meta::Path(path) => path.is_ident("test"),
        Meta::List(list) => list.path.is_ident("cfg") && asks_for_test(list.tokens.clone()),
        Meta::NameValue(_) => false,
    })
}

/// Looks for `test` outside of `not(…)` in a configuration predicate; `any(…)` does not restrict to tests.
fn asks_for_test(predicate: TokenStream) -> bool {
    let mut group_is_conjunction = true;
    for token in predicate {
        match token {
            TokenTree::Ident(ident) if ident == "test" => return true,
            TokenTree::Ident(ident) => group_is_conjunction = ident == "all",
            TokenTree::Group(group) if group_is_conjunction && asks_for_test(group.stream()) => return true,
            _ => {}
        }
    }
    false
}

/// Returns the attributes of an item.
pub fn attributes(item: &Item) -> &[Attribute] {
    match item {
        Item::Const(i) => &i.attrs,
        Item::Enum(i) => &i.attrs,
        Item::ExternCrate(i) => &i.attrs,
        Item::Fn(i) => &i.attrs,
        Item::ForeignMod(i) => &i.attrs,
        Item::Impl(i) => &i.attrs,
        Item::Macro(i) => &i.attrs,
        Item::Mod(i) => &i.attrs,
        Item::Static(i) => &i.attrs,
        Item::Struct(i) => &i.attrs,
        Item::Trait(i) => &i.attrs,
        Item::TraitAlias(i) => &i.attrs,
        Item::Type(i) => &i.attrs,
        Item::Union(i) => &i.attrs,
        Item::Use(i) => &i.attrs,
        _ => &[],
    }
}

/// Returns the ranges of lines, counted from 1, that the test-only items of a file fill.
pub fn test_line_ranges(syntax: &syn::File) -> Vec<RangeInclusive<usize>> {
    struct TestItems(Vec<RangeInclusive<usize>>);
    impl<'ast> Visit<'ast> for TestItems {
        fn visit_item(&mut self, item: &'ast Item) {
            if is_test_only(attributes(item)) {
                let span = item.span();
                self.0.push(span.start().line..=span.end().line);
            } else {
                visit::visit_item(self, item);
            }
        }
    }
    let mut found = TestItems(Vec::new());
    found.visit_file(syntax);
    found.0
}

/// Returns the paths of files that `#[cfg(test)] mod name;` declares, which are tests as a whole.
pub fn test_only_files(tree: &SourceTree) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for file in tree.rust_files().filter(|file| file.text.contains("cfg(")) {
        for item in parse(file).items {
            if let Item::Mod(module) = item
                && module.content.is_none()
                && is_test_only(&module.attrs)
            {
                let folder = child_folder(&file.path);
                found.insert(format!("{folder}/{}.rs", module.ident));
                found.insert(format!("{folder}/{}/mod.rs", module.ident));
            }
        }
    }
    found
}

/// Returns the folder that holds the child modules of a file.
pub fn child_folder(path: &str) -> String {
    let (folder, name) = path.rsplit_once('/').unwrap_or(("", path));
    match name {
        "lib.rs" | "main.rs" | "mod.rs" => folder.to_string(),
        _ => path.trim_end_matches(".rs").to_string(),
    }
}
