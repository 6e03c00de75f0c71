//! What a simulation says about bodies that may break.

use clangor_sim::BreakingReport;
use serde_json::{Value, json};

use crate::console::Console;

/// Blows that broke nothing, and why; what should have broken and did not.
pub(super) fn say(console: &Console, report: &BreakingReport) {
    let BreakingReport { screened, solved, withstood, capped, refused } = report;
    if screened + solved > 0 {
        console.say(format_args!(
            "{} blows on bodies that may break: stress computed for {solved}, of which {withstood} beyond the strength but too \
             weak to pay for a crack",
            screened + solved
        ));
    }
    if *capped > 0 {
        console.warn(format_args!(
            "{capped} blows would have broken a body that is in as many pieces as allowed already: set `most_pieces` under \
             `fracture` if there are to be more"
        ));
    }
    for (body, reason) in refused {
        console.warn(format_args!("\"{body}\" should have broken, but stays whole: {reason}"));
    }
}

/// The same for machines.
pub(super) fn json(report: &BreakingReport) -> Value {
    json!({
        "screened": report.screened,
        "solved": report.solved,
        "withstood": report.withstood,
        "capped": report.capped,
        "refused": report.refused,
    })
}
