//! The published representation of acceleration noise against the papers' figures and against our multipoles:
//! `cargo bench -p clangor-bake --bench published -- [ladder] [bank] [bowl] [compare]`, everything without
//! arguments.
//!
//! * `ladder`: \[PROXY\] §5, storage against ε on the bodies of revolution among the ellipsoids of the
//!   published bank.
//! * `bank`: the same on all 66 ellipsoids in a lower band, and how well the bodies of revolution stand for
//!   them.
//! * `bowl`: \[PAN\] figs. 8 and 9, angular grids and pulse widths at 8 R.
//! * `compare`: errors at 2, 8 and 100 R, bytes and time of a contact for both representations.
//!
//! Fields come from boundary elements on the meridian, which take a few minutes of processor time in all.

#[path = "published/bowl.rs"]
mod bowl;
#[path = "published/compare.rs"]
mod compare;
#[path = "published/ladder.rs"]
mod ladder;
#[path = "published/measure.rs"]
mod measure;
#[path = "published/solved_field.rs"]
mod solved_field;

fn main() {
    let sections: [(&str, fn()); 4] = [
        ("ladder", ladder::print),
        ("bank", ladder::print_bank),
        ("bowl", bowl::print),
        ("compare", compare::print),
    ];
    let asked: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    for (name, print) in sections {
        if asked.is_empty() || asked.iter().any(|a| a == name) {
            print();
        }
    }
}
