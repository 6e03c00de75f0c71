//! A raw log of 17 million rows to disk and back: bytes a row, processor time each way, peak memory.
//!
//! `cargo bench -p clangor-pipeline --bench timeline -- [ROWS] [RUN.timeline]`
//!
//! With a timeline, its rows are repeated one after the other in time until there are enough; without, a rock
//! pile is imitated. Bars: 16 bytes a row, 10 s of processor time each way, memory independent of the number
//! of rows.

#[path = "../../clangor-bake/benches/cpu_time/mod.rs"]
mod cpu_time;
#[path = "timeline/pile.rs"]
mod pile;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clangor_core::timeline::{ContactRow, TimelineSink};
use clangor_pipeline::formats::timeline_file::{TimelineHeader, TimelineReader, TimelineWriter};
use cpu_time::cpu_time;

use pile::{Pile, header};

fn main() -> ExitCode {
    // `cargo bench` adds an option of its own.
    let mut words = std::env::args().skip(1).filter(|word| word != "--bench");
    let rows = words.next().map_or(Ok(17_000_000), |word| word.parse());
    let source = words.next().map(PathBuf::from);
    let Ok(rows) = rows else {
        eprintln!("the number of rows is no number");
        return ExitCode::from(2);
    };
    match run(rows, source.as_deref()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn run(rows: u64, source: Option<&Path>) -> Result<(), Box<dyn std::error::Error>> {
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("long.timeline");
    let source = source.map(TimelineReader::open).transpose()?;
    let header = source.as_ref().map_or_else(header, |s| s.header().clone());

    // What it costs to make the rows is not what it costs to write them.
    let start = cpu_time();
    feed(rows, source.as_ref(), &header, &mut |_| Ok(()))?;
    let making = cpu_time() - start;

    let start = cpu_time();
    let mut writer = TimelineWriter::create(&path, &header, false)?;
    feed(rows, source.as_ref(), &header, &mut |row| writer.contact(row))?;
    writer.finish()?;
    let writing = cpu_time() - start - making;
    let bytes = std::fs::metadata(path.join("contacts.parquet"))?.len();
    let memory_after_writing = peak_memory();

    let start = cpu_time();
    let mut impulse = 0.0;
    let mut read = 0;
    for row in TimelineReader::open(&path)?.contacts()? {
        impulse += row?.impulse_n;
        read += 1;
    }
    let reading = cpu_time() - start;
    println!("rows           {read} (sum of normal impulses {impulse:.6e} N s)");
    println!("bytes a row    {:.2}", bytes as f64 / rows as f64);
    println!("making them    {making:.2} s of processor time, not counted below");
    println!("write          {writing:.2} s of processor time");
    println!("read           {reading:.2} s of processor time");
    println!(
        "peak memory    {memory_after_writing:.0} MB after writing, {:.0} MB after reading",
        peak_memory()
    );
    Ok(())
}

/// Hands out `rows` rows: of the source, again and again, or of the imitated pile.
fn feed(
    rows: u64,
    source: Option<&TimelineReader>,
    header: &TimelineHeader,
    take: &mut dyn FnMut(&ContactRow) -> std::io::Result<()>,
) -> Result<(), Box<dyn std::error::Error>> {
    let Some(source) = source else {
        let mut pile = Pile::new(3);
        for _ in 0..rows {
            take(&pile.next_row())?;
        }
        return Ok(());
    };
    let mut left = rows;
    let mut round = 0_u32;
    while left > 0 {
        let before = left;
        for row in source.contacts()? {
            let mut row = row?;
            row.time += f64::from(round) * (header.origin.duration + 1e-3);
            if row.impact_id > 0 {
                row.impact_id += u64::from(round) << 32;
            }
            take(&row)?;
            left -= 1;
            if left == 0 {
                break;
            }
        }
        if left == before {
            return Err("the timeline has no contacts to repeat".into());
        }
        round += 1;
    }
    Ok(())
}

/// Largest resident memory so far [MB]; 0 where `/proc` is missing.
fn peak_memory() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:")).unwrap_or_default();
    line.trim().trim_end_matches("kB").trim().parse::<f64>().unwrap_or(0.0) / 1024.0
}
