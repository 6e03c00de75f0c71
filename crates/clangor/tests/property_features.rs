//! What a user compiles with each set of features.

use std::process::Command;

/// Names of the crates that `cargo tree` lists for the face crate with these features.
fn dependencies(features: &[&str]) -> Vec<String> {
    let output = Command::new(env!("CARGO"))
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .args(["tree", "--offline", "--locked", "-p", "clangor", "-e", "normal", "--prefix", "none"])
        .args(features)
        .output()
        .expect("cargo runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).expect("names in UTF-8");
    text.lines().filter_map(|line| line.split(' ').next()).map(str::to_owned).collect()
}

fn has(names: &[String], name: &str) -> bool {
    names.iter().any(|own| own == name)
}

#[test]
fn the_real_time_engine_brings_no_offline_dependencies() {
    let names = dependencies(&["--no-default-features", "--features", "realtime"]);
    for heavy in [
        "parquet",
        "faer",
        "rayon",
        "parry3d-f64",
        "clangor-bake",
        "clangor-pipeline",
        "wgpu",
        "cpal",
        "tokio",
    ] {
        assert!(!has(&names, heavy), "{heavy} comes in with the feature realtime alone");
    }
    assert!(has(&names, "clangor-core") && has(&names, "clangor-sim"));
    // With the default features they do come in: the list is not empty by mistake.
    let offline = dependencies(&[]);
    assert!(["parquet", "faer", "rayon"].iter().all(|name| has(&offline, name)));
    assert!(!has(&offline, "wgpu") && !has(&offline, "cpal"));
}
