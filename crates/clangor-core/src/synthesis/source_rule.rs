//! Choice of the source of a body, with the reason.
//!
//! By default a sphere radiates as a sphere. A body that nearly fills its convex hull and is small enough for
//! the band of the bank radiates as an ellipsoid. All other bodies need a field of their own, which is
//! computed once. The decision depends on the body, the rule, the bank and the rendered band, never on which
//! fields have been computed already. A caller that can compute fields may give their own fields to bodies of
//! the few forms that take no time ([`Reason::ExactForm`]).

use std::fmt;
use std::sync::Arc;

use glam::DQuat;

use super::field_source::FieldSource;
use super::source::SoundSource;
use crate::body::{Body, OFF_CENTRE, Surface};
use crate::sound_model::acceleration::model_evaluator::{BankEvaluator, ModelEvaluator};
use crate::sound_model::acceleration::proxy_field::ProxyFields;
use crate::sound_model::rule::AccelerationRule;
use crate::sound_model::soundbank::ellipsoid_bank::Proxy;

/// Least fraction of its convex hull that a body must fill to be represented by an ellipsoid.
pub const LEAST_FILLING: f64 = 0.9;

/// Source chosen for a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SourceKind {
    /// The sphere of equal volume.
    Sphere,
    /// This ellipsoid.
    Proxy(Proxy),
    /// A field of its own.
    Own,
}

/// Reason for a choice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reason {
    /// It cannot move, and radiates nothing.
    Immovable,
    /// It is a sphere, whose field has a closed form.
    IsSphere,
    /// The scene demands it.
    Asked,
    /// An ellipsoid is accurate enough.
    SmallAndConvex {
        /// Fraction of its convex hull that it fills \[-\].
        filling: f64,
        /// Longest semi-axis times highest wavenumber \[-\].
        size: f64,
    },
    /// Its form is one of the few that are computed at once.
    ExactForm {
        /// Number of such forms.
        forms: usize,
    },
    /// It fills too little of its convex hull for an ellipsoid.
    Hollow {
        /// Fraction of its convex hull that it fills \[-\].
        filling: f64,
    },
    /// It is too large for the band of the bank.
    Large {
        /// Longest semi-axis times highest wavenumber \[-\].
        size: f64,
        /// Largest such product in the bank.
        limit: f64,
    },
    /// Its centre of mass is not that of its form, about which an ellipsoid turns.
    OffCentre {
        /// Distance of the two, over the bounding radius \[-\].
        share: f64,
    },
    /// There is no bank, or no ellipsoid in it for this body.
    NoEllipsoid,
}

/// The choice of a source for a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decision {
    /// The source.
    pub kind: SourceKind,
    /// The reason.
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
                // The hull is estimated from some of its points only.
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
            Reason::OffCentre { share } => {
                write!(f, "its centre of mass is {:.0} % of its radius off that of its form", 100.0 * share)
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

/// Chooses the source of a body. `max_wavenumber` is k = 2πf/c [1/m] at the highest frequency rendered in
/// full.
pub fn decide(
    body: &Body,
    rule: AccelerationRule,
    bank: Option<&BankEvaluator>,
    max_wavenumber: f64,
) -> Decision {
    let decision = |kind, reason| Decision { kind, reason };
    if !body.motion.is_movable() || body.surface.is_plane() {
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
            let centre = body.form_of_uneven().map_or(0.0, |form| form.centre_of_mass.length());
            let share = centre / body.surface.bounding_radius();
            if share > OFF_CENTRE {
                return decision(SourceKind::Own, Reason::OffCentre { share });
            }
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

/// The ellipsoid of a bank that represents a body.
fn proxy_of(body: &Body, bank: &BankEvaluator) -> Option<Proxy> {
    let Surface::Mesh(mesh) = &*body.surface else { return None };
    if let Some(form) = body.form_of_uneven() {
        return bank.bank().proxy_for(form.inertia, form.volume);
    }
    let density = body.mass / mesh.volume;
    bank.bank().proxy_for(body.inertia * (1.0 / density), mesh.volume)
}

/// The source of a body and the kind that it is. If a field of its own was chosen and `own` is missing, the
/// next best is used: the ellipsoid, else the sphere.
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
