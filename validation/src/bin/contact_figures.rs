//! Forces of impacts between bodies that give way, beside Hertz's pulse of the same bodies without vibration.
//!
//! `cargo run --release -p clangor-validation --bin contact_figures -- FILE.svg|FILE.png` draws a ball on a
//! steel block, a ball on the rim of a plate, the rim of a wine glass on stone, and a steel ball on soil.

#[path = "../../../crates/clangor-bake/tests/baked_bodies/mod.rs"]
#[expect(dead_code, reason = "parts of it are for tests")]
mod baked_bodies;
#[path = "../../../crates/clangor-core/tests/compliant_bodies/mod.rs"]
#[expect(dead_code, reason = "parts of it are for tests")]
mod compliant_bodies;

use clangor_core::contact::compliant::{
    ContactLaw, ContactSystem, HertzLaw, Member, MemberContact, SolverMemory, StepSettings,
    half_space_radiation, hertz_duration, modal_tail, restitution_damping,
};
use clangor_core::contact::hertz_pulse;
use clangor_core::glam::{DVec2, DVec3};
use clangor_core::material::Material;
use clangor_core::material::presets::{CERAMIC, GLASS, GRANITE, SOIL, STEEL};
use clangor_pipeline::plots::picture::{Align, Canvas, Colour, Raster, Svg, TextStyle};
use clangor_validation::panel::Panel;

use baked_bodies::{BakedBody, Place, steel, stiffness};
use compliant_bodies::{ball, contact, hertz};

/// Restitution of hard surfaces themselves.
const HARD: f64 = 0.98;
const SPEED: f64 = 1.0;
const SOLVED: Colour = [200, 40, 30];
const HERTZ: Colour = [30, 70, 190];
/// Samples of a curve.
const POINTS: usize = 600;

/// An impact along its normal.
struct Case {
    title: &'static str,
    members: Vec<Member>,
    hit: MemberContact,
    law: HertzLaw,
    /// 1/m of the bodies without vibration [1/kg].
    inverse_mass: f64,
    restitution: f64,
}

/// Appends the tail of a body at its contact.
fn add_tail(case: &mut Case, member: usize, side: usize, highest: f64) {
    let duration = hertz_duration(case.inverse_mass, case.law.stiffness, SPEED);
    let body = &mut case.members[member];
    let shapes = &mut case.hit.shapes[side];
    let along = shapes.iter().map(|shape| shape.dot(case.hit.normal));
    let tail = modal_tail(body.poles.iter().map(|pole| pole.norm()).zip(along), highest, duration);
    body.poles.extend(&tail.poles);
    shapes.extend(tail.poles.iter().map(|_| tail.shape * case.hit.normal));
}

/// A steel ball of 5 mm that falls on a body.
fn ball_on(title: &'static str, body: &BakedBody, place: Place) -> Case {
    let radius = 0.005;
    let law = HertzLaw {
        restitution_damping: restitution_damping(HARD),
        ..hertz(stiffness(radius, [&steel(), &body.material]))
    };
    let striker = ball(radius, place.point + radius * place.normal, -SPEED * place.normal);
    let mut hit = contact([Some(0), Some(1)], place.point, place.normal, law);
    hit.shapes[1] = body.shapes(place);
    let inverse_mass = striker.inverse_mass + body.inverse_mass(place, place.normal);
    let members = vec![striker, body.member.clone()];
    let mut case = Case { title, members, hit, law, inverse_mass, restitution: HARD };
    add_tail(&mut case, 1, 1, body.highest);
    case
}

fn radiation(material: &Material) -> f64 {
    half_space_radiation(material.youngs_modulus, material.poisson_ratio, material.density)
}

fn cases() -> [Case; 4] {
    let level = |place: &Place| place.point.with_y(0.0).length();
    let block = BakedBody::new("box:0.1x0.05x0.08", &STEEL, 20e3);
    let off_middle = block.top(|place| {
        10.0 * place.normal.y - (place.point - DVec3::new(0.02, 0.0, 0.01)).with_y(0.0).length()
    });
    let plate = BakedBody::new("plate", &CERAMIC, 20e3);
    // As a ball meets it that falls along the axis.
    let mut rim = plate.top(|place| if place.normal.y > 0.9 { level(place) } else { 0.0 });
    rim.normal = DVec3::Y;
    // The rim of a glass falls sideways on stone, with a lip of 1 mm radius.
    let glass = BakedBody::new("wineglass", &GLASS, 20e3);
    let top = glass.top(|place| place.point.y).point.y;
    let mut lip = glass.top(|place| if place.point.y > top - 0.004 { level(place) } else { 0.0 });
    lip.normal = lip.point.with_y(0.0).normalize();
    let granite = GRANITE.material();
    let law = HertzLaw {
        restitution_damping: restitution_damping(HARD),
        radiation: radiation(&granite),
        ..hertz(stiffness(0.001, [&granite, &glass.material]))
    };
    let mut hit = contact([Some(0), None], lip.point, -lip.normal, law);
    hit.shapes[0] = glass.shapes(lip);
    let members = vec![Member { velocity: SPEED * lip.normal, ..glass.member.clone() }];
    let inverse_mass = glass.inverse_mass(lip, lip.normal);
    let title = "rim of a wine glass on granite, 1 m/s";
    let mut on_stone = Case { title, members, hit, law, inverse_mass, restitution: HARD };
    add_tail(&mut on_stone, 0, 0, glass.highest);
    // Soft ground: no vibration, but losses of the soil itself and its waves.
    let (soil, radius) = (SOIL.material(), 0.06);
    let law = HertzLaw {
        restitution_damping: restitution_damping(soil.restitution),
        radiation: radiation(&soil),
        ..hertz(stiffness(radius, [&steel(), &soil]))
    };
    let striker = ball(radius, radius * DVec3::Y, -SPEED * DVec3::Y);
    let on_soil = Case {
        title: "steel ball, radius 60 mm, on soil, 1 m/s",
        inverse_mass: striker.inverse_mass,
        members: vec![striker],
        hit: contact([Some(0), None], DVec3::ZERO, DVec3::Y, law),
        law,
        restitution: soil.restitution,
    };
    [
        ball_on("steel ball, radius 5 mm, on a steel block, 1 m/s", &block, off_middle),
        ball_on("the same on the rim of a dinner plate", &plate, rim),
        on_stone,
        on_soil,
    ]
}

/// Solves an impact and draws its force and Hertz's pulse in one panel.
fn draw(case: &Case, corner: DVec2, canvas: &mut dyn Canvas) {
    let Case { title, members, hit, law, inverse_mass, restitution } = case;
    let mut hit = hit.clone();
    hit.law = ContactLaw::Hertz(*law);
    let system = ContactSystem::new(members, &[hit]).expect("a sound impact");
    let mut memory = SolverMemory::default();
    let settings = StepSettings { steps_per_duration: 64.0, ..StepSettings::default() };
    let solution = system.solve(&settings, &mut memory).expect("a solution");
    let force = |time: f64| {
        let step = (time / solution.step) as usize;
        if step < solution.steps { solution.force(step, 0)[0] } else { 0.0 }
    };
    let last = (0..solution.steps).rposition(|n| solution.force(n, 0)[0] > 0.0).unwrap_or(0);
    let end = (last + 1) as f64 * solution.step;
    let tau = hertz_duration(*inverse_mass, law.stiffness, SPEED);
    let pulse = |time: f64| (1.0 + restitution) * SPEED / inverse_mass * hertz_pulse::value(time / tau) / tau;
    let impulse = solution.step * (0..solution.steps).map(|n| solution.force(n, 0)[0]).sum::<f64>();
    let bounce = impulse * inverse_mass / SPEED - 1.0;
    println!(
        "{title}: Hertz {:.3} ms with e {restitution:.2}, solved {:.3} ms in {} hits with e {bounce:.3}",
        1e3 * tau,
        1e3 * end,
        solution.hits[0]
    );
    // Axes: both curves whole.
    let whole = 1.08 * end.max(tau);
    let times = || (0..=POINTS).map(|k| whole * k as f64 / POINTS as f64);
    let greatest = times().map(|t| force(t).max(pulse(t))).fold(0.0, f64::max);
    let unit = 10_f64.powf(greatest.log10().floor());
    let tick = if greatest / unit < 3.0 { 0.5 * unit } else { 2.0 * unit };
    let panel = Panel {
        corner,
        extent: DVec2::new(480.0, 240.0),
        across: [0.0, 1e3 * whole],
        up: [0.0, 1.1 * greatest],
    };
    panel.frame(&format!("{title}: e {bounce:.2}"), canvas);
    for k in 0..=(1.1 * greatest / tick) as usize {
        panel.tick_left(k as f64 * tick, &format!("{}", k as f64 * tick), canvas);
    }
    let unit = 10_f64.powf((1e3 * whole).log10().floor());
    let tick = if 1e3 * whole / unit < 3.0 { 0.5 * unit } else { 2.0 * unit };
    let decimals = usize::try_from(-(tick.log10().floor() as i64)).unwrap_or(0);
    for k in 0..=(1e3 * whole / tick) as usize {
        panel.tick_below(k as f64 * tick, &format!("{:.decimals$}", k as f64 * tick), canvas);
    }
    let curve = |of: &dyn Fn(f64) -> f64| -> Vec<DVec2> {
        times().map(|t| panel.place(1e3 * t, of(t).max(0.0))).collect()
    };
    canvas.line(&curve(&pulse), 1.5, HERTZ);
    canvas.line(&curve(&force), 1.8, SOLVED);
    let below = corner + DVec2::new(240.0, 278.0);
    canvas.text(below, Align::Middle, TextStyle::Label, "time [ms]");
}

const WIDTH: usize = 1160;
const HEIGHT: usize = 760;

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [path] = &words[..] else {
        println!("contact_figures -- FILE.svg|FILE.png");
        return;
    };
    let mut svg = Svg::new(WIDTH, HEIGHT);
    let mut raster = Raster::new(WIDTH, HEIGHT);
    let canvas: &mut dyn Canvas = if path.ends_with(".png") { &mut raster } else { &mut svg };
    let title = "Force [N] of solved impacts (red), and Hertz's pulse of the same bodies if rigid (blue)";
    canvas.text(DVec2::new(0.5 * WIDTH as f64, 24.0), Align::Middle, TextStyle::Title, title);
    for (k, case) in cases().iter().enumerate() {
        let corner = DVec2::new(70.0 + 570.0 * (k % 2) as f64, 80.0 + 350.0 * (k / 2) as f64);
        draw(case, corner, canvas);
    }
    std::fs::write(path, canvas.encode().expect("a picture")).expect("written");
}
