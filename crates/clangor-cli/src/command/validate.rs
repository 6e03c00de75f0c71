//! `clangor validate`: the published error table.

use clangor_pipeline::formats::atomic_file::write_atomically;
use clangor_pipeline::validate::{Extent, markdown, validate};
use serde_json::json;

use crate::arguments::Validate;
use crate::console::Console;
use crate::failure::Failure;

pub(crate) fn run(options: &Validate, console: &Console) -> Result<(), Failure> {
    let extent = if options.full { Extent::Full } else { Extent::Quick };
    let table = validate(extent, &mut |section| console.say(format_args!("checking {section} …")))
        .map_err(Failure::new)?;
    if let Some(path) = &options.output {
        write_atomically(path, markdown(&table, extent).as_bytes()).map_err(Failure::new)?;
    }
    for check in &table.checks {
        console.say(format_args!(
            "{} {}: {:.1e} {} (bar {:.0e})",
            if check.holds() { "holds " } else { "BREAKS" },
            check.quantity,
            check.error,
            check.unit,
            check.bar
        ));
    }
    for timing in &table.timings {
        console.say(format_args!("{:.2} CPU s for {}", timing.cpu_seconds, timing.what));
    }
    console.json(&json!({
        "checks": table.checks.iter().map(|c| json!({
            "section": c.section,
            "quantity": c.quantity,
            "reference": c.reference,
            "error": c.error,
            "bar": c.bar,
            "unit": c.unit,
            "holds": c.holds(),
        })).collect::<Vec<_>>(),
        "timings": table.timings.iter().map(|t| json!({
            "what": t.what,
            "cpu_s": t.cpu_seconds,
        })).collect::<Vec<_>>(),
    }));
    let broken = table.checks.iter().filter(|c| !c.holds()).count();
    if broken > 0 {
        return Err(Failure::new(format_args!("{broken} of {} checks miss their bar", table.checks.len())));
    }
    Ok(())
}
