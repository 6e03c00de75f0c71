//! Convergence: errors shrink with the resolution at the expected slope.

#[expect(dead_code, reason = "parts of it are for other tests")]
#[path = "../scenes/rigid.rs"]
mod scenes;

mod rigid_first_impact;
