//! Finds closures that are handed to `pulp::Arch::dispatch`.
//!
//! A closure is called through `FnOnce::call_once`, a function that the compiler makes without the target
//! features of the wide caller. Where it is not inlined, the loops of the closure run with the narrowest
//! vectors, whatever `#[inline(always)]` says. A type with `WithSimd` has no such function in between.

use syn::visit::{self, Visit};
use syn::{Expr, ExprMethodCall};

use crate::measures::Measure;
use crate::rust_syntax::parse;
use crate::source_files::{Language, SourceTree};

/// The closures that are dispatched, tests included.
pub fn dispatched_closures(tree: &SourceTree) -> Vec<Measure> {
    let mut found = Vec::new();
    for file in tree.files.iter().filter(|file| file.language == Language::Rust) {
        let mut scan = DispatchScan { path: &file.path, found: &mut found };
        scan.visit_file(&parse(file));
    }
    found
}

struct DispatchScan<'a> {
    path: &'a str,
    found: &'a mut Vec<Measure>,
}

impl<'ast> Visit<'ast> for DispatchScan<'_> {
    fn visit_expr_method_call(&mut self, call: &'ast ExprMethodCall) {
        let closures = call.args.iter().filter(|argument| matches!(argument, Expr::Closure(_))).count();
        if call.method == "dispatch" && closures > 0 {
            let line = call.method.span().start().line;
            let what = "closure in a dispatch".to_string();
            self.found.push(Measure { path: self.path.to_string(), line, what, number: closures });
        }
        visit::visit_expr_method_call(self, call);
    }
}
