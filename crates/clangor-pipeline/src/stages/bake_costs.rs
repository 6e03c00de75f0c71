//! What the sound models of a body cost at each quality, before anything is baked: estimates of
//! [`clangor_bake::cost`].

use std::f64::consts::TAU;

use clangor_bake::cost::{FieldCost, field_cost, of_modes, seconds};
use clangor_core::body::Surface;
use clangor_core::material::Material;
use clangor_core::medium::Medium;

use super::body_facts::AUDIBLE;
use super::sound_models::request::radiating;
use super::sound_models::{ModelOptions, Quality};

/// Estimated CPU time of the models of a body up to 20 kHz in air, at one quality.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BakeCost {
    /// The quality.
    pub quality: Quality,
    /// Of the field of its acceleration \[s\]; 0 for a sphere, which has a closed form.
    pub clicks: f64,
    /// Of a solve of that field; cells where it is simulated in time. 0 for a sphere.
    pub unknowns: f64,
    /// Of its modes and their transfers \[s\]; `None` without a material.
    pub ringing: Option<f64>,
}

/// The costs at each quality; none for what is endless.
pub fn bake_costs(surface: &Surface, material: Option<&Material>) -> Vec<BakeCost> {
    let Ok((geometry, _)) = radiating(surface) else { return Vec::new() };
    let cost = |quality: Quality| {
        let options = ModelOptions { quality, ..ModelOptions::default() };
        let highest = TAU * AUDIBLE / Medium::AIR.sound_speed;
        let field = options.of_field(options.acceleration(highest).options);
        let modes = options.of_modes(options.modal(Medium::AIR, AUDIBLE));
        let clicks = match surface {
            Surface::Sphere { .. } => FieldCost { operations: 0.0, unknowns: 0.0 },
            _ => field_cost(&geometry, &field),
        };
        BakeCost {
            quality,
            clicks: seconds(clicks.operations),
            unknowns: clicks.unknowns,
            ringing: material.map(|material| seconds(of_modes(&geometry, material, &modes))),
        }
    };
    [Quality::Draft, Quality::Normal, Quality::High].map(cost).to_vec()
}
