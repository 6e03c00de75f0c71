//! One impact on one body at one receiver: `clangor strike`.
//!
//! The body is at rest with its centre of mass at the origin and the axes of its mesh file. The force begins
//! at t = 0. The output begins at −2 ms, because a band-limited onset rings before its arrival. It includes
//! the propagation delay to the receiver.

use std::sync::Arc;

use glam::DVec3;

use super::SampleRate;
use super::modal::ModalSource;
use super::render_settings::RenderSettings;
use super::source::SoundSource;
pub use super::strike_error::StrikeError;
pub use super::striker::Striker;
use super::striker::{positive, struck_side};
use super::struck_sources::{self, StruckSources};
use crate::acoustics::Acoustics;
use crate::body::{Body, Motion};
use crate::contact::{
    ContactPoint, ContactSide, ForceProfile, ForceSettings, Impact, ImpactModel, ImpactPulse, ImpactSolver,
    Spread, Touch, contact_forces, no_modes, touching,
};
use crate::medium::Medium;
use crate::pose::Pose;
use crate::propagation::Room;
use crate::sound_model::acceleration::sphere_radiation::SphereModel;
use crate::synthesis::acceleration_pulse::{AccelerationPulse, clicks_of};

/// Output before the first contact \[s\].
pub const LEAD: f64 = 2e-3;
/// Approach speed of the default duration [m/s].
pub const DEFAULT_SPEED: f64 = 1.0;

/// What strikes the body.
#[allow(clippy::large_enum_variant, reason = "one per strike, never in lists")]
#[derive(Clone, Debug, PartialEq)]
pub enum StrikeForce {
    /// A force of given impulse, which nothing else limits.
    Impulse {
        /// Impulse on the body [N s].
        impulse: DVec3,
        /// Duration τ \[s\]; by default that of a collision with a rigid plane at 1 m/s along the impulse.
        duration: Option<f64>,
    },
    /// A ball that hits the body.
    Striker(Striker),
}

/// An impact and its receiver.
#[derive(Clone, Debug, PartialEq)]
pub struct Strike {
    /// What strikes the body.
    pub force: StrikeForce,
    /// Point of the impact [m, from the centre of mass].
    pub point: DVec3,
    /// Receiver [m, from the centre of mass].
    pub listener: DVec3,
    /// Time profile of the force.
    pub profile: ForceProfile,
    /// Steps of a solve per first duration of the contact.
    pub steps: f64,
    /// Sample rate \[Hz\].
    pub sample_rate: SampleRate,
    /// Highest frequency rendered in full \[Hz\]; by default as high as the sample rate allows.
    pub max_frequency: Option<f64>,
    /// End of the output \[s\]; by default when the sound has decayed.
    pub seconds: Option<f64>,
    /// Medium around the body.
    pub medium: Medium,
    /// Room around body and receiver, whose corners are relative to the centre of mass; `None`: free space.
    pub room: Option<Room>,
    /// Field of an accelerated sphere.
    pub sphere_model: SphereModel,
}

/// The sound of a [`Strike`].
#[derive(Clone, Debug, PartialEq)]
pub struct StrikeSound {
    /// Time of each sample \[s\].
    pub times: Vec<f64>,
    /// Pressure \[Pa\].
    pub pressures: Vec<f64>,
    /// Duration τ of the force \[s\].
    pub duration: f64,
    /// Jump in velocity of the centre of mass [m/s].
    pub velocity_change: DVec3,
    /// Radius of the sphere that has the volume of the body \[m\].
    pub radius: f64,
}

/// The forces of a strike on a body, whose own pose and motion are ignored. `modes` are its modes, which
/// bound the force of a striker on them.
///
/// # Errors
/// [`StrikeError`].
pub fn forces(
    body: &Body,
    modes: Option<&ModalSource>,
    strike: &Strike,
) -> Result<Vec<ImpactPulse>, StrikeError> {
    if !strike.listener.is_finite() {
        return Err(StrikeError::NotFinite { what: "the listener" });
    }
    let body = at_rest(body);
    match &strike.force {
        StrikeForce::Impulse { impulse, duration } => forces_of_impulse(&body, strike, *impulse, *duration),
        StrikeForce::Striker(striker) => {
            let settings = ForceSettings {
                profile: strike.profile,
                steps: strike.steps,
                band: 0.5 * strike.sample_rate.as_f64(),
                ..ForceSettings::default()
            };
            striker.forces_on(&body, modes, strike.point, &settings)
        }
    }
}

/// Forces of a given impulse, as of a rigid plane that meets the body at 1 m/s.
fn forces_of_impulse(
    body: &Body,
    strike: &Strike,
    impulse: DVec3,
    duration: Option<f64>,
) -> Result<Vec<ImpactPulse>, StrikeError> {
    if !impulse.is_finite() {
        return Err(StrikeError::NotFinite { what: "the impulse" });
    }
    let struck = struck_side(body, strike.point)?;
    // Scaled first, so that no length overflows.
    let normal = (impulse / impulse.abs().max_element()).try_normalize();
    if normal.is_none() && duration.is_none() {
        return Err(StrikeError::NoImpulse);
    }
    if let Some(duration) = duration.filter(|duration| !positive(*duration)) {
        return Err(StrikeError::Duration { duration });
    }
    let normal = normal.unwrap_or(DVec3::Y);
    let touch = Touch {
        surfaces: [Some(&*body.surface), None],
        normal,
        place: strike.point,
        speed: DEFAULT_SPEED,
        spread: Spread::single(struck.bounding_radius),
    };
    let impact = Impact {
        impact_id: 0,
        time: 0.0,
        sides: touching([struck, ContactSide::SURROUNDINGS], &touch),
        point: strike.point,
        normal,
        speed: DEFAULT_SPEED,
        restitution: 1.0,
        friction: 0.0,
        points: vec![ContactPoint {
            impulse,
            ..ContactPoint::approaching(strike.point, normal, -DEFAULT_SPEED * normal)
        }],
    };
    // The speed of what gave the impulse is not known, and so not its energy either.
    let settings =
        ForceSettings { profile: strike.profile, model: ImpactModel::Given, ..ForceSettings::default() };
    let pulses = contact_forces(&impact, &no_modes, &settings, &mut ImpactSolver::default())?;
    let lasting = |pulse: ImpactPulse| ImpactPulse { duration: duration.unwrap_or(pulse.duration), ..pulse };
    Ok(pulses.into_iter().map(lasting).collect())
}

/// Acceleration noise of an impact on a body with the source `source`, and of its striker. Its `modes` shape
/// the force. The body's own pose and motion are ignored.
///
/// # Errors
/// [`StrikeError`].
pub fn strike(
    body: &Body,
    source: &SoundSource,
    modes: Option<&ModalSource>,
    strike: &Strike,
) -> Result<StrikeSound, StrikeError> {
    let pulses = forces(body, modes, strike)?;
    let clicks = clicks(&pulses, source, strike)?;
    let seconds = seconds(&clicks, strike)?;
    let count = samples(strike, seconds);
    let pressures = pressure(body, (&pulses, None), &clicks, strike, count)?;
    Ok(StrikeSound {
        times: times(strike, count),
        pressures,
        duration: pulses.iter().map(|pulse| pulse.duration).fold(0.0, f64::max),
        velocity_change: pulses.iter().filter_map(|pulse| pulse.bodies[0]).map(|b| b.velocity_change).sum(),
        radius: body.surface.equal_volume_radius(),
    })
}

/// The clicks of the forces of a strike: those of the body, with this source, and of a striker that is heard.
///
/// # Errors
/// [`StrikeError::ListenerInside`].
pub fn clicks(
    pulses: &[ImpactPulse],
    source: &SoundSource,
    strike: &Strike,
) -> Result<Vec<AccelerationPulse>, StrikeError> {
    let mut sources = vec![source.clone()];
    if let StrikeForce::Striker(striker) = &strike.force
        && striker.heard
    {
        sources.push(SoundSource::Sphere { radius: striker.radius });
    }
    let clicks: Vec<AccelerationPulse> = pulses.iter().flat_map(|pulse| clicks_of(pulse, &sources)).collect();
    let inside = |click: &AccelerationPulse| {
        click.source.silent_at(click.orientation.inverse() * (strike.listener - click.centre))
    };
    if clicks.iter().any(inside) {
        return Err(StrikeError::ListenerInside { distance: strike.listener.length() });
    }
    Ok(clicks)
}

/// End of the output \[s\]: the one asked for, or when the clicks have decayed.
fn seconds(clicks: &[AccelerationPulse], strike: &Strike) -> Result<f64, StrikeError> {
    // The band limit rings for as long after the sound as before it.
    let died_away = |click: &AccelerationPulse| {
        strike.listener.distance(click.centre) / strike.medium.sound_speed
            + click.shape.extent(click.duration).1
            + click.source.ring_time(&strike.medium)
            + LEAD * (48_000.0 / strike.sample_rate.as_f64()).max(1.0)
    };
    let seconds = strike.seconds.unwrap_or_else(|| clicks.iter().map(died_away).fold(0.0, f64::max));
    match seconds > -LEAD && seconds.is_finite() {
        true => Ok(seconds),
        false => Err(StrikeError::Seconds { seconds }),
    }
}

/// Number of samples of an output that ends at `seconds`.
pub fn samples(strike: &Strike, seconds: f64) -> usize {
    ((seconds + LEAD) * strike.sample_rate.as_f64()).ceil().max(0.0) as usize
}

/// Times of the samples \[s\].
pub fn times(strike: &Strike, count: usize) -> Vec<f64> {
    (0..count).map(|i| i as f64 / strike.sample_rate.as_f64() - LEAD).collect()
}

/// Modal sound of a struck body at the sample times of the [`strike`] output for the same impact \[Pa\].
///
/// # Errors
/// [`StrikeError`].
pub fn struck_ringing(
    body: &Body,
    source: Arc<ModalSource>,
    strike: &Strike,
    sound: &StrikeSound,
) -> Result<Vec<f64>, StrikeError> {
    let pulses = forces(body, Some(&source), strike)?;
    pressure(body, (&pulses, Some(&source)), &[], strike, sound.pressures.len())
}

/// Pressure of `clicks`, and of modes under the forces of `pulses`, at the receiver of a strike: `count`
/// samples \[Pa\].
///
/// # Errors
/// [`StrikeError`].
pub fn pressure(
    body: &Body,
    (pulses, modes): (&[ImpactPulse], Option<&Arc<ModalSource>>),
    clicks: &[AccelerationPulse],
    strike: &Strike,
    count: usize,
) -> Result<Vec<f64>, StrikeError> {
    let sources = StruckSources { body: &at_rest(body), pulses, clicks, modes };
    struck_sources::pressure(&sources, strike.listener, &settings(strike), count)
}

/// The body, free and at rest at the origin.
fn at_rest(body: &Body) -> Body {
    Body {
        pose: Pose::IDENTITY,
        velocity: DVec3::ZERO,
        angular_velocity: DVec3::ZERO,
        motion: Motion::Free,
        ..body.clone()
    }
}

/// Render settings of the impact.
fn settings(strike: &Strike) -> RenderSettings {
    RenderSettings {
        sample_rate: strike.sample_rate,
        start: -LEAD,
        acoustics: Acoustics {
            medium: strike.medium,
            max_frequency: strike.max_frequency,
            room: strike.room,
            ..Acoustics::default()
        },
        sphere_model: strike.sphere_model,
    }
}
