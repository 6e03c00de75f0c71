//! Frames of a node in the world, through its parents, and the span in which it is shown.
//!
//! All frames are keys of one curve, the densest that moves the node: a key in between would be a point on
//! the chord of the true path and seem an impact. Keys between which a curve is smooth are divided. Times
//! at a constant rate are taken exactly, since files keep them in 32 bits.

use clangor_core::pose::Pose;
use glam::{DMat4, DQuat, DVec3};

use super::NodeFault;
use super::curve::{Curve, Curves, Interpolation};
use crate::formats::mesh_reader::gltf::Placed;
use crate::formats::mesh_reader::gltf::document::{GltfFile, Node};
use crate::motion::recording::Frame;

/// Frames per second of a smooth curve, at least \[Hz\].
const SMOOTH_RATE: f64 = 240.0;
/// Scales that count as equal, and as zero.
const SAME_SCALE: f64 = 1e-3;
/// Rounding of times in 32 bits, relative.
const TIME_ROUNDING: f64 = 2.5e-7;

/// How a node moves.
pub(super) struct NodeMotion {
    pub(super) frames: Vec<Frame>,
    pub(super) start: Pose,
    pub(super) birth: f64,
    pub(super) death: f64,
    /// Factor on the coordinates of its mesh.
    pub(super) scale: DVec3,
    pub(super) is_animated: bool,
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
}

impl Rest {
    fn of(node: &Node) -> Self {
        if let Some(matrix) = node.matrix {
            let matrix = DMat4::from_cols_array(&matrix);
            let (scale, rotation, translation) = matrix.to_scale_rotation_translation();
            return Rest { translation, rotation, scale };
        }
        Rest {
            translation: node.translation.map_or(DVec3::ZERO, DVec3::from_array),
            rotation: node.rotation.map_or(DQuat::IDENTITY, |q| DQuat::from_array(q).normalize()),
            scale: node.scale.map_or(DVec3::ONE, DVec3::from_array),
        }
    }
}

/// A node of the chain: its curves, what they replace, and whether it is the last.
struct Chain<'a> {
    links: Vec<(Rest, &'a Curves)>,
    /// Scale of the node itself while it is shown, which need not be the same along all axes.
    own: DVec3,
}

impl NodeMotion {
    /// The motion of the first node of a chain that goes up to the root.
    pub(super) fn of_chain(
        file: &GltfFile,
        placed: &[Placed],
        curves: &[Curves],
        chain: &[usize],
    ) -> Result<Self, NodeFault> {
        let rest = |place: &usize| Rest::of(&file.document.nodes[placed[*place].node]);
        let links: Vec<(Rest, &Curves)> = chain.iter().map(|place| (rest(place), &curves[*place])).collect();
        let is_animated = links.iter().any(|(_, curves)| curves.is_animated());
        let times = clock(&links);
        let switches = switches(&links);
        let instants = || times.iter().chain(&switches).copied();
        let own_scale = |time: f64| scale_of(&links[0], time);
        let shown = |scale: &DVec3| scale.abs().max_element() > SAME_SCALE;
        let own = instants().map(own_scale).find(shown).unwrap_or(DVec3::ONE);
        let chain = Chain { links, own };
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
        let alive = |time: &f64| *time >= birth - TIME_ROUNDING * (1.0 + birth) && *time <= death;
        let frame = |(row, time): (usize, f64)| Frame { time, pose: chain.at(time).pose, row: row as u64 };
        let frames = times.iter().copied().enumerate().filter(|(_, time)| alive(time)).map(frame).collect();
        let start = chain.at(if birth.is_finite() { birth } else { begins }).pose;
        let scale = chain.own.abs() * (first.unwrap_or(1.0));
        Ok(NodeMotion { frames, start, birth, death, scale, is_animated })
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
        let mut whole = Similarity { scale: 1.0, pose: Pose::IDENTITY };
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

/// Times of the frames: those of the densest curve, finer where it is smooth; 0 without curves.
fn clock(links: &[(Rest, &Curves)]) -> Vec<f64> {
    let moving = links.iter().flat_map(|(_, curves)| [&curves.translation, &curves.rotation]).flatten();
    let Some(densest) = moving.max_by_key(|curve| curve.times.len()) else { return vec![0.0] };
    let times = exact(&densest.times);
    if densest.interpolation != Interpolation::Cubic {
        return times;
    }
    let mut finer = Vec::new();
    for pair in times.windows(2) {
        let parts = ((pair[1] - pair[0]) * SMOOTH_RATE).ceil().max(1.0);
        finer.extend((0..parts as u32).map(|k| pair[0] + (pair[1] - pair[0]) * f64::from(k) / parts));
    }
    finer.extend(times.last());
    finer
}

/// Times of a constant rate without their rounding to 32 bits.
fn exact(times: &[f64]) -> Vec<f64> {
    let (Some(first), Some(last)) = (times.first(), times.last()) else { return Vec::new() };
    let steps = (times.len() - 1) as f64;
    if steps < 2.0 {
        return times.to_vec();
    }
    let measured = steps / (last - first);
    let round = measured.round();
    let rate = if round > 0.0 && (measured / round - 1.0).abs() < 1e-5 { round } else { measured };
    let start = (first * rate).round() / rate;
    let start = if (start - first).abs() <= TIME_ROUNDING * (1.0 + first.abs()) { start } else { *first };
    let regular: Vec<f64> = (0..times.len()).map(|k| start + k as f64 / rate).collect();
    let is_regular = regular.iter().zip(times).all(|(r, t)| (r - t).abs() <= TIME_ROUNDING * (1.0 + t.abs()));
    if is_regular { regular } else { times.to_vec() }
}

/// Times at which a scale may show or hide the node.
fn switches(links: &[(Rest, &Curves)]) -> Vec<f64> {
    let scales = links.iter().filter_map(|(_, curves)| curves.scale.as_ref());
    scales.flat_map(|curve: &Curve| curve.times.iter().copied()).collect()
}
