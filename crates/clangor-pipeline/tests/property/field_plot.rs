//! Pictures of a field: what is drawn is the field, and what cannot be drawn is told.

use std::path::Path;

use clangor_core::geometry::mass_properties::MassProperties;
use clangor_core::medium::Medium;
use clangor_core::sound_model::acceleration::field::{AccelerationField, Node, Term};
use clangor_core::sound_model::acceleration::model::AccelerationModel;
use clangor_core::sound_model::files::model_file::{ModelFile, Origin, Solid};
use clangor_pipeline::plots::field::{FieldPlot, HEIGHT, PlotError, WIDTH};
use clangor_pipeline::plots::picture::{Align, Canvas, Colour, Grid, PictureError, Raster, Svg, TextStyle};
use clangor_pipeline::stages::sound_models::{SoundFileError, read_model};
use num_complex::Complex64;

/// A rigid sphere, whose field is p ∝ x⁻² (1 + sx) e^{s − sx}/(s² + 2s + 2) cos θ: weights with the zeros of
/// the denominator, and nodes enough for the exponential.
fn sphere(radius: f64, max_wavenumber: f64) -> ModelFile {
    let count = 10;
    let positions: Vec<Complex64> =
        (0..count).map(|j| Complex64::new(0.0, max_wavenumber * (j as f64 + 0.5) / count as f64)).collect();
    let denominator = |s: Complex64| s * s + 2.0 * s + 2.0;
    let mut weights: Vec<Complex64> = positions
        .iter()
        .map(|s| {
            let others = positions.iter().flat_map(|t| [*t, t.conj()]).filter(|t| t != s);
            denominator(*s) / others.map(|t| (s - t) / max_wavenumber).product::<Complex64>()
        })
        .collect();
    let largest = weights.iter().map(|w| w.norm()).fold(0.0, f64::max);
    weights.iter_mut().for_each(|w| *w /= largest);
    let y = (0.75 / std::f64::consts::PI).sqrt();
    let q: Vec<Complex64> = positions.iter().map(|s| (1.0 + s) * s.exp() / denominator(*s) / y).collect();
    let terms = [(-1, 1), (0, 2), (1, 0)].map(|(m, degree)| Term { n: 1, m, degree }).to_vec();
    let field = AccelerationField {
        max_wavenumber,
        ring_time: 12.0,
        nodes: positions.iter().zip(&weights).map(|(s, w)| Node { s: *s, weight: *w }).collect(),
        real: terms.iter().flat_map(|_| q.iter().map(|q| q.re as f32)).collect(),
        imaginary: terms.iter().flat_map(|_| q.iter().map(|q| q.im as f32)).collect(),
        terms,
    };
    ModelFile {
        acceleration: AccelerationModel { radius, field, near: None },
        modal: None,
        solid: Solid { name: "ball".into(), mass: MassProperties::of_sphere(radius), surface: None },
        origin: Origin {
            program: "clangor".into(),
            inputs: "0".into(),
            asked_accuracy: 1e-3,
            method: "closed form".into(),
            unknowns: 1,
            solves: 10,
            held_out_error: 0.0,
            warnings: Vec::new(),
        },
    }
}

fn plot(degree: usize, frequency: f64) -> FieldPlot {
    FieldPlot { degree, frequency, medium: Medium::AIR }
}

/// Keeps what is drawn.
#[derive(Default)]
struct Recorder {
    lines: Vec<(Vec<clangor_core::glam::DVec2>, Colour)>,
    texts: Vec<String>,
    grids: Vec<Grid>,
}

impl Canvas for Recorder {
    fn line(&mut self, points: &[clangor_core::glam::DVec2], _width: f64, colour: Colour) {
        self.lines.push((points.to_vec(), colour));
    }

    fn text(&mut self, _place: clangor_core::glam::DVec2, _align: Align, _style: TextStyle, text: &str) {
        self.texts.push(text.into());
    }

    fn grid(&mut self, _corner: clangor_core::glam::DVec2, _size: clangor_core::glam::DVec2, grid: &Grid) {
        self.grids.push(grid.clone());
    }

    fn encode(&self) -> Result<Vec<u8>, PictureError> {
        Ok(Vec::new())
    }
}

#[test]
fn a_ball_is_a_dipole_along_its_motion() {
    let mut canvas = Recorder::default();
    plot(1, 9000.0).draw(&sphere(0.0075, 2.75), &mut canvas).unwrap();
    // A picture for eyes, beside what is checked.
    for (name, mut picture) in [
        ("ball.png", Box::new(Raster::new(WIDTH, HEIGHT)) as Box<dyn Canvas>),
        ("ball.svg", Box::new(Svg::new(WIDTH, HEIGHT))),
    ] {
        plot(1, 9000.0).draw(&sphere(0.0075, 2.75), picture.as_mut()).unwrap();
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
        std::fs::write(path, picture.encode().unwrap()).unwrap();
    }
    // Far-field curves of the x–y and x–z planes: up and down the loudest, nothing sideways.
    let far: Vec<_> = canvas.lines.iter().filter(|(p, c)| p.len() == 361 && *c == [31, 90, 180]).collect();
    assert_eq!(far.len(), 3);
    let size = |curve: usize| {
        let points = &far[curve].0;
        let middle = (points[0] + points[180]) * 0.5;
        (points.iter().map(|p| (p.x - middle.x).abs()).fold(0.0, f64::max), points[90].y - points[270].y)
    };
    let (_, height) = size(0);
    assert!((height.abs() - 300.0).abs() < 1.0, "{height}");
    assert!(size(2).0 < 1.0, "{:?}", size(2));
    // Above the ball the air is pushed, below it is thinned: mirror images with the other sign.
    assert_eq!(canvas.grids.len(), 4);
    let panel = &canvas.grids[0];
    let cell = |column: usize, row: usize| panel.cells[row * panel.columns + column];
    for column in 0..panel.columns {
        for row in 0..panel.rows() / 2 {
            let (above, below) = (cell(column, row), cell(column, panel.rows() - 1 - row));
            let reds = (above[0] >= above[2], below[0] >= below[2]);
            assert!(reds.0 != reds.1 || above == below || above.iter().all(|c| *c > 235), "{column} {row}");
        }
    }
    assert!(canvas.texts.iter().any(|t| t.contains("translation along y")));
    assert!(canvas.texts.iter().any(|t| t.contains("9000 Hz")));
}

#[test]
fn silence_and_frequencies_beyond_the_band_are_told() {
    let file = sphere(0.0075, 2.75);
    let highest = file.acceleration.max_frequency(Medium::AIR.sound_speed);
    let mut canvas = Recorder::default();
    assert!(matches!(plot(4, 9000.0).draw(&file, &mut canvas), Err(PlotError::Silent { .. })));
    assert!(matches!(plot(1, 1.1 * highest).draw(&file, &mut canvas), Err(PlotError::BeyondBand { .. })));
    assert!(matches!(plot(1, f64::NAN).draw(&file, &mut canvas), Err(PlotError::BeyondBand { .. })));
    assert!(plot(1, highest).draw(&file, &mut canvas).is_ok());
}

#[test]
fn models_are_read_from_their_files() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ball.safetensors");
    let file = sphere(0.0075, 2.75);
    let bytes = file.encode().unwrap();
    std::fs::write(&path, &bytes).unwrap();
    assert_eq!(read_model(&path).unwrap(), file);
    std::fs::write(&path, &bytes[..bytes.len() - 3]).unwrap();
    let error = read_model(&path).unwrap_err();
    assert!(error.to_string().contains("ball.safetensors"), "{error}");
    assert!(matches!(read_model(folder.path()), Err(SoundFileError::Read { .. })));
}
