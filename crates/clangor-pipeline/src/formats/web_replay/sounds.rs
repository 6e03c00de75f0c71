//! The sound models of the bodies with impacts, as files for the slots of the real-time engine.
//!
//! Of the mode shapes, only the values at the points of impact are needed. The surface in the file of a modal
//! body is therefore the list of these points, each a triangle without area. For an ellipsoid that replaces a
//! piece, the file contains the mode shapes at the points to which the impacts on the piece are mapped.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use clangor_core::body::{Body, BodyId};
use clangor_core::contact::ImpactPulse;
use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::glam::{DMat3, DQuat, DVec3};
use clangor_core::medium::Medium;
use clangor_core::realtime::ImpactTarget;
use clangor_core::sound_model::acceleration::model::AccelerationModel;
use clangor_core::sound_model::acceleration::proxy_field::{LEAST_ORDER, mean_field};
use clangor_core::sound_model::files::modal_file::{ModalFile, ModalOrigin, ModalPart};
use clangor_core::sound_model::files::model_file::{ModelFile, Origin, Solid};
use clangor_core::sound_model::modal::model::{ModalMode, ModalModel, ModalTransfer};
use clangor_core::sound_model::modal::surface::{ModalSurface, SurfaceLocator};
use clangor_core::sound_model::soundbank::modal_soundbank::{ContactMapping, ModalProxy};
use clangor_core::synthesis::BodyModes;
use clangor_core::synthesis::source_rule::SourceKind;
use serde_json::{Value, json};

use super::{Replay, ReplayError};

/// Largest number of points of impact on a body; further impacts act at the nearest point.
const MOST_PLACES: usize = 256;
/// Points closer than this part of the bounding radius are merged.
const SAME_PLACE: f64 = 1e-4;
/// Largest distance of a point from the centre, as part of the bounding radius.
const INSIDE: f64 = 0.999_999;
/// Longest T60 that is written \[s\].
const LONGEST_T60: f64 = 1000.0;

/// A slot of the engine.
pub(super) struct Slot {
    body: BodyId,
    /// Rotation from the frame of the sound model to that of the body.
    pub(super) rotation: DQuat,
    /// The file.
    pub(super) bytes: Vec<u8>,
    /// Frequencies \[Hz\] and T60 \[s\] of its material; empty without modes.
    pub(super) t60: Vec<[f64; 2]>,
}

pub(super) struct Sounds {
    pub(super) slots: Vec<Slot>,
    /// Target of the acceleration noise of each body with impacts.
    pub(super) clicks: BTreeMap<BodyId, ImpactTarget>,
    /// Slot with the modes of each modal body, and its points of impact.
    pub(super) rings: BTreeMap<BodyId, (usize, Places)>,
}

impl Slot {
    pub(super) fn describe(&self) -> Value {
        json!({ "body": self.body.0, "rotation": self.rotation.to_array(), "t60": self.t60 })
    }
}

/// Points of impact in the frame of the body \[m\].
#[derive(Default)]
pub(super) struct Places {
    radius: f64,
    pub(super) places: Vec<DVec3>,
}

impl Places {
    /// Index of the point nearest to a point of impact; `None` if there are no points.
    pub(super) fn of(&self, place: DVec3) -> Option<usize> {
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

/// The modes of a body.
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

    /// Rotation from the frame of the body to that of the modes.
    fn rotation(&self) -> DMat3 {
        match self {
            Modes::Own(_) => DMat3::IDENTITY,
            Modes::Proxy(proxy) => proxy.rotation(),
        }
    }

    /// Frequencies, damping by supports [1/s], and transfers.
    fn modes(&self) -> Vec<(f64, f64, Option<ModalTransfer>)> {
        match self {
            Modes::Own(model) => {
                let numbers =
                    |mode: &ModalMode| (mode.frequency, mode.support_damping, mode.transfer.clone());
                model.modes.iter().map(numbers).collect()
            }
            Modes::Proxy(proxy) => (0..proxy.mode_count())
                .map(|mode| (proxy.frequency(mode), 0.0, Some(proxy.transfer(mode))))
                .collect(),
        }
    }

    /// Displacement of each mode [kg^−½] at points of the body, in the frame of the modes.
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
                if replay.clicks && share.moves() && !sounds.clicks.contains_key(&id) {
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

    /// Target of the acceleration noise of a body: a sphere, or a new slot with its sound model.
    fn click(&mut self, replay: &Replay<'_>, id: BodyId) -> Result<ImpactTarget, ReplayError> {
        Ok(match click_file(replay, id)? {
            Some(slot) => {
                self.slots.push(slot);
                ImpactTarget::Object { slot: self.slots.len() - 1 }
            }
            None => ImpactTarget::Sphere { radius: replay.bodies[id.index()].surface.equal_volume_radius() },
        })
    }
}

fn modes_of<'a>(replay: &Replay<'a>, id: BodyId) -> Option<Modes<'a>> {
    let modes = match &replay.models.get(id.index())?.modal {
        BodyModes::Own(model) => Modes::Own(model),
        BodyModes::Proxy(proxy) => Modes::Proxy(proxy),
        BodyModes::None(_) => return None,
    };
    Some(modes).filter(|modes| !modes.modes().is_empty())
}

/// Mass properties of a body in another frame about its centre of mass, without surface.
fn solid(body: &Body, from_body: DMat3) -> Solid {
    let solid = body.homogeneous();
    let inertia = from_body * solid.inertia * from_body.transpose();
    // The product is symmetric only to rounding; the file format requires exact symmetry.
    let inertia = 0.5 * (inertia + inertia.transpose());
    let mass =
        MassProperties { volume: solid.volume, centre_of_mass: from_body * solid.centre_of_mass, inertia };
    Solid { name: body.name.clone(), mass, surface: None }
}

fn program() -> String {
    format!("clangor {}", env!("CARGO_PKG_VERSION"))
}

/// The acceleration model of a body as a file; `None` for a sphere.
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

/// The modes of a body at its points of impact as a file.
fn ringing_file(id: BodyId, body: &Body, modes: &Modes<'_>, places: &[DVec3]) -> Result<Slot, ReplayError> {
    let from_body = modes.rotation();
    let surface = ModalSurface {
        nodes: places.iter().map(|place| from_body * *place).collect(),
        triangles: (0..places.len()).map(|at| [at as u32; 6]).collect(),
    };
    let modes_at = modes.modes().into_iter().zip(modes.shapes(places));
    let list: Vec<ModalMode> = modes_at
        .map(|((frequency, support_damping, transfer), shape)| ModalMode {
            frequency,
            mesh_error: f64::NAN,
            support_damping,
            shape,
            transfer,
        })
        .collect();
    let mut t60: Vec<[f64; 2]> = Vec::new();
    for mode in &list {
        let ratio = body.material.damping.damping_ratio(mode.frequency) + mode.support_damping_ratio();
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
        statistical_above: None,
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
