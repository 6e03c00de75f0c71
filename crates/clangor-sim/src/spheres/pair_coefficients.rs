//! Contact coefficients of pairs of materials: a table over the distinct materials of a world.
//!
//! Reading the large records of two bodies at each of a million impacts would cost more than the impacts.

use std::collections::BTreeMap;

use clangor_core::body::World;
use clangor_core::material::{Material, PairCoefficients};

/// Largest number of materials whose pairs are tabulated.
const MOST: usize = 256;

/// Coefficients of pairs of material classes; materials of one class have the same contact coefficients.
pub(super) struct PairTable {
    materials: Vec<Material>,
    table: Vec<PairCoefficients>,
}

impl PairTable {
    /// The classes of a world, and the class of each of its bodies.
    pub(super) fn new(world: &World) -> (Self, Vec<u32>) {
        let mut known = BTreeMap::new();
        let mut materials: Vec<Material> = Vec::new();
        let classes = world
            .bodies
            .iter()
            .map(|body| {
                *known.entry(key(&body.material)).or_insert_with(|| {
                    materials.push(body.material.clone());
                    (materials.len() - 1) as u32
                })
            })
            .collect();
        (PairTable { table: table(&materials), materials }, classes)
    }

    /// The class of a material; a new material gets a new class.
    pub(super) fn class_of(&mut self, material: &Material) -> u32 {
        let known = self.materials.iter().position(|m| key(m) == key(material));
        known.unwrap_or_else(|| {
            self.materials.push(material.clone());
            self.table = table(&self.materials);
            self.materials.len() - 1
        }) as u32
    }

    /// Contact compliance of a class [1/Pa].
    pub(super) fn compliance(&self, class: u32) -> f64 {
        self.materials[class as usize].contact_compliance()
    }

    /// The coefficients of two classes.
    pub(super) fn of(&self, a: u32, b: u32) -> PairCoefficients {
        let (a, b) = (a as usize, b as usize);
        match self.table.get(a * self.materials.len() + b) {
            Some(&pair) => pair,
            None => PairCoefficients::of(&self.materials[a], &self.materials[b]),
        }
    }
}

/// What the coefficients of pairs depend on.
fn key(m: &Material) -> [u64; 7] {
    let absent = -1.0;
    [
        m.restitution,
        m.restitution_speed.unwrap_or(absent),
        m.yield_strength.unwrap_or(absent),
        m.density,
        m.contact_compliance(),
        m.friction,
        m.rolling_loss,
    ]
    .map(f64::to_bits)
}

fn table(materials: &[Material]) -> Vec<PairCoefficients> {
    if materials.len() > MOST {
        return Vec::new();
    }
    materials.iter().flat_map(|a| materials.iter().map(|b| PairCoefficients::of(a, b))).collect()
}
