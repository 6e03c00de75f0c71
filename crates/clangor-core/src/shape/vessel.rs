//! Bowl, plate, wineglass and moneybox: bodies of revolution of the size of everyday ones. The table they
//! stand on is y = 0.
//!
//! Their sides are spheres and cones, so that volume and curvature are known in closed form. The bowl and the
//! plate have about the volume that the pulse time scales in \[PAN\] Table 1 imply (160 cm³, 230 to 280 cm³).

use std::f64::consts::FRAC_PI_4;

use glam::{DVec2, DVec3};

use crate::geometry::convex::ConvexPart;
use crate::shape::axisymmetric::{Profile, axisymmetric_hull, balance, wedges};

/// A shell between two spheres about (0, `centre`), open above, on a solid base with a flat floor inside.
pub(super) struct Shell {
    /// Height of the centre of the spheres \[m\].
    centre: f64,
    /// Radius of the inner sphere \[m\].
    inner: f64,
    /// Radius of the outer sphere \[m\].
    outer: f64,
    /// Radius of the base where it meets the outer sphere \[m\].
    base: f64,
    /// Radius of the floor inside \[m\].
    floor: f64,
    /// Angle of the rim from straight down \[rad\].
    rim: f64,
}

/// A bowl 148 mm wide and 62 mm high, walls of 5.5 mm, on a foot 60 mm wide.
pub(super) const BOWL: Shell =
    Shell { centre: 0.0735, inner: 0.068, outer: 0.0735, base: 0.030, floor: 0.024, rim: 1.40 };

/// The cup of a glass 142 mm high: a sphere 80 mm wide with walls of 1.5 mm.
pub(super) const GLASS: Shell =
    Shell { centre: 0.118, inner: 0.0385, outer: 0.040, base: 0.004, floor: 0.0135, rim: 2.18 };

/// A moneybox: a sphere 110 mm wide with walls of 4 mm, on a foot 44 mm wide. The hole in its top is 19 mm
/// wide, less than a coin, so that what is inside stays there.
const MONEYBOX: Shell =
    Shell { centre: 0.055, inner: 0.051, outer: 0.055, base: 0.022, floor: 0.018, rim: 2.92 };

impl Shell {
    fn at(&self, radius: f64, angle: f64) -> DVec2 {
        DVec2::new(radius * angle.sin(), self.centre - radius * angle.cos())
    }

    /// Goes on from the point where the base meets the outer sphere: out, around the rim, in and to the axis.
    fn continue_profile(&self, profile: Profile) -> Profile {
        let centre = DVec2::new(0.0, self.centre);
        let middle = self.at(0.5 * (self.inner + self.outer), self.rim);
        let floor = self.at(self.inner, (self.floor / self.inner).asin());
        profile
            .arc_to(centre, self.at(self.outer, self.rim), 1.0)
            .arc_to(middle, self.at(self.inner, self.rim), 1.0)
            .arc_to(centre, floor, -1.0)
            .line_to(0.0, floor.y)
    }

    fn sagitta(&self) -> f64 {
        0.1 * (self.outer - self.inner)
    }

    /// Where the base meets the outer sphere.
    fn foot(&self) -> DVec2 {
        self.at(self.outer, (self.base / self.outer).asin())
    }

    /// The wall as `rows` × `sectors` wedges, and the circles that bound the solid below the floor.
    fn parts(&self, rows: usize, sectors: usize) -> (Vec<ConvexPart>, [DVec2; 2]) {
        let low_inner = (self.floor / self.inner).asin();
        let low_outer = low_inner.max((self.base / self.outer).asin());
        let along = |low: f64, k: f64| low + (self.rim - low) * k / rows as f64;
        let near_radius = self.inner * balance(0.5 * (self.rim - low_inner) / rows as f64);
        let mut parts = Vec::new();
        for row in 0..rows {
            let k = row as f64;
            let mut far = [0.0, 0.5, 1.0].map(|s| self.at(self.outer, along(low_outer, k + s))).to_vec();
            let mut near = [0.0, 1.0].map(|s| self.at(near_radius, along(low_inner, k + s))).to_vec();
            if row + 1 == rows {
                // The rim ends along the spheres, which rise at the angle from straight down.
                let middle = self.at(0.5 * (self.inner + self.outer), self.rim);
                let [out, top, within] = half_round(middle, self.rim, 0.5 * (self.outer - self.inner));
                far.extend([out, top]);
                near.push(within);
            }
            parts.extend(wedges(&far, &near, sectors));
        }
        (parts, [self.at(self.outer, low_outer), self.at(self.inner, low_inner)])
    }
}

/// Three points of a round rim about `middle` that ends in the given direction \[rad\], beside its two ends.
fn half_round(middle: DVec2, direction: f64, radius: f64) -> [DVec2; 3] {
    [-FRAC_PI_4, 0.0, FRAC_PI_4].map(|turn| middle + DVec2::from_angle(direction + turn) * radius)
}

pub(super) fn bowl_profile(edge: f64) -> Profile {
    let foot = BOWL.foot();
    let profile =
        Profile::start(DVec2::ZERO, edge, BOWL.sagitta()).line_to(foot.x, 0.0).line_to(foot.x, foot.y);
    BOWL.continue_profile(profile)
}

pub(super) fn bowl_parts() -> Vec<ConvexPart> {
    let (mut parts, [below, floor]) = BOWL.parts(3, 16);
    parts.push(axisymmetric_hull(&[DVec2::new(BOWL.base, 0.0), below, floor]));
    parts
}

pub(super) fn moneybox_profile(edge: f64) -> Profile {
    let foot = MONEYBOX.foot();
    let profile =
        Profile::start(DVec2::ZERO, edge, MONEYBOX.sagitta()).line_to(foot.x, 0.0).line_to(foot.x, foot.y);
    MONEYBOX.continue_profile(profile)
}

pub(super) fn moneybox_parts() -> Vec<ConvexPart> {
    let (mut parts, [below, floor]) = MONEYBOX.parts(6, 16);
    parts.push(axisymmetric_hull(&[DVec2::new(MONEYBOX.base, 0.0), below, floor]));
    parts
}

/// Foot of the glass: radius, thickness at the edge, height where the stem begins \[m\].
const FOOT: [f64; 3] = [0.034, 0.0024, 0.0065];

pub(super) fn wineglass_profile(edge: f64) -> Profile {
    let [radius, thickness, stem] = FOOT;
    let top = GLASS.foot();
    let profile = Profile::start(DVec2::ZERO, edge, GLASS.sagitta())
        .line_to(radius, 0.0)
        .arc_to(DVec2::new(radius, 0.5 * thickness), DVec2::new(radius, thickness), 1.0)
        .line_to(top.x, stem)
        .line_to(top.x, top.y);
    GLASS.continue_profile(profile)
}

pub(super) fn wineglass_parts() -> Vec<ConvexPart> {
    let [radius, thickness, stem] = FOOT;
    let top = GLASS.foot();
    let (mut parts, [below, floor]) = GLASS.parts(4, 16);
    let middle = 0.5 * (top.x + below.x);
    let cap = GLASS.at(GLASS.outer, (middle / GLASS.outer).asin());
    parts.push(axisymmetric_hull(&[top, cap, below, floor]));
    let edge = DVec2::new(radius + 0.5 * thickness, 0.5 * thickness);
    let foot = [DVec2::new(radius, 0.0), edge, DVec2::new(radius, thickness), DVec2::new(top.x, stem)];
    parts.push(axisymmetric_hull(&foot));
    parts.push(ConvexPart::Cylinder {
        centre: DVec3::Y * 0.5 * (stem + top.y),
        axis: DVec3::Y,
        radius: top.x,
        half_height: 0.5 * (top.y - stem),
    });
    parts
}

/// A plate 26 cm wide: thickness, radius of the flat middle, radius and height of the middle of the round
/// edge \[m\].
const PLATE: [f64; 4] = [0.0045, 0.080, 0.12775, 0.0200];

/// Underside corner, underside of the edge, middle of the edge, top of the edge, top corner of a plate's
/// section.
fn plate_corners() -> [DVec2; 5] {
    let [thickness, flat, radius, height] = PLATE;
    let edge = DVec2::new(radius, height);
    let below = DVec2::new(flat, 0.0);
    // The underside is tangent to the circle of the edge.
    let reach = edge - below;
    let slope = reach.y.atan2(reach.x) - (0.5 * thickness / reach.length()).asin();
    let across = DVec2::from_angle(slope).perp() * 0.5 * thickness;
    let top = edge + across;
    let run = (top.y - thickness) / slope.tan();
    [below, edge - across, edge, top, DVec2::new(top.x - run, thickness)]
}

pub(super) fn plate_profile(edge: f64) -> Profile {
    let [below, rim_below, middle, rim_top, top] = plate_corners();
    Profile::start(DVec2::ZERO, edge, 0.1 * PLATE[0])
        .line_to(below.x, below.y)
        .line_to(rim_below.x, rim_below.y)
        .arc_to(middle, rim_top, 1.0)
        .line_to(top.x, top.y)
        .line_to(0.0, top.y)
}

pub(super) fn plate_parts() -> Vec<ConvexPart> {
    let [below, rim_below, middle, rim_top, top] = plate_corners();
    let along = (rim_below - below).to_angle();
    // The wedges reach a little into the flat middle, whose border is round, along their own upper side.
    let overlap = top - 0.03 * (rim_top - top);
    let mut far = vec![below, rim_below, rim_top];
    far.extend(half_round(middle, along, 0.5 * PLATE[0]));
    let mut parts = wedges(&far, &[overlap], 24);
    parts.push(axisymmetric_hull(&[below, top]));
    parts
}
