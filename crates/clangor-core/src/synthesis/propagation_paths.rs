//! The paths by which a live listener hears: directly, and by reflections in a rigid floor or in the walls of
//! a room.
//!
//! What an image source makes at a receiver, the source itself makes at the receiver mirrored the same path:
//! a path is a direction in which a body sends, and what is lost there.
//!
//! Differs from the offline renderer: what is below the floor is heard directly, though not by the floor, and
//! so is what is outside the room.

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
    /// Whether reflections are heard.
    reflects: bool,
}

impl PropagationPaths {
    /// By a rigid floor, or by up to the room's number of reflections in its walls, which include the floor.
    pub fn new(floor: Floor, room: Option<Room>, air: Option<Air>) -> Self {
        let images = match (&room, floor) {
            (Some(room), _) => {
                // Late reverberation hears what has met one wall.
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

    /// How many.
    pub fn count(&self) -> usize {
        self.losses.len()
    }

    /// What each takes from the sound.
    pub fn losses(&self) -> &[PathLoss] {
        &self.losses
    }

    /// From a body to a receiver, both places [m, world], as the body sees it \[m\]; `None` where the path
    /// does not lead: a reflection of what is outside the room or below the floor.
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

    /// Lets reflections be heard, or not.
    pub fn set_reflections(&mut self, heard: bool) {
        self.reflects = heard;
    }

    /// Whether receivers hear a path themselves; if not, it is only there to feed the late reverberation.
    pub fn is_heard(&self, path: usize) -> bool {
        let most = self.room.as_ref().map_or(u32::MAX, |room| room.image_order);
        path.checked_sub(1).is_none_or(|image| self.images[image].order() <= most)
    }

    /// The input of the late reverberation that a path feeds: each single reflection in a wall one.
    pub fn reverberation_input(&self, path: usize) -> Option<usize> {
        let image = &self.images[path.checked_sub(1)?];
        let single = self.room.as_ref().is_some_and(|room| room.late) && image.order() == 1;
        single.then(|| image.reflections.iter().position(|met| *met == 1))?
    }
}
