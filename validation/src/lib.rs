//! Reproduces tables and figures of the papers, each by a separate program in `src/bin`; this library holds
//! their shared code.
//!
//! Run one by `cargo run --release -p clangor-validation --bin NAME`:
//!
//! | program | reproduces |
//! |---|---|
//! | `pan_table_1` | \[PAN\] Table 1: time of the bake and size of each model |
//! | `pan_table_2` | \[PAN\] Table 2 and \[PROXY\] Table 2: time to synthesise each scene |
//! | `pan_representation_bowl` | \[PAN\] figs. 8 and 9: errors of angular grids and pulse widths |
//! | `pan_representation_ladder` | \[PROXY\] §5: storage against the tolerance ε |
//! | `pan_representation_compare` | errors, bytes and time of published representation and multipoles |
//! | `proxy_table_1` | \[PROXY\] Table 1: size and time of both representations |
//! | `proxy_figure_4` | \[PROXY\] Fig. 4: pulses of ellipsoids along three edges of the bank |
//! | `rock_proxies` | errors of ellipsoids and spheres that replace irregular stones |
//! | `fracture_figures` | \[FRAC\] Figs. 4 and 5: pieces against toughness, impulses of cracks |
//! | `contact_figures` | forces of impacts that the solve of the contact gives, beside Hertz's pulse |
//! | `piece_proxies` | \[FRAC\] Table 2: errors and time of modal proxies of fragments |

pub mod cpu_time;
pub mod pan_representation;
pub mod panel;
pub mod paper_scene;
