//! Bodies with synthetic but realistic modes, for the tests of the compliant contact.

use std::f64::consts::{PI, TAU};

use clangor_core::contact::compliant::{ContactLaw, HertzLaw, Member, MemberContact};
use clangor_core::glam::{DMat3, DVec3};
use clangor_core::math::random::SplitMix;
use num_complex::Complex64;

/// Hertz's stiffness of a ball of this radius \[m\] on ceramic, both of about 1/E* = 1/50 GPa.
pub(crate) fn stiffness(radius: f64) -> f64 {
    4.0 / 3.0 * 5e10 * radius.sqrt()
}

pub(crate) fn hertz(stiffness: f64) -> HertzLaw {
    HertzLaw { stiffness, ..HertzLaw::default() }
}

/// A steel ball without modes.
pub(crate) fn ball(radius: f64, centre: DVec3, velocity: DVec3) -> Member {
    let mass = 7850.0 * 4.0 / 3.0 * PI * radius.powi(3);
    rigid(mass, DMat3::from_diagonal(DVec3::splat(2.5 / (mass * radius * radius))), centre, velocity)
}

pub(crate) fn rigid(mass: f64, inverse_inertia: DMat3, centre: DVec3, velocity: DVec3) -> Member {
    Member {
        inverse_mass: 1.0 / mass,
        inverse_inertia,
        centre,
        velocity,
        angular_velocity: DVec3::ZERO,
        acceleration: DVec3::ZERO,
        poles: Vec::new(),
        state: Vec::new(),
    }
}

/// A ceramic disc of this radius and thickness \[m\] about the origin, its axis along y.
///
/// Its modes are like those of a plate: density and mean mobility of a thin plate, irregular frequencies and
/// shapes.
pub(crate) struct Disc {
    pub(crate) member: Member,
    radius: f64,
    order: Vec<[f64; 3]>,
}

impl Disc {
    pub(crate) fn new(
        random: &mut SplitMix,
        [radius, thickness]: [f64; 2],
        highest: f64,
        loss_factor: f64,
    ) -> Disc {
        let (young, poisson, density) = (72e9, 0.19, 2700.0);
        let rigidity = young * f64::powi(thickness, 3) / (12.0 * (1.0 - poisson * poisson));
        let (surface, area) = (density * thickness, PI * radius * radius);
        let mass = surface * area;
        let spacing = 4.0 * PI / area * (rigidity / surface).sqrt();
        let across = 1.0 / (0.25 * mass * radius * radius);
        let inertia = DMat3::from_diagonal(DVec3::new(across, 0.5 * across, across));
        let mut member = rigid(mass, inertia, DVec3::ZERO, DVec3::ZERO);
        let mut order = Vec::new();
        let mut omega = spacing * random.uniform(0.8, 1.3);
        while omega < TAU * highest {
            let damping = 0.5 * loss_factor;
            let pole = Complex64::new(-damping * omega, omega * (1.0 - damping * damping).sqrt());
            member.poles.push(pole);
            let size = (2.0 / mass).sqrt();
            order.push([size, random.uniform(0.0, TAU), (omega * (surface / rigidity).sqrt()).sqrt()]);
            omega += spacing * random.uniform(0.4, 1.6);
        }
        Disc { member, radius, order }
    }

    /// The point at this share of the radius.
    pub(crate) fn point(&self, share: f64, angle: f64) -> DVec3 {
        share * self.radius * DVec3::new(angle.cos(), 0.0, angle.sin())
    }

    /// Shapes at a point: standing waves across the disc, nearly along its axis, larger at the rim.
    pub(crate) fn shapes(&self, point: DVec3) -> Vec<DVec3> {
        let rim = 1.0 + (point.length() / self.radius).powi(4);
        let shape = |[size, phase, wave]: &[f64; 3]| {
            let along = DVec3::new(phase.cos(), 0.0, phase.sin()).dot(point);
            let height = size * rim * (wave * along + 3.0 * phase).cos() * (0.5 + (2.0 * phase).sin().abs());
            height * DVec3::new(0.1 * phase.sin(), 1.0, 0.1 * phase.cos())
        };
        self.order.iter().map(shape).collect()
    }

    /// A member that rings with this energy \[J\].
    pub(crate) fn ringing(&self, random: &mut SplitMix, energy: f64) -> Member {
        let mut member = self.member.clone();
        let size = (2.0 * energy / member.poles.len().max(1) as f64).sqrt();
        member.state =
            member.poles.iter().map(|_| Complex64::from_polar(size, random.uniform(0.0, TAU))).collect();
        member
    }
}

/// A contact of Hertz without friction between two members, of which B may have shapes.
pub(crate) fn contact(
    members: [Option<usize>; 2],
    point: DVec3,
    normal: DVec3,
    law: HertzLaw,
) -> MemberContact {
    MemberContact {
        velocity: DVec3::ZERO,
        members,
        point,
        normal,
        law: ContactLaw::Hertz(law),
        gap: 0.0,
        friction: 0.0,
        standing: false,
        shapes: [Vec::new(), Vec::new()],
    }
}

/// Displacement of a member's surface along u by its vibration.
pub(crate) fn displacement(member: &Member, shapes: &[DVec3], along: DVec3) -> f64 {
    let modes = member.poles.iter().zip(&member.state).zip(shapes);
    modes.map(|((pole, w), shape)| shape.dot(along) * w.im / pole.im).sum()
}

/// Energy ½(q̇² + ω²q²) of a member's modes \[J\].
pub(crate) fn vibration(poles: &[Complex64], state: &[Complex64]) -> f64 {
    let energy = |(pole, w): (&Complex64, &Complex64)| {
        let q = w.im / pole.im;
        0.5 * ((w.re + pole.re * q).powi(2) + pole.norm_sqr() * q * q)
    };
    poles.iter().zip(state).map(energy).sum()
}
