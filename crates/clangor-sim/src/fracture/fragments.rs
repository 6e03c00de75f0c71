//! The pieces of a broken body as bodies of the solver: poses, velocities, and the impulses of the cracks.
//!
//! A piece keeps the axes of its parent and its motion as a part of the parent, which conserves momentum,
//! angular momentum and energy. Then the cracks release the remaining strain energy (`crack_impulse`).
//! Between two pieces, the triangles under tension act as one impulse and those under compression as another,
//! each at its weighted centre and with the remaining couple:
//!
//! ```text
//! j = Σ jᵢ,    x = Σ |jᵢ| xᵢ / Σ |jᵢ|,    c = Σ (xᵢ − x) × jᵢ
//! ```
//!
//! In a bent plate the two cancel except for a couple across the thickness; as a single impulse they would
//! excite no modes.

use std::collections::BTreeMap;

use clangor_bake::stress::SymmetricTensor;
use clangor_core::body::{Body, MeshSurface, Surface};
use clangor_core::pose::Pose;
use clangor_core::timeline::{FractureRow, PoseRow};
use glam::{DMat3, DVec3};

use super::crack_impulse::{CrackImpulses, NoImpulse, crack_impulses};
use super::error::FractureError;
use super::hulls::{HullSettings, piece_hulls};
use super::motion::Motion;
use super::piece::Piece;
use super::shatter::Shatter;
use super::split::CrackFace;
use crate::rigid::{CrackImpulse, Replacement, check_surface};

/// A body at the instant of its fracture.
pub(super) struct Parent<'a> {
    /// The body in its initial state.
    pub(super) body: &'a Body,
    /// Its pose and velocities at the fracture.
    pub(super) state: PoseRow,
    /// Its centre of mass in the frame of its tetrahedra \[m\].
    pub(super) centre: DVec3,
}

/// The fracture of a body.
pub(super) struct Broken {
    pub(super) shatter: Shatter,
    /// Stress of each element before the fracture \[Pa\].
    pub(super) stress: Vec<SymmetricTensor>,
    /// Energy of the impacts \[J\].
    pub(super) impact_energy: f64,
    /// Seed of the pattern.
    pub(super) seed: u64,
}

/// The pieces for the solver, and their tetrahedra in the same order.
pub(super) struct Fragments {
    pub(super) replacement: Replacement,
    pub(super) pieces: Vec<Piece>,
}

/// Converts the pieces into bodies. `released`: the cracks exert impulses. `name` gives the name of a piece
/// by its index.
///
/// # Errors
/// [`FractureError`] for a piece that is not a valid body.
pub(super) fn fragments(
    parent: &Parent<'_>,
    broken: Broken,
    released: bool,
    name: impl Fn(usize) -> String,
) -> Result<Fragments, FractureError> {
    let Broken { shatter, stress, impact_energy, seed } = broken;
    let density = parent.body.material.density;
    let solids = shatter.pieces.iter().map(Piece::mass_properties).collect::<Result<Vec<_>, _>>()?;
    let mass: f64 = solids.iter().map(|s| s.volume).sum();
    // The pieces share the mass of the parent, which is that of its exact shape.
    let density = if mass > 0.0 { parent.body.mass / mass } else { density };
    // Inherited motions of the pieces, in the axes of the parent.
    let turn = DMat3::from_quat(parent.state.orientation);
    let whole = Motion {
        mass: parent.body.mass,
        centre: parent.centre,
        inertia: parent.body.inertia,
        velocity: turn.transpose() * parent.state.velocity,
        angular_velocity: turn.transpose() * parent.state.angular_velocity,
    };
    let mut motions: Vec<Motion> = solids.iter().map(|solid| whole.of_piece(solid, density)).collect();
    // Impulses of the cracks.
    let surplus = shatter.surplus();
    let tensors: Vec<DMat3> = stress.iter().map(|s| s.matrix()).collect();
    let release = match released {
        true => match crack_impulses(&shatter.crack_faces, &tensors, &motions, surplus) {
            Ok(release) => Some(release),
            // In these cases nothing drives the pieces apart.
            Err(NoImpulse::NoSurplus(_) | NoImpulse::NoTraction) => None,
            Err(error) => return Err(error.into()),
        },
        false => None,
    };
    let before: f64 = motions.iter().map(Motion::kinetic_energy).sum();
    if let Some(release) = &release {
        motions.clone_from(&release.motions);
    }
    let after: f64 = motions.iter().map(Motion::kinetic_energy).sum();
    // Bodies of the solver.
    let to_world = |x: DVec3| parent.state.position + turn * (x - parent.centre);
    let mut bodies = Vec::with_capacity(motions.len());
    // The modes of pieces are not known.
    let material = parent.body.material.clone().rigid();
    let hulls = piece_hulls(&shatter.pieces, &shatter.crack_faces, HullSettings::default())?;
    for (k, ((piece, hulls), motion)) in shatter.pieces.iter().zip(hulls).zip(&motions).enumerate() {
        let (surface, _) = MeshSurface::try_new(piece.surface(), hulls.parts)?;
        let surface = Surface::Mesh(surface);
        check_surface(&surface).map_err(FractureError::Collision)?;
        let pose = Pose { position: to_world(motion.centre), orientation: parent.state.orientation };
        let piece = Body::new(name(k), material.clone(), surface, motion.mass, motion.inertia)
            .at(pose)
            .with_velocity(turn * motion.velocity)
            .with_angular_velocity(turn * motion.angular_velocity);
        bodies.push(piece);
    }
    let row = FractureRow {
        impact_energy,
        strain_energy: shatter.strain_energy,
        fracture_energy: shatter.fracture_energy,
        kinetic_energy_gain: after - before,
        crack_area: shatter.crack_faces.iter().map(|f| f.area_vector().length()).sum(),
        duration: release.as_ref().map_or(0.0, |r| r.duration),
        seed,
        ..FractureRow::of(parent.state.body)
    };
    let cracks =
        release.map_or_else(Vec::new, |release| together(&shatter.crack_faces, &release, turn, to_world));
    Ok(Fragments { replacement: Replacement { row, pieces: bodies, cracks }, pieces: shatter.pieces })
}

/// For each pair of pieces one impulse of the faces under tension and one of those under compression.
fn together(
    faces: &[CrackFace],
    release: &CrackImpulses,
    turn: DMat3,
    to_world: impl Fn(DVec3) -> DVec3,
) -> Vec<CrackImpulse> {
    /// Faces between two pieces, each with its impulse.
    type Parts<'a> = Vec<(&'a CrackFace, DVec3)>;
    let mut groups: BTreeMap<([u32; 2], bool), Parts<'_>> = BTreeMap::new();
    for (face, impulse) in faces.iter().zip(&release.impulses) {
        let pulled = impulse.dot(face.area_vector()) < 0.0;
        groups.entry((face.pieces, pulled)).or_default().push((face, *impulse));
    }
    let join = |pieces: [u32; 2], parts: Parts<'_>| {
        let impulse: DVec3 = parts.iter().map(|(_, j)| *j).sum();
        let weight: f64 = parts.iter().map(|(_, j)| j.length()).sum();
        let point = parts.iter().map(|(face, j)| face.centroid() * j.length()).sum::<DVec3>() / weight;
        let couple: DVec3 = parts.iter().map(|(face, j)| (face.centroid() - point).cross(*j)).sum();
        let outward: DVec3 = parts.iter().map(|(face, _)| face.area_vector()).sum();
        // The normal of a crack points out of b, into a.
        let normal = -outward.try_normalize()?;
        let [piece_a, piece_b] = pieces.map(|p| p as usize);
        (weight > 0.0).then(|| CrackImpulse {
            piece_a,
            piece_b,
            point: to_world(point),
            normal: turn * normal,
            impulse: turn * impulse,
            couple: turn * couple,
        })
    };
    groups.into_iter().filter_map(|((pieces, _), parts)| join(pieces, parts)).collect()
}
