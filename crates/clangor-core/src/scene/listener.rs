//! Listeners: points, or pairs of points, at which pressure is computed; at rest or moving.
//!
//! The frame of a listener has x to the right, y up and −z ahead, as that of a camera.

use glam::{DMat3, DQuat, DVec3};

use super::diagnostic::{Place, Problem, SceneError};
use crate::pose::{Pose, Track};
use crate::propagation::room::Room;
use crate::synthesis::listener::Floor;

/// One `[[listener]]`.
#[derive(Clone, Debug, PartialEq)]
pub struct ListenerDescription {
    /// Name.
    pub name: String,
    /// Position and orientation over time; `position` is the midpoint of a pair.
    pub track: Track,
    /// Distance between the two receivers of a pair \[m\]; `None`: one receiver.
    pub spacing: Option<f64>,
    /// Place of the listener in the text.
    pub place: Place,
}

impl ListenerDescription {
    /// One receiver at a fixed `position` \[m\].
    pub fn mono(name: impl Into<String>, position: DVec3) -> Self {
        let track = Track::fixed(Pose::at(position));
        ListenerDescription { name: name.into(), track, spacing: None, place: Place::default() }
    }

    /// Two receivers `spacing` \[m\] apart along the x axis of a track, left on the negative side.
    pub fn pair(name: impl Into<String>, track: Track, spacing: f64) -> Self {
        ListenerDescription { name: name.into(), track, spacing: Some(spacing), place: Place::default() }
    }

    /// The receivers in the listener's frame \[m\]: one at the origin, or left and right.
    pub fn receivers(&self) -> Vec<DVec3> {
        match self.spacing {
            None => vec![DVec3::ZERO],
            Some(spacing) => vec![DVec3::X * (-0.5 * spacing), DVec3::X * (0.5 * spacing)],
        }
    }
}

/// An error for each listener that is ever below the rigid floor.
pub(super) fn below_floor(listeners: &[ListenerDescription], floor: Floor) -> Vec<SceneError> {
    let Floor::Rigid { height: floor } = floor else { return Vec::new() };
    let mut errors = Vec::new();
    for listener in listeners {
        let height = listener.track.keys().iter().map(|k| k.pose.position.y).fold(f64::INFINITY, f64::min);
        if height < floor {
            let problem = Problem::ListenerBelowFloor { height, floor };
            errors.push(SceneError { place: listener.place.clone(), problem });
        }
    }
    errors
}

/// An error for each listener that ever leaves the room.
pub(super) fn outside(listeners: &[ListenerDescription], room: &Room) -> Vec<SceneError> {
    let leaves = |listener: &&ListenerDescription| {
        listener.track.keys().iter().any(|key| {
            listener.receivers().iter().any(|receiver| !room.holds(key.pose.world_from_body(*receiver)))
        })
    };
    listeners
        .iter()
        .filter(leaves)
        .map(|listener| SceneError { place: listener.place.clone(), problem: Problem::ListenerOutside })
        .collect()
}

/// The rotation that turns −z to `facing` and keeps y as far up as it can; `None` if `facing` is vertical.
pub fn look_along(facing: DVec3) -> Option<DQuat> {
    // Within 1e-6 rad of the vertical, left and right are decided by rounding.
    const MIN_HORIZONTAL: f64 = 1e-6;
    let ahead = facing.try_normalize()?;
    let right = ahead.cross(DVec3::Y);
    if right.length() < MIN_HORIZONTAL {
        return None;
    }
    let right = right.normalize();
    Some(DQuat::from_mat3(&DMat3::from_cols(right, right.cross(ahead), -ahead)).normalize())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn right_is_on_the_right() {
        let facing = DVec3::new(1.0, -0.5, 0.0);
        let turn = look_along(facing).unwrap();
        // Looking along +x with y up, +z is on the right. Residuals seen: 2e-16.
        assert!((turn * DVec3::X - DVec3::Z).length() < 1e-14);
        assert!((turn * DVec3::NEG_Z - facing.normalize()).length() < 1e-14);
        assert!(look_along(DVec3::Y).is_none());
        assert!(look_along(DVec3::ZERO).is_none());
    }
}
