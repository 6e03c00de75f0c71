//! Sound of the contacts of a physics world in Bevy, by Clangor's real-time engine.
//!
//! ```text
//! avian3d: contacts of a step ─► approach speed ─► contact_forces ─► ImpactEvents ─► ring
//!                                                  Engine, on the audio thread ◄──────┘
//! ```
//!
//! [`ClangorPlugin`] looks at every contact after each step of avian3d. One that approached faster than
//! [`V_MIN`] is an impact. [`contact_forces`](fn@contact_forces) makes its forces, as for every other part of
//! Clangor: avian3d gives the masses, the approach speed and the restitution, [`Sounding`] and [`Ground`] the
//! surfaces and the materials. (The impulses that avian3d sums up over a step count some twice: 8.6 m/s for a
//! ball that it turns by 5.5.) A body with a [`Sounding`] is heard; the other one may be anything.
//!
//! The program calls `render` of the [`Engine`](clangor_core::realtime::Engine) that [`ClangorPlugin::new`]
//! returns from an audio callback; with the feature `playback`, [`playback`] does. An event is heard a block
//! and 97 samples after the step in which it happened, at most one step late.
//!
//! The manifold points of one contact are one impact, at their mean. All impacts within a step are at its
//! end, because the physics does not give their times within the step. Both bodies are where their surfaces
//! touch, because after the step they have moved apart. The gap between them at the beginning of the step is
//! shared as their velocities share the approach in the frame without momentum; the way of that frame until
//! they touch is neglected. Their orientations are those after the step.

#[cfg(feature = "playback")]
pub mod playback;

use std::sync::{Arc, Mutex, PoisonError};

use avian3d::prelude::*;
use bevy::prelude::*;
use clangor_core::body::{Body, BodyId, EDGE_RADIUS_RATIO, Surface};
use clangor_core::contact::contact_side::rayleigh_speed;
use clangor_core::contact::{
    ContactSide, ForceProfile, ForceSettings, Impact, ImpactSolver, contact_forces,
};
use clangor_core::glam::{DMat3, DQuat, DVec3};
use clangor_core::material::Material;
use clangor_core::pose::Pose;
use clangor_core::realtime::{
    Controller, Engine, EngineSettings, Event as SoundEvent, ImpactEvent, ImpactTarget, engine,
};
use clangor_core::synthesis::SynthesisError;
use clangor_core::synthesis::modal::ModalSource;

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
    /// Its surface about the centre of mass, for the curvature at impacts.
    pub surface: Arc<Surface>,
    /// Lower bound of the radius of that curvature [m], for edges.
    pub edge_radius: f64,
    /// Its modes, whose energy bounds the force on them.
    pub modes: Option<Arc<ModalSource>>,
}

impl Sounding {
    /// A ball of this radius [m].
    pub fn ball(radius: f64, material: Material) -> Self {
        Sounding {
            target: ImpactTarget::Sphere { radius },
            material,
            surface: Arc::new(Surface::Sphere { radius }),
            edge_radius: EDGE_RADIUS_RATIO * radius,
            modes: None,
        }
    }

    /// An object put into a slot by [`Sound::controller`], with the surface and the material of a body, and
    /// its modes, if it has any.
    pub fn object(slot: usize, body: &Body, modes: Option<Arc<ModalSource>>) -> Self {
        Sounding {
            target: ImpactTarget::Object { slot },
            material: body.material.clone(),
            surface: Arc::clone(&body.surface),
            edge_radius: body.edge_radius,
            modes,
        }
    }
}

/// The material of a flat body that is not heard itself: a floor, a wall.
#[derive(Component, Clone, Debug)]
pub struct Ground(pub Material);

/// The listener; the receivers are to the left and right of its position in the world (`GlobalTransform`),
/// which Bevy's `TransformPlugin` computes. It may be the child of another entity, such as a camera or a
/// head.
#[derive(Component, Clone, Copy, Debug, Default)]
#[require(Transform)]
pub struct Ears;

/// Connection to the engine.
#[derive(Resource)]
pub struct Sound {
    // One thread at a time may send.
    controller: Mutex<Controller>,
    /// Time profile of the forces.
    profile: ForceProfile,
    /// Keeps the vibration of the bodies from impact to impact; its bodies are the indices of entities.
    solver: ImpactSolver,
    /// Time of sound minus time of physics [s].
    offset: Option<f64>,
    /// Impacts sent.
    pub impacts: u64,
}

/// Plugin that sends the impacts of avian3d to an engine.
pub struct ClangorPlugin {
    controller: Mutex<Option<Controller>>,
    profile: ForceProfile,
}

impl ClangorPlugin {
    /// The plugin, and the engine that it sends events to.
    ///
    /// # Errors
    /// [`SynthesisError`] for settings out of range.
    pub fn new(settings: &EngineSettings) -> Result<(Self, Engine), SynthesisError> {
        let (controller, engine) = engine(settings)?;
        let controller = Mutex::new(Some(controller));
        Ok((ClangorPlugin { controller, profile: settings.profile }, engine))
    }
}

impl Plugin for ClangorPlugin {
    fn build(&self, app: &mut App) {
        let mut held = self.controller.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(controller) = held.take() else { return };
        let (controller, profile) = (Mutex::new(controller), self.profile);
        let solver = ImpactSolver::default();
        app.insert_resource(Sound { controller, profile, solver, offset: None, impacts: 0 });
        let systems = (follow_clock, send_poses, send_impacts).chain();
        app.add_systems(PhysicsSchedule, systems.in_set(PhysicsStepSystems::Last));
        // In every frame, where the frame shows the listener: also between two steps of the physics.
        app.add_systems(PostUpdate, send_receivers.after(TransformSystems::Propagate));
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

/// Sends the positions of the receivers in the world.
fn send_receivers(mut sound: ResMut<Sound>, ears: Query<&GlobalTransform, With<Ears>>) {
    if let Some(ears) = ears.iter().next() {
        let middle = widened(ears.translation());
        // Without room in the ring, the next frame sends again.
        let _ = sound.controller().place_listener(middle, widened(*ears.right()));
    }
}

type Moving<'a> = (
    &'a Sounding,
    &'a Position,
    &'a Rotation,
    Option<&'a ComputedCenterOfMass>,
    &'a LinearVelocity,
    &'a AngularVelocity,
);

/// Sends the motion of modal objects.
fn send_poses(mut sound: ResMut<Sound>, clock: Res<Time<Physics>>, bodies: Query<Moving>) {
    let time = sound.time(clock.elapsed_secs_f64());
    for (sounding, position, rotation, centre, velocity, spin) in &bodies {
        if let ImpactTarget::Object { slot } = sounding.target {
            let (velocity, angular_velocity) = (widened(velocity.0), widened(spin.0));
            let orientation = orientation_of(rotation);
            let centre = centre.map_or(DVec3::ZERO, |centre| orientation * widened(centre.0));
            let pose = Pose { position: widened(position.0) + centre, orientation };
            sound.send(SoundEvent::Pose { slot, time, pose, velocity, angular_velocity });
        }
    }
}

/// A vector of Bevy's glam as one of Clangor's, which may be of another version.
fn widened(vector: Vec3) -> DVec3 {
    DVec3::from_array(vector.to_array().map(f64::from))
}

fn orientation_of(rotation: &Rotation) -> DQuat {
    DQuat::from_array(rotation.0.to_array().map(f64::from)).normalize()
}

type ContactBody<'a> = (
    Option<&'a Sounding>,
    Option<&'a Ground>,
    &'a RigidBody,
    &'a Rotation,
    Option<&'a ComputedMass>,
    Option<&'a ComputedAngularInertia>,
);

/// 1/M [1/kg]; 0 for a body that contacts do not move, to which avian3d gives the mass of its collider too.
fn inverse_mass(&(_, _, rigid_body, _, mass, _): &ContactBody) -> f64 {
    let mass = mass.filter(|_| rigid_body.is_dynamic());
    mass.map_or(0.0, |mass| f64::from(mass.inverse()))
}

/// A body in a contact.
struct Side<'a> {
    sounding: Option<&'a Sounding>,
    /// As the forces see it.
    contact: ContactSide,
}

impl<'a> Side<'a> {
    /// The body with this number, with its centre of mass at `centre` [m, world], touched at a
    /// point [m, world] along a unit normal.
    fn touched_at(
        id: BodyId,
        body: ContactBody<'a>,
        centre: DVec3,
        [point, normal]: [DVec3; 2],
    ) -> Self {
        let (sounding, ground, _, rotation, _, inertia) = body;
        let inverse_mass = inverse_mass(&body);
        let pose = Pose { position: centre, orientation: orientation_of(rotation) };
        let material = sounding.map(|s| &s.material).or(ground.map(|g| &g.0));
        let inertia = inertia.filter(|_| inverse_mass > 0.0);
        let inverse_inertia = inertia.map_or(Mat3::ZERO, |inertia| Mat3::from(inertia.inverse()));
        let flat = ContactSide {
            body: id,
            pose,
            inverse_mass,
            inverse_inertia: DMat3::from_cols_array(&inverse_inertia.to_cols_array().map(f64::from)),
            compliance: material.map_or(0.0, Material::contact_compliance),
            rayleigh_speed: material.map_or(f64::INFINITY, rayleigh_speed),
            ..ContactSide::SURROUNDINGS
        };
        let contact = match sounding {
            None => flat,
            Some(Sounding { surface, edge_radius, .. }) => {
                let bounding_radius = surface.bounding_radius();
                ContactSide { edge_radius: *edge_radius, bounding_radius, ..flat }
                    .touched_at(surface, normal, std::iter::once((point, 1.0)))
            }
        };
        Side { sounding, contact }
    }
}

/// Where two bodies meet.
struct Touch {
    /// Mean point [m, world].
    point: DVec3,
    /// Centres of mass of the first and the second body when their surfaces are there [m, world].
    centres: [DVec3; 2],
}

impl Touch {
    /// Of the normals of a contact from the first body to the second, its points, and their weights, which
    /// sum to 1. The bodies have these shares of the way to each other.
    ///
    /// avian3d finds the points at the beginning of the step, midway between the surfaces.
    fn new<'a>(points: impl Iterator<Item = (Vec3, &'a ContactPoint, f64)>, shares: [f64; 2]) -> Self {
        let nowhere = Touch { point: DVec3::ZERO, centres: [DVec3::ZERO; 2] };
        points.fold(nowhere, |Touch { point, centres: [first, second] }, (normal, contact, weight)| {
            let gap = widened(normal) * -f64::from(contact.penetration);
            let middle = widened(contact.point);
            Touch {
                point: point + weight * (middle + 0.5 * (shares[0] - shares[1]) * gap),
                centres: [
                    first + weight * (middle - widened(contact.anchor1) + shares[0] * gap),
                    second + weight * (middle - widened(contact.anchor2) - shares[1] * gap),
                ],
            }
        })
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
        let (Some(first_entity), Some(second_entity)) = (pair.body1, pair.body2) else { continue };
        if approach < V_MIN {
            continue;
        }
        let (Ok(one), Ok(two)) = (bodies.get(first_entity), bodies.get(second_entity)) else { continue };
        // Mean over the points, weighted by their normal impulses.
        let total: f32 = points().map(|(_, p)| p.normal_impulse).sum();
        let share = |p: &ContactPoint| f64::from(p.normal_impulse / total);
        // Normals point from the first body to the second.
        let normal = points().map(|(m, p)| widened(m.normal) * share(p)).sum::<DVec3>().normalize_or_zero();
        let restitution = points().map(|(m, p)| f64::from(m.restitution) * share(p)).sum::<f64>();
        // Each body has its part of the approach in the frame in which their momenta cancel.
        let inverse_masses = [inverse_mass(&one), inverse_mass(&two)];
        let inverse_total: f64 = inverse_masses.iter().sum();
        if inverse_total <= 0.0 {
            continue;
        }
        let ways = inverse_masses.map(|inverse| inverse / inverse_total);
        let weighted = points().map(|(m, p)| (m.normal, p, share(p)));
        let Touch { point, centres: [first, second] } = Touch::new(weighted, ways);
        // A is the second body: its normal points from the first one to it.
        let sides = [(second_entity, two, second), (first_entity, one, first)].map(|(entity, body, centre)| {
            Side::touched_at(BodyId(entity.index_u32()), body, centre, [point, normal])
        });
        let [a, b] = &sides;
        let impact =
            Impact::with_restitution([a.contact, b.contact], point, normal, f64::from(approach), restitution);
        let modes_of = |id: BodyId, points: &[(DVec3, DVec3)]| {
            let side = sides.iter().find(|side| side.contact.body == id)?;
            Some(side.sounding?.modes.as_ref()?.at_contact(points))
        };
        let settings = ForceSettings { profile: sound.profile, ..ForceSettings::default().live() };
        // Two bodies without material have no impact.
        let forces = contact_forces(&impact.at_time(time), &modes_of, &settings, &mut sound.solver);
        let Ok(pulses) = forces else { continue };
        for (index, side) in sides.iter().enumerate() {
            let Some(target) = side.sounding.map(|sounding| sounding.target) else { continue };
            let of_side = |pulse| ImpactEvent::of_side(target, pulse, index);
            let mut events = pulses.iter().flat_map(of_side).peekable();
            sound.impacts += u64::from(events.peek().is_some());
            events.for_each(|event| sound.send(event));
        }
    }
}
