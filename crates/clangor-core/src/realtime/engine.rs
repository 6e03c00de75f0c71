//! The audio thread's part: composes the scheduler, the object table and the renderer.

use glam::DVec3;

use super::block_renderer::BlockRenderer;
use super::controller::{Controller, EngineChannels, channels};
use super::engine_settings::{EngineSettings, LONGEST_BLOCK};
use super::event::{Event, ImpactEvent, ImpactTarget, Part, is_within_limits};
use super::object_table::{MOST_RETIRING, ObjectTable};
use super::report::Report;
use super::scheduler::{Admission, Onset, Scheduler};
use super::sounding_object::SoundingObject;
use crate::synthesis::modal::live_pose::LivePose;
use crate::synthesis::{SoundSource, SynthesisError};

/// Renders pressure at the receivers, block by block, on the audio thread.
///
/// Made by [`engine`], together with the [`Controller`] that sends it events.
pub struct Engine {
    channels: EngineChannels,
    scheduler: Scheduler,
    objects: ObjectTable,
    renderer: BlockRenderer,
    /// The samples asked for.
    output: Vec<Vec<f64>>,
    /// Largest pressure in them \[Pa\].
    peak: f64,
}

/// An engine, and its controller for another thread.
///
/// # Errors
/// [`SynthesisError`] for a medium, band or room out of range.
pub fn engine(settings: &EngineSettings) -> Result<(Controller, Engine), SynthesisError> {
    let settings = settings.clamped();
    let renderer = BlockRenderer::new(&settings)?;
    let (controller, channels) = channels(MOST_RETIRING);
    let engine = Engine {
        channels,
        scheduler: Scheduler::new(&settings),
        objects: ObjectTable::new(&settings, renderer.path_count()),
        renderer,
        output: (0..settings.receivers).map(|_| vec![0.0; LONGEST_BLOCK]).collect(),
        peak: 0.0,
    };
    Ok((controller, engine))
}

impl Engine {
    /// Delay from the time of an event to its sound at a receiver that touches the body \[s\]; constant.
    pub fn latency(&self) -> f64 {
        self.scheduler.latency()
    }

    /// Time of the sample that is rendered next \[s\].
    pub fn time(&self) -> f64 {
        self.scheduler.time()
    }

    /// Counts of the events so far.
    pub fn report(&self) -> Report {
        let (events, objects, pulses) =
            (self.scheduler.counts, self.objects.counts, self.renderer.pulses.report());
        let [distant, shed, masked] = self.renderer.wave_counts();
        Report {
            taken: events.taken,
            lost: 0,
            refused: events.refused + pulses.refused,
            late: events.late,
            simplified: events.simplified,
            waves: pulses.waves,
            distant: distant + pulses.distant,
            shed: events.shed + shed,
            masked,
            inside: pulses.inside,
            shed_voices: objects.shed_voices,
            voices: objects.voices,
            modes: objects.modes,
            peak: self.peak,
            time: self.time(),
        }
    }

    /// Renders the next samples: pressure \[Pa\] at each receiver, `frames` samples but 4096 at most.
    ///
    /// # Real time
    /// Never allocates, frees or waits. Work is bounded by the [`Budget`](super::Budget) and by the capacity
    /// of the ring of events.
    pub fn render(&mut self, frames: usize) -> &[Vec<f64>] {
        let frames = frames.clamp(1, LONGEST_BLOCK);
        self.take_events();
        self.output.iter_mut().for_each(Vec::clear);
        while self.output[0].len() < frames {
            let part = self.scheduler.part_of(frames - self.output[0].len());
            // The fade to silence ends with a block: nothing new is heard before its end.
            self.render_block(self.renderer.stopping().map_or(part, |left| part.min(left.max(1))));
            let blocks = self.output.iter_mut().zip(self.renderer.channels());
            blocks.for_each(|(output, block)| output.extend_from_slice(block));
        }
        self.peak = self.output.iter().flatten().fold(0.0, |peak: f64, p| peak.max(p.abs()));
        self.channels.report.write(self.report());
        &self.output
    }

    fn render_block(&mut self, frames: usize) {
        let budget = self.scheduler.begin_block(frames);
        let position = self.scheduler.position();
        let end = position + frames as i64;
        while self.renderer.stopping().is_none()
            && let Some(event) = self.scheduler.next_event(end)
        {
            self.apply(event);
        }
        self.renderer.begin_block(frames);
        self.renderer.render_waves(end, &mut self.scheduler.credit.waves);
        self.objects.limit_modes(budget.mode_paths);
        let (block, mut outputs) = self.renderer.voice_block(position, frames);
        self.objects.render(&block, budget.transfers, &mut outputs);
        self.renderer.reverberate(frames);
        if self.renderer.fade(frames) {
            self.objects.silence();
        }
        self.scheduler.advance_to(end);
        while let Some(object) = self.objects.take_silent(&mut self.renderer.pulses, end) {
            self.channels.return_object(object);
        }
    }

    /// Takes the events in the ring.
    fn take_events(&mut self) {
        // No more than are there now: a fast sender must not keep the audio thread in this loop.
        for _ in 0..self.channels.events.slots() {
            let Ok(event) = self.channels.events.pop() else { break };
            match self.scheduler.admit(event, |slot| self.objects.is_empty(slot)) {
                Admission::Scheduled => {}
                Admission::Immediate(event) => self.apply(event),
                Admission::Rejected(Event::Put { object: Some(object), .. }) => {
                    self.channels.return_object(object);
                }
                Admission::Rejected(_) => {}
            }
        }
    }

    /// Applies an event whose time has come.
    fn apply(&mut self, event: Event) {
        match event {
            Event::Impact(impact) => self.impact(&impact),
            Event::Pose { slot, time, pose, velocity, angular_velocity } => {
                let sample = self.scheduler.audible_sample(time);
                let motion = LivePose { sample, pose, velocity, angular_velocity };
                let is_there = self.objects.set_pose(slot, motion);
                self.count_refused(!is_there);
            }
            Event::End { slot, .. } => self.objects.end(slot),
            Event::Receivers(places) => {
                let good = places.into_iter().all(is_within_limits);
                if good {
                    self.renderer.receivers.set_targets(places);
                }
                self.count_refused(!good);
            }
            Event::Switch(part, on) => {
                if part == Part::Modal && !on {
                    self.objects.end_all();
                }
                self.renderer.switch(part, on);
            }
            Event::Silence => {
                // Impacts are dropped; motion and slots stay correct.
                while let Some(event) = self.scheduler.next_of_all() {
                    if !matches!(event, Event::Impact(_)) {
                        self.apply(event);
                    }
                }
                self.renderer.stop();
            }
            Event::Put { slot, object } => self.put(slot, object),
        }
    }

    fn count_refused(&mut self, is_refused: bool) {
        self.scheduler.counts.refused += u64::from(is_refused);
    }

    /// Puts an object into a slot; one that is rejected goes back to the controller.
    fn put(&mut self, slot: usize, object: Option<Box<SoundingObject>>) {
        let position = self.scheduler.position();
        let put = self.objects.put(slot, object, &mut self.renderer.pulses, position);
        self.count_refused(put.is_err());
        if let Err(Some(object)) = put {
            self.channels.return_object(object);
        }
    }

    /// Turns an impact into waves of an acceleration pulse and a force on modes.
    fn impact(&mut self, impact: &ImpactEvent) {
        let onset = self.scheduler.onset(impact.time);
        let (source, radius) = match impact.target {
            ImpactTarget::Sphere { radius } => (Some(SoundSource::Sphere { radius }), radius),
            ImpactTarget::Object { slot } => {
                self.excite_modes(slot, impact, &onset);
                let Some(object) = self.objects.object(slot) else {
                    return self.count_refused(true);
                };
                (object.source.clone(), object.radius)
            }
        };
        let moves = impact.velocity_change != DVec3::ZERO || impact.angular_velocity_change != DVec3::ZERO;
        if let Some(source) = source.filter(|_| moves && self.renderer.renders(Part::Acceleration)) {
            self.renderer.send_waves(impact, &onset, source, radius);
        }
    }

    /// Lets the impulse act on the modes of the object in a slot, now or, beyond the budget, in a later
    /// block.
    fn excite_modes(&mut self, slot: usize, impact: &ImpactEvent, onset: &Onset) {
        let Engine { scheduler, objects, renderer, .. } = self;
        let Some(object) = objects.object(slot) else { return };
        let impulse = impact.pose.orientation.inverse() * impact.impulse;
        if !renderer.renders(Part::Modal) || impulse == DVec3::ZERO {
            return;
        }
        let Some(voice) = &mut object.voice else { return };
        voice.stand(onset.sample, impact.pose);
        let transfers = if voice.awake_modes() == 0 { object.transfer_work } else { 0 };
        let allowed = scheduler.credit.allows(transfers);
        let force = if allowed { renderer.force(onset, impact) } else { None };
        let point = impact.pose.body_from_world(impact.point);
        let work = force.as_ref().map_or(0, |force| force.work);
        let strikes = |force| voice.strike(&force, &[(point, impulse)], scheduler.position());
        if force.is_some_and(strikes) {
            scheduler.credit.spend(work, transfers);
        } else {
            scheduler.postpone(impact, onset, !allowed);
        }
    }
}
