//! Animation curves of a node: translation, rotation and scale over time, as the format defines them.
//!
//! Times become seconds as they are read, and tangents, which are per unit of time of the file, per second.

use std::collections::BTreeMap;

use glam::{DQuat, DVec3, DVec4};

use super::NodeFault;
use super::key_times::KeyFrames;
use crate::formats::mesh_reader::MeshFault;
use crate::formats::mesh_reader::gltf::document::{Accessor, Animation, Channel, GltfFile};
use crate::formats::mesh_reader::gltf::morph_weights;
use crate::motion::recording::{MAX_TIME, TimeUnit};

/// Length of a quaternion from which it is a rotation.
const LEAST_ROTATION: f64 = 1e-6;

/// How values lie between keys.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Interpolation {
    Step,
    Linear,
    Cubic,
}

/// A property over time \[s\]; of cubic curves each key has its in-tangent \[1/s\], value and out-tangent.
#[derive(Clone, Debug)]
pub(super) struct Curve {
    pub(super) times: Vec<f64>,
    pub(super) interpolation: Interpolation,
    values: Vec<DVec4>,
    is_rotation: bool,
}

/// The curves of a node.
#[derive(Clone, Debug, Default)]
pub(super) struct Curves {
    pub(super) translation: Option<Curve>,
    pub(super) rotation: Option<Curve>,
    pub(super) scale: Option<Curve>,
}

impl Curves {
    /// Those of a node in all animations of the file, which is in this unit, and whose keys lie on `frames`.
    pub(super) fn of_node(
        file: &GltfFile,
        (unit, frames): (TimeUnit, Option<&KeyFrames>),
        node: usize,
    ) -> Result<Self, NodeFault> {
        let mut curves = Curves::default();
        let mut movers: BTreeMap<&'static str, &Animation> = BTreeMap::new();
        for animation in &file.document.animations {
            for channel in animation.channels.iter().filter(|channel| channel.target.node == Some(node)) {
                let (path, place) = match channel.target.path.as_str() {
                    "translation" => ("translation", &mut curves.translation),
                    "rotation" => ("rotation", &mut curves.rotation),
                    "scale" => ("scale", &mut curves.scale),
                    _ => continue,
                };
                if let Some(other) = movers.insert(path, animation) {
                    let names = [other, animation].map(|of| of.name.clone().unwrap_or_default());
                    return Err(NodeFault::TwoAnimations { path, names });
                }
                *place = Some(read(file, (animation, channel), path, (unit, frames))?);
            }
        }
        Ok(curves)
    }

    /// Times of the keys of each curve \[s\].
    pub(super) fn times(&self) -> impl Iterator<Item = &[f64]> {
        [&self.translation, &self.rotation, &self.scale].into_iter().flatten().map(|curve| &curve.times[..])
    }

    pub(super) fn is_animated(&self) -> bool {
        [&self.translation, &self.rotation, &self.scale].into_iter().any(Option::is_some)
    }
}

impl Curves {
    /// Whether the node turns or changes its place by them.
    pub(super) fn moves(&self) -> bool {
        let curves = [&self.translation, &self.rotation].into_iter().flatten();
        curves.flat_map(|curve| curve.values.windows(2)).any(|pair| pair[0] != pair[1])
    }
}

fn read(
    file: &GltfFile,
    (animation, channel): (&Animation, &Channel),
    path: &'static str,
    (TimeUnit { seconds }, frames): (TimeUnit, Option<&KeyFrames>),
) -> Result<Curve, NodeFault> {
    let fault = |reason: String| NodeFault::Curve { path, reason };
    let sampler = animation.samplers.get(channel.sampler);
    let sampler = sampler.ok_or_else(|| fault("its sampler does not exist".into()))?;
    let interpolation = match sampler.interpolation.as_deref() {
        None | Some("LINEAR") => Interpolation::Linear,
        Some("STEP") => Interpolation::Step,
        Some("CUBICSPLINE") => Interpolation::Cubic,
        Some(other) => return Err(fault(format!("{other} is no interpolation"))),
    };
    let accessor = |index: usize| {
        file.document.accessors.get(index).ok_or_else(|| fault("an accessor does not exist".into()))
    };
    let refused = |error: MeshFault| fault(error.to_string());
    let times = file.numbers::<1>(accessor(sampler.input)?).map_err(refused)?;
    let times: Vec<f64> = times.map(|[time]| time * seconds).collect();
    let output = accessor(sampler.output)?;
    let is_rotation = path == "rotation";
    let values = if is_rotation { vectors::<4>(file, output) } else { vectors::<3>(file, output) };
    let mut values = values.map_err(refused)?;
    let per_key = if interpolation == Interpolation::Cubic { 3 } else { 1 };
    if times.is_empty() || values.len() != per_key * times.len() {
        return Err(fault(format!("it has {} times, but {} values", times.len(), values.len())));
    }
    if let Some(key) = values.iter().position(|value| !value.is_finite()) {
        return Err(fault(format!("key {} is not finite", key / per_key)));
    }
    let of_key = |key: usize| values[per_key * key + per_key / 2];
    if let Some(key) = (0..times.len()).find(|key| is_rotation && of_key(*key).length() < LEAST_ROTATION) {
        return Err(fault(format!("key {key} has length 0, which is no rotation")));
    }
    if let Some(key) = times.windows(2).position(|w| w[0] >= w[1] || !w[0].is_finite() || !w[1].is_finite()) {
        return Err(fault(format!("its times do not rise at key {}", key + 1)));
    }
    if let Some(key) = times.iter().position(|time| !(0.0..=MAX_TIME).contains(time)) {
        let time = times[key];
        let remedy = match time < 0.0 {
            true => "move all keys of the file to later times",
            false => "times in milliseconds need --time-scale 0.001",
        };
        return Err(fault(format!(
            "key {key} is at t = {time} s; times run from 0 to {MAX_TIME} s; {remedy}"
        )));
    }
    if interpolation == Interpolation::Cubic {
        values.chunks_exact_mut(3).for_each(|key| {
            key[0] /= seconds;
            key[2] /= seconds;
        });
    }
    let times = frames.map_or_else(|| times.clone(), |frames| frames.exact(&times));
    Ok(Curve { times, interpolation, values, is_rotation })
}

/// Weights of morph targets that count as equal.
const SAME_WEIGHT: f64 = 1e-4;

/// Whether an animation gives the morph targets of a node other weights than the mesh is read with.
pub(super) fn is_morphed(file: &GltfFile, node: usize) -> Result<bool, NodeFault> {
    let document = &file.document;
    let fault = |reason: String| NodeFault::Curve { path: "weights", reason };
    let Some(mesh) = document.nodes[node].mesh.and_then(|mesh| document.meshes.get(mesh)) else {
        return Ok(false);
    };
    let rest = morph_weights(&document.nodes[node], mesh);
    let targets = mesh.primitives.first().map_or(0, |primitive| primitive.targets.len());
    for animation in document.animations.iter().filter(|_| targets > 0) {
        let of_node =
            |channel: &&Channel| channel.target.node == Some(node) && channel.target.path == "weights";
        for channel in animation.channels.iter().filter(of_node) {
            let sampler = animation.samplers.get(channel.sampler);
            let sampler = sampler.ok_or_else(|| fault("its sampler does not exist".into()))?;
            let output = document.accessors.get(sampler.output);
            let output = output.ok_or_else(|| fault("an accessor does not exist".into()))?;
            let values = file.numbers::<1>(output).map_err(|error| fault(error.to_string()))?;
            let values: Vec<f64> = values.map(|[value]| value).collect();
            // A key of a cubic curve has its tangents before and after its values.
            let is_cubic = sampler.interpolation.as_deref() == Some("CUBICSPLINE");
            let (length, first) = if is_cubic { (3 * targets, targets) } else { (targets, 0) };
            let of_targets = values.chunks_exact(length).flat_map(|key| key.iter().skip(first).take(targets));
            let weights = (0..targets).map(|k| rest.get(k).copied().unwrap_or(0.0)).cycle();
            if of_targets.zip(weights).any(|(value, weight)| (value - weight).abs() > SAME_WEIGHT) {
                return Ok(true);
            }
        }
    }
    Ok(false)
}

fn vectors<const N: usize>(file: &GltfFile, accessor: &Accessor) -> Result<Vec<DVec4>, MeshFault> {
    let vector =
        |value: [f64; N]| DVec4::from_array(std::array::from_fn(|k| value.get(k).copied().unwrap_or(0.0)));
    Ok(file.numbers::<N>(accessor)?.map(vector).collect())
}

impl Curve {
    /// Value at a time \[s\]; constant outside.
    pub(super) fn at(&self, time: f64) -> DVec4 {
        let next = self.times.partition_point(|key| *key <= time);
        let last = self.times.len() - 1;
        if next == 0 || next > last || self.interpolation == Interpolation::Step {
            return self.value(next.saturating_sub(1));
        }
        let (from, to) = (next - 1, next);
        let span = self.times[to] - self.times[from];
        let s = (time - self.times[from]) / span;
        let (a, b) = (self.value(from), self.value(to));
        match self.interpolation {
            Interpolation::Linear if self.is_rotation => {
                let [a, b] = [a, b].map(|q| DQuat::from_vec4(q).normalize());
                DVec4::from(a.slerp(b, s))
            }
            Interpolation::Cubic => {
                let (s2, s3) = (s * s, s * s * s);
                let (out, into) = (self.values[3 * from + 2] * span, self.values[3 * to] * span);
                a * (2.0 * s3 - 3.0 * s2 + 1.0)
                    + out * (s3 - 2.0 * s2 + s)
                    + b * (3.0 * s2 - 2.0 * s3)
                    + into * (s3 - s2)
            }
            _ => a.lerp(b, s),
        }
    }

    fn value(&self, key: usize) -> DVec4 {
        if self.interpolation == Interpolation::Cubic { self.values[3 * key + 1] } else { self.values[key] }
    }

    pub(super) fn vector_at(&self, time: f64) -> DVec3 {
        self.at(time).truncate()
    }

    pub(super) fn rotation_at(&self, time: f64) -> DQuat {
        DQuat::from_vec4(self.at(time)).normalize()
    }
}
