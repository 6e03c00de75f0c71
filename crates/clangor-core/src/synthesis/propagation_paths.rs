//! Propagation paths of a live receiver: the direct path, and reflections in a rigid floor or in the walls of
//! a room.
//!
//! By reciprocity, the source itself makes at the mirrored receiver what its image makes at the receiver. A
//! path is therefore a direction of emission, and a loss.
//!
//! Differs from the offline renderer: sources below the floor are received directly, though not by the floor,
//! and so are sources outside the room.

use glam::DVec3;

use super::listener::Floor;
use crate::propagation::{Air, ImageSource, PathLoss, Room, image_sources};

/// All paths, the direct one first.
#[derive(Clone, Debug)]
pub struct PropagationPaths {
    floor: Floor,
    room: Option<Room>,
    images: Vec<ImageSource>,
    losses: Vec<PathLoss>,
    /// Whether reflections are on.
    reflects: bool,
}

impl PropagationPaths {
    /// Reflections in a rigid floor, or up to the order of the room in its walls, which include the floor.
    pub fn new(floor: Floor, room: Option<Room>, air: Option<Air>) -> Self {
        let images = match (&room, floor) {
            (Some(room), _) => {
                // The input of the late reverberation is what has been reflected once.
                let image_order = room.image_order.max(u32::from(room.late));
                image_sources(&Room { image_order, ..*room })
            }
            (None, Floor::None) => Vec::new(),
            (None, Floor::Rigid { height }) => vec![ImageSource {
                mirrored: [false, true, false],
                origin: 2.0 * height * DVec3::Y,
                reflections: [0, 0, 1, 0, 0, 0],
            }],
        };
        let lost = |image: &ImageSource| match &room {
            Some(room) => PathLoss::by(image, room, air),
            None => PathLoss::through(air),
        };
        let losses = std::iter::once(PathLoss::through(air)).chain(images.iter().map(lost)).collect();
        PropagationPaths { floor, room, images, losses, reflects: true }
    }

    /// Number of paths.
    pub fn count(&self) -> usize {
        self.losses.len()
    }

    /// Loss of each path.
    pub fn losses(&self) -> &[PathLoss] {
        &self.losses
    }

    /// Vector from a body to a receiver, both places [m, world], in the space of the body \[m\]; `None`
    /// without this path: a reflection of a source outside the room or below the floor.
    pub fn towards(&self, path: usize, body: DVec3, receiver: DVec3) -> Option<DVec3> {
        let Some(image) = path.checked_sub(1).map(|image| &self.images[image]) else {
            return Some(receiver - body);
        };
        let among = |point: DVec3| match (&self.room, self.floor) {
            (Some(room), _) => room.holds(point),
            (None, Floor::Rigid { height }) => point.y >= height,
            (None, Floor::None) => true,
        };
        (self.reflects && among(body) && among(receiver)).then(|| image.unfolded(receiver) - body)
    }

    /// Switches reflections on or off.
    pub fn set_reflections(&mut self, heard: bool) {
        self.reflects = heard;
    }

    /// Whether receivers receive a path themselves; otherwise it only feeds the late reverberation.
    pub fn is_heard(&self, path: usize) -> bool {
        let most = self.room.as_ref().map_or(u32::MAX, |room| room.image_order);
        path.checked_sub(1).is_none_or(|image| self.images[image].order() <= most)
    }

    /// Input of the late reverberation that a path feeds: one for each first-order reflection in a wall.
    pub fn reverberation_input(&self, path: usize) -> Option<usize> {
        let image = &self.images[path.checked_sub(1)?];
        let single = self.room.as_ref().is_some_and(|room| room.late) && image.order() == 1;
        single.then(|| image.reflections.iter().position(|met| *met == 1))?
    }
}
