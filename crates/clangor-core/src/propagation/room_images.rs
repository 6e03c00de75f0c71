//! Reflections of sound in the walls of a box, as sources outside it: J. B. Allen and D. A. Berkley (1979),
//! "Image method for efficiently simulating small-room acoustics".
//!
//! ```text
//! x' = 2 n L + x,  or  2 n L − x        along each axis, from the lowest wall on, n = …, −1, 0, 1, …
//! ```
//!
//! The image has met the lowest wall |n| times and the highest |n| times; the mirrored one |n − 1| and |n|
//! times. Exact for rigid walls; approximate for walls whose reflectance depends on the angle. In a box every
//! image is visible from everywhere.

use glam::{DMat3, DVec3};

use super::image_source::{ImageSource, MOST_REFLECTORS};
use super::room::Room;

/// Every image with one reflection up to the order of the room, in ascending order.
pub fn room_images(room: &Room) -> Vec<ImageSource> {
    let order = room.image_order;
    let reach = order as i32;
    let axis = |k: usize| {
        let (low, length) = (room.lowest[k], room.extent()[k]);
        (-reach..=reach).flat_map(move |n| {
            [false, true].map(move |mirrored| {
                // About the lowest wall x − low goes to 2nL ± (x − low).
                let sign = if mirrored { -1.0 } else { 1.0 };
                let origin = low + 2.0 * f64::from(n) * length - sign * low;
                let lowest = (n - i32::from(mirrored)).unsigned_abs();
                (sign, origin, [lowest, n.unsigned_abs()])
            })
        })
    };
    let mut images = Vec::new();
    for (sign_x, x, across_x) in axis(0) {
        for (sign_y, y, across_y) in axis(1) {
            for (sign_z, z, across_z) in axis(2) {
                let across = [across_x, across_y, across_z];
                let mut reflections = [0; MOST_REFLECTORS];
                for (wall, count) in across.into_iter().flatten().enumerate() {
                    reflections[wall] = count;
                }
                let turn = DMat3::from_diagonal(DVec3::new(sign_x, sign_y, sign_z));
                let image = ImageSource { turn, origin: DVec3::new(x, y, z), reflections };
                if (1..=order).contains(&image.order()) {
                    images.push(image);
                }
            }
        }
    }
    images.sort_by_key(ImageSource::order);
    images
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::propagation::{PathLoss, WallAbsorption};

    fn room(image_order: u32) -> Room {
        Room {
            lowest: DVec3::new(-1.0, 0.5, 2.0),
            highest: DVec3::new(2.0, 3.0, 6.0),
            walls: [0.1, 0.2, 0.3, 0.4, 0.5, 0.6].map(WallAbsorption::even),
            image_order,
            late: false,
        }
    }

    #[test]
    fn images_are_as_many_as_the_octahedron_has_points() {
        // 6, 18, 38, 66 with exactly 1, 2, 3, 4 reflections.
        assert_eq!([0, 1, 2, 3, 4].map(|order| room_images(&room(order)).len()), [0, 6, 24, 62, 128]);
    }

    #[test]
    fn one_reflection_mirrors_in_its_wall() {
        let room = room(1);
        let point = DVec3::new(0.3, 1.0, 4.5);
        for image in room_images(&room) {
            let wall = image.reflections.iter().position(|n| *n == 1).unwrap();
            let plane = if wall.is_multiple_of(2) { room.lowest[wall / 2] } else { room.highest[wall / 2] };
            let mut wanted = point;
            wanted[wall / 2] = 2.0 * plane - wanted[wall / 2];
            assert!(image.image(point).distance(wanted) < 1e-12, "{wall} {} {wanted}", image.image(point));
            assert!(image.unfolded(image.image(point)).distance(point) < 1e-12);
            let share = 0.1 * (wall + 1) as f64;
            let loss = PathLoss::by(&image, &room.walls, None);
            assert!((loss.gain(loss.at(1000.0), 3.0) - (1.0 - share).sqrt()).abs() < 1e-12);
        }
    }

    #[test]
    fn images_are_what_repeated_mirrors_make() {
        // Every sequence of up to three mirrors that changes the place is an image, with those walls.
        let room = room(3);
        let point = DVec3::new(0.3, 1.0, 4.5);
        let images = room_images(&room);
        let mirror = |p: DVec3, wall: usize| {
            let mut q = p;
            q[wall / 2] =
                2.0 * if wall.is_multiple_of(2) { room.lowest } else { room.highest }[wall / 2] - p[wall / 2];
            q
        };
        let mut found = vec![false; images.len()];
        let mut sequences: Vec<(DVec3, Vec<usize>)> = vec![(point, Vec::new())];
        for _ in 0..3 {
            sequences = sequences
                .into_iter()
                .flat_map(|(p, walls)| (0..6).map(move |w| (p, [&walls[..], &[w]].concat())))
                // The same wall twice in a row leads back.
                .filter(|(_, walls)| walls.len() < 2 || walls[walls.len() - 1] != walls[walls.len() - 2])
                .map(|(p, walls)| (mirror(p, walls[walls.len() - 1]), walls))
                .collect();
            for (place, walls) in &sequences {
                let same = |image: &ImageSource| image.image(point).distance(*place) < 1e-9;
                // A path back through another wall between is not a separate image: x, y, x is y.
                if let Some(at) = images.iter().position(same) {
                    found[at] |= images[at].order() as usize == walls.len();
                }
            }
        }
        assert!(found.iter().all(|f| *f));
    }
}
