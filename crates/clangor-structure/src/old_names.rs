//! Finds declarations whose names have been replaced: modules, types, functions, constants, and identifiers
//! in the code.

use std::collections::BTreeSet;
use std::fmt;

use proc_macro2::{TokenStream, TokenTree};
use syn::visit::{self, Visit};
use syn::{Ident, ImplItemFn, Item, ItemFn, TraitItemFn};

use crate::rust_syntax::parse;
use crate::source_files::{SourceFile, SourceTree};

/// What kind of declaration an old name belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum NameKind {
    /// A file, a folder, or a `mod` declaration.
    Module,
    /// A struct, enum, union, trait or type alias.
    Type,
    /// A free function or a method.
    Function,
    /// A constant or static.
    Constant,
    /// Any identifier in the code, local variables and fields included.
    Identifier,
}

/// One old name.
#[derive(Clone, Copy, Debug)]
pub struct OldName {
    /// Kind of declaration.
    pub kind: NameKind,
    /// The name, with `*` for any run of characters.
    pub pattern: &'static str,
    /// Text that the path of the file must contain; empty for any file.
    pub within: &'static str,
    /// The name that replaces it.
    pub replacement: &'static str,
}

/// A declaration that still has an old name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OldNameUse {
    /// Path of the file.
    pub path: String,
    /// Line, counted from 1.
    pub line: usize,
    /// Kind of declaration.
    pub kind: NameKind,
    /// The name as it is written.
    pub name: String,
    /// The name that replaces it.
    pub replacement: &'static str,
}

impl fmt::Display for OldNameUse {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { path, line, kind, name, replacement } = self;
        write!(f, "{path}:{line}: {kind:?} {name} is now {replacement}")
    }
}

/// Finds the old names that remain in the Rust files of the tree, except in `exempt` files.
pub fn remaining(tree: &SourceTree, old_names: &[OldName], exempt: &[&str]) -> Vec<OldNameUse> {
    let mut found = Vec::new();
    let mut seen_folders = BTreeSet::new();
    for file in tree.rust_files().filter(|file| !exempt.contains(&file.path.as_str())) {
        let applicable = |name: &&OldName| file.path.contains(name.within);
        let names: Vec<&OldName> = old_names.iter().filter(applicable).collect();
        for declaration in declarations(file, &mut seen_folders) {
            let matching = names
                .iter()
                .find(|old| old.kind == declaration.kind && matches_pattern(&declaration.name, old.pattern));
            found.extend(matching.map(|old| OldNameUse {
                path: file.path.clone(),
                line: declaration.line,
                kind: declaration.kind,
                name: declaration.name.clone(),
                replacement: old.replacement,
            }));
        }
    }
    found
}

/// Returns true if a name matches a pattern in which `*` stands for any run of characters.
pub fn matches_pattern(name: &str, pattern: &str) -> bool {
    match pattern.split_once('*') {
        None => name == pattern,
        Some((head, tail)) => name.strip_prefix(head).is_some_and(|rest| {
            (0..=rest.len()).any(|cut| rest.is_char_boundary(cut) && matches_pattern(&rest[cut..], tail))
        }),
    }
}

struct Declaration {
    kind: NameKind,
    name: String,
    line: usize,
}

/// Lists the declarations of a file: its own name, its folders that were not seen before, its items and
/// identifiers.
fn declarations(file: &SourceFile, seen_folders: &mut BTreeSet<String>) -> Vec<Declaration> {
    let mut found = Declarations(Vec::new());
    let words: Vec<&str> = file.path.split('/').collect();
    for depth in 1..words.len() {
        if seen_folders.insert(words[..depth].join("/")) {
            found.add(NameKind::Module, words[depth - 1], 1);
        }
    }
    found.add(NameKind::Module, words[words.len() - 1].trim_end_matches(".rs"), 1);
    found.visit_file(&parse(file));
    let tokens: TokenStream = file.text.parse().expect("the file was parsed before");
    found.add_identifiers(tokens);
    found.0
}

struct Declarations(Vec<Declaration>);

impl Declarations {
    fn add(&mut self, kind: NameKind, name: &str, line: usize) {
        self.0.push(Declaration { kind, name: name.to_string(), line });
    }

    fn add_ident(&mut self, kind: NameKind, ident: &Ident) {
        self.add(kind, &ident.to_string(), ident.span().start().line);
    }

    fn add_identifiers(&mut self, tokens: TokenStream) {
        for token in tokens {
            match token {
                TokenTree::Ident(ident) => self.add_ident(NameKind::Identifier, &ident),
                TokenTree::Group(group) => self.add_identifiers(group.stream()),
                _ => {}
            }
        }
    }
}

impl<'ast> Visit<'ast> for Declarations {
    fn visit_item(&mut self, item: &'ast Item) {
        match item {
            Item::Mod(i) => self.add_ident(NameKind::Module, &i.ident),
            Item::Enum(i) => self.add_ident(NameKind::Type, &i.ident),
            Item::Struct(i) => self.add_ident(NameKind::Type, &i.ident),
            Item::Trait(i) => self.add_ident(NameKind::Type, &i.ident),
            Item::Type(i) => self.add_ident(NameKind::Type, &i.ident),
            Item::Union(i) => self.add_ident(NameKind::Type, &i.ident),
            Item::Const(i) => self.add_ident(NameKind::Constant, &i.ident),
            Item::Static(i) => self.add_ident(NameKind::Constant, &i.ident),
            _ => {}
        }
        visit::visit_item(self, item);
    }

    fn visit_item_fn(&mut self, function: &'ast ItemFn) {
        self.add_ident(NameKind::Function, &function.sig.ident);
        visit::visit_item_fn(self, function);
    }

    fn visit_impl_item_fn(&mut self, function: &'ast ImplItemFn) {
        self.add_ident(NameKind::Function, &function.sig.ident);
        visit::visit_impl_item_fn(self, function);
    }

    fn visit_impl_item_const(&mut self, constant: &'ast syn::ImplItemConst) {
        self.add_ident(NameKind::Constant, &constant.ident);
        visit::visit_impl_item_const(self, constant);
    }

    fn visit_trait_item_fn(&mut self, function: &'ast TraitItemFn) {
        self.add_ident(NameKind::Function, &function.sig.ident);
        visit::visit_trait_item_fn(self, function);
    }
}
