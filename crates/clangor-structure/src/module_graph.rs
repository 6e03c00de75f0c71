//! Builds the graph "file A uses an item that file B defines" of a crate and finds its cycles.
//!
//! An import of a module makes no edge by itself: what is used through it does. A re-export counts as a use
//! of the file that defines the item. Edges between a module and its direct children are allowed in both
//! directions, so a cycle counts only if it remains without them.

use std::collections::{BTreeMap, BTreeSet};

use crate::dependency_cycle::{Cycle, CycleEdge, Uses};
use crate::module_tree::{FileId, ModuleId, ModuleTree};
use crate::name_resolution::{Target, resolve};
use crate::path_scan::paths_of;
use crate::source_files::SourceTree;

/// The graph of the files of a crate.
#[derive(Clone, Debug, Default)]
pub struct ModuleGraph {
    /// Paths of the files.
    pub files: Vec<String>,
    /// The file that declares each file's module.
    pub parents: Vec<Option<FileId>>,
    /// Edges from the file that uses to the file that defines.
    pub edges: BTreeMap<(FileId, FileId), Uses>,
}

impl ModuleGraph {
    /// Builds the graph of a crate.
    pub fn of(tree: &ModuleTree) -> Self {
        let mut graph = Self {
            files: tree.files.iter().map(|file| file.path.clone()).collect(),
            parents: tree.files.iter().map(|file| file.parent).collect(),
            edges: BTreeMap::new(),
        };
        for (id, module) in tree.modules.iter().enumerate() {
            for import in &module.imports {
                let is_glob_reexport = import.name.is_none() && import.is_reexport;
                graph.add_use(tree, id, &import.path, import.line, is_glob_reexport);
            }
        }
        for file in 0..tree.files.len() {
            for found in paths_of(tree, file) {
                let has_glob = tree.modules[found.module].imports.iter().any(|import| import.name.is_none());
                // A single name was imported, and counted with its import, unless a glob brought it.
                if found.path.len() > 1 || has_glob {
                    graph.add_use(tree, found.module, &found.path, found.line, false);
                }
            }
        }
        graph
    }

    fn add_use(&mut self, tree: &ModuleTree, module: ModuleId, path: &[String], line: usize, whole: bool) {
        let from = tree.modules[module].file;
        let mut resolved = resolve(tree, module, path);
        if whole && let [Target::Module(id)] = resolved.as_slice() {
            resolved = vec![Target::Item(tree.modules[*id].file)];
        }
        for target in resolved {
            if let Target::Item(to) = target
                && to != from
            {
                let first = self.edges.entry((from, to)).or_default().entry(path.join("::")).or_insert(line);
                *first = line.min(*first);
            }
        }
    }

    fn is_family(&self, a: FileId, b: FileId) -> bool {
        self.parents[a] == Some(b) || self.parents[b] == Some(a)
    }

    /// Finds the cycles that remain without the edges between parents and their direct children.
    pub fn cycles(&self) -> Vec<Cycle> {
        self.cycles_along(|a, b| !self.is_family(a, b))
    }

    /// Finds the cycles by all edges, also those between parents and children, for information.
    pub fn cycles_through_parents(&self) -> Vec<Cycle> {
        self.cycles_along(|_, _| true)
    }

    fn cycles_along(&self, counts: impl Fn(FileId, FileId) -> bool) -> Vec<Cycle> {
        let edges: BTreeSet<_> = self.edges.keys().copied().filter(|&(a, b)| counts(a, b)).collect();
        components(self.files.len(), &edges)
            .iter()
            .map(|component| {
                let place = |file: FileId| component.iter().position(|member| *member == file);
                let inside = edges.iter().filter_map(|edge| {
                    let (from, to) = (place(edge.0)?, place(edge.1)?);
                    Some(CycleEdge { from, to, uses: self.edges[edge].clone() })
                });
                let files = component.iter().map(|file| self.files[*file].clone()).collect();
                Cycle { files, edges: inside.collect() }
            })
            .collect()
    }
}

/// Returns the strongly connected components of more than one node, by mutual reachability.
fn components(count: usize, edges: &BTreeSet<(FileId, FileId)>) -> Vec<Vec<FileId>> {
    let reached: Vec<BTreeSet<FileId>> = (0..count)
        .map(|start| {
            let (mut seen, mut next) = (BTreeSet::new(), vec![start]);
            while let Some(at) = next.pop() {
                let ahead = edges.range((at, 0)..=(at, FileId::MAX)).map(|edge| edge.1);
                next.extend(ahead.filter(|to| seen.insert(*to)));
            }
            seen
        })
        .collect();
    let mut left: BTreeSet<FileId> = (0..count).collect();
    let mut found = Vec::new();
    while let Some(first) = left.pop_first() {
        let mutual = |node: &FileId| reached[first].contains(node) && reached[*node].contains(&first);
        let mut component = vec![first];
        component.extend(left.iter().copied().filter(mutual));
        left.retain(|node| !component.contains(node));
        if component.len() > 1 {
            found.push(component);
        }
    }
    found
}

/// Builds the graph of every crate below `crates` and `integrations`.
pub fn graphs_of_crates(tree: &SourceTree) -> Vec<ModuleGraph> {
    let roots = tree.rust_files().filter(|file| {
        let inside = file.crate_folder().and_then(|folder| file.path[folder.len()..].strip_prefix("/src/"));
        inside.is_some_and(|path| match path.strip_prefix("bin/") {
            Some(program) => !program.contains('/'),
            None => matches!(path, "lib.rs" | "main.rs"),
        })
    });
    roots.filter_map(|root| ModuleTree::read(tree, &root.path)).map(|tree| ModuleGraph::of(&tree)).collect()
}

/// Finds the cycles of every crate, the largest first.
pub fn cycles_of_crates(tree: &SourceTree) -> Vec<Cycle> {
    let mut cycles: Vec<Cycle> = graphs_of_crates(tree).iter().flat_map(ModuleGraph::cycles).collect();
    cycles.sort_by_key(|cycle| std::cmp::Reverse(cycle.files.len()));
    cycles
}
