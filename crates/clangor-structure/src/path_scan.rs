//! Collects every path that a file writes in expressions, types and patterns, also inside macro invocations.
//!
//! Attributes, visibilities and `use` declarations are left out, and so is what is compiled for tests only.

use proc_macro2::{Delimiter, Spacing, TokenStream, TokenTree};
use syn::visit::{self, Visit};
use syn::{Attribute, ImplItemFn, Item, ItemMod, ItemUse, Macro, Path, VisRestricted};

use crate::module_tree::{FileId, ModuleId, ModuleTree};
use crate::rust_syntax::{attributes, is_test_only};

/// A path in the code.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PathUse {
    /// The module that writes it.
    pub module: ModuleId,
    /// Its segments, without generic arguments.
    pub path: Vec<String>,
    /// Its line.
    pub line: usize,
}

/// Returns the paths of a file.
pub fn paths_of(tree: &ModuleTree, file: FileId) -> Vec<PathUse> {
    let mut scan = Scan { tree, module: tree.files[file].module, found: Vec::new() };
    scan.visit_file(&tree.files[file].syntax);
    scan.found
}

struct Scan<'a> {
    tree: &'a ModuleTree,
    module: ModuleId,
    found: Vec<PathUse>,
}

impl<'ast> Visit<'ast> for Scan<'_> {
    fn visit_attribute(&mut self, _: &'ast Attribute) {}

    fn visit_vis_restricted(&mut self, _: &'ast VisRestricted) {}

    fn visit_item_use(&mut self, _: &'ast ItemUse) {}

    fn visit_item(&mut self, item: &'ast Item) {
        if !is_test_only(attributes(item)) {
            visit::visit_item(self, item);
        }
    }

    fn visit_impl_item_fn(&mut self, function: &'ast ImplItemFn) {
        if !is_test_only(&function.attrs) {
            visit::visit_impl_item_fn(self, function);
        }
    }

    fn visit_item_mod(&mut self, item: &'ast ItemMod) {
        let outer = self.module;
        if let Some(inner) = self.tree.modules[outer].children.get(&item.ident.to_string())
            && item.content.is_some()
        {
            self.module = *inner;
            visit::visit_item_mod(self, item);
            self.module = outer;
        }
    }

    fn visit_path(&mut self, path: &'ast Path) {
        if path.leading_colon.is_none()
            && let Some(first) = path.segments.first()
        {
            let line = first.ident.span().start().line;
            let path = path.segments.iter().map(|segment| segment.ident.to_string()).collect();
            self.found.push(PathUse { module: self.module, path, line });
        }
        visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, invocation: &'ast Macro) {
        // A single name is a macro's, not an item's.
        if invocation.path.segments.len() > 1 {
            self.visit_path(&invocation.path);
        }
        self.scan_tokens(invocation.tokens.clone());
    }
}

impl Scan<'_> {
    /// Collects the paths of a token stream: names joined by `::` that do not follow a dot.
    fn scan_tokens(&mut self, stream: TokenStream) {
        let tokens: Vec<TokenTree> = stream.into_iter().collect();
        let mut index = 0;
        while index < tokens.len() {
            match &tokens[index] {
                TokenTree::Group(group) => {
                    if !is_attribute(&tokens, index) {
                        self.scan_tokens(group.stream());
                    }
                    index += 1;
                }
                TokenTree::Ident(ident) if starts_path(&tokens, index) => {
                    let line = ident.span().start().line;
                    let mut path = vec![ident.to_string()];
                    index += 1;
                    while let Some(TokenTree::Ident(next)) = tokens.get(index + 2)
                        && is_double_colon(&tokens, index)
                    {
                        path.push(next.to_string());
                        index += 3;
                    }
                    self.found.push(PathUse { module: self.module, path, line });
                }
                _ => index += 1,
            }
        }
    }
}

fn punct(tokens: &[TokenTree], index: usize) -> Option<char> {
    match tokens.get(index) {
        Some(TokenTree::Punct(punct)) => Some(punct.as_char()),
        _ => None,
    }
}

fn is_double_colon(tokens: &[TokenTree], index: usize) -> bool {
    let joint =
        matches!(tokens.get(index), Some(TokenTree::Punct(first)) if first.spacing() == Spacing::Joint);
    joint && punct(tokens, index) == Some(':') && punct(tokens, index + 1) == Some(':')
}

/// Returns true unless the name at `index` is a field, a method, a macro variable or the rest of a longer
/// path.
fn starts_path(tokens: &[TokenTree], index: usize) -> bool {
    let before = |back: usize| index.checked_sub(back).and_then(|at| punct(tokens, at));
    match before(1) {
        // `0..n` begins a path, `a.n` does not.
        Some('.') => before(2) == Some('.'),
        Some(':') => before(2) != Some(':'),
        Some('$') => matches!(&tokens[index], TokenTree::Ident(ident) if ident == "crate"),
        // A lifetime.
        Some('\'') => false,
        _ => true,
    }
}

fn is_attribute(tokens: &[TokenTree], index: usize) -> bool {
    let bracketed =
        matches!(&tokens[index], TokenTree::Group(group) if group.delimiter() == Delimiter::Bracket);
    bracketed && index > 0 && punct(tokens, index - 1) == Some('#')
}
