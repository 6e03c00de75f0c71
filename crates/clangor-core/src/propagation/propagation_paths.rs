//! All paths of sound from a source to a receiver: direct, by reflections, and into the late reverberation.
//!
//! ```text
//! source ──► direct ─────────────────────────────────────────────► receivers
//!        ├─► images in a room's walls, or in planes and a floor ──► receivers
//!        └─► images of the first order in a room's walls ─────────► late reverberation
//! ```
//!
//! By reciprocity, the source itself makes at the mirrored receiver what its image makes at the receiver. A
//! path is therefore a vector of emission, whose length is that of the path, and a loss. Whether a path
//! exists depends on both ends:
//!
//! - a source below a rigid floor makes no sound;
//! - images in a room exist while source and receiver are in it;
//! - images in planes and in a floor exist where they are visible (`plane_images`).
//!
//! Reflectors do not obstruct the direct path, and no body scatters a reflected wave.

use glam::DVec3;

use super::image_source::{ImageSource, MOST_REFLECTORS};
use super::plane_images::{PlaneImage, Sequence, plane_images};
use super::reflecting_plane::{ReflectingPlane, ReflectingPlanes};
use super::room_images::room_images;
use super::{Air, Floor, PathLoss, Room, WallAbsorption};

/// Distance by which a source may be behind a floor or a wall \[m\]: rounding of sources on it.
const ROUNDING: f64 = 1e-6;
/// Index of the floor among the walls of a room.
const ROOM_FLOOR: usize = 2;

/// Where a path leads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct PathEnds {
    /// Whether receivers hear it.
    receivers: bool,
    /// Input of the late reverberation that it feeds.
    reverberation: Option<usize>,
}

/// One path.
#[derive(Clone, Debug)]
struct PropagationPath {
    image: ImageSource,
    loss: PathLoss,
    ends: PathEnds,
    /// Sequences of planes that make the image; empty without planes.
    sequences: Vec<Sequence>,
}

/// What reflects.
#[derive(Clone, Debug)]
enum Reflectors {
    /// The walls of a room between two corners \[m\].
    Room { lowest: DVec3, highest: DVec3 },
    /// Planes; the floor, if there is one and no plane coincides with it, is the first.
    Planes(Vec<ReflectingPlane>),
}

/// All paths from a source to a receiver, the direct one first.
#[derive(Clone, Debug)]
pub struct PropagationPaths {
    floor: Floor,
    reflectors: Reflectors,
    paths: Vec<PropagationPath>,
    /// Whether reflections are on.
    reflects: bool,
}

impl PropagationPaths {
    /// Paths among reflectors: the walls of a room, up to its order; without a room, planes and a rigid
    /// floor.
    ///
    /// A floor is one more plane that absorbs nothing. A reflecting plane in the same place takes its part,
    /// with its own absorption.
    pub fn new(floor: Floor, room: Option<Room>, planes: &ReflectingPlanes, air: Option<Air>) -> Self {
        let (reflectors, images) = match room {
            Some(room) => {
                let Room { lowest, highest, .. } = room;
                (Reflectors::Room { lowest, highest }, images_in_room(&room, air))
            }
            None => {
                let reflecting = with_floor(planes.as_slice(), floor);
                let images = images_in_planes(&reflecting, planes.order(), air);
                (Reflectors::Planes(reflecting), images)
            }
        };
        let floor = if room.is_some() { Floor::None } else { floor };
        let paths = std::iter::once(direct(PathLoss::through(air))).chain(images).collect();
        PropagationPaths { floor, reflectors, paths, reflects: true }
    }

    /// The direct path alone, with this loss.
    pub fn direct(loss: PathLoss) -> Self {
        let reflectors = Reflectors::Planes(Vec::new());
        PropagationPaths { floor: Floor::None, reflectors, paths: vec![direct(loss)], reflects: true }
    }

    /// Those that receivers hear.
    #[must_use]
    pub fn heard(&self) -> Self {
        let heard = self.paths.iter().filter(|path| path.ends.receivers).cloned();
        let alone = |path| {
            let ends = PathEnds { receivers: true, reverberation: None };
            PropagationPath { ends, ..path }
        };
        PropagationPaths { paths: heard.map(alone).collect(), ..self.clone() }
    }

    /// Those that feed the late reverberation, for one receiver: [`channel`](Self::channel) is the input, and
    /// the loss includes the factor of the distance.
    #[must_use]
    pub fn feeding(&self) -> Self {
        let feeding = self.paths.iter().filter(|path| path.ends.reverberation.is_some()).cloned();
        let alone = |path: PropagationPath| {
            let ends = PathEnds { receivers: false, ..path.ends };
            PropagationPath { ends, loss: path.loss.unspread(), ..path }
        };
        PropagationPaths { paths: feeding.map(alone).collect(), ..self.clone() }
    }

    /// Number of paths.
    pub fn count(&self) -> usize {
        self.paths.len()
    }

    /// Loss of each path.
    pub fn losses(&self) -> impl Iterator<Item = &PathLoss> {
        self.paths.iter().map(|path| &path.loss)
    }

    /// Loss of a path.
    pub fn loss(&self, path: usize) -> &PathLoss {
        &self.paths[path].loss
    }

    /// The image of the source by which it is received on a path.
    pub fn image(&self, path: usize) -> &ImageSource {
        &self.paths[path].image
    }

    /// Vector \[m\] from a source to a receiver, both places [m, world], in the space of the source; its
    /// length is that of the path. `None` where the path does not exist.
    pub fn towards(&self, path: usize, source: DVec3, receiver: DVec3) -> Option<DVec3> {
        self.leads(path, source, receiver).then(|| self.unfolded(path, source, receiver))
    }

    /// The same whether the path exists or not.
    pub fn unfolded(&self, path: usize, source: DVec3, receiver: DVec3) -> DVec3 {
        self.paths[path].image.unfolded(receiver) - source
    }

    /// Whether a path leads from a source to a receiver, both places [m, world].
    pub fn leads(&self, path: usize, source: DVec3, receiver: DVec3) -> bool {
        if self.is_buried(source) {
            return false;
        }
        let PropagationPath { image, sequences, .. } = &self.paths[path];
        if image.order() == 0 {
            return true;
        }
        self.reflects
            && match &self.reflectors {
                Reflectors::Room { lowest, highest } => [source, receiver]
                    .into_iter()
                    .all(|end| end.cmpge(*lowest - ROUNDING).all() && end.cmple(*highest + ROUNDING).all()),
                Reflectors::Planes(planes) => {
                    sequences.iter().any(|sequence| sequence.is_path(planes, source, receiver))
                }
            }
    }

    /// Whether a source [m, world] is below the rigid floor.
    pub fn is_buried(&self, source: DVec3) -> bool {
        matches!(self.floor, Floor::Rigid { height } if source.y < height - ROUNDING)
    }

    /// Whether a path meets the ground that radiates under an impact, given by a point \[m\] on it and its
    /// unit normal. The sound of the ground contains this reflection. A rigid floor, and the floor of a room,
    /// stand for every ground.
    pub fn meets_ground(&self, path: usize, point: DVec3, normal: DVec3) -> bool {
        let met = self.paths[path].image.reflections;
        match &self.reflectors {
            Reflectors::Room { .. } => met[ROOM_FLOOR] > 0,
            Reflectors::Planes(planes) => {
                let ground = ReflectingPlane::through(point, normal, WallAbsorption::even(0.0));
                let floor = plane_of(self.floor);
                planes.iter().zip(met).any(|(plane, met)| {
                    let is_ground = plane.normal.distance(normal) < ROUNDING
                        && (plane.offset - ground.offset).abs() < ROUNDING;
                    met > 0 && (is_ground || floor.is_some_and(|floor| floor.coincides(plane)))
                })
            }
        }
    }

    /// Switches reflections on or off.
    pub fn set_reflections(&mut self, heard: bool) {
        self.reflects = heard;
    }

    /// Whether receivers receive a path themselves; otherwise it only feeds the late reverberation.
    pub fn is_heard(&self, path: usize) -> bool {
        self.paths[path].ends.receivers
    }

    /// Input of the late reverberation that a path feeds: one for each first-order reflection in a wall, in
    /// their order.
    pub fn reverberation_input(&self, path: usize) -> Option<usize> {
        self.paths[path].ends.reverberation
    }

    /// The signal that a path adds to at a receiver: that of the receiver or, for a path that only feeds the
    /// late reverberation, that of its input.
    pub fn channel(&self, path: usize, receiver: usize) -> usize {
        match self.paths[path].ends {
            PathEnds { receivers: false, reverberation: Some(input) } => input,
            _ => receiver,
        }
    }
}

fn direct(loss: PathLoss) -> PropagationPath {
    let ends = PathEnds { receivers: true, reverberation: None };
    PropagationPath { image: ImageSource::SOURCE, loss, ends, sequences: Vec::new() }
}

/// Paths by the walls of a room. The input of the late reverberation is what has been reflected once, whether
/// or not receivers hear it themselves.
fn images_in_room(room: &Room, air: Option<Air>) -> Vec<PropagationPath> {
    let image_order = room.image_order.max(u32::from(room.late));
    let path = |(index, image): (usize, ImageSource)| {
        let ends = PathEnds {
            receivers: image.order() <= room.image_order,
            // Images of the first order come first.
            reverberation: (room.late && image.order() == 1).then_some(index),
        };
        PropagationPath { loss: PathLoss::by(&image, &room.walls, air), image, ends, sequences: Vec::new() }
    };
    room_images(&Room { image_order, ..*room }).into_iter().enumerate().map(path).collect()
}

/// Paths by planes.
fn images_in_planes(planes: &[ReflectingPlane], order: u32, air: Option<Air>) -> Vec<PropagationPath> {
    let walls: Vec<WallAbsorption> = planes.iter().map(|plane| plane.absorption).collect();
    let loss = |image: &ImageSource| PathLoss::by(image, &walls, air);
    let ends = PathEnds { receivers: true, reverberation: None };
    plane_images(planes, order, |a, b| loss(a).is_close(&loss(b)))
        .into_iter()
        .map(|PlaneImage { image, sequences }| PropagationPath { loss: loss(&image), image, ends, sequences })
        .collect()
}

/// The plane of a floor.
fn plane_of(floor: Floor) -> Option<ReflectingPlane> {
    match floor {
        Floor::None => None,
        Floor::Rigid { height } => {
            Some(ReflectingPlane::through(height * DVec3::Y, DVec3::Y, WallAbsorption::even(0.0)))
        }
    }
}

/// Planes and a floor, unless one of the planes coincides with it.
fn with_floor(planes: &[ReflectingPlane], floor: Floor) -> Vec<ReflectingPlane> {
    let apart = |floor: &ReflectingPlane| !planes.iter().any(|plane| plane.coincides(floor));
    let all: Vec<_> = plane_of(floor).filter(apart).into_iter().chain(planes.iter().copied()).collect();
    debug_assert!(all.len() <= MOST_REFLECTORS);
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    fn paths(floor: Floor, planes: &[ReflectingPlane], order: u32) -> PropagationPaths {
        let planes = ReflectingPlanes::try_new(planes, order).unwrap();
        PropagationPaths::new(floor, None, &planes, None)
    }

    fn ground(share: f64) -> ReflectingPlane {
        ReflectingPlane::through(DVec3::ZERO, DVec3::Y, WallAbsorption::even(share))
    }

    #[test]
    fn a_plane_in_the_place_of_the_floor_is_one_path_with_its_own_absorption() {
        let floor = Floor::Rigid { height: 0.0 };
        let both = paths(floor, &[ground(0.36)], 2);
        assert_eq!(both.count(), 2);
        let gain = both.loss(1).gain(both.loss(1).at(1000.0), 1.0);
        assert!((gain - 0.8).abs() < 1e-12);
        let apart = paths(Floor::Rigid { height: -0.1 }, &[ground(0.36)], 1);
        assert_eq!(apart.count(), 3);
    }

    #[test]
    fn nothing_is_heard_from_below_a_floor() {
        let floor = paths(Floor::Rigid { height: 0.5 }, &[], 1);
        let (above, below) = (DVec3::new(0.1, 0.7, 0.0), DVec3::new(0.1, 0.4, 0.0));
        let receiver = DVec3::new(1.0, 1.0, 0.0);
        assert_eq!([0, 1].map(|path| floor.leads(path, above, receiver)), [true, true]);
        assert_eq!([0, 1].map(|path| floor.leads(path, below, receiver)), [false, false]);
        assert_eq!([0, 1].map(|path| floor.leads(path, above, below)), [true, false]);
    }

    #[test]
    fn the_sound_of_a_ground_is_not_reflected_in_it() {
        let wall = ReflectingPlane::through(DVec3::ZERO, DVec3::X, WallAbsorption::even(0.0));
        let all = paths(Floor::None, &[ground(0.0), wall], 2);
        assert_eq!(all.count(), 4);
        let meets = |point: DVec3| [0, 1, 2, 3].map(|path| all.meets_ground(path, point, DVec3::Y));
        assert_eq!(meets(DVec3::new(0.3, 0.0, 2.0)), [false, true, false, true]);
        assert_eq!(meets(DVec3::new(0.3, 0.2, 2.0)), [false; 4]);
    }

    #[test]
    fn paths_into_the_reverberation_have_its_inputs() {
        let walls = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6].map(WallAbsorption::even);
        let room = Room { lowest: DVec3::ZERO, highest: DVec3::ONE, walls, image_order: 0, late: true };
        let all = PropagationPaths::new(Floor::None, Some(room), &ReflectingPlanes::default(), None);
        let (heard, feeding) = (all.heard(), all.feeding());
        assert_eq!((all.count(), heard.count(), feeding.count()), (7, 1, 6));
        let mut inputs: Vec<usize> = (0..6).map(|path| feeding.channel(path, 0)).collect();
        inputs.sort_unstable();
        assert_eq!(inputs, [0, 1, 2, 3, 4, 5]);
        let (inside, outside) = (DVec3::splat(0.5), DVec3::splat(1.5));
        assert!(feeding.leads(3, inside, inside) && !feeding.leads(3, outside, inside));
        assert!(heard.leads(0, outside, inside));
    }
}
