//! Checks recorded frames one at a time: finite numbers, rising times, unit rotations, and no jumps that no
//! body makes. Only the last two frames of a body are kept, so that a recording of any length can be checked.
//!
//! A jump is a single frame much faster than those before and after it, or one as fast as sound. A long
//! series of fast frames is a fast body. What is allowed but doubtful is counted and becomes notices.

use clangor_core::body::BodyId;
use clangor_core::quantity::COORDINATE;
use glam::DVec3;

use super::coordinate_rounding::CoordinateRounding;
use super::fall_units::{unit_of_body, unit_of_frames};
use super::file_units::{FileUnits, LikelyUnit};
use super::free_falls::FreeFalls;
use super::jump_windows::CLEAR_OF_NOISE;
use super::pose_noise::PoseNoise;
use super::quaternion_order::QuaternionOrder;
use super::recording::{Frame, MAX_TIME, RecordingError, RecordingNotice};
use super::repeated_poses::RepeatedPoses;
use super::straight_keys::StraightKeys;
use super::uneven_times::UnevenTimes;

/// How far the length of a quaternion may be from 1; it is made 1.
const UNIT_TOLERANCE: f64 = 0.01;
/// A jump is a frame this many times as fast as those before and after it.
const JUMP_RATIO: f64 = 10.0;
/// Slowest frame that is taken for a jump [m/s].
const JUMP_SPEED: f64 = 5.0;
/// Ratio of the longest to the shortest distance of frames from which a notice is given.
const UNEVEN: f64 = 1.5;
/// The same ratio up to which the frames have one length.
const EVEN: f64 = 1.01;
/// Jump of velocity hidden by noise from which a notice is given [m/s].
const HIDES: f64 = 0.2;
/// Deviation of a jump times the length of its frames, over that of a coordinate: √6.
const JUMPS_OF_NOISE: f64 = 2.449_489_742_783_178;
/// Length of a frame in which impacts of noisy positions are told from it \[s\].
const LONG_ENOUGH: f64 = 1.0 / 120.0;
/// Angle within a frame from which a notice is given \[rad\]: well below π, where the sense of rotation is
/// lost.
const FAST_TURN: f64 = 2.0;
/// cos(`FAST_TURN` / 2), which is the product of two unit quaternions at that angle.
const FAST_TURN_COSINE: f64 = 0.540_302_305_868_139_8;
/// Share of the frames in which a body must fall along z for the axes to be doubted.
const DOUBTFUL_SHARE: f64 = 0.3;
/// An acceleration counts as that of gravity within this share of g.
const NEAR_GRAVITY: f64 = 0.2;

/// The frames of one body so far.
#[derive(Clone, Debug)]
pub(crate) struct FrameChecks {
    sound_speed: f64,
    gravity: DVec3,
    /// The last frame.
    last: Option<Frame>,
    /// The one before it.
    before: Option<Frame>,
    /// Mean velocity of the last interval [m/s], and its length \[s\].
    interval: Option<(DVec3, f64)>,
    /// Speed of the last interval, and of the one before it; infinite before the first [m/s].
    speeds: [f64; 2],
    shortest: f64,
    longest: f64,
    /// Largest angle within a frame \[rad\] and its row.
    fastest: (f64, u64),
    falls: Falls,
    free_falls: FreeFalls,
    units: FileUnits,
    noise: PoseNoise,
    rounding: CoordinateRounding,
    repeated: RepeatedPoses,
    straight: StraightKeys,
    times: UnevenTimes,
    order: Option<QuaternionOrder>,
}

/// Frames with an acceleration, and those of them along −z and along gravity.
#[derive(Clone, Copy, Debug, Default)]
struct Falls {
    all: u64,
    along_z: u64,
    right: u64,
}

impl FrameChecks {
    /// `sound_speed` [m/s] is that of the medium, which no body reaches; `gravity` is in m/s². The frames
    /// were in these units.
    pub(crate) fn new(sound_speed: f64, gravity: DVec3, units: FileUnits) -> Self {
        FrameChecks {
            sound_speed,
            gravity,
            last: None,
            before: None,
            interval: None,
            speeds: [f64::INFINITY; 2],
            shortest: f64::INFINITY,
            longest: 0.0,
            fastest: (0.0, 0),
            falls: Falls::default(),
            free_falls: FreeFalls::new(gravity),
            units,
            noise: PoseNoise::new(),
            rounding: CoordinateRounding::default(),
            repeated: RepeatedPoses::default(),
            straight: StraightKeys::default(),
            times: UnevenTimes::default(),
            order: None,
        }
    }

    /// Also whether quaternions have their scalar first.
    pub(crate) fn with_order(self, order: QuaternionOrder) -> Self {
        FrameChecks { order: Some(order), ..self }
    }

    /// Time of the last frame \[s\].
    pub(crate) fn last_time(&self) -> Option<f64> {
        self.last.map(|frame| frame.time)
    }

    /// Longest distance of two frames so far \[s\].
    pub(crate) fn longest(&self) -> f64 {
        self.longest
    }

    /// The falls so far.
    pub(crate) fn free_falls(&self) -> &FreeFalls {
        &self.free_falls
    }

    /// Noise of the jumps of velocity on one axis [m/s].
    pub(crate) fn noise(&self) -> f64 {
        self.noise.of_jumps().max(self.rounding.deviation() / self.shortest)
    }

    /// Checks the next frame of the body called `name` and makes its rotation unit.
    ///
    /// # Errors
    /// [`RecordingError`] with its row, or that of the frame before.
    pub(crate) fn push(&mut self, name: &str, frame: &mut Frame) -> Result<(), RecordingError> {
        check_numbers(name, frame)?;
        self.check_order(name, frame)?;
        let fall = self.free_falls.push(frame);
        if let (None, Some(order)) = (&self.last, &mut self.order) {
            order.begin(frame.pose.orientation, frame.row);
        }
        if let (Some(fall), Some(order)) = (fall, &mut self.order) {
            order.push(&fall, frame.row);
        }
        if let Some(last) = self.last {
            let span = frame.time - last.time;
            let velocity = (frame.pose.position - last.pose.position) / span;
            self.repeated.push(velocity, frame.row);
            self.check_speed(name, (&last, frame), velocity.length())?;
            (self.shortest, self.longest) = (self.shortest.min(span), self.longest.max(span));
            self.noise.push(velocity, span, self.gravity);
            // The cosine of half the angle is cheap, the angle is not.
            if last.pose.orientation.dot(frame.pose.orientation).abs() < FAST_TURN_COSINE {
                let angle = last.pose.rotation_to(&frame.pose).length();
                if angle > self.fastest.0 {
                    self.fastest = (angle, frame.row);
                }
            }
            if let Some((earlier, before)) = self.interval.replace((velocity, span)) {
                self.straight.push([earlier, velocity], last.row);
                self.times.push([earlier, velocity], 0.5 * (before + span), self.gravity);
                self.count_fall((velocity - earlier) / (0.5 * (before + span)));
                self.rounding.push(frame.pose.position, (velocity - earlier).length() * span);
            }
        }
        self.before = self.last.replace(*frame);
        Ok(())
    }

    fn check_order(&self, name: &str, frame: &Frame) -> Result<(), RecordingError> {
        let Frame { time, row, .. } = *frame;
        match self.last_time().filter(|before| *before >= time) {
            Some(before) => Err(RecordingError::Order { body: name.into(), row, time, before }),
            None => Ok(()),
        }
    }

    /// Checks the speed [m/s] between the last frame and the next.
    fn check_speed(
        &mut self,
        name: &str,
        (last, frame): (&Frame, &Frame),
        speed: f64,
    ) -> Result<(), RecordingError> {
        let teleport = |from: &Frame, to: &Frame, speed: f64| RecordingError::Teleport {
            body: name.into(),
            row: to.row,
            distance: from.pose.position.distance(to.pose.position),
            span: to.time - from.time,
            speed,
            unit: self.unit_of_fall(last, frame),
            repeats: self.repeated_poses().is_some(),
        };
        let [middle, earlier] = self.speeds;
        if let Some(before) = &self.before
            && middle > JUMP_SPEED
            && middle > JUMP_RATIO * earlier.max(speed)
        {
            return Err(teleport(before, last, middle));
        }
        if speed >= self.sound_speed {
            return Err(teleport(last, frame, speed));
        }
        self.speeds = [speed, middle];
        Ok(())
    }

    /// The unit of length that the falls until now show, or else the last frames.
    fn unit_of_fall(&self, last: &Frame, frame: &Frame) -> Option<LikelyUnit> {
        let known = unit_of_body(&self.free_falls, self.gravity.length(), self.units);
        let of_frames = || unit_of_frames([self.before.as_ref()?, last, frame], self.gravity, self.units);
        known.filter(LikelyUnit::makes_faster).or_else(of_frames)
    }

    /// How many poses repeat the one before, and the row of the first. Rounded positions repeat where a body
    /// is slow.
    fn repeated_poses(&self) -> Option<(u64, u64)> {
        self.repeated.found().filter(|_| self.rounding.deviation() == 0.0)
    }

    /// Counts an acceleration [m/s²].
    fn count_fall(&mut self, acceleration: DVec3) {
        let g = self.gravity.length();
        if acceleration.length_squared() <= (NEAR_GRAVITY * g).powi(2) {
            return;
        }
        let near = |direction: DVec3| (acceleration - direction).length() < NEAR_GRAVITY * g;
        self.falls.all += 1;
        self.falls.along_z += u64::from(near(DVec3::NEG_Z * g));
        self.falls.right += u64::from(near(self.gravity));
    }

    /// What should be known about the frames of the body called `name`.
    fn notices(&self, name: &str) -> Vec<RecordingNotice> {
        let (shortest, longest) = (self.shortest, self.longest);
        let uneven = RecordingNotice::Uneven { body: name.into(), shortest, longest };
        let (angle, row) = self.fastest;
        let turn = RecordingNotice::FastTurn { body: name.into(), row, degrees: angle.to_degrees() };
        let hidden = CLEAR_OF_NOISE * self.noise();
        let noise = self.noise() * shortest / JUMPS_OF_NOISE;
        let every = (LONG_ENOUGH / shortest).floor().clamp(0.0, f64::from(u32::MAX)) as u32;
        let noisy = RecordingNotice::Noisy { body: name.into(), noise, hidden, every };
        let scalar_first = self.order.and_then(|order| order.scalar_first());
        let order = RecordingNotice::ScalarFirst { body: name.into(), row: scalar_first.unwrap_or(0) };
        let (count, first) = self.repeated_poses().unwrap_or_default();
        let repeated = RecordingNotice::Repeated { body: name.into(), count, row: first };
        let straight = self.straight.found();
        let (every, first) = straight.unwrap_or_default();
        let keys = RecordingNotice::StraightKeys { body: name.into(), every, row: first };
        let deviation = self.times.found();
        let times =
            RecordingNotice::UnevenTimes { body: name.into(), deviation: deviation.unwrap_or_default() };
        let found = [
            (deviation.is_some(), times),
            (straight.is_some(), keys),
            (scalar_first.is_some(), order),
            (count > 0, repeated),
            (longest > UNEVEN * shortest, uneven),
            (hidden > HIDES, noisy),
            (angle > FAST_TURN, turn),
        ];
        found.into_iter().filter(|(is_found, _)| *is_found).map(|(_, notice)| notice).collect()
    }
}

/// Checks the numbers of a frame of the body called `name` and makes its rotation unit.
///
/// # Errors
/// [`RecordingError`] for numbers that no timeline has, and for a quaternion that is no rotation.
pub(crate) fn check_numbers(name: &str, frame: &mut Frame) -> Result<(), RecordingError> {
    let Frame { time, pose, row } = *frame;
    let body = || name.to_string();
    let numbers = [
        (time.is_finite(), "t"),
        (pose.position.is_finite(), "position"),
        (pose.orientation.is_finite(), "orientation"),
    ];
    if let Some((_, what)) = numbers.into_iter().find(|(is_finite, _)| !is_finite) {
        return Err(RecordingError::NotFinite { body: body(), row, what });
    }
    if !(0.0..=MAX_TIME).contains(&time) {
        return Err(RecordingError::Time { body: body(), row, time });
    }
    let place = pose.position.to_array();
    if let Some(value) = place.into_iter().find(|value| !COORDINATE.admits(*value)) {
        return Err(RecordingError::Far { body: body(), row, value });
    }
    let length = pose.orientation.length();
    if (length - 1.0).abs() > UNIT_TOLERANCE {
        return Err(RecordingError::NotUnit { body: body(), row, length });
    }
    frame.pose.orientation = pose.orientation / length;
    Ok(())
}

/// Checks all frames of a body called `name` and makes their rotations unit.
///
/// # Errors
/// [`RecordingError`] with the first bad row.
pub(crate) fn check_frames(
    name: &str,
    frames: &mut [Frame],
    mut checks: FrameChecks,
) -> Result<FrameChecks, RecordingError> {
    frames.iter_mut().try_for_each(|frame| checks.push(name, frame))?;
    Ok(checks)
}

/// What should be known about checked bodies, of which the first `from_gltf` come from glTF files; `name`
/// gives their names.
pub(crate) fn notices(
    bodies: &[(BodyId, FrameChecks)],
    from_gltf: usize,
    name: &dyn Fn(BodyId) -> String,
) -> Vec<RecordingNotice> {
    let mut found: Vec<RecordingNotice> =
        bodies.iter().flat_map(|(body, checks)| checks.notices(&name(*body))).collect();
    let (gltf, tables) = bodies.split_at(from_gltf.min(bodies.len()));
    found.extend(falls_along_z(gltf).then_some(RecordingNotice::ZUpInGltf));
    found.extend(falls_along_z(tables).then_some(RecordingNotice::ZUp));
    let is_known = found.iter().any(|notice| matches!(notice, RecordingNotice::ScalarFirst { .. }));
    found.extend(
        all_begin_with_one(tables)
            .filter(|_| !is_known)
            .map(|(body, row)| RecordingNotice::BeginsWithOne { body: name(body), row }),
    );
    found
}

/// The first body and its first row, if the quaternions of all bodies begin with (1, 0, 0, 0).
fn all_begin_with_one(bodies: &[(BodyId, FrameChecks)]) -> Option<(BodyId, u64)> {
    let ordered = || bodies.iter().filter_map(|(body, checks)| Some((*body, checks.order?)));
    let first = ordered().next().and_then(|(body, order)| Some((body, order.begins_with_one()?)));
    first.filter(|_| ordered().all(|(_, order)| order.begins_with_one().is_some()))
}

/// The length of the frames of all bodies \[s\], if it is one; `None` as well without frames.
pub(crate) fn common_length(checks: &[(BodyId, FrameChecks)]) -> Option<f64> {
    let shortest = checks.iter().map(|(_, body)| body.shortest).fold(f64::INFINITY, f64::min);
    let longest = checks.iter().map(|(_, body)| body.longest).fold(0.0, f64::max);
    (shortest.is_finite() && longest <= EVEN * shortest).then_some(0.5 * (shortest + longest))
}

/// Whether bodies accelerate by g along −z in a good share of the frames, and hardly ever along gravity.
fn falls_along_z(bodies: &[(BodyId, FrameChecks)]) -> bool {
    let sum = |count: fn(&Falls) -> u64| bodies.iter().map(|(_, checks)| count(&checks.falls)).sum::<u64>();
    let [all, along_z, right] =
        [sum(|falls| falls.all), sum(|falls| falls.along_z), sum(|falls| falls.right)];
    along_z as f64 > DOUBTFUL_SHARE * all as f64 && right * 10 < along_z
}
