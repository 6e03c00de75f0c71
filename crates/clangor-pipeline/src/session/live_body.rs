//! A body for the real-time engine, with the sound model and the forces of [`Strike`].
//!
//! It makes the object of a slot, and turns impacts into events for that slot. The forces are those of the
//! offline renderer, so that the engine plays what [`Strike::render`] renders. The engine has no part in it:
//! all of this happens on the thread that sends the events.
//!
//! ```no_run
//! use clangor_core::pose::Pose;
//! use clangor_core::realtime::{EngineSettings, engine};
//! use clangor_core::synthesis::strike::StrikeForce;
//! use clangor_pipeline::session::{Strike, StruckBody};
//!
//! let settings = EngineSettings::default();
//! let (mut controller, mut engine) = engine(&settings)?; // the engine moves to the audio thread
//! let bowl = Strike::new(StruckBody::shape("bowl", "ceramic")?).live_body(&settings, &mut |_| {
//!     std::ops::ControlFlow::Continue(())
//! })?;
//! controller.put(0, Some(bowl.object(&settings)))?;
//! let force = StrikeForce::Impulse { impulse: [0.0, -0.01, 0.0].into(), duration: None };
//! for event in bowl.strike(0, force, None, &Pose::IDENTITY)? {
//!     controller.send(event)?;
//! }
//! let channels = engine.render(128); // pressure [Pa] at the left and the right ear
//! # let _ = channels;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::ops::ControlFlow;

use clangor_core::body::{Body, BodyId};
use clangor_core::contact::contact_side::rayleigh_speed;
use clangor_core::contact::{
    ContactSide, ForceSettings, Impact, ImpactPulse, ImpactSolver, Spread, Touch, contact_forces, touching,
};
use clangor_core::glam::DVec3;
use clangor_core::material::{Material, PairCoefficients};
use clangor_core::pose::Pose;
use clangor_core::realtime::{EngineSettings, ImpactEvent, ImpactTarget, SoundingObject};
use clangor_core::synthesis::strike::{self, StrikeError, StrikeForce};

use super::error::Error;
use super::progress::Progress;
use super::sounding_body::{SoundingBody, point_source};
use super::strike::Strike;
use super::struck_sound::StrikeRemark;

/// A body for the real-time engine: see the module.
#[derive(Clone, Debug)]
pub struct LiveBody {
    sounding: SoundingBody,
    /// What impacts on it have in common.
    impact: strike::Strike,
}

/// Where and how fast two bodies meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Meeting {
    /// Point [m, world].
    pub point: DVec3,
    /// Unit normal at the point, from the second side to the first \[world\].
    pub normal: DVec3,
    /// Speed of approach along the normal [m/s].
    pub speed: f64,
}

/// What a body meets.
#[derive(Clone, Copy, Debug)]
pub enum Partner<'a> {
    /// Another body of the engine, in a slot, at a pose.
    Body(&'a LiveBody, usize, Pose),
    /// Flat ground that does not move and is silent.
    Ground(&'a Material),
}

impl Strike {
    /// The body with its sound model, for an engine of these settings. The sound model is found or baked, as
    /// for [`render`](Self::render); progress goes to `on_progress`, which breaks to stop.
    ///
    /// Sample rate, band, medium and force profile are those of the engine.
    ///
    /// # Errors
    /// As [`render_with_progress`](Self::render_with_progress).
    pub fn live_body(
        self,
        settings: &EngineSettings,
        on_progress: &mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
    ) -> Result<LiveBody, Error> {
        let acoustics = &settings.acoustics;
        let mut choice = self.model;
        choice.options.max_frequency = acoustics.max_frequency.or(choice.options.max_frequency);
        choice.options.check(settings.sample_rate.as_f64())?;
        let impact = strike::Strike {
            sample_rate: settings.sample_rate,
            max_frequency: choice.options.max_frequency,
            medium: acoustics.medium,
            profile: settings.profile,
            ..self.impact
        };
        // A body that cannot be struck is reported before anything is baked.
        strike::strike(&self.body.body, &point_source(&self.body.body), None, &impact)?;
        let sounding = SoundingBody::obtain(&self.body, &choice, &self.parts, &impact, on_progress)?;
        Ok(LiveBody { sounding, impact })
    }
}

impl LiveBody {
    /// The body.
    pub fn body(&self) -> &Body {
        self.sounding.body()
    }

    /// Number of its modes.
    pub fn modes(&self) -> usize {
        self.sounding.resonances().len()
    }

    /// Defects of its sound model.
    pub fn remarks(&self) -> &[StrikeRemark] {
        self.sounding.remarks()
    }

    /// The object to put into a slot of an engine of these settings.
    pub fn object(&self, settings: &EngineSettings) -> SoundingObject {
        let (source, resonator) = self.sounding.sources();
        SoundingObject::new(Some(source.clone()), resonator.cloned(), settings)
    }

    /// The events of an impact at time 0 on the body in a slot, at a pose. `point` \[m\] and the vectors of
    /// the force are in the axes of the body, from its centre of mass; the default point is that of the
    /// [`Strike`]. A striker that is heard has events of its own.
    ///
    /// # Errors
    /// [`Error::Strike`].
    pub fn strike(
        &self,
        slot: usize,
        force: StrikeForce,
        point: Option<DVec3>,
        pose: &Pose,
    ) -> Result<Vec<ImpactEvent>, Error> {
        let point = point.unwrap_or(self.impact.point);
        let heard = match &force {
            StrikeForce::Striker(striker) if striker.heard => {
                Some(ImpactTarget::Sphere { radius: striker.radius })
            }
            _ => None,
        };
        let impact = strike::Strike { force, point, ..self.impact.clone() };
        let (_, resonator) = self.sounding.sources();
        let pulses = strike::forces(self.body(), resonator.map(|modes| &**modes), &impact)?;
        let targets = [Some(ImpactTarget::Object { slot }), heard];
        Ok(events(&pulses, targets).map(|event| placed(event, pose)).collect())
    }

    /// The events at time 0 of an impact of the body in a slot, at a pose, with what it meets. Restitution is
    /// that of the pair of materials; there is no friction.
    ///
    /// # Errors
    /// [`Error::Strike`] for a meeting that has no forces.
    pub fn meet(
        &self,
        (slot, pose): (usize, Pose),
        partner: Partner<'_>,
        meeting: &Meeting,
    ) -> Result<Vec<ImpactEvent>, Error> {
        let Meeting { point, normal, speed } = *meeting;
        let body = self.body();
        let (other, side, target) = match partner {
            Partner::Body(live, slot, pose) => {
                let side = ContactSide::of_body(SECOND, live.body(), pose);
                (Some(live), side, Some(ImpactTarget::Object { slot }))
            }
            Partner::Ground(material) => (None, ground(material), None),
        };
        let material = match partner {
            Partner::Body(live, ..) => &live.body().material,
            Partner::Ground(material) => material,
        };
        let own = ContactSide::of_body(FIRST, body, pose);
        let touch = Touch {
            surfaces: [Some(&*body.surface), other.map(|live| &*live.body().surface)],
            normal,
            place: point,
            speed,
            spread: Spread::single(own.bounding_radius.min(side.bounding_radius)),
        };
        let restitution = PairCoefficients::of(&body.material, material).restitution.at(speed);
        let sides = touching([own, side], &touch);
        let impact = Impact::with_restitution(sides, point, normal, speed, restitution);
        let modes_of = |id: BodyId, points: &[(DVec3, DVec3)]| {
            let live = if id == FIRST { Some(self) } else { other };
            live?.sounding.sources().1.map(|modes| modes.at_contact(points))
        };
        let settings = ForceSettings {
            profile: self.impact.profile,
            steps: self.impact.steps,
            band: 0.5 * self.impact.sample_rate.as_f64(),
            ..ForceSettings::default()
        };
        let pulses = contact_forces(&impact, &modes_of, &settings, &mut ImpactSolver::default());
        let pulses = pulses.map_err(StrikeError::from)?;
        Ok(events(&pulses, [Some(ImpactTarget::Object { slot }), target]).collect())
    }
}

/// The bodies of a meeting.
const FIRST: BodyId = BodyId(0);
const SECOND: BodyId = BodyId(1);

fn ground(material: &Material) -> ContactSide {
    ContactSide {
        compliance: material.contact_compliance(),
        rayleigh_speed: rayleigh_speed(material),
        ..ContactSide::SURROUNDINGS
    }
}

/// The events of all pulses on the sides that have a target.
fn events(pulses: &[ImpactPulse], targets: [Option<ImpactTarget>; 2]) -> impl Iterator<Item = ImpactEvent> {
    pulses.iter().flat_map(move |pulse| {
        let sides = targets.into_iter().enumerate();
        sides
            .filter_map(|(side, target)| target.map(|target| (side, target)))
            .flat_map(move |(side, target)| ImpactEvent::of_side(target, pulse, side))
    })
}

/// An event in the axes of a body at the origin, for that body at a pose.
fn placed(event: ImpactEvent, pose: &Pose) -> ImpactEvent {
    let turned = |vector: DVec3| pose.orientation * vector;
    ImpactEvent {
        pose: Pose {
            position: pose.world_from_body(event.pose.position),
            orientation: pose.orientation * event.pose.orientation,
        },
        velocity_change: turned(event.velocity_change),
        angular_velocity_change: turned(event.angular_velocity_change),
        point: pose.world_from_body(event.point),
        impulse: turned(event.impulse),
        ..event
    }
}
