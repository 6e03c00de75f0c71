//! What the person at the terminal sees: results, warnings, progress with an estimate, and interruption.

use std::io::{IsTerminal, Write};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use crate::failure::Failure;
use crate::printable::printable;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Where messages go, and whether the person has asked to stop.
pub(crate) struct Console {
    quiet: bool,
    json: bool,
    stop: Arc<AtomicBool>,
    /// Whether a command asks from time to time if it should stop.
    asks: Arc<AtomicBool>,
    /// Why the results could not be printed.
    unprinted: Mutex<Option<std::io::Error>>,
    /// The warnings so far, for the result as JSON.
    warnings: Mutex<Vec<String>>,
    /// Whether the result has been printed as JSON.
    has_result: AtomicBool,
}

impl Console {
    /// Listens for Ctrl-C and SIGTERM from now on: the first one asks work to stop, a second one ends the
    /// program at once, as does the first before any work has begun, such as while a pipe is read.
    pub(crate) fn new(quiet: bool, json: bool) -> Self {
        let stop = Arc::new(AtomicBool::new(false));
        let asks = Arc::new(AtomicBool::new(false));
        let (flag, listens) = (Arc::clone(&stop), Arc::clone(&asks));
        let handled = ctrlc::set_handler(move || {
            if flag.swap(true, Ordering::SeqCst) || !listens.load(Ordering::SeqCst) {
                std::process::exit(130);
            }
        });
        if let Err(error) = handled {
            let _ = writeln!(
                std::io::stderr(),
                "warning: Ctrl-C will end the program without tidying up: {error}"
            );
        }
        Console {
            quiet,
            json,
            stop,
            asks,
            unprinted: Mutex::default(),
            warnings: Mutex::default(),
            has_result: AtomicBool::new(false),
        }
    }

    /// Whether results are wanted as JSON.
    pub(crate) fn wants_json(&self) -> bool {
        self.json
    }

    /// A line of the result, unless JSON or silence was asked for.
    pub(crate) fn say(&self, line: impl std::fmt::Display) {
        if !self.quiet && !self.json {
            self.print_line(&printable(&line.to_string()));
        }
    }

    /// A warning, on standard error.
    pub(crate) fn warn(&self, line: impl std::fmt::Display) {
        let line = line.to_string();
        if !self.quiet {
            let _ = writeln!(std::io::stderr(), "warning: {}", printable(&line));
        }
        self.keep_warning(line);
    }

    /// Keeps a warning that is drawn elsewhere for the result as JSON.
    pub(crate) fn keep_warning(&self, line: String) {
        if let Ok(mut warnings) = self.warnings.lock()
            && !warnings.contains(&line)
        {
            warnings.push(line);
        }
    }

    /// A message that says itself what it is, on standard error.
    pub(crate) fn note(&self, text: impl std::fmt::Display) {
        if !self.quiet {
            let _ = writeln!(std::io::stderr(), "{}", printable(&text.to_string()));
        }
    }

    /// A message that is drawn: free of what a terminal would obey, but for colours.
    pub(crate) fn drawn(&self, text: impl std::fmt::Display) {
        if !self.quiet {
            let _ = writeln!(std::io::stderr(), "{text}");
        }
    }

    /// The result as JSON, if asked for; an object without a list of warnings gets those that were printed.
    pub(crate) fn json(&self, value: &serde_json::Value) {
        if !self.json {
            return;
        }
        let mut value = value.clone();
        if let (Some(object), Ok(warnings)) = (value.as_object_mut(), self.warnings.lock()) {
            object.entry("warnings").or_insert_with(|| warnings.as_slice().into());
        }
        self.has_result.store(true, Ordering::SeqCst);
        self.print_line(&value);
    }

    /// The errors as JSON in place of the result, if that has not been printed.
    pub(crate) fn json_errors(&self, errors: &serde_json::Value) {
        if !self.has_result.load(Ordering::SeqCst) {
            self.json(errors);
        }
    }

    /// Prints to standard output; a reader that has gone away, such as `head`, misses the rest and stops
    /// nothing.
    fn print_line(&self, line: &dyn std::fmt::Display) {
        let printed = writeln!(std::io::stdout(), "{line}").and_then(|()| std::io::stdout().flush());
        if let Err(error) = printed
            && error.kind() != std::io::ErrorKind::BrokenPipe
            && let Ok(mut unprinted) = self.unprinted.lock()
        {
            unprinted.get_or_insert(error);
        }
    }

    /// The end of a command that has its result.
    ///
    /// # Errors
    /// [`Failure`] where the result could not be printed.
    pub(crate) fn finish(&self) -> Result<(), Failure> {
        match self.unprinted.lock().ok().and_then(|mut unprinted| unprinted.take()) {
            Some(error) => Err(Failure::new(format_args!("cannot write to standard output: {error}"))),
            None => Ok(()),
        }
    }

    /// `Break` once the person has pressed Ctrl-C.
    pub(crate) fn flow(&self) -> ControlFlow<()> {
        self.asks.store(true, Ordering::SeqCst);
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
        let in_lines = !self.quiet && !self.json && !std::io::stderr().is_terminal();
        let lines =
            in_lines.then(|| Mutex::new(Lines { what, total, begun: Instant::now(), next: LINES_EVERY }));
        Progress { bar, console: self, lines }
    }
}

/// Resolution of progress bars.
const UNITS_PER_SECOND: f64 = 1e4;

/// A running progress bar; gone when dropped.
pub(crate) struct Progress<'a> {
    bar: ProgressBar,
    console: &'a Console,
    /// Where no terminal shows the bar.
    lines: Option<Mutex<Lines>>,
}

/// Time between lines of progress in the first minute, and after it.
const LINES_EVERY: Duration = Duration::from_secs(10);
const LATER_LINES_EVERY: Duration = Duration::from_secs(60);

/// Progress as lines on standard error, for logs.
struct Lines {
    what: &'static str,
    /// All work [s of scene time].
    total: f64,
    begun: Instant,
    /// When the next line is due, since the beginning.
    next: Duration,
}

impl Lines {
    /// The line that is due after a time, with the work done until then [s of scene time].
    fn due(&mut self, elapsed: Duration, time: f64) -> Option<String> {
        if elapsed < self.next {
            return None;
        }
        let every = if elapsed < LATER_LINES_EVERY { LINES_EVERY } else { LATER_LINES_EVERY };
        self.next = elapsed + every;
        let share = (time / self.total).clamp(0.0, 1.0);
        let seconds = elapsed.as_secs_f64();
        let left = match share > 0.0 {
            true => format!(", about {:.0} s left", seconds * (1.0 - share) / share),
            false => String::new(),
        };
        Some(format!("{}: {:.0} % after {seconds:.0} s{left}", self.what, 100.0 * share))
    }
}

impl Progress<'_> {
    /// Names the part of the work that is being done.
    pub(crate) fn stage(&self, what: &'static str) {
        self.bar.set_prefix(what);
        if let Some(Ok(mut lines)) = self.lines.as_ref().map(Mutex::lock) {
            lines.what = what;
        }
    }

    /// Shows how far the work is [s of scene time]; `Break` if it should stop.
    pub(crate) fn reached(&self, time: f64) -> ControlFlow<()> {
        self.bar.set_position((time.max(0.0) * UNITS_PER_SECOND) as u64);
        if let Some(Ok(mut lines)) = self.lines.as_ref().map(Mutex::lock) {
            let elapsed = lines.begun.elapsed();
            if let Some(line) = lines.due(elapsed, time) {
                self.console.note(line);
            }
        }
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
    fn lines_of_progress_come_every_ten_seconds_and_later_every_minute() {
        let mut lines = Lines { what: "bake", total: 2.0, begun: Instant::now(), next: LINES_EVERY };
        let due: Vec<u64> =
            (0..400).filter(|s| lines.due(Duration::from_secs(*s), *s as f64 / 200.0).is_some()).collect();
        assert_eq!(due, [10, 20, 30, 40, 50, 60, 120, 180, 240, 300, 360]);
        let line = lines.due(Duration::from_secs(420), 0.5);
        assert_eq!(line.as_deref(), Some("bake: 25 % after 420 s, about 1260 s left"));
    }

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
