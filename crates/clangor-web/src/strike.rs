//! Impacts on loaded objects: the page hits an object with a ball, and the events of that impact come out.
//!
//! An instance of its own on the page's main thread, so that neither the world nor the audio thread computes
//! forces. [`Striker`] computes them. The objects rest at their places with the axes of their files; their
//! supports are so soft that they vibrate as free bodies, and their rigid motion is neglected.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::sync::Arc;

use clangor_core::body::Body;
use clangor_core::contact::ForceSettings;
use clangor_core::material::presets::PRESETS;
use clangor_core::pose::Pose;
use clangor_core::realtime::{ImpactEvent, ImpactTarget, event_row};
use clangor_core::synthesis::modal::ModalSource;
use clangor_core::synthesis::object_file::{ObjectError, ObjectFile};
use clangor_core::synthesis::strike::{StrikeError, Striker};
use glam::DVec3;
use serde_json::json;

use crate::layout::{CONTACT_STRIDE, contact_row};
use crate::wasm_buffer::{self, status};

/// Numbers of a strike in the buffer: radius \[m\] and speed [m/s] of the ball, centre of mass of the object
/// \[m\], point of the impact \[m\].
pub const STRIKE_NUMBERS: usize = 8;

thread_local! {
    static STATE: RefCell<State> = RefCell::default();
}

#[derive(Default)]
struct State {
    objects: BTreeMap<u32, Object>,
    events: Vec<f64>,
    contact: [f64; CONTACT_STRIDE],
}

/// An object that can be struck.
struct Object {
    body: Body,
    modes: Option<Arc<ModalSource>>,
}

/// Error in a strike of the page.
#[derive(Debug, thiserror::Error)]
enum PageStrikeError {
    #[error(transparent)]
    Object(#[from] ObjectError),
    #[error(transparent)]
    Strike(#[from] StrikeError),
    #[error("there is no object in slot {0} to be struck")]
    Slot(u32),
    #[error("there is no material {index}; there are {count}")]
    UnknownMaterial { index: u32, count: usize },
}

impl State {
    fn load(&mut self, slot: u32, bytes: &[u8]) -> Result<i32, PageStrikeError> {
        let file = ObjectFile::decode(bytes)?;
        let object = Object { body: file.body()?, modes: file.modal_source(None)? };
        self.objects.insert(slot, object);
        Ok(0)
    }

    fn strike(
        &mut self,
        slot: u32,
        material: u32,
        [radius, speed, x, y, z, px, py, pz]: [f64; STRIKE_NUMBERS],
    ) -> Result<i32, PageStrikeError> {
        let Object { body, modes } = self.objects.get(&slot).ok_or(PageStrikeError::Slot(slot))?;
        let preset = PRESETS.get(material as usize);
        let unknown = PageStrikeError::UnknownMaterial { index: material, count: PRESETS.len() };
        let striker = Striker::new(preset.ok_or(unknown)?.material(), radius, speed);
        let body = body.clone().at(Pose::at(DVec3::new(x, y, z)));
        let point = DVec3::new(px, py, pz);
        let settings = ForceSettings::default().live();
        let pulses = striker.forces_on(&body, modes.as_deref(), point, &settings)?;
        // The object with its modes, and the ball, which only accelerates.
        let targets = [ImpactTarget::Object { slot: slot as usize }, ImpactTarget::Sphere { radius }];
        let events = pulses.iter().flat_map(|pulse| {
            let of_side = |(side, target)| ImpactEvent::of_side(target, pulse, side);
            targets.into_iter().enumerate().flat_map(of_side)
        });
        self.events.clear();
        let mut encoder = event_row::RowEncoder::default();
        let rows = events.flat_map(|event| encoder.encode(&event.into(), slot));
        self.events.extend(rows.flatten());
        let [pulse, ..] = &pulses[..] else { return Ok(0) };
        self.contact = contact_row(pulse, [f64::from(slot), -1.0]);
        Ok((self.events.len() / event_row::ROW) as i32)
    }
}

/// Loads the sound model in the buffer, a file of `clangor bake` of so many bytes, as the object of a slot.
/// Its material must be one of the library.
pub fn strike_load(slot: u32, bytes: u32) -> i32 {
    let bytes = wasm_buffer::bytes(bytes);
    STATE.with_borrow_mut(|state| status(state.load(slot, &bytes)))
}

/// Sets the message to the names of the materials of a striker, a JSON list in the order of their indices.
/// Returns their number.
pub fn strike_materials() -> i32 {
    let names: Vec<_> = PRESETS.iter().map(|preset| preset.name).collect();
    wasm_buffer::tell(json!(names).to_string());
    names.len() as i32
}

/// Hits the object of a slot with a ball of a material, by the [`STRIKE_NUMBERS`] numbers in the buffer.
/// Returns the number of rows.
pub fn strike_impact(slot: u32, material: u32) -> i32 {
    let numbers = wasm_buffer::with_words(|words| {
        let first = words.first_chunk::<STRIKE_NUMBERS>().copied();
        first.unwrap_or_default().map(f64::from_bits)
    });
    STATE.with_borrow_mut(|state| status(state.strike(slot, material, numbers)))
}

/// The rows of the events of the last impact, at time 0: on the object, then on the ball.
pub fn strike_events() -> *const f64 {
    STATE.with_borrow(|state| state.events.as_ptr())
}

/// The contact of the last impact, between the slot and −1.
pub fn strike_contact() -> *const f64 {
    STATE.with_borrow(|state| state.contact.as_ptr())
}

/// Calls `read` with the events and the contact of the last impact.
pub fn with_impact<T>(read: impl FnOnce(&[f64], &[f64]) -> T) -> T {
    STATE.with_borrow(|state| read(&state.events, &state.contact))
}
