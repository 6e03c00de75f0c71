//! \[PROXY\] Fig. 4: the pulse p_3 (translation along the shortest semi-axis) of ellipsoids along three edges
//! of the bank, as a picture and in numbers.
//!
//! `cargo run --release -p clangor-validation --bin proxy_figure_4 -- FILE.svg|FILE.png`
//!
//! From the bank that comes with the program, known to kA = 20: the pulse ψ is h = 0.25 A/c wide, 0.36 ms for
//! the paper's A = 0.5 m, whose h = 0.1 ms would need kA = 80. Heard at 3 A in the direction (1, 1, 1).

use clangor_bake::fitting::comparison::directions;
use clangor_bake::reference::{FieldSampler, synthesize};
use clangor_core::glam::{DVec2, DVec3};
use clangor_core::medium::Medium;
use clangor_core::reference::pan_representation::pulse::pulse_spectrum;
use clangor_core::sound_model::acceleration::field::AccelerationField;
use clangor_pipeline::formats::soundbank::default_bank;
use clangor_pipeline::plots::picture::{
    Align, BLACK, Canvas, Colour, GREY, Raster, Svg, TextStyle, rectangle,
};

/// h \[A/c\].
const PULSE: f64 = 0.25;
/// Time between samples \[A/c\], their number, and t − r/c of the first.
const STEP: f64 = 0.04;
const LENGTH: usize = 512;
const START: f64 = -2.0;
/// Samples drawn; the signal ends before.
const DRAWN: usize = 150;
/// Distance of the listener \[A\].
const DISTANCE: f64 = 3.0;
/// A \[m\].
const LONGEST: f64 = 0.5;
/// Along z.
const MOTION: usize = 2;
const STEPS: usize = 11;

/// B/A or C/A of the bank.
fn value(step: usize) -> f64 {
    0.05 + 0.095 * step as f64
}

/// The pulse at a point.
fn pulse_at(sampler: &FieldSampler, gains: &[f64], x: DVec3) -> Vec<f64> {
    synthesize(&sampler.spectra(x)[MOTION], gains, STEP, START)
}

/// L2 change from one set of pulses to the next, over the larger of the two.
fn change(from: &[Vec<f64>], to: &[Vec<f64>]) -> f64 {
    let (mut difference, mut sizes) = (0.0, [0.0, 0.0]);
    for (a, b) in from.iter().flatten().zip(to.iter().flatten()) {
        difference += (a - b) * (a - b);
        sizes[0] += a * a;
        sizes[1] += b * b;
    }
    f64::sqrt(difference / f64::max(sizes[0], sizes[1]))
}

/// Colour scale from blue to red.
fn colour(step: usize) -> Colour {
    let part = step as f64 / (STEPS - 1) as f64;
    [33.0 + 180.0 * part, 70.0 + 60.0 * (part * (1.0 - part) * 4.0), 190.0 - 160.0 * part].map(|c| c as u8)
}

/// A panel of the picture: its upper left corner and size in pixels, and the pressure at the top, over ρA and
/// 1.05.
struct Plot {
    corner: DVec2,
    extent: DVec2,
    largest: f64,
}

impl Plot {
    /// Vertical position of a pressure.
    fn height(&self, p: f64) -> f64 {
        self.corner.y + 0.5 * self.extent.y * (1.0 - p / (1.05 * self.largest))
    }

    /// Horizontal position of a sample.
    fn across(&self, sample: usize) -> f64 {
        self.corner.x + self.extent.x * sample as f64 / (DRAWN - 1) as f64
    }

    /// Draws the colours of three values of the semi-axis that varies.
    fn legend(&self, varied: &str, canvas: &mut dyn Canvas) {
        for (step, part) in [(0, 0.0), (STEPS / 2, 0.09), (STEPS - 1, 0.18)] {
            let place = self.corner + DVec2::new(self.extent.x - 12.0, 16.0 + part * 200.0);
            let text = format!("{varied} = {:.4} m", LONGEST * value(step));
            canvas.text(place, Align::Right, TextStyle::Label, &text);
            canvas.line(&[place + DVec2::new(3.0, 0.0), place + DVec2::new(9.0, 0.0)], 3.0, colour(step));
        }
    }

    /// Draws the ticks of pressure and time and their names.
    fn axes(&self, canvas: &mut dyn Canvas) {
        // ρ A for A = 0.5 m and 1 m/s² at the peak of the pulse's samples.
        let pascals = Medium::AIR.density * LONGEST;
        let milliseconds = 1e3 * LONGEST / Medium::AIR.sound_speed;
        for part in [-1.0, 0.0, 1.0] {
            let place = DVec2::new(self.corner.x - 6.0, self.height(part * self.largest));
            let text =
                if part == 0.0 { "0".into() } else { format!("{:.0}", 1e3 * pascals * part * self.largest) };
            canvas.text(place, Align::Right, TextStyle::Label, &text);
        }
        canvas.text(self.corner + DVec2::new(-8.0, -22.0), Align::Right, TextStyle::Label, "p [mPa]");
        for time in [-2, 0, 2, 4] {
            let sample = ((f64::from(time) / milliseconds - START) / STEP).round();
            if (0.0..DRAWN as f64).contains(&sample) {
                let place = DVec2::new(self.across(sample as usize), self.corner.y + self.extent.y);
                canvas.line(&[place, place + DVec2::new(0.0, 4.0)], 1.0, BLACK);
                canvas.text(
                    place + DVec2::new(0.0, 14.0),
                    Align::Middle,
                    TextStyle::Label,
                    &time.to_string(),
                );
            }
        }
        let below = self.corner + DVec2::new(0.5 * self.extent.x, self.extent.y + 38.0);
        canvas.text(below, Align::Middle, TextStyle::Label, "t - r/c [ms]");
    }
}

fn main() {
    let path = std::env::args().skip(1).find(|a| !a.starts_with('-')).unwrap_or("proxy_figure_4.svg".into());
    let size = DVec2::new(1280.0, 470.0);
    let mut canvas: Box<dyn Canvas> = if path.ends_with("png") {
        Box::new(Raster::new(size.x as usize, size.y as usize))
    } else {
        Box::new(Svg::new(size.x as usize, size.y as usize))
    };
    let bank = default_bank().expect("the bank of the program");
    // Fields of the bank, pulse spectrum and listener.
    let field = |b: f64, c: f64| -> &AccelerationField {
        let near = bank.bank().entries().iter().find(|e| (e.b - b).abs() + (e.c - c).abs() < 1e-6);
        &near.expect("an ellipsoid of the bank").field
    };
    let spacing = std::f64::consts::TAU / (LENGTH as f64 * STEP);
    let wavenumbers: Vec<f64> = (0..=LENGTH / 2).map(|m| m as f64 * spacing).collect();
    let gains: Vec<f64> = wavenumbers.iter().map(|k| pulse_spectrum(*k, PULSE)).collect();
    let listener = DVec3::splat(DISTANCE / 3.0_f64.sqrt());

    type Family = (&'static str, &'static str, fn(f64) -> (f64, f64));
    let families: [Family; 3] = [
        ("(a) A = B = 0.5 m", "C", |v| (1.0, v)),
        ("(b) A = 0.5 m, C = 0.025 m", "B", |v| (v, 0.05)),
        ("(c) A = 0.5 m, B = C", "B = C", |v| (v, v)),
    ];
    canvas.text(
        DVec2::new(0.5 * size.x, 22.0),
        Align::Middle,
        TextStyle::Title,
        "p_3 of ellipsoids of the bank, 3 A away along (1, 1, 1), h = 0.25 A/c",
    );
    // One panel per family of ellipsoids.
    for (panel, (title, varied, member)) in families.into_iter().enumerate() {
        let (corner, extent) = (DVec2::new(75.0 + 410.0 * panel as f64, 78.0), DVec2::new(310.0, 320.0));
        let mut heard: Vec<Vec<f64>> = Vec::new();
        let mut all: Vec<Vec<Vec<f64>>> = Vec::new();
        for step in 0..STEPS {
            let (b, c) = member(value(step));
            let sampler = FieldSampler::new(field(b, c), &wavenumbers);
            heard.push(pulse_at(&sampler, &gains, listener));
            all.push(directions(16).map(|d| pulse_at(&sampler, &gains, d * DISTANCE)).collect());
        }
        // Change between neighbours.
        let changes: Vec<f64> = all.windows(2).map(|pair| change(&pair[0], &pair[1])).collect();
        let listed: Vec<String> = changes.iter().map(|c| format!("{:.1}", 100.0 * c)).collect();
        println!(
            "{title}, {varied} from 0.025 m to 0.5 m: change from one to the next over the larger [%]: {}",
            listed.join(" ")
        );

        // Draw the pulses, legend and axes.
        let largest = heard.iter().flatten().fold(0.0_f64, |m, p| m.max(p.abs()));
        let plot = Plot { corner, extent, largest };
        canvas.line(
            &[DVec2::new(corner.x, plot.height(0.0)), DVec2::new(corner.x + extent.x, plot.height(0.0))],
            1.0,
            GREY,
        );
        for (step, pulse) in heard.iter().enumerate() {
            let points: Vec<DVec2> = pulse[..DRAWN]
                .iter()
                .enumerate()
                .map(|(i, p)| DVec2::new(plot.across(i), plot.height(*p)))
                .collect();
            canvas.line(&points, 1.3, colour(step));
        }
        canvas.line(&rectangle(corner, extent), 1.0, BLACK);
        canvas.text(corner + DVec2::new(0.5 * extent.x, -22.0), Align::Middle, TextStyle::Label, title);
        plot.legend(varied, &mut *canvas);
        plot.axes(&mut *canvas);
    }
    std::fs::write(&path, canvas.encode().expect("a picture")).expect("a file that can be written");
    println!("{path}");
}
