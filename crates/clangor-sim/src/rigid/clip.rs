//! Clipping of one contact face by the prism over another (Sutherland and Hodgman).

use glam::DVec3;

/// Cuts `incident` (a convex polygon, or a segment of two points) by the prism over the convex polygon
/// `reference` along `outward`, the direction out of the reference part. The result is written to `clipped`.
pub(super) fn clip(
    incident: &[DVec3],
    reference: &[DVec3],
    outward: DVec3,
    clipped: &mut Vec<DVec3>,
    spare: &mut Vec<DVec3>,
) {
    clipped.clear();
    clipped.extend_from_slice(incident);
    for (i, &corner) in reference.iter().enumerate() {
        let side = (reference[(i + 1) % reference.len()] - corner).cross(outward);
        spare.clear();
        let count = clipped.len();
        let is_segment = count == 2;
        for k in 0..if is_segment { 1 } else { count } {
            let (p, q) = (clipped[k], clipped[(k + 1) % count]);
            let (height_p, height_q) = ((p - corner).dot(side), (q - corner).dot(side));
            if height_p <= 0.0 {
                spare.push(p);
            }
            if height_p * height_q < 0.0 {
                spare.push(p + (q - p) * (height_p / (height_p - height_q)));
            }
            if is_segment && height_q <= 0.0 {
                spare.push(q);
            }
        }
        std::mem::swap(clipped, spare);
        if clipped.is_empty() {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(half: f64, z: f64) -> Vec<DVec3> {
        [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(x, y)| DVec3::new(x * half, y * half, z))
            .to_vec()
    }

    #[test]
    fn a_large_face_is_cut_to_the_reference_and_a_small_one_is_kept() {
        let (mut clipped, mut spare) = (Vec::new(), Vec::new());
        clip(&square(2.0, 0.5), &square(1.0, 0.0), DVec3::Z, &mut clipped, &mut spare);
        assert_eq!(clipped.len(), 4);
        assert!(clipped.iter().all(|p| p.x.abs() == 1.0 && p.y.abs() == 1.0 && p.z == 0.5));
        clip(&square(0.5, 0.5), &square(1.0, 0.0), DVec3::Z, &mut clipped, &mut spare);
        assert_eq!(clipped, square(0.5, 0.5));
    }

    #[test]
    fn a_segment_stays_a_segment_and_may_vanish() {
        let (mut clipped, mut spare) = (Vec::new(), Vec::new());
        let across = [DVec3::new(-3.0, 0.5, 0.2), DVec3::new(3.0, 0.5, 0.2)];
        clip(&across, &square(1.0, 0.0), DVec3::Z, &mut clipped, &mut spare);
        assert_eq!(clipped, [DVec3::new(-1.0, 0.5, 0.2), DVec3::new(1.0, 0.5, 0.2)]);
        let outside = across.map(|p| p + DVec3::Y * 3.0);
        clip(&outside, &square(1.0, 0.0), DVec3::Z, &mut clipped, &mut spare);
        assert!(clipped.is_empty());
    }
}
