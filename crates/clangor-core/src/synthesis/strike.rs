//! One impact on one body at one receiver: `clangor strike`.
//!
//! The body is at rest with its centre of mass at the origin and the axes of its mesh file. The force begins
//! at t = 0. The output begins at −2 ms, because a band-limited onset rings before its arrival. It includes
//! the propagation delay to the receiver.

use std::sync::Arc;

use glam::DVec3;

use super::listener::Listener;
use super::modal::{ModalSource, ModalVoice};
use super::offline::overlap_add::OverlapAdd;
use super::offline::renderer::Renderer;
use super::render_settings::RenderSettings;
use super::source::SoundSource;
use super::{SampleRate, SynthesisError};
use crate::acoustics::Acoustics;
use crate::body::{Body, BodyId, Motion, Surface};
use crate::contact::{
    ContactError, ContactPoint, ContactSide, ForceProfile, ForceSettings, Impact, ImpactPulse, PoseHistory,
    contact_forces, no_modes,
};
use crate::material::{Material, PairCoefficients};
use crate::medium::Medium;
use crate::pose::Pose;
use crate::sound_model::acceleration::sphere_radiation::SphereModel;
use crate::synthesis::acceleration_pulse::{AccelerationPulse, clicks_of};

/// Output before the first contact \[s\].
pub const LEAD: f64 = 2e-3;
/// Approach speed of the default duration [m/s].
pub const DEFAULT_SPEED: f64 = 1.0;
/// Largest distance of the struck point from the surface, over the bounding radius.
pub const POINT_TOLERANCE: f64 = 0.02;

/// What strikes the body.
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

/// A free ball that hits a body at rest along the normal, without friction.
///
/// Impulse and duration follow from both bodies ([`contact_forces`]), with the restitution of the pair of
/// materials.
#[derive(Clone, Debug, PartialEq)]
pub struct Striker {
    /// Its material.
    pub material: Material,
    /// Its radius \[m\].
    pub radius: f64,
    /// Its speed along the normal [m/s].
    pub speed: f64,
    /// Outward normal of the body at the point; by default that of its surface.
    pub normal: Option<DVec3>,
    /// Whether its own acceleration noise is part of the sound.
    pub heard: bool,
}

impl Striker {
    /// A ball of a material, a radius \[m\] and a speed [m/s], which is heard.
    pub fn new(material: Material, radius: f64, speed: f64) -> Self {
        Striker { material, radius, speed, normal: None, heard: true }
    }
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
    /// A number of the striker that is not positive.
    #[error("the striker has {what} {value}; it must be more than 0")]
    Striker {
        /// Quantity, with its article.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// The normal has no direction.
    #[error("the surface has no normal at the point {point} m: give one that is not zero")]
    NoNormal {
        /// The point \[m\].
        point: DVec3,
    },
    /// The contact has no duration.
    #[error(transparent)]
    Contact(#[from] ContactError),
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

/// Body A of the impact, the one that is struck.
const STRUCK: BodyId = BodyId(0);
/// Body B, the striker.
const STRIKER: BodyId = BodyId(1);

/// The forces of a strike on a body, whose own pose and motion are ignored. `modes` are its modes, which bound
/// the force of a striker on them.
///
/// # Errors
/// [`StrikeError`].
pub fn forces(
    body: &Body,
    modes: Option<&ModalSource>,
    strike: &Strike,
) -> Result<ImpactPulse, StrikeError> {
    let radius = body.surface.equal_volume_radius();
    if !positive(body.mass) || !positive(radius) {
        return Err(StrikeError::Immovable { mass: body.mass, radius });
    }
    let normal = match &strike.force {
        StrikeForce::Impulse { .. } => None,
        StrikeForce::Striker(striker) => striker.normal,
    };
    let impulse = match strike.force {
        StrikeForce::Impulse { impulse, .. } => impulse,
        StrikeForce::Striker(_) => DVec3::ZERO,
    };
    let finite = [
        ("the impulse", impulse.is_finite()),
        ("the normal", normal.is_none_or(DVec3::is_finite)),
        ("the point", strike.point.is_finite()),
        ("the listener", strike.listener.is_finite()),
    ];
    if let Some((what, _)) = finite.into_iter().find(|(_, finite)| !finite) {
        return Err(StrikeError::NotFinite { what });
    }
    check_point(&body.surface, strike.point)?;
    let points = std::iter::once((strike.point, 1.0));
    let struck = ContactSide::of_body(STRUCK, &at_rest(body), Pose::IDENTITY).touched_at(&body.surface, points);
    match &strike.force {
        StrikeForce::Impulse { impulse, duration } => forces_of_impulse(struck, strike, *impulse, *duration),
        StrikeForce::Striker(striker) => forces_of_striker(body, struck, modes, strike, striker),
    }
}

/// Forces of a given impulse, as of a rigid plane that meets the body at 1 m/s.
fn forces_of_impulse(
    struck: ContactSide,
    strike: &Strike,
    impulse: DVec3,
    duration: Option<f64>,
) -> Result<ImpactPulse, StrikeError> {
    // Scaled first, so that no length overflows.
    let normal = (impulse / impulse.abs().max_element()).try_normalize();
    if normal.is_none() && duration.is_none() {
        return Err(StrikeError::NoImpulse);
    }
    if let Some(duration) = duration.filter(|duration| !positive(*duration)) {
        return Err(StrikeError::Duration { duration });
    }
    let impact = Impact {
        impact_id: 0,
        time: 0.0,
        sides: [struck, ContactSide::SURROUNDINGS],
        point: strike.point,
        normal: normal.unwrap_or(DVec3::Y),
        speed: DEFAULT_SPEED,
        points: vec![ContactPoint { place: strike.point, impulse, couple: DVec3::ZERO }],
    };
    // The speed of what gave the impulse is not known, and so not its energy either.
    let settings = ForceSettings { profile: strike.profile, limit_energy: false };
    let pulse = contact_forces(&impact, &no_modes, &settings)?;
    Ok(ImpactPulse { duration: duration.unwrap_or(pulse.duration), ..pulse })
}

/// Forces of a ball that hits the body.
fn forces_of_striker(
    body: &Body,
    struck: ContactSide,
    modes: Option<&ModalSource>,
    strike: &Strike,
    striker: &Striker,
) -> Result<ImpactPulse, StrikeError> {
    for (what, value) in [("the radius", striker.radius), ("the speed", striker.speed)] {
        if !positive(value) {
            return Err(StrikeError::Striker { what, value });
        }
    }
    let normal = match striker.normal {
        Some(normal) => normal.try_normalize(),
        None => body.surface.normal_at(strike.point),
    };
    let outward = normal.ok_or(StrikeError::NoNormal { point: strike.point })?;
    let ball = Body::sphere("striker", striker.material.clone(), striker.radius);
    let pose = Pose::at(strike.point + striker.radius * outward);
    let points = std::iter::once((strike.point, 1.0));
    let sides = [struck, ContactSide::of_body(STRIKER, &ball, pose).touched_at(&ball.surface, points)];
    let restitution = PairCoefficients::of(&body.material, &striker.material).restitution;
    let impact = Impact::with_restitution(sides, strike.point, -outward, striker.speed, restitution);
    let modes_of = |id: BodyId, points: &[(DVec3, DVec3)]| {
        modes.filter(|_| id == STRUCK).map(|modes| modes.at_contact(points))
    };
    let settings = ForceSettings { profile: strike.profile, limit_energy: true };
    Ok(contact_forces(&impact, &modes_of, &settings)?)
}

/// Acceleration noise of an impact on a body with the source `source`, and of its striker. The body's own pose
/// and motion are ignored.
///
/// # Errors
/// [`StrikeError`].
pub fn strike(body: &Body, source: &SoundSource, strike: &Strike) -> Result<StrikeSound, StrikeError> {
    let pulse = forces(body, None, strike)?;
    // What radiates: the body, and a striker that is heard.
    let mut sources = vec![source.clone()];
    if let StrikeForce::Striker(striker) = &strike.force
        && striker.heard
    {
        sources.push(SoundSource::Sphere { radius: striker.radius });
    }
    let clicks: Vec<AccelerationPulse> = clicks_of(&pulse, &sources).collect();
    let distance = strike.listener.length();
    let inside = |click: &AccelerationPulse| {
        click.source.silent_at(click.orientation.inverse() * (strike.listener - click.centre))
    };
    if clicks.iter().any(inside) {
        return Err(StrikeError::ListenerInside { distance });
    }
    // The band limit rings for as long after the sound as before it.
    let died_away = |click: &AccelerationPulse| {
        strike.listener.distance(click.centre) / strike.medium.sound_speed
            + strike.profile.extent(pulse.duration).1
            + click.source.ring_time(&strike.medium)
            + LEAD * (48_000.0 / strike.sample_rate.as_f64()).max(1.0)
    };
    let seconds = strike.seconds.unwrap_or_else(|| clicks.iter().map(died_away).fold(0.0, f64::max));
    if !(seconds > -LEAD && seconds.is_finite()) {
        return Err(StrikeError::Seconds { seconds });
    }

    let mut renderer = Renderer::new(&Listener::fixed("listener", strike.listener), &settings(strike))?;
    for click in &clicks {
        renderer.push(click)?;
    }
    let mut signal = OverlapAdd::new(1, 0);
    for job in renderer.take_all() {
        signal.add(&job.render());
    }
    let rate = strike.sample_rate.as_f64();
    let count = ((seconds + LEAD) * rate).ceil() as i64;
    let pressures = signal.take_until(count).swap_remove(0);
    let times = (0..pressures.len()).map(|i| i as f64 / rate - LEAD).collect();
    Ok(StrikeSound {
        times,
        pressures,
        duration: pulse.duration,
        velocity_change: pulse.bodies[0].map_or(DVec3::ZERO, |share| share.velocity_change),
        radius: body.surface.equal_volume_radius(),
    })
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
    let pulse = forces(body, Some(&source), strike)?;
    let settings = settings(strike);
    let listener = Listener::fixed("listener", strike.listener);
    // A body without rows stays at its start, so this cannot fail.
    let poses = PoseHistory::try_new(&[at_rest(body)], &[])
        .map_err(|_| StrikeError::NotFinite { what: "the pose" })?;
    let mut voice = ModalVoice::new(source, STRUCK, &poses, &listener, &settings)?;
    voice.push_pulses(&[pulse])?;
    let mut channels = [vec![0.0; sound.pressures.len()]];
    voice.render_block(0, &mut channels)?;
    let [ringing] = channels;
    Ok(ringing)
}

fn positive(x: f64) -> bool {
    x > 0.0 && x.is_finite()
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
