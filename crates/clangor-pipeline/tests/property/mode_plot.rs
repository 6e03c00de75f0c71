//! A picture of modes shows the motion that it is given: red where the surface moves outwards, blue where
//! inwards, white where it slides.

use clangor_core::glam::{DVec2, DVec3};
use clangor_core::medium::Medium;
use clangor_core::shape::{Form, Shape};
use clangor_core::sound_model::modal::model::{ModalMode, ModalModel};
use clangor_core::sound_model::modal::surface::ModalSurface;
use clangor_pipeline::plots::modes::{HEIGHT, ModePlot, ModePlotError, WIDTH};
use clangor_pipeline::plots::picture::{Align, Canvas, Colour, Grid, PictureError, Raster, TextStyle};

/// A ball of six-node triangles with these motions.
fn ball(motions: &[fn(DVec3) -> DVec3]) -> ModalModel {
    let mesh = Shape::try_new(Form::Sphere { radius: 1.0 }, Some(0.2)).unwrap().mesh();
    let mut nodes = mesh.vertices.clone();
    let mut middles = std::collections::BTreeMap::new();
    let triangles = mesh
        .triangles
        .iter()
        .map(|t| {
            let middle = [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]].map(|[a, b]| {
                *middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
                    nodes.push((0.5 * (nodes[a as usize] + nodes[b as usize])).normalize());
                    nodes.len() as u32 - 1
                })
            });
            [t[0], t[1], t[2], middle[0], middle[1], middle[2]]
        })
        .collect();
    let mode = |(k, motion): (usize, &fn(DVec3) -> DVec3)| ModalMode {
        frequency: 1000.0 * (k + 1) as f64,
        mesh_error: 0.004,
        support_damping: 0.0,
        shape: nodes.iter().map(|x| motion(*x)).collect(),
        transfer: None,
    };
    let modes = motions.iter().enumerate().map(mode).collect();
    let surface = ModalSurface { nodes: nodes.clone(), triangles };
    ModalModel {
        radius: 1.0,
        medium: Medium::AIR,
        density: 7850.0,
        max_frequency: 2e4,
        statistical_above: None,
        surface,
        modes,
    }
}

#[derive(Default)]
struct Recorder {
    texts: Vec<String>,
    grids: Vec<Grid>,
}

impl Canvas for Recorder {
    fn line(&mut self, _points: &[DVec2], _width: f64, _colour: Colour) {}

    fn text(&mut self, _place: DVec2, _align: Align, _style: TextStyle, text: &str) {
        self.texts.push(text.into());
    }

    fn grid(&mut self, _corner: DVec2, _size: DVec2, grid: &Grid) {
        self.grids.push(grid.clone());
    }

    fn encode(&self) -> Result<Vec<u8>, PictureError> {
        Ok(Vec::new())
    }
}

#[test]
fn colours_follow_the_outward_motion() {
    let model = ball(&[|x| x, |x| -x, |x| x.cross(DVec3::Y), |x| DVec3::new(0.0, x.y, 0.0)]);
    let plot = ModePlot { name: "ball".into(), first: 1 };
    let mut canvas = Recorder::default();
    assert_eq!(plot.draw(&model, None, &mut canvas), Ok(4));
    // The middle of a ball faces the viewer.
    let middle =
        canvas.grids.iter().map(|grid| grid.cells[grid.columns * (grid.rows() / 2) + grid.columns / 2]);
    let middle: Vec<Colour> = middle.collect();
    let [out, inwards, slide, _] = middle[..] else { panic!("{middle:?}") };
    assert!(out[0] > 150 && out[2] < 60, "{out:?}");
    assert!(inwards[2] > 150 && inwards[0] < 60, "{inwards:?}");
    assert!(slide.iter().all(|c| *c > 220), "{slide:?}");
    assert!(canvas.texts.iter().any(|t| t == "3: 3000.0 Hz, mesh 0.40 %"), "{:?}", canvas.texts);
    // A picture for eyes.
    let mut picture = Raster::new(WIDTH, HEIGHT);
    plot.draw(&model, None, &mut picture).unwrap();
    let path = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("modes.png");
    std::fs::write(path, picture.encode().unwrap()).unwrap();
}

#[test]
fn modes_that_are_not_there_are_told() {
    let model = ball(&[|x| x]);
    let draw = |first, model: &ModalModel, lowest| {
        ModePlot { name: "ball".into(), first }.draw(model, lowest, &mut Recorder::default())
    };
    assert_eq!(draw(0, &model, None), Err(ModePlotError::NoSuchMode { asked: 0, count: 1 }));
    assert_eq!(draw(2, &model, None), Err(ModePlotError::NoSuchMode { asked: 2, count: 1 }));
    let silent = ModalModel { modes: Vec::new(), ..model };
    let why = draw(1, &silent, Some(25_000.0)).unwrap_err().to_string();
    assert_eq!(why, "no audible modes: first at 25.00 kHz");
}
