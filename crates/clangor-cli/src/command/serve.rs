//! `clangor serve`: the page in one's own browser.

use clangor_serve::page::BUILD_COMMAND;
use clangor_serve::{Server, embedded_page};
use serde_json::json;

use crate::arguments::Serve;
use crate::console::Console;
use crate::failure::Failure;

pub(crate) fn run(options: &Serve, console: &Console) -> Result<(), Failure> {
    let Some(page) = embedded_page() else {
        return Err(Failure::new(format_args!(
            "this program was built without the page; in the folder of its source:\n  {BUILD_COMMAND}\n  \
             cargo build --release"
        )));
    };
    let server = Server::bind(page, options.port).map_err(Failure::new)?;
    console.say(format_args!("{} (only from this machine; Ctrl-C ends it)", server.address()));
    console.json(&json!({ "address": server.address(), "port": server.port() }));
    server.run(&mut || console.flow()).map_err(Failure::new)?;
    Err(Failure::InterruptedWith("no longer served".into()))
}
