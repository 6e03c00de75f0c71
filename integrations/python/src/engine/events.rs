//! Arguments of Python as events of the real-time engine.

use std::sync::Arc;

use clangor::contact::ForceHistory;
use clangor::glam::DVec3;
use clangor::material::Material;
use clangor::pose::Pose;
use clangor::realtime::event::{DURATIONS, RADII};
use clangor::realtime::{ImpactEvent, ImpactTarget};
use clangor::session::{DEFAULT_IMPULSE, Meeting, Partner};
use clangor::synthesis::strike::StrikeForce;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::Held;
use super::numbers::{number, optional_point, point, rotation};
use crate::errors::raised;
use crate::settings::{MaterialOrName, check_keywords, keyword, named, striker};

const IMPACT_KEYWORDS: &[&str] = &[
    "slot",
    "radius",
    "duration",
    "time",
    "position",
    "orientation",
    "velocity_change",
    "angular_velocity_change",
    "point",
    "impulse",
    "force",
];

/// A strike: its force and its point, in the axes of the body.
pub(crate) struct StrikeCall {
    force: StrikeForce,
    point: Option<DVec3>,
}

impl StrikeCall {
    pub(crate) fn of(options: &Bound<'_, PyDict>) -> PyResult<Self> {
        check_keywords(options, &["impulse", "striker", "point", "time"])?;
        let impulse = optional_point(options, "impulse")?;
        let ball: Option<(MaterialOrName, f64, f64)> = keyword(options, "striker")?;
        let force = match (impulse, ball) {
            (Some(_), Some(_)) => return Err(PyValueError::new_err("give either `impulse` or `striker`")),
            (_, Some(ball)) => StrikeForce::Striker(striker(&ball)?),
            (impulse, None) => {
                StrikeForce::Impulse { impulse: impulse.unwrap_or(DEFAULT_IMPULSE), duration: None }
            }
        };
        Ok(StrikeCall { force, point: optional_point(options, "point")? })
    }

    pub(crate) fn events(self, slot: usize, held: &Held) -> PyResult<Vec<ImpactEvent>> {
        held.live.strike(slot, self.force, self.point, &held.pose).map_err(raised)
    }
}

/// Where and how fast two bodies meet.
pub(crate) struct Collision(Meeting);

impl Collision {
    pub(crate) fn of(options: &Bound<'_, PyDict>) -> PyResult<Self> {
        check_keywords(options, &["point", "normal", "speed", "time"])?;
        let needed = |name: &str| optional_point(options, name)?.ok_or_else(|| missing(name));
        let (point, normal) = (needed("point")?, needed("normal")?);
        let speed = number(options, "speed")?.ok_or_else(|| missing("speed"))?;
        let Some(unit) = normal.try_normalize() else {
            return Err(PyValueError::new_err(format!(
                "normal is {:?}; it has no direction",
                normal.to_array()
            )));
        };
        if speed <= 0.0 {
            return Err(PyValueError::new_err(format!("speed is {speed} m/s; it must be positive")));
        }
        Ok(Collision(Meeting { point, normal: unit, speed }))
    }

    /// The events of the meeting of the body in a slot with what it meets.
    pub(crate) fn events(&self, (slot, held): (usize, &Held), met: &Met) -> PyResult<Vec<ImpactEvent>> {
        let partner = match met {
            Met::Body(slot, other) => Partner::Body(&other.live, *slot, other.pose),
            Met::Ground(material) => Partner::Ground(material),
        };
        held.live.meet((slot, held.pose), partner, &self.0).map_err(raised)
    }
}

/// What a body meets.
#[allow(clippy::large_enum_variant, reason = "one per call, never in lists")]
pub(crate) enum Met {
    /// The body in another slot.
    Body(usize, Held),
    /// Flat ground that does not move.
    Ground(Material),
}

impl Met {
    /// The ground of a material.
    pub(crate) fn ground(partner: &Bound<'_, PyAny>) -> PyResult<Self> {
        let material: MaterialOrName = partner.extract().map_err(|error| named("partner", error))?;
        Ok(Met::Ground(material.material()?))
    }
}

/// Motion of a body from a time on.
pub(crate) struct Motion {
    pub(crate) pose: Pose,
    pub(crate) velocity: DVec3,
    pub(crate) angular_velocity: DVec3,
}

impl Motion {
    pub(crate) fn of(position: &Bound<'_, PyAny>, options: &Bound<'_, PyDict>) -> PyResult<Self> {
        check_keywords(options, &["orientation", "velocity", "angular_velocity", "time"])?;
        let orientation = rotation(options, "orientation")?.unwrap_or_default();
        let vector = |name| Ok::<_, PyErr>(optional_point(options, name)?.unwrap_or_default());
        Ok(Motion {
            pose: Pose { position: point("position", position)?, orientation },
            velocity: vector("velocity")?,
            angular_velocity: vector("angular_velocity")?,
        })
    }
}

/// A pose out of `position` and `orientation`; what is not given is that of `otherwise`.
pub(crate) fn pose(options: &Bound<'_, PyDict>, otherwise: Pose) -> PyResult<Pose> {
    Ok(Pose {
        position: optional_point(options, "position")?.unwrap_or(otherwise.position),
        orientation: rotation(options, "orientation")?.unwrap_or(otherwise.orientation),
    })
}

/// The body of an impact: that in a slot, or a sphere.
pub(crate) fn target(options: &Bound<'_, PyDict>) -> PyResult<ImpactTarget> {
    check_keywords(options, IMPACT_KEYWORDS)?;
    match (keyword(options, "slot")?, number(options, "radius")?) {
        (Some(slot), None) => Ok(ImpactTarget::Object { slot }),
        (None, Some(radius)) => Ok(ImpactTarget::Sphere { radius: within("radius", radius, &RADII, "m")? }),
        _ => Err(PyValueError::new_err("give either `slot` or `radius`")),
    }
}

/// An impact at time 0; a body in a slot is where it was said to be last, unless told otherwise.
pub(crate) fn impact(options: &Bound<'_, PyDict>, target: ImpactTarget, last: Pose) -> PyResult<ImpactEvent> {
    let duration = number(options, "duration")?.ok_or_else(|| missing("duration"))?;
    let duration = within("duration", duration, &DURATIONS, "s")?;
    let pose = pose(options, last)?;
    let vector = |name| Ok::<_, PyErr>(optional_point(options, name)?.unwrap_or_default());
    let event = ImpactEvent::new(target, 0.0, duration)
        .with_pose(pose)
        .with_velocity_changes(vector("velocity_change")?, vector("angular_velocity_change")?)
        .with_impulse(optional_point(options, "point")?.unwrap_or(pose.position), vector("impulse")?);
    Ok(ImpactEvent { force: force(options)?, ..event })
}

/// A force over time: its first time [s], the step [s] and samples [1/s], of which the area is 1.
fn force(options: &Bound<'_, PyDict>) -> PyResult<Option<Arc<ForceHistory>>> {
    let Some((start, step, samples)): Option<(f64, f64, Vec<f64>)> = keyword(options, "force")? else {
        return Ok(None);
    };
    let count = samples.len();
    let lasts = (step * count as f64).abs();
    match ForceHistory::restored(start, step, samples) {
        Some(history) if start.abs() < DURATIONS.end && DURATIONS.contains(&lasts) => {
            Ok(Some(Arc::new(history)))
        }
        _ => Err(PyValueError::new_err(format!(
            "force: {count} samples from {start} s on, {step} s apart; it needs finite numbers, a positive \
             step, a positive area, and less than {} s",
            DURATIONS.end
        ))),
    }
}

fn within(name: &str, value: f64, range: &std::ops::Range<f64>, unit: &str) -> PyResult<f64> {
    match range.contains(&value) {
        true => Ok(value),
        false => {
            let (least, most) = (range.start, range.end);
            let message = format!("{name} is {value} {unit}; it can be {least:e} to {most:e} {unit}");
            Err(PyValueError::new_err(message))
        }
    }
}

fn missing(name: &str) -> PyErr {
    PyTypeError::new_err(format!("{name} is missing"))
}
