//! The audio thread's part: takes events as their time comes, and renders blocks.

use glam::DVec3;

use super::budget::Budget;
use super::event::{Blow, Event, MOST_RECEIVERS, Part, Struck, turns};
use super::event_ring::{Exchange, Report};
use super::schedule::Schedule;
use super::sounding_object::SoundingObject;
use super::wave_queue::{QueuedWave, WaveQueue, strength};
use crate::body::BodyId;
use crate::contact::ForceProfile;
use crate::medium::Medium;
use crate::room::{Air, LateReverberation, Room};
use crate::scene::Scene;
use crate::synthesis::listener::Floor;
use crate::synthesis::live_clicks::{LOOK_AHEAD as CLICK_LOOK_AHEAD, LiveClicks};
use crate::synthesis::live_ways::LiveWays;
use crate::synthesis::modal::live_voice::{
    LOOK_AHEAD as FORCE_LOOK_AHEAD, LiveForces, LiveOutputs, LivePose, LiveVoice,
};
use crate::synthesis::{Click, RenderSettings, SampleRate, SoundSource, SynthesisError};

/// Longest block \[samples\].
pub const LONGEST_BLOCK: usize = 4096;
/// Samples that clicks and forces look ahead.
const LOOK_AHEAD: usize =
    if CLICK_LOOK_AHEAD > FORCE_LOOK_AHEAD { CLICK_LOOK_AHEAD } else { FORCE_LOOK_AHEAD };
/// Events and waves that wait for their time, at most.
const MOST_WAITING: usize = 8192;
/// Events are refused from so far ahead \[s\].
const HORIZON: f64 = 60.0;
/// Time in which receivers follow \[s\].
const FOLLOWING: f64 = 0.02;
/// Beyond this they are there at once \[m\].
const JUMP: f64 = 1.0;
/// Time in which everything stops when it is to \[s\].
const FADE: f64 = 1e-3;
/// Blows on ringing objects whose forces are in progress at once.
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
    /// What takes from it on the way.
    pub air: Option<Air>,
    /// How forces run.
    pub profile: ForceProfile,
    /// Receivers: 1, or 2 for two ears.
    pub receivers: usize,
    /// The length of block for which all events of the block before come in time \[samples\].
    pub block: usize,
    /// How far sound is heard \[m\].
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
    pub fn of_scene(scene: &Scene) -> Self {
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

    /// As clicks and voices are rendered.
    pub(super) fn rendering(&self) -> RenderSettings {
        let EngineSettings { sample_rate, max_frequency, medium, .. } = *self;
        RenderSettings { sample_rate, max_frequency, medium, ..RenderSettings::default() }
    }

    /// The ways by which receivers hear.
    pub(super) fn ways(&self) -> LiveWays {
        LiveWays::new(self.floor, self.room.clone(), self.air)
    }

    /// How long sound may be on its way \[s\].
    pub(super) fn longest_delay(&self) -> f64 {
        self.reach / self.medium.sound_speed
    }
}

/// An object in its slot.
struct Seat {
    object: Box<SoundingObject>,
    /// Share of the work for the motion of objects that this one has been waiting for.
    owed: usize,
}

/// See the module.
pub struct Engine {
    settings: EngineSettings,
    exchange: Exchange,
    /// Sample that is rendered next.
    position: i64,
    /// Poses, ends and blows to come.
    scheduled: Schedule<Event>,
    ways: LiveWays,
    clicks: LiveClicks,
    waves: WaveQueue,
    forces: LiveForces,
    seats: Vec<Option<Seat>>,
    /// Objects that were taken from their slots, until nobody can refer to them; and from which sample on.
    leaving: Vec<(i64, Box<SoundingObject>)>,
    /// The seat that is first to follow its motion.
    turn: usize,
    reverberation: Option<LateReverberation>,
    receivers: Vec<DVec3>,
    targets: Vec<DVec3>,
    placed: bool,
    heard: [bool; 3],
    /// Samples until everything has stopped.
    stopping: Option<usize>,
    blows_left: usize,
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
fn voices(seats: &mut [Option<Seat>]) -> impl Iterator<Item = &mut LiveVoice> {
    seats.iter_mut().flatten().filter_map(|seat| seat.object.voice.as_deref_mut())
}

impl Engine {
    pub(super) fn new(settings: &EngineSettings, exchange: Exchange) -> Result<Self, SynthesisError> {
        let mut settings = settings.clone();
        settings.receivers = settings.receivers.clamp(1, MOST_RECEIVERS);
        settings.block = settings.block.clamp(1, LONGEST_BLOCK);
        let rendering = settings.rendering();
        let ways = settings.ways();
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
        let clicks = LiveClicks::new(
            &rendering,
            ways.losses(),
            settings.objects,
            outputs,
            settings.longest_delay() + 0.1,
        )?;
        let silent = |count: usize, length: usize| (0..count).map(|_| vec![0.0; length]).collect::<Vec<_>>();
        Ok(Engine {
            exchange,
            position: 0,
            scheduled: Schedule::new(MOST_WAITING),
            clicks,
            waves: WaveQueue::new(MOST_WAITING),
            forces: LiveForces::new(&rendering, FORCES),
            seats: (0..settings.objects).map(|_| None).collect(),
            leaving: Vec::with_capacity(settings.objects + 1),
            turn: 0,
            reverberation,
            receivers: vec![DVec3::ZERO; settings.receivers],
            targets: vec![DVec3::ZERO; settings.receivers],
            placed: false,
            heard: [true; 3],
            stopping: None,
            blows_left: 0,
            output: silent(settings.receivers, LONGEST_BLOCK),
            channels: silent(settings.receivers, settings.block),
            entering: silent(inputs, settings.block),
            late: vec![0.0; settings.receivers],
            counts: Report::default(),
            ways,
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
    /// Allocates, frees and waits for nothing. Work is bounded by the [`Budget`], and by the events that the ring holds.
    pub fn render(&mut self, frames: usize) -> &[Vec<f64>] {
        let frames = frames.clamp(1, LONGEST_BLOCK);
        self.take_events();
        self.output.iter_mut().for_each(Vec::clear);
        while self.output[0].len() < frames {
            self.render_block(self.settings.block.min(frames - self.output[0].len()));
            let blocks = self.output.iter_mut().zip(&self.channels);
            blocks.for_each(|(output, block)| output.extend_from_slice(block));
        }
        self.counts.peak = self.output.iter().flatten().fold(0.0, |peak: f64, p| peak.max(p.abs()));
        self.exchange.report.write(self.report());
        &self.output
    }

    fn render_block(&mut self, frames: usize) {
        let budget = self.settings.budget.of(frames);
        self.blows_left = budget.blows;
        let end = self.position + frames as i64;
        // What begins in the next block must be known in this one.
        while let Some(event) = self.scheduled.next_before(end + LOOK_AHEAD as i64) {
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
        for _ in 0..self.exchange.events.slots() {
            let Ok(event) = self.exchange.events.pop() else { break };
            self.take(event);
        }
    }

    fn take(&mut self, event: Event) {
        let time = match &event {
            Event::Blow(blow) if blow.is_good() => blow.time,
            Event::Pose { time, pose, velocity, angular_velocity, .. } => {
                let vectors = [pose.position, *velocity, *angular_velocity];
                let good = turns(pose) && vectors.iter().all(|v| v.is_finite());
                if good { *time } else { f64::NAN }
            }
            Event::End { time, .. } => *time,
            Event::Blow(_) => f64::NAN,
            _ => return self.happen(event),
        };
        let ahead = time - self.time();
        if ahead.is_nan() || ahead > HORIZON {
            self.counts.refused += 1;
            return;
        }
        self.counts.taken += 1;
        // Of what is long past only that it is past matters.
        let sample = (time.max(self.time() - 1.0) * self.settings.sample_rate.as_f64()).floor() as i64;
        if self.scheduled.add(sample + self.latency_samples() as i64, event).is_err() {
            self.counts.shed += 1;
        }
    }

    /// Lets an event happen whose time has come.
    fn happen(&mut self, event: Event) {
        match event {
            Event::Blow(blow) => self.strike(&blow),
            Event::Pose { slot, time, pose, velocity, angular_velocity } => {
                let sample = (time + self.latency()) * self.settings.sample_rate.as_f64();
                match self.seats.get_mut(slot).and_then(Option::as_mut) {
                    Some(Seat { object, .. }) => {
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
                if places.iter().all(|place| place.is_finite()) {
                    self.targets.iter_mut().zip(places).for_each(|(target, place)| *target = place);
                } else {
                    self.counts.refused += 1;
                }
            }
            Event::Switch(part, on) => {
                self.heard[part as usize] = on;
                if part == Part::Ringing && !on {
                    voices(&mut self.seats).for_each(|voice| voice.end());
                }
                self.ways.set_reflections(self.hears(Part::Reflections));
            }
            Event::Silence => {
                self.scheduled.clear();
                self.stopping = Some((FADE * self.settings.sample_rate.as_f64()) as usize);
            }
            Event::Put { slot, object } => self.put(slot, object),
        }
    }

    fn hears(&self, part: Part) -> bool {
        self.heard[part as usize]
    }

    fn put(&mut self, slot: usize, mut object: Option<Box<SoundingObject>>) {
        if self.leaving.len() == self.leaving.capacity() {
            // Slots change faster than sound dies.
            self.counts.refused += 1;
            if let Some(object) = object {
                let _ = self.exchange.returned.push(object);
            }
            return;
        }
        let reach = (self.settings.longest_delay() * self.settings.sample_rate.as_f64()) as i64;
        let until = self.position + reach + LONGEST_BLOCK as i64;
        let Some(seat) = self.seats.get_mut(slot) else {
            self.counts.refused += 1;
            if let Some(object) = object {
                self.leaving.push((until, object));
            }
            return;
        };
        let field = object.as_mut().and_then(|object| object.field.take());
        let field_before = self.clicks.put_field(slot, field);
        let seated = object.map(|object| Seat { object, owed: 0 });
        if let Some(Seat { mut object, .. }) = std::mem::replace(seat, seated) {
            object.field = field_before;
            self.leaving.push((until, object));
        }
    }

    /// A blow becomes waves and forces.
    fn strike(&mut self, blow: &Blow) {
        let rate = self.settings.sample_rate.as_f64();
        let wanted = blow.time + self.latency();
        let earliest = (self.position + LOOK_AHEAD as i64) as f64 / rate;
        // Less than a sample is rounding.
        self.counts.late += u64::from(wanted < earliest - 0.5 / rate);
        let time = wanted.max(earliest);
        let (source, radius) = match blow.struck {
            Struck::Sphere { radius } => (Some(SoundSource::Sphere { radius }), radius),
            Struck::Object { slot } => {
                let Some(Seat { object, .. }) = self.seats.get_mut(slot).and_then(Option::as_mut) else {
                    self.counts.refused += 1;
                    return;
                };
                let impulse = blow.pose.orientation.inverse() * blow.impulse;
                if let Some(voice) = object.voice.as_mut().filter(|_| impulse != DVec3::ZERO) {
                    let force = match self.blows_left.checked_sub(1) {
                        Some(left) if self.heard[Part::Ringing as usize] => {
                            self.blows_left = left;
                            self.forces.blow(self.settings.profile, time * rate, blow.duration)
                        }
                        _ => None,
                    };
                    let point = blow.pose.body_from_world(blow.point);
                    let struck =
                        force.is_some_and(|force| voice.strike(&force, &[(point, impulse)], self.position));
                    self.counts.shed += u64::from(!struck && self.heard[Part::Ringing as usize]);
                }
                (object.click.clone(), object.radius)
            }
        };
        let Some(source) = source.filter(|_| self.hears(Part::Clicks)) else { return };
        let click = Click {
            body: BodyId(0),
            time,
            duration: blow.duration,
            profile: self.settings.profile,
            centre: blow.pose.position,
            orientation: blow.pose.orientation,
            velocity_change: blow.velocity_change,
            angular_velocity_change: blow.angular_velocity_change,
            source,
        };
        self.send_waves(&click, radius);
    }

    /// Queues the waves of a click to all receivers.
    fn send_waves(&mut self, click: &Click, radius: f64) {
        for (receiver, place) in self.targets.iter().enumerate() {
            for way in 0..self.ways.count() {
                let Some(towards) = self.ways.towards(way, click.centre, *place) else { continue };
                if towards.length() > self.settings.reach {
                    self.counts.distant += 1;
                    continue;
                }
                let Some(first) = self.clicks.first_sample(click, towards) else { continue };
                let strength = strength(click, radius, towards.length(), &self.settings.medium);
                self.waves.add(first, QueuedWave { click: click.clone(), towards, way, receiver, strength });
            }
        }
    }

    /// Receivers move on towards where they are to be.
    fn follow(&mut self, frames: usize) {
        let share = 1.0 - (-(frames as f64) / (FOLLOWING * self.settings.sample_rate.as_f64())).exp();
        for (place, target) in self.receivers.iter_mut().zip(&self.targets) {
            let way = *target - *place;
            let jumps = !self.placed || way.length() > JUMP || way.length() < 1e-6;
            *place = if jumps { *target } else { *place + way * share };
        }
        self.placed = true;
    }

    fn render_clicks(&mut self, end: i64, budget: &Budget) {
        let Engine { waves, clicks, ways, channels, entering, .. } = self;
        let receivers = channels.len();
        waves.play(end, budget.waves, |wave| {
            let QueuedWave { click, towards, way, receiver, .. } = wave;
            let input = ways.reverberation_input(*way).filter(|_| *receiver == 0);
            let into = [(*receiver, 1.0), (receivers + input.unwrap_or(0), towards.length())];
            let outputs = if input.is_some() { &into[..] } else { &into[..1] };
            clicks.play(click, *towards, *way, outputs);
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
            let Some(Seat { object, owed }) = &mut self.seats[at] else { continue };
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
            voice.render(self.position, frames, &self.ways, &self.receivers, may, &mut outputs);
        }
        self.turn = next_turn.unwrap_or(0);
    }

    /// Fades out the quietest objects until no more modes ring than may.
    fn limit_modes(&mut self, most: usize) {
        let ringing = || self.seats.iter().flatten().filter_map(|seat| seat.object.voice.as_deref());
        let load: usize = ringing().map(|voice| voice.awake_modes() * voice.paths()).sum();
        self.counts.voices = ringing().filter(|voice| !voice.is_silent()).count() as u64;
        self.counts.modes = ringing().map(|voice| voice.awake_modes() as u64).sum();
        let mut excess = load.saturating_sub(most);
        while excess > 0 {
            let awake = voices(&mut self.seats).filter(|voice| voice.awake_modes() > 0 && !voice.is_ending());
            let Some(quietest) = awake.min_by(|a, b| a.loudness().total_cmp(&b.loudness())) else { break };
            excess = excess.saturating_sub(quietest.awake_modes() * quietest.paths());
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
            voices(&mut self.seats).for_each(|voice| voice.silence());
            if let Some(network) = &mut self.reverberation {
                network.silence();
            }
        }
    }

    /// Returns objects that nobody refers to any more to where they can be freed.
    fn give_back(&mut self) {
        let position = self.position;
        while let Some(at) = self.leaving.iter().position(|(until, _)| *until <= position) {
            if self.exchange.returned.is_full() {
                return;
            }
            let (_, object) = self.leaving.swap_remove(at);
            // There is room for it.
            let _ = self.exchange.returned.push(object);
        }
    }
}
