//! Which models of a rendering are drafts, what that costs, and how to have exact ones.

use std::path::Path;

use clangor_core::synthesis::SoundPart;
use clangor_pipeline::session::Session;
use clangor_pipeline::stages::sound_models::patience::cpu_time;
use clangor_pipeline::stages::sound_models::{ModelOptions, ObtainedModel, Quality};

use crate::console::Console;

/// Names in a list; more are counted.
const MOST_NAMES: usize = 4;

/// Says which models are drafts.
pub(super) fn say(session: &Session<'_>, console: &Console) {
    let Some(models) = session.models() else { return };
    let name = |model: &ObtainedModel| session.bodies()[model.body.index()].name.clone();
    let of = |part: SoundPart| -> Vec<String> {
        models.drafts().filter(|model| model.part == part).map(name).collect()
    };
    let (clicks, ringing) = (of(SoundPart::Acceleration), of(SoundPart::Modal));
    if clicks.is_empty() && ringing.is_empty() {
        return;
    }
    if !clicks.is_empty() {
        let names = listed(&clicks);
        console.say(format_args!(
            "drafts, third octaves within about 3 dB in the median: the clicks of {names}"
        ));
    }
    if !ringing.is_empty() {
        let names = listed(&ringing);
        console.say(format_args!("drafts, about a hundred modes in few elements: the ringing of {names}"));
    }
    let costs: Vec<f64> = models.drafts().filter_map(|model| model.draft_of).collect();
    let scene = session.scene().map(|loaded| loaded.path.as_path());
    let scene = scene.filter(|path| !path.as_os_str().is_empty());
    if let Some(advice) = advice(&costs, scene, session.model_options()) {
        console.say(advice);
    }
}

/// How to have the exact models of drafts with these costs [s], infinite for those that cannot be computed.
fn advice(costs: &[f64], scene: Option<&Path>, options: &ModelOptions) -> Option<String> {
    let seconds: f64 = costs.iter().filter(|cost| cost.is_finite()).sum();
    if seconds <= 0.0 {
        return None;
    }
    let patience = options.patience();
    let remedy = match scene {
        Some(path) => {
            format!("clangor bake {} computes them, and this command then finds them", path.display())
        }
        None if options.quality == Quality::Draft => {
            "--quality normal and enough --patience compute them".into()
        }
        // What is exact takes the patience at most.
        None => format!("--patience {:.0} computes them", (patience + seconds).ceil()),
    };
    Some(format!("exact models take about {} more of CPU time: {remedy}", cpu_time(seconds)))
}

/// The first names, and how many more there are.
fn listed(names: &[String]) -> String {
    let first: Vec<String> = names.iter().take(MOST_NAMES).map(|name| format!("\"{name}\"")).collect();
    match names.len().saturating_sub(MOST_NAMES) {
        0 => first.join(", "),
        more => format!("{} and {more} more", first.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_can_be_computed_is_advised() {
        let patient = ModelOptions { patience: Some(60.0), ..ModelOptions::default() };
        let draft = ModelOptions { quality: Quality::Draft, ..ModelOptions::default() };
        assert_eq!(advice(&[f64::INFINITY], None, &patient), None);
        assert_eq!(advice(&[f64::INFINITY], Some(Path::new("a.toml")), &patient), None);
        // Another model has taken the patience.
        let text = advice(&[f64::INFINITY, 50.0], None, &patient).unwrap();
        assert_eq!(text, "exact models take about 50 s more of CPU time: --patience 110 computes them");
        assert!(
            advice(&[2.0], None, &draft)
                .unwrap()
                .ends_with("--quality normal and enough --patience compute them")
        );
        assert!(advice(&[2.0], Some(Path::new("a.toml")), &patient).unwrap().contains("clangor bake a.toml"));
    }
}
