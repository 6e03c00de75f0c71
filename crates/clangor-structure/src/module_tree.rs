//! Reads the modules of one crate: their files, the items each declares, and the names each imports.
//!
//! The tree starts at a crate root (`src/lib.rs`, `src/main.rs`) and follows `mod` declarations. Modules for
//! tests only are left out. A module in braces belongs to the file in which it is written.

use std::collections::{BTreeMap, BTreeSet};

use syn::visit::{self, Visit};
use syn::{Item, ItemMod, ItemUse, UseTree};

use crate::rust_syntax::{attributes, child_folder, is_test_only, parse};
use crate::source_files::SourceTree;

/// Index of a module in [`ModuleTree::modules`].
pub type ModuleId = usize;

/// Index of a file in [`ModuleTree::files`].
pub type FileId = usize;

/// A file of a crate.
pub struct CrateFile {
    /// Path from the root of the repository.
    pub path: String,
    /// Parsed content.
    pub syntax: syn::File,
    /// The module that the file as a whole is.
    pub module: ModuleId,
    /// The file that declares this module; `None` for the crate root.
    pub parent: Option<FileId>,
}

/// One leaf of a `use` declaration.
#[derive(Clone, Debug)]
pub struct Import {
    /// The imported path, relative to the module that imports.
    pub path: Vec<String>,
    /// The name it gets there; `None` for a glob.
    pub name: Option<String>,
    /// Whether other modules see it: any `pub`.
    pub is_reexport: bool,
    /// Line of the leaf.
    pub line: usize,
}

/// A module.
#[derive(Debug, Default)]
pub struct Module {
    /// File in which the module is written.
    pub file: FileId,
    /// The module around it.
    pub parent: Option<ModuleId>,
    /// Child modules by name.
    pub children: BTreeMap<String, ModuleId>,
    /// Names of types, traits, functions, constants and macros that are declared here.
    pub items: BTreeSet<String>,
    /// Imports, also those inside functions.
    pub imports: Vec<Import>,
}

/// The modules of a crate. Index 0 is the crate root in both lists.
pub struct ModuleTree {
    /// Files.
    pub files: Vec<CrateFile>,
    /// Modules.
    pub modules: Vec<Module>,
}

impl ModuleTree {
    /// Reads the modules below a crate root, or returns `None` if there is no such file.
    pub fn read(tree: &SourceTree, crate_root: &str) -> Option<Self> {
        let mut read = Self { files: Vec::new(), modules: Vec::new() };
        read.add_file(tree, crate_root, None, child_folder(crate_root)).then_some(read)
    }

    /// Adds a file and, recursively, what it declares. Returns false if the file does not exist.
    fn add_file(&mut self, tree: &SourceTree, path: &str, around: Option<ModuleId>, folder: String) -> bool {
        let Some(source) = tree.file(path) else { return false };
        let (file, module) = (self.files.len(), self.modules.len());
        let parent = around.map(|id| self.modules[id].file);
        let syntax = parse(source);
        let items = syntax.items.clone();
        self.files.push(CrateFile { path: path.to_string(), syntax, module, parent });
        self.modules.push(Module { file, parent: around, ..Module::default() });
        self.add_items(tree, module, &folder, &items);
        true
    }

    fn add_items(&mut self, tree: &SourceTree, module: ModuleId, folder: &str, items: &[Item]) {
        for item in items.iter().filter(|item| !is_test_only(attributes(item))) {
            match item {
                Item::Mod(child) => self.add_child(tree, module, folder, child),
                Item::Use(_) => {}
                _ => self.modules[module].items.extend(declared_name(item)),
            }
        }
        let mut imports = Imports(Vec::new());
        items.iter().for_each(|item| imports.visit_item(item));
        self.modules[module].imports = imports.0;
    }

    fn add_child(&mut self, tree: &SourceTree, module: ModuleId, folder: &str, child: &ItemMod) {
        let name = child.ident.to_string();
        let id = self.modules.len();
        let inner = format!("{folder}/{name}");
        if let Some((_, items)) = &child.content {
            let file = self.modules[module].file;
            self.modules.push(Module { file, parent: Some(module), ..Module::default() });
            self.add_items(tree, id, &inner, items);
        } else if !self.add_file(tree, &format!("{inner}.rs"), Some(module), inner.clone())
            && !self.add_file(tree, &format!("{inner}/mod.rs"), Some(module), inner)
        {
            return;
        }
        self.modules[module].children.insert(name, id);
    }
}

/// Returns the name that an item gives to its module; imports and modules are not items here.
pub fn declared_name(item: &Item) -> Option<String> {
    let ident = match item {
        Item::Const(i) => &i.ident,
        Item::Enum(i) => &i.ident,
        Item::Fn(i) => &i.sig.ident,
        Item::Macro(i) => i.ident.as_ref()?,
        Item::Static(i) => &i.ident,
        Item::Struct(i) => &i.ident,
        Item::Trait(i) => &i.ident,
        Item::TraitAlias(i) => &i.ident,
        Item::Type(i) => &i.ident,
        Item::Union(i) => &i.ident,
        _ => return None,
    };
    Some(ident.to_string())
}

/// Collects the imports of one module, without those of modules inside.
struct Imports(Vec<Import>);

impl<'ast> Visit<'ast> for Imports {
    fn visit_item(&mut self, item: &'ast Item) {
        if !is_test_only(attributes(item)) {
            visit::visit_item(self, item);
        }
    }

    fn visit_item_mod(&mut self, _: &'ast ItemMod) {}

    fn visit_item_use(&mut self, item: &'ast ItemUse) {
        if item.leading_colon.is_none() {
            let is_reexport = !matches!(item.vis, syn::Visibility::Inherited);
            add_leaves(&item.tree, &mut Vec::new(), is_reexport, &mut self.0);
        }
    }
}

fn add_leaves(tree: &UseTree, path: &mut Vec<String>, is_reexport: bool, imports: &mut Vec<Import>) {
    let mut add = |ident: &syn::Ident, name: Option<&syn::Ident>, glob: bool| {
        let mut path = path.clone();
        if !glob && ident != "self" {
            path.push(ident.to_string());
        }
        let name = if glob { None } else { name.map(ToString::to_string).or_else(|| path.last().cloned()) };
        imports.push(Import { path, name, is_reexport, line: ident.span().start().line });
    };
    match tree {
        UseTree::Path(inner) => {
            path.push(inner.ident.to_string());
            add_leaves(&inner.tree, path, is_reexport, imports);
            path.pop();
        }
        UseTree::Name(leaf) => add(&leaf.ident, None, false),
        UseTree::Rename(leaf) => add(&leaf.ident, Some(&leaf.rename), false),
        UseTree::Glob(glob) => add(&syn::Ident::new("glob", glob.star_token.spans[0]), None, true),
        UseTree::Group(group) => {
            group.items.iter().for_each(|inner| add_leaves(inner, path, is_reexport, imports));
        }
    }
}
