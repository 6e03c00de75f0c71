//! The published error table: what Clangor computes, against closed forms, printed numbers and second
//! methods.
//!
//! Every check runs the product's own path. Most references share no code with it; the column says where one
//! does, such as a finer step, another sample rate or the state at the start. `docs/validation.md` is the
//! output; nothing in it is typed by hand.

mod compliant_contact;
mod contact;
mod dynamics;
mod fields;
mod geometry;
mod ground;
mod motion;
mod radiation;
mod rendering;
mod ringing;
mod scenes;

use std::fmt::Write;

/// One line of the table.
#[derive(Clone, Debug, PartialEq)]
pub struct Check {
    /// What part of the system.
    pub section: &'static str,
    /// What is computed.
    pub quantity: String,
    /// What it is compared with.
    pub reference: &'static str,
    /// The error that was measured.
    pub error: f64,
    /// The error that is allowed.
    pub bar: f64,
    /// Unit of both; empty for relative errors.
    pub unit: &'static str,
}

impl Check {
    /// Whether the error is within its bar. NaN is not.
    pub fn holds(&self) -> bool {
        self.error <= self.bar
    }
}

/// A time that was measured; it is printed, and never fails.
#[derive(Clone, Debug, PartialEq)]
pub struct Timing {
    /// What was run.
    pub what: String,
    /// CPU time of the process, all threads \[s\].
    pub cpu_seconds: f64,
}

/// How much to run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    /// Less than a minute.
    Quick,
    /// Everything.
    Full,
}

/// The table.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Validation {
    /// Accuracy.
    pub checks: Vec<Check>,
    /// Cost.
    pub timings: Vec<Timing>,
}

/// A section could not be carried out at all.
#[derive(Debug, thiserror::Error)]
#[error("the checks of {section} could not run: {reason}")]
pub struct ValidationError {
    /// Which.
    pub section: &'static str,
    /// Why.
    pub reason: String,
}

/// Whatever error a stage may give.
type Fault = Box<dyn std::error::Error>;
/// What a section returns: its checks are in the table.
type Outcome = Result<(), Fault>;
/// A part of the table.
type Section = fn(Extent, &mut Validation) -> Outcome;

/// Runs the checks; `report` is told of each section before it runs.
///
/// # Errors
/// [`ValidationError`] if a check cannot be carried out; a check that fails its bar is in the table.
pub fn validate(extent: Extent, report: &mut dyn FnMut(&str)) -> Result<Validation, ValidationError> {
    let mut table = Validation::default();
    let sections: [(&'static str, Section); 11] = [
        ("contact", contact::run),
        ("forces of contact", compliant_contact::run),
        ("radiation", radiation::run),
        ("fields", fields::run),
        ("ringing", ringing::run),
        ("rendering", rendering::run),
        ("ground", ground::run),
        ("geometry", geometry::run),
        ("dynamics", dynamics::run),
        ("motion", motion::run),
        ("scenes", scenes::run),
    ];
    for (section, run) in sections {
        report(section);
        run(extent, &mut table).map_err(|fault| ValidationError { section, reason: fault.to_string() })?;
    }
    Ok(table)
}

/// The table as Markdown.
pub fn markdown(table: &Validation, extent: Extent) -> String {
    let command = match extent {
        Extent::Quick => "clangor validate --quick",
        Extent::Full => "clangor validate --full",
    };
    let mut out = String::from("# Validation\n\n");
    let _ = writeln!(
        out,
        "Written by `{command} -o docs/validation.md` (version {}). Every error is measured by running the \
         program \
         against the reference named beside it: a closed form, a printed number, a second method, or the \
         program itself \
         where that is what the reference says (a finer step, another sample rate, the state at the \
         start). Errors \
         without a unit are relative.\n",
        env!("CARGO_PKG_VERSION")
    );
    let mut section = "";
    for check in &table.checks {
        if check.section != section {
            section = check.section;
            let _ = write!(
                out,
                "## {section}\n\n| quantity | reference | error | bar | holds |\n|---|---|---|---|---|\n"
            );
        }
        let unit = if check.unit.is_empty() { String::new() } else { format!(" {}", check.unit) };
        let _ = writeln!(
            out,
            "| {} | {} | {:.1e}{unit} | {:.0e}{unit} | {} |",
            check.quantity,
            check.reference,
            check.error,
            check.bar,
            if check.holds() { "yes" } else { "**no**" }
        );
        let last = table.checks.iter().rfind(|c| c.section == section);
        if last.is_some_and(|l| std::ptr::eq(l, check)) {
            out.push('\n');
        }
    }
    out.push_str("## Cost\n\nCPU time of all threads; it depends on the machine and is never a failure.\n\n");
    out.push_str("| what | CPU s |\n|---|---|\n");
    for timing in &table.timings {
        let _ = writeln!(out, "| {} | {:.2} |", timing.what, timing.cpu_seconds);
    }
    out
}

/// CPU time of this process so far, all threads \[s\]; where the system does not tell, the time since the
/// first call.
fn cpu_time() -> f64 {
    static START: std::sync::LazyLock<std::time::Instant> = std::sync::LazyLock::new(std::time::Instant::now);
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // User and system time are fields 14 and 15, in ticks of 10 ms; the name in field 2 may hold spaces.
    let after_name = stat.rsplit(')').next().unwrap_or_default();
    let ticks: Vec<f64> =
        after_name.split_whitespace().skip(11).take(2).filter_map(|t| t.parse().ok()).collect();
    match ticks[..] {
        [user, system] => (user + system) / 100.0,
        _ => START.elapsed().as_secs_f64(),
    }
}
