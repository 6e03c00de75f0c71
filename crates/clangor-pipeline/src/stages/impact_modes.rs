//! The modes with which the bodies of a scene meet impacts: frequencies, damping of the material and the
//! supports, and shapes at points of the surface. [`find_impact_modes`](mod@super::find_impact_modes) finds
//! them.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use clangor_core::body::BodyId;
use clangor_core::contact::ModesAtContact;
use clangor_core::glam::DVec3;
use clangor_core::material::Damping;
use clangor_core::sound_model::modal::model::{ModalMode, ModalModel};
use clangor_core::sound_model::modal::surface::SurfaceLocator;

/// The modes of the bodies of a scene that give way in impacts.
#[derive(Clone, Debug, Default)]
pub struct ImpactModes {
    bodies: BTreeMap<BodyId, GivingBody>,
    /// What was found or baked: the first body of each form, whether it was in the cache, and the time.
    pub obtained: Vec<(BodyId, bool, Duration)>,
    /// Thin bodies without modes, which collide as rigid ones.
    pub rigid: Vec<BodyId>,
    /// Why modes cannot be had.
    pub remarks: Vec<String>,
}

/// Modes, and where on their surface a point is.
#[derive(Clone, Debug)]
pub(super) struct ModalShapes {
    /// Hash of what the model depends on.
    key: String,
    model: ModalModel,
    locator: SurfaceLocator,
}

impl ModalShapes {
    pub(super) fn new(key: &str, model: ModalModel) -> Self {
        ModalShapes { key: key.into(), locator: SurfaceLocator::new(&model.surface), model }
    }
}

/// A body that gives way.
#[derive(Clone, Debug)]
struct GivingBody {
    shapes: Arc<ModalShapes>,
    damping_ratios: Vec<f64>,
}

impl ImpactModes {
    /// The modes of a body at points \[m\] in its frame; `None` for a body that is rigid in impacts.
    pub fn at(&self, body: BodyId, points: &[(DVec3, DVec3)]) -> Option<ModesAtContact> {
        let GivingBody { shapes, damping_ratios } = self.bodies.get(&body)?;
        let ModalShapes { model, locator, .. } = &**shapes;
        let motions = |(place, _): &(DVec3, DVec3)| match locator.nearest(*place) {
            Some(place) => model.modes.iter().map(|mode| place.interpolate(&mode.shape)).collect(),
            None => vec![DVec3::ZERO; model.modes.len()],
        };
        Some(ModesAtContact {
            frequencies: model.modes.iter().map(|mode| mode.frequency).collect(),
            damping_ratios: damping_ratios.clone(),
            motions: points.iter().map(motions).collect(),
        })
    }

    /// Gives these modes to a body with this damping.
    pub(super) fn insert(&mut self, body: BodyId, shapes: &Arc<ModalShapes>, damping: &Damping) {
        let ratio = |mode: &ModalMode| damping.damping_ratio(mode.frequency) + mode.support_damping_ratio();
        let damping_ratios = shapes.model.modes.iter().map(ratio).collect();
        self.bodies.insert(body, GivingBody { shapes: Arc::clone(shapes), damping_ratios });
    }

    /// The bodies that give way, and the hashes of their models.
    pub fn models(&self) -> Vec<(BodyId, String)> {
        self.bodies.iter().map(|(body, giving)| (*body, giving.shapes.key.clone())).collect()
    }

    /// Whether a body gives way.
    pub fn contains(&self, body: BodyId) -> bool {
        self.bodies.contains_key(&body)
    }

    /// Number of bodies that give way.
    pub fn count(&self) -> usize {
        self.bodies.len()
    }
}
