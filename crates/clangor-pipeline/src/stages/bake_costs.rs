//! What the sound models of a body cost at each quality, before anything is baked: estimates of
//! [`clangor_bake::cost`].

use std::f64::consts::TAU;

use clangor_bake::acceleration::planned_cost;
use clangor_bake::cost::{FieldCost, field_cost, of_modes, planned_cost_of_modes, seconds};
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

/// How much an estimate may cost itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Estimate {
    /// Milliseconds: by volume, area and band.
    Quick,
    /// Seconds: by the triangles that the surface needs.
    Planned,
}

/// The costs at each quality; none for what is endless.
pub fn bake_costs(surface: &Surface, material: Option<&Material>, estimate: Estimate) -> Vec<BakeCost> {
    let Ok((geometry, _)) = radiating(surface) else { return Vec::new() };
    let highest = TAU * AUDIBLE / Medium::AIR.sound_speed;
    let settings = |quality: Quality| {
        let options = ModelOptions { quality, ..ModelOptions::default() };
        let field = options.of_field(options.acceleration(highest).options);
        (field, options.of_modes(options.modal(Medium::AIR, AUDIBLE)))
    };
    let is_sphere = matches!(surface, Surface::Sphere { .. });
    let quick = |quality: Quality| {
        let (field, modes) = settings(quality);
        let clicks = if is_sphere { FieldCost::default() } else { field_cost(&geometry, &field) };
        let ringing = material.map(|material| seconds(of_modes(&geometry, material, &modes)));
        BakeCost { quality, clicks: seconds(clicks.operations), unknowns: clicks.unknowns, ringing }
    };
    let mut costs = [Quality::Draft, Quality::Normal, Quality::High].map(quick);
    if estimate == Estimate::Planned {
        // The same factor for the high quality, whose plan would take as long again.
        let (field, modes) = settings(Quality::Normal);
        let planned = |material: &Material| seconds(planned_cost_of_modes(&geometry, material, &modes));
        let [_, normal, high] = &mut costs;
        if let (false, Ok(clicks)) = (is_sphere || normal.clicks == 0.0, planned_cost(&geometry, &field)) {
            let after = seconds(clicks.operations);
            high.clicks = (high.clicks * after / normal.clicks).max(after);
            (normal.clicks, normal.unknowns) = (after, clicks.unknowns);
        }
        if let (Some(before), Some(of_high), Some(after)) =
            (normal.ringing, high.ringing, material.map(planned))
        {
            let scaled = if before > 0.0 { of_high * after / before } else { of_high };
            high.ringing = Some(scaled.max(after));
            normal.ringing = Some(after);
        }
    }
    costs.to_vec()
}
