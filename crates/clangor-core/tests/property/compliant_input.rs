//! Bad input of an impact gives a located error or a bounded result.

use crate::compliant_bodies::{ball, contact, hertz};
use clangor_core::contact::compliant::{
    CompliantContactError as Error, ContactEnd, ContactLaw, ContactSystem, MAX_CONTACTS, Member,
    MemberContact, SolverMemory, StepSettings,
};
use clangor_core::glam::{DMat3, DVec3};
use num_complex::Complex64;

const POLE: Complex64 = Complex64::new(-10.0, 5e3);

/// Two balls, the second with one mode.
fn pair() -> (Vec<Member>, Vec<MemberContact>) {
    let mut members = vec![ball(0.01, 0.01 * DVec3::Y, -DVec3::Y), ball(0.01, -0.01 * DVec3::Y, DVec3::ZERO)];
    members[1].poles = vec![POLE];
    let mut hit = contact([Some(0), Some(1)], DVec3::ZERO, DVec3::Y, hertz(3e9));
    hit.shapes[1] = vec![DVec3::Y];
    (members, vec![hit])
}

fn error(change: impl Fn(&mut Vec<Member>, &mut Vec<MemberContact>)) -> Error {
    let (mut members, mut contacts) = pair();
    change(&mut members, &mut contacts);
    ContactSystem::new(&members, &contacts).expect_err("bad input")
}

fn solve(
    members: &[Member],
    contacts: &[MemberContact],
    settings: &StepSettings,
) -> Result<ContactEnd, Error> {
    let system = ContactSystem::new(members, contacts)?;
    let mut memory = SolverMemory::default();
    let solution = system.solve(settings, &mut memory)?;
    assert!(solution.velocities.iter().chain(&solution.angular_velocities).all(|v| v.is_finite()));
    let residual = if settings.modal_loss { solution.energies.residual().abs() } else { 0.0 };
    let size = solution.energies.motion_lost.abs() + solution.energies.stored_gained.abs();
    assert!(residual <= 1e-10 * size, "{residual} of {size} J");
    Ok(solution.end)
}

#[test]
fn numbers_out_of_range_are_named() {
    type Change = fn(&mut Vec<Member>, &mut Vec<MemberContact>);
    let members: [(&str, Change); 9] = [
        ("inverse mass", |m, _| m[1].inverse_mass = -1.0),
        ("inverse mass", |m, _| m[1].inverse_mass = f64::INFINITY),
        ("inverse inertia", |m, _| m[1].inverse_inertia.x_axis.y = f64::NAN),
        ("asymmetry of the inverse inertia", |m, _| m[1].inverse_inertia.x_axis.y = 1e9),
        ("least minor of the inverse inertia", |m, _| m[1].inverse_inertia = -DMat3::IDENTITY),
        ("velocity", |m, _| m[1].velocity.z = f64::NAN),
        ("centre", |m, _| m[1].centre.z = f64::INFINITY),
        ("acceleration", |m, _| (m[1].inverse_mass, m[1].acceleration) = (0.0, DVec3::Y)),
        ("state of a mode", |m, _| m[1].state = vec![Complex64::new(0.0, f64::NAN)]),
    ];
    for (name, change) in members {
        let found = error(change);
        assert!(matches!(found, Error::Member { member: 1, what, .. } if what == name), "{name}: {found}");
    }
    let contacts: [(&str, Change); 9] = [
        ("normal", |_, c| c[0].normal.x = f64::NAN),
        ("length of the normal", |_, c| c[0].normal = DVec3::ZERO),
        ("gap", |_, c| c[0].gap = f64::NAN),
        ("friction", |_, c| c[0].friction = -0.1),
        ("stiffness", |_, c| c[0].law = ContactLaw::Hertz(hertz(0.0))),
        ("damping", |_, c| c[0].law = ContactLaw::Spring { stiffness: 1.0, damping: -1.0 }),
        ("friction of a spring", |_, c| {
            c[0].law = ContactLaw::Spring { stiffness: 1.0, damping: 0.0 };
            c[0].friction = 0.1;
        }),
        ("shape of a mode", |_, c| c[0].shapes[1][0].x = f64::NAN),
        ("inverse mass behind the contact", |m, c| {
            c[0].shapes[1].clear();
            for member in m {
                (member.inverse_mass, member.inverse_inertia) = (0.0, DMat3::ZERO);
            }
        }),
    ];
    for (name, change) in contacts {
        let found = error(change);
        assert!(matches!(found, Error::Contact { contact: 0, what, .. } if what == name), "{name}: {found}");
    }
    for pole in [Complex64::new(1.0, 5e3), Complex64::new(-10.0, 0.0), Complex64::new(f64::NAN, 5e3)] {
        let (mut members, contacts) = pair();
        members[1].poles[0] = pole;
        let found = ContactSystem::new(&members, &contacts).expect_err("bad pole");
        assert!(matches!(found, Error::Pole { member: 1, mode: 0, .. }), "{found}");
    }
}

#[test]
fn members_and_lengths_must_fit() {
    assert_eq!(
        error(|_, c| c[0].members[0] = Some(7)),
        Error::UnknownMember { contact: 0, member: 7, members: 2 }
    );
    assert_eq!(error(|_, c| c[0].members = [Some(1); 2]), Error::NotAPair { contact: 0 });
    assert_eq!(error(|_, c| c[0].members = [None; 2]), Error::NotAPair { contact: 0 });
    assert_eq!(error(|_, c| c.clear()), Error::NoContacts);
    let lengths = |what| Error::Lengths { member: 1, modes: 1, count: 2, what };
    assert_eq!(error(|_, c| c[0].shapes[1].push(DVec3::Y)), lengths("shapes"));
    assert_eq!(error(|m, _| m[1].state = vec![POLE; 2]), lengths("states"));
    assert_eq!(
        error(|_, c| *c = vec![c[0].clone(); 10_000]),
        Error::TooManyContacts { count: 10_000, limit: MAX_CONTACTS }
    );
}

#[test]
fn settings_must_be_positive() {
    let (members, contacts) = pair();
    let with = |change: fn(&mut StepSettings)| {
        let mut settings = StepSettings::default();
        change(&mut settings);
        solve(&members, &contacts, &settings).expect_err("bad setting")
    };
    assert!(matches!(with(|s| s.steps_per_duration = 0.0), Error::Settings { .. }));
    assert!(matches!(with(|s| s.step = Some(f64::NAN)), Error::Settings { what: "step", .. }));
    assert!(matches!(with(|s| s.max_steps = 0), Error::Settings { .. }));
    assert!(matches!(with(|s| s.return_durations = -1.0), Error::Settings { .. }));
    let (mut apart, contacts) = pair();
    apart[0].velocity = DVec3::Y;
    assert_eq!(solve(&apart, &contacts, &StepSettings::default()), Err(Error::NoDuration));
    let settings = StepSettings { step: Some(1e-6), ..StepSettings::default() };
    assert_eq!(solve(&apart, &contacts, &settings), Ok(ContactEnd::Parted));
    // Forces beyond what numbers hold.
    let (mut members, contacts) = pair();
    members[0].velocity.y = -1e300;
    let found = solve(&members, &contacts, &StepSettings::default());
    assert!(matches!(found, Err(Error::NotFinite { .. } | Error::NoDuration)), "{found:?}");
}

#[test]
fn odd_but_possible_input_gives_a_bounded_result() {
    let settings = StepSettings { max_steps: 20_000, modal_loss: true, ..StepSettings::default() };
    // Equal bodies in one place: the energy of the overlap drives them apart.
    let (mut members, mut contacts) = pair();
    members[1].centre = members[0].centre;
    contacts[0].gap = -0.02;
    assert_eq!(solve(&members, &contacts, &settings), Ok(ContactEnd::Parted));
    // The same contact many times over, with friction.
    let (members, mut contacts) = pair();
    contacts[0].friction = 0.5;
    let many = vec![contacts[0].clone(); MAX_CONTACTS];
    assert_eq!(solve(&members, &many, &settings), Ok(ContactEnd::Parted));
    // Modes without a mass that moves, and friction against them.
    let (mut members, mut contacts) = pair();
    (members[1].inverse_mass, members[1].inverse_inertia) = (0.0, DMat3::ZERO);
    contacts[0].friction = 0.5;
    assert_eq!(solve(&members, &contacts, &settings), Ok(ContactEnd::Parted));
    // A shape as large as numbers of that kind go, and none at all.
    for size in [0.0, 1e6] {
        let (members, mut contacts) = pair();
        contacts[0].shapes[1][0] = size * DVec3::Y;
        assert!(solve(&members, &contacts, &settings).is_ok());
    }
}
