//! Hertz's laws of balls among each other and on planes, and how fast they meet.

use clangor_core::contact::compliant::restitution_damping;
use clangor_core::contact::hertz::HertzContact;
use clangor_core::contact::hertz_pulse::DURATION_OVER_APPROACH_TIME;
use glam::DVec3;

use super::cluster::Participant;
use super::engine::Engine;
use crate::spheres::compliant_cluster::PressLaw;

/// Slowest approach that begins a cluster \[m/s\]; \[PAN\] §4.3 has it as the slowest one that sounds.
pub(super) const SLOWEST: f64 = 0.05;

/// How a ball meets its partner.
pub(super) struct MeetingSpeed {
    /// Unit normal towards the ball.
    pub(super) normal: DVec3,
    /// Approach speed \[m/s\].
    pub(super) speed: f64,
    /// Hertz's contact time \[s\]; not finite for bodies without compliance.
    pub(super) duration: f64,
}

impl Engine {
    /// How a ball meets its partner now.
    pub(super) fn approach(&self, ball: usize, partner: Participant) -> MeetingSpeed {
        let (x, v) = self.state(ball, self.now);
        let (normal, w) = match partner {
            Participant::Ball(other) => {
                let (y, w) = self.state(other, self.now);
                ((x - y).normalize_or(DVec3::Y), w)
            }
            Participant::Plane(plane) => (self.planes[plane].normal, DVec3::ZERO),
        };
        let speed = -normal.dot(v - w);
        let law = self.law_of(ball, partner, 0.0, speed);
        let duration = self.contact_time(&law, self.inverse_mass_of(ball, partner), speed);
        MeetingSpeed { normal, speed, duration }
    }

    /// Hertz's law of a ball and its partner, whose surfaces meet at `speed` [m/s] or overlap by −`gap`.
    pub(super) fn law_of(&self, ball: usize, partner: Participant, gap: f64, speed: f64) -> PressLaw {
        match partner {
            Participant::Ball(other) => self.law_of_balls(ball, other, gap, speed),
            Participant::Plane(plane) => self.law_on_plane(ball, plane, gap, speed),
        }
    }

    pub(super) fn inverse_mass_of(&self, ball: usize, partner: Participant) -> f64 {
        let other = match partner {
            Participant::Ball(other) => self.traits[other].inverse_mass,
            Participant::Plane(_) => 0.0,
        };
        self.traits[ball].inverse_mass + other
    }

    /// Hertz's law of two balls whose surfaces meet at `speed` [m/s], or that overlap by −`gap`.
    pub(super) fn law_of_balls(&self, a: usize, b: usize, gap: f64, speed: f64) -> PressLaw {
        let radii = [a, b].map(|ball| self.balls[ball].radius);
        let contact = HertzContact {
            inverse_mass: self.inverse_mass_of(a, Participant::Ball(b)),
            relative_radii: [1.0 / radii.iter().map(|r| 1.0 / r).sum::<f64>(); 2],
            compliance: self.compliances[a] + self.compliances[b],
            speed: 1.0,
        };
        let pair = self.pairs.of(self.traits[a].material, self.traits[b].material);
        press_law(&contact, pair.restitution.at(speed), pair.friction, radii[0] + radii[1] + gap)
    }

    /// Hertz's law of a ball on a plane.
    pub(super) fn law_on_plane(&self, ball: usize, plane: usize, gap: f64, speed: f64) -> PressLaw {
        let radius = self.balls[ball].radius;
        let contact = HertzContact {
            inverse_mass: self.traits[ball].inverse_mass,
            relative_radii: [radius; 2],
            compliance: self.compliances[ball] + self.planes[plane].compliance,
            speed: 1.0,
        };
        let pair = self.pairs.of(self.traits[ball].material, self.planes[plane].material);
        let pair = self.planes[plane].met_by(pair, self.contact_of(ball));
        press_law(&contact, pair.restitution.at(speed), pair.friction, radius + gap)
    }

    /// Radius \[m\], inverse mass [1/kg] and compliance [1/Pa] of a ball.
    pub(super) fn contact_of(&self, ball: usize) -> (f64, f64, f64) {
        (self.balls[ball].radius, self.traits[ball].inverse_mass, self.compliances[ball])
    }

    /// Hertz's contact time \[s\].
    pub(super) fn contact_time(&self, law: &PressLaw, inverse_mass: f64, speed: f64) -> f64 {
        let speed = speed.max(SLOWEST);
        let approach = (1.25 * speed * speed / (inverse_mass * law.stiffness)).powf(0.4);
        DURATION_OVER_APPROACH_TIME * approach / speed
    }
}

/// The law with the damping of a restitution.
fn press_law(contact: &HertzContact, restitution: f64, friction: f64, reach: f64) -> PressLaw {
    let stiffness = contact.stiffness();
    let damping = restitution_damping(restitution) * (stiffness / contact.inverse_mass).sqrt();
    PressLaw { stiffness, damping, friction, reach }
}
