//! The planes of a world that sound when they are hit: those that face up.

use std::collections::BTreeMap;
use std::sync::Arc;

use clangor_core::body::{Body, BodyId, Surface};
use clangor_core::glam::DVec3;
use clangor_core::material::presets;
use clangor_core::reference::SlabSource;
use clangor_core::scene::render_description::GroundSound;
use clangor_core::synthesis::ground::{Ground, GroundError, GroundSource};

use super::options::RenderOptions;

/// Cosine of the steepest slope that is ground.
const FACING_UP: f64 = 0.9;

/// Whether a body sounds as ground: walls and cushions are planes too, but nothing extends behind them.
pub(super) fn is_ground(body: &Body, options: &RenderOptions) -> bool {
    let up = (body.pose.orientation * DVec3::Y).y;
    let asked = options.parts.ground && options.ground != GroundSound::None;
    asked && matches!(*body.surface, Surface::HalfSpace) && up > FACING_UP
}

/// The grounds among the bodies; those of one material share their sound.
pub(super) fn grounds(
    bodies: &[Body],
    options: &RenderOptions,
) -> Result<BTreeMap<BodyId, Ground>, GroundError> {
    let mut grounds: BTreeMap<BodyId, Ground> = BTreeMap::new();
    let medium = &options.synthesis.acoustics.medium;
    let planes = bodies.iter().enumerate().filter(|(_, body)| is_ground(body, options));
    for (index, body) in planes {
        let same = grounds.iter().find(|(id, _)| bodies[id.index()].material == body.material);
        let source = match same {
            Some((_, source)) => source.clone(),
            None => match options.ground {
                GroundSound::Slab => {
                    Ground::Reference(Arc::new(SlabSource::try_new(&presets::CONCRETE.material(), medium)?))
                }
                _ => Ground::HalfSpace(Arc::new(GroundSource::try_new(&body.material, medium)?)),
            },
        };
        grounds.insert(BodyId(index as u32), source);
    }
    Ok(grounds)
}
