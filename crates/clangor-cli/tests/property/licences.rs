//! Every dependency is under a licence that lets anyone use Clangor for anything, and comes once, but for
//! those that are known to come more often.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;

/// Licences that ask for no more than a notice.
const ALLOWED: &[&str] = &[
    "MIT",
    "MIT-0",
    "Apache-2.0",
    "Apache-2.0 WITH LLVM-exception",
    "BSD-1-Clause",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "Zlib",
    "ISC",
    "Unicode-3.0",
    "Unicode-DFS-2016",
    "CC0-1.0",
    "0BSD",
];

/// Packages of several versions, and how many: their users have not agreed yet. A version more is a build
/// and a binary that is larger; look first whether an update of its user removes it.
const REPEATED: &[(&str, usize)] = &[
    ("bitflags", 2),
    ("equator", 2),
    ("equator-macro", 2),
    ("getrandom", 3),
    ("hashbrown", 2),
    ("jni-sys", 2),
    ("miniz_oxide", 2),
    ("num-derive", 2),
    ("r-efi", 2),
    ("syn", 3),
    ("thiserror", 2),
    ("thiserror-impl", 2),
];

/// Whether an SPDX expression can be satisfied by allowed licences alone.
fn allowed(expression: &str) -> bool {
    let expression = expression.replace(['(', ')'], " ").replace('/', " OR ");
    // AND binds tighter than OR. Parentheses are dropped, which reads `(A OR B) AND C` as `A OR (B AND C)`:
    // every part of such an expression must then be allowed.
    let grouped = expression.contains(" AND ") && expression.contains(" OR ");
    let any = |mut parts: Box<dyn Iterator<Item = &str> + '_>| parts.any(|p| ALLOWED.contains(&p.trim()));
    if grouped {
        expression.split(" OR ").flat_map(|p| p.split(" AND ")).all(|p| ALLOWED.contains(&p.trim()))
    } else if expression.contains(" AND ") {
        expression.split(" AND ").all(|p| ALLOWED.contains(&p.trim()))
    } else {
        any(Box::new(expression.split(" OR ")))
    }
}

#[test]
fn every_dependency_is_permissively_licensed() {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--format-version", "1", "--locked", "--all-features"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("cargo runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let metadata: serde_json::Value = serde_json::from_slice(&output.stdout).expect("cargo metadata is JSON");
    let packages = metadata["packages"].as_array().expect("packages");
    assert!(packages.len() > 50, "only {} packages", packages.len());
    let refused: Vec<String> = packages
        .iter()
        .filter(|p| !allowed(p["license"].as_str().unwrap_or("none")))
        .map(|p| format!("{} {}: {}", p["name"], p["version"], p["license"]))
        .collect();
    assert!(refused.is_empty(), "{refused:#?}");
}

#[test]
fn the_rule_can_refuse() {
    for bad in ["GPL-3.0", "MPL-2.0", "MIT AND GPL-2.0", "(MIT OR Apache-2.0) AND LGPL-3.0", "none"] {
        assert!(!allowed(bad), "{bad}");
    }
    for good in
        ["MIT", "MIT/Apache-2.0", "GPL-3.0 OR MIT", "MIT AND Zlib", "(MIT OR Apache-2.0) AND Unicode-3.0"]
    {
        assert!(allowed(good), "{good}");
    }
}

#[test]
fn no_more_versions_of_a_dependency_than_are_known() {
    let lock = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../Cargo.lock");
    let lock = fs::read_to_string(lock).unwrap();
    let mut versions = BTreeMap::new();
    for name in lock.lines().filter_map(|line| line.strip_prefix("name = ")) {
        *versions.entry(name.trim_matches('"')).or_insert(0) += 1;
    }
    let repeated: Vec<(&str, usize)> = versions.into_iter().filter(|(_, count)| *count > 1).collect();
    assert_eq!(
        repeated, REPEATED,
        "Cargo.lock has other versions than are known; `cargo tree -d` shows their users"
    );
}
