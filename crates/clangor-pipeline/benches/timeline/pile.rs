//! An imitated raw log of a settling rock pile: the same pairs of bodies touch step after step, at points
//! that creep and with impulses that fluctuate about the load they carry.

use clangor_core::body::{Body, BodyId, Surface, World};
use clangor_core::material::{Damping, Material};
use clangor_core::medium::Medium;
use clangor_core::timeline::{ContactKind, ContactRow};
use clangor_pipeline::formats::timeline_file::{Origin, TimelineHeader};
use glam::{DMat3, DVec3};
use std::sync::Arc;

const BODIES: u32 = 1000;
const CONTACTS: usize = 3300;
const STEP: f64 = 2.5e-4;
/// Relative change of an impulse from step to step.
const FLICKER: f64 = 2e-3;
/// Share of the contacts that slide or roll in a step.
const MOVING: f64 = 0.1;

/// A description for the rows of a [`Pile`].
pub(crate) fn header() -> TimelineHeader {
    let surface = Arc::new(Surface::Sphere { radius: 0.015 });
    let material = Material {
        name: "granite".into(),
        density: 2650.0,
        youngs_modulus: 50e9,
        poisson_ratio: 0.25,
        restitution: 0.4,
        restitution_speed: None,
        rigid_restitution: None,
        yield_strength: None,
        friction: 0.5,
        rolling_loss: 5e-5,
        damping: Damping::LossFactor(1e-3),
        tensile_strength: None,
        fracture_energy: None,
        source: "imitation".into(),
    };
    let bodies = (0..BODIES)
        .map(|i| {
            let (surface, inertia) = (Arc::clone(&surface), DMat3::IDENTITY * 3.4e-6);
            Body::new(format!("rock {i}"), material.clone(), surface, 0.037, inertia).with_edge_radius(3e-4)
        })
        .collect();
    TimelineHeader {
        world: World { bodies, links: Vec::new(), gravity: DVec3::Y * -9.81 },
        medium: Medium::AIR,
        origin: Origin {
            solver: "rigid".into(),
            time_step: STEP,
            duration: 2.0,
            v_min: 0.05,
            pose_rate: 0.0,
            raw_log: true,
            sleep: true,
            seed: 3,
            impact_modes: Vec::new(),
        },
        scene: None,
    }
}

/// Makes rows one after another, the same for the same seed.
pub(crate) struct Pile {
    random: u64,
    contacts: Vec<ContactRow>,
    next: usize,
    step: u64,
}

impl Pile {
    /// A pile at its first step.
    pub(crate) fn new(seed: u64) -> Self {
        let mut pile = Pile { random: seed, contacts: Vec::new(), next: 0, step: 0 };
        for contact in 0..CONTACTS {
            let body = |u: f64| BodyId((u * f64::from(BODIES)) as u32);
            let normal = pile.vector().normalize_or(DVec3::Y);
            let row = ContactRow {
                time: 0.0,
                body_a: body((contact as f64 + 0.5) / CONTACTS as f64),
                body_b: if contact % 10 == 0 { BodyId::WORLD } else { body(pile.unit() * 0.999) },
                kind: ContactKind::Contact,
                point: pile.vector() * 0.2,
                normal,
                impulse_n: 1e-3 * pile.unit(),
                impulse_t: normal.any_orthogonal_vector() * 2e-4 * pile.unit(),
                couple: DVec3::ZERO,
                velocity: pile.vector() * 1e-5,
                depth: 1e-6 * pile.unit(),
                impact_id: 0,
                effective_mass: None,
            };
            pile.contacts.push(row);
        }
        pile
    }

    /// The next row.
    pub(crate) fn next_row(&mut self) -> ContactRow {
        let index = self.next;
        self.next = (self.next + 1) % CONTACTS;
        if index == 0 {
            self.step += 1;
        }
        let mut row = self.contacts[index];
        row.time = self.step as f64 * STEP;
        // The solver stops short of convergence, so impulses and speeds of resting contacts flicker.
        row.impulse_n *= 1.0 + FLICKER * (self.unit() - 0.5);
        row.impulse_t += self.vector() * (FLICKER * row.impulse_n);
        row.couple = self.vector() * (2e-5 * row.impulse_n);
        row.velocity += self.vector() * 2e-6;
        if self.unit() < MOVING {
            let creep = self.vector();
            row.point += creep * 1e-5;
            row.normal = (row.normal + creep * 1e-4).normalize();
            row.depth += creep.x * 1e-7;
            self.contacts[index] = row;
        }
        row
    }

    /// Uniform in 0 to 1 (splitmix64).
    fn unit(&mut self) -> f64 {
        self.random = self.random.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.random;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Uniform in the cube from −1 to 1.
    fn vector(&mut self) -> DVec3 {
        let mut next = || 2.0 * self.unit() - 1.0;
        DVec3::new(next(), next(), next())
    }
}
