//! Writes a scene of 100 bodies and their recorded motion as Parquet, to measure the import of long
//! recordings.
//!
//! Half of the bodies are balls, half are dice. Each stands on a floor, is thrown upwards every 20 to 40 s,
//! bounces with a restitution of 0.6, turning about the vertical, and rests. The flights are exact parabolas;
//! positions at rest have the noise of a solver, 1e-8 m.
//!
//! ```text
//! cargo run --release -p clangor-pipeline --example recorded_bodies -- FOLDER 3600
//! /usr/bin/time -v clangor import poses FOLDER/scene.toml FOLDER/poses.parquet -o FOLDER/run.timeline
//! ```

use std::error::Error;
use std::fmt::Write as _;
use std::fs::{self, File};
use std::path::Path;
use std::sync::Arc;

use parquet::basic::{Compression, ZstdLevel};
use parquet::data_type::{DoubleType, Int32Type};
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;

const BODIES: u32 = 100;
const RATE: f64 = 240.0;
/// Instants in a row group: about a million rows.
const GROUP: u64 = 10_000;
const G: f64 = 9.80665;
const THROWN: f64 = 2.0;
const RESTITUTION: f64 = 0.6;
/// Slowest landing that bounces [m/s].
const SLOWEST: f64 = 0.05;
/// Half the size of a body \[m\].
const HALF: f64 = 0.01;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let folder = arguments.next().ok_or("give a folder and a duration in seconds")?;
    let duration: f64 = arguments.next().unwrap_or_else(|| "360".into()).parse()?;
    let folder = Path::new(&folder);
    fs::create_dir_all(folder)?;
    fs::write(folder.join("scene.toml"), scene()?)?;
    write_poses(&folder.join("poses.parquet"), (duration * RATE) as u64)
}

fn scene() -> Result<String, std::fmt::Error> {
    let mut text = String::from("version = 1\n");
    for body in 0..BODIES {
        let shape = if is_ball(body) { "sphere:0.01" } else { "box:0.02x0.02x0.02" };
        let [x, z] = place(body);
        writeln!(
            text,
            "[[body]]\nname = \"b{body}\"\nshape = \"{shape}\"\nmaterial = \"steel\"\n\
             position = [{x:?}, {HALF:?}, {z:?}]"
        )?;
    }
    text += "[[plane]]\nname = \"floor\"\nmaterial = \"granite\"\n";
    text += "[[listener]]\nposition = [0.5, 1.0, 2.0]\n";
    Ok(text)
}

fn is_ball(body: u32) -> bool {
    body.is_multiple_of(2)
}

fn place(body: u32) -> [f64; 2] {
    [f64::from(body % 10) * 0.1, f64::from(body / 10) * 0.1]
}

/// Height of the centre \[m\] and angle about the vertical \[rad\] of a body.
fn motion(body: u32, time: f64) -> [f64; 2] {
    let (period, phase) = (20.0 + f64::from(body * 37 % 100) * 0.2, f64::from(body * 61 % 100) * 0.01);
    let throws = (time / period + phase).floor();
    let mut t = time - (throws - phase) * period;
    let mut speed = THROWN;
    let mut flown = throws * airborne();
    while speed > SLOWEST {
        let flight = 2.0 * speed / G;
        if t < flight {
            return [HALF + speed * t - 0.5 * G * t * t, 3.0 * (flown + t)];
        }
        (t, speed, flown) = (t - flight, speed * RESTITUTION, flown + flight);
    }
    [HALF + 1e-8 * noise(body, time), 3.0 * flown]
}

/// How long a body flies after it was thrown once \[s\].
fn airborne() -> f64 {
    let mut speed = THROWN;
    let mut flown = 0.0;
    while speed > SLOWEST {
        (speed, flown) = (speed * RESTITUTION, flown + 2.0 * speed / G);
    }
    flown
}

/// A number between -1 and 1 that looks random.
fn noise(body: u32, time: f64) -> f64 {
    let mut bits = (time * RATE).round() as u64 ^ (u64::from(body) << 40);
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    bits = (bits ^ (bits >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    (bits >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

fn write_poses(path: &Path, instants: u64) -> Result<(), Box<dyn Error>> {
    let names = [
        "position_x",
        "position_y",
        "position_z",
        "orientation_x",
        "orientation_y",
        "orientation_z",
        "orientation_w",
    ];
    let doubles: String =
        names.iter().fold(String::new(), |text, name| text + "required double " + name + ";");
    let schema = Arc::new(parse_message_type(&format!(
        "message poses {{ required double t; required int32 body; {doubles} }}"
    ))?);
    let properties = WriterProperties::builder().set_compression(Compression::ZSTD(ZstdLevel::default()));
    let mut writer = SerializedFileWriter::new(File::create(path)?, schema, Arc::new(properties.build()))?;
    for first in (0..instants).step_by(GROUP as usize) {
        let rows: Vec<(u64, u32)> = (first..instants.min(first + GROUP))
            .flat_map(|instant| (0..BODIES).map(move |body| (instant, body)))
            .collect();
        let times: Vec<f64> = rows.iter().map(|(instant, _)| *instant as f64 / RATE).collect();
        let bodies: Vec<i32> = rows.iter().map(|(_, body)| body.cast_signed()).collect();
        let states: Vec<[f64; 7]> = rows
            .iter()
            .zip(&times)
            .map(|((_, body), time)| {
                let ([x, z], [height, angle]) = (place(*body), motion(*body, *time));
                [x, height, z, 0.0, (0.5 * angle).sin(), 0.0, (0.5 * angle).cos()]
            })
            .collect();
        let mut group = writer.next_row_group()?;
        for index in 0..9 {
            let Some(mut column) = group.next_column()? else { break };
            match index {
                0 => column.typed::<DoubleType>().write_batch(&times, None, None)?,
                1 => column.typed::<Int32Type>().write_batch(&bodies, None, None)?,
                _ => {
                    let values: Vec<f64> = states.iter().map(|state| state[index - 2]).collect();
                    column.typed::<DoubleType>().write_batch(&values, None, None)?
                }
            };
            column.close()?;
        }
        group.close()?;
    }
    writer.close()?;
    Ok(())
}
