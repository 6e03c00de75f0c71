//! Jumps of a body that is a part of a larger thing, as a hammer's head on its handle.
//!
//! The thing flies freely, not its parts: their centres circle around its own. With the centre c, mass M and
//! inertia of the whole, the jumps of a part with its centre at x follow from those of the whole,
//!
//! ```text
//! Δω = I⁻¹ ΔL        Δv_part = Δv + Δω × (x − c)        ΔL_part = I_part Δω
//! ```
//!
//! What it is not: one body. Each part takes the impulse that its own mass needs, and rings by itself.

use clangor_core::body::World;
use clangor_core::pose::Pose;
use glam::{DMat3, DVec3};

use super::jump_windows::{JumpWindow, jump_windows};
use super::kinematics::{Inertia, Kinematics, Start};
use super::recording::{Frame, RecordedBody};

/// The impacts of a part, as [`jump_windows`] has them; `recorded` has all parts, and a part that is not
/// there at its first frame is left out. `start` says how the part begins.
pub(super) fn windows_of_part(
    world: &World,
    recorded: &[RecordedBody],
    part: &RecordedBody,
    (v_min, noise): (f64, f64),
    start: Start,
) -> Vec<JumpWindow> {
    let Some(first) = part.frames.first() else { return Vec::new() };
    let whole = Whole::of(world, recorded, part, first);
    let frames: Vec<Frame> = part
        .frames
        .iter()
        .map(|frame| {
            let position = frame.pose.world_from_body(whole.centre);
            Frame { pose: Pose { position, ..frame.pose }, ..*frame }
        })
        .collect();
    let mut kinematics = Kinematics::new(&frames, Inertia::new(whole.mass, whole.inertia, world.gravity));
    kinematics.start = start;
    let own = world.bodies[part.body.index()].inertia;
    let mut windows = jump_windows(part.body, &kinematics, (v_min, noise));
    for window in &mut windows {
        let orientation = frames[window.first].pose.orientation;
        let turning = kinematics.inertia.inverse_at(orientation) * window.angular_momentum;
        // What is left of the jumps is kept for the part, and not for the whole.
        window.is_clean = false;
        let arm = orientation * whole.centre;
        let rotation = DMat3::from_quat(orientation);
        window.velocity -= turning.cross(arm);
        window.angular_momentum = rotation * (own * (rotation.transpose() * turning));
    }
    windows
}

/// All parts together, in the frame of one of them.
struct Whole {
    /// \[kg\].
    mass: f64,
    /// Centre of mass \[m\].
    centre: DVec3,
    /// About the centre [kg m²].
    inertia: DMat3,
}

impl Whole {
    fn of(world: &World, recorded: &[RecordedBody], part: &RecordedBody, at: &Frame) -> Self {
        let inverse = part.frames[0].pose.orientation.inverse();
        let placed = recorded.iter().filter(|other| other.group == part.group).filter_map(|other| {
            let index = other.frames.binary_search_by(|frame| frame.time.total_cmp(&at.time)).ok()?;
            let (pose, body) = (other.frames[index].pose, &world.bodies[other.body.index()]);
            let turn = DMat3::from_quat(inverse * pose.orientation);
            let place = at.pose.body_from_world(pose.position);
            Some((body.mass, place, turn * body.inertia * turn.transpose()))
        });
        let placed: Vec<(f64, DVec3, DMat3)> = placed.collect();
        let mass: f64 = placed.iter().map(|(mass, ..)| mass).sum();
        let centre = placed.iter().map(|(mass, place, _)| *place * *mass).sum::<DVec3>() / mass;
        let about = |(mass, place, own): &(f64, DVec3, DMat3)| {
            let r = *place - centre;
            let outer = DMat3::from_cols(r * r.x, r * r.y, r * r.z);
            *own + (DMat3::from_diagonal(DVec3::splat(r.length_squared())) - outer) * *mass
        };
        let inertia = placed.iter().map(about).fold(DMat3::ZERO, |sum, part| sum + part);
        Whole { mass, centre, inertia }
    }
}
