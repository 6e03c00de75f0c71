//! Exact event-driven spheres.

use std::ops::ControlFlow;

use clangor::body::World;

use crate::record::Recorder;
use crate::{SimulationError, SimulationSettings};

pub(crate) fn simulate(
    _world: &World,
    _settings: &SimulationSettings,
    _recorder: &mut Recorder<'_>,
    _progress: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<(), SimulationError> {
    Ok(())
}
