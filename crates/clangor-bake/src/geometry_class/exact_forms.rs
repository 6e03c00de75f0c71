//! The exact forms that the vertices of a mesh about its centre of mass suggest: an ellipsoid, a box, a box
//! with rounded edges, a torus or another body of revolution of the shape library. Whether the mesh is one is
//! decided by [`agreement`](super::agreement).

use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::geometry::meridian::Meridian;
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::shape::{Form, Shape};
use glam::{DMat3, DVec3};

use super::agreement::{ON_FORM, TORUS_MEASURES, samples_exactly};
use super::bake_geometry::BakeGeometry;

/// Longest semi-axis of an ellipsoid over the distance of its farthest vertex: a mesh need not have one at
/// its ends.
const MOST_BEYOND: f64 = 1.2;

/// The ellipsoid or box that a mesh samples.
pub(super) fn symmetric_form(mesh: &TriMesh) -> Option<BakeGeometry> {
    let (low, high) = mesh.bounds();
    let radius = mesh.bounding_radius(DVec3::ZERO);
    // These forms are symmetric about their centre of mass.
    if (low + high).abs().max_element() > ON_FORM * radius || (high - low).min_element() <= 0.0 {
        return None;
    }
    let half = (0.5 * (high - low)).map(twelve_digits);
    [ellipsoid(mesh, radius), rounded_box(mesh, half, radius)]
        .into_iter()
        .flatten()
        .find(|form| samples_exactly(mesh, form))
}

/// The body of revolution about y that a mesh samples, as one that the shape library can make of its extents.
pub(super) fn revolution_form(mesh: &TriMesh) -> Option<BakeGeometry> {
    let (low, high) = mesh.bounds();
    let from_axis = || mesh.vertices.iter().map(|v| v.x.hypot(v.z));
    let (inner, outer) = (from_axis().fold(f64::INFINITY, f64::min), from_axis().fold(0.0, f64::max));
    let (major, minor) = (twelve_digits(0.5 * (outer + inner)), twelve_digits(0.5 * (outer - inner)));
    let (radius, height) = (twelve_digits(outer), twelve_digits(high.y - low.y));
    let volume = MassProperties::of(mesh).ok()?.volume;
    let forms = [
        Form::Torus { major, minor },
        Form::Cylinder { radius, height },
        Form::Bowl,
        Form::Plate,
        Form::Wineglass,
        Form::Moneybox,
    ];
    forms.into_iter().find_map(|form| {
        let meridian = Shape::try_new(form, None).ok()?.meridian()?;
        if (meridian.volume() - volume).abs() > TORUS_MEASURES * volume {
            return None;
        }
        let is_torus = matches!(form, Form::Torus { .. });
        let placed = if is_torus { meridian.clone() } else { standing(&meridian, low.y) };
        let centred = if is_torus { meridian } else { meridian.about_centre_of_mass() };
        let same = samples_exactly(mesh, &BakeGeometry::axisymmetric(placed));
        same.then(|| BakeGeometry::axisymmetric(centred))
    })
}

/// A section whose lowest point is at `low`. These forms stand on flat feet, so that their lowest points are
/// vertices of the mesh and ends of pieces.
fn standing(meridian: &Meridian, low: f64) -> Meridian {
    let ends = meridian.pieces().iter().flat_map(|p| [p.point(0.0).y, p.point(1.0).y]);
    meridian.raised(low - ends.fold(f64::INFINITY, f64::min))
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
    (semi_axes.max_element() <= MOST_BEYOND * radius).then_some(BakeGeometry::Ellipsoid { semi_axes })
}

/// The box of these half edges, rounded as its faces suggest.
fn rounded_box(mesh: &TriMesh, half: DVec3, radius: f64) -> Option<BakeGeometry> {
    // A face ends where its edges begin to bend.
    let on_face = |v: &&DVec3| v.x >= half.x - ON_FORM * radius;
    let flat = mesh.vertices.iter().filter(on_face).map(|v| v.y).fold(0.0, f64::max);
    let round = match half.y - flat {
        round if round <= ON_FORM * radius => 0.0,
        round => twelve_digits(round),
    };
    ((half - round).min_element() >= 0.0).then_some(BakeGeometry::RoundedBox { edges: 2.0 * half, round })
}

/// The number without the last digits, in which the same length read off different vertices differs.
fn twelve_digits(number: f64) -> f64 {
    let unit = 10f64.powi(number.abs().log10().floor() as i32 - 11);
    // Divided by the inverse, which is a whole number for all that bodies measure, so that 0.0123 is 0.0123.
    (number / unit).round() / unit.recip().round()
}
