//! Contacts that another program recorded, against the surfaces, masses and speeds of the bodies.
//!
//! | found | then |
//! |---|---|
//! | a body against itself; bodies that separate; a normal into a half-space | refused, with row and body |
//! | an impulse beyond what the bodies could give | refused |
//! | a point farther from a surface than the smaller body is large | refused |
//! | a time before or after all that was recorded | refused |
//! | no second body, at a plane of the scene | belongs to the plane; told |
//! | a point off a surface by more than a tolerance | moved to the surface; told |
//!
//! An impulse between two bodies is at most (1 + e) m v, with e ≤ 1, their reduced mass m and their speed v.
//! Where other bodies press on them in the same moments, it is at most that of all that moves. An effective
//! mass that is given counts where it is the larger one: links on joints are heavier than they are alone.

use std::collections::BTreeSet;
use std::path::Path;

use clangor_core::body::{Body, BodyId, Motion, Surface, World};
use clangor_core::pose::Pose;
use clangor_core::quantity::{readable, readable_length, rounded};
use clangor_core::timeline::{ContactKind, ContactRow};
use glam::DVec3;

use super::recording::MAX_TIME;
use crate::formats::contact_list::ListedContact;

/// Distance from a surface that is taken for rounding: a share of the body, and at least \[m\].
const ON_SURFACE: (f64, f64) = (0.02, 1e-4);
/// The same for a plane, from which a contact belongs to it; the share is that of the other body.
const ON_PLANE: (f64, f64) = (0.1, 1e-3);
/// Depth in a half-space, over the bounding radius of the smaller body, up to which a contact belongs there.
const DEEPEST: f64 = 2.0;
/// Cosine of the angle of the two normals within which a contact is one with the plane.
const ALONG: f64 = 0.9;
/// Cosine from which on a normal points into a plane: those of edges lie across it.
const ACROSS: f64 = 0.1;
/// Margin on the largest impulse of two bodies that no listed contact presses on: contacts that last are not
/// listed by all programs.
const PAIR_MARGIN: f64 = 20.0;
/// Margin on the largest impulse of all that moves.
const ALL_MARGIN: f64 = 5.0;
/// Contacts within this time may press on each other \[s\].
const SAME_MOMENT: f64 = 0.005;
/// How far a contact may lie before the first pose or after the last \[s\].
const OUTSIDE: f64 = 0.1;

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
    /// An impact without speed.
    #[error(
        "row {row}: {body} does not approach what it hits: its speed before the impact is 0; give the speed \
         of approach, or the kind contact for what rests"
    )]
    Still {
        /// Line of a text, row of a Parquet file.
        row: usize,
        /// The body.
        body: String,
    },
    /// A normal that would pull a body into a plane.
    #[error(
        "row {row}: the normal of the contact of {body} points into the plane {plane}; it points from body_b \
         to body_a, out of the plane if that is body_b or left out"
    )]
    IntoPlane {
        /// Line of a text, row of a Parquet file.
        row: usize,
        /// The body.
        body: String,
        /// The plane.
        plane: String,
    },
    /// A point that is nowhere near a body.
    #[error(
        "row {row}: the point is {} off the surface of {body} at that time; the smaller body is {} in radius",
        readable_length(*distance), readable_length(*size)
    )]
    FarOff {
        /// Line of a text, row of a Parquet file.
        row: usize,
        /// The body.
        body: String,
        /// Distance \[m\].
        distance: f64,
        /// Bounding radius of the smaller of the two bodies \[m\].
        size: f64,
    },
    /// An impulse that nothing can give.
    #[error(
        "row {row}: impulse_n on {body} is {} N s; the bodies could give no more than {} N s at the speeds \
         of this list, with a wide margin; multiply forces in newtons by the time in which they act (the \
         step of the engine)",
        readable(rounded(*impulse, 4)), readable(rounded(*possible, 2))
    )]
    TooStrong {
        /// Line of a text, row of a Parquet file.
        row: usize,
        /// The body.
        body: String,
        /// The impulse [N s].
        impulse: f64,
        /// What they could give, with its margin [N s].
        possible: f64,
    },
    /// A contact before or after all poses.
    #[error(
        "row {row}: t = {time} s, but the motion was recorded from {from} to {to} s; a contact list needs \
         the clock of the motion"
    )]
    Clock {
        /// Line of a text, row of a Parquet file.
        row: usize,
        /// Time of the contact \[s\].
        time: f64,
        /// First pose \[s\].
        from: f64,
        /// Last pose \[s\].
        to: f64,
    },
    /// A number of an impact that is too large beside those of other lists.
    #[error("row {row}: impact_id is {id}, which is too large; number impacts from 1")]
    ImpactId {
        /// Line of a text, row of a Parquet file.
        row: usize,
        /// The number.
        id: u64,
    },
}

/// What was changed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ContactNotice {
    /// Contacts without a second body, at a plane.
    #[error(
        "{}",
        match count {
            1 => format!("1 contact without body_b belongs to the plane {plane}, on which it lies"),
            _ => format!("{count} contacts without body_b belong to the plane {plane}, on which they lie"),
        }
    )]
    OnPlane {
        /// How many.
        count: usize,
        /// The plane.
        plane: String,
    },
    /// Points that were moved to a surface.
    #[error(
        "{} off the surface of {body} and moved onto it; the farthest, in row {row}, by {}",
        match count { 1 => "1 point was".into(), count => format!("{count} points were") },
        readable_length(*distance)
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

/// What to say of a list without contacts.
pub(crate) fn no_contacts(path: &Path) -> String {
    format!("{} has no contacts: what it should give makes no sound", path.display())
}

/// The first contact at a time that no timeline has.
pub fn time_outside(rows: &[ListedContact]) -> Option<&ListedContact> {
    rows.iter().find(|listed| !(0.0..=MAX_TIME).contains(&listed.row.time))
}

/// Holds the times of contacts against the first and last pose of a recording \[s\].
///
/// # Errors
/// [`ContactFault::Clock`] of the first row that lies outside.
pub fn check_clock(rows: &[ListedContact], [from, to]: [f64; 2]) -> Result<(), ContactFault> {
    let is_outside = |listed: &&ListedContact| !(from - OUTSIDE..=to + OUTSIDE).contains(&listed.row.time);
    match rows.iter().find(is_outside) {
        Some(ListedContact { line, row, .. }) => {
            Err(ContactFault::Clock { row: *line, time: row.time, from, to })
        }
        None => Ok(()),
    }
}

/// Checks rows, which come in order of time, and repairs what can be.
///
/// # Errors
/// [`ContactFault`] of the first impossible row.
pub fn check_contacts(
    world: &World,
    rows: Vec<ListedContact>,
    pose_of: PoseOf<'_>,
) -> Result<(Vec<ContactRow>, Vec<ContactNotice>), ContactFault> {
    let mut checks = ContactChecks::new(world, rows);
    let checked = checks.check_before(f64::INFINITY, pose_of)?;
    Ok((checked, checks.notices()))
}

/// The rows of a list, in order of time, checked up to some time.
pub(crate) struct ContactChecks<'a> {
    world: &'a World,
    rows: Vec<ListedContact>,
    /// Rows that are checked.
    checked: usize,
    limits: Limits,
    /// Contacts of each body that belong to it as a plane.
    on_plane: Vec<usize>,
    /// Points that were moved onto each body: how many, and row and distance \[m\] of the farthest.
    moved: Vec<(usize, usize, f64)>,
}

impl<'a> ContactChecks<'a> {
    /// None of them checked.
    pub(crate) fn new(world: &'a World, rows: Vec<ListedContact>) -> Self {
        let (limits, bodies) = (Limits::new(world, &rows), world.bodies.len());
        ContactChecks {
            world,
            rows,
            checked: 0,
            limits,
            on_plane: vec![0; bodies],
            moved: vec![(0, 0, 0.0); bodies],
        }
    }

    /// The rows that are not checked yet.
    pub(crate) fn left(&self) -> &[ListedContact] {
        &self.rows[self.checked..]
    }

    /// Checks the next rows, those before a time \[s\], and repairs what can be.
    ///
    /// # Errors
    /// [`ContactFault`] of the first impossible row.
    pub(crate) fn check_before(
        &mut self,
        time: f64,
        pose_of: PoseOf<'_>,
    ) -> Result<Vec<ContactRow>, ContactFault> {
        let count = self.left().partition_point(|listed| listed.row.time < time);
        let rows = self.checked..self.checked + count;
        self.checked = rows.end;
        rows.map(|index| self.check(index, pose_of)).collect()
    }

    fn check(&mut self, index: usize, pose_of: PoseOf<'_>) -> Result<ContactRow, ContactFault> {
        let world = self.world;
        let ListedContact { line: number, mut row, names_second } = self.rows[index];
        let possible = self.limits.largest_impulse(world, &self.rows, index);
        check_physics(world, number, &row, &self.limits, possible)?;
        if row.kind == ContactKind::Constraint {
            return Ok(row);
        }
        if !names_second && let Some(plane) = plane_at(world, &row) {
            row.body_b = plane;
            self.on_plane[plane.index()] += 1;
        }
        check_planes(world, number, &row, names_second, pose_of)?;
        let radius = |id: BodyId| Some(world.bodies.get(id.index())?.surface.bounding_radius());
        let size = [row.body_a, row.body_b].into_iter().filter_map(radius).fold(f64::INFINITY, f64::min);
        // Moved onto the first surface and then onto the second, the point must still be near the first.
        for (id, is_repeated) in [(row.body_a, false), (row.body_b, false), (row.body_a, true)] {
            let Some(body) = world.bodies.get(id.index()) else { continue };
            let Some(pose) = pose_of(id, row.time) else { continue };
            let Some((distance, place)) = off_surface(body, pose, row.point) else { continue };
            // Soft contacts of engines lie deep in what gives way.
            let most = if matches!(*body.surface, Surface::HalfSpace) { DEEPEST * size } else { size };
            if distance > most {
                return Err(ContactFault::FarOff { row: number, body: body.name.clone(), distance, size });
            }
            if is_repeated {
                continue;
            }
            row.point = place;
            let (count, farthest, most) = &mut self.moved[id.index()];
            *count += 1;
            if distance > *most {
                (*farthest, *most) = (number, distance);
            }
        }
        Ok(row)
    }

    /// What was changed in the rows that are checked.
    pub(crate) fn notices(&self) -> Vec<ContactNotice> {
        let name = |index: usize| self.world.bodies[index].name.clone();
        let mut notices = Vec::new();
        for (index, &count) in self.on_plane.iter().enumerate().filter(|(_, count)| **count > 0) {
            notices.push(ContactNotice::OnPlane { count, plane: name(index) });
        }
        let moved = self.moved.iter().enumerate().filter(|(_, moved)| moved.0 > 0);
        for (index, &(count, row, distance)) in moved {
            notices.push(ContactNotice::Moved { count, body: name(index), row, distance });
        }
        notices
    }
}

/// What a list allows.
struct Limits {
    /// 2 Σ m · largest speed, with its margin [N s].
    all: f64,
    /// Impacts with a point that approaches.
    approaching: BTreeSet<u64>,
}

impl Limits {
    fn new(world: &World, rows: &[ListedContact]) -> Self {
        let moving = world.bodies.iter().filter(|body| !matches!(body.motion, Motion::Fixed));
        // A body that keyframes move can give any impulse.
        let bodies: f64 =
            moving.map(|body| if body.motion.is_movable() { body.mass } else { f64::INFINITY }).sum();
        let mass = rows.iter().filter_map(|listed| listed.row.effective_mass).fold(bodies, f64::max);
        let speed = rows.iter().map(|listed| listed.row.velocity.length()).fold(0.0, f64::max);
        let approaches = rows.iter().filter(|listed| listed.row.velocity.dot(listed.row.normal) < 0.0);
        let approaching = approaches.map(|listed| listed.row.impact_id).collect();
        Limits { all: ALL_MARGIN * 2.0 * mass * speed, approaching }
    }

    /// Largest impulse of a row, with its margin [N s]; infinite where nothing limits it.
    fn largest_impulse(&self, world: &World, rows: &[ListedContact], index: usize) -> f64 {
        let row = &rows[index].row;
        let all = if self.all > 0.0 { self.all } else { f64::INFINITY };
        if row.kind != ContactKind::Impact {
            return all;
        }
        let is_free = |id: BodyId| world.bodies.get(id.index()).is_some_and(|body| body.motion.is_movable());
        let inverse_mass = |id: BodyId| {
            world.bodies.get(id.index()).filter(|_| is_free(id)).map_or(0.0, |body| body.mass.recip())
        };
        let pair = [row.body_a, row.body_b];
        let near = |other: &&ListedContact| (other.row.time - row.time).abs() <= SAME_MOMENT;
        let moment = rows[..index].iter().rev().take_while(near).chain(rows[index..].iter().take_while(near));
        let mut speed = 0.0_f64;
        for ListedContact { row: other, .. } in moment {
            let others = [other.body_a, other.body_b];
            let is_same = others.iter().all(|id| pair.contains(id));
            if is_same {
                speed = speed.max(other.velocity.length());
            } else if pair.iter().any(|id| is_free(*id) && others.contains(id)) {
                // A third body presses.
                return all;
            }
        }
        let alone = pair.map(inverse_mass).iter().sum::<f64>().recip();
        let mass = row.effective_mass.map_or(alone, |mass| mass.max(alone));
        if speed > 0.0 { (PAIR_MARGIN * 2.0 * mass * speed).min(all) } else { all }
    }
}

fn check_physics(
    world: &World,
    number: usize,
    row: &ContactRow,
    limits: &Limits,
    possible: f64,
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
    if speed >= 0.0 && !limits.approaching.contains(&row.impact_id) {
        let still = ContactFault::Still { row: number, body: body() };
        let recedes = ContactFault::Recedes { row: number, body: body(), speed };
        return Err(if speed > 0.0 { recedes } else { still });
    }
    let impulse = row.impulse_n;
    if impulse > possible {
        return Err(ContactFault::TooStrong { row: number, body: body(), impulse, possible });
    }
    Ok(())
}

/// Refuses normals that point into a half-space: one of the bodies, or one on whose side of the first body a
/// contact without a second lies.
fn check_planes(
    world: &World,
    number: usize,
    row: &ContactRow,
    names_second: bool,
    pose_of: PoseOf<'_>,
) -> Result<(), ContactFault> {
    let fault = |body: BodyId, plane: &Body| {
        let body = world.bodies.get(body.index()).map_or_else(String::new, |body| body.name.clone());
        Err(ContactFault::IntoPlane { row: number, body, plane: plane.name.clone() })
    };
    for (id, other, out) in [(row.body_b, row.body_a, 1.0), (row.body_a, row.body_b, -1.0)] {
        let Some(plane) = world.bodies.get(id.index()) else { continue };
        let is_half_space = matches!(*plane.surface, Surface::HalfSpace);
        if is_half_space && out * upward(plane).dot(row.normal) < -ACROSS {
            return fault(other, plane);
        }
    }
    if names_second || row.body_b != BodyId::WORLD {
        return Ok(());
    }
    let turned = ContactRow { normal: -row.normal, ..*row };
    let plane = plane_at(world, &turned).and_then(|id| world.bodies.get(id.index()));
    // Below the surface of a half-space no body can be, wherever it is; a flat one is hit above it.
    let is_above = |plane: &Body| match pose_of(row.body_a, row.time) {
        Some(pose) => (row.point - pose.position).dot(upward(plane)) < 0.0,
        None => {
            let height = plane.pose.body_from_world(row.point).y.abs();
            matches!(*plane.surface, Surface::HalfSpace) && height <= ON_PLANE.1
        }
    };
    match plane {
        Some(plane) if is_above(plane) => fault(row.body_a, plane),
        _ => Ok(()),
    }
}

/// Unit normal of a plane.
fn upward(plane: &Body) -> DVec3 {
    plane.pose.orientation * DVec3::Y
}

/// The plane on which a contact lies and against which it pushes.
fn plane_at(world: &World, row: &ContactRow) -> Option<BodyId> {
    let size = world.bodies.get(row.body_a.index())?.surface.bounding_radius();
    let within = (ON_PLANE.0 * size).max(ON_PLANE.1);
    let height = |body: &Body| body.pose.body_from_world(row.point).y.abs();
    let faces = |body: &Body| upward(body).dot(row.normal) > ALONG;
    let planes = world.bodies.iter().enumerate().filter(|(_, body)| body.surface.is_plane() && faces(body));
    let nearest = planes.min_by(|(_, a), (_, b)| height(a).total_cmp(&height(b)));
    let overlaps = |plane: &Body| {
        let is_solid = matches!(*plane.surface, Surface::HalfSpace);
        is_solid && (-DEEPEST * size..=0.0).contains(&plane.pose.body_from_world(row.point).y)
    };
    let lies_on = |(_, plane): &(usize, &Body)| height(plane) <= within || overlaps(plane);
    nearest.filter(lies_on).map(|(index, _)| BodyId(index as u32))
}

/// Distance from the surface of a body of a bounding radius that is taken for rounding \[m\].
pub(crate) fn surface_tolerance(radius: f64) -> f64 {
    (ON_SURFACE.0 * radius).max(ON_SURFACE.1)
}

/// Distance of a point from a surface and its place there, if it is not on the surface.
fn off_surface(body: &Body, pose: Pose, point: DVec3) -> Option<(f64, DVec3)> {
    let local = pose.body_from_world(point);
    let size = body.surface.bounding_radius();
    let (place, tolerance) = match &*body.surface {
        Surface::HalfSpace | Surface::Plate { .. } => (DVec3::new(local.x, 0.0, local.z), ON_PLANE.1),
        Surface::Sphere { radius } => (local.normalize_or(DVec3::Y) * *radius, surface_tolerance(size)),
        Surface::Mesh(mesh) => (mesh.nearest(local)?.position, surface_tolerance(size)),
    };
    let distance = place.distance(local);
    (distance > tolerance).then(|| (distance, pose.world_from_body(place)))
}
