//! Which source a body sounds as, and why.
//!
//! By default a sphere is a sphere; a body that nearly fills its convex hull and is small enough for the band
//! of the bank is played as an ellipsoid; everything else has a field of its own, which takes time to compute
//! once. The decision depends on the body, the rule, the bank and the band that is rendered, never on what
//! happens to be computed already. Whoever can compute fields may give one of their own to the few bodies
//! whose form takes no time ([`Reason::ExactForm`]).

use std::fmt;
use std::sync::Arc;

use glam::DQuat;

use super::field_source::FieldSource;
use super::source::SoundSource;
use crate::body::{Body, Motion, Surface};
use crate::sound_model::acceleration::model_evaluator::{BankEvaluator, ModelEvaluator};
use crate::sound_model::acceleration::proxy_field::ProxyFields;
use crate::sound_model::rule::AccelerationRule;
use crate::sound_model::soundbank::ellipsoid_bank::Proxy;

/// Part of its convex hull that a body must fill to be played as an ellipsoid.
pub const LEAST_FILLING: f64 = 0.9;

/// What is to sound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SourceKind {
    /// The sphere of equal volume.
    Sphere,
    /// This ellipsoid.
    Proxy(Proxy),
    /// A field of its own.
    Own,
}

/// Why.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reason {
    /// It cannot move, and makes no sound.
    Immovable,
    /// It is a sphere, whose field is known exactly.
    IsSphere,
    /// The scene says so.
    Asked,
    /// An ellipsoid does.
    SmallAndConvex {
        /// Part of its convex hull that it fills.
        filling: f64,
        /// Longest semi-axis times highest wavenumber.
        size: f64,
    },
    /// Its form is one of few that are computed at once.
    ExactForm {
        /// How many such forms there are.
        forms: usize,
    },
    /// It fills too little of its convex hull for an ellipsoid.
    Hollow {
        /// Part of its convex hull that it fills.
        filling: f64,
    },
    /// It is too large for the band of the bank.
    Large {
        /// Longest semi-axis times highest wavenumber.
        size: f64,
        /// Where the bank ends.
        limit: f64,
    },
    /// There is no bank, or no ellipsoid in it for this body.
    NoEllipsoid,
}

/// What a body is to sound as, and why.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decision {
    /// What.
    pub kind: SourceKind,
    /// Why.
    pub reason: Reason,
}

impl fmt::Display for SourceKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SourceKind::Sphere => f.write_str("sphere of equal volume"),
            SourceKind::Proxy(proxy) => {
                let axes = proxy.semi_axes;
                write!(
                    f,
                    "ellipsoid 1 : {:.2} : {:.2} of {:.3} mm",
                    axes.y / axes.x,
                    axes.z / axes.x,
                    1e3 * axes.x
                )
            }
            SourceKind::Own => f.write_str("field of its own"),
        }
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Reason::Immovable => f.write_str("it cannot move, and makes no sound"),
            Reason::IsSphere => f.write_str("it is a sphere"),
            Reason::Asked => f.write_str("as asked"),
            Reason::SmallAndConvex { filling, size } => {
                // The hull is measured with some of its points only.
                let percent = (100.0 * filling).min(100.0);
                write!(f, "it is small (kA = {size:.1}) and fills {percent:.0} % of its convex hull")
            }
            Reason::ExactForm { forms } => {
                write!(f, "its form is computed at once (one of {forms})")
            }
            Reason::Hollow { filling } => {
                write!(f, "it fills only {:.0} % of its convex hull", 100.0 * filling)
            }
            Reason::Large { size, limit } => {
                write!(f, "it is too large for the ellipsoids (kA = {size:.1} above {limit:.1})")
            }
            Reason::NoEllipsoid => f.write_str("no ellipsoid stands for it"),
        }
    }
}

impl fmt::Display for Decision {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.kind, self.reason)
    }
}

/// Decides what a body sounds as. `max_wavenumber` is k = 2πf/c [1/m] at the highest frequency that is
/// rendered in full.
pub fn decide(
    body: &Body,
    rule: AccelerationRule,
    bank: Option<&BankEvaluator>,
    max_wavenumber: f64,
) -> Decision {
    let decision = |kind, reason| Decision { kind, reason };
    if !matches!(body.motion, Motion::Free) || matches!(*body.surface, Surface::HalfSpace) {
        return decision(SourceKind::Sphere, Reason::Immovable);
    }
    if matches!(*body.surface, Surface::Sphere { .. }) {
        return decision(SourceKind::Sphere, Reason::IsSphere);
    }
    let proxy = || Some((proxy_of(body, bank?)?, bank?));
    match rule {
        AccelerationRule::Sphere => decision(SourceKind::Sphere, Reason::Asked),
        AccelerationRule::Own => decision(SourceKind::Own, Reason::Asked),
        AccelerationRule::Proxy | AccelerationRule::NearestProxy => match proxy() {
            Some((proxy, _)) => {
                let proxy = if rule == AccelerationRule::Proxy { proxy } else { proxy.of_nearest() };
                decision(SourceKind::Proxy(proxy), Reason::Asked)
            }
            None => decision(SourceKind::Sphere, Reason::NoEllipsoid),
        },
        AccelerationRule::Auto => {
            let Some((proxy, bank)) = proxy() else {
                return decision(SourceKind::Own, Reason::NoEllipsoid);
            };
            let (size, limit) = (proxy.radius * max_wavenumber, bank.field(&proxy).max_wavenumber);
            if size > limit {
                return decision(SourceKind::Own, Reason::Large { size, limit });
            }
            let filling = body.surface.hull_filling();
            if filling < LEAST_FILLING {
                return decision(SourceKind::Own, Reason::Hollow { filling });
            }
            decision(SourceKind::Proxy(proxy), Reason::SmallAndConvex { filling, size })
        }
    }
}

/// The ellipsoid of a bank that stands for a body.
fn proxy_of(body: &Body, bank: &BankEvaluator) -> Option<Proxy> {
    let Surface::Mesh(mesh) = &*body.surface else { return None };
    let density = body.mass / mesh.volume;
    bank.bank().proxy_for(body.inertia * (1.0 / density), mesh.volume)
}

/// The source of a body: what was decided, or the next best, if it is to have a field of its own and `own` is
/// not there: the ellipsoid, else the sphere. Says which.
pub fn source_of(
    body: &Body,
    decision: &Decision,
    proxies: Option<&mut ProxyFields<'_>>,
    own: Option<&ModelEvaluator>,
) -> (SoundSource, SourceKind) {
    let surface = &body.surface;
    if let (SourceKind::Own, Some(ModelEvaluator { radius, field, near })) = (decision.kind, own) {
        let (field, near) = (Arc::clone(field), near.clone());
        let source = FieldSource::new(field, near, *radius, DQuat::IDENTITY, Arc::clone(surface));
        return (SoundSource::Field(Arc::new(source)), SourceKind::Own);
    }
    let ellipsoid = proxies.and_then(|proxies| {
        let proxy = match decision.kind {
            SourceKind::Sphere => return None,
            SourceKind::Proxy(proxy) => proxy,
            SourceKind::Own => proxy_of(body, proxies.bank())?,
        };
        let frame = DQuat::from_mat3(&proxy.rotation);
        let source = FieldSource::new(proxies.field(&proxy), None, proxy.radius, frame, Arc::clone(surface));
        Some((SoundSource::Field(Arc::new(source)), SourceKind::Proxy(proxy)))
    });
    ellipsoid.unwrap_or_else(|| (SoundSource::equal_volume_sphere(surface), SourceKind::Sphere))
}
