//! The audio thread's part: takes events as their time comes, and renders blocks.

use glam::DVec3;

use super::budget::Budget;
use super::event::{Event, ImpactEvent, ImpactTarget, MOST_RECEIVERS, Part, is_pose, is_within_limits};
use super::event_ring::{EngineChannels, Report};
use super::schedule::Schedule;
use super::sounding_object::SoundingObject;
use super::wave_queue::{QueuedWave, WaveQueue, strength};
use crate::body::BodyId;
use crate::contact::ForceProfile;
use crate::medium::Medium;
use crate::propagation::{Air, LateReverberation, Room};
use crate::scene::Scene;
use crate::synthesis::listener::Floor;
use crate::synthesis::live_pulses::{LOOK_AHEAD as CLICK_LOOK_AHEAD, LivePulses};
use crate::synthesis::modal::live_voice::{
    LOOK_AHEAD as FORCE_LOOK_AHEAD, LiveForces, LiveOutputs, LivePose, LiveVoice,
};
use crate::synthesis::propagation_paths::PropagationPaths;
use crate::synthesis::{AccelerationPulse, RenderSettings, SampleRate, SoundSource, SynthesisError};

/// Longest block \[samples\].
pub const LONGEST_BLOCK: usize = 4096;
/// Samples that clicks and forces look ahead.
const LOOK_AHEAD: usize =
    if CLICK_LOOK_AHEAD > FORCE_LOOK_AHEAD { CLICK_LOOK_AHEAD } else { FORCE_LOOK_AHEAD };
/// Events and waves that wait for their time, at most.
const MOST_WAITING: usize = 8192;
/// Objects that were taken from their slots and are still heard, at most.
pub(super) const LEAVING: usize = 32;
/// Farthest that sound is waited for \[m\].
const FARTHEST: f64 = 1000.0;
/// Shortest block \[samples\].
const SHORTEST_BLOCK: usize = 16;
/// Events are refused from so far ahead \[s\].
const HORIZON: f64 = 60.0;
/// Time in which receivers follow \[s\].
const FOLLOWING: f64 = 0.02;
/// Beyond this they are there at once \[m\].
const JUMP: f64 = 1.0;
/// Time in which everything stops when it is to \[s\].
const FADE: f64 = 1e-3;
/// How long an impact on an object may wait until there is room for it \[s\].
const LONGEST_WAIT: f64 = 0.03;
/// Impacts on ringing objects whose forces are in progress at once.
const FORCES: usize = 512;

/// How a live engine is built.
#[derive(Clone, Debug)]
pub struct EngineSettings {
    /// Samples per second.
    pub sample_rate: SampleRate,
    /// Highest frequency that is heard in full \[Hz\]; by default what the sample rate holds.
    pub max_frequency: Option<f64>,
    /// What carries the sound.
    pub medium: Medium,
    /// What reflects it, where there is no room.
    pub floor: Floor,
    /// What reflects it.
    pub room: Option<Room>,
    /// What takes from it on the path.
    pub air: Option<Air>,
    /// How forces run.
    pub profile: ForceProfile,
    /// Receivers: 1, or 2 for two ears.
    pub receivers: usize,
    /// The length of block for which all events of the block before come in time \[samples\].
    pub block: usize,
    /// How far sound is heard \[m\], reflections of a room included: at least to all of them.
    pub reach: f64,
    /// Slots for objects.
    pub objects: usize,
    /// How much a block may compute.
    pub budget: Budget,
}

impl Default for EngineSettings {
    fn default() -> Self {
        EngineSettings {
            sample_rate: SampleRate::default(),
            max_frequency: None,
            medium: Medium::default(),
            floor: Floor::None,
            room: None,
            air: None,
            profile: ForceProfile::HalfSine,
            receivers: 2,
            block: 128,
            reach: 40.0,
            objects: 64,
            budget: Budget::default(),
        }
    }
}

impl EngineSettings {
    /// As a scene wants to be rendered: its medium, floor, room, air and forces.
    pub fn from_scene(scene: &Scene) -> Self {
        let render = &scene.render;
        EngineSettings {
            max_frequency: render.max_frequency,
            medium: scene.medium,
            floor: render.floor,
            room: render.room.clone(),
            air: render.air,
            profile: render.pulse,
            ..EngineSettings::default()
        }
    }

    /// The same with what can be: 1 or 2 receivers, blocks of 16 to 4096 samples, a reach up to 1 km that
    /// holds the reflections of the room.
    #[must_use]
    pub fn clamped(&self) -> Self {
        let reflected = self
            .room
            .as_ref()
            .map_or(0.0, |room| room.extent().length() * f64::from(room.image_order.max(1) + 1));
        let reach = if self.reach > 0.0 { self.reach } else { EngineSettings::default().reach };
        EngineSettings {
            receivers: self.receivers.clamp(1, MOST_RECEIVERS),
            block: self.block.clamp(SHORTEST_BLOCK, LONGEST_BLOCK),
            reach: reach.max(reflected).min(FARTHEST),
            ..self.clone()
        }
    }

    /// As clicks and voices are rendered.
    pub(super) fn rendering(&self) -> RenderSettings {
        let EngineSettings { sample_rate, max_frequency, medium, .. } = *self;
        RenderSettings { sample_rate, max_frequency, medium, ..RenderSettings::default() }
    }

    /// The paths by which receivers hear.
    pub(super) fn paths(&self) -> PropagationPaths {
        PropagationPaths::new(self.floor, self.room.clone(), self.air)
    }

    /// How long sound may be on its path \[s\].
    pub(super) fn longest_delay(&self) -> f64 {
        self.reach / self.medium.sound_speed
    }
}

/// An object that left its slot, is heard to its end, and is then freed.
struct RetiringObject {
    object: Box<SoundingObject>,
    /// Sample from which on no click in progress refers to it.
    until: i64,
}

/// An object in its slot.
struct ObjectSlot {
    object: Box<SoundingObject>,
    /// Share of the work for the motion of objects that this one has been waiting for.
    owed: usize,
}

/// See the module.
pub struct Engine {
    settings: EngineSettings,
    links: EngineChannels,
    /// Sample that is rendered next.
    position: i64,
    /// Poses, ends and impacts to come.
    scheduled: Schedule<Event>,
    paths: PropagationPaths,
    clicks: LivePulses,
    waves: WaveQueue,
    forces: LiveForces,
    seats: Vec<Option<ObjectSlot>>,
    /// Their fields have the places behind those of the slots.
    leaving: [Option<RetiringObject>; LEAVING],
    /// The seat that is first to follow its motion.
    turn: usize,
    reverberation: Option<LateReverberation>,
    receivers: Vec<DVec3>,
    targets: Vec<DVec3>,
    placed: bool,
    heard: [bool; 3],
    /// Samples until everything has stopped.
    stopping: Option<usize>,
    impacts_left: usize,
    /// Coefficients that objects which begin to ring may still take in this block.
    waking_left: usize,
    /// Whether one has begun to in this block.
    woke: bool,
    /// What was asked for.
    output: Vec<Vec<f64>>,
    /// A block of it.
    channels: Vec<Vec<f64>>,
    entering: Vec<Vec<f64>>,
    late: Vec<f64>,
    /// What became of the events, but for what the parts count themselves.
    counts: Report,
}

/// All that rings or can.
fn voices(seats: &mut [Option<ObjectSlot>]) -> impl Iterator<Item = &mut LiveVoice> {
    seats.iter_mut().flatten().filter_map(|seat| seat.object.voice.as_deref_mut())
}

impl Engine {
    pub(super) fn new(settings: &EngineSettings, links: EngineChannels) -> Result<Self, SynthesisError> {
        let settings = settings.clamped();
        let rendering = settings.rendering();
        let paths = settings.paths();
        let reverberation = match &settings.room {
            Some(room) if room.late => Some(LateReverberation::new(
                room,
                settings.air.as_ref(),
                settings.medium.sound_speed,
                settings.sample_rate.as_f64(),
            )?),
            Some(room) => room.check().map(|()| None)?,
            None => None,
        };
        let inputs = LateReverberation::INPUTS;
        let outputs = settings.receivers + inputs;
        let clicks = LivePulses::new(
            &rendering,
            paths.losses(),
            settings.objects + LEAVING,
            outputs,
            settings.longest_delay() + 0.1,
        )?;
        let silent = |count: usize, length: usize| (0..count).map(|_| vec![0.0; length]).collect::<Vec<_>>();
        Ok(Engine {
            links,
            position: 0,
            scheduled: Schedule::new(MOST_WAITING),
            clicks,
            waves: WaveQueue::new(MOST_WAITING),
            forces: LiveForces::new(&rendering, FORCES),
            seats: (0..settings.objects).map(|_| None).collect(),
            leaving: [const { None }; LEAVING],
            turn: 0,
            reverberation,
            receivers: vec![DVec3::ZERO; settings.receivers],
            targets: vec![DVec3::ZERO; settings.receivers],
            placed: false,
            heard: [true; 3],
            stopping: None,
            impacts_left: 0,
            waking_left: 0,
            woke: false,
            output: silent(settings.receivers, LONGEST_BLOCK),
            channels: silent(settings.receivers, settings.block),
            entering: silent(inputs, settings.block),
            late: vec![0.0; settings.receivers],
            counts: Report::default(),
            paths,
            settings,
        })
    }

    /// From the time of an event until it is heard by a receiver that it touches \[s\]; always the same.
    pub fn latency(&self) -> f64 {
        self.latency_samples() as f64 / self.settings.sample_rate.as_f64()
    }

    fn latency_samples(&self) -> usize {
        self.settings.block + LOOK_AHEAD
    }

    /// Time of the sample that is rendered next \[s\].
    pub fn time(&self) -> f64 {
        self.position as f64 / self.settings.sample_rate.as_f64()
    }

    /// What became of the events so far.
    pub fn report(&self) -> Report {
        let (clicks, shed) = (self.clicks.report(), self.waves.shed);
        Report {
            waves: clicks.waves,
            inside: clicks.inside,
            distant: self.counts.distant + clicks.distant,
            refused: self.counts.refused + clicks.refused,
            shed: self.counts.shed + shed.audible,
            masked: shed.masked,
            time: self.time(),
            ..self.counts
        }
    }

    /// Renders the next samples: pressure \[Pa\] at each receiver, as many as asked for but 4096 at most.
    ///
    /// # Real time
    /// Allocates, frees and waits for nothing. Work is bounded by the [`Budget`], and by the events that the
    /// ring holds.
    pub fn render(&mut self, frames: usize) -> &[Vec<f64>] {
        let frames = frames.clamp(1, LONGEST_BLOCK);
        self.take_events();
        self.output.iter_mut().for_each(Vec::clear);
        while self.output[0].len() < frames {
            // Of even lengths: what fades does so within a block.
            let left = frames - self.output[0].len();
            let even = left.div_ceil(left.div_ceil(self.settings.block));
            // Whoever wants silence has it before anything else is heard.
            self.render_block(self.stopping.map_or(even, |stopping| even.min(stopping.max(1))));
            let blocks = self.output.iter_mut().zip(&self.channels);
            blocks.for_each(|(output, block)| output.extend_from_slice(block));
        }
        self.counts.peak = self.output.iter().flatten().fold(0.0, |peak: f64, p| peak.max(p.abs()));
        self.links.report.write(self.report());
        &self.output
    }

    fn render_block(&mut self, frames: usize) {
        let budget = self.settings.budget.of(frames);
        (self.impacts_left, self.waking_left, self.woke) = (budget.impacts, 4 * budget.transfers, false);
        let end = self.position + frames as i64;
        // What begins in the next block must be known in this one.
        while self.stopping.is_none()
            && let Some(event) = self.scheduled.next_before(end + LOOK_AHEAD as i64)
        {
            self.happen(event);
        }
        self.follow(frames);
        for samples in self.channels.iter_mut().chain(&mut self.entering) {
            samples.resize(frames, 0.0);
            samples.fill(0.0);
        }
        self.render_clicks(end, &budget);
        self.render_voices(frames, &budget);
        self.reverberate(frames);
        self.fade(frames);
        self.position = end;
        self.give_back();
    }

    /// Takes what the ring holds.
    fn take_events(&mut self) {
        // No more than there were, or a sender faster than this loop would hold it for ever.
        for _ in 0..self.links.events.slots() {
            let Ok(event) = self.links.events.pop() else { break };
            self.take(event);
        }
    }

    fn take(&mut self, event: Event) {
        let time = match &event {
            Event::ImpactEvent(impact) if impact.is_good() => impact.time,
            Event::Pose { time, pose, velocity, angular_velocity, .. } => {
                let good =
                    is_pose(pose) && is_within_limits(*velocity) && is_within_limits(*angular_velocity);
                if good { *time } else { f64::NAN }
            }
            Event::End { time, .. } => *time,
            Event::ImpactEvent(_) => f64::NAN,
            // Nobody has heard of it yet.
            Event::Put { slot, .. } if self.seats.get(*slot).is_some_and(Option::is_none) => {
                return self.happen(event);
            }
            Event::Put { .. } => self.time(),
            _ => return self.happen(event),
        };
        let ahead = time - self.time();
        if ahead.is_nan() || ahead > HORIZON {
            self.counts.refused += 1;
            return;
        }
        // Impacts become waves and forces before they are heard; all else is done when it is heard.
        let early = if matches!(event, Event::Pose { .. } | Event::End { .. }) { LOOK_AHEAD } else { 0 };
        // Of what is long past only that it is past matters.
        let sample = (time.max(self.time() - 1.0) * self.settings.sample_rate.as_f64()).floor() as i64;
        let is_put = matches!(event, Event::Put { .. });
        match self.scheduled.add(sample + (self.latency_samples() + early) as i64, event) {
            Ok(()) => self.counts.taken += u64::from(!is_put),
            Err(Event::Put { object, .. }) => self.refuse(object),
            Err(_) => self.counts.shed += 1,
        }
    }

    /// Sends an object back that finds no place.
    fn refuse(&mut self, object: Option<Box<SoundingObject>>) {
        self.counts.refused += 1;
        if let Some(object) = object {
            // The ring has room for every object that can have been sent.
            let _ = self.links.returned.push(object);
        }
    }

    /// Lets an event happen whose time has come.
    fn happen(&mut self, event: Event) {
        match event {
            Event::ImpactEvent(impact) => self.strike(&impact),
            Event::Pose { slot, time, pose, velocity, angular_velocity } => {
                let sample = (time + self.latency()) * self.settings.sample_rate.as_f64();
                match self.seats.get_mut(slot).and_then(Option::as_mut) {
                    Some(ObjectSlot { object, .. }) => {
                        if let Some(voice) = &mut object.voice {
                            voice.set_pose(LivePose { sample, pose, velocity, angular_velocity });
                        }
                    }
                    None => self.counts.refused += 1,
                }
            }
            Event::End { slot, .. } => {
                let seat = self.seats.get_mut(slot).and_then(Option::as_mut);
                if let Some(voice) = seat.and_then(|seat| seat.object.voice.as_mut()) {
                    voice.end();
                }
            }
            Event::Receivers(places) => {
                if places.into_iter().all(is_within_limits) {
                    self.targets.iter_mut().zip(places).for_each(|(target, place)| *target = place);
                } else {
                    self.counts.refused += 1;
                }
            }
            Event::Switch(part, on) => {
                self.heard[part as usize] = on;
                if part == Part::Modal && !on {
                    voices(&mut self.seats).for_each(|voice| voice.end());
                }
                self.paths.set_reflections(self.hears(Part::Reflections));
            }
            Event::Silence => {
                // Where objects are stays true.
                while let Some(event) = self.scheduled.next_before(i64::MAX) {
                    if !matches!(event, Event::ImpactEvent(_)) {
                        self.happen(event);
                    }
                }
                self.waves.clear();
                let length = (FADE * self.settings.sample_rate.as_f64()) as usize;
                self.stopping.get_or_insert(length);
            }
            Event::Put { slot, object } => self.put(slot, object),
        }
    }

    fn hears(&self, part: Part) -> bool {
        self.heard[part as usize]
    }

    fn put(&mut self, slot: usize, mut object: Option<Box<SoundingObject>>) {
        let fits = object.as_ref().is_none_or(|object| object.fits(&self.settings, self.paths.count()));
        let free = self.leaving.iter().position(Option::is_none);
        let (Some(seat), Some(free), true) = (self.seats.get_mut(slot), free, fits) else {
            return self.refuse(object);
        };
        let field = object.as_mut().and_then(|object| object.field.take());
        let before = self.clicks.put_field(slot, field);
        if let Some(ObjectSlot { mut object, .. }) =
            std::mem::replace(seat, object.map(|object| ObjectSlot { object, owed: 0 }))
        {
            // Its clicks in progress go on.
            self.clicks.put_field(self.settings.objects + free, before);
            if let Some(voice) = &mut object.voice {
                voice.end();
            }
            let reach = (self.settings.longest_delay() * self.settings.sample_rate.as_f64()) as usize;
            let until = self.position + (reach + 2 * LONGEST_BLOCK) as i64;
            self.leaving[free] = Some(RetiringObject { object, until });
        }
    }

    /// An impact becomes waves and forces.
    fn strike(&mut self, impact: &ImpactEvent) {
        let rate = self.settings.sample_rate.as_f64();
        let wanted = impact.time + self.latency();
        let earliest = (self.position + LOOK_AHEAD as i64) as f64 / rate;
        // Less than a sample is rounding.
        self.counts.late += u64::from(wanted < earliest - 0.5 / rate);
        let time = wanted.max(earliest);
        let (source, radius) = match impact.struck {
            ImpactTarget::Sphere { radius } => (Some(SoundSource::Sphere { radius }), radius),
            ImpactTarget::Object { slot } => {
                let Some(ObjectSlot { object, .. }) = self.seats.get_mut(slot).and_then(Option::as_mut)
                else {
                    self.counts.refused += 1;
                    return;
                };
                let impulse = impact.pose.orientation.inverse() * impact.impulse;
                let rings = self.heard[Part::Modal as usize] && impulse != DVec3::ZERO;
                if let Some(voice) = object.voice.as_mut().filter(|_| rings) {
                    voice.stand(time * rate, impact.pose);
                    let waking = if voice.awake_modes() == 0 { object.transfer_work } else { 0 };
                    // However large, the first may always.
                    let may = self.impacts_left > 0 && (waking <= self.waking_left || !self.woke);
                    let force =
                        may.then(|| self.forces.impact(self.settings.profile, time * rate, impact.duration));
                    let point = impact.pose.body_from_world(impact.point);
                    let strikes = |force| voice.strike(&force, &[(point, impulse)], self.position);
                    if force.flatten().is_some_and(strikes) {
                        self.impacts_left -= 1;
                        self.waking_left = self.waking_left.saturating_sub(waking);
                        self.woke |= waking > 0;
                    } else {
                        // A little later is better than never.
                        let still = ImpactEvent {
                            velocity_change: DVec3::ZERO,
                            angular_velocity_change: DVec3::ZERO,
                            ..*impact
                        };
                        let next = self.position + (self.settings.block + LOOK_AHEAD) as i64;
                        let room = self.scheduled.len() < MOST_WAITING / 8;
                        let waits = !may && room && earliest - wanted < LONGEST_WAIT;
                        if !waits || self.scheduled.add(next, Event::ImpactEvent(still)).is_err() {
                            self.counts.shed += 1;
                        }
                    }
                }
                (object.click.clone(), object.radius)
            }
        };
        let moves = impact.velocity_change != DVec3::ZERO || impact.angular_velocity_change != DVec3::ZERO;
        let Some(source) = source.filter(|_| moves && self.hears(Part::Acceleration)) else { return };
        let click = AccelerationPulse {
            body: BodyId(0),
            time,
            duration: impact.duration,
            profile: self.settings.profile,
            centre: impact.pose.position,
            orientation: impact.pose.orientation,
            velocity_change: impact.velocity_change,
            angular_velocity_change: impact.angular_velocity_change,
            source,
        };
        self.send_waves(&click, radius);
    }

    /// Queues the waves of a click to all receivers.
    fn send_waves(&mut self, click: &AccelerationPulse, radius: f64) {
        for (receiver, place) in self.targets.iter().enumerate() {
            for path in 0..self.paths.count() {
                let Some(towards) = self.paths.towards(path, click.centre, *place) else { continue };
                if towards.length() > self.settings.reach {
                    self.counts.distant += 1;
                    continue;
                }
                if self.waves.is_full() {
                    self.waves.shed.audible += 1;
                    continue;
                }
                let Some(first) = self.clicks.first_sample(click, towards) else { continue };
                let strength = strength(click, radius, towards.length(), &self.settings.medium);
                self.waves.add(first, QueuedWave { click: click.clone(), towards, path, receiver, strength });
            }
        }
    }

    /// Receivers move on towards where they are to be.
    fn follow(&mut self, frames: usize) {
        let share = 1.0 - (-(frames as f64) / (FOLLOWING * self.settings.sample_rate.as_f64())).exp();
        for (place, target) in self.receivers.iter_mut().zip(&self.targets) {
            let path = *target - *place;
            let jumps = !self.placed || path.length() > JUMP || path.length() < 1e-6;
            *place = if jumps { *target } else { *place + path * share };
        }
        self.placed = true;
    }

    fn render_clicks(&mut self, end: i64, budget: &Budget) {
        let Engine { waves, clicks, paths, channels, entering, .. } = self;
        let receivers = channels.len();
        waves.play(end, budget.waves, |wave| {
            let QueuedWave { click, towards, path, receiver, .. } = wave;
            let input = paths.reverberation_input(*path).filter(|_| *receiver == 0);
            let into = [(*receiver, 1.0), (receivers + input.unwrap_or(0), towards.length())];
            let outputs = match (paths.is_heard(*path), input) {
                (true, Some(_)) => &into[..],
                (true, None) => &into[..1],
                (false, _) => &into[1..],
            };
            clicks.play(click, *towards, *path, outputs);
        });
        for (output, samples) in channels.iter_mut().chain(entering).enumerate() {
            clicks.take(output, samples);
        }
    }

    fn render_voices(&mut self, frames: usize, budget: &Budget) {
        self.limit_modes(budget.mode_paths);
        let (mut work, count) = (budget.transfers, self.seats.len());
        let mut next_turn = None;
        for k in 0..count {
            let at = (self.turn + k) % count;
            let Some(ObjectSlot { object, owed }) = &mut self.seats[at] else { continue };
            let transfer_work = object.transfer_work;
            let Some(voice) = object.voice.as_mut().filter(|voice| !voice.is_silent()) else { continue };
            // Whoever must wait is the first in the next block.
            *owed += budget.transfers;
            let may = work >= transfer_work || *owed >= transfer_work && work == budget.transfers;
            if may {
                (work, *owed) = (work.saturating_sub(transfer_work), 0);
            } else if next_turn.is_none() {
                next_turn = Some(at);
            }
            let mut outputs = LiveOutputs { channels: &mut self.channels, entering: &mut self.entering };
            voice.render(self.position, frames, &self.paths, &self.receivers, may, &mut outputs);
        }
        for RetiringObject { object, .. } in self.leaving.iter_mut().flatten() {
            if let Some(voice) = &mut object.voice {
                let mut outputs = LiveOutputs { channels: &mut self.channels, entering: &mut self.entering };
                voice.render(self.position, frames, &self.paths, &self.receivers, false, &mut outputs);
            }
        }
        self.turn = next_turn.unwrap_or(0);
    }

    /// Fades out the quietest objects until no more modes ring than may.
    fn limit_modes(&mut self, most: usize) {
        let ringing = || self.seats.iter().flatten().filter_map(|seat| seat.object.voice.as_deref());
        let load: usize = ringing().filter(|voice| !voice.is_ending()).map(LiveVoice::load).sum();
        self.counts.voices = ringing().filter(|voice| !voice.is_silent()).count() as u64;
        self.counts.modes = ringing().map(|voice| voice.awake_modes() as u64).sum();
        let mut excess = load.saturating_sub(most);
        while excess > 0 {
            let awake = voices(&mut self.seats).filter(|voice| voice.awake_modes() > 0 && !voice.is_ending());
            let Some(quietest) = awake.min_by(|a, b| a.loudness().total_cmp(&b.loudness())) else { break };
            excess = excess.saturating_sub(quietest.load());
            quietest.end();
            self.counts.shed_voices += 1;
        }
    }

    fn reverberate(&mut self, frames: usize) {
        let Some(network) = &mut self.reverberation else { return };
        for frame in 0..frames {
            self.late.fill(0.0);
            network.step(&std::array::from_fn(|input| self.entering[input][frame]), &mut self.late);
            self.channels.iter_mut().zip(&self.late).for_each(|(channel, p)| channel[frame] += p);
        }
    }

    /// Stops everything, if it is to stop.
    fn fade(&mut self, frames: usize) {
        let Some(left) = self.stopping else { return };
        let length = FADE * self.settings.sample_rate.as_f64();
        for channel in &mut self.channels {
            for (frame, p) in channel.iter_mut().enumerate() {
                *p *= (left.saturating_sub(frame + 1)) as f64 / length;
            }
        }
        self.stopping = left.checked_sub(frames).filter(|left| *left > 0);
        if self.stopping.is_none() {
            self.clicks.silence();
            self.waves.clear();
            voices(&mut self.seats).for_each(LiveVoice::silence);
            let leaving = self.leaving.iter_mut().flatten();
            leaving.filter_map(|left| left.object.voice.as_mut()).for_each(|voice| voice.silence());
            if let Some(network) = &mut self.reverberation {
                network.silence();
            }
        }
    }

    /// Returns objects that are no longer heard to where they can be freed.
    fn give_back(&mut self) {
        for at in 0..LEAVING {
            let over = |left: &mut RetiringObject| {
                let silent = left.object.voice.as_ref().is_none_or(|voice| voice.is_silent());
                silent && left.until <= self.position
            };
            if let Some(RetiringObject { mut object, .. }) = self.leaving[at].take_if(over) {
                object.field = self.clicks.put_field(self.settings.objects + at, None);
                // The ring has room for every object that can have been sent.
                let _ = self.links.returned.push(object);
            }
        }
    }
}
