//! A modal model of the extension: its numbers, and the surface of six-node triangles that they mean.
//!
//! Between the three corners of a triangle of `indices` the extension interpolates shapes linearly; a
//! triangle of six nodes with the mean at each middle does the same. Files of ours say that every four
//! triangles are one of six nodes, which comes back as it was. Without `indices` the shape anywhere is that
//! of the nearest sample point.
//!
//! *Differs*: there we take the nearest point for the corners of the node's mesh only, and interpolate
//! between them.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use clangor_core::geometry::principal_axes::principal_axes;
use clangor_core::geometry::tri_mesh::TriMesh;
use clangor_core::sound_model::modal::surface::ModalSurface;
use glam::{DMat3, DMat4, DVec3};

use super::super::json::ModelJson;
use super::super::{AudioFault, AudioPlace, Ringing, RingingMode};
use super::{Trouble, numbers, within};
use crate::formats::mesh_reader::gltf::document::{Accessor, FLOAT, GltfFile, INT, SHORT};

/// Factors of a node's scale that differ by less are one.
const UNIFORM: f64 = 1e-4;

/// Reads a model, and moves it with its node; the places are those of the model and of the node.
pub(super) fn ringing(
    file: &GltfFile,
    json: &ModelJson,
    (model, node): (AudioPlace, AudioPlace),
    transform: &DMat4,
    mesh: &TriMesh,
) -> Result<Ringing, Trouble> {
    let turn = rotation(transform).map_err(|fault| Trouble::Content(node, fault))?;
    let mut samples = samples(file, json).map_err(|fault| Trouble::Content(model.clone(), fault))?;
    samples.points.iter_mut().for_each(|x| *x = transform.transform_point3(*x));
    for mode in &mut samples.modes {
        mode.shape.iter_mut().for_each(|u| *u = turn * *u);
    }
    let Samples { points, triangles, mut modes, .. } = samples;
    let own = json.extras.own();
    let surface = match triangles {
        Some(triangles) if own.quadratic => {
            let triangles =
                six_nodes(&triangles, turn).map_err(|fault| Trouble::Content(model.clone(), fault))?;
            ModalSurface { nodes: points, triangles }
        }
        Some(mut triangles) => {
            if turn.determinant() < 0.0 {
                triangles.iter_mut().for_each(|t| t.swap(1, 2));
            }
            linear(TriMesh { vertices: points, triangles }, &mut modes)
        }
        None if mesh.triangles.is_empty() => return Err(Trouble::Content(model, AudioFault::NoSurface)),
        None => {
            let nearest: Vec<usize> = mesh.vertices.iter().map(|v| nearest(&points, *v)).collect();
            for mode in &mut modes {
                mode.shape = nearest.iter().map(|i| mode.shape[*i]).collect();
            }
            linear(mesh.clone(), &mut modes)
        }
    };
    modes.sort_by(|a, b| a.frequency.total_cmp(&b.frequency));
    let max_frequency = within("extras.clangor.maxFrequency", own.max_frequency, |f| f > 0.0, "positive")
        .map_err(|fault| Trouble::Content(model, fault))?;
    Ok(Ringing { surface, modes, max_frequency })
}

/// How vectors turn with a node.
fn rotation(transform: &DMat4) -> Result<DMat3, AudioFault> {
    let linear = DMat3::from_mat4(*transform);
    let squares = principal_axes(linear.transpose() * linear).0;
    let (least, most) = (squares.min_element().max(0.0).sqrt(), squares.max_element().sqrt());
    if !(least > 0.0 && most.is_finite() && most - least <= UNIFORM * most) {
        return Err(AudioFault::Stretched { least, most });
    }
    Ok(linear * (1.0 / linear.determinant().abs().cbrt()))
}

/// The numbers of a model, in the frame of its node.
struct Samples {
    points: Vec<DVec3>,
    triangles: Option<Vec<[u32; 3]>>,
    modes: Vec<RingingMode>,
}

fn samples(file: &GltfFile, json: &ModelJson) -> Result<Samples, AudioFault> {
    let frequencies = scalars(file, "frequencies", json.frequencies)?;
    let decay_rates = scalars(file, "decayRates", json.decay_rates)?;
    let points = vectors(file, "positions", json.positions)?;
    let shapes = vectors(file, "shapes", json.shapes)?;
    let (modes, nodes) = (frequencies.len(), points.len());
    let count = |property, found: usize, wanted: usize, why: String| {
        let wanted = format!("{wanted}, {why}");
        if found > 0 { Ok(()) } else { Err(AudioFault::Count { property, found, wanted }) }
    };
    count("frequencies", modes, 1, "one a mode, at least one".into())?;
    count("positions", nodes, 1, "at least one".into())?;
    if decay_rates.len() != modes {
        let wanted = format!("{modes}, as many as frequencies");
        return Err(AudioFault::Count { property: "decayRates", found: decay_rates.len(), wanted });
    }
    if Some(shapes.len()) != modes.checked_mul(nodes) {
        let wanted = format!("{modes} × {nodes}, those of frequencies and positions");
        return Err(AudioFault::Count { property: "shapes", found: shapes.len(), wanted });
    }
    all("frequencies", &frequencies, |f| f > 0.0, "finite and positive")?;
    all("decayRates", &decay_rates, |d| d >= 0.0, "finite, and 0 or positive")?;
    let triangles = json.indices.map(|indices| triangles(file, indices, nodes)).transpose()?;
    let mode = |(at, (f, d)): (usize, (&f64, &f64))| RingingMode {
        frequency: f.hypot(d / TAU),
        decay_rate: *d,
        shape: shapes[at * nodes..(at + 1) * nodes].to_vec(),
    };
    let modes = frequencies.iter().zip(&decay_rates).enumerate().map(mode).collect();
    Ok(Samples { points, triangles, modes })
}

fn triangles(file: &GltfFile, indices: usize, nodes: usize) -> Result<Vec<[u32; 3]>, AudioFault> {
    const WANTED: &str = "SCALAR of UNSIGNED_INT or UNSIGNED_SHORT";
    let accessor = accessor(file, "indices", indices, "SCALAR", &[INT, SHORT], WANTED)?;
    let corners: Vec<u32> = file.integers(accessor).map_err(numbers("indices"))?.collect();
    let (triangles, rest) = corners.as_chunks::<3>();
    if !rest.is_empty() || triangles.is_empty() {
        let wanted = "a multiple of 3, and some".into();
        return Err(AudioFault::Count { property: "indices", found: corners.len(), wanted });
    }
    match corners.iter().position(|i| *i as usize >= nodes) {
        Some(at) => Err(AudioFault::Value {
            property: "indices",
            at: Some(at),
            value: corners[at].into(),
            limit: "less than the count of positions",
        }),
        None => Ok(triangles.to_vec()),
    }
}

fn accessor<'a>(
    file: &'a GltfFile,
    property: &'static str,
    index: usize,
    shape: &str,
    kinds: &[u32],
    wanted: &'static str,
) -> Result<&'a Accessor, AudioFault> {
    let count = file.document.accessors.len();
    let accessor =
        file.document.accessors.get(index).ok_or(AudioFault::Missing { what: property, index, count })?;
    if accessor.shape == shape && kinds.contains(&accessor.component_type) {
        return Ok(accessor);
    }
    let found = format!("{} of component type {}", accessor.shape, accessor.component_type);
    Err(AudioFault::Accessor { property, found, wanted })
}

fn scalars(file: &GltfFile, property: &'static str, index: usize) -> Result<Vec<f64>, AudioFault> {
    let accessor = accessor(file, property, index, "SCALAR", &[FLOAT], "SCALAR of FLOAT")?;
    Ok(file.floats::<1>(accessor).map_err(numbers(property))?.map(|[x]| x).collect())
}

fn vectors(file: &GltfFile, property: &'static str, index: usize) -> Result<Vec<DVec3>, AudioFault> {
    let accessor = accessor(file, property, index, "VEC3", &[FLOAT], "VEC3 of FLOAT")?;
    let vectors: Vec<DVec3> =
        file.floats::<3>(accessor).map_err(numbers(property))?.map(DVec3::from_array).collect();
    let bad = vectors.iter().enumerate().find_map(|(at, v)| {
        let value = v.to_array().into_iter().find(|x| !x.is_finite())?;
        Some((at, value))
    });
    match bad {
        Some((at, value)) => Err(AudioFault::Value { property, at: Some(at), value, limit: "finite" }),
        None => Ok(vectors),
    }
}

fn all(
    property: &'static str,
    values: &[f64],
    good: impl Fn(f64) -> bool,
    limit: &'static str,
) -> Result<(), AudioFault> {
    match values.iter().position(|x| !(x.is_finite() && good(*x))) {
        Some(at) => Err(AudioFault::Value { property, at: Some(at), value: values[at], limit }),
        None => Ok(()),
    }
}

/// Index of the point nearest to `x`; of equals the first.
fn nearest(points: &[DVec3], x: DVec3) -> usize {
    let distances = points.iter().map(|p| p.distance_squared(x));
    distances.enumerate().min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(at, _)| at)
}

/// The triangles of six nodes that every four triangles are the quarters of.
fn six_nodes(quarters: &[[u32; 3]], turn: DMat3) -> Result<Vec<[u32; 6]>, AudioFault> {
    let (fours, rest) = quarters.as_chunks::<4>();
    if !rest.is_empty() {
        return Err(AudioFault::Quarters { triangle: 4 * fours.len() });
    }
    let one = |(at, four): (usize, &[[u32; 3]; 4])| {
        let [[a, d, f], [_, b, e], [_, _, c], _] = *four;
        let whole = ModalSurface { nodes: Vec::new(), triangles: vec![[a, b, c, d, e, f]] };
        if whole.quarters().triangles != four {
            return Err(AudioFault::Quarters { triangle: 4 * at });
        }
        Ok(if turn.determinant() < 0.0 { [a, c, b, f, e, d] } else { [a, b, c, d, e, f] })
    };
    fours.iter().enumerate().map(one).collect()
}

/// A surface on which shapes are linear between the corners of a mesh; the shapes get the middles of edges
/// too.
fn linear(mesh: TriMesh, modes: &mut [RingingMode]) -> ModalSurface {
    let TriMesh { vertices: mut nodes, triangles } = mesh;
    let mut middles: BTreeMap<[u32; 2], u32> = BTreeMap::new();
    let mut edges: Vec<[usize; 2]> = Vec::new();
    let first = nodes.len();
    let mut middle = |a: u32, b: u32| {
        *middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
            edges.push([a as usize, b as usize]);
            (first + edges.len() - 1) as u32
        })
    };
    let triangles =
        triangles.iter().map(|&[a, b, c]| [a, b, c, middle(a, b), middle(b, c), middle(c, a)]).collect();
    let between = |values: &mut Vec<DVec3>| {
        let middles: Vec<DVec3> = edges.iter().map(|[a, b]| 0.5 * (values[*a] + values[*b])).collect();
        values.extend(middles);
    };
    between(&mut nodes);
    modes.iter_mut().for_each(|mode| between(&mut mode.shape));
    ModalSurface { nodes, triangles }
}
