//! A picture of modes: the body bent by each, coloured by how far its surface moves outwards or inwards.
//!
//! The view is along one direction without perspective. Of what lies behind one another in a pixel the
//! nearest is drawn; nodal lines are where the colour is white.

use clangor_core::glam::{DVec2, DVec3};
use clangor_core::sound_model::modal::model::{ModalMode, ModalModel};

use crate::plots::picture::{Align, Canvas, Colour, Grid, TextStyle, WHITE};

/// Width of a picture in pixels.
pub const WIDTH: usize = 1280;
/// Height of a picture in pixels.
pub const HEIGHT: usize = 960;

/// Modes beside each other.
const COLUMNS: usize = 4;
/// Modes above each other.
const ROWS: usize = 3;
/// Height of the title \[pixels\].
const TITLE: usize = 60;
/// Space for the words under a mode \[pixels\].
const WORDS: usize = 40;
/// Points of a pixel's edge that are looked at, so that edges are smooth.
const SAMPLES: usize = 2;
/// Largest motion that is drawn, over the bounding radius.
const BENDING: f64 = 0.12;

/// What to draw.
#[derive(Clone, Debug, PartialEq)]
pub struct ModePlot {
    /// What the body is called.
    pub name: String,
    /// Number of the first mode, from 1.
    pub first: usize,
}

/// Why a picture cannot be drawn.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ModePlotError {
    /// No modes at all.
    #[error("no audible modes: {}", match first {
        Some(first) => format!("first at {:.2} kHz", first * 1e-3),
        None => "the model has none".into(),
    })]
    NoModes {
        /// The lowest mode \[Hz\], where it is known.
        first: Option<f64>,
    },
    /// A mode that is not there.
    #[error("there is no mode {asked}; the model has {count}")]
    NoSuchMode {
        /// Its number, from 1.
        asked: usize,
        /// How many there are.
        count: usize,
    },
}

/// The directions of the picture: to the right, upwards, and towards the viewer.
struct View {
    right: DVec3,
    up: DVec3,
    near: DVec3,
}

/// A point of the body in the picture.
#[derive(Clone, Copy)]
struct Seen {
    place: DVec2,
    depth: f64,
    /// Outward motion, from −1 to 1.
    outward: f64,
}

impl ModePlot {
    /// How many modes a picture shows at most.
    pub const MOST: usize = COLUMNS * ROWS;

    /// Draws modes of a model; `first_frequency` is where they begin if there are none.
    ///
    /// # Errors
    /// [`ModePlotError`].
    pub fn draw(
        &self,
        model: &ModalModel,
        first_frequency: Option<f64>,
        canvas: &mut dyn Canvas,
    ) -> Result<usize, ModePlotError> {
        let count = model.modes.len();
        if count == 0 {
            return Err(ModePlotError::NoModes { first: first_frequency });
        }
        if !(1..=count).contains(&self.first) {
            return Err(ModePlotError::NoSuchMode { asked: self.first, count });
        }
        let shown = &model.modes[self.first - 1..count.min(self.first - 1 + Self::MOST)];
        let title = format!(
            "Modes of {}: {} to {} of {count}, bounding radius {:.1} mm",
            self.name,
            self.first,
            self.first + shown.len() - 1,
            1e3 * model.radius
        );
        let middle = 0.5 * WIDTH as f64;
        canvas.text(DVec2::new(middle, 24.0), Align::Middle, TextStyle::Title, &title);
        let about = "red moves outwards while blue moves inwards; white stands still or slides";
        canvas.text(DVec2::new(middle, 48.0), Align::Middle, TextStyle::Label, about);
        let (width, height) = (WIDTH / COLUMNS, (HEIGHT - TITLE) / ROWS);
        let view = View::oblique();
        let normals = normals(model);
        for (k, mode) in shown.iter().enumerate() {
            let corner = DVec2::new((k % COLUMNS * width) as f64, (TITLE + k / COLUMNS * height) as f64);
            let size = [width, height - WORDS];
            let seen = seen(model, mode, &normals, &view, size);
            let grid = shaded(model, &seen, &view, size);
            canvas.grid(corner, DVec2::new(size[0] as f64, size[1] as f64), &grid);
            let words = match mode.mesh_error {
                error if error.is_nan() => format!("{}: {:.1} Hz", self.first + k, mode.frequency),
                error => format!("{}: {:.1} Hz, mesh {:.2} %", self.first + k, mode.frequency, 100.0 * error),
            };
            let below = corner + DVec2::new(0.5 * width as f64, (height - WORDS / 2) as f64);
            canvas.text(below, Align::Middle, TextStyle::Label, &words);
        }
        Ok(shown.len())
    }
}

impl View {
    /// From the front, a little from the right and from above.
    fn oblique() -> Self {
        let near = DVec3::new(0.45, 0.75, 1.0).normalize();
        let right = DVec3::Y.cross(near).normalize();
        View { right, up: near.cross(right), near }
    }
}

/// Outward unit normals at the nodes.
fn normals(model: &ModalModel) -> Vec<DVec3> {
    let quarters = model.surface.quarters();
    let mut normals = vec![DVec3::ZERO; quarters.vertices.len()];
    for triangle in &quarters.triangles {
        let [a, b, c] = triangle.map(|i| quarters.vertices[i as usize]);
        let area = (b - a).cross(c - a);
        triangle.iter().for_each(|i| normals[*i as usize] += area);
    }
    normals.iter().map(|n| n.try_normalize().unwrap_or(DVec3::ZERO)).collect()
}

/// Where each node is in a picture of these many points.
fn seen(model: &ModalModel, mode: &ModalMode, normals: &[DVec3], view: &View, size: [usize; 2]) -> Vec<Seen> {
    let largest = mode.shape.iter().map(|u| u.length()).fold(f64::MIN_POSITIVE, f64::max);
    let scale = 0.5 / (1.0 + BENDING) * size[0].min(size[1]) as f64 / model.radius;
    let middle = 0.5 * DVec2::new(size[0] as f64, size[1] as f64);
    model
        .surface
        .nodes
        .iter()
        .zip(&mode.shape)
        .zip(normals)
        .map(|((x, u), normal)| {
            let motion = *u / largest;
            let at = *x + BENDING * model.radius * motion;
            let place = middle + scale * DVec2::new(at.dot(view.right), -at.dot(view.up));
            Seen { place, depth: at.dot(view.near), outward: motion.dot(*normal) }
        })
        .collect()
}

/// The picture of the surface.
fn shaded(model: &ModalModel, seen: &[Seen], view: &View, size: [usize; 2]) -> Grid {
    let (columns, rows) = (size[0] * SAMPLES, size[1] * SAMPLES);
    let mut depths = vec![f64::NEG_INFINITY; columns * rows];
    let mut samples = vec![WHITE.map(f64::from); columns * rows];
    let quarters = model.surface.quarters();
    for triangle in &quarters.triangles {
        let corners = triangle.map(|i| seen[i as usize]);
        let [a, b, c] = corners.map(|s| s.place * SAMPLES as f64);
        let [x, y, z] = triangle.map(|i| quarters.vertices[i as usize]);
        let normal = (y - x).cross(z - x).normalize_or_zero();
        // The inside of a shell is seen too, where the near wall is bent away.
        let light = 0.6 + 0.4 * normal.dot(view.near).abs();
        let area = (b - a).perp_dot(c - a);
        if area == 0.0 {
            continue;
        }
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let range = |low: f64, high: f64, most: usize| {
            low.floor().clamp(0.0, most as f64) as usize..high.ceil().clamp(0.0, most as f64) as usize
        };
        for row in range(low.y, high.y, rows) {
            for column in range(low.x, high.x, columns) {
                let p = DVec2::new(column as f64 + 0.5, row as f64 + 0.5);
                let weights = [(b - p).perp_dot(c - p), (c - p).perp_dot(a - p), (a - p).perp_dot(b - p)]
                    .map(|w| w / area);
                if weights.iter().any(|w| *w < 0.0) {
                    continue;
                }
                let mix = |of: fn(&Seen) -> f64| (0..3).map(|k| weights[k] * of(&corners[k])).sum::<f64>();
                let depth = mix(|s| s.depth);
                let at = row * columns + column;
                if depth > depths[at] {
                    depths[at] = depth;
                    samples[at] = colour(mix(|s| s.outward)).map(|c| light * c);
                }
            }
        }
    }
    let pixel = |row: usize, column: usize| -> Colour {
        let mut sum = [0.0; 3];
        for (r, c) in (0..SAMPLES).flat_map(|r| (0..SAMPLES).map(move |c| (r, c))) {
            let sample = samples[(row * SAMPLES + r) * columns + column * SAMPLES + c];
            sum.iter_mut().zip(sample).for_each(|(s, x)| *s += x);
        }
        sum.map(|s| (s / (SAMPLES * SAMPLES) as f64).round() as u8)
    };
    let cells = (0..size[1]).flat_map(|row| (0..size[0]).map(move |column| (row, column)));
    Grid { columns: size[0], cells: cells.map(|(row, column)| pixel(row, column)).collect() }
}

/// From blue over white to red.
fn colour(outward: f64) -> [f64; 3] {
    let part = outward.clamp(-1.0, 1.0);
    let end = if part > 0.0 { [190.0, 30.0, 30.0] } else { [30.0, 70.0, 190.0] };
    let paper = [242.0; 3];
    std::array::from_fn(|k| paper[k] + part.abs() * (end[k] - paper[k]))
}
