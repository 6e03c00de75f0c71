//! Whether a body encloses air that resonates: by the part of its convex hull that it leaves empty, and of a
//! body of revolution by its mouth.

use clangor_core::geometry::hull::extreme_hull;
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::geometry::meridian::Meridian;
use clangor_core::geometry::tri_mesh::TriMesh;
use glam::DVec2;

/// A body that fills less than this fraction of its hull has cavities, or is a bent plate.
const CONVEX: f64 = 0.7;
/// Directions that sample the hull: its volume to one or two per cent.
const HULL_DIRECTIONS: usize = 300;

/// Whether a body leaves a large part of its convex hull empty.
pub(crate) fn has_cavities(mesh: &TriMesh, mass: &MassProperties) -> bool {
    let hull = extreme_hull(mesh, HULL_DIRECTIONS).and_then(|hull| MassProperties::of(&hull));
    hull.is_ok_and(|hull| mass.volume < CONVEX * hull.volume)
}

/// Area of a narrow mouth in that of the widest place behind it. The moneybox, (19/102)², is below; the bowl
/// and the wine glass are above.
const NARROW: f64 = 0.3;
/// Points of a piece of a section, and levels at which the air about the axis is measured.
const POINTS: usize = 16;
const LEVELS: usize = 64;

/// Whether the air about the axis is wide inside and narrow on the way out, up or down: its resonances lose
/// little through such a mouth, and are narrow.
pub(crate) fn has_narrow_mouth(meridian: &Meridian) -> bool {
    let points = |i: usize| i as f64 / POINTS as f64;
    let path: Vec<DVec2> = meridian
        .pieces()
        .iter()
        .flat_map(|piece| (0..=POINTS).map(move |i| piece.point(points(i))))
        .collect();
    let [Some(first), Some(last)] = [path.first(), path.last()] else { return false };
    !meridian.is_loop()
        && [1.0, -1.0].into_iter().any(|up| {
            // The axis is inside the body between the ends of the section; beyond, there is air.
            let inner = (up * first.y).max(up * last.y);
            let outer = path.iter().map(|p| up * p.y).fold(inner, f64::max);
            let radius = |level: f64| {
                let crossing = |pair: &[DVec2]| {
                    let [a, b] = [up * pair[0].y - level, up * pair[1].y - level];
                    (a * b <= 0.0 && a != b).then(|| pair[0].lerp(pair[1], a / (a - b)).x)
                };
                path.windows(2).filter_map(crossing).fold(f64::INFINITY, f64::min)
            };
            let level = |i: usize| inner + (outer - inner) * (i as f64 + 0.5) / LEVELS as f64;
            let radii: Vec<f64> = (0..LEVELS).map(|i| radius(level(i))).filter(|r| r.is_finite()).collect();
            let Some(at) = (0..radii.len()).max_by(|a, b| radii[*a].total_cmp(&radii[*b])) else {
                return false;
            };
            let mouth = radii[at..].iter().copied().fold(f64::INFINITY, f64::min);
            outer > inner && mouth * mouth < NARROW * radii[at] * radii[at]
        })
}

#[cfg(test)]
mod tests {
    use clangor_core::shape::Shape;

    use super::*;
    use crate::geometry_class::bake_geometry::BakeGeometry;

    #[test]
    fn a_moneybox_has_a_narrow_mouth() {
        for (shape, narrow) in [("moneybox", true), ("bowl", false), ("wineglass", false), ("plate", false)] {
            let mesh = Shape::parse(shape).expect("a shape").mesh();
            let mass = MassProperties::of(&mesh).expect("a solid");
            let geometry = BakeGeometry::of_mesh(&mesh.relative_to(mass.centre_of_mass));
            let form = geometry.axisymmetry().expect("a body of revolution");
            assert_eq!(has_narrow_mouth(&form.meridian), narrow, "{shape}");
        }
    }
}
