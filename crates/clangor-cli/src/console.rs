//! What the person at the terminal sees: results, warnings, progress with an estimate, and interruption.

use std::io::Write;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Where messages go, and whether the person has asked to stop.
pub(crate) struct Console {
    quiet: bool,
    json: bool,
    stop: Arc<AtomicBool>,
}

impl Console {
    /// Listens for Ctrl-C from now on: the first one asks work to stop, a second one ends the program at
    /// once.
    pub(crate) fn new(quiet: bool, json: bool) -> Self {
        let stop = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&stop);
        let handled = ctrlc::set_handler(move || {
            if flag.swap(true, Ordering::SeqCst) {
                std::process::exit(130);
            }
        });
        if let Err(error) = handled {
            let _ = writeln!(
                std::io::stderr(),
                "warning: Ctrl-C will end the program without tidying up: {error}"
            );
        }
        Console { quiet, json, stop }
    }

    /// Whether results are wanted as JSON.
    pub(crate) fn wants_json(&self) -> bool {
        self.json
    }

    /// A line of the result, unless JSON or silence was asked for.
    pub(crate) fn say(&self, line: impl std::fmt::Display) {
        if !self.quiet && !self.json {
            print_line(&line);
        }
    }

    /// A warning, on standard error.
    pub(crate) fn warn(&self, line: impl std::fmt::Display) {
        if !self.quiet {
            let _ = writeln!(std::io::stderr(), "warning: {line}");
        }
    }

    /// A message that says itself what it is, on standard error.
    pub(crate) fn note(&self, text: impl std::fmt::Display) {
        if !self.quiet {
            let _ = writeln!(std::io::stderr(), "{text}");
        }
    }

    /// The result as JSON, if asked for.
    pub(crate) fn json(&self, value: &serde_json::Value) {
        if self.json {
            print_line(value);
        }
    }

    /// `Break` once the person has pressed Ctrl-C.
    pub(crate) fn flow(&self) -> ControlFlow<()> {
        if self.stop.load(Ordering::SeqCst) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// A progress bar over work of `total` seconds of scene time.
    pub(crate) fn progress(&self, what: &'static str, total: f64) -> Progress<'_> {
        let bar = ProgressBar::with_draw_target(
            Some((total * UNITS_PER_SECOND).ceil() as u64),
            if self.quiet || self.json { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() },
        );
        let style = ProgressStyle::with_template(
            "{prefix:>10} {bar:40} {percent:>3} %  {elapsed} (about {eta} left)",
        );
        if let Ok(style) = style {
            bar.set_style(style);
        }
        bar.set_prefix(what);
        Progress { bar, console: self }
    }
}

/// Prints to standard output; a reader that has gone away, such as `head`, misses the rest and stops nothing.
fn print_line(line: &dyn std::fmt::Display) {
    let _ = writeln!(std::io::stdout(), "{line}");
}

/// Resolution of progress bars.
const UNITS_PER_SECOND: f64 = 1e4;

/// A running progress bar; gone when dropped.
pub(crate) struct Progress<'a> {
    bar: ProgressBar,
    console: &'a Console,
}

impl Progress<'_> {
    /// Names the part of the work that is being done.
    pub(crate) fn stage(&self, what: &'static str) {
        self.bar.set_prefix(what);
    }

    /// Shows how far the work is [s of scene time]; `Break` if it should stop.
    pub(crate) fn reached(&self, time: f64) -> ControlFlow<()> {
        self.bar.set_position((time.max(0.0) * UNITS_PER_SECOND) as u64);
        self.console.flow()
    }
}

impl Drop for Progress<'_> {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// A number with its noun: `1 body`, `2 bodies`.
pub(crate) fn counted(count: usize, one: &str, many: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { many })
}

/// A number with four significant digits, in scientific notation where it is very small or large.
pub(crate) fn four_digits(number: f64) -> String {
    let decade = number.abs().log10().floor();
    if number == 0.0 {
        "0".into()
    } else if (-3.0..5.0).contains(&decade) {
        format!("{number:.*}", (3.0 - decade).max(0.0) as usize)
    } else {
        format!("{number:.3e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let cases = [
            (0.0, "0"),
            (3.70891, "3.709"),
            (-39.516, "-39.52"),
            (0.00123456, "0.001235"),
            (12345.6, "12346"),
        ];
        for (number, text) in cases {
            assert_eq!(four_digits(number), text);
        }
        assert_eq!(four_digits(1.0460e32), "1.046e32");
        assert_eq!(four_digits(2.5e-5), "2.500e-5");
    }
}
