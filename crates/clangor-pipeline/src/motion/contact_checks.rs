//! Contacts that another program recorded, against the surfaces, masses and speeds of the bodies.
//!
//! | found | then |
//! |---|---|
//! | a body against itself; bodies that separate; an impulse beyond what all bodies together could give; a point farther from a surface than the body is large | refused, with row and body |
//! | no second body, at a plane of the scene | belongs to the plane; told |
//! | a point off a surface by more than a tolerance | moved to the surface; told |
//!
//! An impulse between two bodies is at most (1 + e) m v of all that moves, with e ≤ 1; m v of the two alone
//! is exceeded where other bodies press on them.

use std::collections::BTreeSet;

use clangor_core::body::{Body, BodyId, Motion, Surface, World};
use clangor_core::pose::Pose;
use clangor_core::timeline::{ContactKind, ContactRow};
use glam::DVec3;

use crate::formats::contact_list::ListedContact;

/// Distance from a surface that is taken for rounding: a share of the body, and at least \[m\].
const ON_SURFACE: (f64, f64) = (0.02, 1e-4);
/// The same for a plane, from which a contact belongs to it; the share is that of the other body.
const ON_PLANE: (f64, f64) = (0.1, 1e-3);
/// Margin on the largest impulse that is possible.
const IMPULSE_MARGIN: f64 = 5.0;

/// Why a contact is impossible.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ContactFault {
    /// A body against itself.
    #[error("row {row}: {body} touches itself; body_b is another body, or left out for the surroundings")]
    Itself {
        /// Line of a text, row of a Parquet file.
        row: usize,
        /// The body.
        body: String,
    },
    /// An impact of bodies that separate.
    #[error(
        "row {row}: {body} recedes from what it hits with {speed} m/s; the normal points from body_b to \
         body_a, \
         and velocity is that of body_a relative to body_b before the impact"
    )]
    Recedes {
        /// Line of a text, row of a Parquet file.
        row: usize,
        /// The body.
        body: String,
        /// Speed of separation [m/s].
        speed: f64,
    },
    /// A point that is nowhere near a body.
    #[error("row {row}: the point is {distance} m off the surface of {body}, which is {size} m in radius")]
    FarOff {
        /// Line of a text, row of a Parquet file.
        row: usize,
        /// The body.
        body: String,
        /// Distance \[m\].
        distance: f64,
        /// Bounding radius of the body \[m\].
        size: f64,
    },
    /// An impulse that nothing can give.
    #[error(
        "row {row}: impulse_n on {body} is {impulse} N s; all that moves could give at most {possible} N s \
         at \
         the speeds of this list"
    )]
    TooStrong {
        /// Line of a text, row of a Parquet file.
        row: usize,
        /// The body.
        body: String,
        /// The impulse [N s].
        impulse: f64,
        /// 2 Σ m · largest speed [N s].
        possible: f64,
    },
}

/// What was changed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ContactNotice {
    /// Contacts without a second body, at a plane.
    #[error("{count} contacts without body_b belong to the plane {plane}, on which they lie")]
    OnPlane {
        /// How many.
        count: usize,
        /// The plane.
        plane: String,
    },
    /// Points that were moved to a surface.
    #[error(
        "{count} points were off the surface of {body} and were moved onto it; the farthest, in row {row}, \
         by {distance} m"
    )]
    Moved {
        /// How many.
        count: usize,
        /// The body.
        body: String,
        /// Row of the farthest.
        row: usize,
        /// Its distance \[m\].
        distance: f64,
    },
}

/// Where bodies are; `None` where that is not known.
pub type PoseOf<'a> = &'a dyn Fn(BodyId, f64) -> Option<Pose>;

/// Checks rows and repairs what can be.
///
/// # Errors
/// [`ContactFault`] of the first impossible row.
pub fn check_contacts(
    world: &World,
    rows: Vec<ListedContact>,
    pose_of: PoseOf<'_>,
) -> Result<(Vec<ContactRow>, Vec<ContactNotice>), ContactFault> {
    let limits = Limits::new(world, &rows);
    let mut on_plane = vec![0_usize; world.bodies.len()];
    let mut moved: Vec<(usize, usize, f64)> = vec![(0, 0, 0.0); world.bodies.len()];
    let mut checked = Vec::with_capacity(rows.len());
    for ListedContact { line: number, mut row, names_second } in rows {
        check_physics(world, number, &row, &limits)?;
        if row.kind == ContactKind::Constraint {
            checked.push(row);
            continue;
        }
        if !names_second && let Some(plane) = plane_at(world, &row) {
            row.body_b = plane;
            on_plane[plane.index()] += 1;
        }
        for id in [row.body_a, row.body_b] {
            let Some(body) = world.bodies.get(id.index()) else { continue };
            let Some(pose) = pose_of(id, row.time) else { continue };
            let Some((distance, place)) = off_surface(body, pose, row.point) else { continue };
            let size = body.surface.bounding_radius();
            if distance > size {
                return Err(ContactFault::FarOff { row: number, body: body.name.clone(), distance, size });
            }
            row.point = place;
            let (count, farthest, most) = &mut moved[id.index()];
            *count += 1;
            if distance > *most {
                (*farthest, *most) = (number, distance);
            }
        }
        checked.push(row);
    }
    let name = |index: usize| world.bodies[index].name.clone();
    let mut notices = Vec::new();
    for (index, &count) in on_plane.iter().enumerate().filter(|(_, count)| **count > 0) {
        notices.push(ContactNotice::OnPlane { count, plane: name(index) });
    }
    for (index, &(count, row, distance)) in moved.iter().enumerate().filter(|(_, moved)| moved.0 > 0) {
        notices.push(ContactNotice::Moved { count, body: name(index), row, distance });
    }
    Ok((checked, notices))
}

/// What a list allows.
struct Limits {
    /// 2 Σ m · largest speed [N s].
    possible: f64,
    /// Impacts with a point that approaches.
    approaching: BTreeSet<u64>,
}

impl Limits {
    fn new(world: &World, rows: &[ListedContact]) -> Self {
        let moving = world.bodies.iter().filter(|body| !matches!(body.motion, Motion::Fixed));
        // What keyframes move has any impulse.
        let mass: f64 = moving
            .map(|body| if matches!(body.motion, Motion::Free) { body.mass } else { f64::INFINITY })
            .sum();
        let speed = rows.iter().map(|listed| listed.row.velocity.length()).fold(0.0, f64::max);
        let approaches = rows.iter().filter(|listed| listed.row.velocity.dot(listed.row.normal) < 0.0);
        let approaching = approaches.map(|listed| listed.row.impact_id).collect();
        Limits { possible: 2.0 * mass * speed, approaching }
    }
}

fn check_physics(
    world: &World,
    number: usize,
    row: &ContactRow,
    limits: &Limits,
) -> Result<(), ContactFault> {
    let body = || world.bodies.get(row.body_a.index()).map_or_else(String::new, |body| body.name.clone());
    if row.body_a == row.body_b {
        return Err(ContactFault::Itself { row: number, body: body() });
    }
    if row.kind != ContactKind::Impact {
        return Ok(());
    }
    // Of an impact at several points, or in several steps, some may recede.
    let speed = row.velocity.dot(row.normal);
    if speed > 0.0 && !limits.approaching.contains(&row.impact_id) {
        return Err(ContactFault::Recedes { row: number, body: body(), speed });
    }
    let (impulse, possible) = (row.impulse_n, limits.possible);
    if possible > 0.0 && impulse > IMPULSE_MARGIN * possible {
        return Err(ContactFault::TooStrong { row: number, body: body(), impulse, possible });
    }
    Ok(())
}

/// The plane on which a contact lies and against which it pushes.
fn plane_at(world: &World, row: &ContactRow) -> Option<BodyId> {
    let size = world.bodies.get(row.body_a.index())?.surface.bounding_radius();
    let within = (ON_PLANE.0 * size).max(ON_PLANE.1);
    let height = |body: &Body| body.pose.body_from_world(row.point).y.abs();
    let faces = |body: &Body| (body.pose.orientation * DVec3::Y).dot(row.normal) > 0.9;
    let planes = world.bodies.iter().enumerate().filter(|(_, body)| body.surface.is_plane() && faces(body));
    let nearest = planes.min_by(|(_, a), (_, b)| height(a).total_cmp(&height(b)));
    nearest.filter(|(_, plane)| height(plane) <= within).map(|(index, _)| BodyId(index as u32))
}

/// Distance of a point from a surface and its place there, if it is not on the surface.
fn off_surface(body: &Body, pose: Pose, point: DVec3) -> Option<(f64, DVec3)> {
    let local = pose.body_from_world(point);
    let size = body.surface.bounding_radius();
    let (place, tolerance) = match &*body.surface {
        Surface::HalfSpace | Surface::Plate { .. } => (DVec3::new(local.x, 0.0, local.z), ON_PLANE.1),
        Surface::Sphere { radius } => {
            (local.normalize_or(DVec3::Y) * *radius, (ON_SURFACE.0 * size).max(ON_SURFACE.1))
        }
        Surface::Mesh(mesh) => (mesh.nearest(local)?.position, (ON_SURFACE.0 * size).max(ON_SURFACE.1)),
    };
    let distance = place.distance(local);
    (distance > tolerance).then(|| (distance, pose.world_from_body(place)))
}
