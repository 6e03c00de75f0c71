//! What a simulation says about bodies that may break.

use std::path::Path;

use clangor_pipeline::formats::atomic_file::write_atomically;
use clangor_pipeline::stages::fracture_report::{FractureReport, Totals};
use clangor_sim::BreakingReport;
use serde_json::{Value, json};

use crate::console::{Console, counted, four_digits};
use crate::failure::Failure;

/// Impacts that broke nothing, and why; what should have broken and did not.
pub(super) fn say(console: &Console, report: &BreakingReport) {
    let BreakingReport { screened, solved, unsolved, withstood, capped, refused } = report;
    if screened + solved > 0 {
        console.say(format_args!(
            "{} on bodies that may break: stress computed for {solved}, of which {withstood} \
             beyond the strength but too \
             weak to pay for a crack",
            counted((screened + solved) as usize, "impact", "impacts")
        ));
    }
    if *unsolved > 0 {
        console.warn(format_args!(
            "the force of {} over time could not be solved: the peak of a half-sine loads the body",
            counted(*unsolved as usize, "impact", "impacts")
        ));
    }
    if *capped > 0 {
        console.warn(format_args!(
            "{} would have broken a body that is in as many pieces as allowed already: set \
             `most_pieces` under \
             `fracture` if there are to be more",
            counted(*capped as usize, "impact", "impacts")
        ));
    }
    for (body, reason) in refused {
        console.warn(format_args!("\"{body}\" should have broken, but stays whole: {reason}"));
    }
}

/// What became of the energy of the impacts that broke something.
pub(in crate::command) fn say_energies(console: &Console, totals: &Totals) {
    if totals.fractures > 0 {
        console.say(format_args!(
            "{} whole; of impacts of {} J, {} J went into fractures: {} J into {} cm² of \
             cracks, {} J into the motion of pieces",
            counted(totals.pieces, "piece is", "pieces are"),
            four_digits(totals.impact_energy),
            four_digits(totals.strain_energy),
            four_digits(totals.fracture_energy),
            four_digits(1e4 * totals.crack_area),
            four_digits(totals.crack_impulse_energy),
        ));
    }
}

/// Writes a report.
pub(in crate::command) fn write(path: &Path, report: &FractureReport) -> Result<(), Failure> {
    let text = serde_json::to_vec_pretty(report).map_err(Failure::new)?;
    write_atomically(path, &text).map_err(Failure::new)
}

/// The same for machines.
pub(super) fn json(report: &BreakingReport) -> Value {
    json!({
        "screened": report.screened,
        "solved": report.solved,
        "unsolved": report.unsolved,
        "withstood": report.withstood,
        "capped": report.capped,
        "refused": report.refused,
    })
}
