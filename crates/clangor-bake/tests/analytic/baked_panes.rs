//! A ball on free panes with baked modes and their tail, against the bounce on all modes.

use crate::baked_bodies::{BakedBody, steel, stiffness};
use crate::compliant_bodies::{ball, contact, hertz};
use clangor_core::contact::compliant::{
    ContactSystem, SolverMemory, StepSettings, hertz_duration, modal_tail,
};
use clangor_core::material::presets::GLASS;
use glam::DVec3;

const RADIUS: f64 = 0.005;

/// Restitution of the ball at 1 m/s in the middle of a pane of a thickness \[m\], without and with the tail.
fn bounce(thickness: f64, highest: f64) -> [f64; 2] {
    let pane = BakedBody::new(&format!("box:0.25x{thickness}x0.25"), &GLASS, highest);
    let place = pane.top(|place| place.normal.y - 100.0 * place.point.with_y(0.0).length());
    let k = stiffness(RADIUS, [&steel(), &pane.material]);
    let striker = ball(RADIUS, place.point + RADIUS * DVec3::Y, -DVec3::Y);
    let duration = hertz_duration(striker.inverse_mass, k, 1.0);
    let shapes = pane.shapes(place);
    let along = pane.member.poles.iter().zip(&shapes).map(|(pole, shape)| (pole.norm(), shape.y));
    let tail = modal_tail(along, pane.highest, duration);
    println!("{thickness}: {} modes, {} in the tail, at {}", shapes.len(), tail.poles.len(), place.point);
    [false, true].map(|with_tail| {
        let mut target = pane.member.clone();
        let mut hit = contact([Some(0), Some(1)], place.point, DVec3::Y, hertz(k));
        hit.shapes[1] = shapes.clone();
        if with_tail {
            target.poles.extend(&tail.poles);
            hit.shapes[1].extend(tail.poles.iter().map(|_| tail.shape * DVec3::Y));
        }
        let system = ContactSystem::new(&[striker.clone(), target], &[hit]).unwrap();
        let settings = StepSettings { steps_per_duration: 64.0, ..StepSettings::default() };
        let mut memory = SolverMemory::default();
        let solution = system.solve(&settings, &mut memory).unwrap();
        solution.impulse(0).y * striker.inverse_mass - 1.0
    })
}

/// Restitution on a supported pane of 50 × 50 cm with all modes, of the shared note "compliant contact", and
/// on a pane of baked modes.
fn panes_bounce_as_with_all_modes(panes: &[(f64, f64)]) {
    for (thickness, known) in panes {
        let [cut, whole] = bounce(*thickness, 20e3);
        println!("{thickness}: {cut:.4} without, {whole:.4} with a tail, of {known}");
        assert!((whole - known).abs() < 0.02, "{thickness}: {whole}");
    }
}

#[test]
fn thick_panes_of_baked_modes_bounce_as_with_all_modes() {
    // Seen: 0.843; without a tail 0.850.
    panes_bounce_as_with_all_modes(&[(0.010, 0.855)]);
}

#[test]
#[ignore = "half a minute, for the modes"]
fn thin_panes_of_baked_modes_bounce_as_with_all_modes() {
    // Seen: 0.155, 0.367 and 0.636; without a tail 0.088, 0.336 and 0.637.
    panes_bounce_as_with_all_modes(&[(0.003, 0.171), (0.004, 0.383), (0.006, 0.652)]);
}
