//! What sounds, as files for the slots of a live engine, and the events that make it sound.
//!
//! A body rings by few of the numbers of its modes: those at the places where it is struck. So the file of a
//! ringing body has no surface but these places, each a triangle without area, and the shapes of the modes
//! there. An ellipsoid in place of a piece is given the motions that the impacts on the piece make in it, and
//! looks like any other body.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::sync::Arc;

use clangor_core::body::{Body, BodyId};
use clangor_core::contact::{BodyPulse, ImpactPulse};
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::glam::{DMat3, DQuat, DVec3};
use clangor_core::medium::Medium;
use clangor_core::sound_model::BodyModes;
use clangor_core::sound_model::acceleration::model::AccelerationModel;
use clangor_core::sound_model::acceleration::proxy_field::{LEAST_ORDER, mean_field};
use clangor_core::sound_model::files::modal_file::{ModalFile, ModalOrigin, ModalPart};
use clangor_core::sound_model::files::model_file::{ModelFile, Origin, Solid};
use clangor_core::sound_model::modal::model::{ModalMode, ModalModel, ModalTransfer};
use clangor_core::sound_model::modal::surface::{ModalSurface, SurfaceLocator};
use clangor_core::sound_model::soundbank::modal_soundbank::{ContactMapping, ModalProxy};
use clangor_core::synthesis::modal::ModalSource;
use clangor_core::synthesis::source_rule::SourceKind;
use serde_json::{Value, json};

use super::{Replay, ReplayError, STRIDE};
use crate::stages::event_schedule::Moving;
use crate::stages::render::{Forces, impacts_on};

/// Places on one body at most; what strikes elsewhere strikes the nearest.
const MOST_PLACES: usize = 256;
/// Part of the bounding radius within which places are one.
const SAME_PLACE: f64 = 1e-4;
/// Places are kept inside the bounding sphere, as far from the centre as this part of it.
const INSIDE: f64 = 0.999_999;
/// Longest T60 that is told \[s\].
const LONGEST_T60: f64 = 1000.0;

/// How far a ringing body may be from where it was told to be \[m\], and turned \[rad\].
const LARGEST_STEP: f64 = 2e-4;
const LARGEST_TURN: f64 = 5e-3;
/// How often that is looked at \[s\].
const LOOK_EVERY: f64 = 1.0 / 480.0;

/// A slot of the engine.
pub(super) struct Slot {
    body: BodyId,
    /// From the frame of what sounds to that of the body.
    rotation: DQuat,
    /// The file.
    pub(super) bytes: Vec<u8>,
    /// Frequencies \[Hz\] and T60 \[s\] of its material; of what does not ring none.
    t60: Vec<[f64; 2]>,
}

pub(super) struct Sounds {
    pub(super) slots: Vec<Slot>,
    /// What each struck body clicks as.
    clicks: BTreeMap<BodyId, AccelerationPulse>,
    /// Slots in which bodies ring, and the places there.
    rings: BTreeMap<BodyId, (usize, Places)>,
}

enum AccelerationPulse {
    Sphere { radius: f64 },
    Slot(usize),
}

impl Slot {
    pub(super) fn describe(&self) -> Value {
        json!({ "body": self.body.0, "rotation": self.rotation.to_array(), "t60": self.t60 })
    }
}

/// Places that are struck, in the frame of the body \[m\].
#[derive(Default)]
struct Places {
    radius: f64,
    places: Vec<DVec3>,
}

impl Places {
    /// Which place stands for one.
    fn of(&self, place: DVec3) -> Option<usize> {
        let place = self.inside(place);
        let distance = |at: &usize| self.places[*at].distance_squared(place);
        (0..self.places.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)))
    }

    fn add(&mut self, place: DVec3) {
        let near = self.of(place).map(|at| self.places[at].distance(self.inside(place)));
        let known = near.is_some_and(|distance| distance < SAME_PLACE * self.radius);
        if !known && self.places.len() < MOST_PLACES {
            self.places.push(self.inside(place));
        }
    }

    fn inside(&self, place: DVec3) -> DVec3 {
        place.clamp_length_max(INSIDE * self.radius)
    }
}

/// How one body rings.
enum Modes<'a> {
    Own(&'a ModalModel),
    Proxy(&'a ModalProxy),
}

impl Modes<'_> {
    fn radius(&self) -> f64 {
        match self {
            Modes::Own(model) => model.radius,
            Modes::Proxy(proxy) => proxy.radius(),
        }
    }

    fn medium(&self) -> Medium {
        match self {
            Modes::Own(model) => model.medium,
            Modes::Proxy(proxy) => proxy.material().medium,
        }
    }

    fn max_frequency(&self) -> f64 {
        match self {
            Modes::Own(model) => model.max_frequency,
            Modes::Proxy(proxy) => proxy.complete_below(),
        }
    }

    /// From the frame of the body to that of the modes.
    fn rotation(&self) -> DMat3 {
        match self {
            Modes::Own(_) => DMat3::IDENTITY,
            Modes::Proxy(proxy) => proxy.rotation(),
        }
    }

    /// Frequencies and transfers.
    fn modes(&self) -> Vec<(f64, Option<ModalTransfer>)> {
        match self {
            Modes::Own(model) => {
                model.modes.iter().map(|mode| (mode.frequency, mode.transfer.clone())).collect()
            }
            Modes::Proxy(proxy) => (0..proxy.mode_count())
                .map(|mode| (proxy.frequency(mode), Some(proxy.transfer(mode))))
                .collect(),
        }
    }

    /// For each mode, its motions [kg^−½] at places of the body, in the frame of the modes.
    fn shapes(&self, places: &[DVec3]) -> Vec<Vec<DVec3>> {
        match self {
            Modes::Own(model) => {
                let locator = SurfaceLocator::new(&model.surface);
                let found: Vec<_> = places.iter().map(|place| locator.nearest(*place)).collect();
                let at = |shape: &[DVec3]| {
                    found.iter().map(|f| f.as_ref().map_or(DVec3::ZERO, |f| f.interpolate(shape))).collect()
                };
                model.modes.iter().map(|mode| at(&mode.shape)).collect()
            }
            Modes::Proxy(proxy) => {
                let (mut harmonics, mut motions) = (Vec::new(), Vec::new());
                let mut shapes = vec![Vec::with_capacity(places.len()); proxy.mode_count()];
                for place in places {
                    let direction = proxy.contact(*place, *place, ContactMapping::default());
                    proxy.motions(direction, &mut harmonics, &mut motions);
                    shapes.iter_mut().zip(&motions).for_each(|(shape, u)| shape.push(*u));
                }
                shapes
            }
        }
    }
}

impl Sounds {
    pub(super) fn of(replay: &Replay<'_>, pulses: &[ImpactPulse]) -> Result<Self, ReplayError> {
        let mut sounds = Sounds { slots: Vec::new(), clicks: BTreeMap::new(), rings: BTreeMap::new() };
        let mut places: BTreeMap<BodyId, Places> = BTreeMap::new();
        for pulse in pulses {
            for share in pulse.bodies.iter().flatten() {
                let id = share.body;
                if replay.clicks && !sounds.clicks.contains_key(&id) {
                    let click = sounds.click(replay, id)?;
                    sounds.clicks.insert(id, click);
                }
                let Some(modes) = modes_of(replay, id) else { continue };
                let of_body =
                    places.entry(id).or_insert_with(|| Places { radius: modes.radius(), places: Vec::new() });
                pulse.points.iter().for_each(|(point, _)| of_body.add(share.pose.body_from_world(*point)));
            }
        }
        for (id, places) in places {
            let Some(modes) = modes_of(replay, id).filter(|_| !places.places.is_empty()) else { continue };
            let body = &replay.bodies[id.index()];
            sounds.slots.push(ringing_file(id, body, &modes, &places.places)?);
            sounds.rings.insert(id, (sounds.slots.len() - 1, places));
        }
        Ok(sounds)
    }

    /// What a body clicks as, in a slot of its own unless it is a sphere.
    fn click(&mut self, replay: &Replay<'_>, id: BodyId) -> Result<AccelerationPulse, ReplayError> {
        Ok(match click_file(replay, id)? {
            Some(slot) => {
                self.slots.push(slot);
                AccelerationPulse::Slot(self.slots.len() - 1)
            }
            None => {
                AccelerationPulse::Sphere { radius: replay.bodies[id.index()].surface.equal_volume_radius() }
            }
        })
    }

    /// All events, in order of time.
    pub(super) fn events(&self, replay: &Replay<'_>, forces: &Forces) -> Vec<[f64; STRIDE]> {
        let mut events = Vec::new();
        for id in self.rings.keys() {
            self.add_poses(*id, replay, forces, &mut events);
        }
        // For each body that rings, the impacts on it in their order, as long as its modes feel them.
        let felt = |(id, source): (&BodyId, &Arc<ModalSource>)| {
            (*id, impacts_on(*id, source, &forces.pulses, replay.limit_energy).0.into_iter())
        };
        let mut felt: BTreeMap<BodyId, _> = replay.ringing.iter().map(felt).collect();
        for pulse in &forces.pulses {
            for (share, sign) in pulse.bodies.iter().zip([1.0, -1.0]) {
                let Some(share) = share else { continue };
                let clicks = match self.clicks.get(&share.body) {
                    Some(AccelerationPulse::Sphere { radius }) => Some((0.0, *radius, DQuat::IDENTITY)),
                    Some(AccelerationPulse::Slot(slot)) => {
                        Some((1.0, *slot as f64, self.slots[*slot].rotation))
                    }
                    None => None,
                };
                if let Some((kind, what, rotation)) = clicks {
                    let whole = Moved { share, velocity: true };
                    let load = PointLoad { point: pulse.point, impulse: DVec3::ZERO };
                    events.push(event((kind, what), rotation, pulse, &whole, load));
                }
                let Some((slot, places)) = self.rings.get(&share.body) else { continue };
                let Some(felt) = felt.get_mut(&share.body).and_then(Iterator::next) else { continue };
                let still = Moved { share, velocity: false };
                for (point, impulse) in &pulse.points {
                    let Some(at) = places.of(share.pose.body_from_world(*point)) else { continue };
                    let place = share.pose.world_from_body(places.places[at]);
                    let rotation = self.slots[*slot].rotation;
                    let load = PointLoad { point: place, impulse: sign * *impulse };
                    events.push(event((1.0, *slot as f64), rotation, &felt, &still, load));
                }
            }
        }
        for (id, (slot, _)) in &self.rings {
            let death = replay.bodies[id.index()].life.death;
            if death.is_finite() {
                let mut row = [0.0; STRIDE];
                (row[0], row[1], row[3], row[10], row[23]) = (3.0, death, *slot as f64, 1.0, f64::from(id.0));
                events.push(row);
            }
        }
        // Poses stay before the impacts of their time.
        events.sort_by(|a, b| a[1].total_cmp(&b[1]));
        events
    }

    /// Where a ringing body is: at every impact, and whenever it is no longer where it would be if it had
    /// gone on as it was told to move; from the first impact until it has died away.
    fn add_poses(&self, id: BodyId, replay: &Replay<'_>, forces: &Forces, events: &mut Vec<[f64; STRIDE]>) {
        let Some((slot, _)) = self.rings.get(&id) else { return };
        let Slot { rotation, t60, .. } = &self.slots[*slot];
        let strikes = |pulse: &&ImpactPulse| pulse.bodies.iter().flatten().any(|share| share.body == id);
        let mut impacts = forces.pulses.iter().filter(strikes).map(|pulse| pulse.onset).peekable();
        let Some(first) = impacts.peek().copied() else { return };
        let last = forces.pulses.iter().filter(strikes).map(|pulse| pulse.onset).fold(first, f64::max);
        let longest = t60.iter().map(|row| row[1]).fold(0.0, f64::max);
        let end = replay.bodies[id.index()].life.death.min(replay.duration).min(last + longest);
        let mut reported: Option<(f64, Moving)> = None;
        let mut time = first;
        while time <= end {
            let impact = impacts.next_if(|impact| *impact <= time);
            let at = impact.unwrap_or(time);
            let pose = forces.poses.at(id, at);
            let off = reported.is_none_or(|(since, moving)| {
                let expected = moving.after(at - since);
                expected.position.distance(pose.position) > LARGEST_STEP
                    || expected.orientation.angle_between(pose.orientation) > LARGEST_TURN
            });
            if impact.is_some() || off {
                let moving = Moving::of(&forces.poses, id, at);
                events.push(pose_event(*slot, id, at, &moving, *rotation));
                reported = Some((at, moving));
            }
            if impact.is_none() {
                time += LOOK_EVERY;
            }
        }
    }
}

fn pose_event(slot: usize, id: BodyId, time: f64, moving: &Moving, rotation: DQuat) -> [f64; STRIDE] {
    let mut row = [0.0; STRIDE];
    (row[0], row[1], row[3], row[23]) = (2.0, time, slot as f64, f64::from(id.0));
    row[4..7].copy_from_slice(&moving.pose.position.to_array());
    row[7..11].copy_from_slice(&(moving.pose.orientation * rotation).normalize().to_array());
    row[11..14].copy_from_slice(&moving.velocity.to_array());
    row[14..17].copy_from_slice(&moving.angular_velocity.to_array());
    row
}

/// A body, and whether it moves as a whole.
struct Moved<'a> {
    share: &'a BodyPulse,
    velocity: bool,
}

/// A load at a point of the surface.
struct PointLoad {
    point: DVec3,
    impulse: DVec3,
}

/// The row of an impact: its kind, and the radius of the sphere or the slot of the object.
fn event(
    (kind, what): (f64, f64),
    rotation: DQuat,
    pulse: &ImpactPulse,
    moved: &Moved<'_>,
    load: PointLoad,
) -> [f64; STRIDE] {
    let PointLoad { point, impulse } = load;
    let Moved { share, velocity } = *moved;
    let orientation = (share.pose.orientation * rotation).normalize();
    let changes = [share.velocity_change, share.angular_velocity_change]
        .map(|v| if velocity { v } else { DVec3::ZERO });
    let vectors = [share.pose.position, changes[0], changes[1], point, impulse];
    let mut row = [0.0; STRIDE];
    (row[0], row[1], row[2], row[3]) = (kind, pulse.onset, pulse.duration, what);
    row[7..11].copy_from_slice(&orientation.to_array());
    for (at, vector) in [4, 11, 14, 17, 20].into_iter().zip(vectors) {
        row[at..at + 3].copy_from_slice(&vector.to_array());
    }
    row[23] = f64::from(share.body.0);
    row
}

fn modes_of<'a>(replay: &Replay<'a>, id: BodyId) -> Option<Modes<'a>> {
    let modes = match &replay.models.get(id.index())?.modal {
        BodyModes::Own(model) => Modes::Own(model),
        BodyModes::Proxy(proxy) => Modes::Proxy(proxy),
        BodyModes::None(_) => return None,
    };
    Some(modes).filter(|modes| !modes.modes().is_empty())
}

/// The solid of a body, in another frame about its centre of mass, without its surface.
fn solid(body: &Body, from_body: DMat3) -> Solid {
    let density = body.material.density;
    let inertia = from_body * (body.inertia * density.recip()) * from_body.transpose();
    // Symmetric to rounding: a file must be to less.
    let inertia = 0.5 * (inertia + inertia.transpose());
    let mass = MassProperties { volume: body.mass / density, centre_of_mass: DVec3::ZERO, inertia };
    Solid { name: body.name.clone(), mass, surface: None }
}

fn program() -> String {
    format!("clangor {}", env!("CARGO_PKG_VERSION"))
}

/// What a body clicks as, unless that is a sphere.
fn click_file(replay: &Replay<'_>, id: BodyId) -> Result<Option<Slot>, ReplayError> {
    let body = &replay.bodies[id.index()];
    let (acceleration, rotation, method) =
        match replay.models.get(id.index()).map(|model| &model.acceleration.kind) {
            Some(SourceKind::Own) => match (replay.own_model)(id) {
                Some(model) => (AccelerationModel { near: None, ..model }, DMat3::IDENTITY, "its own field"),
                None => return Ok(None),
            },
            Some(SourceKind::Proxy(proxy)) => {
                let Some(bank) = replay.bank else { return Ok(None) };
                let order = (proxy.radius * replay.max_wavenumber).ceil() as usize + 3;
                let field = mean_field(bank.bank(), proxy, order.max(LEAST_ORDER));
                (
                    AccelerationModel { radius: proxy.radius, field, near: None },
                    proxy.rotation,
                    "an ellipsoid of the bank",
                )
            }
            Some(SourceKind::Sphere) | None => return Ok(None),
        };
    let file = ModelFile {
        acceleration,
        modal: None,
        solid: solid(body, rotation.transpose()),
        origin: Origin {
            program: program(),
            inputs: String::new(),
            asked_accuracy: 0.01,
            method: method.into(),
            unknowns: 0,
            solves: 0,
            held_out_error: 0.0,
            warnings: Vec::new(),
        },
    };
    let bytes = file.encode().map_err(|source| ReplayError::Sound { body: body.name.clone(), source })?;
    Ok(Some(Slot { body: id, rotation: DQuat::from_mat3(&rotation), bytes, t60: Vec::new() }))
}

/// How a body rings that is struck at these places.
fn ringing_file(id: BodyId, body: &Body, modes: &Modes<'_>, places: &[DVec3]) -> Result<Slot, ReplayError> {
    let from_body = modes.rotation();
    let surface = ModalSurface {
        nodes: places.iter().map(|place| from_body * *place).collect(),
        triangles: (0..places.len()).map(|at| [at as u32; 6]).collect(),
    };
    let modes_at = modes.modes().into_iter().zip(modes.shapes(places));
    let list: Vec<ModalMode> = modes_at
        .map(|((frequency, transfer), shape)| ModalMode { frequency, mesh_error: f64::NAN, shape, transfer })
        .collect();
    let mut t60: Vec<[f64; 2]> = Vec::new();
    for mode in &list {
        let ratio = body.material.damping.damping_ratio(mode.frequency);
        let time = (1000_f64.ln() / (TAU * mode.frequency * ratio)).min(LONGEST_T60);
        if t60.last().is_none_or(|[last, _]| mode.frequency > last * (1.0 + 1e-9)) {
            t60.push([mode.frequency, time]);
        }
    }
    let material = &body.material;
    let model = ModalModel {
        radius: modes.radius(),
        medium: modes.medium(),
        density: material.density,
        max_frequency: modes.max_frequency(),
        surface,
        modes: list,
    };
    let origin = ModalOrigin {
        program: program(),
        inputs: String::new(),
        material: material.name.clone(),
        youngs_modulus: material.youngs_modulus,
        poisson_ratio: material.poisson_ratio,
        asked_mesh_error: 0.0,
        asked_accuracy: 0.0,
        mesh: "the places that are struck".into(),
        nodes: places.len() as u64,
        residual: 0.0,
        first_frequency: None,
        method: String::new(),
        warnings: Vec::new(),
    };
    let file = ModalFile { modal: ModalPart { model, origin }, solid: solid(body, from_body) };
    let bytes = file.encode().map_err(|source| ReplayError::Sound { body: body.name.clone(), source })?;
    Ok(Slot { body: id, rotation: DQuat::from_mat3(&from_body.transpose()).normalize(), bytes, t60 })
}
