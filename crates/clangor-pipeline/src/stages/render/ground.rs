//! The planes of a world that sound when they are hit: plates, and half-spaces that face up.

use std::collections::BTreeMap;
use std::sync::Arc;

use clangor_core::body::{Body, BodyId, Surface};
use clangor_core::glam::DVec3;
use clangor_core::material::presets;
use clangor_core::reference::SlabSource;
use clangor_core::scene::render_description::GroundSound;
use clangor_core::synthesis::ground::{Ground, GroundError, GroundSource, PlateSource};

use super::options::RenderOptions;

/// Cosine of the steepest slope that is ground.
const FACING_UP: f64 = 0.9;

/// Whether a body sounds as ground: a plate in any position, and a half-space that faces up. Walls and
/// cushions are half-spaces too, but nothing extends behind them.
pub(super) fn is_ground(body: &Body, options: &RenderOptions) -> bool {
    let up = (body.pose.orientation * DVec3::Y).y;
    let asked = options.parts.ground && options.ground != GroundSound::None;
    asked
        && match *body.surface {
            Surface::HalfSpace => up > FACING_UP,
            Surface::Plate { .. } => true,
            Surface::Sphere { .. } | Surface::Mesh(_) => false,
        }
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
        let same = grounds.iter().find(|(id, _)| {
            let other = &bodies[id.index()];
            other.material == body.material && other.surface == body.surface
        });
        let source = match same {
            Some((_, source)) => source.clone(),
            None => match (&*body.surface, options.ground) {
                (Surface::Plate { thickness }, _) => {
                    Ground::Plate(Arc::new(PlateSource::try_new(&body.material, *thickness, medium)?))
                }
                (_, GroundSound::Slab) => {
                    Ground::Reference(Arc::new(SlabSource::try_new(&presets::CONCRETE.material(), medium)?))
                }
                _ => Ground::HalfSpace(Arc::new(GroundSource::try_new(&body.material, medium)?)),
            },
        };
        grounds.insert(BodyId(index as u32), source);
    }
    Ok(grounds)
}
