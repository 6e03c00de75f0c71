//! The sides of a contact at the scale of its own largest approach.
//!
//! Edges, corners and flat faces have no one curvature: how wide they are touched depends on the approach
//! (`touched_form`), and the approach on the stiffness, so on the width:
//!
//! ```text
//! d = d_m(k(d))      d_m = (5 m V²/(4 k))^{2/5}
//! ```
//!
//! k changes with d by at most its square root, so each step of the iteration leaves at most a fifth of the
//! error. Smooth surfaces take one step.
//!
//! The relative curvature is at least 2 d/L², with L the size of the smaller body or, where several points
//! touch, half the distance to the nearest other point: together they are not wider than what they lie on.

use glam::{DMat3, DVec3};

use super::contact_scale::ContactScale;
use super::contact_side::{ContactSide, inverse_effective_mass};
use super::hertz::HertzContact;
use super::relative_curvature::RelativeCurvature;
use super::touched_form::TouchedForm;
use crate::body::Surface;

/// Where two bodies touch, and how fast they meet.
#[derive(Clone, Copy, Debug)]
pub struct Touch<'a> {
    /// Surfaces of A and B; `None` for rigid, flat surroundings.
    pub surfaces: [Option<&'a Surface>; 2],
    /// Unit normal \[world\].
    pub normal: DVec3,
    /// Place \[m, world\].
    pub place: DVec3,
    /// Approach speed [m/s].
    pub speed: f64,
    /// How the points of the contact share it.
    pub spread: Spread,
}

/// How the points of a contact share its width and the masses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Largest half width \[m\] of the contact at each point.
    pub reach: f64,
    /// Number of points.
    pub points: usize,
}

/// Largest relative change of the approach in the last step.
const SETTLED: f64 = 1e-5;
/// Most steps: they leave a fifth of the error each.
const MOST_STEPS: usize = 24;

impl Spread {
    /// Of one point, on bodies the smaller of which has this bounding radius \[m\].
    pub fn single(size: f64) -> Self {
        Spread { reach: size, points: 1 }
    }

    /// Of these places on such bodies: half the mean distance to the nearest other place. Places closer than
    /// `one_place` \[m\] count as one.
    pub fn of_places(places: impl Iterator<Item = DVec3> + Clone, size: f64, one_place: f64) -> Self {
        let (mut sum, mut points) = (0.0, 0);
        for place in places.clone() {
            let apart = places.clone().map(|other| other.distance(place)).filter(|apart| *apart > one_place);
            sum += (0.5 * apart.fold(f64::INFINITY, f64::min)).min(size);
            points += 1;
        }
        if points == 0 {
            Spread::single(size)
        } else {
            Spread { reach: sum / f64::from(points), points: points as usize }
        }
    }
}

impl Touch<'_> {
    /// Largest approach d_m \[m\] of two sides at each point; `None` where it is not finite.
    pub(super) fn largest_approach(&self, sides: &[ContactSide; 2]) -> Option<f64> {
        let inverse = inverse_effective_mass(sides, self.place, self.normal);
        let contact = HertzContact {
            inverse_mass: inverse * self.spread.points as f64,
            relative_radii: RelativeCurvature::between(sides, self.normal).radii,
            compliance: sides.iter().map(|side| side.compliance).sum(),
            speed: self.speed,
        };
        Some(contact.largest_approach()).filter(|approach| *approach > 0.0 && approach.is_finite())
    }
}

/// The two sides with the curvatures that they have at the scale of the contact. Without a finite approach,
/// as between bodies that do not move, those of the lightest contact.
pub fn touching(sides: [ContactSide; 2], touch: &Touch<'_>) -> [ContactSide; 2] {
    let form = |i: usize| {
        let place = std::iter::once((touch.place, 1.0));
        touch.surfaces[i].map(|surface| PlacedForms::at(&sides[i], surface, touch.normal, place))
    };
    let forms = [form(0), form(1)];
    let at = |scale: Option<ContactScale>| {
        [0, 1].map(|i| {
            let least = scale.map_or(sides[i].least_curvature, ContactScale::least_curvature);
            let curvature = forms[i].as_ref().map_or(sides[i].curvature, |forms| forms.tensor(scale));
            ContactSide { curvature, least_curvature: least, ..sides[i] }
        })
    };
    let mut settled = at(None);
    let Some(mut reached) = touch.largest_approach(&settled) else { return settled };
    for _ in 0..MOST_STEPS {
        settled = at(Some(ContactScale { approach: reached, reach: touch.spread.reach }));
        let Some(next) = touch.largest_approach(&settled) else { return at(None) };
        let change = (next / reached - 1.0).abs();
        reached = next;
        if change < SETTLED {
            break;
        }
    }
    settled
}

impl ContactSide {
    /// The same side with the curvature of `surface` at contact points [m, world] under a light load: the
    /// mean of the tensors with these weights, which sum to 1. `normal` is the unit normal of the contact
    /// \[world\], either way. [`touching`] has those of an impact.
    #[must_use]
    pub fn touched_at(
        self,
        surface: &Surface,
        normal: DVec3,
        points: impl Iterator<Item = (DVec3, f64)>,
    ) -> Self {
        let curvature = PlacedForms::at(&self, surface, normal, points).tensor(None);
        ContactSide { curvature, ..self }
    }
}

/// The forms of one body at the places of a contact.
pub(super) struct PlacedForms {
    forms: Vec<(TouchedForm, f64)>,
    /// Axes of the body in the world.
    axes: DMat3,
}

impl PlacedForms {
    /// Of a body at places [m, world] with weights.
    pub(super) fn at(
        side: &ContactSide,
        surface: &Surface,
        normal: DVec3,
        places: impl Iterator<Item = (DVec3, f64)>,
    ) -> Self {
        let local = side.pose.orientation.inverse() * normal;
        let form = |place: DVec3| {
            TouchedForm::of_surface(surface, side.pose.body_from_world(place), local, side.edge_radius)
        };
        PlacedForms {
            forms: places.map(|(place, weight)| (form(place), weight)).collect(),
            axes: DMat3::from_quat(side.pose.orientation),
        }
    }

    /// The mean tensor [1/m, world] at a scale; without one, of the lightest contact.
    pub(super) fn tensor(&self, scale: Option<ContactScale>) -> DMat3 {
        let mean =
            self.forms.iter().fold(DMat3::ZERO, |sum, (form, weight)| sum + *weight * form.tensor(scale));
        self.axes * mean * self.axes.transpose()
    }
}
