//! Motion that another program recorded, and the impacts in it.
//!
//! | module | what |
//! |---|---|
//! | `recording` | frames of bodies, and what is wrong with them |
//! | `kinematics` | velocities between frames, their jumps beyond gravity, and free flight continued past a frame |
//! | `jump_windows` | which jumps belong to one impact, and its instant between two frames |
//! | `touching` | where two surfaces touch, with normal and gap |
//! | `impulse_fit` | impulses at given points that explain given jumps |
//! | `impacts` | contact rows of a recording, by the modules above |
//! | `contact_checks` | contacts that another program recorded, against surfaces, masses and speeds |

pub mod contact_checks;
pub mod impacts;
mod impulse_fit;
mod jump_windows;
mod kinematics;
pub mod recording;
mod touching;
