//! The objects of an engine: slots, objects that leave their slots and are heard to their end, and the share
//! of the budget that each gets.

use super::engine_settings::{EngineSettings, LONGEST_BLOCK};
use super::sounding_object::{ObjectShape, SoundingObject};
use crate::synthesis::live_pulses::LivePulses;
use crate::synthesis::modal::live_pose::LivePose;
use crate::synthesis::modal::live_voice::{LiveBlock, LiveOutputs, LiveVoice};

/// Largest number of objects that have left their slots and are still heard.
pub(super) const MOST_RETIRING: usize = 32;

/// An object that left its slot, is heard to its end, and is then freed.
struct RetiringObject {
    object: Box<SoundingObject>,
    /// Sample from which on no acceleration pulse in progress refers to it.
    until: i64,
}

/// An object in its slot.
struct ObjectSlot {
    object: Box<SoundingObject>,
    /// Transfer coefficients granted while the object waited for an update of its transfers.
    credit: usize,
}

/// Counts of the table.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ObjectCounts {
    pub(super) voices: u64,
    pub(super) modes: u64,
    pub(super) shed_voices: u64,
}

/// See the module.
pub(super) struct ObjectTable {
    slots: Vec<Option<ObjectSlot>>,
    /// The places of their fields are behind those of the slots.
    retiring: [Option<RetiringObject>; MOST_RETIRING],
    /// The slot whose transfers are updated first.
    first: usize,
    /// Settings for which objects must have been made.
    shape: ObjectShape,
    /// Samples after which no acceleration pulse of a retired object is in progress.
    retirement: i64,
    pub(super) counts: ObjectCounts,
}

/// All voices in slots.
fn voices(slots: &mut [Option<ObjectSlot>]) -> impl Iterator<Item = &mut LiveVoice> {
    slots.iter_mut().flatten().filter_map(|slot| slot.object.voice.as_deref_mut())
}

impl ObjectTable {
    /// Empty slots, for objects made for these settings and so many paths.
    pub(super) fn new(settings: &EngineSettings, paths: usize) -> Self {
        let reach = (settings.longest_delay() * settings.sample_rate.as_f64()) as usize;
        ObjectTable {
            slots: (0..settings.objects).map(|_| None).collect(),
            retiring: [const { None }; MOST_RETIRING],
            first: 0,
            shape: ObjectShape::new(settings, paths),
            retirement: (reach + 2 * LONGEST_BLOCK) as i64,
            counts: ObjectCounts::default(),
        }
    }

    /// Whether a slot exists and is empty.
    pub(super) fn is_empty(&self, slot: usize) -> bool {
        self.slots.get(slot).is_some_and(Option::is_none)
    }

    /// The object in a slot.
    pub(super) fn object(&mut self, slot: usize) -> Option<&mut SoundingObject> {
        self.slots.get_mut(slot)?.as_mut().map(|slot| &mut *slot.object)
    }

    /// Puts an object into a slot, or empties it; what was there retires at a sample. Returns the object if
    /// there is no such slot, too many are retiring, or it was made for other settings.
    pub(super) fn put(
        &mut self,
        slot: usize,
        mut object: Option<Box<SoundingObject>>,
        pulses: &mut LivePulses,
        position: i64,
    ) -> Result<(), Option<Box<SoundingObject>>> {
        let fits = object.as_ref().is_none_or(|object| object.fits(&self.shape));
        let free = self.retiring.iter().position(Option::is_none);
        let count = self.slots.len();
        let (Some(held), Some(free), true) = (self.slots.get_mut(slot), free, fits) else {
            return Err(object);
        };
        let field = object.as_mut().and_then(|object| object.field.take());
        let before = pulses.put_field(slot, field);
        let new = object.map(|object| ObjectSlot { object, credit: 0 });
        if let Some(ObjectSlot { mut object, .. }) = std::mem::replace(held, new) {
            // Its acceleration pulses in progress go on.
            pulses.put_field(count + free, before);
            if let Some(voice) = &mut object.voice {
                voice.end();
            }
            let until = position + self.retirement;
            self.retiring[free] = Some(RetiringObject { object, until });
        }
        Ok(())
    }

    /// The next object that is no longer heard at a sample.
    pub(super) fn take_silent(
        &mut self,
        pulses: &mut LivePulses,
        position: i64,
    ) -> Option<Box<SoundingObject>> {
        let over = |retiring: &mut RetiringObject| {
            let silent = retiring.object.voice.as_ref().is_none_or(|voice| voice.is_silent());
            silent && retiring.until <= position
        };
        let count = self.slots.len();
        self.retiring.iter_mut().enumerate().find_map(|(at, place)| {
            let RetiringObject { mut object, .. } = place.take_if(over)?;
            object.field = pulses.put_field(count + at, None);
            Some(object)
        })
    }

    /// Sets the motion of an object; whether there is one.
    pub(super) fn set_pose(&mut self, slot: usize, pose: LivePose) -> bool {
        let object = self.object(slot);
        let is_there = object.is_some();
        if let Some(voice) = object.and_then(|object| object.voice.as_mut()) {
            voice.set_pose(pose);
        }
        is_there
    }

    /// Fades out an object within the next block.
    pub(super) fn end(&mut self, slot: usize) {
        if let Some(voice) = self.object(slot).and_then(|object| object.voice.as_mut()) {
            voice.end();
        }
    }

    /// Fades out all objects within the next block.
    pub(super) fn end_all(&mut self) {
        voices(&mut self.slots).for_each(LiveVoice::end);
    }

    /// Silences all objects at once.
    pub(super) fn silence(&mut self) {
        voices(&mut self.slots).for_each(LiveVoice::silence);
        let retiring = self.retiring.iter_mut().flatten();
        retiring.filter_map(|retiring| retiring.object.voice.as_mut()).for_each(|voice| voice.silence());
    }

    /// Fades out the quietest objects until at most so many modes vibrate, times the paths of each.
    pub(super) fn limit_modes(&mut self, most: usize) {
        let audible = || self.slots.iter().flatten().filter_map(|slot| slot.object.voice.as_deref());
        let load: usize = audible().filter(|voice| !voice.is_ending()).map(LiveVoice::load).sum();
        self.counts.voices = audible().filter(|voice| !voice.is_silent()).count() as u64;
        self.counts.modes = audible().map(|voice| voice.awake_modes() as u64).sum();
        let mut excess = load.saturating_sub(most);
        while excess > 0 {
            let awake = voices(&mut self.slots).filter(|voice| voice.awake_modes() > 0 && !voice.is_ending());
            let Some(quietest) = awake.min_by(|a, b| a.loudness().total_cmp(&b.loudness())) else { break };
            excess = excess.saturating_sub(quietest.load());
            quietest.end();
            self.counts.shed_voices += 1;
        }
    }

    /// Adds the sound of all objects in a block. Transfers follow the motion of objects as long as
    /// `transfers` coefficients last; the first object that must wait is the first in the next block.
    pub(super) fn render(&mut self, block: &LiveBlock<'_>, transfers: usize, outputs: &mut LiveOutputs<'_>) {
        let (mut work, count) = (transfers, self.slots.len());
        let mut next_first = None;
        for k in 0..count {
            let at = (self.first + k) % count;
            let Some(ObjectSlot { object, credit }) = &mut self.slots[at] else { continue };
            let transfer_work = object.transfer_work;
            let Some(voice) = object.voice.as_mut().filter(|voice| !voice.is_silent()) else { continue };
            *credit += transfers;
            let may = work >= transfer_work || *credit >= transfer_work && work == transfers;
            if may {
                (work, *credit) = (work.saturating_sub(transfer_work), 0);
            } else if next_first.is_none() {
                next_first = Some(at);
            }
            voice.render(block, may, outputs);
        }
        for RetiringObject { object, .. } in self.retiring.iter_mut().flatten() {
            if let Some(voice) = &mut object.voice {
                voice.render(block, false, outputs);
            }
        }
        self.first = next_first.unwrap_or(0);
    }
}
