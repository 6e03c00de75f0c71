//! Papers: their printed numbers come out.

#[path = "../exact_fields/mod.rs"]
mod exact_fields;

mod elastostatics;
mod modal_soundbank;
mod proxy_ladder;
