//! Frames of a node in the world, through its parents, and the span in which it is shown.
//!
//! Frames are the keys of the finest curve that moves the node, and outside its span those of the next finer
//! one: a key in between would be a point on the chord of the true path and seem an impact. Distances of keys
//! within a smooth curve are divided, and long ones between linear keys.

use clangor_core::pose::Pose;
use glam::{DMat4, DQuat, DVec3};

use super::NodeFault;
use super::curve::{Curve, Curves, Interpolation};
use crate::formats::mesh_reader::gltf::Placed;
use crate::formats::mesh_reader::gltf::document::{GltfFile, Node};
use crate::motion::recording::{Frame, LengthUnit};

/// Frames per second of a smooth curve, at least \[Hz\].
const SMOOTH_RATE: f64 = 240.0;
/// Distance of linear keys from which they are stations of a path and not frames of a recording \[s\]: the
/// path between them is a line, as viewers show it.
const STATIONS: f64 = 0.125;
/// Even keys from which a curve is a recording nevertheless, in another unit of time, and the largest ratio
/// of their distances.
const RECORDING: (usize, f64) = (16, 1.5);
/// Most frames that are added between such keys.
const MOST_ADDED: f64 = 20_000.0;
/// Scales that count as equal, and as zero.
const SAME_SCALE: f64 = 1e-3;

/// How a node moves.
pub(super) struct NodeMotion {
    pub(super) frames: Vec<Frame>,
    pub(super) start: Pose,
    pub(super) birth: f64,
    pub(super) death: f64,
    /// Factor on the coordinates of its mesh.
    pub(super) scale: DVec3,
    pub(super) is_animated: bool,
    /// Place of the node whose curves move it: its own or the nearest above it.
    pub(super) moved_by: Option<usize>,
}

/// Rotation, translation and one scale.
#[derive(Clone, Copy)]
struct Similarity {
    scale: f64,
    pose: Pose,
}

/// Translation, rotation and scale of a node without its curves.
struct Rest {
    translation: DVec3,
    rotation: DQuat,
    scale: DVec3,
    /// Whether `KHR_node_visibility` hides it, and all below it.
    is_hidden: bool,
}

impl Rest {
    fn of(node: &Node) -> Result<Self, NodeFault> {
        let visible = node.extensions.visibility.as_ref().and_then(|visibility| visibility.get("visible"));
        let is_hidden = visible.and_then(serde_json::Value::as_bool) == Some(false);
        if let Some(matrix) = node.matrix {
            let matrix = DMat4::from_cols_array(&matrix);
            let (scale, rotation, translation) = matrix.to_scale_rotation_translation();
            let same = DMat4::from_scale_rotation_translation(scale, rotation, translation);
            if !(same - matrix).abs_diff_eq(DMat4::ZERO, SAME_SCALE * scale.abs().max_element()) {
                return Err(NodeFault::Shear);
            }
            return Ok(Rest { translation, rotation, scale, is_hidden });
        }
        Ok(Rest {
            translation: node.translation.map_or(DVec3::ZERO, DVec3::from_array),
            rotation: node.rotation.map_or(DQuat::IDENTITY, |q| DQuat::from_array(q).normalize()),
            scale: node.scale.map_or(DVec3::ONE, DVec3::from_array),
            is_hidden,
        })
    }
}

/// A node of the chain: its curves, what they replace, and whether it is the last.
struct Chain<'a> {
    links: Vec<(Rest, &'a Curves)>,
    /// Scale of the node itself while it is shown, which need not be the same along all axes.
    own: DVec3,
    unit: LengthUnit,
}

impl NodeMotion {
    /// The motion of the first node of a chain that goes up to the root; the nodes and their curves have the
    /// same places.
    pub(super) fn of_chain(
        file: &GltfFile,
        (placed, curves): (&[Placed], &[Curves]),
        chain: &[usize],
        unit: LengthUnit,
    ) -> Result<Self, NodeFault> {
        let rest = |place: &usize| Rest::of(&file.document.nodes[placed[*place].node]);
        let link = |place: &usize| Ok((rest(place)?, &curves[*place]));
        let links = chain.iter().map(link).collect::<Result<Vec<(Rest, &Curves)>, NodeFault>>()?;
        let is_animated = links.iter().any(|(_, curves)| curves.is_animated());
        let moved_by = chain.iter().copied().find(|place| curves[*place].moves());
        let times = clock(&links);
        let switches = switches(&links);
        let instants = || times.iter().chain(&switches).copied();
        let own_scale = |time: f64| scale_of(&links[0], time);
        let shown = |scale: &DVec3| scale.abs().max_element() > SAME_SCALE;
        let own = instants().map(own_scale).find(shown).unwrap_or(DVec3::ONE);
        let chain = Chain { links, own, unit };
        // Scale of all above, while shown.
        let mut first: Option<f64> = None;
        let (mut birth, mut death) = (None, f64::INFINITY);
        let mut order: Vec<f64> = instants().collect();
        order.sort_by(f64::total_cmp);
        order.dedup();
        for &time in &order {
            let scale = chain.visible_scale(time)?;
            if scale <= SAME_SCALE {
                if birth.is_some() && death.is_infinite() {
                    death = time;
                }
                continue;
            }
            let whole = *first.get_or_insert(scale);
            if (scale / whole - 1.0).abs() > SAME_SCALE {
                return Err(NodeFault::ScaleOverTime { time, scale: scale / whole });
            }
            if death.is_finite() {
                return Err(NodeFault::ShownAgain { time });
            }
            birth.get_or_insert(time);
        }
        // What is shown from its first key on has always been there.
        let begins = order.first().copied().unwrap_or(0.0);
        let birth = birth.map_or(f64::INFINITY, |birth| if birth <= begins { 0.0 } else { birth });
        let alive = |time: &f64| (birth..=death).contains(time);
        let frame = |(row, time): (usize, f64)| Frame { time, pose: chain.at(time).pose, row: row as u64 };
        let frames = times.iter().copied().enumerate().filter(|(_, time)| alive(time)).map(frame).collect();
        let start = chain.at(if birth.is_finite() { birth } else { begins }).pose;
        // With its signs: a mirrored node has a mirrored mesh.
        let scale = chain.own * (first.unwrap_or(1.0) * unit.metres);
        Ok(NodeMotion { frames, start, birth, death, scale, is_animated, moved_by })
    }
}

impl Chain<'_> {
    /// Uniform scale of the world over that of the own mesh: 0 where hidden, else that of all above.
    fn visible_scale(&self, time: f64) -> Result<f64, NodeFault> {
        let own = scale_of(&self.links[0], time) / self.own;
        let mut scale = uniform(own)?;
        for link in &self.links[1..] {
            scale *= uniform(scale_of(link, time))?;
        }
        Ok(scale.abs())
    }

    fn at(&self, time: f64) -> Similarity {
        let mut whole = Similarity { scale: self.unit.metres, pose: Pose::IDENTITY };
        for link in self.links.iter().rev() {
            let (rest, curves) = link;
            let translation = curves.translation.as_ref().map_or(rest.translation, |c| c.vector_at(time));
            let rotation = curves.rotation.as_ref().map_or(rest.rotation, |c| c.rotation_at(time));
            let position = whole.pose.world_from_body(translation * whole.scale);
            let orientation = (whole.pose.orientation * rotation).normalize();
            whole.pose = Pose { position, orientation };
            // Parents are uniform, which has been checked.
            whole.scale *= scale_of(link, time).x;
        }
        whole
    }
}

fn scale_of((rest, curves): &(Rest, &Curves), time: f64) -> DVec3 {
    if rest.is_hidden {
        return DVec3::ZERO;
    }
    curves.scale.as_ref().map_or(rest.scale, |curve| curve.vector_at(time))
}

fn uniform(scale: DVec3) -> Result<f64, NodeFault> {
    let DVec3 { x, y, z } = scale;
    let largest = scale.abs().max_element();
    if (x - y).abs().max((x - z).abs()) > SAME_SCALE * largest.max(SAME_SCALE) || x < 0.0 {
        return Err(NodeFault::UnevenScale { x, y, z });
    }
    Ok(x)
}

/// Times of the frames: the keys of the finest curve, and of the next finer ones where those before have
/// none; finer where a curve is smooth, or linear with keys far apart; 0 without curves.
fn clock(links: &[(Rest, &Curves)]) -> Vec<f64> {
    let moving = links.iter().flat_map(|(_, curves)| [&curves.translation, &curves.rotation]).flatten();
    let mut moving: Vec<&Curve> = moving.collect();
    if moving.is_empty() {
        return vec![0.0];
    }
    moving.sort_by(|a, b| mean_spacing(a).total_cmp(&mean_spacing(b)));
    let mut times: Vec<f64> = Vec::new();
    for curve in &moving {
        let (first, last) = (times.first().copied(), times.last().copied());
        let is_outside =
            |key: &f64| first.is_none_or(|first| *key < first) || last.is_none_or(|last| *key > last);
        times.extend(curve.times.iter().copied().filter(is_outside));
        times.sort_by(f64::total_cmp);
    }
    let spans_of = |interpolation: Interpolation| -> Vec<[f64; 2]> {
        let own = moving.iter().filter(|curve| curve.interpolation == interpolation);
        own.filter_map(|curve| Some([*curve.times.first()?, *curve.times.last()?])).collect()
    };
    let smooth = spans_of(Interpolation::Cubic);
    let linear = if is_recording(&times) { Vec::new() } else { spans_of(Interpolation::Linear) };
    let whole = times.last().zip(times.first()).map_or(0.0, |(last, first)| last - first);
    let linear_rate = SMOOTH_RATE.min(MOST_ADDED / whole);
    let mut finer = Vec::with_capacity(times.len());
    for pair in times.windows(2) {
        let (from, span) = (pair[0], pair[1] - pair[0]);
        let is_within =
            |spans: &[[f64; 2]]| spans.iter().any(|[first, last]| *first < pair[1] && from < *last);
        // Without the last digit, by which a span of ten frames would have eleven.
        let parts = match span {
            span if is_within(&smooth) => (span * SMOOTH_RATE - 1e-6).ceil().max(1.0),
            span if span > STATIONS && is_within(&linear) => (span * linear_rate - 1e-6).ceil().max(1.0),
            _ => 1.0,
        };
        finer.extend((0..parts as u32).map(|k| from + span * f64::from(k) / parts));
    }
    finer.extend(times.last());
    finer
}

/// Whether keys are many and even.
fn is_recording(times: &[f64]) -> bool {
    let spans = || times.windows(2).map(|pair| pair[1] - pair[0]);
    let (shortest, longest) = (spans().fold(f64::INFINITY, f64::min), spans().fold(0.0, f64::max));
    times.len() >= RECORDING.0 && longest <= RECORDING.1 * shortest
}

/// Mean distance of the keys \[s\]; infinite with one key.
fn mean_spacing(curve: &Curve) -> f64 {
    match curve.times.as_slice() {
        [first, .., last] => (last - first) / (curve.times.len() - 1) as f64,
        _ => f64::INFINITY,
    }
}

/// Times at which a scale may show or hide the node.
fn switches(links: &[(Rest, &Curves)]) -> Vec<f64> {
    let scales = links.iter().filter_map(|(_, curves)| curves.scale.as_ref());
    scales.flat_map(|curve: &Curve| curve.times.iter().copied()).collect()
}
