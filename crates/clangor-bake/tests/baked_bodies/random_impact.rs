//! Impacts of a ball or of granite anywhere on bodies with baked modes.

use clangor_core::contact::compliant::{Member, MemberContact, hertz_duration, restitution_damping};
use clangor_core::material::presets::{CERAMIC, GLASS, GRANITE, PLASTIC, Preset, STEEL};
use clangor_core::math::random::SplitMix;

use crate::baked_bodies::{BakedBody, steel, stiffness};
use crate::compliant_bodies::{ball, contact, hertz};

/// Shape, material, and band of the modes \[Hz\].
pub(crate) const BODIES: [(&str, &Preset, f64); 5] = [
    ("plate", &CERAMIC, 20e3),
    ("wineglass", &GLASS, 20e3),
    ("bowl", &CERAMIC, 20e3),
    ("coin:0.0375x0.001", &STEEL, 20e3),
    ("box:0.12x0.0012x0.12", &PLASTIC, 10e3),
];

/// A steel ball on a body at rest, or a body that falls on granite, anywhere on its surface.
pub(crate) struct RandomImpact {
    pub(crate) members: Vec<Member>,
    pub(crate) hit: MemberContact,
    /// Hertz's duration of the rigid bodies \[s\].
    pub(crate) duration: f64,
}

impl RandomImpact {
    pub(crate) fn new(body: &BakedBody, random: &mut SplitMix) -> RandomImpact {
        let place = body.places[(random.uniform(0.0, 1.0) * body.places.len() as f64) as usize];
        let is_ball = random.uniform(0.0, 1.0) < 0.6;
        let radius = 10f64.powf(random.uniform(-2.7, -1.8));
        let speed = 10f64.powf(random.uniform(-1.0, 0.5));
        let other = if is_ball { steel() } else { GRANITE.material() };
        let mut law = hertz(stiffness(radius, [&other, &body.material]));
        law.restitution_damping = restitution_damping(0.95);
        let mut hit = contact([None, Some(0)], place.point, place.normal, law);
        hit.shapes[1] = body.shapes(place);
        let mut members = vec![body.member.clone()];
        let mut inverse = body.inverse_mass(place, place.normal);
        if is_ball {
            let striker = ball(radius, place.point + radius * place.normal, -speed * place.normal);
            inverse += striker.inverse_mass;
            members.push(striker);
            hit.members[0] = Some(1);
        } else {
            members[0].velocity = speed * place.normal;
        }
        RandomImpact { members, hit, duration: hertz_duration(inverse, law.stiffness, speed) }
    }
}
