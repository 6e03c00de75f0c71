//! Impulses that are recovered, and those that are not believed.

use super::*;

fn ball(inverse_mass: f64, centre: DVec3) -> FitBody {
    let inverse_inertia = DMat3::from_diagonal(DVec3::splat(inverse_mass / (0.4 * 0.01 * 0.01)));
    FitBody { inverse_mass, inverse_inertia, centre, velocity: DVec3::ZERO, angular_velocity: DVec3::ZERO }
}

#[test]
fn impulses_at_two_points_of_two_bodies_are_recovered_from_their_jumps() {
    let mut bodies =
        [ball(4.0, DVec3::Y * 0.01), ball(2.0, DVec3::new(0.02, 0.01, 0.0)), ball(0.0, DVec3::ZERO)];
    bodies[2].inverse_inertia = DMat3::ZERO;
    let contact = |a, b, point, normal| FitContact { bodies: [a, b], point, normal, friction: 0.5 };
    let contacts =
        [contact(0, 2, DVec3::ZERO, DVec3::Y), contact(0, 1, DVec3::new(0.01, 0.01, 0.0), DVec3::NEG_X)];
    let impulses = [DVec3::new(0.03, 0.2, -0.05), DVec3::new(-0.4, 0.1, 0.02)];
    for (contact, impulse) in contacts.iter().zip(impulses) {
        for (i, sign) in [(0, 1.0), (1, -1.0)] {
            let body = &mut bodies[contact.bodies[i]];
            body.velocity += impulse * (sign * body.inverse_mass);
            body.angular_velocity +=
                body.inverse_inertia * (contact.point - body.centre).cross(impulse) * sign;
        }
    }
    let fit = fit_impulses(&bodies, &contacts);
    // Seen: 8e-8 N s, and 1e-14 of the energy unexplained.
    for (found, true_impulse) in fit.impulses.iter().zip(impulses) {
        assert!((*found - true_impulse).length() < 1e-6, "{found} for {true_impulse}");
    }
    assert!(fit.residual < 1e-9, "{}", fit.residual);
}

#[test]
fn a_surface_cannot_pull() {
    let mut bodies =
        [ball(1.0, DVec3::Y * 0.01), FitBody { inverse_inertia: DMat3::ZERO, ..ball(0.0, DVec3::ZERO) }];
    bodies[0].velocity = DVec3::NEG_Y;
    let contact = FitContact { bodies: [0, 1], point: DVec3::ZERO, normal: DVec3::Y, friction: 0.3 };
    let fit = fit_impulses(&bodies, &[contact]);
    assert_eq!(fit.impulses, [DVec3::ZERO]);
    assert_eq!(fit.residual, 1.0);
}

/// A body lands, and turns by a little that no contact explains but a squeeze of 16 N s between the floor and
/// a ceiling, 2 mm beside each other.
#[test]
fn what_only_a_squeeze_explains_stays_unexplained() {
    let mut bodies = [ball(1.0, DVec3::ZERO), FitBody::IMMOVABLE, FitBody::IMMOVABLE];
    bodies[0].inverse_inertia = DMat3::from_diagonal(DVec3::splat(100.0));
    (bodies[0].velocity, bodies[0].angular_velocity) = (DVec3::Y, DVec3::Z * 3.2);
    let contact = |other, point, normal| FitContact { bodies: [0, other], point, normal, friction: 0.0 };
    let floor = contact(1, DVec3::new(0.001, -0.1, 0.0), DVec3::Y);
    let ceiling = contact(2, DVec3::new(-0.001, 0.1, 0.0), DVec3::NEG_Y);
    let fit = fit_impulses(&bodies, &[floor, ceiling]);
    // Seen: 1.6e-3 N s off, and nothing from the ceiling.
    assert!(fit.impulses[0].distance(DVec3::Y) < 0.05, "{fit:?}");
    assert!(fit.impulses[1].length() < 0.05, "{fit:?}");
}
