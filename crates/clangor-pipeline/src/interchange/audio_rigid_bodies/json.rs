//! The extension's objects as JSON.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Properties that are none of the draft's, or none that is read.
pub(super) type Others = BTreeMap<String, Value>;

/// The extension of a document.
#[derive(Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct DocumentJson {
    pub(super) modal_models: Option<Vec<Value>>,
    pub(super) acoustic_materials: Option<Vec<Value>>,
    pub(super) acoustic_surfaces: Option<Vec<Value>>,
    #[serde(flatten)]
    pub(super) others: Others,
}

/// The extension of a node.
#[derive(Default, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct NodeJson {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) modal_model: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) acoustic_surface: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) gain: Option<f64>,
    #[serde(flatten)]
    pub(super) others: Others,
}

/// An acoustic material.
#[derive(Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct MaterialJson {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) name: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) density: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) youngs_modulus: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) poisson_ratio: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) alpha: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) beta: Option<f64>,
    #[serde(flatten)]
    pub(super) others: Others,
}

/// What is read of an acoustic surface: the material under it.
#[derive(Deserialize)]
pub(super) struct SurfaceJson {
    pub(super) material: Option<usize>,
}

/// A modal model.
#[derive(Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct ModelJson {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) name: Option<String>,
    pub(super) frequencies: usize,
    pub(super) decay_rates: usize,
    pub(super) positions: usize,
    pub(super) shapes: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) indices: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) material: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) mass_properties: Option<MassJson>,
    #[serde(default, skip_serializing_if = "Extras::is_empty")]
    pub(super) extras: Extras,
    #[serde(flatten)]
    pub(super) others: Others,
}

/// Mass properties, here and in `KHR_physics_rigid_bodies`.
#[derive(Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct MassJson {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) mass: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) center_of_mass: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) inertia_diagonal: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) inertia_orientation: Option<[f64; 4]>,
}

/// The rigid body of a node in `KHR_physics_rigid_bodies`.
#[derive(Deserialize)]
pub(super) struct PhysicsJson {
    pub(super) motion: Option<MotionJson>,
}

/// How that body moves.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct MotionJson {
    #[serde(default)]
    pub(super) is_kinematic: bool,
    #[serde(flatten)]
    pub(super) mass: MassJson,
}

/// What we add to a modal model; other programs may have put anything there.
#[derive(Default, Serialize, Deserialize)]
#[serde(transparent)]
pub(super) struct Extras(pub(super) Value);

/// Key of our part of it.
const OWN: &str = "clangor";

impl Extras {
    /// Ours.
    pub(super) fn new(own: &OwnExtras) -> Self {
        Extras(serde_json::json!({ OWN: own }))
    }

    /// Our part of it, if we wrote it.
    pub(super) fn own(&self) -> OwnExtras {
        let own = self.0.get(OWN).cloned();
        own.and_then(|own| serde_json::from_value(own).ok()).unwrap_or_default()
    }

    fn is_empty(&self) -> bool {
        self.0.is_null()
    }
}

/// What we add to a modal model.
#[derive(Default, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct OwnExtras {
    /// Every four triangles are one of six nodes, between which shapes are quadratic.
    pub(super) quadratic: bool,
    /// There are no other modes below \[Hz\].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) max_frequency: Option<f64>,
}
