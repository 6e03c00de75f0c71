//! An impact between two bodies, before its forces are known: where, along which normal, how fast, and with
//! which impulses. [`contact_forces`](fn@super::contact_forces::contact_forces) makes the forces.

use glam::DVec3;

use super::contact_side::{ContactSide, inverse_effective_mass};
use super::hertz::{HertzContact, HertzRange};
use super::relative_curvature::RelativeCurvature;

/// An impact between two bodies A and B, before its forces are known.
#[derive(Clone, Debug, PartialEq)]
pub struct Impact {
    /// Number of the impact in its timeline; 0 for none.
    pub impact_id: u64,
    /// First instant \[s\].
    pub time: f64,
    /// A and B.
    pub sides: [ContactSide; 2],
    /// Mean point [m, world].
    pub point: DVec3,
    /// Mean unit normal, from B to A.
    pub normal: DVec3,
    /// Approach speed V along the normal [m/s].
    pub speed: f64,
    /// Restitution of the contact itself, without vibration.
    pub restitution: f64,
    /// Coefficient of friction μ.
    pub friction: f64,
    /// Contact points.
    pub points: Vec<ContactPoint>,
}

/// A point of a contact, and what acts there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactPoint {
    /// Place [m, world].
    pub place: DVec3,
    /// Unit normal, from B to A.
    pub normal: DVec3,
    /// Velocity of A relative to B before the impact [m/s].
    pub velocity: DVec3,
    /// Gap between the surfaces at the first instant of the impact \[m\].
    pub gap: f64,
    /// Impulse on A [N s, world].
    pub impulse: DVec3,
    /// Couple impulse on A [N m s, world].
    pub couple: DVec3,
}

impl ContactPoint {
    /// Surfaces that touch at a place [m, world] with a unit normal from B to A and a velocity of A relative
    /// to B [m/s], before any impulse.
    pub fn approaching(place: DVec3, normal: DVec3, velocity: DVec3) -> Self {
        ContactPoint { place, normal, velocity, gap: 0.0, impulse: DVec3::ZERO, couple: DVec3::ZERO }
    }
}

impl Impact {
    /// An impact without friction at one point, by the restitution e of the pair: the impulse (1 + e) m V on
    /// A along `normal`, the unit normal from B to A.
    pub fn with_restitution(
        sides: [ContactSide; 2],
        point: DVec3,
        normal: DVec3,
        speed: f64,
        restitution: f64,
    ) -> Self {
        let inverse_mass = inverse_effective_mass(&sides, point, normal);
        let impulse = normal * ((1.0 + restitution) * speed / inverse_mass);
        let velocity = -speed * normal;
        let points = vec![ContactPoint { impulse, ..ContactPoint::approaching(point, normal, velocity) }];
        Impact { impact_id: 0, time: 0.0, sides, point, normal, speed, restitution, friction: 0.0, points }
    }

    /// The same impact at another time \[s\].
    #[must_use]
    pub fn at_time(self, time: f64) -> Self {
        Impact { time, ..self }
    }

    /// The contact for Hertz's formulas, and whether they cover it.
    pub fn hertz(&self) -> (HertzContact, HertzRange) {
        let RelativeCurvature { radii, range } = RelativeCurvature::between(&self.sides, self.normal);
        let contact = HertzContact {
            inverse_mass: inverse_effective_mass(&self.sides, self.point, self.normal),
            relative_radii: radii,
            compliance: self.sides[0].compliance + self.sides[1].compliance,
            speed: self.speed,
        };
        let deep = range == HertzRange::Within && contact.is_deep();
        (contact, if deep { HertzRange::Deep } else { range })
    }
}
