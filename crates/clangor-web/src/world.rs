//! The moving world of a page: spheres and planes of a scene, in a [`LiveWorld`].
//!
//! Lists are valid until the next call. All functions may be called before [`world_load`]: the world is then
//! empty.

use std::cell::RefCell;

use clangor_core::body::{Body, BodyId, Link, LinkEnd, Motion, Surface, World};
use clangor_core::material::Material;
use clangor_core::material::presets;
use clangor_core::realtime::{ImpactEvent, ImpactTarget, event_row};
use clangor_core::scene::instantiate::load_shape;
use clangor_core::scene::{Scene, instantiate};
use clangor_sim::Solver;
use clangor_sim::live::{LiveError, LiveSettings, LiveWorld};
use glam::DVec3;
use serde_json::json;

use crate::layout::{BODY_STRIDE, CONTACT_STRIDE, EVENT_STRIDE, LINK_STRIDE, contact_row};
use crate::wasm_buffer::{self, status};

/// Numbers of a ball to be added by [`world_add_sphere`].
pub const SPHERE_NUMBERS: usize = 7;
/// Events that the solvers compute per second, a low estimate: a processor of 2015 in a browser.
const EVENTS_PER_SECOND: f64 = 2e5;
/// Largest and default computation time per call \[s\].
const LONGEST_BUDGET: f64 = 2.0;
const USUAL_BUDGET: f64 = 0.02;

thread_local! {
    static STATE: RefCell<State> = RefCell::default();
}

#[derive(Default)]
struct State {
    world: Option<LiveWorld>,
    materials: Vec<Material>,
    events: Vec<f64>,
    contacts: Vec<f64>,
    bodies: Vec<f64>,
    links: Vec<f64>,
    poses: Vec<f32>,
    velocities: Vec<f32>,
}

/// Reasons for the world's refusals.
#[derive(Debug, thiserror::Error)]
enum WorldError {
    #[error("the scene is not UTF-8 text")]
    NotText,
    #[error("{0}")]
    Scene(String),
    #[error(transparent)]
    Live(#[from] LiveError),
    #[error("no scene has been loaded")]
    Empty,
    #[error("there is no material {index}; there are {count}")]
    UnknownMaterial { index: u32, count: usize },
}

impl State {
    fn load(&mut self, text: &[u8]) -> Result<i32, WorldError> {
        let text = str::from_utf8(text).map_err(|_| WorldError::NotText)?;
        let refuse =
            |error: clangor_core::scene::diagnostic::SceneErrors| WorldError::Scene(error.to_string());
        let scene = Scene::from_toml(text).map_err(refuse)?;
        let world = instantiate(&scene, &mut load_shape).map_err(refuse)?.world;
        let settings = LiveSettings { v_min: scene.simulation.v_min, ..LiveSettings::default() };
        let live = LiveWorld::new(&world, settings)?;
        *self = State { materials: materials(&world), world: Some(live), ..State::default() };
        Ok(0)
    }

    fn world(&mut self) -> Result<&mut LiveWorld, WorldError> {
        self.world.as_mut().ok_or(WorldError::Empty)
    }

    fn advance(&mut self, until: f64, budget: f64) -> Result<i32, WorldError> {
        let seconds = if budget > 0.0 { budget.min(LONGEST_BUDGET) } else { USUAL_BUDGET };
        let world = self.world()?;
        let done = world.advance(until, (seconds * EVENTS_PER_SECOND) as u64);
        self.collect();
        Ok(if done? { 0 } else { 1 })
    }

    /// Takes the impacts out of the world.
    fn collect(&mut self) {
        let State { world: Some(world), events, contacts, .. } = self else { return };
        let mut encoder = event_row::RowEncoder::default();
        for pulse in world.impacts() {
            let body = |id: BodyId| if id == BodyId::WORLD { -1.0 } else { f64::from(id.0) };
            let row = contact_row(pulse, pulse.pair.map(body));
            contacts.extend(row);
            for (side, share) in pulse.bodies.iter().enumerate() {
                let Some(share) = share else { continue };
                if let Some(Surface::Sphere { radius }) = world.body(share.body).map(|body| &*body.surface) {
                    let target = ImpactTarget::Sphere { radius: *radius };
                    for impact in ImpactEvent::of_side(target, pulse, side) {
                        events.extend(encoder.encode(&impact.into(), share.body.0).into_iter().flatten());
                    }
                }
            }
        }
        world.clear();
    }
}

/// Materials of a world's bodies in their order, then the library's.
fn materials(world: &World) -> Vec<Material> {
    let mut materials: Vec<Material> = Vec::new();
    let library = presets::PRESETS.iter().map(presets::Preset::material);
    for material in world.bodies.iter().map(|body| body.material.clone()).chain(library) {
        if !materials.iter().any(|known| known.name == material.name) {
            materials.push(material);
        }
    }
    materials
}

/// Loads the scene that lies in the buffer, as TOML of so many bytes: its spheres, planes, springs, hung
/// spheres and gravity. The clock shows 0.
pub fn world_load(scene_bytes: u32) -> i32 {
    let text = wasm_buffer::bytes(scene_bytes);
    STATE.with_borrow_mut(|state| status(state.load(&text)))
}

/// Advances to a time \[s\]. Returns 0 when done, and 1 after about the given computation time \[s\] (0: 20
/// ms); call again then.
pub fn world_advance(until: f64, budget_s_hint: f64) -> i32 {
    STATE.with_borrow_mut(|state| status(state.advance(until, budget_s_hint)))
}

/// The time reached \[s\], at most 2 ms beyond the time requested.
pub fn world_time() -> f64 {
    STATE.with_borrow(|state| state.world.as_ref().map_or(0.0, LiveWorld::time))
}

/// Number of bodies. The number of a removed body is reused for a body added later.
pub fn world_body_count() -> u32 {
    STATE.with_borrow(|state| state.world.as_ref().map_or(0, LiveWorld::count) as u32)
}

/// For each body [`BODY_STRIDE`] numbers: radius \[m\], 0 for a plane or where a body has been removed; index
/// of the material; 1 if it moves freely; 1 if it is a plane; outward normal of the plane; n·x of its surface
/// \[m\].
pub fn world_bodies() -> *const f64 {
    STATE.with_borrow_mut(|state| {
        let State { world, materials, bodies, .. } = state;
        bodies.clear();
        let count = world.as_ref().map_or(0, LiveWorld::count) as u32;
        for id in (0..count).map(BodyId) {
            let body = world.as_ref().and_then(|world| world.body(id));
            bodies.extend(body.map_or([0.0; BODY_STRIDE], |body| described(body, materials)));
        }
        bodies.as_ptr()
    })
}

fn described(body: &Body, materials: &[Material]) -> [f64; BODY_STRIDE] {
    let material = materials.iter().position(|m| m.name == body.material.name).unwrap_or(0);
    let radius = if let Surface::Sphere { radius } = *body.surface { radius } else { 0.0 };
    let is_plane = body.surface.is_plane();
    let normal = if is_plane { body.pose.orientation * DVec3::Y } else { DVec3::ZERO };
    let flag = |is: bool| f64::from(u8::from(is));
    let [x, y, z] = normal.to_array();
    let free = flag(body.motion == Motion::Free);
    [radius, material as f64, free, flag(is_plane), x, y, z, normal.dot(body.pose.position)]
}

/// Number of rods and springs.
pub fn world_link_count() -> u32 {
    STATE.with_borrow(|state| state.world.as_ref().map_or(0, |world| world.links().len()) as u32)
}

/// For each rod and spring [`LINK_STRIDE`] numbers: 0 for a rod, 1 for a spring; the body at one end; the
/// body at the other or −1; the fixed point where there is none \[m\]; the length without force \[m\], 0 for
/// a rod; 0.
pub fn world_links() -> *const f64 {
    STATE.with_borrow_mut(|state| {
        let State { world, links, .. } = state;
        links.clear();
        links.extend(world.iter().flat_map(LiveWorld::links).filter_map(described_link).flatten());
        links.as_ptr()
    })
}

/// `None` for links that the solver of the page does not have.
fn described_link(link: &Link) -> Option<[f64; LINK_STRIDE]> {
    let row = |kind: f64, body: BodyId, other: f64, end: DVec3, length: f64| {
        Some([kind, f64::from(body.0), other, end.x, end.y, end.z, length, 0.0])
    };
    match *link {
        Link::Hang { body, anchor } => row(0.0, body, -1.0, anchor, 0.0),
        Link::Spring { body, to: LinkEnd::Point(end), rest_length, .. } => {
            row(1.0, body, -1.0, end, rest_length)
        }
        Link::Spring { body, to: LinkEnd::Body { body: other, .. }, rest_length, .. } => {
            row(1.0, body, f64::from(other.0), DVec3::ZERO, rest_length)
        }
        Link::Joint { .. } | Link::Load { .. } => None,
    }
}

/// Sets the message to the materials, a JSON list in the order of their indices: those of the
/// scene, then the library's. Returns their number.
pub fn world_materials() -> i32 {
    STATE.with_borrow(|state| {
        let list: Vec<_> = state
            .materials
            .iter()
            .map(|m| {
                json!({
                    "name": m.name, "density": m.density, "youngs_modulus": m.youngs_modulus,
                    "poisson_ratio": m.poisson_ratio, "restitution": m.restitution, "friction": m.friction,
                })
            })
            .collect();
        wasm_buffer::tell(json!(list).to_string());
        list.len() as i32
    })
}

/// For each body its position and its orientation x, y, z, w.
pub fn world_poses() -> *const f32 {
    STATE.with_borrow_mut(|state| {
        let states = state.world.as_ref().map_or(Vec::new(), LiveWorld::states);
        state.poses.clear();
        for body in &states {
            state.poses.extend(body.pose.position.as_vec3().to_array());
            state.poses.extend(body.pose.orientation.as_quat().to_array());
        }
        state.poses.as_ptr()
    })
}

/// For each body its velocity [m/s].
pub fn world_velocities() -> *const f32 {
    STATE.with_borrow_mut(|state| {
        let states = state.world.as_ref().map_or(Vec::new(), LiveWorld::states);
        state.velocities.clear();
        state.velocities.extend(states.iter().flat_map(|body| body.velocity.as_vec3().to_array()));
        state.velocities.as_ptr()
    })
}

/// Number of events since the last [`world_clear`].
pub fn world_events_count() -> u32 {
    STATE.with_borrow(|state| (state.events.len() / EVENT_STRIDE) as u32)
}

/// The events in world time: one impact for each ball that a contact accelerates.
pub fn world_events() -> *const f64 {
    STATE.with_borrow(|state| state.events.as_ptr())
}

/// Number of impacts since the last [`world_clear`].
pub fn world_contacts_count() -> u32 {
    STATE.with_borrow(|state| (state.contacts.len() / CONTACT_STRIDE) as u32)
}

/// For each impact [`CONTACT_STRIDE`] numbers: time \[s\], bodies A and B (−1: none), approach speed [m/s],
/// normal impulse [N s], duration τ \[s\], point \[m\], effective mass \[kg\], 0, 0.
pub fn world_contacts() -> *const f64 {
    STATE.with_borrow(|state| state.contacts.as_ptr())
}

/// Forgets the events and impacts so far.
pub fn world_clear() {
    STATE.with_borrow_mut(|state| {
        state.events.clear();
        state.contacts.clear();
    });
}

/// Calls `read` with the events and the impacts so far.
pub fn with_events<T>(read: impl FnOnce(&[f64], &[f64]) -> T) -> T {
    STATE.with_borrow(|state| read(&state.events, &state.contacts))
}

fn change(act: impl FnOnce(&mut LiveWorld) -> Result<i32, LiveError>) -> i32 {
    STATE.with_borrow_mut(|state| {
        let outcome = state.world().and_then(|world| Ok(act(world)?));
        state.collect();
        status(outcome)
    })
}

/// Sets the velocity of the centre of a ball [m/s].
pub fn world_set_velocity(body: u32, x: f64, y: f64, z: f64) -> i32 {
    change(|world| world.set_velocity(BodyId(body), DVec3::new(x, y, z)).map(|()| 0))
}

/// Adds a ball of a material of [`world_materials`] with the [`SPHERE_NUMBERS`] numbers in the buffer: radius
/// and position \[m\], velocity [m/s]. Returns its number.
pub fn world_add_sphere(material: u32) -> i32 {
    let numbers = wasm_buffer::with_words(|words| {
        let first = words.first_chunk::<SPHERE_NUMBERS>().copied();
        first.unwrap_or_default().map(f64::from_bits)
    });
    let [radius, x, y, z, vx, vy, vz] = numbers;
    STATE.with_borrow_mut(|state| {
        let count = state.materials.len();
        let known = state.materials.get(material as usize).cloned();
        let outcome = known.ok_or(WorldError::UnknownMaterial { index: material, count }).and_then(|known| {
            let (position, velocity) = (DVec3::new(x, y, z), DVec3::new(vx, vy, vz));
            Ok(state.world()?.add(&known, radius, position, velocity)?.0 as i32)
        });
        state.collect();
        status(outcome)
    })
}

/// Removes a ball.
pub fn world_remove(body: u32) -> i32 {
    change(|world| world.remove(BodyId(body)).map(|()| 0))
}

/// Changes gravity [m/s²].
pub fn world_gravity(x: f64, y: f64, z: f64) -> i32 {
    change(|world| world.set_gravity(DVec3::new(x, y, z)).map(|()| 0))
}

/// Kinetic and potential energy \[J\].
pub fn world_energy() -> f64 {
    STATE.with_borrow(|state| state.world.as_ref().map_or(0.0, LiveWorld::energy))
}

/// Solver in use: 0 exact, 1 stepped.
pub fn world_solver() -> u32 {
    STATE.with_borrow(|state| match state.world.as_ref().map(LiveWorld::solver) {
        None | Some(Solver::Spheres) => 0,
        Some(_) => 1,
    })
}
