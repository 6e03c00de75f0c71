//! What a rendering tells: files with their levels, what was not heard, and each body's share.

use std::collections::{BTreeMap, BTreeSet};

use clangor_core::body::{Body, BodyId, Motion, Surface};
use clangor_core::scene::render_description::GroundSound;
use clangor_core::sound_model::modal::model::ModalModel;
use clangor_core::synthesis::source_rule::SourceKind;
use clangor_core::synthesis::{AccelerationPart, BodyModes, NoModes, SoundPart};
use clangor_pipeline::analysis::levels::db_spl;
use clangor_pipeline::stages::render::{ModalStateTransfer, RenderOptions, RenderSummary, RenderedFile};
use clangor_pipeline::stages::sound_models::SoundModels;
use clangor_pipeline::stages::sound_models::modal_plan::MOST_FORMS;
use clangor_sim::SimulationReport;
use serde_json::json;

use crate::console::{Console, counted, four_digits};

/// What a rendering did.
#[derive(Clone, Copy)]
pub(super) struct RenderReportView<'a> {
    pub(super) bodies: &'a [Body],
    pub(super) models: &'a SoundModels,
    pub(super) summary: &'a RenderSummary,
    pub(super) options: &'a RenderOptions,
    pub(super) simulated: Option<&'a SimulationReport>,
}

impl RenderReportView<'_> {
    /// One line per file, and what was left out.
    pub(super) fn say(&self, console: &Console) {
        let RenderReportView { bodies, summary, options, .. } = *self;
        if options.compressor.is_some() {
            console.say(
                "dynamics were compressed: the levels below are those of the file, no longer sound pressure",
            );
        }
        for file in &summary.files {
            let (peak, rms) = loudest(file);
            console.say(format_args!(
                "{}: peak {} Pa ({} dB SPL), RMS {} Pa ({} dB SPL), {} LUFS, full scale {} Pa",
                file.path.display(),
                four_digits(peak),
                decibels(peak),
                four_digits(rms),
                decibels(rms),
                file.levels.loudness.map_or("n/a".into(), |l| format!("{l:.1}")),
                four_digits(file.full_scale),
            ));
            if peak > file.full_scale && file.clipped_samples == 0 && file.stem.is_none() {
                console.say("  samples exceed ±1: a player clips them; for listening, use --normalize -1");
            }
            if file.clipped_samples > 0 {
                console.warn(format_args!(
                    "{}: {} full scale and clipped; raise --full-scale or use --bits 32f",
                    file.path.display(),
                    counted(file.clipped_samples as usize, "sample was above", "samples were above")
                ));
            }
            if peak == 0.0 && file.stem.is_none() {
                console.warn(format_args!("{} is silent; --explain says why", file.path.display()));
            }
        }
        for (report, file) in summary.listeners.iter().zip(summary.files.iter().filter(|f| f.stem.is_none()))
        {
            if let Some((_, body, time)) = report.first_inside {
                console.warn(format_args!(
                    "listener \"{}\" was inside a body, or the sphere that stands for it, at {} left out, \
                     the first of \"{}\" at {time:.4} s; move the listener away",
                    file.listener,
                    counted(report.receiver_inside as usize, "click, which was", "clicks, which were"),
                    bodies[body.index()].name
                ));
            }
            if report.below_floor > 0 {
                console.warn(format_args!(
                    "{} left out, as the centre of the body was below the rigid floor; lower `floor_height`",
                    counted(report.below_floor as usize, "click was", "clicks were")
                ));
            }
        }
        self.say_sources(console);
        self.say_modes(console);
        self.say_missing(console);
    }

    /// How many bodies that sound are what.
    fn say_sources(&self, console: &Console) {
        let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
        for (index, model) in self.models.bodies.iter().enumerate() {
            let is_mesh = matches!(*self.bodies[index].surface, Surface::Mesh(_));
            if energy(self.summary, index) > 0.0 && is_mesh {
                *counts
                    .entry(match model.acceleration.kind {
                        SourceKind::Own => "with fields of their own",
                        SourceKind::Proxy(_) => "as ellipsoids",
                        SourceKind::Sphere => "as spheres of equal volume",
                    })
                    .or_default() += 1;
            }
        }
        if !counts.is_empty() {
            let list: Vec<String> = counts.iter().map(|(what, count)| format!("{count} {what}")).collect();
            console.say(format_args!("bodies that are no spheres click: {}", list.join(", ")));
        }
    }

    /// What rings, and what finding its modes took.
    fn say_modes(&self, console: &Console) {
        let RenderReportView { bodies, models, summary, .. } = *self;
        for found in models.obtained.iter().filter(|found| found.part == SoundPart::Modal) {
            let BodyModes::Own(model) = &models.bodies[found.body.index()].modal else { continue };
            console.say(format_args!(
                "\"{}\"{} rings with {}{}, {}",
                bodies[found.body.index()].name,
                match found.bodies {
                    1 => String::new(),
                    more => format!(" and {} like it", more - 1),
                },
                counted(model.known_modes().len(), "mode", "modes"),
                statistically(model),
                match found.cached {
                    true => "from the cache".into(),
                    false => format!("baked in {:.1} s", found.time.as_secs_f64()),
                },
            ));
        }
        let modes = || models.bodies.iter().map(|model| &model.modal);
        let proxies: Vec<usize> = modes().filter_map(BodyModes::proxy).map(|p| p.entry()).collect();
        if !proxies.is_empty() {
            let count: usize = modes().filter_map(BodyModes::proxy).map(|p| p.mode_count()).sum();
            let different: BTreeSet<usize> = proxies.iter().copied().collect();
            console.say(format_args!(
                "{} with {} of {} of the bank",
                counted(proxies.len(), "piece rings", "pieces ring"),
                counted(count, "mode", "modes"),
                counted(different.len(), "ellipsoid", "ellipsoids"),
            ));
        }
        let above = modes().filter(|m| matches!(m, BodyModes::None(NoModes::AboveBand { .. }))).count();
        let many = modes().filter(|m| matches!(m, BodyModes::None(NoModes::TooManyForms { .. }))).count();
        if above > 0 {
            console.say(format_args!(
                "{} no audible modes; --explain says where they begin",
                counted(above, "body has", "bodies have")
            ));
        }
        if many > 0 {
            console.say(format_args!(
                "{}; ask for them with modal = true",
                match many {
                    1 => format!("1 body of more than {MOST_FORMS} different forms does not ring"),
                    many => format!("{many} bodies of more than {MOST_FORMS} different forms do not ring"),
                }
            ));
        }
        self.say_solves(console);
        if !summary.handovers.is_empty() {
            let sum = |of: fn(&ModalStateTransfer) -> f64| summary.handovers.values().map(of).sum::<f64>();
            console.say(format_args!(
                "{} into pieces that ring on, with {:.0} % of the energy of the vibration",
                counted(summary.handovers.len(), "body breaks", "bodies break"),
                100.0 * sum(|h| h.handed) / sum(|h| h.had),
            ));
        }
        let ground = total(&summary.ground_energies);
        let (clicks, ringing) = (total(&summary.energies), total(&summary.modal_energies));
        if clicks > 0.0 && ground > 0.0 {
            console
                .say(format_args!("the ground has {:.1} dB of the clicks", 10.0 * (ground / clicks).log10()));
        }
        if clicks > 0.0 && ringing > 0.0 {
            console
                .say(format_args!("ringing has {:.1} dB of the clicks", 10.0 * (ringing / clicks).log10()));
        }
    }

    /// Impacts whose contact was solved, and what scaling to the recorded impulses costs.
    fn say_solves(&self, console: &Console) {
        let contacts = &self.summary.contacts;
        let solves = &contacts.solves;
        if solves.solved > 0 {
            let scaled = match solves.largest_scale {
                scale if scale > 0.0 => {
                    format!("; scaled to the recorded impulses by {:+.1} dB at most", 20.0 * scale.log10())
                }
                _ => String::new(),
            };
            console.say(format_args!(
                "{} with a solve of the contact ({} in closed form){scaled}",
                counted(solves.solved as usize, "impact", "impacts"),
                solves.closed
            ));
        }
        if solves.recorded > 0 {
            console.say(format_args!(
                "{} with the forces in the timeline",
                counted(solves.recorded as usize, "impact", "impacts")
            ));
        }
        if contacts.beyond_hertz > 0 {
            console.say(format_args!(
                "{} out of the range of Hertz's theory (flat, close-fitting or deep contacts), whose radii \
                 are bounded by the size of the bodies",
                counted(contacts.beyond_hertz as usize, "impact", "impacts"),
            ));
        }
        if solves.over_scaled > 0 {
            console.warn(format_args!(
                "the recorded impulses of {} are over twice those of the solve: bodies get twice the solved \
                 force (+6 dB), and the rest slowly",
                counted(solves.over_scaled as usize, "impact", "impacts"),
            ));
        }
        if solves.fallen_back > 0 {
            console.warn(format_args!(
                "the contact of {} could not be solved; the force is Hertz's, and what it gives the modes is \
                 bounded by the energy of the approach",
                counted(solves.fallen_back as usize, "impact", "impacts"),
            ));
        }
    }

    /// Fields that end below the band that is rendered, once.
    fn say_missing(&self, console: &Console) {
        let ends = self.summary.listeners.iter().flat_map(|report| &report.band_ends);
        let Some((body, end)) = ends.min_by(|a, b| a.1.total_cmp(b.1)) else { return };
        let lacking: f64 = self.summary.missing_energies.values().sum();
        let all: f64 = self.summary.energies.values().sum();
        console.warn(format_args!(
            "the field of \"{}\" ends at {end:.0} Hz, below the band of the file; what is missing is about \
         {:.1e} of the energy of all",
            self.bodies[body.index()].name,
            lacking / (all + lacking)
        ));
    }

    /// A table of bodies: share of the energy, impacts, and why a body is silent.
    ///
    /// A simulation does not pass on what is slower than v_min: it is counted in `simulated`.
    pub(super) fn explain(&self, console: &Console) {
        let RenderReportView { bodies, summary, simulated, models, .. } = *self;
        let contacts = &summary.contacts;
        let dropped = simulated.map_or(0, |report| report.dropped_impacts);
        console.say(format_args!(
            "impacts: {} sound, {} slower than v_min, {} without normal impulse, {} between bodies that \
         cannot move",
            contacts.pulses,
            contacts.slow + dropped,
            contacts.without_impulse,
            contacts.immovable
        ));
        console.say(format_args!(
            "{:24} {:12} {:>10} {:>8} {:>8} {:>8}  remark",
            "body", "part", "dB of all", "clicks", "too slow", "τc/L"
        ));
        let parts = [&summary.energies, &summary.modal_energies, &summary.ground_energies];
        let total: f64 = parts.into_iter().map(total).sum();
        let share = |energy: f64| match energy > 0.0 {
            true => format!("{:.1}", 10.0 * (energy / total).log10()),
            false => "−∞".into(),
        };
        for (index, body) in bodies.iter().enumerate() {
            let ground = summary.ground_energies.get(&BodyId(index as u32)).copied();
            let energy = ground.unwrap_or_else(|| energy(summary, index));
            let counts = contacts.bodies.get(index).copied().unwrap_or_default();
            let slow = counts.slow + dropped_of(simulated, index);
            let transit = counts.smallest_transit_ratio;
            console.say(format_args!(
                "{:24} {:12} {:>10} {:>8} {:>8} {:>8}  {}",
                body.name,
                if ground.is_some() { "ground" } else { "acceleration" },
                share(energy),
                counts.pulses,
                slow,
                if transit.is_finite() { format!("{transit:.2}") } else { "–".into() },
                self.remark(energy, slow, index)
            ));
            let modes = &models.bodies[index].modal;
            if *modes != BodyModes::None(NoModes::Unstruck) && !body.surface.is_plane() {
                console.say(format_args!(
                    "{:24} {:12} {:>10} {:>8} {:>8} {:>8}  {modes}",
                    "",
                    "modal",
                    share(modal_energy(summary, index)),
                    "",
                    "",
                    "",
                ));
            }
        }
    }

    /// Why a body is silent, or what to know about its sound.
    fn remark(&self, energy: f64, slow: u64, index: usize) -> String {
        let RenderReportView { bodies, summary, models, .. } = *self;
        let body = &bodies[index];
        let counts = summary.contacts.bodies.get(index).copied().unwrap_or_default();
        if body.surface.is_plane() && energy > 0.0 {
            match (&*body.surface, self.options.ground) {
                (Surface::Plate { thickness }, _) => format!("an endless plate of {} mm", 1e3 * thickness),
                (_, GroundSound::Slab) => "a slab of concrete".into(),
                _ => "a half-space of its material".into(),
            }
        } else if body.surface.is_plane() {
            "silent: it does not move".into()
        } else if !body.motion.is_movable() {
            let held = match body.motion {
                Motion::Fixed => "does not move as a whole",
                _ => "moves by keyframes, not by impacts",
            };
            match models.bodies[index].modal.mode_count() {
                0 => format!("silent: it {held}"),
                _ => format!("it {held}: it only vibrates"),
            }
        } else if energy > 0.0 {
            let AccelerationPart { decision, kind, .. } = &models.bodies[index].acceleration;
            let as_what = match kind == &decision.kind {
                _ if matches!(*body.surface, Surface::Sphere { .. }) => "exact".into(),
                true => format!("{decision}"),
                false => format!("{kind}: its field is not there"),
            };
            match counts.shorter_than_transit {
                0 => as_what,
                _ => format!(
                    "{as_what}; some impacts are shorter than a wave takes to cross it (τc/L < 1): an \
                     upper bound"
                ),
            }
        } else if counts.pulses > 0 && !self.options.parts.acceleration {
            "clicks are not rendered".into()
        } else if counts.pulses > 0 {
            "silent: its clicks fall outside the written time, or the listener was inside it".into()
        } else if slow > 0 {
            "silent: every touch was slower than v_min".into()
        } else {
            "silent: nothing touched it".into()
        }
    }

    /// The result as JSON.
    pub(super) fn print_json(&self, console: &Console) {
        let RenderReportView { bodies, models, summary, options, simulated } = *self;
        if !console.wants_json() {
            return;
        }
        let files: Vec<_> = summary
            .files
            .iter()
            .map(|file| {
                let (peak, rms) = loudest(file);
                json!({
                    "path": file.path.display().to_string(),
                    "listener": file.listener,
                    "stem": file.stem.map(|stem| bodies[stem.body.index()].name.clone()),
                    "part": file.stem.map(|stem| stem.part.to_string()),
                    "frames": file.levels.frames,
                    "full_scale_pa": file.full_scale,
                    "peak_pa": peak,
                    "rms_pa": rms,
                    "peak_db_spl": db_spl(peak),
                    "rms_db_spl": db_spl(rms),
                    "loudness_lufs": file.levels.loudness,
                    "clipped_samples": file.clipped_samples,
                })
            })
            .collect();
        let bodies: Vec<_> = bodies
            .iter()
            .enumerate()
            .map(|(index, body)| {
                let counts = summary.contacts.bodies.get(index).copied().unwrap_or_default();
                json!({
                    "name": body.name,
                    "acceleration_energy_pa2_s": energy(summary, index),
                    "modal_energy_pa2_s": modal_energy(summary, index),
                    "ground_energy_pa2_s": summary.ground_energies.get(&BodyId(index as u32)),
                    "modes": models.bodies[index].modal.mode_count(),
                    "modal": models.bodies[index].modal.to_string(),
                    "acceleration": models.bodies[index].acceleration.kind.to_string(),
                    "because": models.bodies[index].acceleration.decision.reason.to_string(),
                    "missing_energy_pa2_s": summary.missing_energies.get(&BodyId(index as u32)),
                    "clicks": counts.pulses,
                    "impacts_slower_than_v_min": counts.slow + dropped_of(simulated, index),
                })
            })
            .collect();
        let contacts = &summary.contacts;
        console.json(&json!({
            "files": files,
            "compressed": options.compressor.is_some(),
            "bodies": bodies,
            "impacts": {
                "sounding": contacts.pulses,
                "slower_than_v_min": contacts.slow,
                "without_impulse": contacts.without_impulse,
                "immovable": contacts.immovable,
                "delayed_in_chains": contacts.delayed,
                "solved": contacts.solves.solved,
                "recorded": contacts.solves.recorded,
                "closed_form": contacts.solves.closed,
                "not_solvable": contacts.solves.fallen_back,
                "solve_steps": contacts.solves.steps,
                "beyond_hertz": contacts.beyond_hertz,
            },
            "simulation": simulated.map(|report| json!({
                "simulated_s": report.time,
                "impacts": report.impacts,
                "dropped_impacts": report.dropped_impacts,
                "deepest_overlap_m": report.deepest_overlap,
            })),
        }));
    }
}

/// Impacts of a body that the simulation left out.
fn dropped_of(simulated: Option<&SimulationReport>, index: usize) -> u64 {
    simulated.and_then(|report| report.dropped_by_body.get(index).copied()).unwrap_or(0)
}

/// Largest peak and RMS of the channels [Pa].
fn loudest(file: &RenderedFile) -> (f64, f64) {
    let channels = &file.levels.channels;
    let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
    (largest(&mut channels.iter().map(|c| c.peak)), largest(&mut channels.iter().map(|c| c.rms)))
}

fn energy(summary: &RenderSummary, index: usize) -> f64 {
    summary.energies.get(&BodyId(index as u32)).copied().unwrap_or(0.0)
}

fn modal_energy(summary: &RenderSummary, index: usize) -> f64 {
    summary.modal_energies.get(&BodyId(index as u32)).copied().unwrap_or(0.0)
}

fn total(energies: &BTreeMap<BodyId, f64>) -> f64 {
    energies.values().sum()
}

/// From which frequency a body rings statistically.
fn statistically(model: &ModalModel) -> String {
    model.statistical_above.map_or(String::new(), |from| {
        let synthetic = model.modes.len() - model.known_modes().len();
        format!(
            " below {:.2} kHz, and statistically to {:.2} kHz with {}",
            1e-3 * from,
            1e-3 * model.max_frequency,
            counted(synthetic, "synthetic one", "synthetic ones")
        )
    })
}

fn decibels(pressure: f64) -> String {
    db_spl(pressure).map_or("−∞".into(), |db| format!("{db:.1}"))
}
