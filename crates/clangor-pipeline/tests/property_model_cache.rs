//! The cache gives back what was put in, or nothing: whoever is killed, whoever writes at the same time, and
//! whatever somebody did to the files.

use std::fs;
use std::ops::ControlFlow;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use clangor_bake::acceleration::{BakeOptions, BakeProgress, Method};
use clangor_bake::geometry_class::bake_geometry::BakeGeometry;
use clangor_core::body::Surface;
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::glam::DVec3;
use clangor_core::sound_model::acceleration::field::{AccelerationField, Node, Term};
use clangor_core::sound_model::acceleration::model::AccelerationModel;
use clangor_core::sound_model::files::model_file::{ModelFile, Origin, Solid};
use clangor_pipeline::formats::model_cache::{Lookup, ModelCache, model_key};
use clangor_pipeline::stages::sound_models::{
    AccelerationBake, SoundModelRequest, bake_and_keep, bake_model, obtain,
};
use num_complex::Complex64;

/// A model of half a megabyte, so that writing it takes a while.
fn model(key: &str, version: f32) -> ModelFile {
    let mut terms = Vec::new();
    for n in 1..=8 {
        for m in -n..=n {
            terms.extend((0..6).map(|degree| Term { n: n as u8, m, degree }));
        }
    }
    let nodes: Vec<Node> = (0..128)
        .map(|j| Node { s: Complex64::new(0.0, 0.1 * f64::from(j)), weight: Complex64::ONE })
        .collect();
    let count = terms.len() * nodes.len();
    ModelFile {
        acceleration: AccelerationModel {
            radius: 0.01,
            field: AccelerationField {
                max_wavenumber: 13.0,
                ring_time: 5.0,
                nodes,
                terms,
                real: vec![version; count],
                imaginary: vec![-version; count],
            },
            near: None,
        },
        modal: None,
        solid: Solid { name: "ball".into(), mass: MassProperties::of_sphere(0.01), surface: None },
        origin: Origin {
            program: "clangor".into(),
            inputs: key.into(),
            asked_accuracy: 1e-3,
            method: "by hand".into(),
            unknowns: 1,
            solves: 1,
            held_out_error: 0.0,
            warnings: Vec::new(),
        },
    }
}

/// A bake of several batches of frequencies.
fn slow_request() -> SoundModelRequest<AccelerationBake> {
    let options = BakeOptions { method: Method::Bem, ..BakeOptions::new(900.0, 0.05) };
    let surface = Surface::Sphere { radius: 0.01 };
    SoundModelRequest::new("ball", &surface, MassProperties::of_sphere(0.01), AccelerationBake(options))
        .unwrap()
}

const KEY: &str = "00112233445566778899aabbccddeeff";

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(folder)
        .unwrap()
        .map(|e| e.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

/// A version of the model, whole, in the cache; or nothing.
fn check_entry(cache: &ModelCache) -> bool {
    match cache.read::<ModelFile>(KEY) {
        Lookup::Found(found) => {
            assert_eq!(*found, model(KEY, found.acceleration.field.real[0]));
            true
        }
        Lookup::Missing => false,
        Lookup::Invalid(why) => panic!("{why}"),
    }
}

/// Says to the process what it is, where it is started by another test.
const ROLE: &str = "CLANGOR_TEST_ROLE";
const FOLDER: &str = "CLANGOR_TEST_FOLDER";

/// What the other processes of this file's tests do; without a role it is no test.
#[test]
fn other_process() {
    let (Ok(role), Ok(folder)) = (std::env::var(ROLE), std::env::var(FOLDER)) else { return };
    let cache = ModelCache::new(folder);
    match role.as_str() {
        "write until killed" => {
            for version in 1.. {
                cache.write(&model(KEY, version as f32)).unwrap();
            }
        }
        "write 20 times" => {
            for version in 0..20 {
                cache.write(&model(KEY, version as f32)).unwrap();
                assert!(check_entry(&cache));
            }
        }
        "bake until killed" => {
            let mut slowly = |_: &BakeProgress| {
                std::thread::sleep(Duration::from_millis(100));
                ControlFlow::Continue(())
            };
            bake_and_keep(&slow_request(), &cache, Duration::ZERO, &mut slowly).unwrap();
        }
        "find the disk full" => {
            let error = cache.write(&model(KEY, 1.0)).unwrap_err().to_string();
            assert!(error.contains("cannot write") && error.contains(KEY), "{error}");
            assert!(!check_entry(&cache));
        }
        other => panic!("no role {other}"),
    }
}

fn start(role: &str, folder: &Path, command: &mut Command) -> Child {
    command
        .args(["--exact", "other_process", "--nocapture"])
        .env(ROLE, role)
        .env(FOLDER, folder)
        .stdout(Stdio::null())
        .spawn()
        .unwrap()
}

fn myself() -> Command {
    Command::new(std::env::current_exe().unwrap())
}

#[test]
fn what_is_put_in_comes_out_and_what_is_damaged_does_not() {
    let folder = tempfile::tempdir().unwrap();
    let cache = ModelCache::new(folder.path().join("deep/cache"));
    assert!(!check_entry(&cache));
    let path = cache.write(&model(KEY, 1.0)).unwrap();
    assert!(check_entry(&cache));
    assert_eq!(names(cache.folder()), [format!("acceleration-{KEY}.safetensors")]);

    let whole = fs::read(&path).unwrap();
    let mut damaged = whole.clone();
    damaged[whole.len() / 2] ^= 4;
    for bad in [&damaged, &whole[..whole.len() - 1], &Vec::new()[..]] {
        fs::write(&path, bad).unwrap();
        assert!(matches!(cache.read::<ModelFile>(KEY), Lookup::Invalid(_)));
    }
    // A whole model under the name of another.
    fs::write(&path, model("another", 1.0).encode().unwrap()).unwrap();
    assert!(matches!(cache.read::<ModelFile>(KEY), Lookup::Invalid(why) if why.contains("other inputs")));
    cache.write(&model(KEY, 2.0)).unwrap();
    assert!(check_entry(&cache));

    // A file where the folder should be.
    let file = folder.path().join("file");
    fs::write(&file, "x").unwrap();
    let error = ModelCache::new(file.join("cache")).write(&model(KEY, 1.0)).unwrap_err().to_string();
    assert!(error.contains("--cache"), "{error}");
}

#[test]
fn what_the_killed_have_left_is_removed_and_what_the_living_write_is_not() {
    let folder = tempfile::tempdir().unwrap();
    let cache = ModelCache::new(folder.path());
    let path = |name: &str| folder.path().join(name);
    let dead = [
        path("acceleration-1.safetensors.part-1-0"),
        path("acceleration-1.safetensors.part-0123456789abcdef"),
        path(&format!("acceleration-{KEY}.safetensors.part-1-0")),
    ];
    let living = path("acceleration-2.safetensors.part-0123456789abcdef");
    let resumed = path("acceleration-3.partial");
    dead.iter().chain([&living, &resumed]).for_each(|path| fs::write(path, "half").unwrap());
    let lock = fs::File::open(&living).unwrap();
    lock.try_lock().unwrap();
    let last_month = std::time::SystemTime::now() - Duration::from_secs(31 * 86_400);
    let given_up = path("acceleration-4.partial");
    fs::write(&given_up, "half").unwrap();
    fs::File::options().write(true).open(&given_up).unwrap().set_modified(last_month).unwrap();
    cache.write(&model(KEY, 1.0)).unwrap();
    assert!(check_entry(&cache));
    assert!(dead.iter().all(|path| !path.exists()) && !given_up.exists());
    assert!(living.exists() && resumed.exists());
    // One process wrote the model while another, which was killed, still had its own half: who only reads
    // removes that too. Seen in one of 2900 kills of two containers.
    let (kept, half) = (path(&format!("acceleration-{KEY}.partial")), &dead[1]);
    fs::write(&kept, "half").unwrap();
    fs::write(half, "half").unwrap();
    let cache = ModelCache::find(Some(folder.path())).unwrap();
    assert!(check_entry(&cache));
    assert!(!kept.exists() && !half.exists() && living.exists() && resumed.exists());
}

#[test]
fn a_bake_that_is_killed_goes_on_where_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let cache = ModelCache::new(folder.path());
    let request = slow_request();
    let mut go_on = |_: &BakeProgress| ControlFlow::Continue(());
    let mut found = 0;
    for _ in 0..3 {
        let mut child = start("bake until killed", folder.path(), &mut myself());
        let wait = Instant::now();
        while cache.read_partial(request.key()).len() <= found && wait.elapsed().as_secs() < 60 {
            std::thread::sleep(Duration::from_millis(1));
        }
        child.kill().unwrap();
        child.wait().unwrap();
        let solved = cache.read_partial(request.key()).len();
        assert!(solved > found, "{solved} after {found}");
        found = solved;
        if found > 12 {
            break;
        }
    }
    let obtained = obtain(&request, Some(&cache), &mut go_on).unwrap();
    assert!(!obtained.cached && obtained.remarks.is_empty(), "{:?}", obtained.remarks);
    assert!(obtained.file == bake_model(&request, &mut go_on).unwrap());
    assert!(cache.read_partial(request.key()).is_empty());
    assert!(obtain(&request, Some(&cache), &mut go_on).unwrap().cached);
}

#[test]
fn a_process_killed_at_any_moment_leaves_a_whole_entry_or_none() {
    let folder = tempfile::tempdir().unwrap();
    let cache = ModelCache::new(folder.path());
    let (mut entries, mut partial) = (0, 0);
    for round in 0..24 {
        let mut child = start("write until killed", folder.path(), &mut myself());
        // The child needs a few milliseconds to start, and as long for each entry.
        let wait = Instant::now();
        while fs::read_dir(folder.path()).unwrap().next().is_none() && wait.elapsed().as_secs() < 10 {
            std::thread::sleep(Duration::from_millis(1));
        }
        std::thread::sleep(Duration::from_micros(700 * round));
        child.kill().unwrap();
        child.wait().unwrap();
        entries += usize::from(check_entry(&cache));
        partial += names(folder.path()).iter().filter(|n| n.contains(".part-")).count();
        if round % 4 == 3 {
            names(folder.path()).iter().for_each(|n| fs::remove_file(folder.path().join(n)).unwrap());
        }
    }
    // Otherwise no moment has been tried that matters.
    assert!(entries > 0 && partial > 0, "{entries} entries, {partial} partial files");
}

#[test]
fn processes_that_bake_the_same_do_each_other_no_harm() {
    let folder = tempfile::tempdir().unwrap();
    let children: Vec<Child> =
        (0..3).map(|_| start("write 20 times", folder.path(), &mut myself())).collect();
    for mut child in children {
        assert!(child.wait().unwrap().success());
    }
    assert_eq!(names(folder.path()), [format!("acceleration-{KEY}.safetensors")]);
    assert!(check_entry(&ModelCache::new(folder.path())));
}

#[cfg(unix)]
#[test]
fn a_full_disk_is_told_and_nothing_is_left() {
    let folder = tempfile::tempdir().unwrap();
    // A limit on the size of files stops a write half-way as a full disk does, for any user.
    let mut limited = Command::new("sh");
    limited
        .args(["-c", "trap '' XFSZ; ulimit -f 64; exec \"$0\" \"$@\""])
        .arg(std::env::current_exe().unwrap());
    let mut child = start("find the disk full", folder.path(), &mut limited);
    assert!(child.wait().unwrap().success());
    assert_eq!(names(folder.path()), Vec::<String>::new());
}

#[test]
fn keys_follow_whatever_the_model_depends_on() {
    let options = BakeOptions { near_field: true, ..BakeOptions::new(366.0, 1e-3) };
    let ball = |radius| BakeGeometry::Ellipsoid { semi_axes: DVec3::splat(radius) };
    let key = model_key(&ball(0.01), &options);
    assert_eq!(key, model_key(&ball(0.01), &options));
    assert_eq!(key.len(), 32);
    let others = [
        model_key(&ball(0.011), &options),
        model_key(&BakeGeometry::RoundedBox { edges: DVec3::splat(0.01), round: 0.0 }, &options),
        model_key(&ball(0.01), &BakeOptions { max_wavenumber: 367.0, ..options }),
        model_key(&ball(0.01), &BakeOptions { accuracy: 2e-3, ..options }),
        model_key(&ball(0.01), &BakeOptions { method: Method::Bem, ..options }),
        model_key(&ball(0.01), &BakeOptions { near_field: false, ..options }),
    ];
    for (at, other) in others.iter().enumerate() {
        assert_ne!(*other, key, "{at}");
        assert!(!others[..at].contains(other), "{at}");
    }
}
