//! Motion that another program recorded, and the impacts in it.
//!
//! | module | what |
//! |---|---|
//! | `recording` | frames of bodies, and what can be wrong with them |
//! | `frame_checks` | finds that, frame by frame |
//! | `kinematics` | velocities between frames, their jumps beyond gravity, and free flight continued past a
//! frame |
//! | `jump_windows` | which jumps belong to one impact, and its instant between two frames |
//! | `soft_contacts` | pushes over many frames, of engines whose contacts give way, as one jump |
//! | `parts_of_one` | the same for a part of a larger thing |
//! | `touch` | a point where two surfaces touch |
//! | `touching` | where two surfaces touch, with normal and gap |
//! | `area_corners` | which points stand for the area where they touch |
//! | `edge_touches` | where sharp edges of two surfaces cross |
//! | `impulse_fit` | impulses at given points that explain given jumps |
//! | `cone_faces` | steps of such fits within the limits that impulses have reached |
//! | `led_bodies` | bodies that a hand or a joint leads |
//! | `impacts` | contact rows of a recording, by the modules above |
//! | `pose_noise` | noise of positions, measured from the frames |
//! | `uneven_times` | poses of other instants than their times say |
//! | `straight_keys` | poses on lines between keys |
//! | `lasting_jumps` | what a body does beyond gravity and impacts: rest, and forces without noise |
//! | `lasting_fit` | impulses of lasting contacts, shared by all points that touch |
//! | `lasting_contacts` | rows of lasting contact, by the modules above |
//! | `parts` | impacts of a long recording, found in parts of time that overlap |
//! | `free_falls` | the acceleration of bodies that fall |
//! | `fall_units` | whether that acceleration is the gravity of the scene |
//! | `file_units` | units of time and length, and which explain an acceleration |
//! | `quaternion_order` | whether quaternions have their scalar first, found by spins in falls |
//! | `flights` | the motion of bodies of which only the impulses are listed |
//! | `open_joints` | bodies that leave the joints that hold them in the scene |
//! | `sunk_bodies` | bodies that lie deeper in planes than any solid could |
//! | `list_clock` | times of a list that are probably no seconds |
//! | `nested_bodies` | bodies that lie deep in each other over several frames |
//! | `repeated_contacts` | contacts that lists have twice |
//! | `contact_steps` | contacts that lists give at each step of an engine |
//! | `contact_checks` | contacts that another program recorded, against surfaces, masses and speeds |

mod area_corners;
mod ball_pairs;
mod cone_faces;
pub mod contact_checks;
pub(crate) mod contact_steps;
mod coordinate_rounding;
mod edge_touches;
pub(crate) mod fall_units;
pub mod file_units;
pub(crate) mod flights;
pub(crate) mod frame_checks;
pub(crate) mod free_falls;
pub mod impacts;
mod impulse_fit;
mod jump_windows;
mod kinematics;
mod lasting_contacts;
mod lasting_fit;
mod lasting_jumps;
mod led_bodies;
pub(crate) mod list_clock;
pub(crate) mod listed_impulses;
mod neighbours;
pub(crate) mod nested_bodies;
pub(crate) mod open_joints;
mod parting_normals;
pub(crate) mod parts;
mod parts_of_one;
mod pose_noise;
pub(crate) mod quaternion_order;
pub mod recording;
pub(crate) mod repeated_contacts;
mod repeated_poses;
pub(crate) mod soft_contacts;
mod steady_pushes;
mod straight_keys;
pub(crate) mod sunk_bodies;
mod touch;
mod touching;
mod uneven_times;
