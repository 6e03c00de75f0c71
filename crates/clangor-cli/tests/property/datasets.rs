//! `clangor strike --list` beside `clangor strike` and `clangor modes`: the same samples and the same labels.

use std::fs;

use crate::program::{clangor, run};
use clangor_pipeline::formats::wav::WavReader;
use serde_json::Value;

const RECIPE: &str = "count = 2\nsample_rate = 8000\nseconds = 0.1\nmaterials = \"brass\"\n[[object]]\n\
    shape = \"box:0.2x0.03x0.008\"\npoints = [[0.09, 0.01, 0.004]]\n[[striker]]\nmaterials = \"wood\"\n\
    radius = 0.01\nspeed = 0.7\n[[listener]]\nposition = [0.1, 0.5, 0.2]\n";

fn samples(path: &std::path::Path) -> Vec<f32> {
    let mut samples = Vec::new();
    WavReader::open(path).unwrap().read(&mut samples, 10_000).unwrap();
    samples
}

#[test]
fn property_a_data_set_has_the_samples_of_strike() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("bars.toml"), RECIPE).unwrap();
    let list = ["strike", "--list", "bars.toml", "-o", "bars", "--quality", "draft", "--files", "wav"];
    let report: Value =
        serde_json::from_str(&clangor(folder, &[&list[..], &["--shard", "2/2", "--json"]].concat())).unwrap();
    assert_eq!((&report["strikes"], &report["kept"]), (&Value::from(1), &Value::from(0)));
    let report: Value =
        serde_json::from_str(&clangor(folder, &[&list[..], &["--shards", "2", "--json"]].concat())).unwrap();
    assert_eq!((&report["strikes"], &report["kept"]), (&Value::from(2), &Value::from(1)));
    let single = "strike box:0.2x0.03x0.008 --material brass --striker wood:0.01 --speed 0.7 --point \
        0.09,0.01,0.004 --listener 0.1,0.5,0.2 --sample-rate 8000 --seconds 0.1 --quality draft -o one.wav";
    clangor(folder, &single.split_whitespace().collect::<Vec<_>>());
    let one = samples(&folder.join("one.wav"));
    assert_eq!(one.len(), 817);
    for index in 0..2 {
        let name = format!("bars/strikes-{:05}-of-00002/{index:09}.wav", index + 1);
        assert_eq!(samples(&folder.join(name)), one);
    }
}

#[test]
fn property_impossible_data_sets_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("bars.toml"), RECIPE.replace("speed = 0.7", "sped = 0.7")).unwrap();
    let refused = |line: &str| {
        let output = run(folder, &line.split_whitespace().collect::<Vec<_>>());
        assert!(!output.status.success(), "{line}");
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    let misspelt = refused("strike --list bars.toml -o out");
    assert!(misspelt.contains("did you mean `speed`?") && misspelt.contains("bars.toml:11"), "{misspelt}");
    assert!(refused("strike --list bars.toml -o out --shard 17/16").contains("17/16 is no part"));
    assert!(refused("strike --list no.toml -o out").contains("cannot read no.toml"));
    fs::write(folder.join("no.txt"), "").unwrap();
    assert!(refused("strike --list no.txt -o out").contains("no.txt is no table that can be read"));
    assert!(refused("strike bowl --list bars.toml -o out").contains("cannot be used with"));
    assert!(refused("strike --list bars.toml").contains("--output"));
    assert!(refused("strike -o out.wav").contains("<BODY>"));
    assert!(!folder.join("out").exists());
}

/// Damaged entries of the cache, as any defect of a model, are told once for each body, on standard error.
#[test]
fn property_defects_of_sound_models_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("bars.toml"), RECIPE).unwrap();
    let line = "strike --list bars.toml -o bars --quality draft --shard";
    let warnings = |part: &str| {
        let output = run(folder, &line.split_whitespace().chain([part]).collect::<Vec<_>>());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    assert_eq!(warnings("1/2"), "");
    let entries: Vec<_> = fs::read_dir(folder.join("cache")).unwrap().map(|e| e.unwrap().path()).collect();
    for entry in entries.iter().filter(|path| path.is_file()) {
        let mut bytes = fs::read(entry).unwrap();
        let middle = bytes.len() / 2;
        bytes[middle] ^= 1;
        fs::write(entry, bytes).unwrap();
    }
    let heard = warnings("2/2");
    assert!(heard.contains("\"box:0.2x0.03x0.008\" of brass: ") && heard.contains("baked again"), "{heard}");
    assert_eq!(warnings("2/2"), "");
}
