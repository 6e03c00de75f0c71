//! Which models of a rendering are drafts, what that costs, and how to have exact ones.

use clangor_core::synthesis::SoundPart;
use clangor_pipeline::session::Session;
use clangor_pipeline::stages::sound_models::ObtainedModel;
use clangor_pipeline::stages::sound_models::patience::cpu_time;

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
    let seconds: f64 = models.drafts().filter_map(|model| model.draft_of).sum();
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
    let remedy = match session.scene() {
        Some(loaded) if !loaded.path.as_os_str().is_empty() => {
            format!("clangor bake {} computes them, and this command then finds them", loaded.path.display())
        }
        _ => "a higher --patience computes them".into(),
    };
    console.say(format_args!("exact models take about {} of CPU time: {remedy}", cpu_time(seconds)));
}

/// The first names, and how many more there are.
fn listed(names: &[String]) -> String {
    let first: Vec<String> = names.iter().take(MOST_NAMES).map(|name| format!("\"{name}\"")).collect();
    match names.len().saturating_sub(MOST_NAMES) {
        0 => first.join(", "),
        more => format!("{} and {more} more", first.join(", ")),
    }
}
