//! The bodies of a glTF file with the extension.

mod ringing;

use std::path::Path;

use clangor_core::geometry::tri_mesh::TriMesh;
use glam::{DMat3, DQuat, DVec3};
use serde::de::DeserializeOwned;
use serde_json::Value;

use super::json::{
    DocumentJson, MassJson, MaterialJson, ModelJson, NodeJson, Others, PhysicsJson, SurfaceJson,
};
use super::{
    AudioBody, AudioFault, AudioFileError, AudioMaterial, AudioPlace, BodyMass, EXTENSION, OLDER_NAME,
};
use crate::formats::input_file::read_bounded;
use crate::formats::mesh_reader::gltf::document::{GltfFile, Node};
use crate::formats::mesh_reader::gltf::{Placed, append_node, placed_nodes};
use crate::formats::mesh_reader::{Located, MOST_BYTES, MeshFault, MeshFileError};

/// Masses that differ by more than this are told.
const SAME_MASS: f64 = 0.01;

/// A fault and its place, before the file's name is known.
enum Trouble {
    File(Located),
    Content(AudioPlace, AudioFault),
}

impl From<Located> for Trouble {
    fn from(located: Located) -> Self {
        Trouble::File(located)
    }
}

/// Reads the bodies of a file, in the order of its nodes; none if it has no such extension, or is no glTF.
///
/// A body is a node with the extension, and what hangs from it; one without a mesh has the triangles between
/// the points of its modal model, and is left out if there is neither. Decays, shapes and masses are those of
/// the file: nothing is computed anew.
///
/// # Errors
/// [`AudioFileError`] names the file, the place and what is wrong.
pub fn read_audio_bodies(path: &Path) -> Result<Vec<AudioBody>, AudioFileError> {
    let ending = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    if !["gltf", "glb"].contains(&ending.as_str()) {
        return Ok(Vec::new());
    }
    let bytes =
        read_bounded(path, MOST_BYTES).map_err(|source| MeshFileError::Io { path: path.into(), source })?;
    bodies(&bytes, path.parent().unwrap_or(Path::new("."))).map_err(|trouble| match trouble {
        Trouble::File(located) => AudioFileError::File(located.in_file(path)),
        Trouble::Content(place, fault) => AudioFileError::Content { path: path.into(), place, fault },
    })
}

fn bodies(bytes: &[u8], folder: &Path) -> Result<Vec<AudioBody>, Trouble> {
    let file = GltfFile::open(bytes, folder)?;
    let at_document = |fault| Trouble::Content(AudioPlace::Document, fault);
    let Some(extension) = &file.document.extensions.audio else {
        return match file.document.extensions_used.iter().any(|name| name == OLDER_NAME) {
            true => Err(at_document(AudioFault::Draft { found: OLDER_NAME.into() })),
            false => Ok(Vec::new()),
        };
    };
    let document: DocumentJson = typed(extension).map_err(at_document)?;
    let lists = [&document.modal_models, &document.acoustic_materials, &document.acoustic_surfaces];
    if let (Some(found), true) = (unknown(&document.others), lists.iter().all(|list| list.is_none())) {
        return Err(at_document(AudioFault::Draft { found }));
    }
    Tables::new(&file, document)?.bodies()
}

/// The lists of a file.
struct Tables<'a> {
    file: &'a GltfFile,
    placed: Vec<Placed>,
    /// The extension of each placed node.
    nodes: Vec<Option<NodeJson>>,
    /// The body that each placed node is part of, as the place of its topmost node.
    body_of: Vec<Option<usize>>,
    materials: Vec<AudioMaterial>,
    surfaces: Vec<SurfaceJson>,
    models: Vec<ModelJson>,
    remarks: Vec<String>,
}

impl<'a> Tables<'a> {
    fn new(file: &'a GltfFile, document: DocumentJson) -> Result<Self, Trouble> {
        let mut remarks = Vec::new();
        remark_unknown(EXTENSION, &document.others, &mut remarks);
        let materials =
            list("acousticMaterials", document.acoustic_materials, |json: MaterialJson, place| {
                remark_unknown(&place.to_string(), &json.others, &mut remarks);
                material(json)
            })?;
        let surfaces = list("acousticSurfaces", document.acoustic_surfaces, |surface: SurfaceJson, _| {
            surface.material.map_or(Ok(()), |m| index("acousticMaterials", m, materials.len()))?;
            Ok(surface)
        })?;
        let models = list("modalModels", document.modal_models, |model: ModelJson, place| {
            remark_unknown(&place.to_string(), &model.others, &mut remarks);
            model.material.map_or(Ok(()), |m| index("acousticMaterials", m, materials.len()))?;
            Ok(model)
        })?;
        let placed = placed_nodes(&file.document)?;
        let mut nodes = Vec::with_capacity(placed.len());
        let mut body_of: Vec<Option<usize>> = Vec::with_capacity(placed.len());
        for (at, placed_node) in placed.iter().enumerate() {
            let node = node(file, placed_node, &models, &surfaces, &mut remarks)?;
            let part = placed_node.parent.and_then(|parent| body_of[parent]);
            let own = node.as_ref().is_some_and(|n| n.modal_model.is_some() || n.acoustic_surface.is_some());
            body_of.push(part.or(own.then_some(at)));
            nodes.push(node);
        }
        Ok(Tables { file, placed, nodes, body_of, materials, surfaces, models, remarks })
    }

    fn bodies(&self) -> Result<Vec<AudioBody>, Trouble> {
        let tops = (0..self.placed.len()).filter(|at| self.body_of[*at] == Some(*at));
        let mut bodies = Vec::new();
        for top in tops {
            bodies.extend(self.body(top)?);
        }
        Ok(bodies)
    }

    /// The body whose topmost node this is; none without triangles.
    fn body(&self, top: usize) -> Result<Option<AudioBody>, Trouble> {
        let place = place_of(self.file, &self.placed[top]);
        let parts = || (0..self.placed.len()).filter(|at| self.body_of[*at] == Some(top));
        let mut mesh = TriMesh::default();
        for part in parts() {
            append_node(self.file, &self.placed[part], &mut mesh)?;
        }
        let of_part = |at: usize| self.nodes[at].as_ref();
        let models: Vec<usize> =
            parts().filter(|at| of_part(*at).is_some_and(|n| n.modal_model.is_some())).collect();
        if models.len() > 1 {
            let wanted = "1 at most: one body rings as a whole".into();
            let fault = AudioFault::Count { property: "the body's modalModel", found: models.len(), wanted };
            return Err(Trouble::Content(place, fault));
        }
        let sounding = models.first().copied();
        let model = sounding.and_then(|at| of_part(at)?.modal_model);
        let mut remarks = self.remarks.clone();
        let mut ringing = match (sounding, model) {
            (Some(at), Some(model)) => Some(ringing::ringing(
                self.file,
                &self.models[model],
                (AudioPlace::Element("modalModels", model), place_of(self.file, &self.placed[at])),
                &self.placed[at].transform,
                &mesh,
            )?),
            _ => None,
        };
        if mesh.triangles.is_empty() {
            match &ringing {
                None => return Ok(None),
                Some(ringing) => mesh = ringing.surface.quarters(),
            }
        }
        let surface = parts().find_map(|at| of_part(at)?.acoustic_surface).map(|i| &self.surfaces[i]);
        let of_contact = surface.and_then(|s| s.material);
        let of_model = model.and_then(|m| self.models[m].material);
        if let (Some(modal), Some(contact)) = (of_model, of_contact)
            && self.materials[modal] != self.materials[contact]
        {
            remarks.push(format!(
                "acousticMaterials {contact} of the surface is not used: the modes are of \
                 acousticMaterials {modal}"
            ));
        }
        let material =
            of_model.or(of_contact).map_or_else(AudioMaterial::default, |i| self.materials[i].clone());
        let sounding = sounding.unwrap_or(top);
        let gain = of_part(sounding).and_then(|n| n.gain).unwrap_or(1.0);
        let (of_model, simulated) = self.masses(sounding, model)?;
        if let (Some(of_model), Some(simulated)) = (of_model, simulated) {
            let ratio = simulated.mass / of_model.mass;
            let scale = DMat3::from_mat4(self.placed[sounding].transform).determinant().abs();
            if let (true, Some(ringing)) = (resized(ratio, scale), &mut ringing) {
                ringing.resize(ratio.cbrt(), &material);
                remarks.push(format!(
                    "modalModels {}: by its mass it is of the body {:.4} times as large, and was resized",
                    model.unwrap_or_default(),
                    1.0 / ratio.cbrt()
                ));
            } else if (ratio - 1.0).abs() > SAME_MASS {
                remarks.push(format!(
                    "KHR_physics_rigid_bodies gives {} kg and the modal model {} kg: the former holds",
                    simulated.mass, of_model.mass
                ));
            }
        }
        let mass = simulated.or(of_model);
        let name = self.file.document.nodes.get(self.placed[top].node).and_then(|n| n.name.clone());
        let name = name.unwrap_or_else(|| format!("node-{}", self.placed[top].node));
        Ok(Some(AudioBody { name, mesh, material, mass, ringing, gain, remarks }))
    }

    /// The masses that the file gives: that of the model, and that of the rigid body that moves, which holds.
    fn masses(
        &self,
        at: usize,
        model: Option<usize>,
    ) -> Result<(Option<BodyMass>, Option<BodyMass>), Trouble> {
        let of_model = match model.and_then(|m| Some((m, self.models[m].mass_properties.as_ref()?))) {
            None => None,
            Some((index, json)) => {
                let place = AudioPlace::Element("modalModels", index);
                let mass = mass(json, &self.placed[at]);
                let mass = mass.map_err(|fault| Trouble::Content(place.clone(), fault))?;
                if mass.is_none() {
                    let reason = "massProperties: missing field `mass`".into();
                    return Err(Trouble::Content(place, AudioFault::Property { reason }));
                }
                mass
            }
        };
        let Some((moving, physics)) = self.moving(at)? else { return Ok((of_model, None)) };
        let place = place_of(self.file, moving);
        let simulated = mass(&physics, moving).map_err(|fault| Trouble::Content(place, fault))?;
        Ok((of_model, simulated))
    }

    /// The node itself or the nearest above it that moves as a rigid body.
    fn moving(&self, at: usize) -> Result<Option<(&Placed, MassJson)>, Trouble> {
        let mut next = Some(&self.placed[at]);
        while let Some(placed) = next {
            let physics =
                self.file.document.nodes.get(placed.node).and_then(|n| n.extensions.physics.as_ref());
            if let Some(physics) = physics {
                let content = |fault| Trouble::Content(place_of(self.file, placed), fault);
                let physics: PhysicsJson = typed(physics).map_err(content)?;
                if let Some(motion) = physics.motion.filter(|m| !m.is_kinematic) {
                    return Ok(Some((placed, motion.mass)));
                }
            }
            next = placed.parent.map(|parent| &self.placed[parent]);
        }
        Ok(None)
    }
}

/// The extension of a node.
fn node(
    file: &GltfFile,
    placed: &Placed,
    models: &[ModelJson],
    surfaces: &[SurfaceJson],
    remarks: &mut Vec<String>,
) -> Result<Option<NodeJson>, Trouble> {
    let Some(extension) = file.document.nodes.get(placed.node).and_then(|n| n.extensions.audio.as_ref())
    else {
        return Ok(None);
    };
    let place = place_of(file, placed);
    let read = || {
        let node: NodeJson = typed(extension)?;
        node.modal_model.map_or(Ok(()), |m| index("modalModels", m, models.len()))?;
        node.acoustic_surface.map_or(Ok(()), |s| index("acousticSurfaces", s, surfaces.len()))?;
        within("gain", node.gain, |g| g >= 0.0, "a finite number from 0")?;
        Ok(node)
    };
    let node = read().map_err(|fault| Trouble::Content(place.clone(), fault))?;
    remark_unknown(&place.to_string(), &node.others, remarks);
    Ok(Some(node))
}

fn place_of(file: &GltfFile, placed: &Placed) -> AudioPlace {
    let name = |node: &Node| node.name.clone();
    let name = file.document.nodes.get(placed.node).and_then(name).unwrap_or_default();
    AudioPlace::Node(placed.node, name)
}

fn typed<T: DeserializeOwned>(value: &Value) -> Result<T, AudioFault> {
    T::deserialize(value).map_err(|error| AudioFault::Property { reason: error.to_string() })
}

/// Reads the elements of a list.
fn list<J: DeserializeOwned, T>(
    name: &'static str,
    values: Option<Vec<Value>>,
    mut read: impl FnMut(J, &AudioPlace) -> Result<T, AudioFault>,
) -> Result<Vec<T>, Trouble> {
    let values = values.unwrap_or_default();
    let element = |(at, value)| {
        let place = AudioPlace::Element(name, at);
        typed(value).and_then(|json| read(json, &place)).map_err(|fault| Trouble::Content(place, fault))
    };
    values.iter().enumerate().map(element).collect()
}

fn index(what: &'static str, index: usize, count: usize) -> Result<(), AudioFault> {
    if index < count { Ok(()) } else { Err(AudioFault::Missing { what, index, count }) }
}

/// Refuses a number, if there is one, that is not finite or not as `good` wants it.
fn within(
    property: &'static str,
    value: Option<f64>,
    good: impl Fn(f64) -> bool,
    limit: &'static str,
) -> Result<Option<f64>, AudioFault> {
    match value {
        Some(value) if !(value.is_finite() && good(value)) => {
            Err(AudioFault::Value { property, at: None, value, limit })
        }
        value => Ok(value),
    }
}

fn material(json: MaterialJson) -> Result<AudioMaterial, AudioFault> {
    let MaterialJson { name, density, youngs_modulus, poisson_ratio, alpha, beta, others: _ } = json;
    let positive = |x: f64| x > 0.0;
    let not_negative = |x: f64| x >= 0.0;
    Ok(AudioMaterial {
        name,
        density: within("density", density, positive, "positive")?,
        youngs_modulus: within("youngsModulus", youngs_modulus, positive, "positive")?,
        poisson_ratio: within("poissonRatio", poisson_ratio, |x| x > -1.0 && x < 0.5, "between -1 and 0.5")?,
        alpha: within("alpha", alpha, not_negative, "0 or positive")?,
        beta: within("beta", beta, not_negative, "0 or positive")?,
    })
}

/// Whether a body and its model, whose masses have this ratio, are one body at two sizes, the node's `scale`
/// (of volumes) apart. A model is that of the body as the scene shows it, by the text of the draft; its
/// samples keep models of other sizes, and masses with them.
fn resized(ratio: f64, scale: f64) -> bool {
    (scale - 1.0).abs() > SAME_MASS && (ratio / scale - 1.0).abs() <= SAME_MASS
}

/// How far a quaternion's length may be from 1.
const UNIT: f64 = 1e-3;

/// Mass properties in the frame of the file; nothing without a mass.
fn mass(json: &MassJson, placed: &Placed) -> Result<Option<BodyMass>, AudioFault> {
    let Some(mass) = within("mass", json.mass, |m| m > 0.0, "positive")? else { return Ok(None) };
    let centre = DVec3::from_array(json.center_of_mass.unwrap_or_default());
    let moments = json.inertia_diagonal.unwrap_or_default();
    if let Some(at) = moments.iter().position(|i| !(i.is_finite() && *i >= 0.0)) {
        let value = moments[at];
        let property = "inertiaDiagonal";
        return Err(AudioFault::Value { property, at: Some(at), value, limit: "0 or positive" });
    }
    let turn = json.inertia_orientation.map_or(DQuat::IDENTITY, DQuat::from_array);
    within("the length of inertiaOrientation", Some(turn.length()), |l| (l - 1.0).abs() <= UNIT, "1")?;
    let linear = DMat3::from_mat4(placed.transform);
    // The numbers are those of the body in its size; only their axes turn with the node.
    let axes = linear * (1.0 / linear.determinant().abs().cbrt()) * DMat3::from_quat(turn.normalize());
    let inertia = axes * DMat3::from_diagonal(DVec3::from_array(moments)) * axes.transpose();
    let centre_of_mass = placed.transform.transform_point3(centre);
    if !(centre_of_mass.is_finite() && inertia.is_finite()) {
        let (property, value) = ("the scale of its node", linear.determinant());
        return Err(AudioFault::Value { property, at: None, value, limit: "finite and not 0" });
    }
    Ok(Some(BodyMass { mass, centre_of_mass, inertia }))
}

/// Properties that the draft does not have, in words.
fn unknown(others: &Others) -> Option<String> {
    let names: Vec<&str> = others
        .keys()
        .map(String::as_str)
        .filter(|name| !["name", "extensions", "extras"].contains(name))
        .collect();
    (!names.is_empty()).then(|| names.join(", "))
}

fn remark_unknown(place: &str, others: &Others, remarks: &mut Vec<String>) {
    if let Some(names) = unknown(others) {
        remarks.push(format!("{place}: {names} is not part of the draft that is read, and has no effect"));
    }
}

/// A fault of the numbers of an accessor.
fn numbers(property: &'static str) -> impl Fn(MeshFault) -> AudioFault {
    move |fault| AudioFault::Numbers { property, fault }
}
