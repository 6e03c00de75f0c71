//! `clangor import`: what another tool or a person wrote becomes a timeline.

use clangor_pipeline::interchange::body_files::import_contacts;
use serde_json::json;

use super::{check_ending, load};
use crate::arguments::{Global, Import, ImportFormat};
use crate::console::Console;
use crate::failure::Failure;

pub(crate) fn run(options: &Import, global: &Global, console: &Console) -> Result<(), Failure> {
    let ImportFormat::Contacts { scene, list, output, force } = &options.format;
    check_ending(output, "timeline")?;
    let loaded = load(scene, global, &|_| (), console)?;
    let rows = import_contacts(&loaded, list, output, *force)?;
    console.say(format_args!("{}: {} contact rows", output.display(), rows.contacts));
    console.json(&json!({ "timeline": output, "contact_rows": rows.contacts }));
    Ok(())
}
