//! Checks of members, contacts and settings before an impact is solved.

use glam::DVec3;

use super::compliant_error::CompliantContactError;
use super::contact_law::{ContactLaw, HertzLaw};
use super::member::{Member, MemberContact, StepSettings};

/// Most contacts of one system: its matrices are dense, with up to three rows per contact.
pub const MAX_CONTACTS: usize = 64;

type Checked = Result<(), CompliantContactError>;

/// Checks everything that is summed or divided by.
pub(super) fn check(members: &[Member], contacts: &[MemberContact]) -> Checked {
    if contacts.is_empty() {
        return Err(CompliantContactError::NoContacts);
    }
    if contacts.len() > MAX_CONTACTS {
        return Err(CompliantContactError::TooManyContacts { count: contacts.len(), limit: MAX_CONTACTS });
    }
    for (index, member) in members.iter().enumerate() {
        check_member(index, member)?;
    }
    for (index, contact) in contacts.iter().enumerate() {
        check_pair(index, contact, members)?;
        check_contact(index, contact)?;
    }
    Ok(())
}

/// The component that is not finite, if any.
fn stray(vector: DVec3) -> Option<f64> {
    vector.to_array().into_iter().find(|x| !x.is_finite())
}

fn check_member(member: usize, body: &Member) -> Checked {
    let wrong = |what, value, wanted| Err(CompliantContactError::Member { member, what, value, wanted });
    if !(body.inverse_mass >= 0.0 && body.inverse_mass.is_finite()) {
        return wrong("inverse mass", body.inverse_mass, "finite and ≥ 0");
    }
    let inertia = body.inverse_inertia;
    if let Some(value) = inertia.to_cols_array().into_iter().find(|x| !x.is_finite()) {
        return wrong("inverse inertia", value, "finite");
    }
    let size = inertia.to_cols_array().into_iter().fold(0.0, |a: f64, b| a.max(b.abs()));
    let skew = inertia - inertia.transpose();
    if let Some(value) = skew.to_cols_array().into_iter().find(|x| x.abs() > 1e-9 * size) {
        return wrong("asymmetry of the inverse inertia", value, "0");
    }
    // Principal minors of every order, with room for rounding of a body without extent across an axis.
    let diagonal = [inertia.x_axis.x, inertia.y_axis.y, inertia.z_axis.z];
    let minors = [
        diagonal[0] * diagonal[1] - inertia.x_axis.y * inertia.y_axis.x,
        diagonal[1] * diagonal[2] - inertia.y_axis.z * inertia.z_axis.y,
        diagonal[0] * diagonal[2] - inertia.x_axis.z * inertia.z_axis.x,
    ];
    let least = |values: [f64; 3]| values.into_iter().fold(f64::INFINITY, f64::min);
    for (value, scale) in
        [(least(diagonal), size), (least(minors), size.powi(2)), (inertia.determinant(), size.powi(3))]
    {
        if value < -1e-9 * scale {
            return wrong("least minor of the inverse inertia", value, "≥ 0");
        }
    }
    let vectors = [
        ("centre", body.centre),
        ("velocity", body.velocity),
        ("angular velocity", body.angular_velocity),
        ("acceleration", body.acceleration),
    ];
    for (what, vector) in vectors {
        if let Some(value) = stray(vector) {
            return wrong(what, value, "finite");
        }
    }
    if body.inverse_mass == 0.0 && body.acceleration != DVec3::ZERO {
        return wrong("acceleration", body.acceleration.length(), "0 without an inverse mass");
    }
    check_modes(member, body)
}

fn check_modes(member: usize, body: &Member) -> Checked {
    for (mode, pole) in body.poles.iter().enumerate() {
        if !(pole.is_finite() && pole.re <= 0.0 && pole.im > 0.0) {
            return Err(CompliantContactError::Pole { member, mode, re: pole.re, im: pole.im });
        }
    }
    let (modes, count) = (body.poles.len(), body.state.len());
    if count != 0 && count != modes {
        return Err(CompliantContactError::Lengths { member, modes, count, what: "states" });
    }
    match body.state.iter().find(|w| !w.is_finite()) {
        Some(w) => Err(CompliantContactError::Member {
            member,
            what: "state of a mode",
            value: if w.re.is_finite() { w.im } else { w.re },
            wanted: "finite",
        }),
        None => Ok(()),
    }
}

/// Two different bodies, of which one can move, with a shape for each mode.
fn check_pair(contact: usize, pair: &MemberContact, members: &[Member]) -> Checked {
    if pair.members[0] == pair.members[1] {
        return Err(CompliantContactError::NotAPair { contact });
    }
    for (member, shapes) in pair.members.iter().zip(&pair.shapes) {
        let Some(member) = *member else {
            if let Some(shape) = shapes.first() {
                return Err(CompliantContactError::Contact {
                    contact,
                    what: "shape of an immovable body",
                    value: shape.x,
                    wanted: "absent",
                });
            }
            continue;
        };
        let Some(body) = members.get(member) else {
            return Err(CompliantContactError::UnknownMember { contact, member, members: members.len() });
        };
        let (modes, count) = (body.poles.len(), shapes.len());
        if count != 0 && count != modes {
            return Err(CompliantContactError::Lengths { member, modes, count, what: "shapes" });
        }
        if let Some(value) = shapes.iter().find_map(|shape| stray(*shape)) {
            let what = "shape of a mode";
            return Err(CompliantContactError::Contact { contact, what, value, wanted: "finite" });
        }
    }
    Ok(())
}

fn check_contact(contact: usize, pair: &MemberContact) -> Checked {
    let wrong = |what, value, wanted| Err(CompliantContactError::Contact { contact, what, value, wanted });
    for (what, vector) in [("point", pair.point), ("normal", pair.normal), ("velocity", pair.velocity)] {
        if let Some(value) = stray(vector) {
            return wrong(what, value, "finite");
        }
    }
    if (pair.normal.length() - 1.0).abs() > 1e-6 {
        return wrong("length of the normal", pair.normal.length(), "1");
    }
    if !pair.gap.is_finite() {
        return wrong("gap", pair.gap, "finite");
    }
    if !(pair.friction >= 0.0 && pair.friction.is_finite()) {
        return wrong("friction", pair.friction, "finite and ≥ 0");
    }
    let parts = match pair.law {
        ContactLaw::Hertz(law) => [
            ("restitution damping", law.restitution_damping),
            ("viscosity", law.viscosity),
            ("radiation", law.radiation),
            ("plate mobility", law.plate_mobility),
        ],
        ContactLaw::Spring { damping, .. } => [("damping", damping); 4],
    };
    for (what, value) in parts {
        if !(value >= 0.0 && value.is_finite()) {
            return wrong(what, value, "finite and ≥ 0");
        }
    }
    let (ContactLaw::Hertz(HertzLaw { stiffness, .. }) | ContactLaw::Spring { stiffness, .. }) = pair.law;
    if !(stiffness > 0.0 && stiffness.is_finite()) {
        return wrong("stiffness", stiffness, "finite and positive");
    }
    if matches!(pair.law, ContactLaw::Spring { .. }) && pair.friction != 0.0 {
        return wrong("friction of a spring", pair.friction, "0");
    }
    Ok(())
}

/// Checks the numbers of the settings.
pub(super) fn check_settings(settings: &StepSettings) -> Checked {
    let step = settings.step.unwrap_or(1.0);
    let limit = settings.max_steps as f64;
    let numbers = [("steps_per_duration", settings.steps_per_duration), ("step", step), ("max_steps", limit)];
    for (what, value) in numbers {
        if !(value > 0.0 && value.is_finite()) {
            return Err(CompliantContactError::Settings { what, value });
        }
    }
    let value = settings.return_durations;
    if !(value >= 0.0 && value.is_finite()) {
        return Err(CompliantContactError::Settings { what: "return_durations", value });
    }
    Ok(())
}
