//! `clangor strike --list`: a data set of labelled impacts.

use std::path::Path;

use clangor_pipeline::dataset::{Dataset, DatasetOptions, FileKind, Shard};
use serde_json::json;

use super::session::StageBars;
use crate::arguments::{DatasetFiles, Global, Strike};
use crate::console::{Console, counted};
use crate::failure::Failure;

/// Most warnings after a file.
const MOST_WARNINGS: usize = 20;

pub(super) fn run(list: &Path, options: &Strike, global: &Global, console: &Console) -> Result<(), Failure> {
    let settings = DatasetOptions {
        models: options.models.on(options.device.device),
        cache: global.cache.clone(),
        seed: global.seed,
    };
    let dataset = Dataset::open(list, settings)?;
    let part = options.dataset.shard;
    if options.dataset.bake_only {
        return bake(&dataset, part, console);
    }
    let Some(folder) = &options.output else {
        return Err(Failure::new("where should the data set go? add -o FOLDER"));
    };
    let shards = match part {
        Some(part) => vec![part],
        None => {
            let usual = Shard::usual_number(dataset.count());
            Shard::all(options.dataset.shards.unwrap_or(usual))?
        }
    };
    let kind = match options.dataset.files {
        DatasetFiles::Parquet => FileKind::Parquet,
        DatasetFiles::Wav => FileKind::Wav,
    };
    let (mut rows, mut kept, mut files) = (0, 0, Vec::new());
    for shard in shards {
        let bars = StageBars::new(console);
        let written = dataset.write(folder, shard, kind, &mut |progress| bars.show(progress))?;
        bars.clear();
        warn(&dataset, console);
        let remark = if written.kept { ", was there" } else { "" };
        let strikes = counted(written.rows as usize, "strike", "strikes");
        console.say(format_args!("{}: {strikes}{remark}", written.path.display()));
        rows += written.rows;
        kept += usize::from(written.kept);
        files.push(written.path.display().to_string());
    }
    console.json(&json!({ "files": files, "strikes": rows, "kept": kept }));
    Ok(())
}

/// Says what is wrong with the sound models that were just found or baked.
fn warn(dataset: &Dataset, console: &Console) {
    let remarks = dataset.take_remarks();
    remarks.iter().take(MOST_WARNINGS).for_each(|remark| console.warn(remark));
    if let Some(more @ 1..) = remarks.len().checked_sub(MOST_WARNINGS) {
        console.warn(format_args!("{} more on sound models", counted(more, "remark", "remarks")));
    }
}

/// Bakes the models of all bodies, or of a part of them.
fn bake(dataset: &Dataset, part: Option<Shard>, console: &Console) -> Result<(), Failure> {
    let part = part.map_or_else(|| Shard::new(1, 1), Ok)?;
    let bars = StageBars::new(console);
    let bodies = dataset.bake(part, &mut |progress| bars.show(progress))?;
    bars.clear();
    warn(dataset, console);
    let of = dataset.body_count();
    console.say(format_args!("sound models of {bodies} of {of} bodies and materials are in the cache"));
    console.json(&json!({ "bodies": bodies, "of": of }));
    Ok(())
}
