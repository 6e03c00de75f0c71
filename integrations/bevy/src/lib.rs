//! Sound of the contacts of a physics world in Bevy, by Clangor's real-time engine.
//!
//! ```text
//! avian3d: contacts of a step ─► approach speed ─► impulse, Hertz: duration τ ─► ImpactEvent ─► ring
//!                                                              Engine, on the audio thread ◄──────┘
//! ```
//!
//! [`ClangorPlugin`] looks at every contact after each step of avian3d. One that approached faster than
//! [`V_MIN`] is an impact: its impulse is (1 + e) m V, of the approach, the effective mass and avian3d's
//! restitution, its duration that of Hertz's theory for the masses, curvatures and materials of the two
//! bodies. (The impulses that avian3d sums up over a step count some twice: 8.6 m/s for a ball that it turns
//! by 5.5.) A body with a [`Sounding`] is heard; the other one may be anything.
//!
//! The program calls `render` of the [`Engine`](clangor_core::realtime::Engine) that [`ClangorPlugin::new`]
//! returns from an audio callback; with the feature `playback`, [`playback`] does. An event is heard a block
//! and 97 samples after the step in which it happened, at most one step late.
//!
//! The manifold points of one contact are one impact, at their mean. All impacts within a step are at its
//! end, because the physics does not give their times within the step.

#[cfg(feature = "playback")]
pub mod playback;

use std::sync::{Mutex, PoisonError};

use avian3d::prelude::*;
use bevy::prelude::*;
use clangor_core::contact::hertz::HertzContact;
use clangor_core::glam::{DQuat, DVec3};
use clangor_core::material::Material;
use clangor_core::pose::Pose;
use clangor_core::realtime::{
    Controller, Engine, EngineSettings, Event as SoundEvent, ImpactEvent, ImpactTarget, engine,
};
use clangor_core::synthesis::SynthesisError;

/// Contacts that approach more slowly are silent [m/s].
pub const V_MIN: f32 = 0.05;
/// Distance of the two receivers of an [`Ears`] [m].
pub use clangor_core::realtime::EAR_DISTANCE;
/// Difference of the clocks of physics and sound at which their offset is set again [s].
const DRIFT: f64 = 0.1;

/// A body whose impacts are heard.
#[derive(Component, Clone, Debug)]
pub struct Sounding {
    /// The sphere of its volume, or an object put into a slot by [`Sound::controller`].
    pub target: ImpactTarget,
    /// Its material, for the duration of contacts.
    pub material: Material,
    /// Mean curvature of its surface at impacts [1/m].
    pub curvature: f64,
}

impl Sounding {
    /// A ball of this radius [m].
    pub fn ball(radius: f64, material: Material) -> Self {
        Sounding { target: ImpactTarget::Sphere { radius }, material, curvature: 1.0 / radius }
    }
}

/// The material of a flat body that is not heard itself: a floor, a wall.
#[derive(Component, Clone, Debug)]
pub struct Ground(pub Material);

/// Position of the listener; the receivers are to the left and right of it.
#[derive(Component, Clone, Copy, Debug, Default)]
#[require(Transform)]
pub struct Ears;

/// Connection to the engine.
#[derive(Resource)]
pub struct Sound {
    // One thread at a time may send.
    controller: Mutex<Controller>,
    /// Time of sound minus time of physics [s].
    offset: Option<f64>,
    /// Impacts sent.
    pub impacts: u64,
}

/// Plugin that sends the impacts of avian3d to an engine.
pub struct ClangorPlugin {
    controller: Mutex<Option<Controller>>,
}

impl ClangorPlugin {
    /// The plugin, and the engine that it sends events to.
    ///
    /// # Errors
    /// [`SynthesisError`] for settings out of range.
    pub fn new(settings: &EngineSettings) -> Result<(Self, Engine), SynthesisError> {
        let (controller, engine) = engine(settings)?;
        Ok((ClangorPlugin { controller: Mutex::new(Some(controller)) }, engine))
    }
}

impl Plugin for ClangorPlugin {
    fn build(&self, app: &mut App) {
        let mut held = self.controller.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(controller) = held.take() else { return };
        app.insert_resource(Sound { controller: Mutex::new(controller), offset: None, impacts: 0 });
        let systems = (follow_clock, send_receivers, send_poses, send_impacts).chain();
        app.add_systems(PhysicsSchedule, systems.in_set(PhysicsStepSystems::Last));
    }
}

impl Sound {
    /// Sends events, and puts objects into slots.
    pub fn controller(&mut self) -> &mut Controller {
        self.controller.get_mut().unwrap_or_else(PoisonError::into_inner)
    }

    /// The time of sound at a time of physics [s].
    fn time(&self, physics: f64) -> f64 {
        physics + self.offset.unwrap_or(0.0)
    }

    /// Sends an event. One for which there is no room is counted in the report of the engine.
    fn send(&mut self, event: impl Into<SoundEvent>) {
        let _ = self.controller().send(event);
    }
}

/// Keeps the clocks together: present impacts are heard as soon as possible.
fn follow_clock(mut sound: ResMut<Sound>, clock: Res<Time<Physics>>) {
    let now = sound.controller().report().time - clock.elapsed_secs_f64();
    if sound.offset.is_none_or(|offset| (offset - now).abs() > DRIFT) {
        sound.offset = Some(now);
    }
}

/// Sends the positions of the receivers.
fn send_receivers(mut sound: ResMut<Sound>, ears: Query<&Transform, With<Ears>>) {
    if let Some(ears) = ears.iter().next() {
        let middle = widened(ears.translation);
        // Without room in the ring, the next step sends again.
        let _ = sound.controller().place_listener(middle, widened(*ears.right()));
    }
}

type Moving<'a> = (&'a Sounding, &'a Position, &'a Rotation, &'a LinearVelocity, &'a AngularVelocity);

/// Sends the motion of modal objects.
fn send_poses(mut sound: ResMut<Sound>, clock: Res<Time<Physics>>, bodies: Query<Moving>) {
    let time = sound.time(clock.elapsed_secs_f64());
    for (sounding, position, rotation, velocity, spin) in &bodies {
        if let ImpactTarget::Object { slot } = sounding.target {
            let (velocity, angular_velocity) = (widened(velocity.0), widened(spin.0));
            let pose = pose_of(position, rotation);
            sound.send(SoundEvent::Pose { slot, time, pose, velocity, angular_velocity });
        }
    }
}

/// A vector of Bevy's glam as one of Clangor's, which may be of another version.
fn widened(vector: Vec3) -> DVec3 {
    DVec3::from_array(vector.to_array().map(f64::from))
}

fn pose_of(position: &Position, rotation: &Rotation) -> Pose {
    let orientation = DQuat::from_array(rotation.0.to_array().map(f64::from)).normalize();
    Pose { position: widened(position.0), orientation }
}

type ContactBody<'a> = (
    Option<&'a Sounding>,
    Option<&'a Ground>,
    &'a Position,
    &'a Rotation,
    Option<&'a ComputedMass>,
    Option<&'a ComputedAngularInertia>,
    Option<&'a ComputedCenterOfMass>,
);

/// Properties of a body in a contact.
struct Side {
    target: Option<ImpactTarget>,
    pose: Pose,
    inverse_mass: f64,
    inverse_inertia: Mat3,
    curvature: f64,
    compliance: f64,
}

impl Side {
    fn of((sounding, ground, position, rotation, mass, inertia, centre): ContactBody<'_>) -> Self {
        let mut pose = pose_of(position, rotation);
        if let Some(centre) = centre {
            pose.position += pose.orientation * widened(centre.0);
        }
        let material = sounding.map(|s| &s.material).or(ground.map(|g| &g.0));
        let turn = Mat3::from_quat(rotation.0);
        let inverse = inertia.map_or(Mat3::ZERO, |inertia| Mat3::from(inertia.inverse()));
        Side {
            target: sounding.map(|sounding| sounding.target),
            pose,
            inverse_mass: mass.map_or(0.0, |mass| f64::from(mass.inverse())),
            inverse_inertia: turn * inverse * turn.transpose(),
            curvature: sounding.map_or(0.0, |sounding| sounding.curvature),
            compliance: material.map_or(0.0, Material::contact_compliance),
        }
    }

    /// Inverse effective mass at a point along a direction [1/kg].
    fn inverse_mass_at(&self, point: DVec3, normal: DVec3) -> f64 {
        let lever = (point - self.pose.position).cross(normal).as_vec3();
        let lever = Vec3::from_array(lever.to_array());
        self.inverse_mass + f64::from(lever.dot(self.inverse_inertia * lever))
    }

    /// The impact of an impulse at a point on this body; `None` if it is silent.
    fn impact(&self, time: f64, duration: f64, point: DVec3, impulse: DVec3) -> Option<ImpactEvent> {
        let twist = (point - self.pose.position).cross(impulse).as_vec3();
        let twist = Vec3::from_array(twist.to_array());
        let angular_velocity_change = widened(self.inverse_inertia * twist);
        let impact = ImpactEvent::new(self.target?, time, duration)
            .with_pose(self.pose)
            .with_velocity_changes(impulse * self.inverse_mass, angular_velocity_change)
            .with_impulse(point, impulse);
        Some(impact)
    }
}

/// Sends the contacts that approached in this step as impacts.
fn send_impacts(
    mut sound: ResMut<Sound>,
    clock: Res<Time<Physics>>,
    contacts: Collisions,
    bodies: Query<ContactBody>,
) {
    let time = sound.time(clock.elapsed_secs_f64());
    for pair in contacts.iter() {
        let points = || pair.manifolds.iter().flat_map(|m| m.points.iter().map(move |p| (m, p)));
        let touches = |p: &ContactPoint| p.normal_impulse > 0.0;
        let approach = points().filter(|(_, p)| touches(p)).map(|(_, p)| -p.normal_speed).fold(0.0, f32::max);
        let (Some(one), Some(two)) = (pair.body1, pair.body2) else { continue };
        if approach < V_MIN {
            continue;
        }
        let (Ok(one), Ok(two)) = (bodies.get(one), bodies.get(two)) else { continue };
        let sides = [Side::of(one), Side::of(two)];
        // Mean over the points, weighted by their normal impulses.
        let total: f32 = points().map(|(_, p)| p.normal_impulse).sum();
        let share = |p: &ContactPoint| f64::from(p.normal_impulse / total);
        let point: DVec3 = points().map(|(_, p)| widened(p.point) * share(p)).sum();
        // Normals point from the first body to the second.
        let normal = points().map(|(m, p)| widened(m.normal) * share(p)).sum::<DVec3>().normalize_or_zero();
        let restitution = points().map(|(m, p)| f64::from(m.restitution) * share(p)).sum::<f64>();
        let contact = HertzContact {
            inverse_mass: sides.iter().map(|side| side.inverse_mass_at(point, normal)).sum(),
            curvature: sides.iter().map(|side| side.curvature).sum(),
            compliance: sides.iter().map(|side| side.compliance).sum(),
            speed: f64::from(approach),
        };
        let duration = contact.duration();
        let impulse = normal * ((1.0 + restitution) * contact.speed / contact.inverse_mass);
        for (side, impulse) in sides.iter().zip([-impulse, impulse]) {
            if let Some(impact) = side.impact(time, duration, point, impulse) {
                sound.impacts += 1;
                sound.send(impact);
            }
        }
    }
}
