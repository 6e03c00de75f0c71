//! The planes of a world that sound when they are hit: those that face up.

use std::collections::BTreeMap;
use std::sync::Arc;

use clangor::body::{Body, BodyId, Surface};
use clangor::glam::DVec3;
use clangor::medium::Medium;
use clangor::scene::render_settings::GroundSound;
use clangor::synthesis::ground::{GroundError, GroundSource};

/// Cosine of the steepest slope that is ground.
const FACING_UP: f64 = 0.9;

/// Whether a body is ground: walls and cushions are planes too, but nothing extends behind them.
pub(super) fn is_ground(body: &Body) -> bool {
    let up = (body.pose.orientation * DVec3::Y).y;
    matches!(*body.surface, Surface::HalfSpace) && up > FACING_UP
}

/// The grounds among the bodies; those of one material share their sound.
pub(super) fn grounds(
    bodies: &[Body],
    medium: &Medium,
    sound: GroundSound,
) -> Result<BTreeMap<BodyId, Arc<GroundSource>>, GroundError> {
    let mut grounds: BTreeMap<BodyId, Arc<GroundSource>> = BTreeMap::new();
    let planes =
        bodies.iter().enumerate().filter(|(_, body)| sound == GroundSound::HalfSpace && is_ground(body));
    for (index, body) in planes {
        let same = grounds.iter().find(|(id, _)| bodies[id.index()].material == body.material);
        let source = match same {
            Some((_, source)) => Arc::clone(source),
            None => Arc::new(GroundSource::try_new(&body.material, medium)?),
        };
        grounds.insert(BodyId(index as u32), source);
    }
    Ok(grounds)
}
