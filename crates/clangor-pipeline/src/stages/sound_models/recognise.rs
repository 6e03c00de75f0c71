//! Which exact form a mesh samples: an ellipsoid, a box, a box with rounded edges, a torus or another body of
//! revolution of the shape library.
//!
//! The solvers are cheaper and sharper on exact forms. The form is read off the mesh and not off the scene,
//! so that a shape, a mesh file and a timeline's copy of either have the same model. It counts when all
//! vertices lie on it and the triangles nowhere leave it by more than a small part of the size: a cube's
//! corners lie on a sphere too.
//!
//! A mesh of none of these forms may still be turned about y, but for the roughness of its triangles. It then
//! sounds as the body of its section (`clangor_bake::geometry_class::detect_axisymmetry`).

use std::f64::consts::TAU;

use clangor_bake::geometry_class::bake_geometry::BakeGeometry;
use clangor_bake::geometry_class::detect_axisymmetry::fitted_meridian;
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::geometry::meridian::Piece;
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::glam::{DMat3, DVec2, DVec3};
use clangor_core::shape::{Form, Shape};

/// Largest distance of a vertex from the form, over the bounding radius: files keep 7 digits.
const ON_FORM: f64 = 2e-6;
/// Largest distance of the middle of a triangle from a curved form, over the bounding radius: a mesh as
/// coarse as that stands for the form, and not for its facets.
const CHORD: f64 = 1e-2;
/// Longest semi-axis of an ellipsoid over the distance of its farthest vertex: a mesh need not have one at
/// its ends.
const MOST_BEYOND: f64 = 1.2;

/// The form that a mesh about its centre of mass stands for.
pub(super) fn form(mesh: &TriMesh) -> Option<BakeGeometry> {
    let turned = || {
        let fit = fitted_meridian(mesh)?;
        let near = fit.deviation <= CHORD * mesh.bounding_radius(DVec3::ZERO);
        near.then_some(BakeGeometry::Axisymmetric(fit.meridian))
    };
    exact_form(mesh).or_else(turned)
}

/// The form that the vertices of a mesh about its centre of mass lie on.
pub(super) fn exact_form(mesh: &TriMesh) -> Option<BakeGeometry> {
    let (low, high) = mesh.bounds();
    let radius = mesh.bounding_radius(DVec3::ZERO);
    symmetric_form(mesh, low, high, radius)
        .or_else(|| torus(mesh, radius))
        .or_else(|| revolution(mesh, low, high, radius))
}

fn symmetric_form(mesh: &TriMesh, low: DVec3, high: DVec3, radius: f64) -> Option<BakeGeometry> {
    // All forms here are symmetric about their centre of mass.
    if (low + high).abs().max_element() > ON_FORM * radius || (high - low).min_element() <= 0.0 {
        return None;
    }
    ellipsoid(mesh, radius).or_else(|| rounded_box(mesh, (0.5 * (high - low)).map(twelve_digits), radius))
}

/// The ellipsoid x²/A² + y²/B² + z²/C² = 1 of least squares: a mesh need not have a vertex at the end of an
/// axis.
fn ellipsoid(mesh: &TriMesh, radius: f64) -> Option<BakeGeometry> {
    let (mut normal, mut right) = (DMat3::ZERO, DVec3::ZERO);
    for v in &mesh.vertices {
        let square = *v * *v / (radius * radius);
        normal += DMat3::from_cols(square * square.x, square * square.y, square * square.z);
        right += square;
    }
    let inverse_squares = normal.inverse() * right;
    if !(inverse_squares.is_finite() && inverse_squares.min_element() > 0.0) {
        return None;
    }
    let semi_axes = inverse_squares.map(|q| twelve_digits(radius / q.sqrt()));
    // The vertices of a flat box lie on an ellipsoid without end.
    if semi_axes.max_element() > MOST_BEYOND * radius {
        return None;
    }
    // The scaled distance to the centre, over the length of its gradient: the distance from the surface to
    // first order.
    let distance = |x: DVec3| {
        let scaled = x / semi_axes;
        (scaled.length() - 1.0) * scaled.length() / (scaled / semi_axes).length()
    };
    follows(mesh, radius, &distance).then_some(BakeGeometry::Ellipsoid { semi_axes })
}

fn rounded_box(mesh: &TriMesh, half: DVec3, radius: f64) -> Option<BakeGeometry> {
    // A face ends where its edges begin to bend.
    let on_face = |v: &&DVec3| v.x >= half.x - ON_FORM * radius;
    let flat = mesh.vertices.iter().filter(on_face).map(|v| v.y).fold(0.0, f64::max);
    let round = match half.y - flat {
        round if round <= ON_FORM * radius => 0.0,
        round => twelve_digits(round),
    };
    let core = half - round;
    if core.min_element() < 0.0 {
        return None;
    }
    let distance = |x: DVec3| {
        let outside = x.abs() - core;
        outside.max(DVec3::ZERO).length() + outside.max_element().min(0.0) - round
    };
    follows(mesh, radius, &distance).then_some(BakeGeometry::RoundedBox { edges: 2.0 * half, round })
}

/// The body of revolution about y on whose section all vertices lie, as one that the shape library can make
/// of the mesh's extents.
fn revolution(mesh: &TriMesh, low: DVec3, high: DVec3, radius: f64) -> Option<BakeGeometry> {
    let (across, height) = (twelve_digits(high.x), twelve_digits(high.y - low.y));
    let forms =
        [Form::Cylinder { radius: across, height }, Form::Bowl, Form::Plate, Form::Wineglass, Form::Moneybox];
    let volume = MassProperties::of(mesh).ok()?.volume;
    forms.into_iter().find_map(|form| {
        let meridian = Shape::try_new(form, None).ok()?.meridian()?;
        if (meridian.volume() - volume).abs() > MOST_LOST_VOLUME * volume {
            return None;
        }
        // These forms stand on flat feet, so that their lowest points are vertices of the mesh and ends of
        // pieces.
        let foot =
            meridian.pieces().iter().flat_map(|p| [p.point(0.0).y, p.point(1.0).y]).fold(0.0, f64::min);
        let on_section = |v: &DVec3| {
            let point = DVec2::new(v.x.hypot(v.z), v.y - low.y + foot);
            meridian.pieces().iter().any(|piece| distance_to(piece, point) <= ON_FORM * radius)
        };
        mesh.vertices
            .iter()
            .all(on_section)
            .then(|| BakeGeometry::Axisymmetric(meridian.about_centre_of_mass()))
    })
}

/// The torus about y through the vertices nearest to the axis and farthest from it: a mesh has vertices on
/// both equators.
fn torus(mesh: &TriMesh, radius: f64) -> Option<BakeGeometry> {
    let from_axis = || mesh.vertices.iter().map(|v| v.x.hypot(v.z));
    let (inner, outer) = (from_axis().fold(f64::INFINITY, f64::min), from_axis().fold(0.0, f64::max));
    let (major, minor) = (twelve_digits(0.5 * (outer + inner)), twelve_digits(0.5 * (outer - inner)));
    let distance = |x: DVec3| (x.x.hypot(x.z) - major).hypot(x.y) - minor;
    // A ball or a coin has vertices on the axis, a tube has none on a circle.
    if inner < ON_FORM * radius || !follows(mesh, radius, &distance) {
        return None;
    }
    Shape::try_new(Form::Torus { major, minor }, None).ok()?.meridian().map(BakeGeometry::Axisymmetric)
}

/// Part of its volume that a mesh may lose to its facets.
const MOST_LOST_VOLUME: f64 = 0.05;

/// Distance of a point from a piece of a section, exact on the piece.
fn distance_to(piece: &Piece, point: DVec2) -> f64 {
    let nearest = match *piece {
        Piece::Line { from, to } => {
            ((point - from).dot(to - from) / (to - from).length_squared()).clamp(0.0, 1.0)
        }
        Piece::Arc { centre, semi_axes, from, to } => {
            let scaled = (point - centre) / semi_axes;
            // The angle in the turn that is nearest to the middle of the arc.
            let middle = 0.5 * (from + to);
            let angle = scaled.y.atan2(scaled.x);
            let angle = angle + TAU * ((middle - angle) / TAU).round();
            ((angle - from) / (to - from)).clamp(0.0, 1.0)
        }
    };
    piece.point(nearest).distance(point)
}

/// Whether a mesh samples the surface with this signed distance.
fn follows(mesh: &TriMesh, radius: f64, distance: &dyn Fn(DVec3) -> f64) -> bool {
    mesh.vertices.iter().all(|v| distance(*v).abs() <= ON_FORM * radius)
        && (0..mesh.triangles.len()).all(|t| distance(mesh.centroid(t)).abs() <= CHORD * radius)
}

/// The number without the last digits, in which the same length read off different vertices differs.
fn twelve_digits(number: f64) -> f64 {
    let unit = 10f64.powi(number.abs().log10().floor() as i32 - 11);
    // Divided by the inverse, which is a whole number for all that bodies measure, so that 0.0123 is 0.0123.
    (number / unit).round() / unit.recip().round()
}

#[cfg(test)]
mod tests {
    use clangor_core::body::Surface;

    use super::*;

    fn form_of(shape: &str) -> Option<BakeGeometry> {
        let (surface, _) = Shape::parse(shape).unwrap().surface().unwrap();
        match surface {
            Surface::Mesh(surface) => form(&surface.mesh),
            _ => None,
        }
    }

    #[test]
    fn exact_forms_are_read_off_their_meshes() {
        let ellipsoid = |x, y, z| Some(BakeGeometry::Ellipsoid { semi_axes: DVec3::new(x, y, z) });
        assert_eq!(form_of("ellipsoid:0.03x0.02x0.011"), ellipsoid(0.03, 0.02, 0.011));
        assert_eq!(form_of("ellipsoid:0.1x0.004x0.02"), ellipsoid(0.1, 0.004, 0.02));
        let cuboid = |x, y, z, round| Some(BakeGeometry::RoundedBox { edges: DVec3::new(x, y, z), round });
        assert_eq!(form_of("box:0.1x0.2x0.05"), cuboid(0.1, 0.2, 0.05, 0.0));
        assert_eq!(form_of("box:0.1x0.2x0.05@0.2"), cuboid(0.1, 0.2, 0.05, 0.0));
        assert_eq!(form_of("box:0.38x0.008x0.38"), cuboid(0.38, 0.008, 0.38, 0.0));
        assert_eq!(form_of("die:0.016x0.002"), cuboid(0.016, 0.016, 0.016, 0.002));
        assert_eq!(form_of("die:0.02x0"), cuboid(0.02, 0.02, 0.02, 0.0));
    }

    #[test]
    fn bodies_of_revolution_find_their_section() {
        for shape in [
            "coin",
            "cylinder:0.01x0.05",
            "bowl",
            "plate",
            "wineglass",
            "moneybox",
            "torus:0.02x0.006",
            "torus:0.05x0.002",
        ] {
            let exact = Shape::parse(shape).unwrap().meridian().unwrap().about_centre_of_mass();
            let Some(BakeGeometry::Axisymmetric(found)) = form_of(shape) else { panic!("{shape}") };
            assert!((found.volume() / exact.volume() - 1.0).abs() < 1e-9, "{shape}");
        }
    }

    /// Of no size of the library, and of single precision: a mesh from elsewhere.
    #[test]
    fn foreign_bowls_find_their_section_too() {
        let (surface, mass) = Shape::parse("bowl").unwrap().surface().unwrap();
        let Surface::Mesh(surface) = surface else { panic!("a mesh") };
        let mut mesh = surface.mesh;
        mesh.vertices.iter_mut().for_each(|v| *v = (1.07 * *v).as_vec3().as_dvec3());
        assert_eq!(exact_form(&mesh), None);
        let Some(BakeGeometry::Axisymmetric(found)) = form(&mesh) else { panic!("a body of revolution") };
        let lost = found.volume() / (1.07_f64.powi(3) * mass.volume) - 1.0;
        // Residual seen: 9e-4, of the facets.
        assert!(lost.abs() < 1e-2, "{lost:.1e}");
        // Its middle stays where the mesh has it.
        assert!(found.centre_of_mass().abs() < 1e-3 * found.bounding_radius());
        // An oval bowl is none.
        mesh.vertices.iter_mut().for_each(|v| v.x *= 0.8);
        assert_eq!(form(&mesh), None);
    }

    #[test]
    fn other_bodies_stay_meshes() {
        for shape in ["mug", "key", "rock:3x0.01", "prism:8x0.02x0.01", "ellipsoid:0.02x0.02x0.02@0.03"] {
            assert_eq!(form_of(shape), None, "{shape}");
        }
    }

    #[test]
    fn single_precision_and_a_bump_make_a_difference() {
        let (surface, _) = Shape::parse("die:0.016x0.002").unwrap().surface().unwrap();
        let Surface::Mesh(surface) = surface else { panic!("a mesh") };
        let mut mesh = surface.mesh;
        mesh.vertices.iter_mut().for_each(|v| *v = v.as_vec3().as_dvec3());
        assert!(exact_form(&mesh).is_some());
        mesh.vertices[10] *= 1.001;
        assert_eq!(exact_form(&mesh), None);
    }
}
