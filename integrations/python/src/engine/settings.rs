//! Settings of the real-time engine.

use clangor::realtime::EngineSettings;
use clangor::synthesis::SampleRate;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::numbers::number;
use crate::session::Session;
use crate::settings::{check_keywords, keyword, named};

/// Most slots: as many objects as the ring of events takes.
const MOST_OBJECTS: usize = 8192;
/// Blocks that the engine supports [samples].
const BLOCKS: std::ops::RangeInclusive<usize> = 16..=4096;

const KEYWORDS: &[&str] = &["sample_rate", "block", "objects", "reach", "max_frequency", "scene"];

/// Settings of an engine for so many listeners.
pub(super) fn settings(listeners: usize, options: Option<&Bound<'_, PyDict>>) -> PyResult<EngineSettings> {
    let usual = EngineSettings::default();
    let Some(options) = options else { return Ok(usual.with_receivers(listeners)) };
    check_keywords(options, KEYWORDS)?;
    let mut settings = from_scene(options)?.unwrap_or(usual).with_receivers(listeners);
    if let Some(hz) = keyword::<u32>(options, "sample_rate")? {
        settings.sample_rate = SampleRate::try_new(hz)
            .map_err(|error| PyValueError::new_err(format!("sample_rate: {error}")))?;
    }
    let counts =
        [("block", BLOCKS, &mut settings.block), ("objects", 1..=MOST_OBJECTS, &mut settings.objects)];
    for (name, range, setting) in counts {
        let Some(count) = keyword::<usize>(options, name)? else { continue };
        if !range.contains(&count) {
            let (least, most) = (range.start(), range.end());
            return Err(PyValueError::new_err(format!("{name} is {count}; it can be {least} to {most}")));
        }
        *setting = count;
    }
    if let Some(reach) = number(options, "reach")? {
        if !(reach > 0.0 && reach <= 1000.0) {
            return Err(PyValueError::new_err(format!("reach is {reach} m; it can be up to 1000 m")));
        }
        settings.reach = reach;
    }
    settings.acoustics.max_frequency = number(options, "max_frequency")?.or(settings.acoustics.max_frequency);
    Ok(settings)
}

/// Acoustics and force profile of the scene in the options, if there is one.
fn from_scene(options: &Bound<'_, PyDict>) -> PyResult<Option<EngineSettings>> {
    let Some(scene) = options.get_item("scene")?.filter(|scene| !scene.is_none()) else { return Ok(None) };
    let session = scene.cast::<Session>().map_err(|error| named("scene", error))?;
    let inner = session.get().lock()?;
    match inner.scene() {
        Some(loaded) => Ok(Some(EngineSettings::from_scene(&loaded.scene))),
        None => Err(PyValueError::new_err("scene: this session is of a timeline, not of a scene")),
    }
}
