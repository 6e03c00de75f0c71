//! The program `clangor`.
//!
//! A command calls one stage of `clangor_pipeline` after the other: load, simulate, render. What goes wrong
//! comes back as a [`Failure`] and is printed once, here.

mod arguments;
mod command;
mod console;
mod diagnostics;
mod failure;
mod printable;

use std::io::Write;
use std::process::ExitCode;

use clap::Parser;

use arguments::former_names::{Renewed, renew};
use arguments::{Arguments, Command};
use console::Console;
use failure::Failure;
use printable::printable;

fn main() -> ExitCode {
    let Renewed { words, warnings } = renew(std::env::args_os());
    let arguments = Arguments::parse_from(words);
    let console = Console::new(arguments.global.quiet, arguments.global.json);
    for warning in warnings {
        console.warn(warning);
    }
    let global = &arguments.global;
    let threads = global.threads.map_or(0, usize::from);
    let done = clangor_pipeline::with_threads(threads, || match &arguments.command {
        Command::Render(options) => command::render::run(options, global, &console),
        Command::Play(options) => command::play::run(options, global, &console),
        Command::Check(options) => command::check::run(options, global, &console),
        Command::Simulate(options) => command::simulate::run(options, global, &console),
        Command::Bake(options) => command::bake::run(options, global, &console),
        Command::Bank(options) => command::bank::run(options, global, &console),
        Command::Plot(options) => command::plot::run(options, &console),
        Command::Modes(options) => command::modes::run(options, &console),
        Command::Compare(options) => command::compare::run(options, global, &console),
        Command::Strike(options) => command::strike::run(options, global, &console),
        Command::Import(options) => command::import::run(options, global, &console),
        Command::Export(options) => command::export::run(options, global, &console),
        Command::Inspect(options) => command::inspect::run(options, global, &console),
        Command::Validate(options) => command::validate::run(options, &console),
        Command::Serve(options) => command::serve::run(options, &console),
    });
    let ended = done.and_then(|()| console.finish());
    if let Some(errors) = ended.as_ref().err().and_then(Failure::json) {
        console.json_errors(&errors);
    }
    let (message, code) = match ended {
        Ok(()) => return ExitCode::SUCCESS,
        Err(Failure::Interrupted) => {
            ("interrupted; what was not complete has been removed".to_owned(), ExitCode::from(130))
        }
        Err(Failure::InterruptedWith(message)) => (printable(&message).into_owned(), ExitCode::from(130)),
        Err(Failure::Error(message)) => (printable(message.trim_end()).into_owned(), ExitCode::FAILURE),
        Err(Failure::Drawn { text, .. }) => (text.trim_end().to_owned(), ExitCode::FAILURE),
    };
    let _ = writeln!(std::io::stderr(), "{message}");
    code
}
