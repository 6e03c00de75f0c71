//! Rows of a timeline become force pulses: one per impact, with what it does to each body.
//!
//! All points of a merged impact share one duration τ, from the mean point and normal, weighted by normal
//! impulse, the curvatures weighted likewise, and the approach speed before the first instant, the largest of
//! its points. Impulses are summed exactly: Σj and Σ (x − x_com) × j.
//!
//! A body that breaks gets the whole of the pulse that broke it, even what comes after its death: the time of
//! a fracture is known to a time step, and the impulse has moved the body by then.
//!
//! A body that contacts cannot move (fixed, keyframed, half-space, world) radiates nothing; its stiffness and
//! curvature count. The world, which has no material, is a rigid plane.

use std::collections::BTreeMap;

use glam::DVec3;

use super::ContactError;
use super::chain_onset::delay_chains;
use super::effective_mass::{angular_velocity_change, body_inverse_effective_mass, inverse_mass};
use super::force_profile::ForceProfile;
use super::hertz::{HertzContact, combined_curvature};
use super::local_curvature::mean_curvature;
use super::pose_history::PoseHistory;
use crate::body::{Body, BodyId, Life, Motion};
use crate::material::Material;
use crate::pose::Pose;
use crate::timeline::{ContactKind, ContactRow};

/// How impacts become forces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactSettings {
    /// Impacts slower than this are silent [m/s]; \[PAN\] §4.3 uses 5 cm/s.
    pub v_min: f64,
    /// How the force runs.
    pub profile: ForceProfile,
    /// Whether impacts take time to travel along chains ([`chain_onset`](super::chain_onset)).
    pub chain_onset: bool,
}

impl Default for ContactSettings {
    fn default() -> Self {
        ContactSettings { v_min: 0.05, profile: ForceProfile::HalfSine, chain_onset: true }
    }
}

/// The force of one impact over time.
#[derive(Clone, Debug, PartialEq)]
pub struct ImpactPulse {
    /// Number of the impact in the timeline; 0 for a row that stands alone.
    pub impact_id: u64,
    /// First instant in the timeline \[s\].
    pub time: f64,
    /// When the force begins \[s\]: `time`, or later inside a chain.
    pub onset: f64,
    /// Duration τ \[s\].
    pub duration: f64,
    /// How the force runs.
    pub profile: ForceProfile,
    /// Approach speed V along the normal [m/s].
    pub speed: f64,
    /// Effective mass m \[kg\].
    pub effective_mass: f64,
    /// Combined radius r \[m\].
    pub radius: f64,
    /// Mean point [m, world].
    pub point: DVec3,
    /// Mean unit normal, from B to A.
    pub normal: DVec3,
    /// Velocity of A relative to B at the mean point before anything happened at that instant [m/s], where
    /// the timeline has the poses of that instant. In a touching chain only the first contact approaches
    /// then.
    pub velocity_before: Option<DVec3>,
    /// A and B.
    pub pair: [BodyId; 2],
    /// What it does to A and B; `None` for a body that it cannot move.
    pub bodies: [Option<BodyPulse>; 2],
    /// The points: place [m, world] and impulse on A [N s].
    pub points: Vec<(DVec3, DVec3)>,
}

impl ImpactPulse {
    /// Places \[m\] and impulses [N s] on a body in its frame, for each side of the impact that it is.
    pub fn points_on(&self, body: BodyId) -> impl Iterator<Item = Vec<(DVec3, DVec3)>> {
        let sides = self.bodies.iter().zip([1.0, -1.0]);
        sides.filter_map(move |(share, sign)| {
            let pose = share.filter(|share| share.body == body)?.pose;
            let to_body = pose.orientation.inverse();
            let local = |(x, j): &(DVec3, DVec3)| (pose.body_from_world(*x), to_body * *j * sign);
            Some(self.points.iter().map(local).collect())
        })
    }

    /// Whether it is the release of a crack, which has no curvature.
    pub fn is_crack(&self) -> bool {
        self.radius == f64::INFINITY
    }
}

/// One body's share of an impact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyPulse {
    /// The body.
    pub body: BodyId,
    /// Its pose at the impact.
    pub pose: Pose,
    /// Σj [N s], world.
    pub impulse: DVec3,
    /// Σj/M [m/s], world.
    pub velocity_change: DVec3,
    /// Σ (x − x_com) × j + couples [N m s], world, about the centre of mass.
    pub angular_impulse: DVec3,
    /// I⁻¹ of that [rad/s], world.
    pub angular_velocity_change: DVec3,
    /// τ c_R / L: duration over the time in which a Rayleigh wave crosses the body. Below 1 the body does not
    /// move as a whole during the impact, and the click of a rigid body is an upper bound.
    pub transit_ratio: f64,
}

/// What became of the impacts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContactReport {
    /// Impacts that sound.
    pub pulses: u64,
    /// Impacts slower than v_min.
    pub slow: u64,
    /// Impacts without a normal impulse.
    pub without_impulse: u64,
    /// Impacts between bodies that cannot move.
    pub immovable: u64,
    /// Pulses whose onset a chain delayed.
    pub delayed: u64,
    /// The same for each body.
    pub bodies: Vec<BodyContacts>,
}

/// What became of the impacts of one body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyContacts {
    /// Impacts that sound.
    pub pulses: u64,
    /// Impacts slower than v_min.
    pub slow: u64,
    /// Impacts without a normal impulse.
    pub without_impulse: u64,
    /// Pulses shorter than the body's elastic transit time.
    pub shorter_than_transit: u64,
    /// Smallest τ c_R / L; infinite without pulses.
    pub smallest_transit_ratio: f64,
}

impl Default for BodyContacts {
    fn default() -> Self {
        BodyContacts {
            pulses: 0,
            slow: 0,
            without_impulse: 0,
            shorter_than_transit: 0,
            smallest_transit_ratio: f64::INFINITY,
        }
    }
}

/// Turns the impacts among `rows` into pulses, in order of time; rows of other kinds are left alone, those of
/// cracks to [`crack_pulses`](fn@super::crack_pulses::crack_pulses).
///
/// `rows` hold whole impacts in order of time: rows with the same impact id, or single rows of kind
/// [`ContactKind::Impact`] with id 0.
///
/// # Errors
/// Unknown bodies, numbers that are not finite, bodies without mass or stiffness.
pub fn impact_pulses(
    bodies: &[Body],
    rows: &[ContactRow],
    poses: &PoseHistory,
    settings: &ContactSettings,
) -> Result<(Vec<ImpactPulse>, ContactReport), ContactError> {
    let mut report =
        ContactReport { bodies: vec![BodyContacts::default(); bodies.len()], ..Default::default() };
    let mut pulses = Vec::new();
    for impact in whole_impacts(rows) {
        for row in &impact {
            check_row(bodies, row)?;
        }
        let outcome = pulse(bodies, &impact, poses, settings)?;
        for id in [impact[0].body_a, impact[0].body_b] {
            if let Some(counts) = report.bodies.get_mut(id.index()) {
                count(counts, &outcome, id);
            }
        }
        match outcome {
            Ok(pulse) => pulses.push(pulse),
            Err(Silence::Slow) => report.slow += 1,
            Err(Silence::WithoutImpulse) => report.without_impulse += 1,
            Err(Silence::Immovable) => report.immovable += 1,
        }
    }
    pulses.sort_by(|a, b| a.time.total_cmp(&b.time));
    report.pulses = pulses.len() as u64;
    if settings.chain_onset {
        report.delayed = delay_chains(&mut pulses);
    }
    Ok((pulses, report))
}

/// Why an impact makes no sound.
#[derive(Clone, Copy, Debug)]
enum Silence {
    Slow,
    WithoutImpulse,
    Immovable,
}

/// Counts an impact for one of its bodies.
fn count(counts: &mut BodyContacts, outcome: &Result<ImpactPulse, Silence>, body: BodyId) {
    match outcome {
        Ok(pulse) => {
            counts.pulses += 1;
            if let Some(share) = pulse.bodies.iter().flatten().find(|share| share.body == body) {
                counts.shorter_than_transit += u64::from(share.transit_ratio < 1.0);
                counts.smallest_transit_ratio = counts.smallest_transit_ratio.min(share.transit_ratio);
            }
        }
        Err(Silence::Slow) => counts.slow += 1,
        Err(Silence::WithoutImpulse) => counts.without_impulse += 1,
        Err(Silence::Immovable) => {}
    }
}

/// Groups rows by impact, in order of each impact's first row.
pub(super) fn whole_impacts(rows: &[ContactRow]) -> Vec<Vec<ContactRow>> {
    let mut impacts: Vec<Vec<ContactRow>> = Vec::new();
    let mut place: BTreeMap<u64, usize> = BTreeMap::new();
    for row in rows {
        match (row.kind, row.impact_id) {
            (ContactKind::Fracture, _) => {}
            (ContactKind::Impact, 0) => impacts.push(vec![*row]),
            (_, 0) => {}
            (_, id) => {
                let index = *place.entry(id).or_insert_with(|| {
                    impacts.push(Vec::new());
                    impacts.len() - 1
                });
                impacts[index].push(*row);
            }
        }
    }
    impacts
}

/// Refuses rows of bodies that are unknown or not alive, and numbers that are not finite.
pub(super) fn check_row(bodies: &[Body], row: &ContactRow) -> Result<(), ContactError> {
    for id in [row.body_a, row.body_b].into_iter().filter(|id| *id != BodyId::WORLD) {
        check_body(bodies, id, "contact", row.time)?;
    }
    let vectors = [row.point, row.normal, row.impulse_t, row.couple, row.velocity];
    let finite = row.time.is_finite() && row.impulse_n.is_finite() && vectors.iter().all(|v| v.is_finite());
    if finite {
        Ok(())
    } else {
        Err(ContactError::NotFinite { what: "contact", body: row.body_a.0, time: row.time })
    }
}

/// Refuses bodies that are unknown, or not alive at a time \[s\].
pub(super) fn check_body(
    bodies: &[Body],
    id: BodyId,
    what: &'static str,
    time: f64,
) -> Result<(), ContactError> {
    let Some(body) = bodies.get(id.index()) else {
        return Err(ContactError::UnknownBody { what, body: id.0, bodies: bodies.len(), time });
    };
    let Life { birth, death, .. } = body.life;
    // A time that is not finite is refused as such.
    if body.life.holds(time) || !time.is_finite() {
        return Ok(());
    }
    Err(ContactError::NotAlive { what, body: id.0, time, birth, death })
}

/// The pulse of the rows of one impact, or why it is silent.
fn pulse(
    bodies: &[Body],
    rows: &[ContactRow],
    poses: &PoseHistory,
    settings: &ContactSettings,
) -> Result<Result<ImpactPulse, Silence>, ContactError> {
    let ids = [rows[0].body_a, rows[0].body_b];
    let pair = ids.map(|id| (id != BodyId::WORLD).then(|| &bodies[id.index()]));
    let time = rows.iter().map(|r| r.time).fold(f64::INFINITY, f64::min);
    let first_instant = rows.iter().filter(|r| r.time == time);
    let speed = first_instant.map(ContactRow::approach_speed).fold(0.0, f64::max);
    if pair.iter().flatten().all(|body| inverse_mass(body) == 0.0) {
        return Ok(Err(Silence::Immovable));
    }
    if speed < settings.v_min || speed == 0.0 {
        return Ok(Err(Silence::Slow));
    }
    let total: f64 = rows.iter().map(|r| r.impulse_n).sum();
    let normal = rows.iter().map(|r| r.normal * r.impulse_n).sum::<DVec3>().try_normalize();
    let Some(normal) = normal.filter(|_| total > 0.0) else {
        return Ok(Err(Silence::WithoutImpulse));
    };
    let weight = |row: &ContactRow| row.impulse_n / total;
    let point: DVec3 = rows.iter().map(|r| r.point * weight(r)).sum();

    let body_poses = [0, 1].map(|i| match pair[i] {
        Some(_) => poses.at(ids[i], time),
        None => Pose::IDENTITY,
    });
    let curvature_of = |i: usize| match pair[i] {
        Some(body) => rows
            .iter()
            .map(|r| weight(r) * mean_curvature(&body.surface, body_poses[i].body_from_world(r.point)))
            .sum(),
        None => 0.0,
    };
    let size = pair.iter().flatten().map(|body| body.surface.bounding_radius()).fold(f64::INFINITY, f64::min);
    let contact = HertzContact {
        inverse_mass: (0..2)
            .filter_map(|i| {
                pair[i].map(|body| body_inverse_effective_mass(body, &body_poses[i], point, normal))
            })
            .sum(),
        curvature: combined_curvature(
            [curvature_of(0), curvature_of(1)],
            pair.map(|body| body.map_or(0.0, |b| b.edge_radius)),
            size,
        ),
        compliance: pair.iter().flatten().map(|body| body.material.contact_compliance()).sum(),
        speed,
    };
    let duration = contact.duration();
    if !(duration > 0.0 && duration.is_finite()) {
        return Err(ContactError::NoDuration { body: ids[0].0, time, duration });
    }

    let share = |i: usize| {
        let body = pair[i].filter(|body| inverse_mass(body) > 0.0)?;
        Some(body_pulse(body, ids[i], body_poses[i], rows, if i == 0 { 1.0 } else { -1.0 }, duration))
    };
    let velocity_of = |i: usize| match pair[i] {
        Some(body) if inverse_mass(body) > 0.0 || matches!(body.motion, Motion::Keyframed(_)) => {
            poses.velocity_at(ids[i], point, time)
        }
        _ => Some(DVec3::ZERO),
    };
    Ok(Ok(ImpactPulse {
        impact_id: rows[0].impact_id,
        time,
        onset: time,
        duration,
        profile: settings.profile,
        speed,
        effective_mass: 1.0 / contact.inverse_mass,
        radius: 1.0 / contact.curvature,
        point,
        normal,
        velocity_before: velocity_of(0).zip(velocity_of(1)).map(|(a, b)| a - b),
        pair: ids,
        bodies: [share(0), share(1)],
        points: rows.iter().map(|r| (r.point, r.impulse())).collect(),
    }))
}

/// What the rows of an impact do to one body, which is A for a `sign` of 1 and B for −1.
pub(super) fn body_pulse(
    body: &Body,
    id: BodyId,
    pose: Pose,
    rows: &[ContactRow],
    sign: f64,
    duration: f64,
) -> BodyPulse {
    let impulse: DVec3 = rows.iter().map(|r| sign * r.impulse()).sum();
    let turn = |r: &ContactRow| sign * ((r.point - pose.position).cross(r.impulse()) + r.couple);
    let angular_impulse = rows.iter().map(turn).sum();
    BodyPulse {
        body: id,
        pose,
        impulse,
        velocity_change: impulse * inverse_mass(body),
        angular_impulse,
        angular_velocity_change: angular_velocity_change(body, &pose, angular_impulse),
        transit_ratio: duration * rayleigh_speed(&body.material) / (2.0 * body.surface.bounding_radius()),
    }
}

/// Speed of Rayleigh waves [m/s], Viktorov's approximation c_s (0.87 + 1.12 ν)/(1 + ν), good to 0.5 %.
fn rayleigh_speed(material: &Material) -> f64 {
    let nu = material.poisson_ratio;
    let shear = (0.5 * material.youngs_modulus / (material.density * (1.0 + nu))).sqrt();
    shear * (0.87 + 1.12 * nu) / (1.0 + nu)
}
