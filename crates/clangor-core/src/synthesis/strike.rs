//! One impact on one body at one receiver: `clangor strike`.
//!
//! The body is at rest with its centre of mass at the origin and the axes of its mesh file. The force begins
//! at t = 0. The output begins at −2 ms, because a band-limited onset rings before its arrival. It includes
//! the propagation delay to the receiver.

use std::sync::Arc;

use glam::{DQuat, DVec3};

use super::listener::Listener;
use super::modal::{ModalSource, ModalVoice};
use super::offline::overlap_add::OverlapAdd;
use super::offline::renderer::Renderer;
use super::render_settings::RenderSettings;
use super::source::SoundSource;
use super::{SampleRate, SynthesisError};
use crate::acoustics::Acoustics;
use crate::body::{Body, BodyId, Motion, Surface};
use crate::contact::effective_mass::inverse_effective_mass;
use crate::contact::force_profile::ForceProfile;
use crate::contact::hertz::{HertzContact, combined_curvature};
use crate::contact::local_curvature::mean_curvature;
use crate::contact::{BodyPulse, ImpactPulse, PoseHistory};
use crate::medium::Medium;
use crate::pose::Pose;
use crate::sound_model::acceleration::sphere_radiation::SphereModel;
use crate::synthesis::acceleration_pulse::AccelerationPulse;

/// Output before the first contact \[s\].
pub const LEAD: f64 = 2e-3;
/// Approach speed of the default duration [m/s].
pub const DEFAULT_SPEED: f64 = 1.0;
/// Largest distance of the struck point from the surface, over the bounding radius.
pub const POINT_TOLERANCE: f64 = 0.02;

/// An impact and its receiver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strike {
    /// Impulse on the body [N s].
    pub impulse: DVec3,
    /// Point of the impact [m, from the centre of mass].
    pub point: DVec3,
    /// Receiver [m, from the centre of mass].
    pub listener: DVec3,
    /// Duration τ \[s\]; by default that of a collision with a rigid plane at 1 m/s along the impulse.
    pub duration: Option<f64>,
    /// Time profile of the force.
    pub profile: ForceProfile,
    /// Sample rate \[Hz\].
    pub sample_rate: SampleRate,
    /// Highest frequency rendered in full \[Hz\]; by default as high as the sample rate allows.
    pub max_frequency: Option<f64>,
    /// End of the output \[s\]; by default when the sound has decayed.
    pub seconds: Option<f64>,
    /// Medium around the body.
    pub medium: Medium,
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

/// Error in a strike.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum StrikeError {
    /// A number that is not finite.
    #[error("{what} is not finite")]
    NotFinite {
        /// Quantity.
        what: &'static str,
    },
    /// The impact misses the body.
    #[error(
        "the point {point} m is {distance:.4e} m off the surface, more than 2 % of the bounding radius \
        {bounding} m"
    )]
    OffSurface {
        /// The point \[m\].
        point: DVec3,
        /// Its distance from the surface \[m\].
        distance: f64,
        /// Bounding radius of the body \[m\].
        bounding: f64,
    },
    /// No impulse and no duration.
    #[error("the impulse is zero, so the duration of the contact must be given")]
    NoImpulse,
    /// A half-space, or a mass or volume that is not positive.
    #[error(
        "the body cannot be struck: its mass is {mass} kg and the sphere of its volume has radius {radius} m"
    )]
    Immovable {
        /// Mass \[kg\].
        mass: f64,
        /// Radius of the sphere of equal volume \[m\].
        radius: f64,
    },
    /// A duration that is not positive.
    #[error("the contact lasts {duration} s; it must be longer than 0")]
    Duration {
        /// Duration \[s\].
        duration: f64,
    },
    /// An output that ends before it begins.
    #[error("the output ends at {seconds} s, before it begins at −0.002 s")]
    Seconds {
        /// End of the output \[s\].
        seconds: f64,
    },
    /// The listener is inside the body, or inside the sphere in its place.
    #[error(
        "the listener is {distance} m from the centre of mass, inside the body or the sphere that sounds in \
        its place"
    )]
    ListenerInside {
        /// Distance from the centre of mass \[m\].
        distance: f64,
    },
    /// The sound cannot be synthesised.
    #[error(transparent)]
    Synthesis(#[from] SynthesisError),
}

/// Acceleration noise of an impact on a body with the source `source`. The body's own pose and motion are
/// ignored.
///
/// # Errors
/// [`StrikeError`].
pub fn strike(body: &Body, source: &SoundSource, strike: &Strike) -> Result<StrikeSound, StrikeError> {
    let radius = body.surface.equal_volume_radius();
    let positive = |x: f64| x > 0.0 && x.is_finite();
    if !positive(body.mass) || !positive(radius) {
        return Err(StrikeError::Immovable { mass: body.mass, radius });
    }
    let finite = [
        ("the impulse", strike.impulse.is_finite()),
        ("the point", strike.point.is_finite()),
        ("the listener", strike.listener.is_finite()),
    ];
    if let Some((what, _)) = finite.into_iter().find(|(_, finite)| !finite) {
        return Err(StrikeError::NotFinite { what });
    }
    check_point(&body.surface, strike.point)?;
    let distance = strike.listener.length();
    if source.silent_at(strike.listener) {
        return Err(StrikeError::ListenerInside { distance });
    }
    let duration = match strike.duration {
        Some(duration) => duration,
        None => default_duration(body, strike.impulse, strike.point)?,
    };
    if !positive(duration) {
        return Err(StrikeError::Duration { duration });
    }

    let velocity_change = strike.impulse / body.mass;
    let click = AccelerationPulse {
        body: BodyId(0),
        time: 0.0,
        duration,
        profile: strike.profile,
        centre: DVec3::ZERO,
        orientation: DQuat::IDENTITY,
        velocity_change,
        angular_velocity_change: body.inertia.inverse() * strike.point.cross(strike.impulse),
        source: source.clone(),
    };
    let settings = settings(strike);
    // The band limit rings for as long after the sound as before it.
    let died_away = distance / strike.medium.sound_speed
        + strike.profile.extent(duration).1
        + source.ring_time(&strike.medium)
        + LEAD * (48_000.0 / strike.sample_rate.as_f64()).max(1.0);
    let seconds = strike.seconds.unwrap_or(died_away);
    if !(seconds > -LEAD && seconds.is_finite()) {
        return Err(StrikeError::Seconds { seconds });
    }

    let mut renderer = Renderer::new(&Listener::fixed("listener", strike.listener), &settings)?;
    renderer.push(&click)?;
    let mut signal = OverlapAdd::new(1, 0);
    for job in renderer.take_all() {
        signal.add(&job.render());
    }
    let rate = strike.sample_rate.as_f64();
    let count = ((seconds + LEAD) * rate).ceil() as i64;
    let pressures = signal.take_until(count).swap_remove(0);
    let times = (0..pressures.len()).map(|i| i as f64 / rate - LEAD).collect();
    Ok(StrikeSound { times, pressures, duration, velocity_change, radius })
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
    let at_rest = Body {
        pose: Pose::IDENTITY,
        velocity: DVec3::ZERO,
        angular_velocity: DVec3::ZERO,
        motion: Motion::Free,
        ..body.clone()
    };
    let angular_impulse = strike.point.cross(strike.impulse);
    let share = BodyPulse {
        body: BodyId(0),
        pose: Pose::IDENTITY,
        impulse: strike.impulse,
        velocity_change: sound.velocity_change,
        angular_impulse,
        angular_velocity_change: body.inertia.inverse() * angular_impulse,
        transit_ratio: f64::INFINITY,
    };
    let pulse = ImpactPulse {
        impact_id: 0,
        time: 0.0,
        onset: 0.0,
        duration: sound.duration,
        profile: strike.profile,
        speed: DEFAULT_SPEED,
        effective_mass: body.mass,
        radius: sound.radius,
        point: strike.point,
        normal: strike.impulse.normalize_or_zero(),
        velocity_before: None,
        pair: [BodyId(0), BodyId::WORLD],
        bodies: [Some(share), None],
        points: vec![(strike.point, strike.impulse)],
    };
    let settings = settings(strike);
    let listener = Listener::fixed("listener", strike.listener);
    // A body without rows stays at its start, so this cannot fail.
    let poses =
        PoseHistory::try_new(&[at_rest], &[]).map_err(|_| StrikeError::NotFinite { what: "the pose" })?;
    let mut voice = ModalVoice::new(source, BodyId(0), &poses, &listener, &settings)?;
    voice.push_pulses(&[pulse])?;
    let mut channels = [vec![0.0; sound.pressures.len()]];
    voice.render_block(0, &mut channels)?;
    let [ringing] = channels;
    Ok(ringing)
}

/// Render settings of the impact.
fn settings(strike: &Strike) -> RenderSettings {
    RenderSettings {
        sample_rate: strike.sample_rate,
        start: -LEAD,
        acoustics: Acoustics {
            medium: strike.medium,
            max_frequency: strike.max_frequency,
            ..Acoustics::default()
        },
        sphere_model: strike.sphere_model,
    }
}

/// Rejects a point that is not on the surface.
fn check_point(surface: &Surface, point: DVec3) -> Result<(), StrikeError> {
    let bounding = surface.bounding_radius();
    let distance = match surface {
        Surface::Sphere { radius } => (point.length() - radius).abs(),
        Surface::HalfSpace => point.y.abs(),
        Surface::Mesh(mesh) => mesh.signed_distance(point).abs(),
    };
    if distance > POINT_TOLERANCE * bounding {
        return Err(StrikeError::OffSurface { point, distance, bounding });
    }
    Ok(())
}

/// Hertz duration \[s\] of a collision with a rigid plane at 1 m/s whose normal is the impulse.
fn default_duration(body: &Body, impulse: DVec3, point: DVec3) -> Result<f64, StrikeError> {
    // Scaled first, so that no length overflows.
    let normal = (impulse / impulse.abs().max_element()).try_normalize().ok_or(StrikeError::NoImpulse)?;
    let curvature = mean_curvature(&body.surface, point);
    let contact = HertzContact {
        inverse_mass: inverse_effective_mass(1.0 / body.mass, body.inertia, point, normal),
        curvature: combined_curvature(
            [curvature, 0.0],
            [body.edge_radius, 0.0],
            body.surface.bounding_radius(),
        ),
        compliance: body.material.contact_compliance(),
        speed: DEFAULT_SPEED,
    };
    Ok(contact.duration())
}
