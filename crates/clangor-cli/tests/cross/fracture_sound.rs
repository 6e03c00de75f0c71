//! What a person does with a scene that breaks: simulate, inspect, render, render the timeline again, look at
//! what broke and how that sounds.

use std::fs;
use std::path::Path;

use crate::program::clangor;
use crate::sound_file::samples;

/// A tile just above the floor; `released` says whether its cracks drive the pieces apart.
fn scene(folder: &Path, name: &str, released: bool) {
    let text = format!(
        "version = 1\n[simulation]\nduration = 0.05\ntime_step = 0.0001\n[material.tough]\n\
         base = \"ceramic\"\n\
         fracture_energy = 150\n[[body]]\nname = \"tile\"\nshape = \"box:0.12x0.006x0.12\"\n\
         material = \"tough\"\n\
         position = [0, 0.03, 0]\norientation = {{ axis = [0.3, 0, 1], degrees = 12 }}\n\
         velocity = [0, -4, 0]\n\
         fracture = {{ edge = 0.01, crack_impulses = {released} }}\n[[plane]]\nmaterial = \"granite\"\n\
         [[listener]]\nposition = [0, 0.4, 1]\n"
    );
    fs::write(folder.join(name), text).unwrap();
}

/// ∫ p² dt \[Pa² s\] over the first milliseconds from the first sound on.
fn onset(path: &Path, milliseconds: f64) -> f64 {
    let (samples, rate) = samples(path);
    let samples: Vec<f64> = samples.into_iter().map(f64::from).collect();
    let peak = samples.iter().map(|p| p.abs()).fold(0.0, f64::max);
    let first = samples.iter().position(|p| p.abs() > 1e-3 * peak).unwrap();
    let length = (1e-3 * milliseconds * rate) as usize;
    samples[first..].iter().take(length).map(|p| p * p).sum::<f64>() / rate
}

#[test]
fn a_breaking_scene_is_kept_and_rendered_again() {
    let folder = tempfile::tempdir().unwrap();
    scene(folder.path(), "tile.toml", true);
    let report: serde_json::Value = serde_json::from_str(&clangor(
        folder.path(),
        &["--json", "simulate", "tile.toml", "-o", "tile.timeline"],
    ))
    .unwrap();
    let births = report["births"].as_u64().unwrap();
    println!("{} fractures, {births} births", report["fractures"]);
    assert!(births >= 2 && report["breaking"]["solved"].as_u64().unwrap() > 0, "{report}");
    let inspected: serde_json::Value =
        serde_json::from_str(&clangor(folder.path(), &["--json", "inspect", "tile.timeline"])).unwrap();
    assert_eq!(inspected["births"].as_u64().unwrap(), births);
    let parts = ["--parts", "acceleration", "--quality", "draft"];
    clangor(folder.path(), &[&["render", "tile.toml", "-o", "direct.wav"][..], &parts].concat());
    clangor(folder.path(), &[&["render", "tile.timeline", "-o", "again.wav"][..], &parts].concat());
    let [direct, again] = ["direct.wav", "again.wav"].map(|name| onset(&folder.path().join(name), 50.0));
    // The file keeps points and impulses in single precision; 1e-6 seen.
    assert!(direct > 0.0 && (again / direct - 1.0).abs() < 1e-4, "{direct} {again}");
}

/// A JSON file.
fn json(path: &Path) -> serde_json::Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

#[test]
fn reports_and_pictures_tell_what_broke() {
    let folder = tempfile::tempdir().unwrap();
    scene(folder.path(), "tile.toml", true);
    let report = clangor(
        folder.path(),
        &["simulate", "tile.toml", "-o", "tile.timeline", "--report", "energies.json"],
    );
    assert!(report.contains("J into the motion of pieces"), "{report}");
    let report = json(&folder.path().join("energies.json"));
    let rows = report["fractures"].as_array().unwrap();
    let number = |row: &serde_json::Value, key: &str| row[key].as_f64().unwrap();
    assert!(!rows.is_empty());
    for row in rows {
        let [impact, strain, cracks, motion] =
            ["impact_energy_j", "strain_energy_j", "fracture_energy_j", "crack_impulse_energy_j"]
                .map(|key| number(row, key));
        // What the cracks do not take moves the pieces; η = 0.8 of the rest at most is theirs. Residual seen:
        // 2e-16.
        assert!((strain / (cracks + motion) - 1.0).abs() < 1e-9, "{row}");
        assert!(
            cracks <= 0.8 * strain * (1.0 + 1e-9) && strain <= impact * (1.0 + 1e-9) && motion > 0.0,
            "{row}"
        );
        // G_c = 150 J/m².
        assert!((cracks / (150.0 * number(row, "crack_area_m2")) - 1.0).abs() < 1e-9, "{row}");
    }
    let births: u64 = rows.iter().map(|row| row["pieces"].as_u64().unwrap()).sum();
    let totals = &report["totals"];
    // Every body that broke but the tile was a piece.
    assert_eq!(totals["pieces"].as_u64().unwrap(), births + 1 - rows.len() as u64);
    assert!(report["impacts"]["solved"].as_u64().unwrap() >= rows.len() as u64 && report["modal"].is_null());

    let parts = ["--parts", "acceleration,modal", "--quality", "draft", "--max-frequency", "6000"];
    let render = ["render", "tile.timeline", "-o", "tile.wav", "--report", "ringing.json"];
    clangor(folder.path(), &[&render[..], &parts].concat());
    let report = json(&folder.path().join("ringing.json"));
    assert_eq!(report["fractures"].as_array().unwrap().len(), rows.len());
    let ringing = &report["modal"];
    let ellipsoids = ringing["ellipsoids"].as_array().unwrap();
    let used: usize = ellipsoids.iter().map(|e| e["masses_kg"].as_array().unwrap().len()).sum();
    assert!(used > 0 && used as u64 == ringing["proxy_pieces"].as_u64().unwrap(), "{ringing}");

    let picture = ["plot", "bank-use", "ringing.json", "-o", "use.svg"];
    assert!(
        clangor(folder.path(), &picture)
            .contains(&format!("{used} pieces as {} ellipsoids", ellipsoids.len()))
    );
    let draw = ["plot", "spectrogram", "tile.wav", "--timeline", "tile.timeline", "-o", "tile.png"];
    let drawn: serde_json::Value =
        serde_json::from_str(&clangor(folder.path(), &[&["--json"][..], &draw].concat())).unwrap();
    assert_eq!((drawn["deaths"].as_u64(), drawn["births"].as_u64()), (Some(rows.len() as u64), Some(births)));
    assert!(fs::read(folder.path().join("tile.png")).unwrap().starts_with(b"\x89PNG"));
    // After all has broken.
    let last = rows.iter().map(|row| number(row, "time_s")).fold(0.0, f64::max);
    let from = (last + 1e-3).to_string();
    let quiet = [&["--json"][..], &draw, &["--from", &from]].concat();
    let drawn: serde_json::Value = serde_json::from_str(&clangor(folder.path(), &quiet)).unwrap();
    assert_eq!(drawn["births"].as_u64(), Some(0));
}
