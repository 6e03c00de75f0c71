//! Lengths of the sides of triangles in a flat plate.
//!
//! At a re-entrant corner the stress is singular: displacements vary as r^α with α < 1, 0.54 at a right angle
//! (Williams, J. Appl. Mech. 19, 1952). The error of a frequency is then of order 2α, about one, in the size
//! of the elements at the corner, whatever their degree. Sizes grow linearly away from the corner,
//!
//! ```text
//! h(x) = min(e, q min(m s, e₀) + g |x − c|),    q = (e/e₀)²
//! ```
//!
//! with the size e far from corners, e₀ that of the coarsest mesh, and s the shorter side at the corner
//! or the distance to other sides. So all errors are at least of order two in e where the mesh is finer at
//! every corner. Triangles fill an outline, so that they are not always as small as asked for, and two meshes
//! that are alike at the corners show no error. Of the error at the corners,
//!
//! ```text
//! q = Σ s h_fine / Σ s h_coarse,    h² = 2 max A
//! ```
//!
//! is left, A the areas of the triangles at a corner. The stress around it is that of the plate over a
//! distance s, so that its error has the weight s² (h/s)^(2α), about s h.

use glam::DVec2;

use crate::geometry_class::flat_plate::FlatPlate;

/// Growth g of the size per distance from a corner.
const GROWTH: f64 = 0.7;
/// Angle \[rad\] above which a re-entrant corner counts; below it α is close to one.
const SHARP: f64 = 0.35;
/// Samples of the size along a side.
const SAMPLES: usize = 192;

/// Sizes at the inner corners.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct CornerSizes {
    /// m, of the coarsest mesh.
    pub(super) of_sides: f64,
    /// e₀ \[m\].
    pub(super) coarsest: f64,
    /// q, 1 for the coarsest mesh.
    pub(super) part: f64,
}

/// Sizes of the elements of a plate.
pub(super) struct PlateSizes {
    /// Far from corners \[m\].
    edge: f64,
    corners: Vec<InnerCorner>,
}

/// A re-entrant corner.
struct InnerCorner {
    place: DVec2,
    /// Size of the elements there \[m\].
    size: f64,
    /// Largest size on the way to the next corner \[m\].
    most: f64,
}

impl PlateSizes {
    /// With sides of `edge` \[m\] far from corners.
    pub(super) fn new(plate: &FlatPlate, edge: f64, at: CornerSizes) -> Self {
        let inner = |k: usize| {
            let side = inner_corner(&plate.outline, k)?;
            let size = at.part * (at.of_sides * side).min(at.coarsest);
            let most = (size + 0.5 * GROWTH * side).min(edge);
            (size < edge).then_some(InnerCorner { place: plate.outline[k], size, most })
        };
        PlateSizes { edge, corners: (0..plate.outline.len()).filter_map(inner).collect() }
    }

    /// Size at a point \[m\].
    pub(super) fn at(&self, point: DVec2) -> f64 {
        let near = self.corners.iter().map(|corner| corner.size + GROWTH * corner.place.distance(point));
        near.fold(self.edge, f64::min)
    }

    /// An outline with sides of these sizes.
    pub(super) fn divided(&self, outline: &[DVec2]) -> Vec<DVec2> {
        let ends = |k: usize| [outline[k], outline[(k + 1) % outline.len()]];
        (0..outline.len()).flat_map(|k| self.cuts(ends(k))).collect()
    }

    /// The points at which a side is cut, its start included.
    fn cuts(&self, [from, to]: [DVec2; 2]) -> Vec<DVec2> {
        // Samples are dense at the ends, where the sizes are smallest.
        let place = |k: usize| 0.5 - 0.5 * (std::f64::consts::PI * k as f64 / SAMPLES as f64).cos();
        let mut sums = vec![0.0];
        for k in 0..SAMPLES {
            let [a, b] = [k, k + 1].map(|k| from.lerp(to, place(k)));
            sums.push(sums[k] + a.distance(b) / self.at(0.5 * (a + b)));
        }
        let total = sums[SAMPLES];
        let count = (total - 1e-6).ceil().max(1.0) as usize;
        (0..count)
            .map(|n| {
                let wanted = total * n as f64 / count as f64;
                let k = sums.partition_point(|s| *s <= wanted).clamp(1, SAMPLES);
                let within = (wanted - sums[k - 1]) / (sums[k] - sums[k - 1]);
                from.lerp(to, place(k - 1) + within * (place(k) - place(k - 1)))
            })
            .collect()
    }

    /// Estimated number of triangles around the corners, beyond those of even sizes.
    pub(super) fn around_corners(&self) -> f64 {
        // Three quarters of a circle of triangles with sides g r: ∫ 1.5π r dr / (√3/4 g² r²).
        let around = 6.0 * std::f64::consts::PI / (3.0_f64.sqrt() * GROWTH * GROWTH);
        self.corners.iter().map(|corner| around * (corner.most / corner.size).ln()).sum()
    }
}

/// Σ s h over the inner corners of an outline that is filled with triangles \[m²\].
pub(super) fn error_at_corners(outline: &[DVec2], triangles: &[[DVec2; 3]]) -> f64 {
    let size_at = |corner: DVec2| {
        let around = triangles.iter().filter(|triangle| triangle.contains(&corner));
        around.map(|[a, b, c]| (*b - *a).perp_dot(*c - *a).abs().sqrt()).fold(0.0, f64::max)
    };
    (0..outline.len()).filter_map(|k| Some(inner_corner(outline, k)? * size_at(outline[k]))).sum()
}

/// The shorter side at a corner of an outline, or the distance to other sides \[m\]; `None` of a corner that
/// is not re-entrant.
fn inner_corner(outline: &[DVec2], corner: usize) -> Option<f64> {
    let count = outline.len();
    let [before, place, after] = [corner + count - 1, corner, corner + 1].map(|k| outline[k % count]);
    let (u, v) = (place - before, after - place);
    let across =
        (corner + 1..corner + count - 1).map(|k| distance(place, [k, k + 1].map(|k| outline[k % count])));
    (u.angle_to(v) < -SHARP).then(|| across.fold(u.length().min(v.length()), f64::min))
}

/// Distance of a point from a straight side \[m\].
fn distance(point: DVec2, [from, to]: [DVec2; 2]) -> f64 {
    let along = to - from;
    let part = ((point - from).dot(along) / along.length_squared()).clamp(0.0, 1.0);
    point.distance(from + part * along)
}

#[cfg(test)]
mod tests {
    use glam::DMat3;

    use super::*;

    /// An L of 100 mm with arms of 20 mm.
    fn angle() -> FlatPlate {
        let outline = [[0.0, 0.0], [0.1, 0.0], [0.1, 0.02], [0.02, 0.02], [0.02, 0.1], [0.0, 0.1]];
        let outline = outline.map(DVec2::from_array).to_vec();
        FlatPlate { outline, thickness: 0.002, frame: DMat3::IDENTITY, height: 0.0 }
    }

    #[test]
    fn sides_shrink_towards_an_inner_corner() {
        let plate = angle();
        let at_corner = |part: f64| {
            let at = CornerSizes { of_sides: 1.0, coarsest: 0.015, part };
            let sizes = PlateSizes::new(&plate, 0.015, at);
            let divided = sizes.divided(&plate.outline);
            let corner =
                divided.iter().position(|p| p.distance(plate.outline[3]) < 1e-9).expect("the corner");
            // No side is longer than the size at its middle.
            for k in 0..divided.len() {
                let [a, b] = [k, k + 1].map(|k| divided[k % divided.len()]);
                let ratio = a.distance(b) / sizes.at(0.5 * (a + b));
                assert!(ratio < 1.1, "{a} {b}: {ratio}");
            }
            divided[corner].distance(divided[corner + 1])
        };
        let ratio = at_corner(0.2) / at_corner(0.05);
        println!("{ratio}");
        // Seen: 4.05; sides are whole in number.
        assert!((ratio / 4.0 - 1.0).abs() < 0.15, "{ratio}");
    }

    /// Two meshes alike at a corner would show no error, however short the sides there are.
    #[test]
    fn a_finer_mesh_is_finer_at_every_inner_corner() {
        let plate = angle();
        let corner = plate.outline[3];
        let coarse = CornerSizes { of_sides: 4.0, coarsest: 0.015, part: 1.0 };
        let [first, second] = [1.0, 1.5_f64].map(|ratio| {
            let at = CornerSizes { part: (ratio * ratio).recip(), ..coarse };
            PlateSizes::new(&plate, 0.015 / ratio, at).at(corner)
        });
        // Residual seen: 2e-16.
        assert!((first / second / 2.25 - 1.0).abs() < 1e-12, "{first} {second}");
    }

    #[test]
    fn an_outline_without_inner_corners_is_divided_evenly() {
        let mut plate = angle();
        plate.outline = [[0.0, 0.0], [0.1, 0.0], [0.1, 0.05], [0.0, 0.05]].map(DVec2::from_array).to_vec();
        let at = CornerSizes { of_sides: 1.0, coarsest: 0.03, part: 0.1 };
        let divided = PlateSizes::new(&plate, 0.03, at).divided(&plate.outline);
        assert_eq!(divided.len(), 12);
        // Residual seen: 1e-17 m.
        assert!(divided[1].distance(DVec2::new(0.025, 0.0)) < 1e-12, "{}", divided[1]);
    }
}
