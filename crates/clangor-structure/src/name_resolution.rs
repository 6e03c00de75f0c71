//! Resolves a path of the code to the file that defines the item, through imports, re-exports and globs.
//!
//! Privacy is ignored: code that compiles cannot name what it does not see. Paths into other crates resolve
//! to nothing.

use std::collections::BTreeSet;

use crate::module_tree::{FileId, ModuleId, ModuleTree};

/// What a name stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Target {
    /// A module.
    Module(ModuleId),
    /// An item that this file defines.
    Item(FileId),
}

/// Imports that are being resolved, so that import circles end: module, index of the import, looked-up name.
type Open = BTreeSet<(ModuleId, usize, String)>;

/// Returns what a path stands for, seen from a module. One name can stand for a module and an item at once.
/// The result is empty for paths into other crates and for local variables.
pub fn resolve(tree: &ModuleTree, module: ModuleId, path: &[String]) -> Vec<Target> {
    follow(tree, module, path, &mut Open::new()).unwrap_or_default()
}

/// `None` means that the path begins with an unknown name; `Some(empty)` that it leads into another crate.
fn follow(tree: &ModuleTree, module: ModuleId, path: &[String], open: &mut Open) -> Option<Vec<Target>> {
    let mut at = module;
    let mut segments = path.iter().enumerate().peekable();
    let mut anchored = false;
    while let Some((_, word)) = segments.next_if(|(_, word)| is_anchor(word)) {
        at = match word.as_str() {
            "crate" => 0,
            "super" => tree.modules[at].parent?,
            _ => at,
        };
        anchored = true;
    }
    let mut targets = vec![Target::Module(at)];
    for (index, name) in segments {
        // Modules and types share a namespace: a module, if there is one, is what the path goes through.
        let Some(inside) = targets.iter().find_map(|target| match target {
            Target::Module(id) => Some(*id),
            Target::Item(_) => None,
        }) else {
            return Some(targets);
        };
        targets = match member(tree, inside, name, open) {
            Some(found) => found,
            None if index == 0 && !anchored => return None,
            // A macro must have made the item, so the module's file defines it.
            None => return Some(vec![Target::Item(tree.modules[inside].file)]),
        };
    }
    Some(targets)
}

fn is_anchor(word: &str) -> bool {
    matches!(word, "crate" | "super" | "self")
}

/// Looks a name up in one module. `None` if the module does not know it; empty if it comes from another
/// crate.
fn member(tree: &ModuleTree, module: ModuleId, name: &str, open: &mut Open) -> Option<Vec<Target>> {
    let here = &tree.modules[module];
    let mut found = BTreeSet::new();
    let mut known = false;
    found.extend(here.children.get(name).map(|id| Target::Module(*id)));
    if here.items.contains(name) {
        found.insert(Target::Item(here.file));
    }
    for (index, import) in here.imports.iter().enumerate() {
        if import.name.as_deref().is_some_and(|imported| imported == name) {
            let key = (module, index, name.to_string());
            if open.insert(key.clone()) {
                known = true;
                found.extend(follow(tree, module, &import.path, open).unwrap_or_default());
                open.remove(&key);
            }
        }
    }
    if found.is_empty() && !known {
        known = through_globs(tree, module, name, open, &mut found);
    }
    (known || !found.is_empty()).then(|| found.into_iter().collect())
}

/// Looks a name up behind the globs of a module. Returns true if a glob of another crate could hold it.
fn through_globs(
    tree: &ModuleTree,
    module: ModuleId,
    name: &str,
    open: &mut Open,
    found: &mut BTreeSet<Target>,
) -> bool {
    let mut foreign = false;
    for (index, import) in tree.modules[module].imports.iter().enumerate() {
        let key = (module, index, name.to_string());
        if import.name.is_some() || !open.insert(key.clone()) {
            continue;
        }
        match follow(tree, module, &import.path, open).as_deref() {
            None | Some([]) => foreign = true,
            Some(targets) => {
                for target in targets {
                    if let Target::Module(inside) = target {
                        found.extend(member(tree, *inside, name, open).unwrap_or_default());
                    }
                }
            }
        }
        open.remove(&key);
    }
    foreign && found.is_empty()
}
