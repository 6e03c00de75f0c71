//! The strikes of the page: impulse, duration, momentum and energy of an impact by closed forms, and
//! messages instead of an impact for bad numbers.

mod struck_objects;

use std::f64::consts::{PI, TAU};

use clangor_core::contact::force_shape::ForceShape;
use clangor_core::contact::hertz::HertzContact;
use clangor_core::glam::DVec3;
use clangor_core::material::{Material, PairCoefficients, presets};
use clangor_core::realtime::event_row::{DecodedRow, ROW, RowDecoder};
use clangor_core::realtime::{Event, ImpactEvent, ImpactTarget};
use clangor_web::layout::{CONTACT_FIELDS, CONTACT_STRIDE};
use clangor_web::strike::{STRIKE_NUMBERS, strike_impact, strike_load, strike_materials, with_impact};
use clangor_web::wasm_buffer::{last_message, write};
use struck_objects::{FREQUENCIES, SIZE, ball, cube, write_numbers};

/// Slot of the struck object.
const SLOT: u32 = 3;
/// Radius \[m\] and speed [m/s] of the mallet.
const MALLET: [f64; 2] = [0.01, 0.7];
/// Centre of mass of the object \[m\].
const CENTRE: DVec3 = DVec3::new(0.3, -0.2, 1.5);

fn load(bytes: &[u8]) {
    assert_eq!(strike_load(SLOT, write(bytes)), 0, "{}", last_message());
}

fn index_of(material: &str) -> u32 {
    let count = strike_materials();
    let names: Vec<String> = serde_json::from_str(&last_message()).unwrap();
    assert_eq!(names.len() as i32, count);
    names.iter().position(|name| name == material).unwrap() as u32
}

fn numbers(point: DVec3) -> [f64; STRIKE_NUMBERS] {
    let [radius, speed] = MALLET;
    [radius, speed, CENTRE.x, CENTRE.y, CENTRE.z, point.x, point.y, point.z]
}

/// Hits the object at a point from its centre: events of the object and the mallet, contact.
fn hit(material: &str, from_centre: DVec3) -> (ImpactEvent, ImpactEvent, [f64; CONTACT_STRIDE]) {
    let index = index_of(material);
    write_numbers(&numbers(CENTRE + from_centre));
    assert!(strike_impact(SLOT, index) >= 2, "{}", last_message());
    with_impact(|rows, contact| {
        let mut decoder = RowDecoder::default();
        let event = |row: &[f64; ROW]| match decoder.decode(row) {
            DecodedRow::Event(Event::Impact(event)) => Some(event),
            DecodedRow::ForceHistory => None,
            _ => panic!("{row:?} is no impact"),
        };
        let events: Vec<ImpactEvent> = rows.as_chunks::<ROW>().0.iter().filter_map(event).collect();
        let [object, mallet] = &events[..] else { panic!("{} events", events.len()) };
        // Both have the same force over time.
        assert_eq!((&object.force, decoder.missing), (&mallet.force, 0));
        (object.clone(), mallet.clone(), contact.try_into().unwrap())
    })
}

fn field(contact: &[f64; CONTACT_STRIDE], name: &str) -> f64 {
    contact[CONTACT_FIELDS.iter().find(|(field, ..)| *field == name).unwrap().1]
}

/// Residual seen: 4e-15.
fn near(value: f64, expected: f64) {
    assert!((value / expected - 1.0).abs() < 1e-12, "{value:e} for {expected:e}");
}

/// Residual seen: 8e-15, of an angular velocity.
fn near_vector(value: DVec3, expected: DVec3) {
    assert!(value.distance(expected) < 1e-12 * expected.length(), "{value} for {expected}");
}

fn ball_mass(material: &Material, radius: f64) -> f64 {
    material.density * 4.0 / 3.0 * PI * radius.powi(3)
}

#[test]
fn a_ball_is_hit_by_the_formulas_of_newton_and_hertz() {
    load(&ball("ceramic", 0.5));
    for (mallet, place) in [("wood", DVec3::Y), ("steel", DVec3::new(0.6, 0.0, -0.8)), ("rubber", -DVec3::X)]
    {
        let (struck, striker, contact) = hit(mallet, SIZE * place);
        let [a, b] = ["ceramic", mallet].map(|name| presets::preset(name).unwrap());
        let [radius, speed] = MALLET;
        let [mass, striker_mass] = [ball_mass(&a, SIZE), ball_mass(&b, radius)];
        let effective = 1.0 / (1.0 / mass + 1.0 / striker_mass);
        let impulse = (1.0 + PairCoefficients::of(&a, &b).restitution.at(speed)) * effective * speed;
        let compliance = |m: &Material| (1.0 - m.poisson_ratio.powi(2)) / m.youngs_modulus;
        let hertz = HertzContact {
            inverse_mass: 1.0 / effective,
            relative_radii: [1.0 / (1.0 / SIZE + 1.0 / radius); 2],
            compliance: compliance(&a) + compliance(&b),
            speed,
        };
        println!("{mallet}: {impulse:.3e} N s in {:.3e} s", hertz.duration());

        assert_eq!(struck.target, ImpactTarget::Object { slot: SLOT as usize });
        assert_eq!(striker.target, ImpactTarget::Sphere { radius });
        near_vector(struck.impulse, -impulse * place);
        near_vector(struck.velocity_change, -impulse / mass * place);
        near_vector(striker.velocity_change, impulse / striker_mass * place);
        near_vector(striker.pose.position, CENTRE + (SIZE + radius) * place);
        near_vector(struck.pose.position, CENTRE);
        for event in [&struck, &striker] {
            near(event.duration, hertz.duration());
            near_vector(event.point, CENTRE + SIZE * place);
            assert_eq!((event.time, event.angular_velocity_change.length() < 1e-12), (0.0, true));
        }
        for (name, value) in [
            ("speed", speed),
            ("impulse", impulse),
            ("duration", hertz.duration()),
            ("mass", effective),
            ("bodyA", f64::from(SLOT)),
            ("bodyB", -1.0),
        ] {
            near(field(&contact, name), value);
        }
    }
}

#[test]
fn a_cube_that_is_hit_off_its_centre_turns_and_momentum_is_kept() {
    load(&cube("ceramic", 0.5));
    let arm = DVec3::new(0.012, SIZE, 0.005);
    let (struck, striker, contact) = hit("wood", arm);
    let [ceramic, wood] = ["ceramic", "wood"].map(|name| presets::preset(name).unwrap());
    let mass = ceramic.density * (2.0 * SIZE).powi(3);
    let inertia = mass * (2.0 * SIZE).powi(2) / 6.0;
    let striker_mass = ball_mass(&wood, MALLET[0]);
    // (r × n)² / I of the normal −y.
    let turn = (arm.x.powi(2) + arm.z.powi(2)) / inertia;
    let effective = 1.0 / (1.0 / mass + turn + 1.0 / striker_mass);
    let restitution = PairCoefficients::of(&ceramic, &wood).restitution.at(MALLET[1]);
    let impulse = (1.0 + restitution) * effective * MALLET[1] * -DVec3::Y;
    near(field(&contact, "mass"), effective);
    near_vector(struck.impulse, impulse);
    near_vector(mass * struck.velocity_change, impulse);
    near_vector(striker_mass * striker.velocity_change, -mass * struck.velocity_change);
    near_vector(struck.angular_velocity_change, arm.cross(impulse) / inertia);
    // The points separate at e V.
    let at_point = struck.velocity_change + struck.angular_velocity_change.cross(arm);
    near((striker.velocity_change - at_point).y - MALLET[1], restitution * MALLET[1]);
}

/// A solved force J_s leaves the modes at most what the motion loses, J_s V − J_s²/2m. Scaled by J/J_s to the
/// impulse J = (1 + e) m V, with J_s ≥ J/2 as on 6 dB, that is at most (1 + e)(3 − e) ½ m V².
#[test]
fn modes_get_no_more_than_the_motion_of_the_solved_impact_loses() {
    let mut largest = 0.0_f64;
    for motion in [0.5, 4.0, 16.0, 64.0, 256.0] {
        load(&ball("ceramic", motion));
        let (struck, _, contact) = hit("wood", SIZE * DVec3::Y);
        let shape = struck.force.clone().map_or_else(ForceShape::default, ForceShape::History);
        let spectrum = |omega| shape.centred_spectrum(omega, struck.duration).norm();
        let energy: f64 = FREQUENCIES
            .iter()
            .map(|f| 0.5 * (motion * struck.impulse.length() * spectrum(TAU * f)).powi(2))
            .sum();
        let [rigid, mass, speed] = ["impulse", "mass", "speed"].map(|name| field(&contact, name));
        let restitution = rigid / (mass * speed) - 1.0;
        let share = energy / (0.5 * mass * speed * speed);
        println!("{motion} kg^-1/2: {share:.3} of the energy of the approach");
        largest = largest.max(share);
        assert!(share <= (1.0 + restitution) * (3.0 - restitution), "{motion}: {share}, e = {restitution}");
        assert!(struck.impulse.length() <= rigid * (1.0 + 1e-12));
        // The motion keeps the impulse of rigid bodies.
        let body = ball_mass(&presets::CERAMIC.material(), SIZE);
        near(struck.velocity_change.length(), rigid / body);
    }
    // Modes of 16 kg^−½ would get ten times as much from the force of rigid bodies.
    assert!(largest > 0.5, "{largest}");
}

fn refused(status: i32, says: &str) {
    assert!(status < 0 && last_message().contains(says), "{status}: {}", last_message());
}

#[test]
fn nonsense_is_refused_with_a_message() {
    let wood = index_of("wood");
    let good = numbers(CENTRE + SIZE * DVec3::Y);
    write_numbers(&good);
    refused(strike_impact(SLOT, wood), "no object in slot 3");
    load(&ball("ceramic", 0.5));
    write_numbers(&good);
    assert_eq!(strike_impact(SLOT, wood), 2);
    let before = with_impact(|rows, contact| (rows.to_vec(), contact.to_vec()));

    refused(strike_impact(SLOT + 1, wood), "no object in slot 4");
    refused(strike_impact(SLOT, 9999), "no material 9999");
    refused(strike_impact(SLOT, u32::MAX), "no material 4294967295");
    let hit = |at: usize, value: f64, says: &str| {
        let mut bad = good;
        bad[at] = value;
        write_numbers(&bad);
        refused(strike_impact(SLOT, wood), says);
    };
    hit(6, CENTRE.y + 1.1 * SIZE, "off the surface");
    hit(6, CENTRE.y, "off the surface");
    for bad in [f64::NAN, f64::INFINITY, -1.0, 0.0] {
        hit(0, bad, "radius");
        hit(1, bad, "speed");
    }
    for at in 2..STRIKE_NUMBERS {
        for bad in [f64::NAN, f64::NEG_INFINITY, 1e300] {
            hit(at, bad, "");
        }
    }

    let file = ball("ceramic", 0.5);
    refused(strike_load(SLOT, write(b"garbage")), "cannot be read");
    refused(strike_load(SLOT, write(&[])), "cannot be read");
    refused(strike_load(SLOT, write(&file[..file.len() / 2])), "cannot be read");
    refused(strike_load(SLOT, u32::MAX), "cannot be read");
    refused(strike_load(SLOT, write(&ball("porridge", 0.5))), "porridge");
    // The object and the impact that were there are there.
    assert!(before == with_impact(|rows, contact| (rows.to_vec(), contact.to_vec())));
    write_numbers(&good);
    assert_eq!(strike_impact(SLOT, wood), 2);
    assert!(before == with_impact(|rows, contact| (rows.to_vec(), contact.to_vec())));
}
