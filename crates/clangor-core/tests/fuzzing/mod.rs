//! Inputs for parsers: seeds, changed at random over and over.
//!
//! An input that leads to an outcome not seen before (a message without its numbers, or a success) joins the
//! inputs that are changed further, so that a run finds its way past one check after the other. Runs repeat:
//! the same seed and the same number of executions give the same inputs.
//!
//! `CLANGOR_FUZZ` is the number of executions for each parser, `CLANGOR_FUZZ_RUNS` for each target that
//! simulates or renders, `CLANGOR_FUZZ_SEED` another beginning, and `CLANGOR_FUZZ_INPUT` a file that takes
//! the place of all inputs. The input being read lies at the path that is printed at the start; after a
//! panic, a hang or an abort it is the one that caused it.
//!
//! What it is not: guided by the coverage of the code. The number of distinct outcomes is printed instead.

mod change;

use std::collections::HashSet;
use std::env;
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::process;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;
use std::time::{Duration, Instant};

pub(crate) use change::Random;

/// Longest time that an input may take; one of these sizes should take milliseconds.
const LONGEST: Duration = Duration::from_secs(10);
/// Executions of a parser, unless `CLANGOR_FUZZ` says otherwise.
const FEW: u64 = 2_000;
/// Executions of a target that simulates, unless `CLANGOR_FUZZ_RUNS` says otherwise.
const FEW_RUNS: u64 = 20;
/// Tries to make an input whole for each that is read.
const MOST_TRIES: u64 = 20;
/// Most inputs that are changed further.
const MOST_KEPT: usize = 4_000;
/// Longest input [bytes].
const MOST_BYTES: usize = 1 << 16;

/// What is fuzzed, and with what.
pub(crate) struct Target<'a> {
    pub(crate) name: &'static str,
    /// Extension of the file that the input lies in.
    pub(crate) extension: &'static str,
    pub(crate) seeds: Vec<Vec<u8>>,
    /// Words of the format.
    pub(crate) words: &'a [&'a str],
    /// Makes a changed input whole again, as with a checksum; `None` drops it.
    pub(crate) mend: &'a dyn Fn(Vec<u8>) -> Option<Vec<u8>>,
    /// Whether it simulates or renders.
    pub(crate) runs: bool,
}

impl Target<'_> {
    /// A parser of files with this extension.
    pub(crate) fn parser<'a>(
        name: &'static str,
        extension: &'static str,
        seeds: Vec<Vec<u8>>,
        words: &'a [&'a str],
    ) -> Target<'a> {
        Target { name, extension, seeds, words, mend: &Some, runs: false }
    }
}

fn number(variable: &str, default: u64) -> u64 {
    match env::var(variable) {
        Ok(text) => text.parse().unwrap_or_else(|_| panic!("{variable} = {text:?} is no number")),
        Err(_) => default,
    }
}

/// The text without its numbers and names, by which outcomes are told apart.
fn kind(outcome: &str) -> String {
    let mut quoted = false;
    let mut kind = String::new();
    for character in outcome.chars().take(400) {
        if matches!(character, '"' | '`') {
            quoted = !quoted;
        }
        let digit = character.is_ascii_digit() || matches!(character, '.' | '-' | '+');
        if !quoted && !digit && !kind.ends_with(character) {
            kind.push(character);
        }
    }
    kind
}

/// Ends the process if an input takes too long.
fn watch(path: PathBuf) -> Arc<AtomicU64> {
    let turn = Arc::new(AtomicU64::new(0));
    let watched = Arc::clone(&turn);
    thread::spawn(move || {
        let (mut last, mut since) = (0, Instant::now());
        loop {
            thread::sleep(Duration::from_millis(200));
            let now = watched.load(Ordering::Relaxed);
            if now == u64::MAX {
                return;
            }
            if now != last {
                (last, since) = (now, Instant::now());
            } else if since.elapsed() > LONGEST {
                eprintln!("the input {} takes more than {LONGEST:?}", path.display());
                process::abort();
            }
        }
    });
    turn
}

/// Where inputs are written: in memory, where there is such a folder. To write a file anew waits for a disk.
pub(crate) fn in_memory() -> &'static Path {
    let memory = Some(Path::new("/dev/shm")).filter(|memory| memory.is_dir());
    memory.unwrap_or(Path::new(env!("CARGO_TARGET_TMPDIR")))
}

/// Gives changed inputs to `read`, which gets the file that holds the input and its bytes, and returns a text
/// by which outcomes are told apart: the message of an error, or what was read.
pub(crate) fn fuzz(target: &Target<'_>, read: &dyn Fn(&Path, &[u8]) -> String) {
    let folder = format!("fuzz-{}-{}", target.name, process::id());
    let folder = in_memory().join(folder);
    fs::create_dir_all(&folder).unwrap();
    let path = folder.join(format!("input.{}", target.extension));
    println!("{}: inputs at {}", target.name, path.display());
    let executions =
        if target.runs { number("CLANGOR_FUZZ_RUNS", FEW_RUNS) } else { number("CLANGOR_FUZZ", FEW) };
    let mut random = Random::new(number("CLANGOR_FUZZ_SEED", 1), target.name);
    let given = env::var_os("CLANGOR_FUZZ_INPUT").map(|path| fs::read(path).unwrap());
    let turn = watch(path.clone());
    let (mut kept, mut seen) = (target.seeds.clone(), HashSet::new());
    let (start, mut slowest, mut done) = (Instant::now(), (Duration::ZERO, 0), 0_u64);
    for execution in 0..MOST_TRIES * executions {
        if done >= executions {
            break;
        }
        let input = match (&given, target.seeds.get(execution as usize)) {
            (Some(given), _) => Some(given.clone()),
            (None, Some(seed)) => Some(seed.clone()),
            (None, None) => {
                let mut changed = random.changed(&kept, target.words);
                changed.truncate(MOST_BYTES);
                (target.mend)(changed)
            }
        };
        let Some(input) = input else { continue };
        fs::write(&path, &input).unwrap();
        turn.store(execution + 1, Ordering::Relaxed);
        let before = Instant::now();
        let outcome = catch_unwind(AssertUnwindSafe(|| read(&path, &input)));
        let took = before.elapsed();
        done += 1;
        let Ok(outcome) = outcome else {
            turn.store(u64::MAX, Ordering::Relaxed);
            panic!("{}: panicked in execution {execution}, with {}", target.name, path.display());
        };
        if took > slowest.0 {
            slowest = (took, input.len());
        }
        if seen.insert(kind(&outcome)) && kept.len() < MOST_KEPT {
            kept.push(input);
        }
        if given.is_some() {
            println!("{outcome}");
            break;
        }
    }
    turn.store(u64::MAX, Ordering::Relaxed);
    let peak = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let peak = peak.lines().find(|line| line.starts_with("VmHWM")).unwrap_or_default().to_owned();
    println!(
        "{}: {done} executions, {} outcomes, {:.1} s; the slowest took {:?} for {} bytes; {peak}",
        target.name,
        seen.len(),
        start.elapsed().as_secs_f64(),
        slowest.0,
        slowest.1,
    );
    fs::remove_dir_all(&folder).unwrap();
}
