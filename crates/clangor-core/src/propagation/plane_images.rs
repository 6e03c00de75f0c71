//! Images in planes of any orientation, and the paths by which they are visible: J. Borish (1984), "Extension
//! of the image model to arbitrary polyhedra".
//!
//! A sequence of planes mirrors the source in one after the other. Its image is heard where the line from the
//! receiver to it, folded back at the planes, hits them in reverse order, always from the front, and crosses
//! no other reflecting plane on the way. Sequences with the same image are one image: at two perpendicular
//! walls a source has one image of the second order, by either wall first. At most one of these sequences is
//! a path.
//!
//! Planes are infinite. They do not obstruct the direct path.

use glam::DVec3;

use super::image_source::ImageSource;
use super::reflecting_plane::{MOST_ORDERS, ReflectingPlane};

/// Distance by which a point may be behind a plane and still count as on it \[m\]: rounding of bodies at rest
/// on it.
const ROUNDING: f64 = 1e-9;
/// Cosine of the angle between normals below which planes are perpendicular.
const PERPENDICULAR: f64 = 1e-12;

/// Indices of planes in the order in which sound meets them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Sequence {
    planes: [u8; MOST_ORDERS as usize],
    count: usize,
}

/// An image and the sequences of planes that make it.
#[derive(Clone, Debug)]
pub(super) struct PlaneImage {
    pub(super) image: ImageSource,
    pub(super) sequences: Vec<Sequence>,
}

/// All images in planes with up to `order` reflections, in ascending order. `same_loss` says whether two
/// images lose the same; images at the same place that differ in their loss are separate.
pub(super) fn plane_images(
    planes: &[ReflectingPlane],
    order: u32,
    same_loss: impl Fn(&ImageSource, &ImageSource) -> bool,
) -> Vec<PlaneImage> {
    let mut images: Vec<PlaneImage> = Vec::new();
    let mut last = vec![(ImageSource::SOURCE, Sequence::default())];
    for _ in 0..order.min(MOST_ORDERS) {
        let longer = last.iter().flat_map(|(image, sequence)| {
            let following = (0..planes.len()).filter(|plane| sequence.may_continue(planes, *plane));
            following.map(|plane| (planes[plane].mirrored(image, plane), sequence.with(plane)))
        });
        last = longer.collect();
        for (image, sequence) in &last {
            let same =
                |known: &&mut PlaneImage| known.image.coincides(image) && same_loss(&known.image, image);
            match images.iter_mut().find(same) {
                Some(known) => known.sequences.push(*sequence),
                None => images.push(PlaneImage { image: *image, sequences: vec![*sequence] }),
            }
        }
    }
    images
}

impl Sequence {
    fn with(mut self, plane: usize) -> Self {
        self.planes[self.count] = plane as u8;
        self.count += 1;
        self
    }

    /// The planes, in the order in which sound meets them.
    fn planes(&self) -> impl DoubleEndedIterator<Item = usize> + ExactSizeIterator {
        self.planes[..self.count].iter().map(|plane| usize::from(*plane))
    }

    /// Whether sound can meet a plane next. After a reflection it moves away from that plane, and planes
    /// perpendicular to it do not change that.
    fn may_continue(&self, planes: &[ReflectingPlane], plane: usize) -> bool {
        for met in self.planes().rev() {
            if met == plane {
                return false;
            }
            if planes[met].normal.dot(planes[plane].normal).abs() > PERPENDICULAR {
                return true;
            }
        }
        true
    }

    /// Whether sound runs from a source to a receiver [m, world] by reflections in these planes.
    pub(super) fn is_path(&self, planes: &[ReflectingPlane], source: DVec3, receiver: DVec3) -> bool {
        // Images of the source after each reflection.
        let mut images = [source; MOST_ORDERS as usize];
        let mut image = source;
        for (slot, plane) in images.iter_mut().zip(self.planes()) {
            image -= 2.0 * planes[plane].height(image) * planes[plane].normal;
            *slot = image;
        }
        // Back from the receiver, plane by plane, to the source.
        let (mut at, mut left) = (receiver, None);
        for (image, plane) in images[..self.count].iter().zip(self.planes()).rev() {
            let (above, below) = (planes[plane].height(at), planes[plane].height(*image));
            if above < -ROUNDING || below > ROUNDING {
                return false;
            }
            let part = if above > below { (above / (above - below)).clamp(0.0, 1.0) } else { 0.0 };
            let hit = at + part * (*image - at);
            if !is_free(planes, at, hit, [left, Some(plane)]) {
                return false;
            }
            (at, left) = (hit, Some(plane));
        }
        is_free(planes, at, source, [left, None])
    }
}

/// Whether a straight line crosses no plane. Its first and last point may lie on one each, in front of which
/// the line is.
fn is_free(planes: &[ReflectingPlane], from: DVec3, to: DVec3, ends: [Option<usize>; 2]) -> bool {
    planes.iter().enumerate().all(|(index, plane)| {
        let (a, b) = (plane.height(from), plane.height(to));
        if ends.contains(&Some(index)) {
            return a.min(b) >= -ROUNDING;
        }
        !(a.min(b) < -ROUNDING && a.max(b) > ROUNDING)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::propagation::WallAbsorption;

    fn plane(normal: DVec3, offset: f64) -> ReflectingPlane {
        ReflectingPlane { normal: normal.normalize(), offset, absorption: WallAbsorption::even(0.0) }
    }

    fn images(planes: &[ReflectingPlane], order: u32) -> Vec<PlaneImage> {
        plane_images(planes, order, |_, _| true)
    }

    #[test]
    fn a_corner_of_three_walls_has_seven_images_and_all_are_visible() {
        let corner = [plane(DVec3::X, 0.0), plane(DVec3::Y, -0.5), plane(DVec3::Z, 0.2)];
        let (source, receiver) = (DVec3::new(0.4, 0.1, 1.0), DVec3::new(1.3, 2.0, 0.7));
        let images = images(&corner, 4);
        assert_eq!(images.len(), 7);
        for PlaneImage { sequences, .. } in &images {
            let paths = sequences.iter().filter(|sequence| sequence.is_path(&corner, source, receiver));
            assert_eq!(paths.count(), 1);
        }
    }

    #[test]
    fn a_box_of_planes_has_the_images_of_a_room() {
        let sides = [DVec3::X, DVec3::Y, DVec3::Z].into_iter();
        let planes: Vec<_> = sides.flat_map(|axis| [plane(axis, -1.0), plane(-axis, -2.0)]).collect();
        assert_eq!([1, 2, 3, 4].map(|order| images(&planes, order).len()), [6, 24, 62, 128]);
    }

    /// A wedge of angle π/n mirrors a source 2n − 1 times, all visible from everywhere in it.
    #[test]
    fn a_wedge_has_the_images_of_its_group() {
        for n in [2_u32, 3, 4] {
            let angle = std::f64::consts::PI / f64::from(n);
            let wedge = [plane(DVec3::Y, 0.0), plane(DVec3::new(angle.sin(), -angle.cos(), 0.0), 0.0)];
            let images = images(&wedge, 4);
            let at = |part: f64, radius: f64| {
                let turn = part * angle;
                radius * DVec3::new(turn.cos(), turn.sin(), 0.0)
            };
            for (a, b) in [(0.1, 0.9), (0.31, 0.37), (0.8, 0.77), (0.05, 0.07)] {
                let (source, receiver) = (at(a, 0.7), at(b, 1.9) + 0.4 * DVec3::Z);
                let seen = images
                    .iter()
                    .filter(|image| image.sequences.iter().any(|s| s.is_path(&wedge, source, receiver)));
                assert_eq!(seen.count() as u32, 2 * n - 1, "{n} {a} {b}");
            }
        }
    }

    #[test]
    fn a_plane_hides_what_is_behind_it() {
        // The reflection in the ground would lie behind the wall.
        let planes = [plane(DVec3::Y, 0.0), plane(DVec3::new(1.0, -0.5, 0.0), 0.0)];
        let (source, receiver) = (DVec3::new(0.4, 0.1, 0.0), DVec3::new(1.4, 2.5, 0.0));
        let ground = Sequence::default().with(0);
        assert!(ground.is_path(&planes, source, receiver));
        let hidden = DVec3::new(-0.2, 1.0, 0.0);
        assert!(!ground.is_path(&planes, source, hidden));
        assert!(ground.is_path(&planes[..1], source, hidden));
    }
}
